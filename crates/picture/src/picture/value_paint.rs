//! Vertex values as colours, with contour lines.

use glam::{Vec2, Vec3};

use super::pixels::from_srgb;

// Six steps of ColorBrewer's RdYlBu (Apache 2.0), low to high: light enough for dark lines, and safe for red-green
// blindness.
const STEPS: [[u8; 3]; 6] =
    [[215, 48, 39], [252, 141, 89], [254, 224, 144], [224, 243, 248], [145, 191, 219], [69, 117, 180]];
// Colour of faces without a value, in linear light.
const NO_VALUE: Vec3 = Vec3::splat(0.25);
// Colour of contour lines, in linear light, and half their width in samples.
const LINE: Vec3 = Vec3::new(0.012, 0.022, 0.045);
const HALF_LINE: f32 = 1.8;

/// Scale of values in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Value of the last colour, above 0; the first is 0.
    pub end: f64,
    /// Number of contour lines, evenly spaced up to the end.
    pub lines: usize,
}

pub struct ValuePaint<'a> {
    // Projected vertices in samples, with the inverse depth as z, n_vertices.
    pub points: &'a [Vec3],
    // n_faces x 3.
    pub faces: &'a [[u32; 3]],
    // Values, n_vertices; not finite if missing.
    pub values: &'a [f64],
    pub scale: Scale,
}

impl ValuePaint<'_> {
    /// Returns the colour of a face at a point in sample coordinates, in linear light.
    pub fn colour(&self, face: u32, at: Vec2) -> Vec3 {
        let share = |at: Vec2| self.value(face, at) / self.scale.end as f32;
        let here = share(at);
        // One missing value makes the whole face grey.
        if !here.is_finite() {
            return NO_VALUE;
        }
        let slope = Vec2::new(share(at + Vec2::X) - here, share(at + Vec2::Y) - here).length();
        step_colour(here).lerp(LINE, 0.85 * self.line(here, slope))
    }

    /// Returns the share of a sample that a contour line covers.
    fn line(&self, share: f32, slope: f32) -> f32 {
        let along = share * self.scale.lines as f32;
        // The value 0 has no line, as it would cover whole areas.
        if along < 0.5 {
            return 0.0;
        }
        let samples = (along - along.round()).abs() / (slope * self.scale.lines as f32).max(1e-12);
        (HALF_LINE + 0.5 - samples).clamp(0.0, 1.0)
    }

    fn value(&self, face: u32, at: Vec2) -> f32 {
        let corners = self.faces[face as usize].map(|v| v as usize);
        let [a, b, c] = corners.map(|v| self.points[v].truncate() - at);
        // Values are linear in space: weights on the picture are multiplied by the inverse depth.
        let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let terms = [0, 1, 2].map(|k| (weights[k] * self.points[corners[k]].z, self.values[corners[k]] as f32));
        let total: f32 = terms.iter().map(|(weight, _)| weight).sum();
        terms.iter().map(|(weight, value)| weight * value).sum::<f32>() / total
    }
}

fn step_colour(share: f32) -> Vec3 {
    let along = share.clamp(0.0, 1.0) * (STEPS.len() - 1) as f32;
    let low = (along as usize).min(STEPS.len() - 2);
    from_srgb(STEPS[low]).lerp(from_srgb(STEPS[low + 1]), along - low as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_tilted_triangle(lines: usize, check: impl Fn(&ValuePaint)) {
        let points = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(300.0, 0.0, 0.5), Vec3::new(0.0, 300.0, 0.25)];
        let scale = Scale { end: 2.0, lines };
        check(&ValuePaint { points: &points, faces: &[[0, 1, 2]], values: &[0.0, 1.0, 2.0], scale });
    }

    #[test]
    fn values_are_linear_in_space_not_on_the_picture() {
        check_tilted_triangle(0, |paint| {
            for (corner, value) in [(0, 0.0), (1, 1.0), (2, 2.0)] {
                assert!((paint.value(0, paint.points[corner].truncate()) - value).abs() < 1e-5);
            }
            // Half way on the picture between depths 1 and 2 lies a third of the way in space.
            assert!((paint.value(0, Vec2::new(150.0, 0.0)) - 1.0 / 3.0).abs() < 1e-5);
        });
    }

    #[test]
    fn lines_lie_where_the_value_is_a_multiple() {
        let is_dark = |paint: &ValuePaint, x: f32| paint.colour(0, Vec2::new(x, 0.0)).max_element() < 0.2;
        check_tilted_triangle(4, |paint| {
            // The value 0.5 lies half way in space between depths 1 and 2: at two thirds on the picture.
            assert!(is_dark(paint, 200.0) && !is_dark(paint, 190.0) && !is_dark(paint, 210.0) && !is_dark(paint, 3.0));
        });
        check_tilted_triangle(0, |paint| assert!((10..290).all(|x| !is_dark(paint, x as f32))));
    }

    #[test]
    fn what_has_no_value_is_grey() {
        let points = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(9.0, 0.0, 1.0), Vec3::new(0.0, 9.0, 1.0)];
        let scale = Scale { end: 2.0, lines: 4 };
        let paint = ValuePaint { points: &points, faces: &[[0, 1, 2]], values: &[0.0, f64::INFINITY, 1.0], scale };
        assert_eq!(paint.colour(0, Vec2::new(2.0, 2.0)), NO_VALUE);
    }
}
