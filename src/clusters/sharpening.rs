//! Sharper bounds of a group's largest errors, against the ancestors of its faces.

use rustc_hash::FxHashMap;

use crate::geometry::triangle::area_normal_f64;

use super::ancestors::{AncestorSurface, GroupAncestors};
use super::overlay::{Cover, Covering};
use super::overlay_surface::{OverlaySurface, centroid, largest_distance};

/// Share of a bound at which a new one is not made sharper still.
// At 0.9 the bounds of groups are the same.
const WELCOME: f64 = 0.8;

/// Bounds of one group, of the faces before and after.
pub struct FaceBounds {
    /// Bounds from the input at each face of the group to the result.
    pub before: Vec<f64>,
    /// Bounds from each face of the result to the input.
    pub after: Vec<f64>,
}

struct Sharpening<'a> {
    group: &'a GroupAncestors<'a>,
    /// Number of faces of the group that list each ancestor.
    n_users: FxHashMap<u32, u32>,
    result: &'a OverlaySurface,
    /// Largest bound that stays.
    largest: f64,
}

/// Makes the largest bounds sharper, until they are proved or no sharper ones are found.
///
/// `covers` are those of the group by the result, and back.
pub fn sharpen(bounds: &mut FaceBounds, group: &GroupAncestors, result: &OverlaySurface, covers: [&Cover; 2]) {
    let mut sharpening = Sharpening { group, n_users: group.count_users(), result, largest: 0.0 };
    sharpening.sharpen_before(&mut bounds.before, covers[0]);
    sharpening.sharpen_after(&mut bounds.after, covers[1]);
}

impl Sharpening<'_> {
    /// Sharpens bounds of the distance from the input at faces of the group to the result.
    fn sharpen_before(&mut self, bounds: &mut [f64], cover: &Cover) {
        let mut covering = Covering::new(self.result, self.n_users.len());
        let mut known: FxHashMap<u32, f64> = FxHashMap::default();
        for face in sorted_from_largest(bounds) {
            let bound = &mut bounds[face as usize];
            if *bound <= self.largest {
                break;
            }
            let hint = cover.at_centroids[face as usize].face;
            let mut sharp = 0.0f64;
            for &ancestor in self.group.lists.get(face) {
                let bound_ancestor = || self.bound_ancestor(ancestor, hint, *bound, &mut covering);
                sharp = sharp.max(*known.entry(ancestor).or_insert_with(bound_ancestor));
                if sharp >= *bound {
                    break;
                }
            }
            *bound = bound.min(sharp);
            self.largest = self.largest.max(*bound);
        }
    }

    fn bound_ancestor(&self, ancestor: u32, hint: u32, known: f64, covering: &mut Covering) -> f64 {
        // What reaches beyond the group is far from its result.
        if self.group.ancestors.n_users(ancestor) != self.n_users[&ancestor] {
            return f64::INFINITY;
        }
        let triangle = self.group.triangle(ancestor);
        let normal = area_normal_f64(triangle).normalize_or_zero();
        let error = self.group.ancestors.error(ancestor);
        (covering.enough, covering.usual) = (self.largest - error, WELCOME * known - error);
        covering.cover((triangle, normal), self.result.footing_of(&triangle, normal, hint));
        error + largest_distance(&covering.parts)
    }

    /// Sharpens bounds of the distance from faces of the result to the input.
    fn sharpen_after(&mut self, bounds: &mut [f64], cover: &Cover) {
        let mut faces = sorted_from_largest(bounds);
        faces.retain(|&face| bounds[face as usize] > self.largest);
        // Only the ancestors near these faces are needed.
        let mut is_large = vec![false; bounds.len()];
        faces.iter().for_each(|&face| is_large[face as usize] = true);
        let pieces = cover.pieces.iter().filter(|piece| is_large[piece.face as usize]);
        let near = pieces.flat_map(|piece| self.group.lists.get(piece.over)).copied().collect();
        let ancestors = self.group.surface(near);
        // Faces to which no point of the input belongs have none.
        if ancestors.numbers.is_empty() {
            return;
        }
        let mut covering = Covering::new(&ancestors.surface, faces.len());
        for face in faces {
            let bound = &mut bounds[face as usize];
            if *bound <= self.largest {
                break;
            }
            let over = self.group.lists.get(cover.at_centroids[face as usize].face);
            let hint = ancestors.find_nearest(over, centroid(&self.result.triangles[face as usize]));
            let sharp = self.bound_after(face, hint, (*bound, &ancestors), &mut covering);
            *bound = bound.min(sharp);
            self.largest = self.largest.max(*bound);
        }
    }

    fn bound_after(
        &self,
        face: u32,
        hint: u32,
        (known, ancestors): (f64, &AncestorSurface),
        covering: &mut Covering,
    ) -> f64 {
        let error = |over: u32| self.group.ancestors.error(ancestors.numbers[over as usize]);
        let (triangle, normal) = (self.result.triangles[face as usize], self.result.normals[face as usize]);
        (covering.enough, covering.usual) = (self.largest - error(hint), WELCOME * known - error(hint));
        covering.cover((triangle, normal), ancestors.surface.footing_of(&triangle, normal, hint));
        covering.parts.iter().map(|&(over, distance)| error(over) + distance).fold(0.0, f64::max)
    }
}

/// Returns the numbers of bounds, the largest bound first.
fn sorted_from_largest(bounds: &[f64]) -> Vec<u32> {
    let mut faces: Vec<u32> = (0..bounds.len() as u32).collect();
    faces.sort_by(|&x, &y| bounds[y as usize].total_cmp(&bounds[x as usize]));
    faces
}
