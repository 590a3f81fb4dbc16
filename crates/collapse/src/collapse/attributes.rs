//! Attributes of wedges: what they lose in a merge, and their values where vertices have moved.
//!
//! On a face each attribute s is linear, with gradient g. If the wedge of v comes to x, seen from v, with values that
//! differ by σ, the faces of area a around it lose Σ a (g·x - σ)² over faces and attributes; as a form in x and σ that is
//! xᵀ(Σ a g gᵀ)x - 2 Σ σ (Σ a g)·x + (Σ a) Σ σ² (Hoppe, New Quadric Metric for Simplifying Meshes with Appearance
//! Attributes, 1999), here without memory, as for planes.

use crate::collapse::rings::{Rings, Vertex, state};
use crate::collapse::vector::{Point, cross, dot, subtract};
use crate::collapse::wedges::{WedgeFace, WedgePair};

/// The part of a face's area that one of its vertices has, over the length of the cross product.
const SHARE: f32 = 1.0 / 6.0;

/// Numbers of a form before those of its attributes: xx, xy, xz, yy, yz, zz of Σ a g gᵀ, and Σ a.
const HEAD: usize = 7;

/// The attributes of all wedges.
pub(crate) struct WedgeAttributes {
    /// Number of attributes.
    pub width: usize,
    /// Number of those that count; the rest are only carried.
    n_counted: usize,
    /// Values, n_wedges x width; of those that count, a difference of 1 is the unit frame's side.
    pub values: Vec<f32>,
    /// Forms of the wedges, n_wedges x (HEAD + 3 width).
    forms: Vec<f32>,
    /// The mesh before the merges of a pass.
    before: Vec<Vertex>,
}

impl WedgeAttributes {
    /// Returns the attributes of wedges with these values, n_wedges x width, of which the first `n_counted` count.
    pub(crate) fn new(values: Vec<f32>, width: usize, n_counted: usize) -> WedgeAttributes {
        WedgeAttributes { width, n_counted, values, forms: Vec::new(), before: Vec::new() }
    }

    fn value(&self, wedge: u32) -> &[f32] {
        &self.values[wedge as usize * self.width..][..self.width]
    }

    fn form(&self, wedge: u32) -> &[f32] {
        let length = HEAD + 3 * self.width;
        &self.forms[wedge as usize * length..][..length]
    }

    /// Writes what the attributes of each vertex lose if it goes into a neighbour, one number per entry of the rings.
    pub(crate) fn write_losses(&mut self, rings: &Rings, faces: &[WedgeFace], losses: &mut Vec<f32>) {
        self.sum_forms(rings, faces);
        self.before.clone_from(&rings.vertices);
        losses.clear();
        if self.n_counted == 0 {
            return;
        }
        losses.resize(rings.neighbors.len(), 0.0);
        for face in faces {
            for (i, j) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
                let (goes, stays) = (face.vertices[i], face.vertices[j]);
                let ring = rings.ring(goes as usize);
                let Some(place) = ring.iter().position(|&w| w == stays) else { continue };
                // Both faces at an edge say the same, unless it is on a line, where each has its side.
                let state = rings.states[goes as usize];
                let is_single = state & state::BOUNDARY != 0 && (place == 0 || place + 1 == ring.len())
                    || state & state::LINE != 0 && rings.lines[goes as usize].contains(&stays);
                let x = subtract(rings.vertices[stays as usize].position, rings.vertices[goes as usize].position);
                let loss = self.measure_loss(face.wedges[i], face.wedges[j], x);
                losses[rings.range(goes as usize).start + place] += if is_single { loss } else { 0.5 * loss };
            }
        }
    }

    fn sum_forms(&mut self, rings: &Rings, faces: &[WedgeFace]) {
        let (width, length) = (self.width, HEAD + 3 * self.width);
        self.forms.clear();
        self.forms.resize(self.values.len() / width * length, 0.0);
        let mut form = vec![0.0; length];
        for face in faces {
            let [a, b, c] = face.vertices.map(|v| rings.vertices[v as usize].position);
            let (e1, e2) = (subtract(b, a), subtract(c, a));
            let normal = cross(e1, e2);
            let area = SHARE * dot(normal, normal).sqrt();
            form.fill(0.0);
            form[6] = area;
            let [va, vb, vc] = face.wedges.map(|wedge| self.value(wedge));
            for k in 0..width {
                let g = find_gradient([e1, e2], [vb[k] - va[k], vc[k] - va[k]], dot(normal, normal));
                let products = [g[0] * g[0], g[0] * g[1], g[0] * g[2], g[1] * g[1], g[1] * g[2], g[2] * g[2]];
                let weight = if k < self.n_counted { area } else { 0.0 };
                for (sum, product) in form.iter_mut().zip(products) {
                    *sum += weight * product;
                }
                for i in 0..3 {
                    form[HEAD + 3 * k + i] = area * g[i];
                }
            }
            for wedge in face.wedges {
                for (sum, x) in self.forms[wedge as usize * length..][..length].iter_mut().zip(&form) {
                    *sum += x;
                }
            }
        }
    }

    // The form of one wedge at the place of another, `x` away.
    fn measure_loss(&self, goes: u32, stays: u32, x: Point) -> f32 {
        let form = self.form(goes);
        let rows = [[form[0], form[1], form[2]], [form[1], form[3], form[4]], [form[2], form[4], form[5]]];
        let mut loss = dot(rows.map(|row| dot(row, x)), x);
        let counted = self.value(goes)[..self.n_counted].iter().zip(self.value(stays));
        for ((old, new), slope) in counted.zip(form[HEAD..].as_chunks().0) {
            let difference = new - old;
            loss += difference * (form[6] * difference - 2.0 * dot(*slope, x));
        }
        loss.max(0.0)
    }

    /// Gives wedges that have moved the values at which their and their partner's faces lose least.
    pub(crate) fn follow(&mut self, pairs: &[WedgePair], next: &Rings, numbers: &[u32]) {
        let mut pairs = pairs.to_vec();
        pairs.sort_unstable_by_key(|pair| (pair.stays, pair.goes));
        pairs.dedup_by_key(|pair| (pair.stays, pair.goes));
        for WedgePair { goes, stays, vertices } in pairs {
            let position = next.vertices[numbers[vertices[1] as usize] as usize].position;
            let [from_gone, from_stayed] = vertices.map(|v| subtract(position, self.before[v as usize].position));
            if from_stayed == [0.0; 3] {
                continue;
            }
            for k in 0..self.width {
                let (old, other) = (self.value(stays)[k], self.value(goes)[k]);
                let (mut sum, mut weight) = (0.0, 0.0);
                for (wedge, value, x) in [(stays, old, from_stayed), (goes, other, from_gone)] {
                    let form = self.form(wedge);
                    let slope = [0, 1, 2].map(|i| form[HEAD + 3 * k + i]);
                    sum += form[6] * value + dot(slope, x);
                    weight += form[6];
                }
                let reach = (old - other).abs();
                let (low, high) = (old.min(other) - reach, old.max(other) + reach);
                if weight > 0.0 {
                    self.values[stays as usize * self.width + k] = (sum / weight).clamp(low, high);
                }
            }
        }
    }
}

// The gradient in a face of what changes by `changes` along its sides; none in a face without area.
fn find_gradient([e1, e2]: [Point; 2], changes: [f32; 2], squared_normal: f32) -> Point {
    if squared_normal <= 0.0 {
        return [0.0; 3];
    }
    let (aa, ab, bb) = (dot(e1, e1), dot(e1, e2), dot(e2, e2));
    let s = (bb * changes[0] - ab * changes[1]) / squared_normal;
    let t = (aa * changes[1] - ab * changes[0]) / squared_normal;
    [0, 1, 2].map(|i| s * e1[i] + t * e2[i])
}
