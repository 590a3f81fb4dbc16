//! Eight numbers at a time: the operations that kernels are written in, with one implementation per kind of machine.
//!
//! Kernels are generic over [`EightLanes`]. No operation is fused and all sums have one order,
//! so every implementation gives the same bits.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

use crate::collapse::rings::Vertex;

/// Eight indices of vertices.
pub(crate) type EightIndices = [u32; 8];

/// The quadric of a vertex: xx, xy, xz, yy, yz, zz of its matrix, a third of the area around it, and its importance.
///
/// The matrix is the sum of n nᵀ over the faces around, n the unit normal, each times a third of the face's area; offsets
/// are counted from the vertex itself, so there is no linear term. Matrix and area are times the importance, at most 1, to
/// which a [`mark`] is added.
#[repr(C, align(32))]
#[derive(Clone, Copy, Default, Debug, PartialEq)]
pub(crate) struct VertexQuadric(pub [f32; 8]);

impl VertexQuadric {
    /// Returns the importance without its mark.
    pub(crate) fn importance(&self) -> f32 {
        if self.0[7] > mark::SPECIAL { self.0[7] - mark::SPECIAL } else { self.0[7] }
    }
}

/// The bound that the last number of a [`VertexQuadric`] exceeds for marked vertices; their edges take the slow lane of the prices.
pub(crate) mod mark {
    pub const SPECIAL: f32 = 1.0;
}

/// Eight floats, or a mask of eight lanes whose bits are all set or all clear. What has a body is for vectors that gather nothing.
pub(crate) trait EightLanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn splat(x: f32) -> Self;
    fn to_array(self) -> [f32; 8];
    fn sqrt(self) -> Self;
    /// Returns the smaller numbers; those of `other` where one is NaN.
    fn min(self, other: Self) -> Self;
    /// Returns the larger numbers; those of `other` where one is NaN.
    fn max(self, other: Self) -> Self;
    /// Returns the mask of lanes above those of `other`.
    fn greater(self, other: Self) -> Self;
    fn and(self, other: Self) -> Self;
    /// Takes lanes of `yes` where this mask is set, else of `no`.
    fn select(self, yes: Self, no: Self) -> Self;
    /// Returns one bit per lane of a mask.
    fn to_bits(self) -> u32;
    /// Returns the mask of lanes 0 to `n` - 1.
    fn mask_first(n: usize) -> Self;
    /// Moves lane `from[i]` to lane i.
    fn permute(self, from: &EightIndices) -> Self;
    /// Returns the sum of each row's lanes, as ((0 + 1) + (2 + 3)) + ((4 + 5) + (6 + 7)).
    fn sum_rows(rows: [Self; 8]) -> [f32; 8];
    /// Returns the sums of four rows, in the order of [`EightLanes::sum_rows`].
    fn sum_four_rows(rows: [Self; 4]) -> [f32; 4];
    /// Returns the least lane and the first place of it.
    #[inline(always)]
    fn find_least(self) -> (f32, usize) {
        let x = self.to_array();
        let mut least = 0;
        for i in 1..8 {
            if x[i] < x[least] {
                least = i;
            }
        }
        (x[least], least)
    }
    /// Loads positions as x, y and z of eight vertices.
    fn load_points(vertices: &[Vertex], at: &EightIndices) -> [Self; 3];
    /// Loads quadrics, transposed: one row per number.
    fn load_quadrics(quadrics: &[VertexQuadric], at: &EightIndices) -> [Self; 8];
    /// Loads eight numbers.
    #[inline(always)]
    fn load_numbers(numbers: &[u32], at: &EightIndices) -> EightIndices {
        from_fn(|i| numbers[at[i] as usize])
    }
    /// Returns the first `n` of `raw` and `rest` in place of the others.
    #[inline(always)]
    fn keep_first(raw: &EightIndices, n: usize, rest: u32) -> EightIndices {
        from_fn(|i| if i < n { raw[i] } else { rest })
    }
    /// Writes those of the first `n` of `raw` above `u` to the front of `vs`, and `u` to all of `us`; returns how many.
    #[inline(always)]
    fn keep_above(raw: &EightIndices, n: usize, u: u32, us: &mut EightIndices, vs: &mut EightIndices) -> usize {
        let mut kept = 0;
        *us = [u; 8];
        for &v in &raw[..n] {
            vs[kept & 7] = v;
            kept += usize::from(v > u);
        }
        kept
    }
    /// Lowers `best` at both ends of eight edges to price and other end.
    ///
    /// Does nothing and returns false if an end is not in `best`, whose first vertex is `first`.
    #[inline(always)]
    fn lower_prices(best: &mut [u64], first: u32, us: &EightIndices, vs: &EightIndices, prices: Self) -> bool {
        if (0..8).any(|i| us[i].wrapping_sub(first).max(vs[i].wrapping_sub(first)) as usize >= best.len()) {
            return false;
        }
        let prices = prices.to_array();
        for i in 0..8 {
            for (end, other) in [(us[i], vs[i]), (vs[i], us[i])] {
                let least = &mut best[(end - first) as usize];
                *least = (*least).min(pack(prices[i], other));
            }
        }
        true
    }
    /// Runs a kernel as a function of its own that is compiled for these lanes, to keep rare work out of hot code.
    #[inline(never)]
    fn run_apart<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Self>()
    }
}

/// Work that is compiled for each kind of lanes; it and its callees must be `#[inline(always)]`, without closures.
pub(crate) trait Kernel {
    type Output;

    fn run<L: EightLanes>(self) -> Self::Output;
}

/// Packs a price and the other end of its edge; the order of the packed numbers is that of prices, then of indices.
#[inline(always)]
pub(crate) fn pack(price: f32, other: u32) -> u64 {
    u64::from(price.to_bits()) << 32 | u64::from(other)
}

/// Three rows of lanes: x, y and z of eight vectors.
pub(crate) type Vectors<L> = [L; 3];

#[inline(always)]
pub(crate) fn splat_vector<L: EightLanes>(v: [f32; 3]) -> Vectors<L> {
    [L::splat(v[0]), L::splat(v[1]), L::splat(v[2])]
}

#[inline(always)]
pub(crate) fn subtract<L: EightLanes>(a: Vectors<L>, b: Vectors<L>) -> Vectors<L> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn dot<L: EightLanes>(a: Vectors<L>, b: Vectors<L>) -> L {
    a[0] * b[0] + (a[1] * b[1] + a[2] * b[2])
}

#[inline(always)]
pub(crate) fn cross<L: EightLanes>(a: Vectors<L>, b: Vectors<L>) -> Vectors<L> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Clamps to 0 to 1.
#[inline(always)]
pub(crate) fn clamp_unit<L: EightLanes>(x: L) -> L {
    x.max(L::splat(0.0)).min(L::splat(1.0))
}

/// Returns the squared distance between `d` and s a + t b.
#[inline(always)]
pub(crate) fn squared_rest<L: EightLanes>(d: Vectors<L>, a: Vectors<L>, b: Vectors<L>, s: L, t: L) -> L {
    let rest = [d[0] - (s * a[0] + t * b[0]), d[1] - (s * a[1] + t * b[1]), d[2] - (s * a[2] + t * b[2])];
    dot(rest, rest)
}
