//! Surfaces that are invisible from outside.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::{area_normal, area_normal_f64, corners_f64};
use crate::linalg::Rows;
use crate::mesh::TriMesh;
use crate::parallel;
use crate::spatial::{Occluders, visible_areas, visible_faces};

use super::input::Input;

const AXES: usize = 8;
const AXES_OF_COMPONENTS: usize = 3;
/// A front that nothing hides shows a quarter of its area, averaged over all directions.
const SHARE_OF_FRONT: f32 = 4.0;
/// Means over neighbours, which even out what few pixels say.
const ROUNDS_OF_MEANS: usize = 2;
/// Rays per face of a component; at least `LEAST_RAYS` in all.
const RAYS: f64 = 0.25;
const LEAST_RAYS: usize = 1024;
/// Rays of all hidden components: a number per face, or the second number if larger.
const ALL_RAYS: [usize; 2] = [1, 65_536];
/// Length that a ray skips at its start, as a share of the diagonal.
const MARGIN: f64 = 1e-4;
/// Powers of the inverse of the root of x^5 = x + 1: a sequence that fills four dimensions evenly.
///
/// Roberts 2018, "The unreasonable effectiveness of quasirandom sequences".
const STEPS: [f64; 4] = [0.856_674_883_854_503, 0.733_891_856_627_126, 0.628_706_721_404_131, 0.538_597_258_071_713];

/// Returns each vertex's visible share of its area, averaged with its neighbours; 1 where a front is never hidden.
pub(super) fn visible_shares(input: &Input) -> Vec<f32> {
    let view = input.view();
    let n = input.mesh.positions().len();
    let mut shares = vec![[0.0f32; 2]; n];
    let visible = visible_areas(view.mesh.positions(), view.mesh.faces(), AXES);
    for ((&face, placed), visible) in view.faces.iter().zip(view.mesh.faces()).zip(visible) {
        let area = 0.5 * area_normal(placed.map(|v| Vec3::from(view.mesh.positions()[v as usize]))).length();
        for &v in &input.mesh.faces()[face as usize] {
            let [sum, areas] = &mut shares[v as usize];
            (*sum, *areas) = (*sum + SHARE_OF_FRONT * visible as f32, *areas + area);
        }
    }
    for _ in 0..ROUNDS_OF_MEANS {
        shares = sum_over_neighbours(input.mesh, &shares);
    }
    shares.into_iter().map(|[sum, areas]| if areas > 0.0 { sum / areas } else { 1.0 }).collect()
}

fn sum_over_neighbours(mesh: &TriMesh, values: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let mut sums = values.to_vec();
    for face in mesh.faces() {
        let of_face = [0, 1].map(|k| face.iter().map(|&v| values[v as usize][k]).sum::<f32>());
        face.iter().for_each(|&v| sums[v as usize].iter_mut().zip(of_face).for_each(|(sum, value)| *sum += value));
    }
    sums
}

pub(super) fn hidden_components(mesh: &TriMesh, component: &[u32], n: usize) -> Vec<bool> {
    let mut hidden = vec![true; n];
    let seen = visible_faces(mesh.positions(), mesh.faces(), AXES_OF_COMPONENTS);
    // Views show most components. Those that appear in none are tested with rays, which find gaps of any width.
    component.iter().zip(seen).for_each(|(&c, seen)| hidden[c as usize] &= !seen);
    if !hidden.contains(&true) {
        return hidden;
    }
    let triangles: Vec<[[f32; 3]; 3]> =
        mesh.faces().iter().map(|face| face.map(|v| mesh.positions()[v as usize])).collect();
    // Only visible components can hide others from outside.
    let shown = triangles.iter().zip(component).filter(|(_, c)| !hidden[**c as usize]);
    let occluders = Occluders::new(&shown.map(|(corners, _)| *corners).collect::<Vec<_>>());
    let faces = Rows::new(n, component.iter().copied().zip(0..).filter(|(c, _)| hidden[*c as usize]));
    // The hidden components share one number of rays, so that many of them take no longer.
    let n_hidden = hidden.iter().filter(|hidden| **hidden).count();
    let most_rays = (ALL_RAYS[0] * triangles.len()).max(ALL_RAYS[1]) / n_hidden;
    let start = MARGIN * mesh.diagonal();
    let is_hidden = |component: usize| {
        let faces = faces.row(component);
        // The number of rays grows with the number of faces, up to this component's share.
        let n_rays = ((RAYS * faces.len() as f64) as usize).max(LEAST_RAYS).min(most_rays.max(64));
        let corners = |face: u32| corners_f64(triangles[face as usize]);
        !faces.is_empty()
            && !any_ray_escapes(&occluders, &faces.iter().map(|&face| corners(face)).collect::<Vec<_>>(), n_rays, start)
    };
    parallel::map(n, 1, is_hidden)
}

/// Returns whether one of `n_rays` rays from the triangles meets nothing beyond `start`.
fn any_ray_escapes(occluders: &Occluders, triangles: &[[DVec3; 3]], n_rays: usize, start: f64) -> bool {
    let sums: Vec<f64> = triangles
        .iter()
        .scan(0.0, |sum, corners| {
            *sum += area_normal_f64(*corners).length();
            Some(*sum)
        })
        .collect();
    let all = sums.last().copied().unwrap_or(0.0);
    parallel::any(n_rays, 256, |ray| {
        let place = (ray as f64 + 0.5) / n_rays as f64 * all;
        let [a, b, c] = triangles[sums.partition_point(|&sum| sum <= place).min(triangles.len() - 1)];
        // Two numbers choose the point on the face, two the direction.
        let [u, v, height, turn] = STEPS.map(|step| (0.5 + ray as f64 * step).fract());
        let root = u.sqrt();
        let point = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
        !occluders.is_blocked(point, direction(height, turn), start)
    })
}

fn direction(height: f64, turn: f64) -> DVec3 {
    let height = 1.0 - 2.0 * height;
    let (radius, angle) = ((1.0 - height * height).max(0.0).sqrt(), std::f64::consts::TAU * turn);
    DVec3::new(radius * angle.cos(), radius * angle.sin(), height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn join_meshes(parts: &[&TriMesh]) -> (TriMesh, Vec<u32>) {
        let component = (0..).zip(parts).flat_map(|(number, part)| vec![number; part.faces().len()]);
        (shapes::unite(parts.iter().copied()), component.collect())
    }

    fn scale_mesh(mesh: &TriMesh, by: f32) -> TriMesh {
        TriMesh::new(mesh.positions().iter().map(|p| p.map(|x| by * x)).collect(), mesh.faces().to_vec()).unwrap()
    }

    fn find_hidden(parts: &[&TriMesh]) -> Vec<bool> {
        let (mesh, component) = join_meshes(parts);
        hidden_components(&mesh, &component, parts.len())
    }

    #[test]
    fn surfaces_behind_a_narrow_gap_are_visible() {
        // A sphere without one of its 20,480 faces, away from the axes of the views, has a hole 1/70 wide.
        let outer = shapes::icosphere(5);
        let holed = TriMesh::new(outer.positions().to_vec(), outer.faces()[1..].to_vec()).unwrap();
        let inner = scale_mesh(&shapes::icosphere(4), 0.5);
        assert_eq!(find_hidden(&[&outer, &inner]), [false, true]);
        assert_eq!(find_hidden(&[&holed, &inner]), [false, false]);
        assert_eq!(find_hidden(&[&inner, &outer, &scale_mesh(&inner, 0.5)]), [true, false, true]);
    }

    #[test]
    fn open_surfaces_are_visible_from_either_side() {
        let grid = shapes::grid(20, 20);
        for mesh in [&grid, &shapes::open_cylinder(24, 8), &shapes::torus(40, 20, 2.0, 0.7), &shapes::bolt(20)] {
            assert_eq!(find_hidden(&[mesh]), [false]);
        }
    }

    #[test]
    fn visible_shares_are_one_outside_and_none_inside() {
        let sphere = shapes::icosphere(4);
        let (mesh, component) = join_meshes(&[&sphere, &scale_mesh(&sphere, 0.9)]);
        let shares = visible_shares(&Input::bare(&mesh));
        let n = sphere.positions().len();
        assert!(component.len() == 2 * sphere.faces().len() && shares[n..].iter().all(|share| *share == 0.0));
        let mean = shares[..n].iter().sum::<f32>() / n as f32;
        assert!((mean - 1.0).abs() < 0.05 && shares[..n].iter().all(|share| (0.6..1.4).contains(share)), "{mean}");
        // Of a bowl without its upper half, the inside is seen less than the outside.
        let bowl = |mesh: &TriMesh| {
            let faces =
                mesh.faces().iter().copied().filter(|f| f.iter().all(|&v| mesh.positions()[v as usize][2] < 0.3));
            TriMesh::new(mesh.positions().to_vec(), faces.collect()).unwrap()
        };
        let (both, _) = join_meshes(&[&bowl(&sphere), &bowl(&scale_mesh(&sphere, 0.95))]);
        let shares = visible_shares(&Input::bare(&both));
        let lowest = |range: std::ops::Range<usize>| {
            range.min_by(|&v, &w| both.positions()[v][2].total_cmp(&both.positions()[w][2])).unwrap()
        };
        let [outside, inside] = [shares[lowest(0..n)], shares[lowest(n..2 * n)]];
        assert!(outside > 0.8 && (0.02..0.6).contains(&inside), "{outside} {inside}");
    }

    #[test]
    fn a_surface_just_below_another_is_visible() {
        let sphere = shapes::icosphere(4);
        assert_eq!(find_hidden(&[&sphere, &scale_mesh(&sphere, 0.99999)]), [false, false]);
        assert_eq!(find_hidden(&[&sphere, &scale_mesh(&sphere, 0.9)]), [false, true]);
    }
}
