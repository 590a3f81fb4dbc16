//! Density that follows error: the regions that cost far more than the others are cut in two, again and again.
//!
//! On scans there are few such regions. On parts with flat faces and sharp edges a few regions that swallowed a
//! corner hold nearly all of the error, and no later step can give it back.

use rustc_hash::FxHashMap;

use super::darts::Assignment;
use super::placement::PULL;
use super::quotient::cut_region;
use super::regions::Sum;
use super::surface::Surface;

/// A region is costly from this many times the mean error on.
const COSTLY: f64 = 4.0;
/// Share of the whole error in costly regions above which they are cut.
const HEAVY: f64 = 0.2;
/// How often the mean is taken anew.
const ROUNDS: usize = 8;

/// Cuts costly regions in two while they hold much of the error, at most until there are `most_regions`, and keeps the
/// sums of the regions in step.
pub(super) fn cut_costly(surface: &Surface, assignment: &mut Assignment, sums: &mut Vec<Sum>, most_regions: usize) {
    let mut errors: Vec<f64> = sums.iter().map(error).collect();
    let mut members = FxHashMap::default();
    for _ in 0..ROUNDS {
        let total: f64 = errors.iter().sum();
        let limit = COSTLY * total / errors.len() as f64;
        let costly: Vec<u32> = (0..errors.len() as u32).filter(|&r| errors[r as usize] > limit).collect();
        if costly.iter().map(|&r| errors[r as usize]).sum::<f64>() <= HEAVY * total {
            break;
        }
        gather(assignment, &costly, &mut members);
        for r in costly {
            if assignment.n_regions >= most_regions {
                return;
            }
            let Some(whole) = members.remove(&r).filter(|whole| whole.len() > 1) else { continue };
            cut_region(surface, assignment, &whole);
            let (stay, go): (Vec<u32>, Vec<u32>) = whole.into_iter().partition(|&v| assignment.region[v as usize] == r);
            let [rest, cut] = [&stay, &go].map(|part| sum(surface, part));
            (sums[r as usize], errors[r as usize]) = (rest, error(&rest));
            sums.push(cut);
            errors.push(error(&cut));
            members.extend([(r, stay), (errors.len() as u32 - 1, go)]);
        }
    }
}

/// Lists the vertices of those of the regions that have no list yet.
fn gather(assignment: &Assignment, regions: &[u32], members: &mut FxHashMap<u32, Vec<u32>>) {
    let mut wanted = vec![false; assignment.n_regions];
    for &r in regions {
        members.entry(r).or_insert_with(|| {
            wanted[r as usize] = true;
            Vec::new()
        });
    }
    if !wanted.contains(&true) {
        return;
    }
    for (v, r) in assignment.region.iter().enumerate().filter(|(_, r)| wanted[**r as usize]) {
        members.entry(*r).or_default().push(v as u32);
    }
}

fn sum(surface: &Surface, vertices: &[u32]) -> Sum {
    let mut sum = Sum::default();
    vertices.iter().for_each(|&v| sum += Sum::of(surface, v as usize));
    sum
}

/// The error of a region at its best placement.
fn error(sum: &Sum) -> f64 {
    sum.quadric(f64::from(PULL)).minimum().map_or(0.0, |(_, error)| error)
}
