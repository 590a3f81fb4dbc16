//! The surfaces that Bevy draws at different errors.

use std::collections::HashMap;

use crate::content::{Content, Meshlet};
use crate::tree::Tree;

/// Cuts to check, at most.
const MOST_CUTS: usize = 32;

type Position = [i64; 3];

/// Faces and open edges of a cut.
struct Surface {
    n_faces: usize,
    n_open: usize,
}

/// Checks the boxes of all meshlets, and that a closed mesh is closed at each error; returns a summary.
///
/// # Errors
/// Message about a meshlet outside its box, or a cut with a crack.
pub fn check_cuts(content: &Content, tree: &Tree) -> Result<String, String> {
    let faces = read_faces(content, tree)?;
    let errors = list_errors(tree);
    let surfaces: Vec<Surface> = errors.iter().map(|&error| measure(&faces, &tree.list_drawn(error))).collect();
    let (finest, coarsest) = (&surfaces[0], &surfaces[surfaces.len() - 1]);
    for (surface, error) in surfaces.iter().zip(&errors) {
        if surface.n_faces == 0 || (finest.n_open == 0 && surface.n_open > 0) {
            return Err(format!("{} faces with {} open edges at an error of {error}", surface.n_faces, surface.n_open));
        }
    }
    let (n_cuts, closed) = (errors.len(), if finest.n_open == 0 { "closed " } else { "" });
    Ok(format!("{n_cuts} {closed}cuts of {} to {} faces", finest.n_faces, coarsest.n_faces))
}

/// Returns the faces of each meshlet.
fn read_faces(content: &Content, tree: &Tree) -> Result<Vec<Vec<[Position; 3]>>, String> {
    let read = |(k, bounds): (usize, &crate::tree::Bounds)| {
        let meshlet = Meshlet::new(content, k);
        let faces = meshlet.faces(content);
        let to_point = |position: &Position| position.map(|x| x as f32 * meshlet.step());
        let is_inside = |point| bounds.has_point(point, tree.rounding() + meshlet.step());
        let is_valid = faces.as_flattened().iter().map(to_point).all(is_inside);
        is_valid.then_some(faces).ok_or_else(|| format!("meshlet {k}: positions outside its box"))
    };
    tree.meshlets().iter().enumerate().map(read).collect()
}

/// Returns errors between the least and the largest, in ascending order, at which the cut changes.
fn list_errors(tree: &Tree) -> Vec<f32> {
    let mut errors: Vec<f32> = tree.meshlets().iter().map(|meshlet| meshlet.error.next_up()).collect();
    errors.sort_by(f32::total_cmp);
    errors.dedup();
    let n = errors.len();
    let n_cuts = n.min(MOST_CUTS);
    (0..n_cuts).map(|k| errors[k * (n - 1) / (n_cuts - 1).max(1)]).collect()
}

fn measure(faces: &[Vec<[Position; 3]>], drawn: &[usize]) -> Surface {
    let mut balance: HashMap<(Position, Position), i64> = HashMap::new();
    let drawn = || drawn.iter().flat_map(|&meshlet| &faces[meshlet]);
    for &[a, b, c] in drawn() {
        for (from, to) in [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to) {
            let sign = if from < to { 1 } else { -1 };
            *balance.entry((from.min(to), from.max(to))).or_default() += sign;
        }
    }
    let n_open = balance.values().filter(|&&count| count != 0).count();
    Surface { n_faces: drawn().count(), n_open }
}
