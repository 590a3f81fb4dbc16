//! Triangles of local Delaunay triangulations in the tangent planes of points (Gopi, Krishnan and Silva 2000).

use super::planes::{plane_normals, point, tangents};
use crate::linalg::Csr;
use crate::parallel;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Neighbours, with the point itself, through which tangent planes run.
const PLANE: usize = 12;

/// Least length of a neighbour's projection over its distance; steeper neighbours are of another sheet.
const STEEP: f64 = 0.5;

/// Largest displacement of a point against ties, over the distance to its nearest neighbour.
// All stars see the same points. Without, the corners of a square choose different diagonals, and the cloud of a regular
// tube falls into 39 components.
const JITTER: f64 = 0.01;

/// Triangles in the stars of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StarTriangles {
    /// Triangles, each ascending, sorted, without repeats.
    pub triangles: Vec<[u32; 3]>,
    /// Number of corners in whose star the triangle is, 1 to 3.
    pub votes: Vec<u8>,
}

impl StarTriangles {
    /// Lists the triangles that at least two of their corners have.
    pub fn list_agreed(&self) -> Vec<[u32; 3]> {
        let agreed = self.triangles.iter().zip(&self.votes).filter(|(_, votes)| **votes > 1);
        agreed.map(|(triangle, _)| *triangle).collect()
    }
}

/// Finds the triangles of each point in the Delaunay triangulation of its neighbours in its tangent plane.
///
/// # Shapes
/// - `points`: n x 3
/// - `graph`: n x n, the neighbours
pub fn star_triangles(points: &[[f32; 3]], graph: &Csr) -> StarTriangles {
    let normals = plane_normals(points, PLANE);
    let points = &jitter(points, graph);
    let star = |v: u32| star_of(points, normals[v as usize], v, graph.row(v as usize));
    let mut all: Vec<[u32; 3]> = parallel::flat_map(0..points.len(), 16, |v| star(v as u32)).collect();
    all.par_sort_unstable();
    let copies = || all.chunk_by(|a, b| a == b);
    StarTriangles {
        triangles: copies().map(|copies| copies[0]).collect(),
        votes: copies().map(|copies| copies.len() as u8).collect(),
    }
}

fn jitter(points: &[[f32; 3]], graph: &Csr) -> Vec<[f32; 3]> {
    // Multiples of these numbers, the powers of a root of x^4 = x + 1, fill the cube evenly (Roberts 2018).
    const STEPS: [f64; 3] = [0.819_172_513_396, 0.671_043_606_704, 0.549_700_477_901];
    let move_point = |v: u32| {
        let to_neighbour = |&w: &u32| point(points, w).distance(point(points, v));
        let others = graph.row(v as usize).iter().filter(|&&w| w != v);
        let reach = others.map(to_neighbour).min_by(f64::total_cmp).unwrap_or(0.0);
        let offset = DVec3::from(STEPS.map(|step| (f64::from(v) * step).fract() - 0.5));
        (point(points, v) + JITTER * reach * offset).as_vec3().to_array()
    };
    parallel::map(points.len(), 256, |v| move_point(v as u32))
}

fn star_of(points: &[[f32; 3]], normal: DVec3, v: u32, neighbours: &[u32]) -> Vec<[u32; 3]> {
    // Points on a line span no triangles.
    if normal == DVec3::ZERO {
        return Vec::new();
    }
    let [x, y] = tangents(normal);
    let project = |&w: &u32| {
        let d = point(points, w) - point(points, v);
        let flat = DVec2::new(d.dot(x), d.dot(y));
        // The neighbour keeps its distance, so that points on the far side of a bend do not come near.
        (flat.length() > STEEP * d.length()).then(|| (w, flat.normalize_or_zero() * d.length()))
    };
    let (around, flat): (Vec<u32>, Vec<DVec2>) = neighbours.iter().filter(|&&w| w != v).filter_map(project).unzip();
    let triangle = |[a, b]: [usize; 2]| {
        let mut triangle = [v, around[a], around[b]];
        triangle.sort_unstable();
        triangle
    };
    delaunay_star(&flat).into_iter().map(triangle).collect()
}

/// Finds the triangles of the origin in the Delaunay triangulation of the origin and `points`, as pairs of points.
fn delaunay_star(points: &[DVec2]) -> Vec<[usize; 2]> {
    let is_nearer = |&a: &usize, &b: &usize| points[a].length_squared().total_cmp(&points[b].length_squared());
    // The nearest point always is a neighbour.
    let Some(first) = (0..points.len()).min_by(is_nearer) else { return Vec::new() };
    let mut sides = Vec::new();
    // Around the origin to the left; at a boundary, the rest from the first point to the right.
    for turn in [1.0, -1.0] {
        let mut last = first;
        while let Some(next) = next_around(points, last, turn).filter(|_| sides.len() < 2 * points.len()) {
            sides.push([last, next]);
            if next == first {
                return sides;
            }
            last = next;
        }
    }
    sides
}

/// Finds the third corner of the triangle on one side of the edge from the origin to a point, if it has one.
fn next_around(points: &[DVec2], at: usize, turn: f64) -> Option<usize> {
    let from = points[at];
    // The largest angle over the edge belongs to the circle that has no other point on that side.
    let cotangent = |p: DVec2| (-p).dot(from - p) / (-p).perp_dot(from - p).abs();
    let is_on_side = |p: DVec2| turn * from.perp_dot(p) > 1e-9 * from.length() * p.length();
    let on_side = (0..points.len()).filter(|&i| i != at && is_on_side(points[i]));
    on_side.min_by(|&a, &b| cotangent(points[a]).total_cmp(&cotangent(points[b])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::model::extended_graph;
    use proptest::prelude::*;

    /// Pairs whose circle with the origin has no other point inside.
    fn naive(points: &[DVec2]) -> Vec<[usize; 2]> {
        let centre = |p: DVec2, q: DVec2| {
            let d = 2.0 * p.perp_dot(q);
            DVec2::new(
                q.y * p.length_squared() - p.y * q.length_squared(),
                p.x * q.length_squared() - q.x * p.length_squared(),
            ) / d
        };
        let is_empty = |&[a, b]: &[usize; 2]| {
            let c = centre(points[a], points[b]);
            (0..points.len()).all(|i| i == a || i == b || points[i].distance(c) > c.length())
        };
        (0..points.len()).flat_map(|a| (a + 1..points.len()).map(move |b| [a, b])).filter(is_empty).collect()
    }

    proptest! {
        #[test]
        fn stars_are_those_of_empty_circles(points in prop::collection::vec([-1.0f64..1.0, -1.0..1.0], 2..20)) {
            let points: Vec<DVec2> = points.into_iter().map(DVec2::from_array).collect();
            let mut found: Vec<[usize; 2]> = delaunay_star(&points).iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
            found.sort_unstable();
            prop_assert_eq!(found, naive(&points));
        }
    }

    #[test]
    fn the_triangles_of_a_sphere_are_its_faces() {
        let sphere = shapes::icosphere(3);
        let graph = extended_graph(sphere.positions(), &Csr::from_edges(642, []), 15);
        let agreed = star_triangles(sphere.positions(), &graph).list_agreed();
        let mut faces: Vec<[u32; 3]> = sphere.faces().to_vec();
        faces.iter_mut().for_each(|face| face.sort_unstable());
        faces.sort_unstable();
        assert_eq!(agreed, faces);
    }
}
