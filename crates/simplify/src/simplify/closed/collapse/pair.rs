//! Vertices of a collapse, and placement and price of a merged pair.

use std::ops::{Add, Div, Mul, Sub};

use glam::{DVec3, Vec3};

use crate::geometry::Quadric;

use super::corner_table::NONE;

/// Number of edges priced at once: the `f32` in a register of 256 bits.
pub(super) const WIDTH: usize = 8;

/// Largest distance of a merged vertex from the edge's middle, in edge lengths.
// Sixteen meshes: 1 or 4 change the largest distance by 1 %.
const REACH: f64 = 2.0;
/// Least pivot over the trace; below, the quadric determines no position in that direction.
// Eight roundings of single precision. At 1e-7 the largest distance is 1.4 % larger.
const LEAST_PIVOT: f32 = 1e-6;

/// Weight of the pull to a vertex's own position, over the trace of its planes.
// On flat surfaces planes do not determine the position. Sixteen meshes: at 1e-5 the mean distance is 1.6 % larger, at
// 1e-7 0.2 % smaller.
pub const PULL: f32 = 1e-6;

#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct CollapseVertex {
    pub position: Vec3,
    /// Plane quadric, an upper triangle: `d -> d'Ad` for the offset `d` from the vertex.
    pub planes: [f32; 6],
    pub importance: f32,
    pub corner: u32,
    pub degree: u32,
    /// Number on the surface; [`NONE`] for a ghost vertex.
    pub id: u32,
    pub changed: LastChange,
    /// Number of the last link test that marked the vertex.
    pub seen: u32,
    /// Price of the vertex's next edge to try if its cheaper edges failed; else 0.
    pub wait: f32,
}

/// Pass in which a vertex last changed, and whether it merged itself or only a neighbour did.
#[derive(Clone, Copy, Default, PartialEq)]
pub(super) struct LastChange(u32);

impl LastChange {
    pub fn from_merge(pass: u32) -> Self {
        Self(2 * pass + 1)
    }

    pub fn with_neighbour_change(self, pass: u32) -> Self {
        Self(self.0.max(2 * pass))
    }

    #[inline(always)]
    pub fn is_in(self, pass: u32) -> bool {
        self.0 / 2 == pass
    }

    pub fn is_before(self, pass: u32) -> bool {
        self.0 / 2 < pass
    }
}

impl CollapseVertex {
    pub fn new(position: Vec3, planes: [f32; 6], importance: f32, id: u32) -> Self {
        let (changed, seen, wait) = (LastChange::default(), 0, 0.0);
        Self { position, planes, importance, corner: NONE, degree: 0, id, changed, seen, wait }
    }

    pub fn ghost() -> Self {
        Self::new(Vec3::ZERO, [0.0; 6], 1.0, NONE)
    }

    #[inline(always)]
    fn first_eight(&self) -> [f32; WIDTH] {
        let (Vec3 { x, y, z }, [xx, xy, xz, yy, yz, _]) = (self.position, self.planes);
        [x, y, z, xx, xy, xz, yy, yz]
    }

    #[inline(always)]
    pub fn area(&self) -> f32 {
        (self.planes[0] + self.planes[3] + self.planes[5]) / self.importance
    }

    #[inline(always)]
    fn quadric(&self) -> Quadric {
        Quadric { a: self.planes.map(f64::from), ..Quadric::default() }
    }
}

#[inline(always)]
pub(super) fn add_pull(planes: [f32; 6]) -> [f32; 6] {
    add_growing_pull(planes, 0.0)
}

/// Adds two pulls to the position: one proportional to the trace of `planes`, one to its square.
#[inline(always)]
pub(super) fn add_growing_pull(mut planes: [f32; 6], growing_pull: f32) -> [f32; 6] {
    // The weight of the planes is their trace.
    let weight = planes[0] + planes[3] + planes[5];
    let pull = (PULL + growing_pull * weight) * weight;
    [0, 3, 5].into_iter().for_each(|diagonal| planes[diagonal] += pull);
    planes
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    Minimum,
    KeptEnd,
    RemovedEnd,
    Middle,
}

#[derive(Clone, Copy)]
pub struct MergedVertex {
    pub place: Placement,
    pub offset: DVec3,
    pub price: f64,
}

/// Edge with the summed quadric about its first end.
pub struct Pair {
    pub sum: Quadric,
    other: DVec3,
}

impl Pair {
    #[inline(always)]
    pub(super) fn new(u: &CollapseVertex, v: &CollapseVertex) -> Self {
        // Coordinates are relative to `u`: differences of positions are nearly exact in single precision.
        let other = (v.position - u.position).as_dvec3();
        Self { sum: u.quadric() + v.quadric().with_origin(-other), other }
    }

    pub fn other(&self) -> DVec3 {
        self.other
    }

    #[inline(always)]
    fn minimum_within_reach(&self) -> Option<(DVec3, f64)> {
        self.sum.minimum().filter(|(x, _)| self.is_within_reach(*x))
    }

    #[inline(always)]
    fn is_within_reach(&self, x: DVec3) -> bool {
        x.distance_squared(self.other * 0.5) <= REACH * REACH * self.other.length_squared()
    }

    #[inline(always)]
    fn best_without_minimum(&self) -> MergedVertex {
        let [kept, removed, middle] =
            [Placement::KeptEnd, Placement::RemovedEnd, Placement::Middle].map(|place| self.place_at(place));
        // Ties go to the vertex that stays, then to the other end.
        let best = if removed.price < kept.price { removed } else { kept };
        if middle.price < best.price { middle } else { best }
    }

    #[inline(always)]
    pub fn place_at(&self, place: Placement) -> MergedVertex {
        // Along the edge the quadric is a parabola in `t`.
        let t = match place {
            Placement::KeptEnd => 0.0,
            Placement::RemovedEnd => 1.0,
            Placement::Middle | Placement::Minimum => 0.5,
        };
        let Pair { sum, other } = self;
        let price = t * t * sum.curvature(*other) - 2.0 * t * sum.b.dot(*other) + sum.c;
        MergedVertex { place, offset: *other * t, price }
    }

    #[inline(always)]
    pub fn placement(&self) -> MergedVertex {
        match self.minimum_within_reach() {
            Some((offset, price)) => MergedVertex { place: Placement::Minimum, offset, price },
            None => self.best_without_minimum(),
        }
    }
}

#[derive(Clone, Copy)]
struct Lanes([f32; WIDTH]);

impl Lanes {
    #[inline(always)]
    fn all(x: f32) -> Self {
        Self([x; WIDTH])
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = [0.0; WIDTH];
        for ((out, x), y) in out.iter_mut().zip(self.0).zip(other.0) {
            *out = f(x, y);
        }
        Self(out)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |x, y| if y < x { y } else { x })
    }
}

macro_rules! by_lane {
    ($($operation:ident $method:ident $operator:tt),*) => {$(
        impl $operation for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |x, y| x $operator y)
            }
        }
    )*};
}
by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

#[inline(always)]
fn times(a: &[Lanes; 6], x: [Lanes; 3]) -> [Lanes; 3] {
    [
        a[0] * x[0] + a[1] * x[1] + a[2] * x[2],
        a[1] * x[0] + a[3] * x[1] + a[4] * x[2],
        a[2] * x[0] + a[4] * x[1] + a[5] * x[2],
    ]
}

#[inline(always)]
fn dot(x: [Lanes; 3], y: [Lanes; 3]) -> Lanes {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

struct EndColumns {
    position: [Lanes; 3],
    planes: [Lanes; 6],
}

impl EndColumns {
    #[inline(always)]
    fn new(nodes: [&CollapseVertex; WIDTH]) -> Self {
        let [a, b, c, d, e, f, g, h] = nodes;
        let [x, y, z, xx, xy, xz, yy, yz] = transpose([
            a.first_eight(),
            b.first_eight(),
            c.first_eight(),
            d.first_eight(),
            e.first_eight(),
            f.first_eight(),
            g.first_eight(),
            h.first_eight(),
        ]);
        // The ninth number does not fit into the transposed block.
        let mut zz = [0.0; WIDTH];
        for (zz, node) in zz.iter_mut().zip(nodes) {
            *zz = node.planes[5];
        }
        let planes = [Lanes(xx), Lanes(xy), Lanes(xz), Lanes(yy), Lanes(yz), Lanes(zz)];
        Self { position: [Lanes(x), Lanes(y), Lanes(z)], planes }
    }
}

#[inline(always)]
fn transpose(rows: [[f32; WIDTH]; WIDTH]) -> [[f32; WIDTH]; WIDTH] {
    let [a, b, c, d, e, f, g, h] = rows;
    let [a, b, c, d, e, f, g, h] =
        [low(a, b), high(a, b), low(c, d), high(c, d), low(e, f), high(e, f), low(g, h), high(g, h)];
    let [a, b, c, d, e, f, g, h] = [
        low_pairs(a, c),
        high_pairs(a, c),
        low_pairs(b, d),
        high_pairs(b, d),
        low_pairs(e, g),
        high_pairs(e, g),
        low_pairs(f, h),
        high_pairs(f, h),
    ];
    [
        low_half(a, e),
        low_half(b, f),
        low_half(c, g),
        low_half(d, h),
        high_half(a, e),
        high_half(b, f),
        high_half(c, g),
        high_half(d, h),
    ]
}

/// Shuffles of two registers; lane numbers from 8 on mean the second.
macro_rules! shuffles {
    ($($name:ident $lanes:expr),*) => {$(
        #[inline(always)]
        fn $name(a: [f32; WIDTH], b: [f32; WIDTH]) -> [f32; WIDTH] {
            let mut out = [0.0; WIDTH];
            for (out, lane) in out.iter_mut().zip($lanes) {
                *out = if lane < WIDTH { a[lane] } else { b[lane - WIDTH] };
            }
            out
        }
    )*};
}
shuffles!(
    low [0, 8, 1, 9, 4, 12, 5, 13],
    high [2, 10, 3, 11, 6, 14, 7, 15],
    low_pairs [0, 1, 8, 9, 4, 5, 12, 13],
    high_pairs [2, 3, 10, 11, 6, 7, 14, 15],
    low_half [0, 1, 2, 3, 8, 9, 10, 11],
    high_half [4, 5, 6, 7, 12, 13, 14, 15]
);

struct PairLanes {
    a: [Lanes; 6],
    b: [Lanes; 3],
    c: Lanes,
    other: [Lanes; 3],
}

impl PairLanes {
    #[inline(always)]
    fn new([u, v]: [[&CollapseVertex; WIDTH]; 2]) -> Self {
        let (u, v) = (EndColumns::new(u), EndColumns::new(v));
        let mut other = v.position;
        for (other, u) in other.iter_mut().zip(u.position) {
            *other = *other - u;
        }
        // The quadric of `v` about `u`: same matrix, shifted linear and constant terms.
        let there = times(&v.planes, other);
        let mut a = u.planes;
        for (a, v) in a.iter_mut().zip(v.planes) {
            *a = *a + v;
        }
        Self { a, b: there, c: dot(there, other), other }
    }

    /// Computes the minima relative to the first ends, and the prices there.
    ///
    /// Solves `A x = b` with `A = L D L'`: `L y = b`, `D z = y`, `L' x = z`. Directions without a pivot stay 0.
    #[inline(always)]
    fn minima(&self) -> ([Lanes; 3], Lanes) {
        // The factorisation loses no more than the rounding of A; a determinant would lose everything on nearly flat
        // surfaces.
        let Self { a: [xx, xy, xz, yy, yz, zz], b, c, .. } = *self;
        let all = Lanes::all;
        let least_pivot = all(LEAST_PIVOT) * (xx + yy + zz);
        // Inverts a pivot; gives 0 where rounding leaves no information.
        let over = |pivot: Lanes| {
            let over = all(1.0) / pivot;
            let is_pivot = pivot - least_pivot;
            is_pivot.zip(over, |is_pivot, over| if is_pivot > 0.0 { over } else { 0.0 })
        };
        let over_d0 = over(xx);
        // Factorisation, column by column.
        let (l10, l20) = (xy * over_d0, xz * over_d0);
        let d1 = yy - l10 * xy;
        let rest = yz - l20 * xy;
        let over_d1 = over(d1);
        let l21 = rest * over_d1;
        let d2 = zz - l20 * xz - l21 * rest;
        let over_d2 = over(d2);
        // Forward substitution, scaling, back substitution.
        let y = [b[0], b[1] - l10 * b[0], b[2] - l20 * b[0] - l21 * (b[1] - l10 * b[0])];
        let z = [y[0] * over_d0, y[1] * over_d1, y[2] * over_d2];
        let x1 = z[1] - l21 * z[2];
        let x = [z[0] - l10 * x1 - l20 * z[2], x1, z[2]];
        (x, (c - dot(y, z)).zip(all(0.0), f32::max))
    }

    #[inline(always)]
    fn best_without_minima(&self) -> Lanes {
        let Self { a, b, c, other } = self;
        // The parabola along the edge at t = 0, 1 and 1/2.
        let (curvature, slope) = (dot(times(a, *other), *other), dot(*b, *other));
        let removed = curvature - Lanes::all(2.0) * slope + *c;
        let middle = Lanes::all(0.25) * curvature - slope + *c;
        c.min(removed).min(middle)
    }
}

/// Computes the prices of [`Pair::placement`] for eight edges.
#[inline(always)]
pub(super) fn prices(ends: [[&CollapseVertex; WIDTH]; 2]) -> [f32; WIDTH] {
    // All lanes have one order of operations, so a price does not depend on the other edges. Loops over arrays are used
    // because closures in array methods are not always vectorised.
    let pairs = PairLanes::new(ends);
    let (x, lowest) = pairs.minima();
    let (other, half) = (pairs.other, Lanes::all(0.5));
    let from_middle = [x[0] - other[0] * half, x[1] - other[1] * half, x[2] - other[2] * half];
    // Not negative where the minimum is within reach of the edge.
    let within = Lanes::all(REACH as f32 * REACH as f32) * dot(other, other) - dot(from_middle, from_middle);
    let best_without_minima = pairs.best_without_minima();
    let mut prices = best_without_minima.0;
    // A select instead of a branch, for all lanes.
    for (price, (within, lowest)) in prices.iter_mut().zip(within.0.into_iter().zip(lowest.0)) {
        *price = if within >= 0.0 { lowest } else { *price };
    }
    prices
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::shapes;
    use crate::simplify::closed::prepare::surface::PreparedSurface;

    fn nodes(surface: &PreparedSurface) -> Vec<CollapseVertex> {
        let node =
            |v: u32| CollapseVertex::new(surface.positions[v as usize], add_pull(surface.quadrics[v as usize]), 1.0, v);
        (0..surface.n_vertices() as u32).map(node).collect()
    }

    #[test]
    fn prices_are_what_the_placement_costs() {
        for mesh in [shapes::wavy_sphere(3, 10.0), shapes::cuboid([1.0; 3], 4), shapes::thin_sheet(9, 1e-3)] {
            let surface = PreparedSurface::new(&mesh, Pulse::NONE);
            let nodes = nodes(&surface);
            let edges: Vec<[u32; 2]> = surface.faces.iter().map(|&[a, b, _]| [a, b]).collect();
            let scale: f32 = nodes.iter().map(CollapseVertex::area).sum();
            for &[u, v] in &edges {
                let (u, v) = (&nodes[u as usize], &nodes[v as usize]);
                let naive = Pair::new(u, v).placement().price as f32;
                let prices = prices([[u; WIDTH], [u, v, u, v, v, u, v, v]]);
                let of_v = [prices[1], prices[3], prices[4], prices[6], prices[7]];
                assert!(of_v.iter().all(|price| price.to_bits() == of_v[0].to_bits()));
                assert!((of_v[0] - naive).abs() <= 1e-4 * naive + 1e-9 * scale, "{} {naive}", of_v[0]);
            }
        }
    }
}
