//! Nested bodies: cavities, or hidden bodies, which are dropped.
//!
//! A body within solid is a cavity if its faces are wound inward; otherwise it is hidden. If the whole file is inside
//! out, by volume, inward is the other way. A body within a cavity, or outside, is solid. Intersecting bodies are
//! solid, except a shell wound as a cavity and mostly within solid.

use super::bodies::Body;
use super::faces::RepairFaces;
use super::rays::Rays;

const SAMPLES: usize = 64;
/// Least share of samples within solid for an intersecting shell to be a cavity.
const MOSTLY: f64 = 0.5;
/// Barycentric weights of a sample, chosen so that rays rarely meet edges.
const WITHIN: [f64; 3] = [0.4637, 0.3391, 0.1972];

/// Reverses cavities and drops hidden bodies.
pub(super) fn nest(faces: &RepairFaces, bodies: &mut Vec<Body>) {
    if bodies.len() < 2 {
        return;
    }
    // A body can only be inside larger ones, which are decided before it.
    bodies.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    let body_of: Vec<u32> = (0..).zip(&*bodies).flat_map(|(i, body)| body.hull.iter().map(move |_| i)).collect();
    let rays = Rays::new(bodies.iter().flat_map(|body| body.hull.iter()).map(|&hull| triangle(faces, hull)).collect());
    // A file that is inside out as a whole has its solid wound inward.
    let outward: f64 = bodies.iter().map(|body| body.volume * f64::from(body.winding)).sum();
    let inward = if outward < 0.0 { 1 } else { -1 };
    // 1 for a body wound outward, -1 for a cavity, 0 for a dropped body.
    let mut fates = vec![1i32; bodies.len()];
    for number in 0..bodies.len() {
        let within = share_in_solid(faces, &bodies[number], &rays, &mut |triangle| {
            let body = body_of[triangle as usize];
            if body < number as u32 { fates[body as usize] } else { 0 }
        });
        let is_cavity = within >= MOSTLY && bodies[number].winding == inward;
        fates[number] = if is_cavity { -1 } else { i32::from(within < 1.0) };
    }
    for (body, fate) in bodies.iter_mut().zip(&fates) {
        if *fate < 0 {
            body.hull.iter_mut().for_each(|(_, turn)| *turn = !*turn);
        }
    }
    let mut fates = fates.into_iter();
    bodies.retain(|_| fates.next() != Some(0));
}

fn triangle(faces: &RepairFaces, (face, turn): (u32, bool)) -> [[f32; 3]; 3] {
    let [a, b, c] = faces.corners[face as usize].map(|v| faces.positions[v as usize]);
    if turn { [a, c, b] } else { [a, b, c] }
}

fn share_in_solid(faces: &RepairFaces, body: &Body, rays: &Rays, counts: &mut dyn FnMut(u32) -> i32) -> f64 {
    let step = body.hull.len().div_ceil(SAMPLES);
    let (mut n_visits, mut n_within) = (0, 0);
    for (sample, &(face, _)) in body.hull.iter().step_by(step).enumerate() {
        let point: glam::DVec3 = faces.points(face).iter().zip(WITHIN).map(|(corner, weight)| *corner * weight).sum();
        // A ray through an edge says nothing; another sample will.
        let Some(crossed) = rays.find_crossings(point.as_vec3().to_array(), sample % 3) else { continue };
        let winding: i32 = crossed.into_iter().map(|(triangle, sign)| sign * counts(triangle)).sum();
        n_visits += 1;
        n_within += usize::from(winding > 0);
    }
    if n_visits == 0 { 0.0 } else { n_within as f64 / n_visits as f64 }
}

#[cfg(test)]
mod tests {
    use super::super::bodies::bodies;
    use super::*;
    use crate::mesh::{Attributes, TriMesh, shapes};

    fn spheres(all: &[(f32, f32)]) -> TriMesh {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        let sphere = shapes::icosphere(2);
        for &(radius, x) in all {
            let first = positions.len() as u32;
            positions.extend(
                sphere.positions().iter().map(|p| [p[0] * radius.abs() + x, p[1] * radius.abs(), p[2] * radius.abs()]),
            );
            let turned = |&[a, b, c]: &[u32; 3]| if radius < 0.0 { [a, c, b] } else { [a, b, c] };
            faces.extend(sphere.faces().iter().map(turned).map(|face| face.map(|v| v + first)));
        }
        TriMesh::new(positions, faces).unwrap()
    }

    fn nest_spheres(all: &[(f32, f32)]) -> (f64, usize) {
        let mesh = spheres(all);
        let faces = RepairFaces::new(&mesh, &Attributes::default());
        let mut bodies = bodies(&faces, &vec![false; faces.len()]);
        nest(&faces, &mut bodies);
        let volume = |hull: &(u32, bool)| {
            let [a, b, c] = triangle(&faces, *hull).map(|p| glam::Vec3::from(p).as_dvec3());
            a.dot(b.cross(c)) / 6.0
        };
        let sphere: f64 = shapes::icosphere(2)
            .faces()
            .iter()
            .map(|face| {
                let [a, b, c] = face.map(|v| glam::Vec3::from(shapes::icosphere(2).positions()[v as usize]).as_dvec3());
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        (bodies.iter().flat_map(|body| &body.hull).map(volume).sum::<f64>() / sphere, bodies.len())
    }

    fn is(found: (f64, usize), volume: f64, n: usize) -> bool {
        (found.0 - volume).abs() < 1e-3 && found.1 == n
    }

    #[test]
    fn shells_within_shells() {
        assert!(is(nest_spheres(&[(2.0, 0.0), (-1.0, 0.0)]), 7.0, 2));
        assert!(is(nest_spheres(&[(2.0, 0.0), (1.0, 0.0)]), 8.0, 1));
        // The whole file is inside out.
        assert!(is(nest_spheres(&[(-2.0, 0.0), (1.0, 0.0)]), 7.0, 2));
        assert!(is(nest_spheres(&[(-2.0, 0.0), (-1.0, 0.0)]), 8.0, 1));
        // A ball in a cavity, with a cavity of its own.
        assert!(is(nest_spheres(&[(3.0, 0.0), (-2.0, 0.0), (1.0, 0.0), (-0.5, 0.0)]), 27.0 - 8.0 + 1.0 - 0.125, 4));
        assert!(is(nest_spheres(&[(3.0, 0.0), (-2.0, 0.0), (-1.0, 0.0), (-0.5, 0.0)]), 27.0 - 8.0 + 1.0 - 0.125, 4));
    }

    #[test]
    fn bodies_side_by_side_and_across_each_other_stay() {
        assert!(is(nest_spheres(&[(1.0, 0.0), (-1.0, 5.0)]), 2.0, 2));
        assert!(is(nest_spheres(&[(1.0, 0.0), (1.0, 1.0)]), 2.0, 2));
        // Mostly within a body that is inside out, in a file that is not.
        assert!(is(nest_spheres(&[(4.0, 20.0), (-2.0, 0.0), (1.0, 1.8)]), 64.0 + 8.0 + 1.0, 3));
    }
}
