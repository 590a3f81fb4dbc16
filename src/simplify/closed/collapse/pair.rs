//! A vertex of a collapse, and two of them about to be merged: where the merged one goes and what that costs.
//!
//! What merges cost is computed for several edges side by side, the same operations in the same order for each, so that
//! an edge has the same price to the bit however many stand beside it.

use std::ops::{Add, Div, Mul, Range, Sub};

use glam::{DVec3, Vec3};

use crate::geometry::Quadric;
use crate::linalg::{Isa, RowKernel};

use super::links::Span;
use crate::simplify::closed::placement::Placement;

/// A merged vertex lies at most this many edge lengths from the middle of its edge.
pub(super) const REACH: f64 = 2.0;
/// Edges that are priced side by side.
pub(super) const SIDE_BY_SIDE: usize = 8;

/// A vertex: where it is, what it stands for, and where its neighbours are listed. One cache line.
#[derive(Clone, Copy, Default)]
#[repr(align(64))]
pub(super) struct Node {
    /// Where it is.
    pub position: Vec3,
    /// What it stands for.
    pub quadric: LocalQuadric,
    /// Where its neighbours are listed.
    pub ring: Span,
    /// Grows with every merge; tells an edge that its price is old.
    pub version: u32,
}

impl Node {
    /// A vertex that was not merged yet.
    pub fn new(placed: &Placement, v: u32, ring: Span) -> Self {
        let position = placed.positions[v as usize].as_vec3();
        let quadric = match placed.own_planes(v) {
            Some(a) => LocalQuadric { a, ..LocalQuadric::default() },
            None => LocalQuadric::new(&placed.quadric(v), position),
        };
        Self { position, quadric, ring, version: 0 }
    }
}

/// A quadric about its vertex: `d -> d'Ad - 2 b'd + c` for the offset `d` from there. Small numbers, so that single
/// precision holds them as well as double precision held them about the origin.
#[derive(Clone, Copy, Default)]
pub(super) struct LocalQuadric {
    a: [f32; 6],
    b: [f32; 3],
    /// Its value at the vertex.
    pub c: f32,
}

impl LocalQuadric {
    /// The quadric about `position`, rounded.
    pub fn new(quadric: &Quadric, position: Vec3) -> Self {
        let Quadric { a, b, c } = quadric.about(position.as_dvec3());
        Self { a: a.map(|x| x as f32), b: b.as_vec3().to_array(), c: c.max(0.0) as f32 }
    }

    fn wide(&self) -> Quadric {
        Quadric { a: self.a.map(f64::from), b: DVec3::from(self.b.map(f64::from)), c: f64::from(self.c) }
    }
}

/// Where a merged vertex goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::simplify::closed) enum Place {
    /// To the minimum of the summed quadrics.
    Minimum,
    /// Where the vertex that stays was.
    Kept,
    /// Where the other one was.
    Gone,
    /// Between them.
    Middle,
}

/// An edge about to be merged, seen from its first end: the summed quadric about there, and where the other end is.
pub(in crate::simplify::closed) struct Pair {
    /// The summed quadric about the first end.
    pub sum: Quadric,
    other: DVec3,
}

impl Pair {
    /// The edge between two vertices.
    #[inline(always)]
    pub(super) fn new(u: &Node, v: &Node) -> Self {
        let other = (v.position - u.position).as_dvec3();
        Self { sum: u.quadric.wide() + v.quadric.wide().about(-other), other }
    }

    /// An edge to `other` by the summed quadric about its first end.
    #[cfg(test)]
    pub(super) fn about(sum: Quadric, other: DVec3) -> Self {
        Self { sum, other }
    }

    /// Where the other end is, from the first.
    pub fn other(&self) -> DVec3 {
        self.other
    }

    /// The minimum, if it lies near enough to the edge, and its value.
    #[inline(always)]
    fn minimum_within_reach(&self) -> Option<(DVec3, f64)> {
        let middle = self.other * 0.5;
        self.sum.minimum().filter(|(x, _)| x.distance_squared(middle) <= REACH * REACH * self.other.length_squared())
    }

    /// The best of what else comes into question: the two ends and the middle.
    #[inline(always)]
    fn best_other(&self) -> (Place, DVec3, f64) {
        let [kept, gone, middle] = [Place::Kept, Place::Gone, Place::Middle].map(|place| self.at(place));
        let best = if gone.2 < kept.2 { gone } else { kept };
        if middle.2 < best.2 { middle } else { best }
    }

    /// One of the two ends or, for any other place, the middle, from the first end, and what that costs.
    #[inline(always)]
    pub fn at(&self, place: Place) -> (Place, DVec3, f64) {
        let t = match place {
            Place::Kept => 0.0,
            Place::Gone => 1.0,
            Place::Middle | Place::Minimum => 0.5,
        };
        let Pair { sum, other } = self;
        (place, *other * t, t * t * sum.curvature(*other) - 2.0 * t * sum.b.dot(*other) + sum.c)
    }

    /// Where the merged vertex goes, from the first end, and what that costs.
    #[inline(always)]
    pub fn placement(&self) -> (Place, DVec3, f64) {
        match self.minimum_within_reach() {
            Some((x, cost)) => (Place::Minimum, x, cost),
            None => self.best_other(),
        }
    }
}

/// What merging the ends of an edge costs.
#[inline(always)]
pub(super) fn price(u: &Node, v: &Node) -> f32 {
    prices_of([(u, v)])[0]
}

/// What merging the ends of each of these edges costs.
pub(super) fn prices(nodes: &[Node], edges: &[[u32; 2]]) -> Vec<f32> {
    Isa::best().matrix(&Prices { nodes, edges }, edges.len(), 1).into_data()
}

struct Prices<'a> {
    nodes: &'a [Node],
    edges: &'a [[u32; 2]],
}

impl RowKernel for Prices<'_> {
    /// Products are not fused, so that every processor finds the same prices.
    #[inline(always)]
    fn compute<const FMA: bool>(&self, rows: Range<usize>, out: &mut [f32]) {
        let pair = |&[u, v]: &[u32; 2]| (&self.nodes[u as usize], &self.nodes[v as usize]);
        let edges = &self.edges[rows];
        let (whole, rest) = edges.as_chunks::<SIDE_BY_SIDE>();
        for (edges, out) in whole.iter().zip(out.chunks_exact_mut(SIDE_BY_SIDE)) {
            out.copy_from_slice(&prices_of(std::array::from_fn::<_, SIDE_BY_SIDE, _>(|i| pair(&edges[i]))));
        }
        let done = edges.len() - rest.len();
        rest.iter().zip(&mut out[done..]).for_each(|(edge, out)| *out = prices_of([pair(edge)])[0]);
    }
}

/// Numbers side by side.
#[derive(Clone, Copy)]
struct Lanes<const N: usize>([f64; N]);

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    fn of(get: impl Fn(usize) -> f32) -> Self {
        Self(std::array::from_fn(|i| f64::from(get(i))))
    }

    #[inline(always)]
    fn all(x: f64) -> Self {
        Self([x; N])
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    /// The lesser of each two; the first where one is not a number.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |x, y| if y < x { y } else { x })
    }
}

macro_rules! by_lane {
    ($($operation:ident $method:ident $operator:tt),*) => {$(
        impl<const N: usize> $operation for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |x, y| x $operator y)
            }
        }
    )*};
}
by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

/// Product of the symmetric matrix with upper triangle `a` and `x`.
#[inline(always)]
fn times<const N: usize>(a: &[Lanes<N>; 6], x: [Lanes<N>; 3]) -> [Lanes<N>; 3] {
    [
        a[0] * x[0] + a[1] * x[1] + a[2] * x[2],
        a[1] * x[0] + a[3] * x[1] + a[4] * x[2],
        a[2] * x[0] + a[4] * x[1] + a[5] * x[2],
    ]
}

#[inline(always)]
fn dot<const N: usize>(x: [Lanes<N>; 3], y: [Lanes<N>; 3]) -> Lanes<N> {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

/// The cost of [`Pair::placement`] for each of these pairs, every case of it computed for all.
#[inline(always)]
pub(super) fn prices_of<const N: usize>(pairs: [(&Node, &Node); N]) -> [f32; N] {
    let all = Lanes::<N>::all;
    let difference = |k: usize| Lanes::of(|i| pairs[i].1.position[k] - pairs[i].0.position[k]);
    let other: [Lanes<N>; 3] = std::array::from_fn(difference);
    let quadric_of_v = |k: usize| Lanes::of(|i| pairs[i].1.quadric.a[k]);
    let of_v: [Lanes<N>; 6] = std::array::from_fn(quadric_of_v);
    let there = times(&of_v, other);
    let b_of_v: [Lanes<N>; 3] = std::array::from_fn(|k| Lanes::of(|i| pairs[i].1.quadric.b[k]));
    let both: [Lanes<N>; 3] = std::array::from_fn(|k| there[k] + b_of_v[k] + b_of_v[k]);
    let a: [Lanes<N>; 6] = std::array::from_fn(|k| Lanes::of(|i| pairs[i].0.quadric.a[k]) + of_v[k]);
    let b: [Lanes<N>; 3] = std::array::from_fn(|k| Lanes::of(|i| pairs[i].0.quadric.b[k]) + (b_of_v[k] + there[k]));
    let c = Lanes::of(|i| pairs[i].0.quadric.c) + (Lanes::of(|i| pairs[i].1.quadric.c) + dot(both, other));

    let [xx, xy, xz, yy, yz, zz] = a;
    let (c0, c1, c2) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let determinant = xx * c0 + xy * c1 + xz * c2;
    let adjugate = [c0, c1, c2, xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy];
    let scaled = times(&adjugate, b);
    let lowest = (c - dot(b, scaled) / determinant).zip(all(0.0), f64::max);
    let trace = xx + yy + zz;
    let least_determinant = all(Quadric::SINGULAR) * trace * trace * trace;
    let half = all(0.5) * determinant;
    let from_middle: [Lanes<N>; 3] = std::array::from_fn(|k| scaled[k] - other[k] * half);
    let reach = all(REACH) * determinant;
    let within = reach * reach * dot(other, other) - dot(from_middle, from_middle);

    let (curvature, slope) = (dot(times(&a, other), other), dot(b, other));
    let gone = curvature - all(2.0) * slope + c;
    let middle = all(0.25) * curvature - slope + c;
    let best_other = c.min(gone).min(middle);
    std::array::from_fn(|i| {
        let has_minimum = determinant.0[i] > least_determinant.0[i] && within.0[i] >= 0.0;
        (if has_minimum { lowest.0[i] } else { best_other.0[i] }) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::closed::darts::Assignment;
    use crate::simplify::closed::placement::place;
    use crate::simplify::closed::surface::Surface;

    fn nodes(surface: &Surface) -> Vec<Node> {
        let placed = place(surface, &Assignment::identity(surface.n_vertices()), &[], &surface.faces);
        (0..surface.n_vertices() as u32).map(|v| Node::new(&placed, v, Span::default())).collect()
    }

    #[test]
    fn prices_are_what_the_placement_costs() {
        for mesh in [shapes::wavy_sphere(3, 10.0), shapes::cuboid([1.0; 3], 4), shapes::thin_sheet(9, 1e-3)] {
            let surface = Surface::new(&mesh);
            let nodes = nodes(&surface);
            let edges: Vec<[u32; 2]> = surface.faces.iter().map(|&[a, b, _]| [a, b]).collect();
            let scale: f32 = nodes.iter().map(|node| node.quadric.a[0] + node.quadric.a[3] + node.quadric.a[5]).sum();
            for (&[u, v], price_of_many) in edges.iter().zip(prices(&nodes, &edges)) {
                let (u, v) = (&nodes[u as usize], &nodes[v as usize]);
                assert_eq!(price(u, v).to_bits(), price_of_many.to_bits());
                let naive = Pair::new(u, v).placement().2 as f32;
                assert!((price_of_many - naive).abs() <= 1e-4 * naive + 1e-9 * scale, "{price_of_many} {naive}");
            }
        }
    }
}
