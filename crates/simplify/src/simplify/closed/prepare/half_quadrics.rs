//! Quadrics along the cut of a half, completed to those of the whole mesh.

use crate::simplify::closed::pins::PlaneVertices;

use super::surface::{Neighbour, PreparedSurface, planes_around};

pub fn complete(surface: &mut PreparedSurface, plane: &PlaneVertices) {
    for v in (0..surface.n_vertices() as u32).filter(|&v| plane.contains(v)) {
        // The cut gets no boundary lines: in the whole mesh it is no boundary.
        let ring = surface.rings.ring(v).iter().map(|&w| match surface.positions.get(w as usize) {
            Some(&position) if plane.contains(w) => Neighbour::AlongCut(position),
            Some(&position) => Neighbour::At(position),
            None => Neighbour::Ghost,
        });
        let v = v as usize;
        let quadric = plane.with_image(planes_around(surface.positions[v], ring, surface.area_weights));
        // A vertex without area keeps its least weight.
        if quadric[0] + quadric[3] + quadric[5] > 0.0 {
            surface.quadrics[v] = quadric;
        }
        surface.normals[v][plane.axis()] = 0.0;
        surface.normals[v] = surface.normals[v].normalize_or_zero();
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
