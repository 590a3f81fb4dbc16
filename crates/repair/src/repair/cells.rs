//! Cells: the regions into which faces divide space.
//!
//! Around an edge, a side of a face and the next side by angle bound one cell (Attene 2018, Sec. 3.3; Zhou, Grinspun,
//! Zorin and Jacobson 2016, "Mesh arrangements for solid geometry", Sec. 3). Where surfaces intersect away from edges,
//! angles connect inside and outside; such components are cut into sheets (`mesh::manifold`), whose cells are used.

use glam::DVec3;

use crate::mesh::half_edges::{HalfEdge, NO_TWIN, for_each_edge, next, start, twins};
use crate::mesh::manifold;
use crate::mesh::pulse::Pulse;
use crate::mesh::union_find::UnionFind;

use super::faces::RepairFaces;

pub(super) struct Cells {
    /// Cell at each side, n_faces x 2, first the side of the normal.
    pub of_sides: Vec<[u32; 2]>,
    pub n: usize,
    pub component: Vec<u32>,
    pub n_components: usize,
}

/// Finds the cells of faces; both sides of a face with an open edge are in one cell.
///
/// Sides of `parted` faces are joined as the cut into a manifold joins the faces, not by angle.
pub(super) fn cells(faces: &RepairFaces, parted: &[bool]) -> Cells {
    let mut sides = UnionFind::new(2 * faces.len());
    let mut components = UnionFind::new(faces.len());
    for_each_edge(faces.positions.len(), &faces.corners, |ends, around| {
        if parted[around[0].face() as usize] {
            return;
        }
        // Order is immaterial for one or two faces.
        let blades = match around.len() {
            1 | 2 => around.iter().map(|&half| SidesAtEdge::new(faces, half)).collect(),
            _ => sort_by_angle(faces, ends, around),
        };
        // At an edge with one face, this joins the two sides of the face.
        for (blade, after) in blades.iter().zip(blades.iter().cycle().skip(1)) {
            sides.union(blade.ahead, after.behind);
        }
        // Components follow edges even where sides stay separate.
        around.windows(2).for_each(|pair| _ = components.union(pair[0].face(), pair[1].face()));
    });
    // Faces of leaking components, whose angles are meaningless.
    let some: Vec<u32> = faces.numbers().filter(|&face| parted[face as usize]).collect();
    join_sheets(faces, &some, &mut sides, &mut components);
    let (of_side, n) = sides.number_sets(Pulse::NONE);
    let (component, n_components) = components.number_sets(Pulse::NONE);
    Cells { of_sides: of_side.chunks_exact(2).map(|sides| [sides[0], sides[1]]).collect(), n, component, n_components }
}

fn join_sheets(faces: &RepairFaces, some: &[u32], sides: &mut UnionFind, components: &mut UnionFind) {
    let corners: Vec<[u32; 3]> = some.iter().map(|&face| faces.corners[face as usize]).collect();
    let cut = manifold(faces.positions, &corners);
    let n_vertices = faces.positions.len();
    // Maps copies made by the cut back to original vertices.
    let vertex_of = |v: u32| (v as usize).checked_sub(n_vertices).map_or(v, |copy| cut.copies[copy]);
    let is_turned = |i: usize| vertex_of(cut.faces[i][1]) != corners[i][1];
    for (half, &twin) in twins(n_vertices + cut.copies.len(), &cut.faces).iter().enumerate() {
        let face = some[half / 3];
        // A boundary of the cut: a path around it leads from one side to the other.
        if twin == NO_TWIN {
            sides.union(2 * face, 2 * face + 1);
            continue;
        }
        let other = some[twin as usize / 3];
        let along = start(&cut.faces, half as u32) == start(&cut.faces, twin);
        // Winding of the pair in the original faces, which the cut may have reversed.
        let turns = u32::from(along ^ is_turned(half / 3) ^ is_turned(twin as usize / 3));
        sides.union(2 * face, 2 * other + turns);
        sides.union(2 * face + 1, 2 * other + (1 - turns));
        components.union(face, other);
    }
}

/// Share of a component's area with one cell on both sides, above which its inside leaks.
const LEAK: f64 = 0.05;

/// Marks the faces of leaking components, where angles say little about the inside.
pub(super) fn find_leaks(faces: &RepairFaces) -> Vec<bool> {
    let cells = cells(faces, &vec![false; faces.len()]);
    let mut areas = vec![[0.0; 2]; cells.n_components];
    for ((face, &component), [front, back]) in faces.numbers().zip(&cells.component).zip(&cells.of_sides) {
        areas[component as usize][usize::from(front == back)] += faces.area(face);
    }
    let leaks = |[between, within]: [f64; 2]| within > LEAK * (between + within);
    cells.component.iter().map(|&component| leaks(areas[component as usize])).collect()
}

struct SidesAtEdge {
    ahead: u32,
    behind: u32,
}

impl SidesAtEdge {
    fn new(faces: &RepairFaces, half: HalfEdge) -> Self {
        let [front, back] = [2 * half.face(), 2 * half.face() + 1];
        let (ahead, behind) = if half.runs_up(&faces.corners) { (front, back) } else { (back, front) };
        Self { ahead, behind }
    }
}

fn sort_by_angle(faces: &RepairFaces, [low, high]: [u32; 2], around: &[HalfEdge]) -> Vec<SidesAtEdge> {
    let (from, along) = (faces.position(low), (faces.position(high) - faces.position(low)).normalize_or_zero());
    let tip = |half: &HalfEdge| faces.position(start(&faces.corners, next(next(half.half_edge)))) - from;
    let across = |arm: DVec3| arm - arm.dot(along) * along;
    // Angles are measured from any face with width.
    let right = around.iter().map(|half| across(tip(half))).find(|arm| *arm != DVec3::ZERO).unwrap_or(DVec3::X);
    let right = right.normalize_or_zero();
    let up = along.cross(right);
    let angle = |half: &HalfEdge| tip(half).dot(up).atan2(tip(half).dot(right));
    let mut blades: Vec<(f64, &HalfEdge)> = around.iter().map(|half| (angle(half), half)).collect();
    blades.sort_by(|a, b| a.0.total_cmp(&b.0));
    blades.into_iter().map(|(_, &half)| SidesAtEdge::new(faces, half)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, TriMesh, shapes};

    fn all(mesh: &TriMesh, is_parted: bool) -> Cells {
        cells(&RepairFaces::new(mesh, &Attributes::default()), &vec![is_parted; mesh.faces().len()])
    }

    fn count(mesh: &TriMesh) -> usize {
        all(mesh, false).n
    }

    #[test]
    fn cells_of_known_meshes() {
        assert_eq!(count(&shapes::icosphere(2)), 2);
        // Both sides of an open surface, or of a one-sided one, are in one cell.
        assert_eq!((count(&shapes::grid(3, 3)), count(&shapes::klein_bottle(16, 8))), (1, 1));
        // Two tetrahedra at one edge: two insides and one outside.
        assert_eq!(count(&shapes::tetrahedra_sharing_edge()), 3);
    }

    #[test]
    fn a_wall_makes_two_rooms_whichever_way_it_is_wound() {
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
        for wall in [[0, 1, 2], [0, 2, 1]] {
            let faces = vec![[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4], wall];
            let mesh = TriMesh::new(corners.clone(), faces).unwrap();
            let Cells { of_sides: sides, n, .. } = all(&mesh, false);
            assert_eq!(n, 3);
            let outside = sides[0][0];
            assert!(sides[..6].iter().all(|[front, back]| *front == outside && *back != outside));
            assert!(!sides[6].contains(&outside) && sides[6][0] != sides[6][1]);
        }
    }

    #[test]
    fn sheets_have_two_sides_of_their_own() {
        for mesh in [shapes::icosphere(2), shapes::tetrahedra_sharing_edge(), shapes::many_boxes(5)] {
            let turned =
                mesh.faces().iter().enumerate().map(|(f, &[a, b, c])| if f % 3 == 0 { [a, c, b] } else { [a, b, c] });
            let turned = TriMesh::new(mesh.positions().to_vec(), turned.collect()).unwrap();
            let sheets = all(&turned, true);
            assert_eq!(sheets.n, 2 * sheets.n_components);
            for (&[front, back], &component) in sheets.of_sides.iter().zip(&sheets.component) {
                let same = |other: &u32| *other == component;
                assert!(front != back && sheets.component.iter().filter(|other| same(other)).count() > 3);
            }
        }
    }

    #[test]
    fn crossed_sheets_leak() {
        // Two tetrahedra at one edge that intersect: around the edge their faces alternate.
        let tips = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [-0.7, 0.7, 0.0]];
        let positions: Vec<[f32; 3]> = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]].into_iter().chain(tips).collect();
        let body = |a, b| [[0, 1, a], [1, 0, b], [0, a, b], [1, b, a]];
        let mesh = TriMesh::new(positions, [body(2, 3), body(4, 5)].concat()).unwrap();
        assert!(find_leaks(&RepairFaces::new(&mesh, &Attributes::default())).iter().all(|leaks| *leaks));
        assert_eq!(all(&mesh, true).n, 4);
        assert!(!find_leaks(&RepairFaces::new(&shapes::tetrahedra_sharing_edge(), &Attributes::default()))[0]);
    }
}
