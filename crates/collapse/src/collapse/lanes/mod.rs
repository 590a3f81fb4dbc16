//! Eight numbers at a time: the operations that kernels are written in, with one implementation per kind of machine.
//!
//! Kernels are generic over [`Lanes`] and run through [`dispatch`]. No operation is fused and all sums have one order,
//! so every implementation gives the same bits.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod plain;

use std::ops::{Add, Div, Mul, Sub};

use crate::collapse::rings::Vertex;

/// Eight indices of vertices.
pub(crate) type Indices = [u32; 8];

/// The quadric of a vertex: xx, xy, xz, yy, yz, zz of its matrix, a third of the area around it, and a [`mark`].
///
/// The matrix is the sum of n nᵀ over the faces around, n the unit normal, each times a third of the face's area; offsets
/// are counted from the vertex itself, so there is no linear term.
#[repr(C, align(32))]
#[derive(Clone, Copy, Default, Debug, PartialEq)]
pub(crate) struct Quadric(pub [f32; 8]);

/// Marks of the last number of a [`Quadric`]: edges of a marked vertex take the slow lane of the prices.
pub(crate) mod mark {
    pub const FREE: f32 = 0.0;
    pub const SPECIAL: f32 = 1.0;
}

/// Eight floats, or a mask of eight lanes whose bits are all set or all clear.
pub(crate) trait Lanes:
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
    fn permute(self, from: &Indices) -> Self;
    /// Returns the sum of each row's lanes, as ((0 + 1) + (2 + 3)) + ((4 + 5) + (6 + 7)).
    fn sum_rows(rows: [Self; 8]) -> [f32; 8];
    /// Returns the sums of four rows, in the order of [`Lanes::sum_rows`].
    fn sum_four_rows(rows: [Self; 4]) -> [f32; 4];
    /// Returns the least lane and the first place of it.
    fn find_least(self) -> (f32, usize);
    /// Loads positions as x, y and z of eight vertices.
    fn load_points(vertices: &[Vertex], at: &Indices) -> [Self; 3];
    /// Loads quadrics, transposed: one row per number.
    fn load_quadrics(quadrics: &[Quadric], at: &Indices) -> [Self; 8];
    /// Loads eight numbers.
    fn load_numbers(numbers: &[u32], at: &Indices) -> Indices;
    /// Returns the first `n` of `raw` and `rest` in place of the others.
    fn keep_first(raw: &Indices, n: usize, rest: u32) -> Indices;
    /// Writes those of the first `n` of `raw` above `u` to the front of `vs`, and `u` to all of `us`; returns how many.
    fn keep_above(raw: &Indices, n: usize, u: u32, us: &mut Indices, vs: &mut Indices) -> usize;
    /// Lowers `best` at both ends of eight edges to price and other end; does nothing and returns false if an end is
    /// not in `best`, which starts at vertex `first`.
    fn lower_prices(best: &mut [u64], first: u32, us: &Indices, vs: &Indices, prices: Self) -> bool;
    /// Runs a kernel as a function of its own that is compiled for these lanes, to keep rare work out of hot code.
    fn run_apart<K: Kernel>(kernel: K) -> K::Output;
}

/// Work that is compiled for each kind of lanes; it and its callees must be `#[inline(always)]`, without closures.
pub(crate) trait Kernel {
    type Output;

    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs a kernel with the widest lanes that this processor has.
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    {
        avx2::run_if_present(kernel)
    }
    #[cfg(not(target_arch = "x86_64"))]
    run_plain(kernel)
}

/// Runs a kernel with plain arrays, as on processors without AVX2.
pub(crate) fn run_plain<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<plain::PlainLanes>()
}

/// Packs a price and the other end of its edge; the order of the packed numbers is that of prices, then of indices.
#[inline(always)]
pub(crate) fn pack(price: f32, other: u32) -> u64 {
    u64::from(price.to_bits()) << 32 | u64::from(other)
}

/// Three rows of lanes: x, y and z of eight vectors.
pub(crate) type Vectors<L> = [L; 3];

#[inline(always)]
pub(crate) fn splat_vector<L: Lanes>(v: [f32; 3]) -> Vectors<L> {
    [L::splat(v[0]), L::splat(v[1]), L::splat(v[2])]
}

#[inline(always)]
pub(crate) fn subtract<L: Lanes>(a: Vectors<L>, b: Vectors<L>) -> Vectors<L> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn dot<L: Lanes>(a: Vectors<L>, b: Vectors<L>) -> L {
    a[0] * b[0] + (a[1] * b[1] + a[2] * b[2])
}

#[inline(always)]
pub(crate) fn cross<L: Lanes>(a: Vectors<L>, b: Vectors<L>) -> Vectors<L> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Clamps to 0 to 1.
#[inline(always)]
pub(crate) fn clamp_unit<L: Lanes>(x: L) -> L {
    x.max(L::splat(0.0)).min(L::splat(1.0))
}

/// Returns the squared distance between `d` and s a + t b.
#[inline(always)]
pub(crate) fn squared_rest<L: Lanes>(d: Vectors<L>, a: Vectors<L>, b: Vectors<L>, s: L, t: L) -> L {
    let rest = [d[0] - (s * a[0] + t * b[0]), d[1] - (s * a[1] + t * b[1]), d[2] - (s * a[2] + t * b[2])];
    dot(rest, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    struct EveryOperation([f32; 8], [f32; 8]);

    impl Kernel for EveryOperation {
        type Output = Vec<u32>;

        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec<u32> {
            let mut out = Vec::new();
            let quadrics = [Quadric(self.0), Quadric(self.1)];
            let rows = L::load_quadrics(&quadrics, &[0, 1, 1, 0, 1, 0, 0, 1]);
            let (a, b) = (rows[0], rows[1]);
            let mask = a.greater(b);
            let lanes = [a + b, a - b, a * b, a / b, (a * a).sqrt(), a.min(b), a.max(b), mask, a.and(mask)];
            let more = [mask.select(a, b), L::mask_first(3), a.permute(&[3, 2, 1, 0, 7, 7, 5, 4]), L::splat(2.5)];
            for x in lanes.into_iter().chain(more).chain(rows) {
                out.extend(x.to_array().map(f32::to_bits));
            }
            out.extend(L::sum_rows(rows).map(f32::to_bits));
            out.extend(L::sum_four_rows([a, b, rows[2], rows[3]]).map(f32::to_bits));
            out.extend([mask.to_bits(), a.find_least().0.to_bits(), a.find_least().1 as u32]);
            let vertices: Vec<Vertex> =
                self.0.iter().enumerate().map(|(i, &x)| Vertex::new([x, x * x, self.1[i]], i as u32)).collect();
            for x in L::load_points(&vertices, &[7, 0, 3, 3, 2, 1, 6, 5]) {
                out.extend(x.to_array().map(f32::to_bits));
            }
            let raw = [3, 9, 1, 4, 7, 0, 2, 5];
            out.extend(L::load_numbers(&[5, 4, 3, 2, 1, 0, 9, 8, 7, 6], &raw));
            out.extend(L::keep_first(&raw, 5, 77));
            let (mut us, mut vs) = ([0; 8], [0; 8]);
            let n = L::keep_above(&raw, 6, 3, &mut us, &mut vs);
            out.extend(vs[..n].iter().chain(&us[..n]));
            let mut best = vec![u64::MAX; 10];
            assert!(!L::lower_prices(&mut best, 1, &us, &raw, a));
            assert!(L::lower_prices(&mut best, 0, &us, &raw, a * a));
            out.extend(best.iter().flat_map(|&x| [x as u32, (x >> 32) as u32]));
            out
        }
    }

    #[test]
    fn all_lanes_give_the_bits_of_plain_arrays() {
        let (a, b) = ([0.1, -2.7, 3.3, 4.9, 1e-20, -6.0, 7.5, 0.25], [1.5, 2.5, -0.3, 4.7, 8.1, 1e10, -7.5, 3.0]);
        assert_eq!(dispatch(EveryOperation(a, b)), run_plain(EveryOperation(a, b)));
        assert_eq!(dispatch(EveryOperation(b, a)), run_plain(EveryOperation(b, a)));
    }
}
