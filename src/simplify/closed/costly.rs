//! Density that follows error: the regions that cost far more than the others are cut in two, again and again.
//!
//! On scans there are few such regions. On parts with flat faces and sharp edges a few regions that swallowed a
//! corner hold nearly all of the error, and no later step can give it back.

use crate::geometry::Quadric;

use super::darts::Assignment;
use super::placement::PULL;
use super::quotient::{cut_region, members};
use super::regions::vertex_quadric;
use super::surface::Surface;

/// A region is costly from this many times the mean error on.
const COSTLY: f64 = 4.0;
/// Share of the whole error in costly regions above which they are cut.
const HEAVY: f64 = 0.2;
/// How often the mean is taken anew.
const ROUNDS: usize = 8;

/// Cuts costly regions in two while they hold much of the error, at most until there are `most_regions`.
pub(super) fn cut_costly(surface: &Surface, assignment: &mut Assignment, most_regions: usize) {
    let mut lists = members(assignment);
    let mut errors: Vec<f64> = lists.iter().map(|vertices| error(surface, vertices)).collect();
    for _ in 0..ROUNDS {
        let total: f64 = errors.iter().sum();
        let limit = COSTLY * total / errors.len() as f64;
        let costly: Vec<usize> = (0..errors.len()).filter(|&r| errors[r] > limit && lists[r].len() > 1).collect();
        if costly.iter().map(|&r| errors[r]).sum::<f64>() <= HEAVY * total {
            break;
        }
        for r in costly {
            if assignment.n_regions >= most_regions {
                return;
            }
            cut_region(surface, assignment, &lists[r]);
            let whole = std::mem::take(&mut lists[r]);
            let (stay, go): (Vec<u32>, Vec<u32>) =
                whole.into_iter().partition(|&v| assignment.region[v as usize] == r as u32);
            errors[r] = error(surface, &stay);
            errors.push(error(surface, &go));
            lists[r] = stay;
            lists.push(go);
        }
    }
}

/// The error of a region at its best placement.
fn error(surface: &Surface, vertices: &[u32]) -> f64 {
    let sum = vertices.iter().fold(Quadric::default(), |sum, &v| sum + vertex_quadric(surface, v as usize, PULL));
    sum.minimum().map_or(0.0, |(_, error)| error)
}
