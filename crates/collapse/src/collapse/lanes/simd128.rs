//! Lanes in pairs of vectors of WebAssembly, for modules that are compiled with them.

use std::arch::wasm32::*;
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

use super::eight::{EightIndices, EightLanes, VertexQuadric};
use crate::collapse::rings::Vertex;

#[derive(Clone, Copy)]
pub(super) struct Simd128Lanes([v128; 2]);

macro_rules! implement {
    ($($operator:ident $name:ident $instruction:ident),*) => {$(
        impl $operator for Simd128Lanes {
            type Output = Simd128Lanes;

            #[inline(always)]
            fn $name(self, other: Simd128Lanes) -> Simd128Lanes {
                Simd128Lanes([$instruction(self.0[0], other.0[0]), $instruction(self.0[1], other.0[1])])
            }
        }
    )*};
}
implement!(Add add f32x4_add, Sub sub f32x4_sub, Mul mul f32x4_mul, Div div f32x4_div);

#[inline(always)]
fn four(x: [f32; 4]) -> v128 {
    f32x4(x[0], x[1], x[2], x[3])
}

#[inline(always)]
fn to_four(x: v128) -> [f32; 4] {
    [f32x4_extract_lane::<0>(x), f32x4_extract_lane::<1>(x), f32x4_extract_lane::<2>(x), f32x4_extract_lane::<3>(x)]
}

#[inline(always)]
fn transpose(r: [v128; 4]) -> [v128; 4] {
    let (low01, high01) = (i32x4_shuffle::<0, 4, 1, 5>(r[0], r[1]), i32x4_shuffle::<2, 6, 3, 7>(r[0], r[1]));
    let (low23, high23) = (i32x4_shuffle::<0, 4, 1, 5>(r[2], r[3]), i32x4_shuffle::<2, 6, 3, 7>(r[2], r[3]));
    [
        i32x4_shuffle::<0, 1, 4, 5>(low01, low23),
        i32x4_shuffle::<2, 3, 6, 7>(low01, low23),
        i32x4_shuffle::<0, 1, 4, 5>(high01, high23),
        i32x4_shuffle::<2, 3, 6, 7>(high01, high23),
    ]
}

impl EightLanes for Simd128Lanes {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([f32x4_splat(x); 2])
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        let [a, b] = self.0.map(to_four);
        [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]]
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self([f32x4_sqrt(self.0[0]), f32x4_sqrt(self.0[1])])
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self([f32x4_pmin(other.0[0], self.0[0]), f32x4_pmin(other.0[1], self.0[1])])
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self([f32x4_pmax(other.0[0], self.0[0]), f32x4_pmax(other.0[1], self.0[1])])
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self([f32x4_gt(self.0[0], other.0[0]), f32x4_gt(self.0[1], other.0[1])])
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self([v128_and(self.0[0], other.0[0]), v128_and(self.0[1], other.0[1])])
    }

    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        Self([v128_bitselect(yes.0[0], no.0[0], self.0[0]), v128_bitselect(yes.0[1], no.0[1], self.0[1])])
    }

    #[inline(always)]
    fn to_bits(self) -> u32 {
        u32::from(i32x4_bitmask(self.0[0])) | u32::from(i32x4_bitmask(self.0[1])) << 4
    }

    #[inline(always)]
    fn mask_first(n: usize) -> Self {
        let n = i32x4_splat(n.min(8) as i32);
        Self([i32x4_gt(n, i32x4(0, 1, 2, 3)), i32x4_gt(n, i32x4(4, 5, 6, 7))])
    }

    #[inline(always)]
    fn permute(self, from: &EightIndices) -> Self {
        let x = self.to_array();
        let [a, b] = [0, 4].map(|first| four([0, 1, 2, 3].map(|i| x[from[first + i] as usize & 7])));
        Self([a, b])
    }

    #[inline(always)]
    fn sum_rows(rows: [Self; 8]) -> [f32; 8] {
        let [a, b] = [0, 4].map(|first| Self::sum_four_rows([0, 1, 2, 3].map(|i| rows[first + i])));
        [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]]
    }

    #[inline(always)]
    fn sum_four_rows(rows: [Self; 4]) -> [f32; 4] {
        let half = |k: usize| {
            let [a, b, c, d] = transpose([rows[0].0[k], rows[1].0[k], rows[2].0[k], rows[3].0[k]]);
            f32x4_add(f32x4_add(a, b), f32x4_add(c, d))
        };
        to_four(f32x4_add(half(0), half(1)))
    }

    #[inline(always)]
    fn load_points(vertices: &[Vertex], at: &EightIndices) -> [Self; 3] {
        let load = |i: usize| {
            let Vertex { position: [x, y, z], survivor } = vertices[at[i] as usize];
            f32x4(x, y, z, f32::from_bits(survivor))
        };
        let low = transpose([load(0), load(1), load(2), load(3)]);
        let high = transpose([load(4), load(5), load(6), load(7)]);
        [Self([low[0], high[0]]), Self([low[1], high[1]]), Self([low[2], high[2]])]
    }

    #[inline(always)]
    fn load_quadrics(quadrics: &[VertexQuadric], at: &EightIndices) -> [Self; 8] {
        let load = |i: usize, first: usize| {
            let q = &quadrics[at[i] as usize].0;
            f32x4(q[first], q[first + 1], q[first + 2], q[first + 3])
        };
        let quarter = |i: usize, first: usize| {
            transpose([load(i, first), load(i + 1, first), load(i + 2, first), load(i + 3, first)])
        };
        let (low, high) = ([quarter(0, 0), quarter(0, 4)], [quarter(4, 0), quarter(4, 4)]);
        from_fn(|number| Self([low[number / 4][number % 4], high[number / 4][number % 4]]))
    }
}
