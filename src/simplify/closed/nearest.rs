//! The original near a place, found by walking over its edges: the regions know where to start, so that no search
//! structure is needed.

use glam::Vec3;

use crate::geometry::triangle::{area_normal, nearest_point};

use super::prepare::surface::Surface;

/// For each output vertex that is wanted the input vertex of its region that lies nearest to it; any for others.
pub(super) fn anchors(surface: &Surface, positions: &[Vec3], vertex_of: &[u32], wanted: &[bool]) -> Vec<u32> {
    let mut best = vec![(f32::INFINITY, 0); positions.len()];
    for (v, &output) in vertex_of.iter().enumerate().filter(|(_, output)| wanted[**output as usize]) {
        let distance = surface.positions[v].distance_squared(positions[output as usize]);
        if distance < best[output as usize].0 {
            best[output as usize] = (distance, v as u32);
        }
    }
    best.into_iter().map(|(_, v)| v).collect()
}

/// The vertex of the original, and its squared distance, at which a walk toward `point` ends that begins at `start`.
pub(super) fn nearest_vertex(surface: &Surface, point: Vec3, start: u32) -> (u32, f32) {
    let mut v = start;
    let mut least = surface.positions[v as usize].distance_squared(point);
    loop {
        let before = v;
        for &w in surface.neighbors(v) {
            let distance = surface.positions[w as usize].distance_squared(point);
            if distance < least {
                (v, least) = (w, distance);
            }
        }
        if v == before {
            return (v, least);
        }
    }
}

/// The other two corners of each face at a vertex of the original.
pub(super) fn sides(surface: &Surface, v: u32) -> impl Iterator<Item = [u32; 2]> {
    let ring = surface.neighbors(v);
    let n_faces = if surface.rings.apex(v).is_none() { ring.len() } else { ring.len() - 1 };
    (0..n_faces).map(|i| [ring[i], ring[if i + 1 == ring.len() { 0 } else { i + 1 }]])
}

/// Normal of a face of the original at vertex `v`, not of unit length; where not all are wound the same way around, as the
/// vertex looks.
pub(super) fn normal_at(surface: &Surface, v: u32, corners: [Vec3; 3]) -> Vec3 {
    let normal = area_normal(corners);
    let is_opposed = !surface.rings.is_oriented() && normal.dot(surface.normals[v as usize]) < 0.0;
    if is_opposed { -normal } else { normal }
}

/// The normal of the original's face nearest to `point` among those where a walk from vertex `start` ends, not of unit
/// length.
pub(super) fn normal_near(surface: &Surface, point: Vec3, start: u32) -> Vec3 {
    let (v, _) = nearest_vertex(surface, point, start);
    let mut nearest = (f32::INFINITY, [Vec3::ZERO; 3]);
    for [p, q] in sides(surface, v) {
        let corners = [v, p, q].map(|w| surface.positions[w as usize]);
        let distance = nearest_point(point, corners).distance_squared(point);
        if distance < nearest.0 {
            nearest = (distance, corners);
        }
    }
    normal_at(surface, v, nearest.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn normals_are_those_of_the_naive_search() {
        let mesh = shapes::wavy_sphere(3, 4.0);
        let surface = Surface::new(&mesh);
        for v in (0..surface.n_vertices() as u32).step_by(37) {
            let corners = |f: &[u32; 3]| f.map(|v| surface.positions[v as usize]);
            let face = surface.faces.iter().find(|face| face.contains(&v)).unwrap();
            let centroid = corners(face).iter().sum::<Vec3>() / 3.0;
            let start = surface.neighbors(surface.neighbors(v)[0])[0];
            let (found, naive) = (normal_near(&surface, centroid, start), area_normal(corners(face)));
            assert!(found.distance(naive) <= 1e-3 * naive.length(), "{found} {naive}");
        }
    }
}
