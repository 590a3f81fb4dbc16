//! Coverings of triangles that faces of a surface do not cover as seen along the normal, such as those next to creases.
//!
//! The triangle is cut along planes through the edges of the surface, and each piece is assigned to one face. The
//! distance to a triangle is convex, so over a piece it is largest at a corner: any assignment gives a proved bound, and a
//! good one a sharp bound.

use glam::DVec3;

use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::mesh::half_edges::NO_TWIN;

use super::overlay_surface::{EdgePlane, OverlaySurface, largest_distance};

/// Most corners of a piece; larger ones are not cut.
const MOST_CORNERS: usize = 12;
/// Most pieces of a triangle that are cut.
const MOST_CUTS: usize = 96;
/// Most faces that a piece passes; then it starts again from the face closest to it, at most as often as this.
// Around vertices of strongly bent surfaces, the planes leave gaps, in which pieces would turn for ever.
const MOST_STEPS: u8 = 8;
const MOST_STARTS: u8 = 3;
/// Bound over the distance of a point at which a piece is not halved further.
const SHARP: f64 = 1.1;
const MOST_HALVINGS: u32 = 8;

/// Part of a triangle on its way over the surface.
#[derive(Clone, Copy)]
pub struct Piece {
    points: [DVec3; MOST_CORNERS],
    n: usize,
    /// Face that the piece has reached, and the half-edge of that face through which it came.
    face: u32,
    entry: u32,
    n_steps: u8,
    n_starts: u8,
}

impl OverlaySurface {
    /// Covers a triangle by pieces, the first on the face `start`; pieces within `enough` of a face are not cut.
    pub fn cover_by_cutting(
        &self,
        (triangle, start): ([DVec3; 3], u32),
        enough: f64,
        pending: &mut Vec<Piece>,
        mut visit: impl FnMut(u32, f64),
    ) {
        let mut points = [DVec3::ZERO; MOST_CORNERS];
        points[..3].copy_from_slice(&triangle);
        pending.push(Piece { points, n: 3, face: start, entry: NO_TWIN, n_steps: 0, n_starts: 0 });
        let mut n_cuts = 0;
        while let Some(piece) = pending.pop() {
            let piece = if piece.n_steps > MOST_STEPS { self.start_again(piece) } else { piece };
            let distance = self.distance(&piece.points[..piece.n], piece.face);
            n_cuts += 1;
            if distance <= enough || n_cuts > MOST_CUTS || piece.n_starts >= MOST_STARTS {
                visit(piece.face, distance);
            } else if let Some(inside) = self.cut(piece, pending) {
                visit(inside.face, self.distance(&inside.points[..inside.n], inside.face));
            }
        }
    }

    /// Covers a triangle by halving it until bounds are sharp, at most `enough`, or no halvings are left.
    pub fn cover_by_halving(
        &self,
        triangle: [DVec3; 3],
        enough: f64,
        halvings_left: &mut usize,
        mut visit: impl FnMut(u32, f64),
    ) {
        let mut pending = vec![(triangle, 0)];
        while let Some((triangle, n_cuts)) = pending.pop() {
            let hits = self.nearest_samples(&triangle);
            let least = largest_distance(&hits);
            let bounds = hits.iter().map(|&(face, _)| (self.distance(&triangle, face), face));
            let Some((bound, face)) = bounds.min_by(|x, y| x.0.total_cmp(&y.0)) else { return };
            if bound <= enough.max(SHARP * least) || n_cuts == MOST_HALVINGS || *halvings_left == 0 {
                visit(face, bound);
                continue;
            }
            *halvings_left -= 1;
            let [a, b, c] = rotate_longest_first(triangle);
            let middle = 0.5 * (a + b);
            pending.extend([([a, middle, c], n_cuts + 1), ([middle, b, c], n_cuts + 1)]);
        }
    }

    /// Cuts off all parts beyond the edges of a piece's face; returns the rest.
    fn cut(&self, mut piece: Piece, pending: &mut Vec<Piece>) -> Option<Piece> {
        for half_edge in 3 * piece.face..3 * piece.face + 3 {
            if half_edge == piece.entry || piece.n == MOST_CORNERS {
                continue;
            }
            let (inside, outside) = piece.split(&self.plane(half_edge));
            if outside.n > 0 {
                let twin = self.twins[half_edge as usize];
                pending.push(match twin {
                    // Beyond the boundary: the rest of the surface may turn back there.
                    NO_TWIN => Piece { n_steps: MOST_STEPS + 1, ..outside },
                    twin => Piece { face: twin / 3, entry: twin, n_steps: piece.n_steps + 1, ..outside },
                });
            }
            if inside.n == 0 {
                return None;
            }
            piece = inside;
        }
        Some(piece)
    }

    fn start_again(&self, piece: Piece) -> Piece {
        let middle = piece.points[..piece.n].iter().sum::<DVec3>() / piece.n as f64;
        let (face, _) = self.nearest(middle);
        Piece { face, entry: NO_TWIN, n_steps: 0, n_starts: piece.n_starts + 1, ..piece }
    }

    /// Returns the largest distance of a polygon's corners, and so of all its points, to a face.
    fn distance(&self, polygon: &[DVec3], face: u32) -> f64 {
        let corners = self.triangles[face as usize];
        let distance2 = |&p: &DVec3| {
            let [u, v, w] = nearest_weights_f64(p, corners);
            p.distance_squared(u * corners[0] + v * corners[1] + w * corners[2])
        };
        polygon.iter().map(distance2).fold(0.0, f64::max).sqrt()
    }
}

fn rotate_longest_first([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    let [ab, bc, ca] = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    if ab >= bc.max(ca) {
        [a, b, c]
    } else if bc >= ca {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

impl Piece {
    /// Splits the polygon by a plane; parts without area on one side are empty.
    fn split(&self, plane: &EdgePlane) -> (Self, Self) {
        let side = |p: DVec3| plane.normal.dot(p) - plane.offset;
        let sides: [f64; MOST_CORNERS] = std::array::from_fn(|i| if i < self.n { side(self.points[i]) } else { 0.0 });
        let sides = &sides[..self.n];
        let empty = Self { n: 0, ..*self };
        if sides.iter().all(|side| *side >= -plane.slack) {
            return (*self, empty);
        }
        if sides.iter().all(|side| *side <= 0.0) {
            return (empty, *self);
        }
        // Rounding may have bent a thin piece, which is then left whole: two crossings add one corner to each part.
        let n_crossings = (0..self.n).filter(|&i| sides[i] * sides[(i + 1) % self.n] < 0.0).count();
        if n_crossings > 2 {
            return (*self, empty);
        }
        let (mut inside, mut outside) = (empty, empty);
        for (i, (&p, &side)) in self.points.iter().zip(sides).enumerate() {
            let j = (i + 1) % self.n;
            if side >= 0.0 {
                inside.push(p);
            }
            if side <= 0.0 {
                outside.push(p);
            }
            if side * sides[j] < 0.0 {
                let middle = p.lerp(self.points[j], side / (side - sides[j]));
                inside.push(middle);
                outside.push(middle);
            }
        }
        (inside, outside)
    }

    fn push(&mut self, p: DVec3) {
        // Full polygons are not cut, so there is room.
        self.points[self.n] = p;
        self.n += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clusters::overlay_surface::centroid;
    use crate::mesh::shapes;

    #[test]
    fn pieces_cover_the_triangle() {
        let target = OverlaySurface::from_mesh(&shapes::icosphere(3));
        let triangle = shapes::icosphere(1).faces()[5].map(|v| shapes::icosphere(1).positions()[v as usize]);
        let triangle = triangle.map(|p| DVec3::from(p.map(f64::from)));
        let mut faces = Vec::new();
        let (start, _) = target.nearest(centroid(&triangle));
        target.cover_by_cutting((triangle, start), 0.0, &mut Vec::new(), |face, _| faces.push(face));
        // A face of the coarse sphere lies over sixteen of the fine one, and touches their neighbours.
        faces.sort_unstable();
        faces.dedup();
        assert!((16..=46).contains(&faces.len()), "{}", faces.len());
    }
}
