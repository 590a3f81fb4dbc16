//! Flips: where the other diagonal of two faces lies nearer to the original surface, it takes the edge's place.
//!
//! Points of the original that belong to the two faces tell which diagonal is better: the sum of their squared heights
//! over the faces. Borders stay, and so does every edge whose other diagonal exists already or would turn a face over:
//! the surface stays what it is.

use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::simplify::closed::attributes::corners::Corners;
use crate::simplify::closed::collapse::Remains;
use crate::simplify::closed::refine::diamond::{Diamond, diamonds};
use crate::simplify::closed::refine::faces_around::FacesAround;
use crate::simplify::closed::refine::facets::{Facet, Facets};
use crate::simplify::closed::refine::points::{Match, Points};

/// Squared heights over the other two faces, over those over the two faces, below which a flip pays.
const GAIN: f32 = 0.6;
/// Squared heights over the two faces, over the mean of a face, below which no flip is looked for.
const LEAST_ERROR: f32 = 0.25;
/// Least cosine between the faces' normals before and after.
const LEAST_COSINE: f32 = 0.5;
/// Cosine between the two faces above which their diagonals hardly differ.
const FLAT: f32 = 0.998;

/// Flips edges of the faces, best gains first, each face once; returns how many were flipped.
pub fn flip(points: &mut Points, remains: &mut Remains, mut corners: Option<&mut Corners>) -> usize {
    let Remains { positions, faces, normals, on_plane, .. } = remains;
    let on_plane = on_plane.as_ref();
    let bridges = |c: u32, d: u32| on_plane.is_some_and(|on_plane| on_plane.has(c) && on_plane.has(d));
    let around = FacesAround::new(positions.len(), faces);
    let facets = Facets::new(positions, faces, &around);
    let weighed = PointsOfFaces::new(points, &facets, faces.len());
    let rate = |f: u32| {
        let later = diamonds(faces, &around, f).filter(move |diamond| diamond.faces[1] > f);
        later.filter_map(|diamond| {
            let meant = diamond.faces.map(|f| normals[f as usize]);
            Some((weighed.gain(&facets, positions, &diamond, meant)?, diamond))
        })
    };
    let mut worthwhile: Vec<(f32, Diamond)> = (0..faces.len() as u32).into_par_iter().flat_map_iter(rate).collect();
    worthwhile.sort_unstable_by(|x, y| y.0.total_cmp(&x.0).then(x.1.faces.cmp(&y.1.faces)));
    let mut touched = vec![false; faces.len()];
    let mut made: FxHashSet<[u32; 2]> = FxHashSet::default();
    let mut n_flipped = 0;
    for (_, diamond) in worthwhile {
        let Diamond { faces: [f, g], corners: [a, b, c, d] } = diamond;
        let is_seam = corners.as_ref().is_some_and(|corners| corners.is_seam(faces, [f, g], [a, b]));
        let (f, g) = (f as usize, g as usize);
        let is_held = is_seam || bridges(c, d);
        if !is_held && !touched[f] && !touched[g] && !around.joins(c, d) && made.insert([c.min(d), c.max(d)]) {
            corners.iter_mut().for_each(|corners| corners.flip(faces, [f as u32, g as u32], [a, b, c, d]));
            [faces[f], faces[g]] = diamond.flipped();
            normals[f] = (normals[f] + normals[g]).normalize_or_zero();
            normals[g] = normals[f];
            (touched[f], touched[g]) = (true, true);
            n_flipped += 1;
        }
    }
    n_flipped
}

/// A point of the original and its area.
#[derive(Clone, Copy, Default)]
struct Weighed {
    at: Vec3,
    area: f32,
}

/// The points of each face as compressed rows.
struct PointsOfFaces {
    starts: Vec<u32>,
    points: Vec<Weighed>,
    /// Sums of squared heights, times areas, over the faces.
    errors: Vec<f32>,
    /// The errors of two faces below which no flip is looked for.
    least_error: f32,
}

impl PointsOfFaces {
    fn new(points: &mut Points, facets: &Facets, n_faces: usize) -> Self {
        let mut starts = vec![0u32; n_faces + 2];
        let mut errors = vec![0.0; n_faces];
        let mut found: Vec<(u32, u32, f32)> = Vec::new();
        points.place(facets, |matches| {
            for Match { point, area, place } in matches.iter().flatten() {
                starts[place.face as usize + 2] += 1;
                errors[place.face as usize] += area * place.height * place.height;
                found.push((place.face, *point, *area));
            }
        });
        (2..starts.len()).for_each(|f| starts[f] += starts[f - 1]);
        let mut weighed = vec![Weighed::default(); found.len()];
        for (face, point, area) in found {
            let slot = &mut starts[face as usize + 1];
            weighed[*slot as usize] = Weighed { at: points.position(point), area };
            *slot += 1;
        }
        let mean = errors.iter().map(|&error| f64::from(error)).sum::<f64>() / n_faces as f64;
        Self { starts, points: weighed, errors, least_error: LEAST_ERROR * mean as f32 }
    }

    fn of(&self, face: u32) -> &[Weighed] {
        &self.points[self.starts[face as usize] as usize..self.starts[face as usize + 1] as usize]
    }

    /// How much nearer to the points the other two faces lie (sum of squared heights times areas), if that is enough.
    fn gain(&self, facets: &Facets, positions: &[Vec3], diamond: &Diamond, meant: [Vec3; 2]) -> Option<f32> {
        let before: f32 = diamond.faces.iter().map(|&f| self.errors[f as usize]).sum();
        if before < self.least_error {
            return None;
        }
        let old = diamond.faces.map(|f| facets.normal(f));
        if old[0].dot(old[1]) > FLAT {
            return None;
        }
        let [a, b, c, d] = diamond.corners;
        let like = |n: Vec3, m: Vec3| n.dot(m) > LEAST_COSINE;
        let new = [[c, d, b], [d, c, a]].map(|face| Facet::new(face.map(|v| positions[v as usize])));
        if new.iter().any(|n| old.iter().chain(&meant).any(|m| !like(n.normal, *m))) {
            return None;
        }
        let points = diamond.faces.iter().flat_map(|&f| self.of(f));
        let heights = points.map(|point| {
            let heights = [new[0].height(point.at), new[1].height(point.at)];
            let height = if new[0].weights(point.at)[2] < 0.0 { heights[1] } else { heights[0] };
            point.area * height * height
        });
        let after: f32 = heights.sum();
        (after < GAIN * before).then_some(before - after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle::area_normal;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::prepare::surface::Surface;

    /// A gentle roof with its ridge along y, 16 x 16 quads: vertex 17 i + j at x = i / 16, y = j / 16.
    fn roof() -> TriMesh {
        let flat = shapes::grid(16, 16);
        let places = flat.positions().iter().map(|&[x, y, _]| [x, y, -0.5 * (x - 0.5).abs()]).collect();
        TriMesh::new(places, flat.faces().to_vec()).unwrap()
    }

    /// Two faces over a diagonal: the corners are vertices of the roof.
    fn two_faces(surface: &Surface, corners: [u32; 4]) -> (Vec<u32>, Remains) {
        let positions = corners.map(|v| surface.positions[v as usize]).to_vec();
        let nearest = |p: &Vec3| {
            let distance = |&v: &usize| positions[v].distance_squared(*p);
            (0..4).min_by(|x, y| distance(x).total_cmp(&distance(y))).unwrap() as u32
        };
        let vertex_of: Vec<u32> = surface.positions.iter().map(nearest).collect();
        let faces = vec![[0, 1, 2], [1, 0, 3]];
        let normals = faces.iter().map(|f: &[u32; 3]| area_normal(f.map(|v| positions[v as usize])).normalize());
        let normals = normals.collect();
        let (fixed, origins, on_plane) = (Vec::new(), Vec::new(), None);
        (vertex_of.clone(), Remains { positions, faces, normals, vertex_of, fixed, origins, on_plane })
    }

    #[test]
    fn a_diagonal_across_the_ridge_turns_to_run_along_it() {
        let roof = roof();
        let surface = Surface::new(&roof);
        let [left, right, back, front] = [8, 17 * 16 + 8, 17 * 8 + 16, 17 * 8];
        let (vertex_of, mut remains) = two_faces(&surface, [left, right, back, front]);
        assert_eq!(flip(&mut Points::new(&surface, &vertex_of, usize::MAX / 64), &mut remains, None), 1);
        assert_eq!(remains.faces, [[2, 3, 1], [3, 2, 0]]);
        let mut again = two_faces(&surface, [front, back, left, right]);
        assert_eq!(flip(&mut Points::new(&surface, &again.0, usize::MAX / 64), &mut again.1, None), 0);
    }

    #[test]
    fn a_diagonal_that_exists_is_not_made_twice() {
        let roof = roof();
        let surface = Surface::new(&roof);
        let (vertex_of, mut remains) = two_faces(&surface, [8, 17 * 16 + 8, 17 * 8 + 16, 17 * 8]);
        remains.positions.push(surface.positions[17 * 4]);
        remains.faces.push([2, 3, 4]);
        remains.normals.push(Vec3::Z);
        assert_eq!(flip(&mut Points::new(&surface, &vertex_of, usize::MAX / 64), &mut remains, None), 0);
    }
}
