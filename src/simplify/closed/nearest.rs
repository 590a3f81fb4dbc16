//! The original near a place, found by walking over its edges: the regions know where to start, so that no search
//! structure is needed.

use glam::Vec3;

use crate::geometry::triangle::nearest_point;

use super::surface::Surface;

/// For each output vertex the input vertex of its region that lies nearest to it.
pub(super) fn anchors(surface: &Surface, positions: &[Vec3], vertex_of: &[u32]) -> Vec<u32> {
    let mut best = vec![(f32::INFINITY, 0); positions.len()];
    for (v, &output) in vertex_of.iter().enumerate() {
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

/// Squared distance from `point` to the original, near where a walk from vertex `start` ends.
pub(super) fn distance_squared(surface: &Surface, point: Vec3, start: u32) -> f32 {
    let (v, mut least) = nearest_vertex(surface, point, start);
    let here = surface.positions[v as usize];
    let ring = surface.neighbors(v);
    let closing = if surface.rings.apex(v).is_none() { ring.len() } else { ring.len() - 1 };
    for i in 0..closing {
        let (p, q) = (surface.positions[ring[i] as usize], surface.positions[ring[(i + 1) % ring.len()] as usize]);
        least = least.min(nearest_point(point, [here, p, q]).distance_squared(point));
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn distances_are_those_of_the_naive_search() {
        let surface = Surface::new(&shapes::wavy_sphere(3, 4.0));
        for v in (0..surface.n_vertices() as u32).step_by(37) {
            let point = surface.positions[v as usize] + 0.002 * surface.normals[v as usize];
            let corners = surface.faces.iter().map(|f| f.map(|v| surface.positions[v as usize]));
            let naive = corners.map(|c| nearest_point(point, c).distance_squared(point)).fold(f32::INFINITY, f32::min);
            let start = surface.neighbors(v)[0];
            assert!((distance_squared(&surface, point, start) - naive).abs() <= 1e-3 * naive);
        }
    }
}
