//! Density that follows error: the regions that cost far more than the others are cut in two, again and again.
//!
//! On scans there are few such regions. On parts with flat faces and sharp edges a few regions that swallowed a
//! corner hold nearly all of the error, and no later step can give it back.

use std::collections::BTreeMap;

use super::darts::Assignment;
use super::placement::PULL;
use super::quotient::{cut_region, members, move_sums};
use super::regions::Sum;
use super::surface::Surface;

/// A region is costly from this many times the mean error on.
const COSTLY: f64 = 4.0;
/// Share of the whole error in costly regions above which they are cut.
const HEAVY: f64 = 0.2;
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
    let mut errors: Vec<f64> = sums.iter().map(error).collect();
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
        for r in costly {
            if assignment.n_regions >= most_regions {
                return cut;
            }
            let Some(whole) = lists.remove(&r).filter(|whole: &Vec<u32>| whole.len() > 1) else { continue };
            cut_region(surface, assignment, &whole);
            cut.extend_from_slice(&whole);
            move_sums(surface, assignment, sums, (r, &whole));
            errors[r as usize] = error(&sums[r as usize]);
            errors.push(error(&sums[errors.len()]));
            let (stay, go): (Vec<u32>, Vec<u32>) = whole.into_iter().partition(|&v| assignment.region[v as usize] == r);
            lists.extend([(r, stay), (errors.len() as u32 - 1, go)]);
        }
    }
    cut
}

/// The error of a region at its best placement.
fn error(sum: &Sum) -> f64 {
    sum.quadric(f64::from(PULL)).minimum().map_or(0.0, |(_, error)| error)
}
