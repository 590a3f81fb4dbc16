//! Components whose loss is smaller than what it would cost to keep them.

use crate::collapse::{CollapseError, find_root};

use super::buffers::{IndexBuffers, IndexResult, measure_extent};
use super::weld::weld;

/// Drops components with a radius of at most a share of the extent; returns the faces that are left.
///
/// A radius is the largest distance of a component's vertices from their mean.
///
/// # Errors
/// Refuses indices out of range and coordinates that are not finite.
pub fn prune_components(buffers: &IndexBuffers, max_error: f32) -> Result<Vec<[u32; 3]>, CollapseError> {
    buffers.check()?;
    let components = BufferComponents::new(buffers);
    let most = max_error * measure_extent(buffers.positions);
    let stays = |face: &&[u32; 3]| components.radii[components.find(face[0])] > most;
    Ok(buffers.indices.iter().filter(stays).copied().collect())
}

/// The faces of components that stay, and the largest radius of those that go.
pub(super) struct KeptFaces {
    pub faces: Vec<u32>,
    pub radius: f32,
}

/// Drops the smallest components of a mesh by its result; returns nothing if all stay.
///
/// These are the ones within the result's error, and those within `max_radius` until `n_faces` of its faces are gone.
/// Components with locked vertices stay, and without a bound the largest one.
pub(super) fn drop_smallest(
    buffers: &IndexBuffers,
    result: &IndexResult,
    n_faces: usize,
    max_radius: f32,
) -> Option<KeptFaces> {
    let components = BufferComponents::new(buffers);
    let n = components.radii.len();
    let mut counts = vec![0; n];
    for face in &result.indices {
        counts[components.find(face[0])] += 1;
    }
    let mut may_go: Vec<bool> = components.radii.iter().map(|&radius| radius <= max_radius).collect();
    for (v, _) in buffers.locks.iter().enumerate().filter(|(_, is_locked)| **is_locked) {
        may_go[components.find(v as u32)] = false;
    }
    let mut order: Vec<usize> = (0..n).filter(|&c| counts[c] > 0).collect();
    order.sort_by(|&a, &b| components.radii[a].total_cmp(&components.radii[b]).then(a.cmp(&b)));
    if max_radius.is_infinite() {
        order.pop();
    }
    let mut is_dropped = vec![false; n];
    let (mut n_gone, mut radius) = (0, None);
    for component in order {
        let is_wanted = n_gone < n_faces || components.radii[component] <= result.error;
        if !is_wanted || !may_go[component] {
            continue;
        }
        n_gone += counts[component];
        is_dropped[component] = true;
        radius = Some(components.radii[component]);
    }
    let stays = |face: &u32| !is_dropped[components.find(buffers.indices[*face as usize][0])];
    radius.map(|radius| KeptFaces { faces: (0..buffers.indices.len() as u32).filter(stays).collect(), radius })
}

struct BufferComponents {
    /// The component of each vertex.
    numbers: Vec<u32>,
    radii: Vec<f32>,
}

impl BufferComponents {
    // Vertices at one position are in one component.
    fn new(buffers: &IndexBuffers) -> BufferComponents {
        let mut parents = weld(buffers.positions);
        for face in buffers.indices {
            let [a, b, c] = face.map(|v| find_root(&mut parents, v));
            let least = a.min(b).min(c);
            for root in [a, b, c] {
                parents[root as usize] = least;
            }
        }
        let n = parents.len();
        let numbers: Vec<u32> = (0..n as u32).map(|v| find_root(&mut parents, v)).collect();
        let (mut sums, mut counts) = (vec![[0.0f64; 3]; n], vec![0.0f64; n]);
        for (&c, p) in numbers.iter().zip(buffers.positions) {
            counts[c as usize] += 1.0;
            (0..3).for_each(|k| sums[c as usize][k] += f64::from(p[k]));
        }
        let mut radii = vec![0.0f32; n];
        for (&c, p) in numbers.iter().zip(buffers.positions) {
            let c = c as usize;
            let squared: f64 = (0..3).map(|k| (f64::from(p[k]) - sums[c][k] / counts[c]).powi(2)).sum();
            radii[c] = radii[c].max(squared.sqrt() as f32);
        }
        BufferComponents { numbers, radii }
    }

    fn find(&self, vertex: u32) -> usize {
        self.numbers[vertex as usize] as usize
    }
}
