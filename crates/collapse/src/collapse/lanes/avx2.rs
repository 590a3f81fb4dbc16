//! Lanes in the vectors of AVX2: the one file of the crate with `unsafe`.
//!
//! Plain arrays take 1.15 to 1.5 times as long. The code is sound for two reasons. [`Avx2Lanes`] is private to this file
//! and named by two functions alone, [`run_if_present`], after it has found AVX2, and `run_apart`, which only code that
//! the first one started can call: so every instruction here runs on a processor that has it. And every pointer is
//! into a slice whose length was compared with the largest index just before.
#![allow(unsafe_code)]

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

use super::eight::{EightIndices, EightLanes, Kernel, VertexQuadric};
use crate::collapse::rings::Vertex;

#[derive(Clone, Copy)]
struct Avx2Lanes(__m256);

/// Runs a kernel with these lanes; gives it back if the processor has no AVX2.
pub(super) fn run_if_present<K: Kernel>(kernel: K) -> Result<K::Output, K> {
    if !std::is_x86_feature_detected!("avx2") {
        return Err(kernel);
    }
    // SAFETY: AVX2 is present.
    Ok(unsafe { run_here(kernel) })
}

#[target_feature(enable = "avx2")]
fn run_here<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx2Lanes>()
}

#[inline(never)]
#[target_feature(enable = "avx2")]
fn run_out_of_line<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx2Lanes>()
}

macro_rules! implement {
    ($($operator:ident $name:ident $instruction:ident),*) => {$(
        impl $operator for Avx2Lanes {
            type Output = Avx2Lanes;

            #[inline(always)]
            fn $name(self, other: Avx2Lanes) -> Avx2Lanes {
                // SAFETY: AVX2 is present.
                Avx2Lanes(unsafe { $instruction(self.0, other.0) })
            }
        }
    )*};
}
implement!(Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);

// Lane numbers below `n`, as a mask.
#[inline(always)]
fn first_lanes(n: usize) -> __m256i {
    // SAFETY: AVX2 is present.
    unsafe { _mm256_cmpgt_epi32(_mm256_set1_epi32(n as i32), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)) }
}

#[inline(always)]
fn load(x: &EightIndices) -> __m256i {
    // SAFETY: AVX2 is present; eight numbers lie there.
    unsafe { _mm256_loadu_si256(x.as_ptr().cast()) }
}

#[inline(always)]
fn store(x: __m256i) -> EightIndices {
    let mut out = [0; 8];
    // SAFETY: AVX2 is present; there is room for eight numbers.
    unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), x) };
    out
}

// Whether all indices are below `len`, in one comparison.
#[inline(always)]
fn are_below(at: &EightIndices, len: usize) -> bool {
    let Some(last) = len.checked_sub(1) else { return false };
    // SAFETY: AVX2 is present.
    unsafe {
        let last = _mm256_set1_epi32(last.min(u32::MAX as usize) as u32 as i32);
        _mm256_movemask_epi8(_mm256_cmpeq_epi32(_mm256_max_epu32(load(at), last), last)) == -1
    }
}

// For each mask of eight bits, the places of its set bits.
const PLACES: [[u8; 8]; 256] = {
    let mut places = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut n) = (0, 0);
        while bit < 8 {
            if mask >> bit & 1 != 0 {
                places[mask][n] = bit as u8;
                n += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    places
};

impl EightLanes for Avx2Lanes {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        let mut out = [0.0; 8];
        // SAFETY: AVX2 is present; there is room for eight numbers.
        unsafe { _mm256_storeu_ps(out.as_mut_ptr(), self.0) };
        out
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_and_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_blendv_ps(no.0, yes.0, self.0) })
    }

    #[inline(always)]
    fn to_bits(self) -> u32 {
        // SAFETY: AVX2 is present.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }

    #[inline(always)]
    fn mask_first(n: usize) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_castsi256_ps(first_lanes(n)) })
    }

    #[inline(always)]
    fn permute(self, from: &EightIndices) -> Self {
        // SAFETY: AVX2 is present.
        Self(unsafe { _mm256_permutevar8x32_ps(self.0, load(from)) })
    }

    #[inline(always)]
    fn sum_rows(rows: [Self; 8]) -> [f32; 8] {
        // SAFETY: AVX2 is present.
        Self(unsafe {
            let (a, b) = (_mm256_hadd_ps(rows[0].0, rows[1].0), _mm256_hadd_ps(rows[2].0, rows[3].0));
            let (c, d) = (_mm256_hadd_ps(rows[4].0, rows[5].0), _mm256_hadd_ps(rows[6].0, rows[7].0));
            let (a, b) = (_mm256_hadd_ps(a, b), _mm256_hadd_ps(c, d));
            _mm256_add_ps(_mm256_permute2f128_ps::<0x20>(a, b), _mm256_permute2f128_ps::<0x31>(a, b))
        })
        .to_array()
    }

    #[inline(always)]
    fn sum_four_rows(rows: [Self; 4]) -> [f32; 4] {
        let mut out = [0.0; 4];
        // SAFETY: AVX2 is present; there is room for four numbers.
        unsafe {
            let (a, b) = (_mm256_hadd_ps(rows[0].0, rows[1].0), _mm256_hadd_ps(rows[2].0, rows[3].0));
            let a = _mm256_hadd_ps(a, b);
            let sums = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            _mm_storeu_ps(out.as_mut_ptr(), sums);
        }
        out
    }

    #[inline(always)]
    fn find_least(self) -> (f32, usize) {
        // SAFETY: AVX2 is present.
        unsafe {
            let a = _mm256_min_ps(self.0, _mm256_permute2f128_ps::<1>(self.0, self.0));
            let a = _mm256_min_ps(a, _mm256_shuffle_ps::<0x4E>(a, a));
            let a = _mm256_min_ps(a, _mm256_shuffle_ps::<0xB1>(a, a));
            let places = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(a, self.0)) as u32;
            (_mm256_cvtss_f32(a), (places.trailing_zeros() & 7) as usize)
        }
    }

    #[inline(always)]
    fn load_points(vertices: &[Vertex], at: &EightIndices) -> [Self; 3] {
        assert!(are_below(at, vertices.len()));
        let start = vertices.as_ptr();
        // SAFETY: AVX2 is present; indices are in range, and a vertex is 16 aligned bytes.
        unsafe {
            macro_rules! load_two {
                ($i:expr) => {{
                    let (a, b) = (start.add(at[$i] as usize).cast(), start.add(at[$i + 4] as usize).cast());
                    _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(_mm_load_ps(a)), _mm_load_ps(b))
                }};
            }
            let (a, b, c, d) = (load_two!(0), load_two!(1), load_two!(2), load_two!(3));
            let (low, high) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
            let z = _mm256_shuffle_ps::<0x44>(_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
            [Self(_mm256_shuffle_ps::<0x44>(low, high)), Self(_mm256_shuffle_ps::<0xEE>(low, high)), Self(z)]
        }
    }

    #[inline(always)]
    fn load_quadrics(quadrics: &[VertexQuadric], at: &EightIndices) -> [Self; 8] {
        assert!(are_below(at, quadrics.len()));
        let start = quadrics.as_ptr();
        // SAFETY: AVX2 is present; indices are in range, and a quadric is 32 aligned bytes.
        unsafe {
            macro_rules! load_row {
                ($i:expr) => {
                    _mm256_load_ps(start.add(at[$i] as usize).cast())
                };
            }
            let rows = [
                load_row!(0),
                load_row!(1),
                load_row!(2),
                load_row!(3),
                load_row!(4),
                load_row!(5),
                load_row!(6),
                load_row!(7),
            ];
            transpose(rows)
        }
    }

    #[inline(always)]
    fn load_numbers(numbers: &[u32], at: &EightIndices) -> EightIndices {
        assert!(are_below(at, numbers.len()));
        let mut out = [0; 8];
        for i in 0..8 {
            // SAFETY: indices are in range.
            out[i] = unsafe { *numbers.get_unchecked(at[i] as usize) };
        }
        out
    }

    #[inline(always)]
    fn keep_first(raw: &EightIndices, n: usize, rest: u32) -> EightIndices {
        // SAFETY: AVX2 is present.
        store(unsafe { _mm256_blendv_epi8(_mm256_set1_epi32(rest as i32), load(raw), first_lanes(n)) })
    }

    #[inline(always)]
    fn keep_above(raw: &EightIndices, n: usize, u: u32, us: &mut EightIndices, vs: &mut EightIndices) -> usize {
        // SAFETY: AVX2 is present; eight bytes lie at each row of places.
        unsafe {
            let (x, all_u) = (load(raw), _mm256_set1_epi32(u as i32));
            // Vertices are below 2^31, so signed comparisons hold.
            let above = _mm256_castsi256_ps(_mm256_and_si256(_mm256_cmpgt_epi32(x, all_u), first_lanes(n)));
            let mask = _mm256_movemask_ps(above) as usize & 255;
            let places = _mm256_cvtepu8_epi32(_mm_loadl_epi64(PLACES[mask].as_ptr().cast()));
            *us = store(all_u);
            *vs = store(_mm256_permutevar8x32_epi32(x, places));
            mask.count_ones() as usize
        }
    }

    #[inline(always)]
    fn lower_prices(best: &mut [u64], first: u32, us: &EightIndices, vs: &EightIndices, prices: Self) -> bool {
        // SAFETY: AVX2 is present.
        let (u_places, v_places, by_u, by_v) = unsafe {
            let (u, v, price) = (load(us), load(vs), _mm256_castps_si256(prices.0));
            let first = _mm256_set1_epi32(first as i32);
            (
                store(_mm256_sub_epi32(u, first)),
                store(_mm256_sub_epi32(v, first)),
                [_mm256_unpacklo_epi32(v, price), _mm256_unpackhi_epi32(v, price)],
                [_mm256_unpacklo_epi32(u, price), _mm256_unpackhi_epi32(u, price)],
            )
        };
        if !are_below(&u_places, best.len()) || !are_below(&v_places, best.len()) {
            return false;
        }
        let (by_u, by_v) = (to_packed(by_u), to_packed(by_v));
        // Unpacking gives lanes 0, 1, 4, 5 first.
        macro_rules! lower {
            ($(($lane:expr, $packed:expr))*) => {$(
                // SAFETY: indices are in range.
                let (u, v) = unsafe { (best.as_mut_ptr().add(u_places[$lane] as usize), best.as_mut_ptr().add(v_places[$lane] as usize)) };
                // SAFETY: as above; one write ends before the next read.
                unsafe { *u = (*u).min(by_u[$packed]); *v = (*v).min(by_v[$packed]); }
            )*};
        }
        lower!((0, 0)(1, 1)(4, 2)(5, 3)(2, 4)(3, 5)(6, 6)(7, 7));
        true
    }

    fn run_apart<K: Kernel>(kernel: K) -> K::Output {
        // SAFETY: AVX2 is present.
        unsafe { run_out_of_line(kernel) }
    }
}

#[inline(always)]
fn to_packed(halves: [__m256i; 2]) -> [u64; 8] {
    let mut out = [0; 8];
    // SAFETY: AVX2 is present; there is room for eight numbers.
    unsafe {
        _mm256_storeu_si256(out.as_mut_ptr().cast(), halves[0]);
        _mm256_storeu_si256(out.as_mut_ptr().add(4).cast(), halves[1]);
    }
    out
}

// Columns of eight rows.
#[inline(always)]
fn transpose(rows: [__m256; 8]) -> [Avx2Lanes; 8] {
    // SAFETY: AVX2 is present.
    unsafe {
        let (a0, a1) = (_mm256_unpacklo_ps(rows[0], rows[1]), _mm256_unpackhi_ps(rows[0], rows[1]));
        let (a2, a3) = (_mm256_unpacklo_ps(rows[2], rows[3]), _mm256_unpackhi_ps(rows[2], rows[3]));
        let (a4, a5) = (_mm256_unpacklo_ps(rows[4], rows[5]), _mm256_unpackhi_ps(rows[4], rows[5]));
        let (a6, a7) = (_mm256_unpacklo_ps(rows[6], rows[7]), _mm256_unpackhi_ps(rows[6], rows[7]));
        let (b0, b1) = (_mm256_shuffle_ps::<0x44>(a0, a2), _mm256_shuffle_ps::<0xEE>(a0, a2));
        let (b2, b3) = (_mm256_shuffle_ps::<0x44>(a1, a3), _mm256_shuffle_ps::<0xEE>(a1, a3));
        let (b4, b5) = (_mm256_shuffle_ps::<0x44>(a4, a6), _mm256_shuffle_ps::<0xEE>(a4, a6));
        let (b6, b7) = (_mm256_shuffle_ps::<0x44>(a5, a7), _mm256_shuffle_ps::<0xEE>(a5, a7));
        [
            Avx2Lanes(_mm256_permute2f128_ps::<0x20>(b0, b4)),
            Avx2Lanes(_mm256_permute2f128_ps::<0x20>(b1, b5)),
            Avx2Lanes(_mm256_permute2f128_ps::<0x20>(b2, b6)),
            Avx2Lanes(_mm256_permute2f128_ps::<0x20>(b3, b7)),
            Avx2Lanes(_mm256_permute2f128_ps::<0x31>(b0, b4)),
            Avx2Lanes(_mm256_permute2f128_ps::<0x31>(b1, b5)),
            Avx2Lanes(_mm256_permute2f128_ps::<0x31>(b2, b6)),
            Avx2Lanes(_mm256_permute2f128_ps::<0x31>(b3, b7)),
        ]
    }
}
