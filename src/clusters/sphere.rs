//! Bounding spheres.

use glam::{DVec3, Vec3};

use crate::mesh::value_bytes::store_fields;

/// Slack of radii, as a share: rounding to single precision must not leave a point outside.
const SLACK: f64 = 1e-6;

/// A sphere, in the mesh's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// Center.
    pub center: [f32; 3],
    /// Radius.
    pub radius: f32,
}

store_fields! { Sphere { center: [f32; 3], radius: f32 }; }

impl Sphere {
    /// Encloses spheres, of which points have radius 0, in one at the center of their bounding box.
    ///
    /// ```
    /// use neural_mesh::clusters::Sphere;
    /// let [a, b] = [-1.0, 2.0].map(|x| Sphere { center: [x, 0.0, 0.0], radius: 1.0 });
    /// let both = Sphere::enclose([a, b].into_iter());
    /// assert!(both.contains(&a) && both.contains(&b) && (2.5..2.51).contains(&both.radius));
    /// ```
    pub fn enclose(spheres: impl Iterator<Item = Self> + Clone) -> Self {
        let corners = spheres.clone().map(|sphere| {
            let (center, radius) = (sphere.center(), DVec3::splat(f64::from(sphere.radius)));
            (center - radius, center + radius)
        });
        let Some((low, high)) = corners.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { return Self::default() };
        // Distances count from the rounded center.
        let center = (0.5 * (low + high)).as_vec3();
        let reach = |sphere: Self| sphere.center().distance(center.as_dvec3()) + f64::from(sphere.radius);
        let radius = spheres.map(reach).fold(0.0, f64::max);
        Self { center: center.to_array(), radius: (radius * (1.0 + SLACK)) as f32 }
    }

    /// Returns whether all of another sphere is inside.
    pub fn contains(&self, other: &Self) -> bool {
        self.center().distance(other.center()) + f64::from(other.radius) <= f64::from(self.radius) * (1.0 + SLACK)
    }

    /// Returns the distance of a point from the sphere, 0 inside.
    pub fn distance(&self, point: [f32; 3]) -> f64 {
        (self.center().distance(Vec3::from(point).as_dvec3()) - f64::from(self.radius)).max(0.0)
    }

    fn center(&self) -> DVec3 {
        Vec3::from(self.center).as_dvec3()
    }
}
