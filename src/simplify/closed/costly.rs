//! Density that follows error: the regions that cost far more than the others are cut in two, again and again.
//!
//! On scans there are few such regions. On parts with flat faces and sharp edges a few regions that swallowed a
//! corner hold nearly all of the error, and no later step can give it back.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::darts::Assignment;
use super::placement::PULL;
use super::quotient::{far_half, members};
use super::regions::Sum;
use super::surface::Surface;

/// A region is costly from this many times the mean error on.
const COSTLY: f64 = 4.0;
/// Share of the whole error in costly regions above which they are cut.
const HEAVY: f64 = 0.2;
/// Regions that a thread takes at once.
const PARALLEL: usize = 4096;
/// How often the mean is taken anew.
const ROUNDS: usize = 8;

/// Cuts costly regions in two while they hold much of the error, at most until there are `most_regions`, and keeps the
/// sums of the regions in step. Returns the vertices of the regions that were cut; those cut twice come twice.
pub(super) fn cut_costly(
    surface: &Surface,
    assignment: &mut Assignment,
    sums: &mut Vec<Sum>,
    most_regions: usize,
) -> Vec<u32> {
    let mut cut = Vec::new();
    let mut errors: Vec<f64> = sums.par_iter().with_min_len(PARALLEL).map(error).collect();
    let mut lists = BTreeMap::new();
    for _ in 0..ROUNDS {
        let total: f64 = errors.iter().sum();
        let limit = COSTLY * total / errors.len() as f64;
        let costly: Vec<u32> = (0..errors.len() as u32).filter(|&r| errors[r as usize] > limit).collect();
        if costly.iter().map(|&r| errors[r as usize]).sum::<f64>() <= HEAVY * total {
            break;
        }
        let mut unlisted = vec![false; assignment.n_regions];
        costly.iter().for_each(|r| unlisted[*r as usize] = !lists.contains_key(r));
        lists.append(&mut members(assignment, &unlisted));
        let wholes = costly.iter().filter_map(|r| lists.remove(r)).filter(|whole| whole.len() > 1);
        let wholes: Vec<Vec<u32>> = wholes.take(most_regions.saturating_sub(assignment.n_regions)).collect();
        let halves: Vec<[Half; 2]> = wholes.par_iter().map(|whole| Half::both(surface, whole)).collect();
        for ([stays, goes], whole) in halves.into_iter().zip(&wholes) {
            let (r, fresh) = (assignment.region[whole[0] as usize], assignment.n_regions as u32);
            assignment.n_regions += 1;
            goes.vertices.iter().for_each(|&v| assignment.region[v as usize] = fresh);
            (sums[r as usize], errors[r as usize]) = (stays.sum, error(&stays.sum));
            sums.push(goes.sum);
            errors.push(error(&goes.sum));
            lists.extend([(r, stays.vertices), (fresh, goes.vertices)]);
            cut.extend_from_slice(whole);
        }
        if assignment.n_regions >= most_regions {
            break;
        }
    }
    cut
}

/// A half of a region.
struct Half {
    vertices: Vec<u32>,
    sum: Sum,
}

impl Half {
    /// The near half of a region and the far one.
    fn both(surface: &Surface, whole: &[u32]) -> [Self; 2] {
        let far = far_half(surface, whole);
        let near = whole.iter().filter(|v| far.binary_search(v).is_err()).copied().collect();
        [near, far].map(|vertices: Vec<u32>| {
            let mut sum = Sum::default();
            vertices.iter().for_each(|&v| sum += Sum::of(surface, v as usize));
            Self { vertices, sum }
        })
    }
}

/// The error of a region at its best placement.
fn error(sum: &Sum) -> f64 {
    sum.quadric(f64::from(PULL)).minimum().map_or(0.0, |(_, error)| error)
}
