//! Attribute quadrics (Hoppe 1999, "New quadric metric for simplifying meshes with appearance attributes").
//!
//! On a face a value is a linear function `g.x + d`. A vertex at `x` with value `s` costs `w (g.x + d - s)^2`. For the
//! best `s`, the weighted mean, the cost is a quadric of `x`.

use std::ops::Range;

use glam::DVec3;

use crate::geometry::Quadric;
use crate::mesh::{Attributes, Channel, Role};

use crate::simplify::closed::original::Original;

/// Number of values: red, green, blue, opacity, and three of a normal.
const N_VALUES: usize = 7;
const KINDS: [Range<usize>; 2] = [0..4, 4..N_VALUES];
/// Distance, at unit size, that costs as much as a colour change from 0 to 1.
// Twelve painted meshes: at 0.005 distances are 16 % smaller and colour errors 4 % larger.
const LENGTH: f64 = 0.01;
/// Distance, at unit size, that costs as much as a change of a normal's component by 1.
// Fourteen meshes: at 0.003 normal errors fall by 18 % and distances grow by 10 %, at 0.006 by 20 and 18 %.
const NORMAL_LENGTH: f64 = 0.005;
/// `NORMAL_LENGTH` where small faces weigh more than their areas, which alone keeps most bevels.
// Twenty props: at 0.005 the largest distance is 9 % larger, and normal errors 25 % smaller; at 0.0005 7 % smaller and 19 % larger.
const NORMAL_LENGTH_OF_PROPS: f64 = 0.0015;
/// Squared sine of a corner angle below which a face is too thin for gradients.
// 1e-8 or 1e-4 change nothing by 0.1 %.
const THIN: f64 = 1e-6;

#[derive(Clone, Copy, Default)]
pub(super) struct AttributeQuadric {
    weights: [f64; 2],
    gradients: [DVec3; N_VALUES],
    values: [f64; N_VALUES],
    squares: Quadric,
}

impl AttributeQuadric {
    /// Adds a face with its weight; `functions` are each value's gradient, and value at the vertex.
    fn add(&mut self, kind: usize, weight: f64, functions: impl Iterator<Item = (DVec3, f64)>) {
        self.weights[kind] += weight;
        for (k, (gradient, value)) in KINDS[kind].clone().zip(functions) {
            self.gradients[k] += gradient * weight;
            self.values[k] += weight * value;
            self.squares += square(gradient, value, weight);
        }
    }

    /// Returns the sum of two vertices' quadrics about the first vertex; `other` is the second one's offset.
    pub fn sum_with(&self, second: &Self, other: DVec3) -> Self {
        // Both sums must be about the same point before they add up.
        let second = second.shift_origin(-other);
        Self {
            weights: std::array::from_fn(|kind| self.weights[kind] + second.weights[kind]),
            gradients: std::array::from_fn(|k| self.gradients[k] + second.gradients[k]),
            values: std::array::from_fn(|k| self.values[k] + second.values[k]),
            squares: self.squares + second.squares,
        }
    }

    pub fn shift_origin(&self, origin: DVec3) -> Self {
        let values = std::array::from_fn(|k| self.values[k] + self.gradients[k].dot(origin));
        Self { values, squares: self.squares.with_origin(origin), ..*self }
    }

    /// Returns the cost of each position with the best values there, as a quadric, for two vertices' quadrics together.
    ///
    /// It is about the first vertex; `other` is the second one's offset.
    fn cost_with(&self, second: &Self, other: DVec3) -> Quadric {
        // The remaining cost is the variance: the sum of squares less the square of the mean, per value.
        let mut cost = self.squares + second.squares.with_origin(-other);
        for (kind, values) in KINDS.into_iter().enumerate() {
            let weight = self.weights[kind] + second.weights[kind];
            // A mesh without colours, or with a seam here, has no values of that kind to sum up.
            for k in values.filter(|_| weight > 0.0) {
                let gradient = self.gradients[k] + second.gradients[k];
                let value = self.values[k] + (second.values[k] + second.gradients[k].dot(-other));
                cost -= square(gradient, value, 1.0 / weight);
            }
        }
        // Rounding may leave a tiny negative constant.
        cost.c = cost.c.max(0.0);
        cost
    }
}

fn square(gradient: DVec3, value: f64, weight: f64) -> Quadric {
    let DVec3 { x, y, z } = gradient;
    let a = [x * x, x * y, x * z, y * y, y * z, z * z].map(|entry| weight * entry);
    Quadric { a, b: gradient * (-weight * value), c: weight * value * value }
}

pub fn sum_attribute_quadrics(original: &Original) -> AttributeQuadrics {
    let Some(attributes) = original.attributes.as_deref() else { return AttributeQuadrics::default() };
    let counted = CountedChannels::new(original, attributes);
    if counted.channels.iter().all(Option::is_none) {
        return AttributeQuadrics::default();
    }
    let surface = &original.surface;
    let mut quadrics = vec![AttributeQuadric::default(); surface.n_vertices()];
    let wedges = attributes.wedges.iter().zip(original.corner_orders());
    for (face, (wedges, order)) in surface.faces.iter().zip(wedges) {
        // The surface may wind a face the other way than the mesh.
        let wedges = order.map(|corner| wedges[corner as usize]);
        let corners = face.map(|v| surface.positions[v as usize].as_dvec3());
        let Some(weights) = LinearWeights::new(corners) else { continue };
        for (&v, corner) in face.iter().zip(corners) {
            // Attributes count by the same importance as planes.
            let importance = surface.importance.get(v as usize).map_or(1.0, |&factor| f64::from(factor));
            for (kind, channel) in counted.kinds_at(v) {
                let numbers =
                    (0..channel.width).map(|k| wedges.map(|wedge| counted.length(kind, channel.value(wedge)[k])));
                let functions = numbers.map(|numbers| weights.function(numbers, corner));
                quadrics[v as usize].add(kind, weights.area / 3.0 * importance, functions);
            }
        }
    }
    AttributeQuadrics(quadrics)
}

struct CountedChannels<'a> {
    channels: [Option<&'a Channel>; 2],
    at_seam: [Vec<bool>; 2],
    normal_length: f64,
}

impl<'a> CountedChannels<'a> {
    fn new(original: &Original, attributes: &'a Attributes) -> Self {
        // At seams and hard edges each side would need its own values, so vertices there get no quadrics.
        let ends_of = |edges: &mut dyn Iterator<Item = [u32; 2]>| {
            let mut touched = vec![false; original.surface.n_vertices()];
            edges.flatten().for_each(|v| touched[v as usize] = true);
            touched
        };
        let features = &original.features;
        let is_prop = !original.surface.area_weights.is_plain();
        Self {
            normal_length: if is_prop { NORMAL_LENGTH_OF_PROPS } else { NORMAL_LENGTH },
            channels: [attributes.channel(Role::Colour), attributes.normals()],
            // Colours stop at every feature edge, normals at hard edges alone.
            at_seam: [ends_of(&mut features.edges.iter().copied()), ends_of(&mut features.hard_edges())],
        }
    }

    fn kinds_at(&self, v: u32) -> impl Iterator<Item = (usize, &'a Channel)> {
        let counts = move |kind: &usize| !self.at_seam[*kind][v as usize];
        (0..KINDS.len()).filter(counts).filter_map(|kind| Some((kind, self.channels[kind]?)))
    }

    fn length(&self, kind: usize, number: f32) -> f64 {
        match (number.is_nan(), kind) {
            (true, _) => 0.0,
            (_, 0) => LENGTH * f64::from(number.clamp(0.0, 1.0)),
            _ => self.normal_length * f64::from(number.clamp(-1.0, 1.0)),
        }
    }
}

#[derive(Clone, Default)]
pub struct AttributeQuadrics(Vec<AttributeQuadric>);

impl AttributeQuadrics {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn has_quadric_at(&self, v: u32) -> bool {
        self.0.get(v as usize).is_some_and(|quadric| quadric.weights != [0.0; 2])
    }

    /// Returns the cost of a merge as a quadric about the first vertex; `other` is the second one's offset.
    pub(super) fn price(&self, [u, v]: [u32; 2], other: DVec3) -> Quadric {
        self.0[u as usize].cost_with(&self.0[v as usize], other)
    }

    pub(super) fn merge(&mut self, [u, v]: [u32; 2], other: DVec3, step: DVec3) {
        if !self.is_empty() {
            self.0[u as usize] = self.0[u as usize].sum_with(&self.0[v as usize], other).shift_origin(step);
        }
    }
}

/// Barycentric weights of a face as linear functions of the position.
struct LinearWeights {
    area: f64,
    gradients: [DVec3; 2],
    origin: DVec3,
}

impl LinearWeights {
    fn new([a, b, origin]: [DVec3; 3]) -> Option<Self> {
        let (u, v) = (a - origin, b - origin);
        let normal = u.cross(v);
        // Gradients of barycentric weights lie in the plane, perpendicular to the opposite edge.
        let squared = normal.length_squared();
        let gradients = [v.cross(normal) / squared, normal.cross(u) / squared];
        let has_gradients = squared > THIN * u.length_squared() * v.length_squared();
        has_gradients.then_some(Self { area: 0.5 * squared.sqrt(), gradients, origin })
    }

    /// Interpolates a value given at the corners: returns its gradient, and the value at `x`.
    fn function(&self, [a, b, c]: [f64; 3], x: DVec3) -> (DVec3, f64) {
        let gradient = self.gradients[0] * (a - c) + self.gradients[1] * (b - c);
        (gradient, c + gradient.dot(x - self.origin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FUNCTIONS: [([f64; 3], f64, f64); 4] = [
        ([1.0, 0.0, 2.0], 0.5, 1.0),
        ([0.0, -1.0, 1.0], 0.25, 2.0),
        ([3.0, 1.0, 0.0], -1.0, 0.5),
        ([0.5; 3], 0.0, 1.5),
    ];

    fn naive(x: DVec3) -> f64 {
        let value_at_point = |(gradient, value, _): &([f64; 3], f64, f64)| DVec3::from(*gradient).dot(x) + value;
        let weight: f64 = FUNCTIONS.iter().map(|f| f.2).sum();
        let mean = FUNCTIONS.iter().map(|f| f.2 * value_at_point(f)).sum::<f64>() / weight;
        FUNCTIONS.iter().map(|f| f.2 * (value_at_point(f) - mean).powi(2)).sum()
    }

    fn quadric(functions: &[([f64; 3], f64, f64)], vertex: DVec3) -> AttributeQuadric {
        let mut quadric = AttributeQuadric::default();
        for &(gradient, value, weight) in functions {
            let gradient = DVec3::from(gradient);
            quadric.add(0, weight, std::iter::once((gradient, value + gradient.dot(vertex))));
        }
        quadric
    }

    #[test]
    fn a_quadric_is_what_the_best_number_costs() {
        let [first, second] = [DVec3::new(0.5, 1.0, -1.0), DVec3::new(2.0, 0.0, 1.0)];
        let (of_first, of_second) = FUNCTIONS.split_at(2);
        let [of_first, of_second] = [quadric(of_first, first), quadric(of_second, second)];
        let cost = of_first.cost_with(&of_second, second - first);
        let none = AttributeQuadric::default();
        let both = of_first.sum_with(&of_second, second - first);
        let step = DVec3::new(-0.5, 0.25, 1.0);
        for x in [DVec3::ZERO, DVec3::ONE, DVec3::new(3.0, -2.0, 0.5)] {
            assert!((cost.value(x - first) - naive(x)).abs() < 1e-9);
            let moved = both.shift_origin(step).cost_with(&none, DVec3::ZERO);
            assert!((moved.value(x - first - step) - naive(x)).abs() < 1e-9);
        }
        assert_eq!(none.cost_with(&none, DVec3::ONE), Quadric::default());
    }

    #[test]
    fn a_number_is_linear_on_its_face() {
        let corners = [DVec3::new(1.0, 0.0, 3.0), DVec3::new(0.0, 2.0, 1.0), DVec3::new(0.0, 0.0, 1.0)];
        let weights = LinearWeights::new(corners).unwrap();
        let values = [0.25, 0.75, 1.0];
        for (corner, value) in corners.into_iter().zip(values) {
            assert!((weights.function(values, corner).1 - value).abs() < 1e-12);
        }
        assert!(LinearWeights::new([DVec3::ZERO, DVec3::X, DVec3::X * 2.0]).is_none());
        let counted = CountedChannels { channels: [None; 2], at_seam: Default::default(), normal_length: 1.0 };
        assert_eq!(weights.function([counted.length(1, f32::NAN); 3], corners[0]), (DVec3::ZERO, 0.0));
    }
}
