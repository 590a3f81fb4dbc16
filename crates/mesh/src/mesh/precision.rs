//! Tests whether single precision can hold a mesh of doubles.

use rustc_hash::FxHashMap;

use super::union_find::join_vertices;
use crate::linalg::Rows;

/// Smallest size of a component whose vertices rounding may merge, in spacings of `f32` numbers.
const STEPS: f64 = 4096.0;
/// Smallest size of any component, in spacings of `f32` numbers.
const FEWEST: f64 = 8.0;

pub(super) struct LostComponent {
    pub vertex: usize,
    /// Diagonal of the component's bounding box.
    pub size: f64,
    /// Spacing of `f32` numbers at the component.
    pub step: f64,
}

/// Returns the first component that rounding `positions` to `local` damages.
///
/// `single` holds, for each vertex, the first vertex at its local position.
pub(super) fn find_lost_component(
    positions: &[[f64; 3]],
    local: &[[f32; 3]],
    single: &[u32],
    faces: &[[u32; 3]],
) -> Option<LostComponent> {
    let is_moved = |&vertex: &u32| positions[vertex as usize] != positions[single[vertex as usize] as usize];
    if !faces.iter().any(|face| face.iter().any(is_moved) || is_short(positions, local, face)) {
        return None;
    }
    let exact = equal_positions(positions);
    let components = PositionComponents::new(&exact, faces);
    let (before, after) = (count_faces(&components, &exact, faces), count_faces(&components, single, faces));
    (0..components.faces.n_rows() as u32).find_map(|component| {
        let measured = components.measure(component, positions, local, faces);
        let is_hurt =
            measured.size < STEPS * measured.step && components.falls_together(component, &exact, single, faces);
        let is_lost = is_hurt || after[component as usize] == 0 || measured.size < FEWEST * measured.step;
        (is_lost && before[component as usize] > 0).then_some(measured)
    })
}

fn is_short(positions: &[[f64; 3]], local: &[[f32; 3]], face: &[u32; 3]) -> bool {
    let corners = face.map(|vertex| positions[vertex as usize]);
    let reach =
        face.map(|vertex| local[vertex as usize]).as_flattened().iter().fold(0.0f32, |most, x| most.max(x.abs()));
    let side = |axis: usize| {
        let along = corners.map(|corner| corner[axis]);
        along.into_iter().fold(f64::MIN, f64::max) - along.into_iter().fold(f64::MAX, f64::min)
    };
    side(0).max(side(1)).max(side(2)) < FEWEST * f64::from(reach * f32::EPSILON)
}

fn equal_positions(positions: &[[f64; 3]]) -> Vec<u32> {
    let mut first = FxHashMap::default();
    let key = |p: &[f64; 3]| p.map(|x| (x + 0.0).to_bits());
    positions.iter().zip(0..).map(|(position, vertex)| *first.entry(key(position)).or_insert(vertex)).collect()
}

struct PositionComponents {
    component_of_face: Vec<u32>,
    faces: Rows<u32>,
}

impl PositionComponents {
    fn new(exact: &[u32], faces: &[[u32; 3]]) -> Self {
        let mut sets = join_vertices(exact.len(), faces.iter().map(|face| face.map(|vertex| exact[vertex as usize])));
        let mut numbers = FxHashMap::default();
        let mut component_of_face = Vec::with_capacity(faces.len());
        for face in faces {
            let next = numbers.len() as u32;
            component_of_face.push(*numbers.entry(sets.find(exact[face[0] as usize])).or_insert(next));
        }
        let faces = Rows::new(numbers.len(), component_of_face.iter().copied().zip(0..));
        Self { component_of_face, faces }
    }

    fn faces<'a>(&'a self, component: u32, faces: &'a [[u32; 3]]) -> impl Iterator<Item = &'a [u32; 3]> {
        self.faces.row(component as usize).iter().map(|&f| &faces[f as usize])
    }

    fn falls_together(&self, component: u32, exact: &[u32], single: &[u32], faces: &[[u32; 3]]) -> bool {
        let mut first = FxHashMap::default();
        let mut vertices = self.faces(component, faces).flatten().map(|&vertex| vertex as usize);
        vertices.any(|vertex| *first.entry(single[vertex]).or_insert(exact[vertex]) != exact[vertex])
    }

    fn measure(&self, component: u32, positions: &[[f64; 3]], local: &[[f32; 3]], faces: &[[u32; 3]]) -> LostComponent {
        let (mut low, mut high, mut reach, mut first) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0f64, u32::MAX);
        for &vertex in self.faces(component, faces).flatten() {
            first = first.min(vertex);
            for axis in 0..3 {
                let x = positions[vertex as usize][axis];
                (low[axis], high[axis]) = (low[axis].min(x), high[axis].max(x));
                reach = reach.max(f64::from(local[vertex as usize][axis].abs()));
            }
        }
        let side = |axis: usize| high[axis] - low[axis];
        let step = (reach * f64::from(f32::EPSILON)).max(f64::from(f32::from_bits(1)));
        LostComponent { vertex: first as usize, size: side(0).hypot(side(1)).hypot(side(2)), step }
    }
}

fn count_faces(components: &PositionComponents, first: &[u32], faces: &[[u32; 3]]) -> Vec<usize> {
    let mut left = vec![0; components.faces.n_rows()];
    for (face, &component) in faces.iter().zip(&components.component_of_face) {
        let [a, b, c] = face.map(|vertex| first[vertex as usize]);
        left[component as usize] += usize::from(a != b && b != c && c != a);
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::first_equal::join_positions;
    use crate::mesh::shapes;

    type Both = (Vec<[f64; 3]>, Vec<[f32; 3]>, Vec<[u32; 3]>);

    fn find(positions: &[[f64; 3]], local: &[[f32; 3]], faces: &[[u32; 3]]) -> Option<LostComponent> {
        find_lost_component(positions, local, &join_positions(local).0, faces)
    }

    fn two_spheres(apart: f64) -> Both {
        let sphere = shapes::icosphere(2);
        let n = sphere.positions().len() as u32;
        let at =
            |shift: f64| sphere.positions().iter().map(move |p| [f64::from(p[0]) + shift, p[1].into(), p[2].into()]);
        let positions: Vec<[f64; 3]> = at(0.0).chain(at(apart)).collect();
        let faces = sphere.faces().iter().copied().chain(sphere.faces().iter().map(|face| face.map(|v| v + n)));
        let local = positions.iter().map(|p| p.map(|x| x as f32)).collect();
        (positions, local, faces.collect())
    }

    #[test]
    fn components_far_apart_exceed_single_precision() {
        for (apart, is_held) in [(10.0, true), (1e4, true), (1e9, false), (1e12, false)] {
            let (positions, local, faces) = two_spheres(apart);
            assert_eq!(find(&positions, &local, &faces).is_none(), is_held, "{apart}");
        }
        let (positions, local, faces) = two_spheres(1e9);
        let lost = find(&positions, &local, &faces).unwrap();
        assert_eq!((lost.vertex, lost.size.round()), (162, 3.0));
    }

    #[test]
    fn seams_of_noise_are_no_loss() {
        let positions: Vec<[f64; 3]> = vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.1],
            [1.0 + 1e-15, 1e-16, 0.0],
            [1.0, 1.0, 0.0],
            [1e-16, 1.0, 0.1 + 1e-16],
        ];
        let local: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x as f32)).collect();
        assert!(find(&positions, &local, &[[0, 1, 2], [3, 4, 5]]).is_none());
    }
}
