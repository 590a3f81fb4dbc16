//! Surfaces on which few vertices are what counts: those with much that is flat, and those on which half of the vertices
//! stand for hardly any area. They are parts of machines, mostly.
//!
//! Darts lie where a surface bends. On these it bends at corners and along creases alone, at a vertex or two each, and what
//! the darts leave out there is far off when its turn comes; so the collapse looks at all vertices.

use crate::simplify::closed::prepare::surface::Surface;

/// Vertices that are looked at, about: a share among them is right within 0.008 (one standard deviation).
const MEASURED: usize = 4096;
/// Sum of the products of two eigenvalues of a vertex's planes, over their squared sum, up to which the faces around it
/// lie in one plane: a thousandth between their normals. At 1e-7 and 1e-5 the same training meshes of more than 15,000
/// vertices count, but for one boat.
const FLAT: f32 = 1e-6;
/// Share of flat vertices from which on a surface counts. Of the training meshes of more than 15,000 vertices six of
/// seven parts made by constructive geometry have 0.64 to 0.85; all others have up to 0.24.
const MOST_FLAT: f64 = 0.3;
/// Mean weight of the vertices over the median from which on a surface counts. Of the training meshes of more than
/// 15,000 vertices three machine parts with faces as long as their sides have 11 to 103; all others have up to 6.9.
const MOST_UNEVEN: f64 = 8.0;

/// Whether a surface is mostly its corners and creases.
pub fn is_uneven(surface: &Surface) -> bool {
    let looked_at = surface.quadrics.iter().step_by(surface.n_vertices() / MEASURED + 1);
    let (mut weights, mut n_flat): (Vec<f32>, usize) = (Vec::with_capacity(MEASURED), 0);
    for [xx, xy, xz, yy, yz, zz] in looked_at {
        let weight = xx + yy + zz;
        let products = xx * yy - xy * xy + (xx * zz - xz * xz) + (yy * zz - yz * yz);
        n_flat += usize::from(products <= FLAT * weight * weight);
        weights.push(weight);
    }
    if weights.is_empty() {
        return false;
    }
    let mean = weights.iter().copied().map(f64::from).sum::<f64>() / weights.len() as f64;
    let middle = weights.len() / 2;
    let median = *weights.select_nth_unstable_by(middle, f32::total_cmp).1;
    n_flat as f64 > MOST_FLAT * weights.len() as f64 || mean > MOST_UNEVEN * f64::from(median)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{TriMesh, shapes};

    fn uneven(mesh: &TriMesh) -> bool {
        is_uneven(&Surface::new(mesh, Pulse::NONE))
    }

    #[test]
    fn parts_are_uneven_and_smooth_surfaces_are_not() {
        assert!(uneven(&shapes::cuboid([3.0, 2.0, 1.0], 12)));
        assert!(uneven(&shapes::grid(30, 30)));
        for mesh in [shapes::wavy_sphere(4, 5.0), shapes::torus(60, 30, 1.0, 0.3), shapes::open_cylinder(60, 30)] {
            assert!(!uneven(&mesh));
        }
        // A sphere that is fine on one side and coarse on the other.
        let sphere = shapes::icosphere(4);
        let squeezed = |p: &[f32; 3]| [p[0], p[1], if p[2] < 0.9 { p[2] * 1e-3 } else { p[2] }];
        let places = sphere.positions().iter().map(squeezed).collect();
        assert!(uneven(&TriMesh::new(places, sphere.faces().to_vec()).unwrap()));
    }
}
