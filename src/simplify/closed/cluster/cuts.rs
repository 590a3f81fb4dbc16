//! Density that follows error: the regions that cost far more than the others are cut in two, again and again.
//!
//! On scans there are few such regions. On parts with flat faces and sharp edges a few regions that swallowed a
//! corner hold nearly all of the error, and no later step can give it back.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::assignment::Assignment;
use super::placement::PULL;
use super::quotient::{far_half, members};
use super::sums::Sum;
use crate::simplify::closed::prepare::surface::Surface;

/// A region is costly from this many times the mean error on. Twelve large training meshes at ratios 0.03 to 0.15: the
/// mean distance is 0.5 % farther at 2 and 1.0 % at 8, the largest 4 % at 8.
const COSTLY: f64 = 4.0;
/// Share of the whole error in costly regions above which they are cut. Twelve large training meshes at ratios 0.03 to
/// 0.15: the mean distance is 0.3 % nearer at 0.1 and 1.1 % farther at 0.4.
const HEAVY: f64 = 0.2;
/// How often the mean is taken anew: a bound. At 4 and at 16 none of 48 results of twelve large training meshes
/// differs.
const ROUNDS: usize = 8;
/// Regions that are cut between two beats: at a few microseconds each, about ten milliseconds.
const TOGETHER: usize = 4096;

/// Cuts costly regions in two while they hold much of the error, at most until there are `most_regions`, and keeps the
/// sums of the regions in step.
pub fn cut_costly(surface: &Surface, assignment: &mut Assignment, sums: &mut Vec<Sum>, most_regions: usize) {
    let mut errors = surface.pulse.map(sums, error);
    // The vertices of the regions that were looked at.
    let mut vertices_of = BTreeMap::new();
    for _ in 0..ROUNDS {
        surface.pulse.beat(0);
        let Some(costly) = costly_regions(&errors) else { break };
        let mut is_new = vec![false; assignment.n_regions];
        costly.iter().for_each(|r| is_new[*r as usize] = !vertices_of.contains_key(r));
        vertices_of.append(&mut members(surface.pulse, assignment, &is_new));
        let regions = costly.iter().filter_map(|r| vertices_of.remove(r)).filter(|vertices| vertices.len() > 1);
        let regions: Vec<Vec<u32>> = regions.take(most_regions.saturating_sub(assignment.n_regions)).collect();
        let mut halves: Vec<[Part; 2]> = Vec::with_capacity(regions.len());
        for numbers in surface.pulse.counting_if(false).by(TOGETHER, 0..regions.len()) {
            halves.par_extend(regions[numbers].par_iter().map(|vertices| Part::halves(surface, vertices)));
        }
        for (n_before, ([near, far], vertices)) in halves.into_iter().zip(&regions).enumerate() {
            if n_before % TOGETHER == 0 {
                surface.pulse.beat(0);
            }
            let (old, new) = (assignment.region[vertices[0] as usize], assignment.n_regions as u32);
            assignment.n_regions += 1;
            far.vertices.iter().for_each(|&v| assignment.region[v as usize] = new);
            (sums[old as usize], errors[old as usize]) = (near.sum, error(&near.sum));
            sums.push(far.sum);
            errors.push(error(&far.sum));
            vertices_of.extend([(old, near.vertices), (new, far.vertices)]);
        }
        if assignment.n_regions >= most_regions {
            break;
        }
    }
}

/// The regions that cost far more than the mean; `None` where they hold little of the error.
fn costly_regions(errors: &[f64]) -> Option<Vec<u32>> {
    let total: f64 = errors.iter().sum();
    let limit = COSTLY * total / errors.len() as f64;
    let costly: Vec<u32> = (0..errors.len() as u32).filter(|&r| errors[r as usize] > limit).collect();
    let held: f64 = costly.iter().map(|&r| errors[r as usize]).sum();
    (held > HEAVY * total).then_some(costly)
}

/// A part of a region.
struct Part {
    vertices: Vec<u32>,
    sum: Sum,
}

impl Part {
    /// The half of a region that holds its first vertex, and the far one.
    fn halves(surface: &Surface, region: &[u32]) -> [Self; 2] {
        let far = far_half(surface, region);
        let near = region.iter().filter(|v| far.binary_search(v).is_err()).copied().collect();
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
