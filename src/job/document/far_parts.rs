//! Parts of a scene far from their own origin, which nodes move back.
//!
//! The united mesh has one scale, so such parts would leave too few bits for the shapes of all.

use glam::{DMat4, DVec3, Vec3};

use crate::mesh::TriMesh;
use crate::mesh::cleanup::{Cleaned, origin_within};

/// PartBox of the parts in their own coordinates, over that of the scene, above which each is moved to its origin.
const FAR: f64 = 16.0;

/// A cleaned part, the scale of its coordinates in the united mesh, and the transforms of its instances.
pub struct ScenePart<'a> {
    pub cleaned: &'a mut Cleaned,
    pub scale: f64,
    pub places: &'a mut Vec<DMat4>,
}

/// Moves parts to their origin if they are far apart in their own coordinates, and returns where each was, n_parts.
///
/// Moves are exact, so that vertices which stay are written as they were.
pub fn move_to_origins(parts: &mut [ScenePart]) -> Vec<[f32; 3]> {
    let (mut own, mut scene) = (PartBox::EMPTY, PartBox::EMPTY);
    for part in &*parts {
        let corners = PartBox::of_mesh(&part.cleaned.mesh).corners();
        corners.iter().for_each(|&corner| own.add(part.scale * corner));
        let placed = part.places.iter().flat_map(|place| corners.iter().map(|&corner| place.transform_point3(corner)));
        placed.for_each(|corner| scene.add(corner));
    }
    // Parts without instances have no scene.
    let is_far = own.diagonal() > FAR * scene.diagonal() && scene.diagonal() > 0.0;
    parts.iter_mut().map(|part| if is_far { part.move_to_origin() } else { [0.0; 3] }).collect()
}

impl ScenePart<'_> {
    fn move_to_origin(&mut self) -> [f32; 3] {
        let PartBox { low, high } = PartBox::of_mesh(&self.cleaned.mesh);
        let origin = origin_within(low.to_array(), high.to_array()).map(|x| x as f32);
        let (positions, faces) = std::mem::take(&mut self.cleaned.mesh).into_parts();
        let moved = positions.iter().map(|p| std::array::from_fn(|axis| p[axis] - origin[axis])).collect();
        // The origin is within the part, so that no difference overflows.
        self.cleaned.mesh = TriMesh::new(moved, faces).unwrap_or_default();
        let back = DMat4::from_translation(Vec3::from(origin).as_dvec3());
        self.places.iter_mut().for_each(|place| *place *= back);
        origin
    }
}

struct PartBox {
    low: DVec3,
    high: DVec3,
}

impl PartBox {
    const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    fn of_mesh(mesh: &TriMesh) -> Self {
        let mut found = Self::EMPTY;
        mesh.positions().iter().for_each(|p| found.add(Vec3::from(*p).as_dvec3()));
        found
    }

    fn corners(&self) -> [DVec3; 8] {
        let sides = [self.low.to_array(), self.high.to_array()];
        std::array::from_fn(|corner| DVec3::from_array(std::array::from_fn(|axis| sides[corner >> axis & 1][axis])))
    }

    fn add(&mut self, p: DVec3) {
        (self.low, self.high) = (self.low.min(p), self.high.max(p));
    }

    fn diagonal(&self) -> f64 {
        (self.high - self.low).max(DVec3::ZERO).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::cleanup::{CleanOptions, clean};
    use crate::mesh::{RawMesh, shapes};

    fn part_at(at: f32) -> Cleaned {
        let ball = shapes::icosphere(2);
        let positions = ball.positions().iter().map(|p| [f64::from(p[0] + at), f64::from(p[1]), f64::from(p[2])]);
        clean(RawMesh::new(positions.collect(), ball.faces().to_vec()), &CleanOptions::default()).unwrap()
    }

    /// Moves two balls that nodes place next to each other, and returns where they were.
    fn move_two(at: [f32; 2]) -> (Vec<Cleaned>, Vec<[f32; 3]>) {
        let mut cleaned = at.map(part_at);
        let place = |at: f32, x: f64| vec![DMat4::from_translation(DVec3::new(x - f64::from(at), 0.0, 0.0))];
        let mut places = [place(at[0], 0.0), place(at[1], 3.0)];
        let mut parts: Vec<ScenePart> = cleaned
            .iter_mut()
            .zip(&mut places)
            .map(|(cleaned, places)| ScenePart { cleaned, scale: 1.0, places })
            .collect();
        let origins = move_to_origins(&mut parts);
        for (cleaned, places) in cleaned.iter().zip(&places) {
            let placed = places[0].transform_point3(PartBox::of_mesh(&cleaned.mesh).low);
            assert!((placed.y + 1.0).abs() < 1e-6 && placed.x < 2.1, "{placed}");
        }
        (cleaned.into(), origins)
    }

    #[test]
    fn parts_far_from_each_other_move_exactly() {
        let (moved, origins) = move_two([17_000.0, 0.0]);
        assert!((origins[0][0] - 17_000.0).abs() <= 4.0 && origins[1] == [0.0; 3], "{origins:?}");
        let before = part_at(17_000.0);
        for (p, own) in before.mesh.positions().iter().zip(moved[0].mesh.positions()) {
            assert_eq!(*p, std::array::from_fn(|axis| own[axis] + origins[0][axis]));
            assert!(own[0].abs() < 8.0);
        }
    }

    #[test]
    fn parts_near_each_other_stay() {
        let (stayed, origins) = move_two([20.0, 0.0]);
        assert_eq!(origins, [[0.0; 3]; 2]);
        assert_eq!(stayed[0].mesh, part_at(20.0).mesh);
    }
}
