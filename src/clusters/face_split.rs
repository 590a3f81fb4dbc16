//! Splits faces into clusters of nearly equal size by inertial bisection.
//!
//! Faces are sorted along the axis of largest variance of their centroids and cut in two, again and again (Simon 1991,
//! "Partitioning of unstructured problems for parallel processing").

use glam::{DMat3, DVec3, Vec3};

use crate::parallel;

/// Number of faces above which halves are split on two threads.
const PARALLEL: usize = 1 << 13;
/// Steps of the power iteration that finds the axis.
const AXIS_STEPS: usize = 8;
/// About how many faces at most decide on the axis.
const AXIS_SAMPLE: usize = 1 << 11;

/// Largest cluster.
#[derive(Clone, Copy)]
pub struct ClusterLimit {
    pub n_faces: usize,
    pub n_vertices: usize,
}

/// Splits `items` into parts of at most `limit`; `centroid` and `corners` are those of an item's face.
pub fn split_faces(
    items: Vec<u32>,
    limit: ClusterLimit,
    centroid: &(impl Fn(u32) -> [f32; 3] + Sync),
    corners: &(impl Fn(u32) -> [u32; 3] + Sync),
) -> Vec<Vec<u32>> {
    let n_parts = items.len().div_ceil(limit.n_faces);
    split(items, n_parts, &FaceSplit { limit, centroid, corners })
}

struct FaceSplit<'a, P, C> {
    limit: ClusterLimit,
    centroid: &'a P,
    corners: &'a C,
}

fn split<P, C>(mut items: Vec<u32>, n_parts: usize, by: &FaceSplit<P, C>) -> Vec<Vec<u32>>
where
    P: Fn(u32) -> [f32; 3] + Sync,
    C: Fn(u32) -> [u32; 3] + Sync,
{
    // A part with too many vertices is cut once more.
    let n_parts = if n_parts == 1 && by.count_vertices(&items) > by.limit.n_vertices { 2 } else { n_parts };
    if n_parts <= 1 || items.len() < 2 {
        return vec![items];
    }
    let n_low = n_parts / 2;
    let at = (items.len() * n_low / n_parts).max(1);
    let some = items.iter().step_by(items.len().div_ceil(AXIS_SAMPLE));
    let axis = principal_axis(some.map(|&item| point((by.centroid)(item))));
    let mut keyed: Vec<(f64, u32)> = items.iter().map(|&item| (axis.dot(point((by.centroid)(item))), item)).collect();
    keyed.select_nth_unstable_by(at, |x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    items.clear();
    let part = |keyed: &[(f64, u32)]| {
        let mut items: Vec<u32> = keyed.iter().map(|&(_, item)| item).collect();
        // The order within a part must not depend on that of the selection.
        items.sort_unstable();
        items
    };
    let (low, high) = (part(&keyed[..at]), part(&keyed[at..]));
    let is_large = keyed.len() > PARALLEL;
    drop(keyed);
    let (low_part, high_part) = (|| split(low, n_low, by), || split(high, n_parts - n_low, by));
    let (mut parts, others) = if is_large { parallel::join(low_part, high_part) } else { (low_part(), high_part()) };
    parts.extend(others);
    parts
}

impl<P, C: Fn(u32) -> [u32; 3]> FaceSplit<'_, P, C> {
    fn count_vertices(&self, items: &[u32]) -> usize {
        if 3 * items.len() <= self.limit.n_vertices {
            return 0;
        }
        let mut vertices: Vec<u32> = items.iter().flat_map(|&item| (self.corners)(item)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices.len()
    }
}

fn point(position: [f32; 3]) -> DVec3 {
    Vec3::from(position).as_dvec3()
}

/// Returns the axis of largest variance, by power iteration.
fn principal_axis(points: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
    let (sum, n) = points.clone().fold((DVec3::ZERO, 0.0), |(sum, n), p| (sum + p, n + 1.0));
    let mean = sum / n;
    let covariance = points.fold(DMat3::ZERO, |matrix, p| {
        let d = p - mean;
        matrix + DMat3::from_cols(d * d.x, d * d.y, d * d.z)
    });
    // The longest column is never perpendicular to the axis, unless all variances are equal or zero.
    let columns = [covariance.x_axis, covariance.y_axis, covariance.z_axis];
    let longest =
        columns.into_iter().fold(DVec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
    let step = |axis: DVec3| (covariance * axis).normalize_or(axis);
    (0..AXIS_STEPS).fold(longest.normalize_or(DVec3::X), |axis, _| step(axis))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::spatial::Bounds;

    fn split_mesh(mesh: &TriMesh, n_faces: usize, n_vertices: usize) -> Vec<Vec<u32>> {
        let corners = |face: u32| mesh.faces()[face as usize];
        let centroid = |face: u32| {
            let [a, b, c] = corners(face).map(|v| mesh.positions()[v as usize]);
            std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0)
        };
        let items = (0..mesh.faces().len() as u32).collect();
        split_faces(items, ClusterLimit { n_faces, n_vertices }, &centroid, &corners)
    }

    #[test]
    fn parts_are_full_and_hold_each_face_once() {
        for (mesh, n) in
            [(shapes::icosphere(4), 128), (shapes::torus(40, 25, 1.0, 0.3), 77), (shapes::tetrahedron(), 128)]
        {
            let parts = split_mesh(&mesh, n, 255);
            assert_eq!(parts.len(), mesh.faces().len().div_ceil(n));
            assert!(parts.iter().all(|part| part.len() <= n && part.len() + 1 >= mesh.faces().len() / parts.len()));
            let mut all: Vec<u32> = parts.into_iter().flatten().collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..mesh.faces().len() as u32));
        }
    }

    #[test]
    fn parts_with_too_many_vertices_are_cut_again() {
        let mesh = shapes::icosphere(3);
        let parts = split_mesh(&mesh, 256, 40);
        let n_vertices = |part: &Vec<u32>| {
            let mut vertices: Vec<u32> = part.iter().flat_map(|&face| mesh.faces()[face as usize]).collect();
            vertices.sort_unstable();
            vertices.dedup();
            vertices.len()
        };
        assert!(parts.iter().all(|part| n_vertices(part) <= 40));
        assert_eq!(parts.iter().map(Vec::len).sum::<usize>(), mesh.faces().len());
    }

    #[test]
    fn a_strip_is_cut_across_its_length() {
        let square = shapes::grid(64, 4);
        let long = square.positions().iter().map(|p| [10.0 * p[0], p[1], p[2]]).collect();
        let strip = TriMesh::new(long, square.faces().to_vec()).unwrap();
        let parts = split_mesh(&strip, strip.faces().len() / 4, 255);
        let length = |part: &Vec<u32>| {
            let corners = part.iter().flat_map(|&face| strip.faces()[face as usize]);
            let points: Vec<[f32; 3]> = corners.map(|v| strip.positions()[v as usize]).collect();
            Bounds::from_points(&points).diagonal()
        };
        let whole = Bounds::from_points(strip.positions()).diagonal();
        assert_eq!(parts.len(), 4);
        assert!(parts.iter().all(|part| length(part) < 0.3 * whole));
    }
}
