//! The regions of the samples: their quadrics, and the sweeps that move their borders.
//!
//! The sweeps are the discrete Voronoi clustering of Valette and Chassery (2004) with the quadric energy: a
//! vertex goes to a neighbouring region where that lowers the sum of the two regions' errors, each at its own
//! best placement.

use crate::geometry::Quadric;

use super::darts::Assignment;
use super::surface::Surface;

/// Weight of the distance to the region's vertices against that to its planes; keeps every minimum unique.
const SWEEP_PULL: f32 = 1e-3;

/// The quadric of one vertex, with a pull toward it of `pull` times its weight.
pub(super) fn vertex_quadric(surface: &Surface, v: usize, pull: f32) -> Quadric {
    let mut a = surface.quadrics[v];
    let weight = pull * (a[0] + a[3] + a[5]);
    for diagonal in [0, 3, 5] {
        a[diagonal] += weight;
    }
    Quadric::around(a, surface.positions[v])
}

/// Moves border vertices between regions while the energy falls, at most `n_sweeps` times over the mesh.
///
/// Regions stay discs: a vertex moves only where it is a simple point of both regions.
pub(super) fn sweep(surface: &Surface, assignment: &mut Assignment, n_sweeps: usize) {
    if assignment.n_regions == surface.n_vertices() {
        return;
    }
    let mut quadrics = vec![Quadric::default(); assignment.n_regions];
    for (v, &region) in assignment.region.iter().enumerate() {
        quadrics[region as usize] += vertex_quadric(surface, v, SWEEP_PULL);
    }
    let energies = quadrics.iter().map(energy).collect();
    let mut state = Sweep { surface, region: &mut assignment.region, quadrics, energies };
    let mut due = vec![true; surface.n_vertices()];
    for _ in 0..n_sweeps {
        let mut next = vec![false; surface.n_vertices()];
        for v in 0..surface.n_vertices() as u32 {
            if due[v as usize] && state.improve(v) {
                next[v as usize] = true;
                surface.neighbors(v).iter().for_each(|&w| next[w as usize] = true);
            }
        }
        due = next;
    }
}

fn energy(quadric: &Quadric) -> f64 {
    quadric.minimum().map_or(0.0, |(_, value)| value)
}

struct Sweep<'a> {
    surface: &'a Surface,
    region: &'a mut Vec<u32>,
    quadrics: Vec<Quadric>,
    energies: Vec<f64>,
}

impl Sweep<'_> {
    /// Moves `v` to the region where it costs least, if that is another than its own.
    fn improve(&mut self, v: u32) -> bool {
        let own = self.region[v as usize];
        let Some(runs) = self.label_runs(v, own) else { return false };
        if runs.count(own) != 1 {
            return false;
        }
        let moved = vertex_quadric(self.surface, v as usize, SWEEP_PULL);
        let without = self.quadrics[own as usize] - moved;
        let energy_without = energy(&without);
        let saved = self.energies[own as usize] - energy_without;
        let mut best = None;
        let mut best_gain = 1e-9 * self.energies[own as usize];
        for &(label, count) in runs.as_slice() {
            if label == own || count != 1 || label as usize >= self.quadrics.len() {
                continue;
            }
            let with = self.quadrics[label as usize] + moved;
            let energy_with = energy(&with);
            let gain = saved + self.energies[label as usize] - energy_with;
            if gain > best_gain {
                best_gain = gain;
                best = Some((label, with, energy_with));
            }
        }
        let Some((label, with, energy_with)) = best else { return false };
        self.region[v as usize] = label;
        (self.quadrics[own as usize], self.energies[own as usize]) = (without, energy_without);
        (self.quadrics[label as usize], self.energies[label as usize]) = (with, energy_with);
        true
    }

    /// How often each label begins around `v`; `None` where all are `own` or there are too many.
    fn label_runs(&self, v: u32, own: u32) -> Option<Runs> {
        let ring = self.surface.rings.ring(v);
        let label = |w: u32| self.region.get(w as usize).copied().unwrap_or(u32::MAX);
        if ring.iter().all(|&w| label(w) == own) {
            return None;
        }
        let mut runs = Runs::default();
        let mut before = label(*ring.last()?);
        for &w in ring {
            let here = label(w);
            if here != before && !runs.add(here) {
                return None;
            }
            before = here;
        }
        Some(runs)
    }
}

/// A few labels with their counts.
#[derive(Default)]
struct Runs {
    entries: [(u32, u32); 12],
    n: usize,
}

impl Runs {
    fn add(&mut self, label: u32) -> bool {
        if let Some(entry) = self.entries[..self.n].iter_mut().find(|entry| entry.0 == label) {
            entry.1 += 1;
            return true;
        }
        let Some(slot) = self.entries.get_mut(self.n) else { return false };
        *slot = (label, 1);
        self.n += 1;
        true
    }

    fn count(&self, label: u32) -> u32 {
        self.as_slice().iter().find(|entry| entry.0 == label).map_or(0, |entry| entry.1)
    }

    fn as_slice(&self) -> &[(u32, u32)] {
        &self.entries[..self.n]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::closed::darts::throw_darts;
    use crate::simplify::closed::edge_lengths::EdgeLengths;
    use std::collections::HashSet;

    fn total_energy(surface: &Surface, assignment: &Assignment) -> f64 {
        let mut quadrics = vec![Quadric::default(); assignment.n_regions];
        for (v, &r) in assignment.region.iter().enumerate() {
            quadrics[r as usize] += vertex_quadric(surface, v, SWEEP_PULL);
        }
        quadrics.iter().map(energy).sum()
    }

    /// The naive twin of the simple-point test: a region of a closed surface is a disc.
    fn is_disc(surface: &Surface, assignment: &Assignment, region: u32) -> bool {
        let inside = |v: u32| assignment.region[v as usize] == region;
        let vertices: Vec<u32> = (0..surface.n_vertices() as u32).filter(|&v| inside(v)).collect();
        let mut edges = HashSet::new();
        let mut n_faces = 0;
        for &[a, b, c] in &surface.faces {
            let within = |&[u, v]: &[u32; 2]| inside(u) && inside(v);
            edges.extend([[a, b], [b, c], [c, a]].into_iter().filter(within).map(|[u, v]| [u.min(v), u.max(v)]));
            n_faces += i64::from([a, b, c].into_iter().all(inside));
        }
        let mut reached = HashSet::from([vertices[0]]);
        let mut pending = vec![vertices[0]];
        while let Some(v) = pending.pop() {
            let joined = surface.neighbors(v).iter().filter(|&&w| inside(w));
            pending.extend(joined.filter(|&&w| reached.insert(w)));
        }
        reached.len() == vertices.len() && vertices.len() as i64 - edges.len() as i64 + n_faces == 1
    }

    #[test]
    fn sweeps_lower_the_energy_and_keep_discs() {
        for (mesh, n) in [(shapes::wavy_sphere(3, 10.0), 60), (shapes::torus(32, 12, 1.0, 0.3), 40)] {
            let surface = Surface::new(&mesh);
            let lengths = EdgeLengths::new(&surface);
            for seed in 0..3 {
                let mut assignment = throw_darts(&surface, &lengths, n, seed);
                let discs = |a: &Assignment| -> Vec<bool> {
                    (0..a.n_regions as u32).map(|r| is_disc(&surface, a, r)).collect()
                };
                let (before, discs_before) = (total_energy(&surface, &assignment), discs(&assignment));
                sweep(&surface, &mut assignment, 2);
                let after = total_energy(&surface, &assignment);
                assert!(after < 0.9 * before, "{before} {after}");
                let still: Vec<bool> = discs(&assignment);
                assert!(discs_before.iter().zip(still).all(|(before, after)| !before || after));
            }
        }
    }
}
