//! Sharper bounds of a group's largest errors, against the ancestors of its faces.

use std::cell::OnceCell;

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::geometry::triangle::area_normal_f64;

use super::ancestors::GroupAncestors;
use super::overlay::{Cover, Covering};
use super::overlay_surface::{OverlaySurface, largest_distance};

/// Bounds of at most this share of the group's largest one are not made sharper.
const SHARPENED: f64 = 0.7;

/// Bounds of one group, of the faces before and after.
pub struct FaceBounds {
    /// Of the input at each face of the group to the result.
    pub before: Vec<f64>,
    /// Of each face of the result to the input.
    pub after: Vec<f64>,
}

/// A face whose bound may be made sharper.
#[derive(Clone, Copy)]
enum BoundedFace {
    Before(u32),
    After(u32),
}

struct Sharpening<'a> {
    group: &'a GroupAncestors<'a>,
    result: &'a OverlaySurface,
    covers: [&'a Cover; 2],
    numbers: Vec<u32>,
    is_inside: Vec<bool>,
    /// Bounds of ancestors to the result.
    known: FxHashMap<u32, f64>,
}

/// Makes the largest bounds sharper, until they are proved or no sharper ones are found.
pub fn sharpen(
    bounds: &mut FaceBounds,
    group: &GroupAncestors,
    result: &OverlaySurface,
    covers: [&Cover; 2],
) {
    let (numbers, is_inside) = group.distinct();
    let mut sharpening =
        Sharpening { group, result, covers, numbers, is_inside, known: FxHashMap::default() };
    let before = (0..).zip(&bounds.before).map(|(face, &bound)| (bound, BoundedFace::Before(face)));
    let after = (0..).zip(&bounds.after).map(|(face, &bound)| (bound, BoundedFace::After(face)));
    let mut faces: Vec<(f64, BoundedFace)> = before.chain(after).collect();
    faces.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut to_result = Covering::new(result, sharpening.numbers.len());
    let surface = OnceCell::new();
    let mut to_ancestors: Option<Covering> = None;
    let mut largest = 0.0f64;
    for (bound, face) in faces {
        if bound <= SHARPENED * largest {
            break;
        }
        let sharp = match face {
            BoundedFace::Before(face) => {
                let sharp = sharpening.bound_before(face, SHARPENED * largest, bound, &mut to_result);
                let bound = &mut bounds.before[face as usize];
                *bound = bound.min(sharp);
                *bound
            }
            BoundedFace::After(face) => {
                let surface = surface.get_or_init(|| group.surface(&sharpening.numbers));
                let covering = to_ancestors.get_or_insert_with(|| Covering::new(surface, result.triangles.len()));
                let sharp = sharpening.bound_after(face, SHARPENED * largest, surface, covering);
                let bound = &mut bounds.after[face as usize];
                *bound = bound.min(sharp);
                *bound
            }
        };
        largest = largest.max(sharp);
    }
}

impl Sharpening<'_> {
    /// Returns a bound of the distance from the input at a face of the group to the result, by the face's ancestors.
    fn bound_before(&mut self, face: u32, enough: f64, known: f64, covering: &mut Covering) -> f64 {
        let mut largest = 0.0f64;
        for &ancestor in self.group.lists.get(face) {
            let bound = match self.known.get(&ancestor) {
                Some(&bound) => bound,
                None => {
                    let bound = self.bound_of_ancestor(ancestor, self.covers[0].at_centroids[face as usize].face, enough, covering);
                    self.known.insert(ancestor, bound);
                    bound
                }
            };
            largest = largest.max(bound);
            if largest >= known {
                break;
            }
        }
        largest
    }

    fn bound_of_ancestor(&self, ancestor: u32, hint: u32, enough: f64, covering: &mut Covering) -> f64 {
        let place = self.numbers.partition_point(|&number| number < ancestor);
        // What reaches beyond the group is far from its result.
        if !self.is_inside[place] {
            return f64::INFINITY;
        }
        let triangle = self.group.triangle(ancestor);
        let normal = area_normal_f64(triangle).normalize_or_zero();
        let error = self.group.ancestors.error(ancestor);
        covering.enough = enough - error;
        covering.usual = covering.enough;
        covering.cover((triangle, normal), self.result.footing_of(&triangle, normal, hint));
        error + largest_distance(&covering.parts)
    }

    /// Returns a bound of the distance from a face of the result to the input.
    fn bound_after(&self, face: u32, enough: f64, surface: &OverlaySurface, covering: &mut Covering) -> f64 {
        let over = self.covers[1].at_centroids[face as usize].face;
        let number = |ancestor: u32| self.numbers.partition_point(|&number| number < ancestor) as u32;
        let hint = self.group.lists.get(over).first().map_or(0, |&ancestor| number(ancestor));
        let (triangle, normal) = (self.result.triangles[face as usize], self.result.normals[face as usize]);
        covering.enough = enough - self.group.ancestors.error(self.numbers[hint as usize]);
        covering.usual = covering.enough;
        covering.cover((triangle, normal), surface.footing_of(&triangle, normal, hint));
        let error = |&(over, distance): &(u32, f64)| self.group.ancestors.error(self.numbers[over as usize]) + distance;
        covering.parts.iter().map(error).fold(0.0, f64::max)
    }
}
