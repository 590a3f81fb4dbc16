//! Samples of the input and the nearest points of the result: what each sample asks of the vertices of its face.

use crate::collapse::lanes::{
    EightIndices, EightLanes, Kernel, Vectors, clamp_unit, dot, splat_vector, squared_rest, subtract,
};
use crate::collapse::rings::{NONE, Rings};
use crate::collapse::vector::{self, Point};

/// Stars that a sample may try.
const N_STARS: usize = 5;

/// Squared distance, over the usual, up to which samples have about the same weight.
const FULL_WEIGHT: f32 = 0.3;

/// Largest ring of a star; vertices beyond are left where they are.
const LARGEST_RING: usize = 16;

/// A point of the input, weighted by the area of its face, twice.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sample {
    pub point: Point,
    pub weight: f32,
}

/// The normal equations of one vertex, in which near samples count more, and sums of squared distances and of areas. The
/// matrix is xx, xy, xz, yy, yz, zz.
#[derive(Clone, Copy, Default)]
pub(crate) struct SampleMoments {
    pub matrix: [f32; 6],
    pub right: Point,
    pub squares: f32,
    pub area: f32,
}

impl SampleMoments {
    pub(crate) fn add(&mut self, other: &SampleMoments) {
        for k in 0..6 {
            self.matrix[k] += other.matrix[k];
        }
        for k in 0..3 {
            self.right[k] += other.right[k];
        }
        self.squares += other.squares;
        self.area += other.area;
    }

    pub(crate) fn trace(&self) -> f32 {
        self.matrix[0] + self.matrix[3] + self.matrix[5]
    }

    /// Solves for the step, with `pull` times the trace on the diagonal; zero without samples.
    pub(crate) fn solve(&self, pull: f32) -> Point {
        let pull = pull * self.trace();
        // Also where the sums are NaN.
        if pull.is_nan() || pull <= 0.0 {
            return [0.0; 3];
        }
        let [xx, xy, xz, yy, yz, zz] = self.matrix;
        let (xx, yy, zz) = (xx + pull, yy + pull, zz + pull);
        let (l10, l20) = (xy / xx, xz / xx);
        let pivot1 = yy - l10 * xy;
        let rest = yz - l20 * xy;
        let l21 = rest / pivot1;
        let pivot2 = zz - l20 * xz - l21 * rest;
        let b = self.right;
        let y1 = b[1] - l10 * b[0];
        let y2 = b[2] - l20 * b[0] - l21 * y1;
        let z = y2 / pivot2;
        let y = y1 / pivot1 - l21 * z;
        [b[0] / xx - l10 * y - l20 * z, y, z]
    }
}

/// Sums the moments of the vertices from `first` on; those of others go to `elsewhere`.
pub(crate) struct SumSamples<'a> {
    pub rings: &'a Rings,
    /// Where each vertex' samples start.
    pub starts: &'a [u32],
    pub samples: &'a [Sample],
    pub farthest: f32,
    /// Mean squared distance of all samples, about.
    pub usual: f32,
    pub first: usize,
    pub out: &'a mut [SampleMoments],
    pub elsewhere: &'a mut Vec<(u32, SampleMoments)>,
}

/// The nearest point of a star: squared distance, the place of its face, and the weights of the face's other two ends.
#[derive(Clone, Copy)]
struct NearestInStar {
    squared: f32,
    place: usize,
    weights: [f32; 2],
}

impl Kernel for SumSamples<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: EightLanes>(mut self) {
        for v in self.first..self.first + self.out.len() {
            let samples = &self.samples[self.starts[v] as usize..self.starts[v + 1] as usize];
            // The star stays loaded while samples begin at it.
            let mut loaded = NONE;
            let mut star = None;
            for sample in samples {
                let mut center = v as u32;
                let mut hit: Option<([u32; 3], NearestInStar)> = None;
                for _ in 0..N_STARS {
                    if loaded != center {
                        star = VertexStar::<L>::load(self.rings, center);
                        loaded = center;
                    }
                    let Some(star) = &star else {
                        // Stars at the boundary have no samples.
                        hit = None;
                        break;
                    };
                    let nearest = star.find_nearest(sample.point);
                    if hit.is_some_and(|(_, before)| nearest.squared >= 0.9999 * before.squared) {
                        break;
                    }
                    let [a, b] = star.ends(nearest.place);
                    hit = Some(([center, a, b], nearest));
                    // At the rim another star may be nearer.
                    let [s, t] = nearest.weights;
                    if s + t < 0.999 {
                        break;
                    }
                    center = if s > t { a } else { b };
                }
                if let Some((face, nearest)) = hit
                    && nearest.squared <= self.farthest
                {
                    self.add_sample(sample, face, nearest.weights);
                }
            }
        }
    }
}

impl SumSamples<'_> {
    // Each vertex of the face gets the sample by its weight there.
    #[inline(always)]
    fn add_sample(&mut self, sample: &Sample, face: [u32; 3], [s, t]: [f32; 2]) {
        let [origin, a, b] = face.map(|v| self.rings.vertices[v as usize].position);
        let (a, b, d) =
            (vector::subtract(a, origin), vector::subtract(b, origin), vector::subtract(sample.point, origin));
        let rest = [d[0] - s * a[0] - t * b[0], d[1] - s * a[1] - t * b[1], d[2] - s * a[2] - t * b[2]];
        let is_inside = s > 0.0 && t > 0.0 && s + t < 1.0;
        let squared = vector::dot(rest, rest);
        // Within a face its normal, else the way to the sample.
        let direction = if is_inside || squared < 1e-24 { vector::cross(a, b) } else { rest };
        let scale = 1.0 / vector::dot(direction, direction).max(1e-37).sqrt();
        let n = [direction[0] * scale, direction[1] * scale, direction[2] * scale];
        let height = vector::dot(n, rest);
        // Heights in place of squared heights become least: one far sample moves little.
        let count = 1.0 / (height * height / self.usual.max(1e-37) + FULL_WEIGHT).sqrt();
        for (v, weight) in [(face[0], 1.0 - s - t), (face[1], s), (face[2], t)] {
            if weight <= 0.0 {
                continue;
            }
            let area = sample.weight * weight;
            let w = area * count;
            let wn = [n[0] * w, n[1] * w, n[2] * w];
            let moments = SampleMoments {
                matrix: [n[0] * wn[0], n[0] * wn[1], n[0] * wn[2], n[1] * wn[1], n[1] * wn[2], n[2] * wn[2]],
                right: [wn[0] * height, wn[1] * height, wn[2] * height],
                squares: area * height * height,
                area,
            };
            match self.out.get_mut((v as usize).wrapping_sub(self.first)) {
                Some(sum) => sum.add(&moments),
                None => self.elsewhere.push((v, moments)),
            }
        }
    }
}

/// Faces of a star, eight at a time: both other ends, seen from the center, with their products.
#[derive(Clone, Copy)]
struct EightFaces<L> {
    a: Vectors<L>,
    b: Vectors<L>,
    aa: L,
    ab: L,
    bb: L,
    inverse: L,
}

struct VertexStar<'a, L> {
    ring: &'a [u32],
    center: Point,
    faces: [EightFaces<L>; LARGEST_RING / 8],
}

impl<'a, L: EightLanes> VertexStar<'a, L> {
    #[inline(always)]
    fn load(rings: &'a Rings, center: u32) -> Option<VertexStar<'a, L>> {
        let ring = rings.ring(center as usize);
        if rings.is_boundary(center as usize) || ring.len() < 3 || ring.len() > LARGEST_RING {
            return None;
        }
        let position = rings.vertices[center as usize].position;
        let zero = [L::splat(0.0); 3];
        let none = EightFaces { a: zero, b: zero, aa: zero[0], ab: zero[0], bb: zero[0], inverse: zero[0] };
        let mut star = VertexStar { ring, center: position, faces: [none; LARGEST_RING / 8] };
        let origin = splat_vector(position);
        for j in 0..ring.len().div_ceil(8) {
            let (mut at, mut next) = ([center; 8], [center; 8]);
            for i in 0..(ring.len() - 8 * j).min(8) {
                let place = 8 * j + i;
                at[i] = ring[place];
                next[i] = ring[if place + 1 < ring.len() { place + 1 } else { 0 }];
            }
            star.faces[j] = EightFaces::load(rings, &at, &next, origin);
        }
        Some(star)
    }

    fn ends(&self, place: usize) -> [u32; 2] {
        [self.ring[place], self.ring[if place + 1 < self.ring.len() { place + 1 } else { 0 }]]
    }

    #[inline(always)]
    fn find_nearest(&self, point: Point) -> NearestInStar {
        let d = splat_vector(vector::subtract(point, self.center));
        let mut nearest = NearestInStar { squared: f32::INFINITY, place: 0, weights: [0.0; 2] };
        for j in 0..self.ring.len().div_ceil(8) {
            let (squared, s, t) = self.faces[j].find_nearest(d);
            let live = L::mask_first(self.ring.len() - 8 * j);
            let (least, lane) = live.select(squared, L::splat(f32::INFINITY)).find_least();
            if least < nearest.squared {
                let weights = [s.to_array()[lane], t.to_array()[lane]];
                nearest = NearestInStar { squared: least, place: 8 * j + lane, weights };
            }
        }
        nearest
    }
}

impl<L: EightLanes> EightFaces<L> {
    #[inline(always)]
    fn load(rings: &Rings, at: &EightIndices, next: &EightIndices, origin: Vectors<L>) -> EightFaces<L> {
        let a = subtract(L::load_points(&rings.vertices, at), origin);
        let b = subtract(L::load_points(&rings.vertices, next), origin);
        let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
        let inverse = L::splat(1.0) / (aa * bb - ab * ab).max(L::splat(1e-30));
        EightFaces { a, b, aa, ab, bb, inverse }
    }

    // Squared distances of `d` and the weights of a and b at the nearest points: inside, or on the nearest side.
    #[inline(always)]
    fn find_nearest(&self, d: Vectors<L>) -> (L, L, L) {
        let (zero, one, tiny) = (L::splat(0.0), L::splat(1.0), L::splat(1e-30));
        let EightFaces { a, b, aa, ab, bb, inverse } = *self;
        let (da, db) = (dot(d, a), dot(d, b));
        let (x, y) = ((bb * da - ab * db) * inverse, (aa * db - ab * da) * inverse);
        let is_inside = x.greater(zero).and(y.greater(zero)).and((one - x).greater(y));
        let on_a = clamp_unit(da / aa.max(tiny));
        let on_b = clamp_unit(db / bb.max(tiny));
        let on_far = clamp_unit(((db - da) + (aa - ab)) / ((aa - ab) + (bb - ab)).max(tiny));
        let (mut squared, mut s, mut t) = (squared_rest(d, a, b, on_a, zero), on_a, zero);
        let other = squared_rest(d, a, b, zero, on_b);
        let is_nearer = squared.greater(other);
        squared = is_nearer.select(other, squared);
        s = is_nearer.select(zero, s);
        t = is_nearer.select(on_b, t);
        let other = squared_rest(d, a, b, one - on_far, on_far);
        let is_nearer = squared.greater(other);
        squared = is_nearer.select(other, squared);
        s = is_nearer.select(one - on_far, s);
        t = is_nearer.select(on_far, t);
        let inner = squared_rest(d, a, b, x, y);
        (is_inside.select(inner, squared), is_inside.select(x, s), is_inside.select(y, t))
    }
}
