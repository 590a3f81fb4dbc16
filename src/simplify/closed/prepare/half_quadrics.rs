//! Quadrics along the cut of a half, completed to those of the whole mesh.

use crate::simplify::closed::pins::PlaneVertices;

use super::surface::{PreparedSurface, add, plane_of};

pub fn complete(surface: &mut PreparedSurface, plane: &PlaneVertices) {
    // The cut gets no boundary lines: in the whole mesh it is no boundary.
    let mut sums = vec![[0.0f32; 6]; if plane.len() > 0 { surface.n_vertices() } else { 0 }];
    for face in surface.faces.iter().filter(|face| face.iter().any(|&v| plane.contains(v))) {
        if let Some((_, quadric)) = plane_of(face.map(|v| surface.positions[v as usize])) {
            let quadric = plane.with_image(quadric);
            let corners = face.iter().filter(|&&v| plane.contains(v));
            corners.for_each(|&v| add(&mut sums[v as usize], &quadric));
        }
    }
    let of_cut: Vec<usize> = (0..sums.len()).filter(|&v| plane.contains(v as u32)).collect();
    for &v in &of_cut {
        surface.normals[v][plane.axis()] = 0.0;
        surface.normals[v] = surface.normals[v].normalize_or_zero();
    }
    add_boundaries(surface, plane, &mut sums);
    for v in of_cut {
        // A vertex without area keeps its least weight.
        let weight = sums[v][0] + sums[v][3] + sums[v][5];
        if weight > 0.0 {
            surface.quadrics[v] = sums[v];
        }
    }
}

fn add_boundaries(surface: &PreparedSurface, plane: &PlaneVertices, sums: &mut [[f32; 6]]) {
    let boundaries = if sums.is_empty() { Vec::new() } else { surface.rings.ghost_faces() };
    for [a, b, _] in boundaries.into_iter().filter(|&[a, b, _]| plane.contains(a) != plane.contains(b)) {
        let v = if plane.contains(a) { a } else { b };
        let line = plane.with_image(surface.line_along_boundary([a, b]));
        add(&mut sums[v as usize], &line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::shapes;
    use crate::simplify::input::Half;

    #[test]
    fn a_vertex_on_the_cut_has_the_quadric_of_the_whole_mesh() {
        let whole = shapes::torus(24, 12, 1.0, 0.4);
        let x = |v: u32| whole.positions()[v as usize][0];
        let faces: Vec<[u32; 3]> =
            whole.faces().iter().copied().filter(|face| face.iter().all(|&v| x(v) > -1e-6)).collect();
        let (half, sources) = crate::mesh::compact(whole.positions(), faces).unwrap();
        let on_plane: Vec<bool> = half.positions().iter().map(|p| p[0].abs() < 1e-6).collect();
        assert_eq!(on_plane.iter().filter(|&&on| on).count(), 24);
        let (mut surface, of_whole) =
            (PreparedSurface::new(&half, Pulse::NONE), PreparedSurface::new(&whole, Pulse::NONE));
        let plane = PlaneVertices::from_half(&surface, &Half { axis: 0, on_plane: &on_plane });
        complete(&mut surface, &plane);
        // The halves are normalised by different powers of two.
        let ratio = (surface.scale.to_unit([1.0, 0.0, 0.0]) - surface.scale.to_unit([0.0; 3])).x
            / (of_whole.scale.to_unit([1.0, 0.0, 0.0]) - of_whole.scale.to_unit([0.0; 3])).x;
        for v in (0..on_plane.len()).filter(|&v| on_plane[v]) {
            let meant = of_whole.quadrics[sources[v] as usize].map(|x| x * (ratio * ratio) as f32);
            for (here, there) in surface.quadrics[v].iter().zip(meant) {
                assert!((here - there).abs() < 1e-5, "{:?} {meant:?}", surface.quadrics[v]);
            }
        }
    }
}
