//! One-sided surfaces, such as a Klein bottle.

use crate::mesh::half_edges::{NO_TWIN, spread_winding, start, twins};

use super::faces::RepairFaces;

/// Drops a face at each two-face edge where windings cannot agree; returns the number dropped.
pub(super) fn cut_one_sided(faces: &mut RepairFaces) -> usize {
    let twins = twins(faces.positions.len(), &faces.corners);
    let mut sides = vec![None; faces.len()];
    for seed in 0..faces.len() {
        if sides[seed].is_none() {
            sides[seed] = Some(false);
            spread_winding(vec![seed as u32], &faces.corners, &twins, &mut sides);
        }
    }
    let is_opposed = |half: usize, twin: u32| {
        let along = start(&faces.corners, half as u32) == start(&faces.corners, twin);
        (sides[half / 3] != sides[twin as usize / 3]) != along
    };
    let mut is_cut = vec![false; faces.len()];
    for (half, &twin) in twins.iter().enumerate().filter(|&(half, &twin)| twin != NO_TWIN && half < twin as usize) {
        // One face per conflict is enough: the edge is open without it.
        if is_opposed(half, twin) && !is_cut[half / 3] {
            is_cut[twin as usize / 3] = true;
        }
    }
    let n_cut = is_cut.iter().filter(|cut| **cut).count();
    if n_cut > 0 {
        faces.retain(|face| !is_cut[face as usize]);
    }
    n_cut
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, TriMesh, shapes, topology};

    #[test]
    fn one_sided_surfaces_are_cut_to_two_sides() {
        for mesh in [shapes::klein_bottle(24, 12), shapes::moebius_strip(24, 4)] {
            let mut faces = RepairFaces::new(&mesh, &Attributes::default());
            let n_cut = cut_one_sided(&mut faces);
            let cut = TriMesh::new(mesh.positions().to_vec(), faces.corners).unwrap();
            assert!(topology(&cut).orientable && (1..60).contains(&n_cut), "{n_cut}");
        }
    }

    #[test]
    fn two_sided_surfaces_stay_in_any_winding() {
        let sphere = shapes::icosphere(2);
        let turned =
            sphere.faces().iter().enumerate().map(|(f, &[a, b, c])| if f % 3 == 0 { [a, c, b] } else { [a, b, c] });
        let mesh = TriMesh::new(sphere.positions().to_vec(), turned.collect()).unwrap();
        assert_eq!(cut_one_sided(&mut RepairFaces::new(&mesh, &Attributes::default())), 0);
    }
}
