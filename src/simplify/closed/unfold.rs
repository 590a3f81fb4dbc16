//! The last few folds: a face that looks away from the original gives its longest edge to the other diagonal, or,
//! where no flip helps, one of its corners another place.
//!
//! Collapse and fit turn no face far, but a face can end up where the original looks another way. Such a face
//! looks away from the mean of the faces around it, which is what is searched for; thin parts have such faces, too,
//! so that the original's normal nearby decides.

use glam::Vec3;
use rustc_hash::FxHashSet;

use crate::geometry::triangle::area_normal;

use super::corners::Corners;
use super::faces_around::FacesAround;
use super::half::OnPlane;
use super::nearest::{anchors, distance_squared, nearest_vertex};
use super::surface::Surface;

/// What counts as looking away, and how much farther from the original (squared) the other diagonal may then lie,
/// round after round: where all of the original nearby looks the other way, any diagonal is better.
const ROUNDS: [(Sight, f32); 3] = [(Sight::Nearest, 16.0), (Sight::Nearest, 16.0), (Sight::AllNear, f32::INFINITY)];

/// The result as far as folds are mended.
pub(super) struct Folded<'a> {
    /// Normalised positions, n_vertices x 3.
    pub positions: &'a mut [Vec3],
    /// Faces, n_faces x 3.
    pub faces: &'a mut [[u32; 3]],
    /// What the corners carry: seams stay, and corners are flipped with their faces.
    pub corners: Option<&'a mut Corners>,
    /// Whether each vertex stays where it is; empty where all may move.
    pub fixed: &'a [bool],
    /// What stays on the plane, where this is one half of a mirrored mesh.
    pub on_plane: Option<&'a OnPlane>,
}

/// Mends folded faces by flips, and by moving a corner where no flip helps; returns how many edges it flipped.
pub(super) fn unfold(surface: &Surface, vertex_of: &[u32], result: &mut Folded) -> usize {
    let Folded { positions, faces, corners, fixed, on_plane } = result;
    let on_plane = *on_plane;
    let mut folded = folded_faces(positions, faces);
    if folded.is_empty() {
        return 0;
    }
    let mut around = FacesAround::new(positions.len(), faces);
    let starts = anchors(surface, positions, vertex_of);
    let mut n_flipped = 0;
    let mut touched: FxHashSet<u32> = FxHashSet::default();
    for (round, (sight, most_loss)) in ROUNDS.into_iter().enumerate() {
        let original = Original { surface, positions, starts: &starts, sight, most_loss, on_plane };
        // The second round is the first again: only near what it changed can anything be different.
        let near = if round == 1 { folded_near(faces, &around, &folded, &touched) } else { folded.clone() };
        touched.clear();
        for &f in &near {
            if original.looks_away(faces[f as usize])
                && let Some(diamond) = original.find_flip(f, faces, &around, &touched, corners.as_deref())
            {
                corners.iter_mut().for_each(|corners| corners.flip(faces, diamond.faces, diamond.corners));
                diamond.flip(faces, &mut around);
                touched.extend(diamond.corners);
                n_flipped += 1;
            }
        }
        folded = still_folded(positions, faces, &around, folded, &touched);
    }
    let stays =
        |v: u32| fixed.get(v as usize).is_some_and(|&fixed| fixed) || on_plane.is_some_and(|plane| plane.has(v));
    move_corners(surface, positions, faces, &around, (&folded, &stays), &starts);
    n_flipped
}

/// Moves corners of the faces that still look away, and against all of their neighbours, to where fewer of the faces
/// around them do.
fn move_corners(
    surface: &Surface,
    positions: &mut [Vec3],
    faces: &[[u32; 3]],
    around: &FacesAround,
    (folded, stays): (&[u32], &dyn Fn(u32) -> bool),
    starts: &[u32],
) {
    let n_away = |positions: &[Vec3], of: &[u32]| {
        let original = Original { surface, positions, starts, sight: Sight::Nearest, most_loss: 0.0, on_plane: None };
        of.iter().filter(|&&f| original.looks_away(faces[f as usize])).count()
    };
    for &f in folded {
        if !opposes_all(positions, faces, around, f) || n_away(positions, &[f]) == 0 {
            continue;
        }
        for v in faces[f as usize].into_iter().filter(|&v| !stays(v)) {
            let before = (n_away(positions, &around.faces(v).collect::<Vec<_>>()), positions[v as usize]);
            let mut best = before;
            for place in other_places(surface, positions, faces, around, v, starts[v as usize]) {
                positions[v as usize] = place;
                let n = n_away(positions, &around.faces(v).collect::<Vec<_>>());
                best = if n < best.0 { (n, place) } else { best };
            }
            positions[v as usize] = best.1;
            if best.0 < before.0 {
                break;
            }
        }
    }
}

/// Whether a face looks against every face that it shares an edge with.
fn opposes_all(positions: &[Vec3], faces: &[[u32; 3]], around: &FacesAround, f: u32) -> bool {
    let face = faces[f as usize];
    let normal = |face: [u32; 3]| area_normal(face.map(|v| positions[v as usize]));
    let beside = |g: u32| g != f && faces[g as usize].iter().filter(|v| face.contains(v)).count() == 2;
    let mut neighbors = face.iter().flat_map(|&v| around.faces(v)).filter(|&g| beside(g));
    neighbors.all(|g| normal(faces[g as usize]).dot(normal(face)) < 0.0)
}

/// Where else a vertex could be: amid its neighbours, on a vertex of the original near there, or near where it is.
fn other_places(
    surface: &Surface,
    positions: &[Vec3],
    faces: &[[u32; 3]],
    around: &FacesAround,
    v: u32,
    start: u32,
) -> [Vec3; 3] {
    let corners = around.faces(v).flat_map(|f| faces[f as usize]).filter(|&w| w != v);
    let (sum, n) = corners.fold((Vec3::ZERO, 0.0), |(sum, n), w| (sum + positions[w as usize], n + 1.0));
    let amid = sum / n;
    let on_original = |p: Vec3| surface.positions[nearest_vertex(surface, p, start).0 as usize];
    [on_original(positions[v as usize]), on_original(amid), amid]
}

/// Which of the original's vertices decide whether a face looks away.
#[derive(Clone, Copy, PartialEq)]
enum Sight {
    /// The one nearest to its centroid.
    Nearest,
    /// That one and all its neighbours.
    AllNear,
}

/// The faces that look away from the mean normal at one of their corners.
fn folded_faces(positions: &[Vec3], faces: &[[u32; 3]]) -> Vec<u32> {
    let normal = |face: &[u32; 3]| area_normal(face.map(|v| positions[v as usize]));
    let mut means = vec![Vec3::ZERO; positions.len()];
    for face in faces {
        let normal = normal(face);
        face.iter().for_each(|&v| means[v as usize] += normal);
    }
    let is_folded = |face: &[u32; 3]| face.iter().any(|&v| normal(face).dot(means[v as usize]) < 0.0);
    (0..faces.len() as u32).filter(|&f| is_folded(&faces[f as usize])).collect()
}

/// The `folded` faces beside which an edge was flipped.
fn folded_near(faces: &[[u32; 3]], around: &FacesAround, folded: &[u32], touched: &FxHashSet<u32>) -> Vec<u32> {
    let rings = touched.iter().flat_map(|&v| around.faces(v)).flat_map(|f| faces[f as usize]);
    let near: FxHashSet<u32> = rings.collect();
    folded.iter().copied().filter(|&f| faces[f as usize].iter().any(|v| near.contains(v))).collect()
}

/// Of the faces that were `folded` and those at `touched` vertices, the ones that are.
fn still_folded(
    positions: &[Vec3],
    faces: &[[u32; 3]],
    around: &FacesAround,
    mut folded: Vec<u32>,
    touched: &FxHashSet<u32>,
) -> Vec<u32> {
    if touched.is_empty() {
        return folded;
    }
    let normal = |f: u32| area_normal(faces[f as usize].map(|v| positions[v as usize]));
    let mean = |v: u32| around.faces(v).map(normal).sum::<Vec3>();
    folded.extend(
        touched.iter().flat_map(|&v| around.faces(v)).flat_map(|f| faces[f as usize]).flat_map(|v| around.faces(v)),
    );
    folded.sort_unstable();
    folded.dedup();
    folded.retain(|&f| faces[f as usize].iter().any(|&v| normal(f).dot(mean(v)) < 0.0));
    folded
}

/// The original as the output's faces see it.
struct Original<'a> {
    surface: &'a Surface,
    positions: &'a [Vec3],
    /// For each output vertex an input vertex near it.
    starts: &'a [u32],
    sight: Sight,
    most_loss: f32,
    on_plane: Option<&'a OnPlane>,
}

impl Original<'_> {
    /// Whether a face looks away from the original near its centroid, or nowhere.
    fn looks_away(&self, face: [u32; 3]) -> bool {
        let corners = face.map(|v| self.positions[v as usize]);
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        let (nearest, _) = nearest_vertex(self.surface, centroid, self.starts[face[0] as usize]);
        let normal = area_normal(corners);
        let against = |v: &u32| normal.dot(self.surface.normals[*v as usize]) <= 0.0;
        against(&nearest) && (self.sight == Sight::Nearest || self.surface.neighbors(nearest).iter().all(against))
    }

    /// How far the original is from two points of a diagonal (sum of squares).
    fn distance(&self, u: u32, v: u32) -> f32 {
        let (p, q) = (self.positions[u as usize], self.positions[v as usize]);
        let start = self.starts[u as usize];
        [1.0 / 3.0, 2.0 / 3.0].iter().map(|&t| distance_squared(self.surface, p.lerp(q, t), start)).sum()
    }

    /// The longest edge of face `f` whose other diagonal is free, not much farther from the original, and makes two
    /// faces that look right; no seam, and none at a vertex that was `touched`.
    fn find_flip(
        &self,
        f: u32,
        faces: &[[u32; 3]],
        around: &FacesAround,
        touched: &FxHashSet<u32>,
        corners: Option<&Corners>,
    ) -> Option<Diamond> {
        let [a, b, c] = faces[f as usize];
        let length = |u: u32, v: u32| self.positions[u as usize].distance_squared(self.positions[v as usize]);
        let mut sides = [(a, b, c), (b, c, a), (c, a, b)];
        sides.sort_by(|x, y| length(y.0, y.1).total_cmp(&length(x.0, x.1)));
        sides.into_iter().find_map(|(a, b, c)| {
            let g = around.along(b, a)?;
            let d = *faces[g as usize].iter().find(|&&v| v != a && v != b)?;
            let diamond = Diamond { faces: [f, g], corners: [a, b, c, d] };
            let bridges = self.on_plane.is_some_and(|on_plane| on_plane.has(c) && on_plane.has(d));
            let is_free =
                !bridges && !around.joins(c, d) && c != d && !diamond.corners.iter().any(|v| touched.contains(v));
            let is_seam = || corners.is_some_and(|corners| corners.is_seam(faces, diamond.faces, [a, b]));
            let helps = || {
                self.distance(c, d) <= self.most_loss * self.distance(a, b)
                    && !diamond.flipped().iter().any(|&n| self.looks_away(n))
            };
            (is_free && !is_seam() && helps()).then_some(diamond)
        })
    }
}

/// An edge over which two faces meet: their corners `a b c` and `b a d`.
struct Diamond {
    faces: [u32; 2],
    corners: [u32; 4],
}

impl Diamond {
    /// The faces with the other diagonal.
    fn flipped(&self) -> [[u32; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[c, d, b], [d, c, a]]
    }

    fn flip(&self, faces: &mut [[u32; 3]], around: &mut FacesAround) {
        for (f, now) in self.faces.into_iter().zip(self.flipped()) {
            around.replace(f, std::mem::replace(&mut faces[f as usize], now), now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_fold_in_a_plane_is_mended() {
        let surface = Surface::new(&shapes::grid(8, 8));
        // Vertex 3 lies within the triangle of the others, so that the second face looks down.
        let corners = [[0u32, 0], [8, 0], [4, 8], [4, 2]].map(|[i, j]| 9 * i + j);
        let mut positions = corners.map(|v| surface.positions[v as usize]);
        let vertex_of: Vec<u32> = (0..surface.n_vertices() as u32)
            .map(|v| corners.iter().position(|&c| c == v).unwrap_or(0) as u32)
            .collect();
        let mut faces = vec![[0, 1, 2], [1, 0, 3]];
        let mut mend = || {
            let mut folded =
                Folded { positions: &mut positions, faces: &mut faces, corners: None, fixed: &[], on_plane: None };
            unfold(&surface, &vertex_of, &mut folded)
        };
        assert_eq!([mend(), mend()], [1, 0]);
        assert!(faces.iter().all(|f| area_normal(f.map(|v| positions[v as usize])).z > 0.0), "{faces:?}");
    }
}
