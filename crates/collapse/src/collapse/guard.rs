//! The guard of thin shapes: how far both old vertices lie from the faces around the new one, exactly, eight at a time.
//!
//! Where a star is flat, planes tell enough. Around a tip or a thin edge a placement may be on all planes and still cut
//! the shape off; there a merge is refused if the errors that have added up exceed the pass's limit.

use crate::collapse::lanes::{
    EightIndices, EightLanes, Kernel, Vectors, clamp_unit, dot, splat_vector, squared_rest, subtract,
};
use crate::collapse::rings::Vertex;
use crate::collapse::vector::{self, Point};

/// Squared distances of two points from the faces of `x` and two of the border in a row, all seen from `origin`.
pub(crate) struct SquaredDistances<'a> {
    pub vertices: &'a [Vertex],
    /// The border, then nine readable indices of which the first closes it.
    pub border: &'a [u32],
    pub origin: Point,
    pub x: Point,
    pub ends: [Point; 2],
}

impl Kernel for SquaredDistances<'_> {
    type Output = [f32; 2];

    #[inline(always)]
    fn run<L: EightLanes>(self) -> [f32; 2] {
        let n = self.border.len() - 9;
        let apex = [self.origin[0] + self.x[0], self.origin[1] + self.x[1], self.origin[2] + self.x[2]];
        let apex = splat_vector::<L>(apex);
        let d = [
            splat_vector::<L>(vector::subtract(self.ends[0], self.x)),
            splat_vector(vector::subtract(self.ends[1], self.x)),
        ];
        let far = L::splat(f32::INFINITY);
        let mut least = [far, far];
        for j in 0..n.div_ceil(8) {
            let ids = &self.border[8 * j..8 * j + 9];
            let at: &EightIndices = ids.first_chunk().expect("there are nine");
            let next: &EightIndices = ids.last_chunk().expect("there are nine");
            let a = subtract(L::load_points(self.vertices, at), apex);
            let b = subtract(L::load_points(self.vertices, next), apex);
            let live = L::mask_first(n - 8 * j);
            for k in 0..2 {
                least[k] = live.select(measure_to_faces(d[k], a, b), far).min(least[k]);
            }
        }
        [least[0].find_least().0, least[1].find_least().0]
    }
}

/// Returns squared distances between `d` and eight triangles of the origin, `a` and `b`.
#[inline(always)]
fn measure_to_faces<L: EightLanes>(d: Vectors<L>, a: Vectors<L>, b: Vectors<L>) -> L {
    let (zero, one, tiny) = (L::splat(0.0), L::splat(1.0), L::splat(1e-30));
    let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
    let (da, db) = (dot(d, a), dot(d, b));
    let inverse = one / (aa * bb - ab * ab).max(tiny);
    let (s, t) = ((bb * da - ab * db) * inverse, (aa * db - ab * da) * inverse);
    let is_inside = s.greater(zero).and(t.greater(zero)).and((one - s).greater(t));
    // The next face measures the side b.
    let on_a = squared_rest(d, a, b, clamp_unit(da / aa.max(tiny)), zero);
    let far_side = clamp_unit(((db - da) + (aa - ab)) / ((aa - ab) + (bb - ab)).max(tiny));
    let on_far_side = squared_rest(d, a, b, one - far_side, far_side);
    is_inside.select(squared_rest(d, a, b, s, t), on_a.min(on_far_side))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collapse::lanes::{dispatch, run_plain};
    use crate::collapse::tests::measure::squared_distance_to_triangle;

    #[test]
    fn distances_are_those_to_the_nearest_triangle() {
        let n = 11;
        let around = |i: usize| {
            let angle = i as f32 * std::f32::consts::TAU / n as f32;
            [angle.cos() * (1.0 + 0.3 * (i % 3) as f32), angle.sin(), 0.2 * (i % 4) as f32]
        };
        let vertices: Vec<Vertex> = (0..n).map(|i| Vertex::new(around(i), i as u32)).collect();
        let border: Vec<u32> = (0..n as u32).chain([0; 9]).collect();
        let (origin, x) = ([0.1, -0.2, 0.3], [0.05, 0.1, -0.2]);
        for i in 0..40 {
            let end = |k: usize| [0, 1, 2].map(|j| ((i * 31 + k * 17 + j * 7) % 23) as f32 / 11.0 - 1.0);
            let kernel =
                || SquaredDistances { vertices: &vertices, border: &border, origin, x, ends: [end(0), end(1)] };
            let found = dispatch(kernel());
            assert_eq!(found, run_plain(kernel()));
            for k in 0..2 {
                let widen = |p: Point| p.map(f64::from);
                let apex = widen([0, 1, 2].map(|j| origin[j] + x[j]));
                let point = widen([0, 1, 2].map(|j| origin[j] + end(k)[j]));
                let exact = (0..n)
                    .map(|i| squared_distance_to_triangle(point, [apex, widen(around(i)), widen(around((i + 1) % n))]))
                    .fold(f64::INFINITY, f64::min);
                assert!((f64::from(found[k]) - exact).abs() < 1e-5, "{found:?} {exact}");
            }
        }
    }
}
