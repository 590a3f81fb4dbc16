//! Parts that cost more than they show: which go, so that the others have their vertices.
//!
//! That a part goes is a merge like others, with a price: its area times the squared distance from what stays, for each vertex that
//! it frees. It goes where that is less than what the last merges cost, were the vertices of all that went left to the others: what
//! they cost when the collapse had so many more.
//!
//! At a fifth of that price four assemblies are up to 14 % nearer in the mean at coarse ratios, but what is dropped then shows: the
//! largest distance of `ogre`, 44 parts, is three times as far for a mean distance 2 % nearer.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec3;

use crate::geometry::triangle::area_normal;
use crate::mesh::Role;
use crate::mesh::pulse::Pulse;
use crate::mesh::union_find::UnionFind;
use crate::simplify::limits::Limit;
use crate::spatial::NearestOnTriangles;

use super::original::Original;
use super::output::Output;
use super::request::Shown;

/// Points of a part at most that tell how far it lies from what stays.
const POINTS: usize = 64;

/// What vertices cost at the end of a collapse.
pub struct Cost<'a> {
    /// How many vertices rounds of merges left, falling, and up to which price each went.
    pub paid: &'a [(usize, f32)],
    /// The size asked for.
    pub limit: Limit,
    /// Whether parts have to go for it: each is as small as its topology allows.
    pub must_fit: bool,
}

impl Cost<'_> {
    /// What the merges down to so many vertices cost. Beyond what was seen: the squared distances of n vertices fall as n^-2, what one
    /// more is worth as n^-3.
    fn down_to(&self, vertices: usize) -> f64 {
        let seen = self.paid.iter().take_while(|(left, _)| *left >= vertices).map(|(_, price)| f64::from(*price));
        let first = self.paid.first().map(|&(left, price)| f64::from(price) * (left as f64 / vertices as f64).powi(3));
        seen.reduce(f64::max).or(first).unwrap_or_default()
    }
}

/// Parts that go.
pub struct Gone {
    /// Whether each face of the mesh goes.
    pub faces: Vec<bool>,
    /// How many parts go.
    pub n_parts: usize,
}

/// The parts that go for others to have their vertices, none that lies farther than `within` from what stays, in the unit of the
/// mesh; `None` where all stay.
pub fn gone(original: &Original, output: &Output, cost: &Cost, within: f64, shown: &Shown) -> Option<Gone> {
    let (part_of_vertex, n_parts) = parts_of(output);
    if n_parts < 2 {
        return None;
    }
    let faces = &original.surface.faces;
    let part_of_face: Vec<u32> =
        faces.iter().map(|face| part_of_vertex[output.vertex_of[face[0] as usize] as usize]).collect();
    let parts = Parts::new(original, output, &part_of_vertex, &part_of_face, n_parts, shown);
    let within = original.surface.length(within as f32);
    let gone = parts.going(cost, within);
    let n_gone = gone.iter().filter(|gone| **gone).count();
    (n_gone > 0)
        .then(|| Gone { faces: part_of_face.iter().map(|&part| gone[part as usize]).collect(), n_parts: n_gone })
}

/// The part of each output vertex, where there are several, and how many there are.
pub fn parts_of(output: &Output) -> (Vec<u32>, usize) {
    parts(output.positions.len(), output.faces())
}

/// The part of each of so many vertices, where there are several, and how many there are.
pub fn parts(n_vertices: usize, faces: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut sets = UnionFind::new(n_vertices);
    for &[a, b, c] in faces {
        sets.union(a, b);
        sets.union(b, c);
    }
    if sets.sets() == 1 {
        return (Vec::new(), 1);
    }
    sets.numbered(Pulse::NONE)
}

/// A part of a surface.
#[derive(Clone)]
struct Part {
    n_vertices: usize,
    n_faces: usize,
    /// Of the original, and of the parts for which this one stands in, as it counts.
    area: f64,
    /// The box of the original.
    low: Vec3,
    high: Vec3,
    /// The group of its faces, where they have one.
    group: Option<u32>,
    /// Its area times the squared distance from what stays, were it gone.
    loss: f64,
    /// The part that would stand in for it.
    stand_in: usize,
}

/// The parts of a surface, and how to tell what stands near them.
struct Parts<'a> {
    parts: Vec<Part>,
    /// By area, the smallest first: the place of each.
    rank: Vec<usize>,
    original: &'a Original<'a>,
    /// The faces of the original, part by part, and where those of each end.
    faces: Vec<u32>,
    ends: Vec<usize>,
    /// The output's faces.
    tree: NearestOnTriangles,
    /// The part of each of them.
    part_of_output: Vec<u32>,
    /// Whether corners carry what shows.
    is_painted: bool,
}

impl<'a> Parts<'a> {
    fn new(
        original: &'a Original,
        output: &Output,
        part_of_vertex: &[u32],
        part_of_face: &[u32],
        n_parts: usize,
        shown: &Shown,
    ) -> Self {
        let mut parts = sums(original, part_of_face, n_parts, shown);
        part_of_vertex.iter().for_each(|&part| parts[part as usize].n_vertices += 1);
        let part_of_output: Vec<u32> = output.faces().iter().map(|face| part_of_vertex[face[0] as usize]).collect();
        part_of_output.iter().for_each(|&part| parts[part as usize].n_faces += 1);
        let mut by_area: Vec<usize> = (0..n_parts).collect();
        by_area.sort_by(|&x, &y| parts[x].area.total_cmp(&parts[y].area).then(x.cmp(&y)));
        let mut rank = vec![0; n_parts];
        by_area.iter().enumerate().for_each(|(place, &part)| rank[part] = place);
        let (faces, ends) = by_part(part_of_face, n_parts);
        let tree = output.tree();
        let shows = |role: Role| matches!(role, Role::Uv | Role::Colour);
        let is_painted =
            shown.attributes.is_some_and(|attributes| attributes.channels.iter().any(|channel| shows(channel.role)));
        let mut all = Self { parts, rank, original, faces, ends, tree, part_of_output, is_painted };
        for part in by_area {
            (all.parts[part].loss, all.parts[part].stand_in) = all.loss(part);
        }
        all
    }

    /// The faces of the original that a part has.
    fn faces(&self, part: usize) -> &[u32] {
        let start = if part == 0 { 0 } else { self.ends[part - 1] };
        &self.faces[start..self.ends[part]]
    }

    /// The squared distance of a point of a part from the larger ones, and which of them is nearest.
    fn nearest(&self, part: usize, point: Vec3) -> Option<(f64, usize)> {
        let rank = self.rank[part];
        let is_larger = |face: u32| self.rank[self.part_of_output[face as usize] as usize] > rank;
        let hit = self.tree.nearest_of(point.as_dvec3(), is_larger)?;
        Some((hit.distance2, self.part_of_output[hit.triangle as usize] as usize))
    }

    /// What is lost with a part, by points on its faces, and the part that is nearest to most of them.
    fn loss(&self, part: usize) -> (f64, usize) {
        let faces = self.faces(part);
        let own = &self.parts[part];
        let (mut sum, mut areas, mut nearest) = (0.0, 0.0, Vec::new());
        for &face in faces.iter().step_by(faces.len().div_ceil(POINTS).max(1)) {
            let corners = self.corners(face);
            let Some((distance2, other)) = self.nearest(part, corners.iter().sum::<Vec3>() / 3.0) else {
                return (f64::INFINITY, part);
            };
            // What looks otherwise does not stand in for it: it is as far as it is large.
            let looks_same = !self.is_painted && own.group.is_some() && own.group == self.parts[other].group;
            let least = if looks_same { 0.0 } else { 0.25 * f64::from(own.low.distance_squared(own.high)) };
            let area = f64::from(area_normal(corners).length());
            sum += area * distance2.max(least);
            areas += area;
            nearest.push(other);
        }
        nearest.sort_unstable();
        let most = nearest.chunk_by(|a, b| a == b).max_by_key(|same| same.len()).map_or(part, |same| same[0]);
        (if areas > 0.0 { own.area * sum / areas } else { 0.0 }, most)
    }

    fn corners(&self, face: u32) -> [Vec3; 3] {
        self.original.surface.faces[face as usize].map(|v| self.original.surface.positions[v as usize])
    }

    /// Whether all of a part lies near a larger one.
    fn is_within(&self, part: usize, within: f32) -> bool {
        let is_near = |point: Vec3| {
            self.nearest(part, point).is_some_and(|(distance2, _)| distance2 <= f64::from(within) * f64::from(within))
        };
        within.is_infinite() || self.faces(part).iter().flat_map(|&face| self.corners(face)).all(is_near)
    }

    /// Whether each part goes.
    fn going(mut self, cost: &Cost, within: f32) -> Vec<bool> {
        let price = |part: &Part| (part.loss / part.n_vertices.max(1) as f64).to_bits();
        let mut gone = vec![false; self.parts.len()];
        let n_whole: usize = self.parts.iter().map(|part| part.n_vertices).sum();
        let mut n_vertices = n_whole;
        let mut n_faces: usize = self.parts.iter().map(|part| part.n_faces).sum();
        let mut queue: BinaryHeap<Reverse<(u64, usize)>> =
            self.parts.iter().enumerate().map(|(i, part)| Reverse((price(part), i))).collect();
        while let Some(Reverse((bits, i))) = queue.pop() {
            let part = self.parts[i].clone();
            let is_largest = part.stand_in == i;
            if gone[i] || bits != price(&part) || is_largest {
                continue;
            }
            let share = |n: usize, limit: usize| n as f64 / limit as f64;
            let size = share(n_vertices, cost.limit.vertices).max(share(n_faces, cost.limit.faces));
            let n_of_others = n_whole.min(cost.limit.vertices) + (n_whole - n_vertices);
            let is_worth = f64::from_bits(bits) >= cost.down_to(n_of_others);
            if is_worth && (size <= 1.0 || !cost.must_fit) {
                break;
            }
            if !self.is_within(i, within) {
                continue;
            }
            gone[i] = true;
            (n_vertices, n_faces) = (n_vertices - part.n_vertices, n_faces - part.n_faces);
            let other = &mut self.parts[part.stand_in];
            // Of two without area none shows.
            if other.area > 0.0 {
                other.loss *= (other.area + part.area) / other.area;
            }
            other.area += part.area;
            queue.push(Reverse((price(other), part.stand_in)));
        }
        gone
    }
}

/// Areas, boxes and groups of the parts.
fn sums(original: &Original, part_of_face: &[u32], n_parts: usize, shown: &Shown) -> Vec<Part> {
    let none = Part {
        n_vertices: 0,
        n_faces: 0,
        area: 0.0,
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
        group: None,
        loss: 0.0,
        stand_in: 0,
    };
    let mut parts = vec![none; n_parts];
    let group = |face: u32| shown.attributes.map_or(0, |attributes| attributes.group(face));
    let factor = |v: &u32| original.surface.importance.get(*v as usize).copied().unwrap_or(1.0);
    let counts = |face: &[u32; 3]| if shown.is_weighed { face.iter().map(factor).sum::<f32>() / 3.0 } else { 1.0 };
    for ((f, face), &part) in (0..).zip(original.surface.faces.iter()).zip(part_of_face) {
        let part = &mut parts[part as usize];
        let corners = face.map(|v| original.surface.positions[v as usize]);
        let is_first = part.area == 0.0 && part.low.x == f32::INFINITY;
        part.group = if is_first { Some(group(f)) } else { part.group.filter(|&own| own == group(f)) };
        part.area += 0.5 * f64::from(area_normal(corners).length() * counts(face));
        part.low = corners.into_iter().fold(part.low, Vec3::min);
        part.high = corners.into_iter().fold(part.high, Vec3::max);
    }
    parts
}

/// The faces, part by part, and where those of each end.
fn by_part(part_of_face: &[u32], n_parts: usize) -> (Vec<u32>, Vec<usize>) {
    let mut ends = vec![0; n_parts];
    part_of_face.iter().for_each(|&part| ends[part as usize] += 1);
    let mut n = 0;
    ends.iter_mut().for_each(|end| {
        n += *end;
        *end = n;
    });
    let mut starts: Vec<usize> = std::iter::once(0).chain(ends.iter().copied()).collect();
    let mut faces = vec![0; part_of_face.len()];
    for (f, &part) in (0..).zip(part_of_face) {
        faces[starts[part as usize]] = f;
        starts[part as usize] += 1;
    }
    (faces, ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, TriMesh, shapes};
    use crate::simplify::closed::pins::Pins;

    /// A sphere of radius 1, and a smaller one at `x` of radius `r` with 12 vertices.
    fn spheres(x: f32, r: f32) -> TriMesh {
        let (large, small) = (shapes::icosphere(3), shapes::icosphere(0));
        let n = large.positions().len() as u32;
        let moved = small.positions().iter().map(|p| [r * p[0] + x, r * p[1], r * p[2]]);
        let faces = small.faces().iter().map(|face| face.map(|v| v + n));
        let positions = large.positions().iter().copied().chain(moved).collect();
        TriMesh::new(positions, large.faces().iter().copied().chain(faces).collect()).unwrap()
    }

    /// What goes of a mesh that was not simplified, where merges cost `paid` and so many vertices are asked for.
    fn going(mesh: &TriMesh, paid: f64, vertices: usize, within: f64, attributes: Option<&Attributes>) -> Option<Gone> {
        let original = Original::bare(mesh);
        let surface = &original.surface;
        let vertex_of = (0..surface.n_vertices() as u32).collect();
        let (positions, faces) = (surface.positions.clone(), surface.faces.to_vec());
        let output = Output::new(Pulse::NONE, positions, faces, Pins::default(), vertex_of);
        let limit = Limit::of_vertices(vertices);
        let paid = [(mesh.positions().len() + 50, paid as f32)];
        let shown = Shown { attributes, is_weighed: false };
        gone(&original, &output, &Cost { paid: &paid, limit, must_fit: false }, within, &shown)
    }

    /// The price from which on the small sphere goes.
    fn price(mesh: &TriMesh, attributes: Option<&Attributes>) -> f64 {
        let n = mesh.positions().len();
        let goes = |paid: f64| going(mesh, paid, n, f64::INFINITY, attributes).is_some();
        let (mut low, mut high) = (1e-30f64, 1e3f64);
        assert!(!goes(low) && goes(high));
        while high / low > 1.001 {
            let middle = (low * high).sqrt();
            *(if goes(middle) { &mut high } else { &mut low }) = middle;
        }
        high
    }

    #[test]
    fn a_part_goes_for_its_area_times_its_squared_distance() {
        // Twice the size: four times the area, at the same distance of its middle about the same.
        let [one, two] = [0.01, 0.02].map(|r| price(&spheres(3.0, r), None));
        assert!((3.9..4.1).contains(&(two / one)), "{}", two / one);
        let [near, far] = [3.0, 5.0].map(|x| {
            let mesh = spheres(x, 0.01);
            price(&mesh, None) / f64::from(Original::bare(&mesh).surface.length(1.0)).powi(4)
        });
        // At distances of 2 and 4, in the unit of the mesh.
        assert!((3.8..4.2).contains(&(far / near)), "{}", far / near);
    }

    #[test]
    fn what_looks_otherwise_is_as_far_as_it_is_large() {
        let mesh = spheres(0.95, 0.02);
        let n = shapes::icosphere(3).faces().len();
        let groups = |other| (0..mesh.faces().len()).map(|f| if f < n { 1 } else { other }).collect();
        let [same, other] = [1, 2].map(|group| Attributes { groups: groups(group), ..Attributes::default() });
        assert_eq!(price(&mesh, Some(&same)), price(&mesh, None));
        assert!(price(&spheres(1.0, 0.02), Some(&other)) > 2.0 * price(&spheres(1.0, 0.02), None));
    }

    #[test]
    fn nothing_goes_that_lies_too_far() {
        let mesh = spheres(3.0, 0.01);
        let n = mesh.positions().len();
        assert!(going(&mesh, 1e3, n, 1.9, None).is_none());
        let gone = going(&mesh, 1e3, n, 2.1, None).unwrap();
        let large = shapes::icosphere(3).faces().len();
        assert!(gone.n_parts == 1 && gone.faces.iter().enumerate().all(|(f, gone)| *gone == (f >= large)));
    }

    #[test]
    fn the_largest_part_stays_whatever_it_costs() {
        let boxes = shapes::many_boxes(94);
        let gone = going(&boxes, 1e30, 8, f64::INFINITY, None).unwrap();
        assert_eq!((gone.n_parts, gone.faces.iter().filter(|gone| !**gone).count()), (93, boxes.faces().len() / 94));
        assert!(going(&shapes::icosphere(2), 1e30, 4, f64::INFINITY, None).is_none());
        // Nor does the last where none has any area.
        let lines = shapes::many_boxes(9);
        let flat = lines.positions().iter().map(|p| [p[0], 0.0, 0.0]).collect();
        let gone = going(&TriMesh::new(flat, lines.faces().to_vec()).unwrap(), 1.0, 8, f64::INFINITY, None).unwrap();
        assert_eq!(gone.n_parts, 8);
    }
}
