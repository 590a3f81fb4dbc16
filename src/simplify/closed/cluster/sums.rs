//! What the regions of the samples sum up to: plane quadrics, weights, positions, normals.

use std::ops::AddAssign;

use glam::DVec3;

use crate::geometry::Quadric;
use crate::mesh::shares::add_to_rows;

use super::assignment::Assignment;
use crate::simplify::closed::prepare::surface::Surface;

/// Weighted sums over the vertices of a region.
#[derive(Clone, Copy, Default)]
pub struct Sum {
    /// The planes.
    pub planes: Quadric,
    /// The weights: areas times importance.
    pub weight: f64,
    /// Weighted sum of the positions.
    pub position: DVec3,
    /// Weighted sum of the squared positions.
    pub squared: f64,
    /// Weighted sum of the normals.
    pub normal: DVec3,
}

impl Sum {
    /// The sum over one vertex.
    pub fn of(surface: &Surface, v: usize) -> Self {
        let weight = surface.weight(v);
        let p = surface.positions[v].as_dvec3();
        Self {
            planes: Quadric::around(surface.quadrics[v], surface.positions[v]),
            weight,
            position: p * weight,
            squared: p.length_squared() * weight,
            normal: surface.normals[v].as_dvec3() * weight,
        }
    }

    /// The planes, and the distances to the vertices with `pull` times their weight.
    pub fn quadric(&self, pull: f64) -> Quadric {
        let mut sum = self.planes;
        [0, 3, 5].into_iter().for_each(|diagonal| sum.a[diagonal] += pull * self.weight);
        sum.b += self.position * pull;
        sum.c += self.squared * pull;
        sum
    }

    /// The mean of the vertices.
    pub fn mean(&self) -> DVec3 {
        self.position / self.weight
    }

    /// Mean squared distance of the vertices from their mean.
    pub fn variance(&self) -> f64 {
        (self.squared / self.weight - self.mean().length_squared()).max(0.0)
    }
}

impl AddAssign for Sum {
    fn add_assign(&mut self, other: Self) {
        self.planes += other.planes;
        self.weight += other.weight;
        self.position += other.position;
        self.squared += other.squared;
        self.normal += other.normal;
    }
}

/// The sums of all regions.
pub fn sums(surface: &Surface, assignment: &Assignment) -> Vec<Sum> {
    let mut sums = vec![Sum::default(); assignment.n_regions];
    add_to_rows(surface.pulse, &mut sums, &assignment.region, |sum, v| *sum += Sum::of(surface, v));
    sums
}
