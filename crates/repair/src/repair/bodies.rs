//! Bodies: for each component, the faces that separate solid cells from others.
//!
//! The outside is the cell whose faces span the most negative volume. All other cells are solid, except cavities. A
//! cell is a cavity if its faces are all wound one way and those of the outside all the opposite way.

use glam::DVec3;

use super::cells::cells;
use super::faces::{FaceOrigin, RepairFaces};

/// Largest share of area wound the other way in a cell that counts as wound one way.
const STRAY: f64 = 0.01;
/// Area of the faces over filled holes, relative to the input faces, above which a body may be a sheet.
const MOSTLY_NEW: f64 = 0.5;
/// Volume relative to filled area to the power 3/2, below which a filled body is a sheet; a half ball has 0.38.
const SHEET: f64 = 0.1;
/// Volume relative to area to the power 3/2, below which a body is rounding error.
const NOTHING: f64 = 1e-7;

#[derive(Clone, Debug, Default)]
pub(super) struct Body {
    /// Faces, and whether each must be reversed.
    pub hull: Vec<(u32, bool)>,
    /// Winding of the outer faces: 1 outward, -1 inward, 0 mixed.
    pub winding: i8,
    pub volume: f64,
}

#[derive(Clone, Copy, Default)]
struct CellFigures {
    component: u32,
    volume: f64,
    /// Area of the cell's input faces whose normals, as read, point into the cell, and out of it.
    wound: [f64; 2],
}

impl CellFigures {
    fn winding(&self) -> i8 {
        let [into, out] = self.wound;
        let stray = STRAY * (into + out);
        if into + out == 0.0 { 0 } else { i8::from(out <= stray) - i8::from(into <= stray) }
    }
}

/// Returns the bodies of all components that enclose something; `parted` is that of [`cells`].
pub(super) fn bodies(faces: &RepairFaces, parted: &[bool]) -> Vec<Body> {
    let cells = cells(faces, parted);
    let (component, n_components, sides) = (cells.component, cells.n_components, cells.of_sides);
    let all = measure_cells(faces, &component, &sides, cells.n);
    // The outside of a component spans the most negative volume, whatever its winding.
    let mut outside = vec![u32::MAX; n_components];
    for (number, cell) in (0..).zip(&all) {
        let least = &mut outside[cell.component as usize];
        if *least == u32::MAX || cell.volume < all[*least as usize].volume {
            *least = number;
        }
    }
    let is_solid = |number: u32| {
        let cell = &all[number as usize];
        let outside = outside[cell.component as usize];
        // A cavity only if the winding is clear: all faces outside one way, all of this cell the other.
        let opposite = all[outside as usize].winding();
        number != outside && (opposite == 0 || cell.winding() != opposite)
    };
    let body = |&outside: &u32| {
        let cell = all.get(outside as usize).copied().unwrap_or_default();
        Body { hull: Vec::new(), winding: cell.winding(), volume: -cell.volume }
    };
    let mut bodies: Vec<Body> = outside.iter().map(body).collect();
    for ((face, component), &[front, back]) in faces.numbers().zip(&component).zip(&sides) {
        let [front, back] = [front, back].map(&is_solid);
        // A face with one cell on both sides bounds nothing.
        if front != back {
            bodies[*component as usize].hull.push((face, front));
        }
    }
    bodies.retain(|body| !body.hull.is_empty() && encloses(faces, body));
    bodies
}

fn measure_cells(faces: &RepairFaces, component: &[u32], sides: &[[u32; 2]], n_cells: usize) -> Vec<CellFigures> {
    let mut all = vec![CellFigures::default(); n_cells];
    let mut origins: Vec<Option<DVec3>> = vec![None; faces.len()];
    for ((face, &component), &[front, back]) in faces.numbers().zip(component).zip(sides) {
        let points = faces.points(face);
        // Volumes are the same about any point; one of the component keeps digits.
        let origin = *origins[component as usize].get_or_insert(points[0]);
        let (normal, is_new) = (faces.normal(face), faces.origins[face as usize] == FaceOrigin::New);
        let volume = (points[0] - origin).dot(normal) / 6.0;
        let area = if is_new { 0.0 } else { 0.5 * normal.length() };
        let turned = usize::from(faces.origins[face as usize] == FaceOrigin::Turned);
        for (cell, volume, way) in [(front, -volume, turned), (back, volume, 1 - turned)] {
            let cell = &mut all[cell as usize];
            cell.component = component;
            if front != back {
                cell.volume += volume;
                cell.wound[way] += area;
            }
        }
    }
    all
}

fn encloses(faces: &RepairFaces, body: &Body) -> bool {
    let [new, old] = super::fill::areas(faces, body.hull.iter().map(|(face, _)| *face));
    // A sheet whose filled boundary covers it: mostly new area, hardly any volume.
    let is_sheet = new > MOSTLY_NEW * old && body.volume < SHEET * new.powf(1.5);
    !is_sheet && body.volume > NOTHING * (new + old).powf(1.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, TriMesh, shapes};

    fn bodies_of(mesh: &TriMesh) -> Vec<Body> {
        bodies(&RepairFaces::new(mesh, &Attributes::default()), &vec![false; mesh.faces().len()])
    }

    #[test]
    fn windings_and_volumes_of_known_bodies() {
        let cube = shapes::cuboid([2.0; 3], 3);
        let turned = cube.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
        let inside_out = TriMesh::new(cube.positions().to_vec(), turned).unwrap();
        for (mesh, winding) in [(&cube, 1), (&inside_out, -1)] {
            let all = bodies_of(mesh);
            assert_eq!((all.len(), all[0].winding, all[0].hull.len()), (1, winding, cube.faces().len()));
            assert!((all[0].volume - 8.0).abs() < 1e-5 && all[0].hull.iter().all(|(_, turn)| *turn == (winding < 0)));
        }
        assert!(bodies_of(&shapes::grid(3, 3)).is_empty() && bodies_of(&shapes::klein_bottle(16, 8)).is_empty());
        assert_eq!(bodies_of(&shapes::many_boxes(9)).len(), 9);
    }

    #[test]
    fn a_wall_is_no_part_of_the_hull() {
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
        let faces = vec![[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4], [0, 1, 2]];
        let all = bodies_of(&TriMesh::new(corners, faces).unwrap());
        let hull: Vec<u32> = all[0].hull.iter().map(|(face, _)| *face).collect();
        assert_eq!((all.len(), hull), (1, (0..6).collect()));
    }
}
