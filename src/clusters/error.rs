//! Errors of simplified groups.

use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::mesh::{Attributes, Channel, Role};

use super::ancestors::{AncestorLists, GroupAncestors};
use super::overlay::{Cover, CoveredPiece};
use super::overlay_surface::{OverlaySurface, centroid};
use super::sharpening::{FaceBounds, sharpen};
use super::vertices::{Patch, ReducedPatch};

/// Slack for rounding, as a share of the bound and of the largest coordinate.
const SLACK: [f64; 2] = [1e-9, 1e-13];

/// Errors of a simplified patch.
pub struct GroupErrors {
    /// Bound, for each face, of the distance to the part of the input surface that it replaces, both ways; n_faces.
    pub of_faces: Vec<f32>,
    /// Mean change of each channel between the centroids of the patch's faces and the points of the result below them.
    pub of_channels: Vec<f32>,
    /// Ancestors of each face.
    pub ancestors: AncestorLists,
}

/// Measures a simplified patch; `before` holds the bounds of the patch's own faces.
pub fn measure(patch: &Patch, reduced: &ReducedPatch, before: &[f32], group: &GroupAncestors) -> GroupErrors {
    let (from, to) = (OverlaySurface::from_mesh(&patch.mesh), OverlaySurface::from_mesh(&reduced.mesh));
    let n_faces = reduced.mesh.faces().len();
    // A face whose bound stays below the largest distance at a centroid does not raise that of the group.
    let most = before.iter().copied().fold(0.0, f32::max);
    let there = from.cover_by(&to, |face, distance| distance - f64::from(before[face as usize]));
    let back = to.cover_by(&from, |_, distance| distance - f64::from(most));
    let add = |face: u32, distance: f64| f64::from(before[face as usize]) + distance;
    let mut limits = FaceBounds { before: vec![0.0; before.len()], after: vec![0.0; n_faces] };
    for piece in &there.pieces {
        raise(&mut limits.before[piece.face as usize], add(piece.face, piece.distance));
    }
    for piece in &back.pieces {
        raise(&mut limits.after[piece.face as usize], add(piece.over, piece.distance));
    }
    if group.ancestors.age > 0 {
        sharpen(&mut limits, group, &to, [&there, &back]);
    }
    let mut bounds = limits.after;
    for piece in &there.pieces {
        let bound = add(piece.face, piece.distance).min(limits.before[piece.face as usize]);
        raise(&mut bounds[piece.over as usize], bound);
    }
    let rounding = from.reach() * SLACK[1];
    let slack = |bound: f64| round_up(bound * (1.0 + SLACK[0]) + rounding);
    GroupErrors {
        of_faces: bounds.into_iter().map(slack).collect(),
        of_channels: attribute_changes(patch, reduced, [&from, &to], &there),
        ancestors: inherit(&there, group, n_faces),
    }
}

fn raise(bound: &mut f64, to: f64) {
    *bound = bound.max(to);
}

/// Returns the ancestors of the result's faces: those of the faces that have pieces near them.
fn inherit(cover: &Cover, group: &GroupAncestors, n_faces: usize) -> AncestorLists {
    if group.ancestors.is_last {
        return AncestorLists::default();
    }
    let pair = |piece: &CoveredPiece| u64::from(piece.over) << 32 | u64::from(piece.face);
    let mut pairs: Vec<u64> = cover.pieces.iter().map(pair).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let (mut lists, mut pairs) = (AncestorLists::default(), pairs.as_slice());
    let mut numbers: Vec<u32> = Vec::new();
    for face in 0..n_faces as u64 {
        let n_own = pairs.iter().take_while(|pair| **pair >> 32 == face).count();
        let (own, others) = pairs.split_at(n_own);
        numbers.clear();
        own.iter().for_each(|pair| numbers.extend(group.lists.get(*pair as u32)));
        if group.ancestors.age > 0 {
            numbers.sort_unstable();
            numbers.dedup();
        }
        lists.push(numbers.iter().copied());
        pairs = others;
    }
    lists
}

/// Returns the next number of single precision that is not smaller.
fn round_up(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) < x { rounded.next_up() } else { rounded }
}

fn attribute_changes(
    patch: &Patch,
    reduced: &ReducedPatch,
    [from, to]: [&OverlaySurface; 2],
    cover: &Cover,
) -> Vec<f32> {
    let mut sums = vec![0.0; patch.attributes.channels.len()];
    if sums.is_empty() {
        return Vec::new();
    }
    for ((face, triangle), footing) in from.triangles.iter().enumerate().zip(&cover.at_centroids) {
        let after = footing.face;
        let weights = nearest_weights_f64(centroid(triangle), to.triangles[after as usize]);
        for (number, sum) in sums.iter_mut().enumerate() {
            *sum += f64::from(change(&patch.attributes, face, &reduced.attributes, (after, weights), number));
        }
    }
    sums.into_iter().map(|sum| (sum / from.triangles.len() as f64) as f32).collect()
}

/// Returns the largest difference of a channel's numbers at a face's centroid and at a point of the result.
fn change(
    before: &Attributes,
    face: usize,
    after: &Attributes,
    (over, weights): (u32, [f64; 3]),
    number: usize,
) -> f32 {
    let (channel, other) = (&before.channels[number], &after.channels[number]);
    // Numbers of joints and objects are not interpolated.
    if matches!(channel.role, Role::Label | Role::Skin) {
        return 0.0;
    }
    let (own, found) = (before.wedges[face], after.wedges[over as usize]);
    let blend = |channel: &Channel, wedges: [u32; 3], weights: [f32; 3], k: usize| {
        wedges.iter().zip(weights).map(|(&wedge, weight)| weight * channel.value(wedge)[k]).sum::<f32>()
    };
    let weights = weights.map(|weight| weight as f32);
    let difference = |k: usize| (blend(channel, own, [1.0 / 3.0; 3], k) - blend(other, found, weights, k)).abs();
    (0..channel.width).map(difference).fold(0.0, f32::max)
}
