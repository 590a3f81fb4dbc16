//! Attribute quadrics (Hoppe 1999, "New quadric metric for simplifying meshes with appearance attributes"): what it costs the
//! colours at the corners that one vertex stands for a region.
//!
//! On a face a number is a linear function `g.x + d` of the place. A vertex at `x` with the number `s` costs the face
//! `w (g.x + d - s)^2`. The best `s` for a region is the mean of its functions at `x`; what is left then is a quadric of `x`
//! alone, made of sums that add up when regions merge. A region at a seam has no quadric: each of its sides would need
//! numbers of its own.

use glam::DVec3;

use crate::geometry::Quadric;
use crate::mesh::{Attributes, Channel, Role};

use crate::simplify::closed::cluster::assignment::Assignment;
use crate::simplify::closed::cluster::placement::Placement;
use crate::simplify::closed::original::Original;

/// Numbers of a colour, at most: red, green, blue, opacity.
const MOST: usize = 4;
/// The length, of a surface of unit size, that counts as much as a colour from dark to bright. It trades shape for
/// colour. Twelve painted training meshes: 0.005 is 16 % nearer and 4 % farther off in colour, 0.02 is 22 % farther and
/// 2 % nearer in colour.
const LENGTH: f64 = 0.01;
/// Squared sine of the angle at a corner below which a face is too thin to tell how a colour changes across it. Twelve
/// painted training meshes: at 1e-8 or 1e-4 no figure moves by more than 0.1 %.
const THIN: f64 = 1e-6;

/// The sums of a region about its vertex.
#[derive(Clone, Copy, Default)]
pub(super) struct AttributeQuadric {
    /// Sum of the faces' weights.
    weight: f64,
    /// Weighted sums of the gradients.
    gradients: [DVec3; MOST],
    /// Weighted sums of the numbers at the vertex.
    values: [f64; MOST],
    /// The sum of `w (g.x + d)^2` over faces and numbers.
    squares: Quadric,
}

impl AttributeQuadric {
    /// Adds a face of this weight on which a number has this gradient and this value at the vertex, for each number.
    fn add(&mut self, weight: f64, functions: impl Iterator<Item = (DVec3, f64)>) {
        self.weight += weight;
        for (k, (gradient, value)) in functions.take(MOST).enumerate() {
            self.gradients[k] += gradient * weight;
            self.values[k] += weight * value;
            self.squares += square(gradient, value, weight);
        }
    }

    /// The sums of both regions about the first one's vertex; `other` is where the second's is from there.
    pub fn united(&self, second: &Self, other: DVec3) -> Self {
        let second = second.about(-other);
        Self {
            weight: self.weight + second.weight,
            gradients: std::array::from_fn(|k| self.gradients[k] + second.gradients[k]),
            values: std::array::from_fn(|k| self.values[k] + second.values[k]),
            squares: self.squares + second.squares,
        }
    }

    /// The same about another place.
    pub fn about(&self, origin: DVec3) -> Self {
        let values = std::array::from_fn(|k| self.values[k] + self.gradients[k].dot(origin));
        Self { values, squares: self.squares.about(origin), ..*self }
    }

    /// What the best numbers cost, as a quadric of the place.
    pub fn cost(&self) -> Quadric {
        let share = if self.weight > 0.0 { 1.0 / self.weight } else { 0.0 };
        let means = self.gradients.iter().zip(self.values).map(|(&gradient, value)| square(gradient, value, share));
        let mut cost = means.fold(self.squares, |rest, mean| rest - mean);
        cost.c = cost.c.max(0.0);
        cost
    }
}

/// `weight (gradient.x + value)^2`.
fn square(gradient: DVec3, value: f64, weight: f64) -> Quadric {
    let DVec3 { x, y, z } = gradient;
    let a = [x * x, x * y, x * z, y * y, y * z, z * z].map(|entry| weight * entry);
    Quadric { a, b: gradient * (-weight * value), c: weight * value * value }
}

/// The quadrics of the regions' colours about their placed vertices; none where the corners carry no colour.
pub fn of_colours(
    original: &Original,
    assignment: &Assignment,
    placed: &Placement,
    attributes: &Attributes,
) -> AttributeQuadrics {
    let is_colour = |channel: &&Channel| channel.role == Role::Colour;
    let Some(channel) = attributes.channels.iter().find(is_colour) else { return AttributeQuadrics::default() };
    let surface = &original.surface;
    let region = |v: u32| assignment.region[v as usize] as usize;
    let mut at_seam = vec![false; assignment.n_regions];
    original.features.edges.iter().flatten().for_each(|&v| at_seam[region(v)] = true);
    let mut quadrics = vec![AttributeQuadric::default(); assignment.n_regions];
    let wedges = attributes.wedges.iter().zip(original.corner_orders());
    for (face, (wedges, order)) in surface.faces.iter().zip(wedges) {
        let colours = order.map(|corner| channel.of(wedges[corner as usize]));
        let Some(weights) = Weights::new(face.map(|v| surface.positions[v as usize].as_dvec3())) else { continue };
        for &v in face.iter().filter(|&&v| !at_seam[region(v)]) {
            let importance = surface.importance.get(v as usize).map_or(1.0, |&factor| f64::from(factor));
            let functions =
                (0..channel.width).map(|k| weights.function(colours.map(|c| c[k]), placed.position(region(v) as u32)));
            quadrics[region(v)].add(weights.area / 3.0 * importance, functions);
        }
    }
    AttributeQuadrics(quadrics)
}

/// The quadric of each vertex of a collapse; none where the corners carry nothing that counts.
#[derive(Clone, Default)]
pub struct AttributeQuadrics(Vec<AttributeQuadric>);

impl AttributeQuadrics {
    /// Whether nothing counts.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What a merge of two vertices costs, about the first one; `other` is where the second is from there.
    pub(super) fn price(&self, [u, v]: [u32; 2], other: DVec3) -> Quadric {
        self.0[u as usize].united(&self.0[v as usize], other).cost()
    }

    /// Takes note that `v`, which was at `other` from `u`, was merged into `u`, which moved by `step`.
    pub(super) fn merge(&mut self, [u, v]: [u32; 2], other: DVec3, step: DVec3) {
        if !self.is_empty() {
            self.0[u as usize] = self.0[u as usize].united(&self.0[v as usize], other).about(step);
        }
    }
}

/// The barycentric weights of a face as linear functions.
struct Weights {
    area: f64,
    /// Gradients of the first two weights; both are 0 at the third corner.
    gradients: [DVec3; 2],
    origin: DVec3,
}

impl Weights {
    /// Those of a triangle; `None` where it is too thin.
    fn new([a, b, origin]: [DVec3; 3]) -> Option<Self> {
        let (u, v) = (a - origin, b - origin);
        let normal = u.cross(v);
        let squared = normal.length_squared();
        let gradients = [v.cross(normal) / squared, normal.cross(u) / squared];
        let is_firm = squared > THIN * u.length_squared() * v.length_squared();
        is_firm.then_some(Self { area: 0.5 * squared.sqrt(), gradients, origin })
    }

    /// The gradient of a number with these values at the corners, and its value at `x`, as lengths; what is no number is 0.
    fn function(&self, values: [f32; 3], x: DVec3) -> (DVec3, f64) {
        let [a, b, c] =
            values.map(|value| if value.is_nan() { 0.0 } else { LENGTH * f64::from(value.clamp(0.0, 1.0)) });
        let gradient = self.gradients[0] * (a - c) + self.gradients[1] * (b - c);
        (gradient, c + gradient.dot(x - self.origin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear functions of the place: gradient, value at the origin, weight.
    const FUNCTIONS: [([f64; 3], f64, f64); 4] = [
        ([1.0, 0.0, 2.0], 0.5, 1.0),
        ([0.0, -1.0, 1.0], 0.25, 2.0),
        ([3.0, 1.0, 0.0], -1.0, 0.5),
        ([0.5; 3], 0.0, 1.5),
    ];

    fn naive(x: DVec3) -> f64 {
        let at = |(gradient, value, _): &([f64; 3], f64, f64)| DVec3::from(*gradient).dot(x) + value;
        let weight: f64 = FUNCTIONS.iter().map(|f| f.2).sum();
        let mean = FUNCTIONS.iter().map(|f| f.2 * at(f)).sum::<f64>() / weight;
        FUNCTIONS.iter().map(|f| f.2 * (at(f) - mean).powi(2)).sum()
    }

    fn quadric(functions: &[([f64; 3], f64, f64)], vertex: DVec3) -> AttributeQuadric {
        let mut quadric = AttributeQuadric::default();
        for &(gradient, value, weight) in functions {
            let gradient = DVec3::from(gradient);
            quadric.add(weight, std::iter::once((gradient, value + gradient.dot(vertex))));
        }
        quadric
    }

    #[test]
    fn a_quadric_is_what_the_best_number_costs() {
        let [first, second] = [DVec3::new(0.5, 1.0, -1.0), DVec3::new(2.0, 0.0, 1.0)];
        let (of_first, of_second) = FUNCTIONS.split_at(2);
        let both = quadric(of_first, first).united(&quadric(of_second, second), second - first);
        let step = DVec3::new(-0.5, 0.25, 1.0);
        for x in [DVec3::ZERO, DVec3::ONE, DVec3::new(3.0, -2.0, 0.5)] {
            assert!((both.cost().value(x - first) - naive(x)).abs() < 1e-9);
            assert!((both.about(step).cost().value(x - first - step) - naive(x)).abs() < 1e-9);
        }
        assert_eq!(AttributeQuadric::default().cost(), Quadric::default());
    }

    #[test]
    fn a_number_is_linear_on_its_face() {
        let corners = [DVec3::new(1.0, 0.0, 3.0), DVec3::new(0.0, 2.0, 1.0), DVec3::new(0.0, 0.0, 1.0)];
        let weights = Weights::new(corners).unwrap();
        let values = [0.25, 0.75, 1.0];
        for (corner, value) in corners.into_iter().zip(values) {
            assert!((weights.function(values, corner).1 - LENGTH * f64::from(value)).abs() < 1e-12);
        }
        assert!(Weights::new([DVec3::ZERO, DVec3::X, DVec3::X * 2.0]).is_none());
        assert_eq!(weights.function([f32::NAN; 3], corners[0]), (DVec3::ZERO, 0.0));
    }
}
