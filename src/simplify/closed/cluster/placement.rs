//! Where the vertex of each region goes: the minimum of its plane quadrics, kept near the region.
//!
//! Quadrics alone are singular on flat parts, so they carry a small pull toward the region's vertices; a minimum far
//! outside the region is pulled harder, and one that would turn a face over gives way to a vertex of the input.

use glam::DVec3;
use rayon::prelude::*;

use crate::geometry::Quadric;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::OneRings;
use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::mesh::shares::add_to_rows;

use super::assignment::Assignment;
use super::importance;
use super::sums::Sum;
use crate::simplify::closed::prepare::surface::{Neighbour, Surface, planes_around};

/// Weight of the distance to the region's vertices against that to its planes, which say nothing along a flat part.
/// Sixteen training meshes at ratios 0.05 to 0.5: at 1e-5 the mean distance is 1.6 % farther, the largest 3 %; at 1e-7
/// 0.2 % nearer.
pub const PULL: f32 = 1e-6;
/// The same where the minimum lies far outside the region. Twelve large training meshes at ratios 0.03 to 0.15: at 1e-4
/// and 1e-2 the mean distance is the same, the largest 1 to 2 % farther.
pub const FIRM_PULL: f64 = 1e-3;
/// How far outside is far, in standard deviations of the region's vertices. Twelve large training meshes at ratios 0.03
/// to 0.15: the mean distance is the same at 2 and at 8, the largest 2 % farther at 8.
const FAR: f64 = 4.0;
/// How often regions at the corners of turned faces are placed anew. Twelve large training meshes at ratios 0.03 to
/// 0.15: without, 35 faces of the results are turned and not 9, and the largest distance is 4 % farther; after one
/// round 10 are, after four 9.
const ROUNDS: usize = 2;

/// How the vertex of a region was placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Case {
    /// At the minimum of its planes.
    Minimum,
    /// At the minimum with the harder pull.
    Firm,
    /// This far from the mean of its vertices, where that minimum lies too far outside.
    Offset(DVec3),
    /// At a vertex of the input.
    Vertex(u32),
}

/// A vertex per region.
pub struct Placement<'a> {
    /// Positions, n_regions x 3; empty where every vertex is one and stays where it is.
    positions: Vec<DVec3>,
    /// The planes around the vertices, n_regions; empty where every vertex is one.
    planes: Vec<[f32; 6]>,
    /// How much more than its area each counts, n_regions; empty where every vertex is one, or all count alike.
    importance: Vec<f32>,
    surface: &'a Surface<'a>,
    /// The sums of the regions; empty where every vertex is one.
    sums: &'a [Sum],
}

impl<'a> Placement<'a> {
    /// Vertices at these places, whose planes are not summed yet.
    pub fn new(surface: &'a Surface<'a>, places: Places, sums: &'a [Sum]) -> Self {
        let sums = if places.positions.is_empty() { &[] } else { sums };
        Self { positions: places.positions, planes: Vec::new(), importance: Vec::new(), surface, sums }
    }

    /// Who listens.
    pub fn pulse(&self) -> Pulse<'_> {
        self.surface.pulse
    }

    /// Whether the planes are the surface's: every vertex is a region.
    pub fn is_of_surface(&self) -> bool {
        self.planes.is_empty()
    }

    /// Where the vertex of a region is.
    pub fn position(&self, region: u32) -> DVec3 {
        let own = || self.surface.positions[region as usize].as_dvec3();
        self.positions.get(region as usize).copied().unwrap_or_else(own)
    }

    /// Puts the vertex of each of these regions where a vertex of the surface is that lies in it.
    pub fn move_to_vertices(&mut self, vertices: impl Iterator<Item = (u32, u32)>) {
        for (region, v) in vertices {
            let place = self.surface.positions[v as usize].as_dvec3();
            self.positions.get_mut(region as usize).into_iter().for_each(|position| *position = place);
        }
    }

    /// Sums the planes around the vertices over the faces of the quotient, which has these rings; nothing where every vertex is
    /// one, as those are the surface's.
    pub fn sum_planes(&mut self, rings: &OneRings, assignment: &Assignment) {
        if assignment.n_regions == self.surface.n_vertices() {
            return;
        }
        let importance = importance::of_regions(self.surface, assignment);
        let place = |r: u32| self.position(r).as_vec3();
        let neighbour = |&r: &u32| {
            if (r as usize) < assignment.n_regions { Neighbour::At(place(r)) } else { Neighbour::Ghost }
        };
        let planes = |r: usize| planes_around(place(r as u32), rings.ring(r as u32).iter().map(neighbour));
        let mut all: Vec<[f32; 6]> = self.surface.pulse.map_numbers(assignment.n_regions, planes);
        for (r, planes) in all.iter_mut().enumerate() {
            let factor = importance.get(r).copied().unwrap_or(1.0);
            *planes = pulled(planes.map(|entry| entry * factor));
        }
        (self.planes, self.importance) = (all, importance);
    }

    /// The planes around the vertex of a region, an upper triangle about it.
    pub fn planes(&self, region: u32) -> [f32; 6] {
        let own = || pulled(self.surface.quadrics[region as usize]);
        self.planes.get(region as usize).copied().unwrap_or_else(own)
    }

    /// How much more than its area the vertex of a region counts.
    pub fn importance(&self, region: u32) -> f32 {
        let importance = if self.planes.is_empty() { &self.surface.importance } else { &self.importance };
        importance.get(region as usize).copied().unwrap_or(1.0)
    }

    /// The plane quadric of a region.
    pub fn quadric(&self, region: u32) -> Quadric {
        let pull = f64::from(PULL);
        match self.sums.get(region as usize) {
            Some(sum) => sum.quadric(pull),
            None => Sum::of(self.surface, region as usize).quadric(pull),
        }
    }
}

/// Where the vertices of the regions lie, of which the sums are given and the faces of the quotient.
#[derive(Default)]
pub struct Places {
    /// Positions, n_regions x 3; empty where every vertex is one and stays where it is.
    pub positions: Vec<DVec3>,
    /// Regions at the corners of faces that look away from what they stand for, wherever their vertices lie.
    pub turned: Vec<u32>,
}

impl Places {
    /// At the minima of the planes, and at vertices of the input where these would turn faces over.
    pub fn new(surface: &Surface, assignment: &Assignment, sums: &[Sum], faces: &[[u32; 3]]) -> Self {
        if assignment.n_regions == surface.n_vertices() {
            return Self::default();
        }
        let best = |sum: &Sum| best_position(&sum.quadric(f64::from(PULL)), sum).1;
        let mut positions: Vec<DVec3> = surface.pulse.map(sums, best);
        let mut turned = turned_regions(surface, &positions, sums, faces);
        for _ in 0..ROUNDS {
            if turned.is_empty() {
                break;
            }
            let mut has_turned = vec![false; sums.len()];
            turned.iter().for_each(|&r| has_turned[r as usize] = true);
            let safe = central_vertices(surface, assignment, sums, |r| has_turned[r as usize]);
            for r in turned {
                positions[r as usize] = surface.positions[safe[r as usize] as usize].as_dvec3();
            }
            turned = turned_regions(surface, &positions, sums, faces);
        }
        Self { positions, turned }
    }
}

/// Planes with a small pull to their vertex, which they say nothing about along a flat part: upper triangles.
#[inline(always)]
pub fn pulled(planes: [f32; 6]) -> [f32; 6] {
    drawn(planes, 0.0)
}

/// The same, drawn to their vertex the more the more they weigh.
#[inline(always)]
pub fn drawn(mut planes: [f32; 6], bend: f32) -> [f32; 6] {
    let weight = planes[0] + planes[3] + planes[5];
    let pull = (PULL + bend * weight) * weight;
    [0, 3, 5].into_iter().for_each(|diagonal| planes[diagonal] += pull);
    planes
}

/// How [`Places`] came to these positions.
pub fn cases(assignment: &Assignment, placed: &Placement) -> Vec<Case> {
    let Placement { positions, surface, sums, .. } = placed;
    if assignment.n_regions == surface.n_vertices() {
        return (0..surface.n_vertices() as u32).map(Case::Vertex).collect();
    }
    let safe = central_vertices(surface, assignment, sums, |_| true);
    let case = |r: usize| {
        let (case, x) = best_position(&sums[r].quadric(f64::from(PULL)), &sums[r]);
        if x == positions[r] { case } else { Case::Vertex(safe[r]) }
    };
    (0..assignment.n_regions).map(case).collect()
}

/// Moves the vertex of each region to the one of the region's own vertices that costs least; returns which these are.
pub fn to_own_vertices(surface: &Surface, assignment: &Assignment, placed: &mut Placement) -> Vec<u32> {
    let mut best = vec![(f64::INFINITY, 0); assignment.n_regions];
    for (v, &r) in assignment.region.iter().enumerate() {
        let cost = placed.quadric(r).value(surface.positions[v].as_dvec3());
        if cost < best[r as usize].0 {
            best[r as usize] = (cost, v as u32);
        }
    }
    let best: Vec<u32> = best.into_iter().map(|(_, v)| v).collect();
    placed.move_to_vertices((0u32..).zip(best.iter().copied()));
    best
}

fn best_position(quadric: &Quadric, sum: &Sum) -> (Case, DVec3) {
    let mean = sum.mean();
    let far = FAR * FAR * sum.variance();
    if let Some((x, _)) = quadric.minimum().filter(|(x, _)| x.distance_squared(mean) <= far) {
        return (Case::Minimum, x);
    }
    let firm = quadric.pulled_to(mean, FIRM_PULL * quadric.trace());
    let Some((x, _)) = firm.minimum() else { return (Case::Offset(DVec3::ZERO), mean) };
    let offset = (x - mean).clamp_length_max(far.sqrt());
    (if offset == x - mean { Case::Firm } else { Case::Offset(offset) }, mean + offset)
}

/// For each region that is wanted its vertex nearest to the mean.
fn central_vertices(
    surface: &Surface,
    assignment: &Assignment,
    sums: &[Sum],
    is_wanted: impl Fn(u32) -> bool + Sync,
) -> Vec<u32> {
    let mut nearest = vec![(f64::INFINITY, 0); sums.len()];
    add_to_rows(surface.pulse, &mut nearest, &assignment.region, |best, v| {
        let r = assignment.region[v];
        if is_wanted(r) {
            let distance = surface.positions[v].as_dvec3().distance_squared(sums[r as usize].mean());
            *best = if distance < best.0 { (distance, v as u32) } else { *best };
        }
    });
    nearest.into_iter().map(|(_, v)| v).collect()
}

/// The regions at the corners of faces that look away from what they stand for.
fn turned_regions(surface: &Surface, positions: &[DVec3], sums: &[Sum], faces: &[[u32; 3]]) -> Vec<u32> {
    let turned = |face: &&[u32; 3]| {
        let normal = area_normal_f64(face.map(|r| positions[r as usize]));
        let meant: DVec3 = face.iter().map(|&r| sums[r as usize].normal.normalize_or_zero()).sum();
        normal.dot(meant) <= 0.0
    };
    let mut all: Vec<&[u32; 3]> = Vec::new();
    for faces in surface.pulse.over(faces) {
        all.par_extend(faces.par_iter().with_min_len(PARALLEL).filter(turned));
    }
    all.into_iter().flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::closed::cluster::sums::sums;
    use glam::Vec3;

    fn placed<'a>(surface: &'a Surface<'a>, assignment: &Assignment, sums: &'a [Sum]) -> Placement<'a> {
        Placement::new(surface, Places::new(surface, assignment, sums, &[]), sums)
    }

    #[test]
    fn three_sides_meet_at_the_corner() {
        let mesh = shapes::cuboid([1.0; 3], 8);
        let surface = Surface::new(&mesh, Pulse::NONE);
        let near = |p: &[f32; 3]| p.iter().all(|&x| x <= 0.25);
        let region = mesh.positions().iter().map(|p| u32::from(!near(p))).collect();
        let assignment = Assignment { region, n_regions: 2, samples: Vec::new() };
        let sums = sums(&surface, &assignment);
        let places = placed(&surface, &assignment, &sums);
        let corner = surface.scale.restore(places.position(0));
        assert!(Vec3::from(corner).length() < 1e-3, "{corner:?}");
    }

    #[test]
    fn a_region_in_a_plane_goes_to_its_middle_and_a_vertex_stays() {
        let mesh = shapes::grid(10, 10);
        let surface = Surface::new(&mesh, Pulse::NONE);
        let within = |p: &[f32; 3]| (0.25..0.75).contains(&p[0]) && (0.25..0.75).contains(&p[1]);
        let region = mesh.positions().iter().map(|p| u32::from(!within(p))).collect();
        let assignment = Assignment { region, n_regions: 2, samples: Vec::new() };
        let sums = sums(&surface, &assignment);
        let places = placed(&surface, &assignment, &sums);
        let middle = Vec3::from(surface.scale.restore(places.position(0)));
        assert!(middle.distance(Vec3::new(0.5, 0.5, 0.0)) < 1e-3, "{middle}");
        let places = placed(&surface, &Assignment::identity(surface.n_vertices()), &[]);
        assert!((0u32..).zip(&surface.positions).all(|(v, p)| places.position(v).as_vec3() == *p));
    }
}
