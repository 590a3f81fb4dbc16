//! Edge collapse by memoryless quadrics (Garland and Heckbert 1997; Lindstrom and Turk 1999) on a closed complex.
//!
//! Ghost vertices close the boundaries. So the link condition of closed surfaces (Dey et al. 1999) preserves the
//! topology: both ends of an edge share exactly the two opposite vertices.

mod attribute_quadrics;
mod cheapest_edge;
mod compaction;
mod component_ceilings;
mod constraints;
mod corner_table;
mod deformation;
mod end_ring;
mod failed_merges;
mod history;
mod kept_copy;
mod memoryless;
mod merge;
mod pair;
mod passes;
mod poses;
mod record_merges;
mod recording;
mod relaxation;
mod retries;
mod state;
mod stretch;

pub use attribute_quadrics::sum_attribute_quadrics;
pub use component_ceilings::{Ceiling, Ceilings};
pub use constraints::Constraints;
pub use history::{CollapseEvent, Renewal};
pub use pair::{PULL, Placement};
pub use poses::Poses;
pub use recording::RecordedMerge;
pub use state::{Collapse, CollapseEnd, merges_to, size_with_shape};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{Attributes, Channel, FeatureEdge, Role, TriMesh, compact, seams, shapes, topology};
    use crate::simplify::closed::output::Output;
    use crate::simplify::closed::prepare::area_weights::build_rounded_cube;
    use crate::simplify::closed::prepare::prepare;
    use crate::simplify::closed::prepare::surface::PreparedSurface;
    use crate::simplify::closed::request::{ClosedRequest, Task};
    use crate::simplify::input::Input;
    use crate::simplify::limits::Limit;
    use crate::simplify::options::ClosedOptions;
    use attribute_quadrics::AttributeQuadrics;
    use glam::Vec3;

    fn begin(mesh: &TriMesh) -> (PreparedSurface<'_>, Collapse<'static>) {
        let surface = PreparedSurface::new(mesh, Pulse::NONE);
        let collapse = Collapse::new(Pulse::NONE, &surface);
        (surface, collapse)
    }

    fn collapse_to(mesh: &TriMesh, vertices: usize) -> (PreparedSurface<'_>, CollapseEnd, Output) {
        let (surface, mut collapse) = begin(mesh);
        let end = collapse.run(Limit::from_vertices(vertices));
        let output = collapse.output();
        (surface, end, output)
    }

    #[test]
    fn bevels_stay_near_where_small_faces_weigh_more_than_their_areas() {
        let (radius, n_vertices) = (0.02, 59);
        let mesh = build_rounded_cube(radius);
        let largest_distance = |is_weighed: bool| {
            let mut surface = PreparedSurface::new(&mesh, Pulse::NONE);
            if is_weighed {
                surface.weigh_small_faces();
            }
            let mut collapse = Collapse::new(Pulse::NONE, &surface);
            assert_eq!(collapse.run(Limit::from_vertices(n_vertices)), CollapseEnd::Reached);
            // The cube's surface is at the radius around its core.
            let distance = |p: &Vec3| {
                let p = Vec3::from(surface.scale.restore(p.as_dvec3()));
                (p.distance(p.clamp(Vec3::splat(radius - 0.5), Vec3::splat(0.5 - radius))) - radius).abs()
            };
            collapse.output().positions.iter().map(distance).fold(0.0, f32::max)
        };
        let [plain, weighed] = [false, true].map(largest_distance);
        assert!(weighed < 0.6 * plain, "{weighed} {plain}");
    }

    fn assert_corners_stay(mesh: &TriMesh, corners: &[[f32; 3]]) {
        let (surface, end, output) = collapse_to(mesh, corners.len());
        assert_eq!((end, output.positions.len()), (CollapseEnd::Reached, corners.len()));
        let left: Vec<[f32; 3]> = output.positions.iter().map(|p| surface.scale.restore(p.as_dvec3())).collect();
        for &corner in corners {
            let nearest = left.iter().map(|&p| Vec3::from(p).distance(corner.into())).fold(f32::INFINITY, f32::min);
            assert!(nearest < 1e-3, "{corner:?} {nearest}");
        }
    }

    #[test]
    fn corners_are_what_stays_of_flat_parts() {
        let cube: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|x| x as f32)).collect();
        assert_corners_stay(&shapes::cuboid([1.0; 3], 5), &cube);
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        assert_corners_stay(&shapes::grid(9, 6), &square);
    }

    #[test]
    fn the_smallest_surfaces_stay() {
        let tetrahedra =
            (0..300u32).flat_map(|i| [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|f| f.map(|v| 4 * i + v)));
        let places = (0..300).flat_map(|i| {
            let x = 3.0 * i as f32;
            [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]]
        });
        let mesh = TriMesh::new(places.collect(), tetrahedra.collect()).unwrap();
        for shape in [&mesh, &shapes::tetrahedron()] {
            let (_, end, output) = collapse_to(shape, 1);
            assert_eq!((end, output.faces().len()), (CollapseEnd::Smallest, shape.faces().len()));
        }
        for shape in [shapes::icosphere(2), shapes::cuboid([1.0; 3], 3)] {
            let (_, end, output) = collapse_to(&shape, 1);
            assert!(end != CollapseEnd::Reached && output.positions.len() <= 8, "{end:?}");
        }
    }

    #[test]
    fn every_vertex_knows_its_output_vertex() {
        let mesh = shapes::torus(24, 10, 1.0, 0.3);
        let (_, _, output) = collapse_to(&mesh, 50);
        assert_eq!(output.vertex_of.len(), mesh.positions().len());
        let mut used = vec![false; 50];
        output.vertex_of.iter().for_each(|&v| used[v as usize] = true);
        assert_eq!(used, [true; 50]);
        assert_eq!(output.faces().len(), 100);
    }

    fn error(surface: &PreparedSurface, collapse: &Collapse) -> f64 {
        let output = collapse.output();
        let tree = output.tree();
        surface.positions.iter().map(|p| tree.nearest(p.as_dvec3()).map_or(f64::INFINITY, |hit| hit.distance2)).sum()
    }

    fn naive_run(collapse: &mut Collapse, vertices: usize) {
        while collapse.n_vertices > vertices {
            collapse.begin_pass();
            let list_edges = |u: u32| collapse.edges_at(u).into_iter().map(move |(price, edge)| (price, u, edge));
            let mut edges: Vec<(f32, u32, u32)> = collapse.remaining().flat_map(list_edges).collect();
            edges.sort_by(|x, y| x.0.total_cmp(&y.0));
            assert!(edges.iter().any(|&(_, u, edge)| collapse.try_merge(u, edge)));
        }
    }

    #[test]
    fn passes_are_nearly_as_good_as_pricing_all_edges_each_time() {
        for mesh in [shapes::wavy_sphere(3, 10.0), shapes::open_cylinder(20, 12)] {
            let ((surface, mut in_passes), mut naive) = (begin(&mesh), begin(&mesh).1);
            in_passes.run(Limit::from_vertices(60));
            naive_run(&mut naive, 60);
            let (in_passes, naive) = (error(&surface, &in_passes), error(&surface, &naive));
            assert!(in_passes < 1.6 * naive + 1e-12, "{in_passes} {naive}");
        }
    }

    #[test]
    fn every_vertex_knows_its_cheapest_edge() {
        for mesh in [shapes::wavy_sphere(4, 10.0), shapes::open_cylinder(40, 30)] {
            let (_, mut collapse) = begin(&mesh);
            for vertices in [mesh.positions().len(), 1000, 990, 985, 400] {
                collapse.run(Limit::from_vertices(vertices));
                collapse.begin_pass();
                for u in collapse.remaining() {
                    let least = collapse.edges_at(u).first().map_or(f32::INFINITY, |edge| edge.0);
                    let known = collapse.cheapest[u as usize].price();
                    assert!((known - least).abs() <= 1e-3 * least + 1e-10, "{vertices} {u}: {known} {least}");
                }
            }
        }
    }

    #[test]
    fn cheapest_edges_do_not_depend_on_the_number_of_threads() {
        let mesh = shapes::wavy_sphere(6, 10.0);
        let cheapest = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let (_, mut collapse) = begin(&mesh);
                collapse.run(Limit::from_vertices(30_000));
                collapse.begin_pass();
                collapse.cheapest.iter().map(|edge| edge.0).collect::<Vec<u64>>()
            })
        };
        assert!(cheapest(1) == cheapest(3));
    }

    fn charted_torus() -> (TriMesh, Vec<FeatureEdge>) {
        let mesh = shapes::torus(60, 30, 2.0, 0.5);
        let chart = |face: &[u32; 3]| {
            let centre = face.iter().map(|&v| Vec3::from(mesh.positions()[v as usize])).sum::<Vec3>();
            centre.to_array().map(|x| (1.5 * x).floor()).iter().fold(0.0, |number, x| 7.0 * number + x)
        };
        let uv = |face: &[u32; 3], v: u32| {
            let [x, y, z] = mesh.positions()[v as usize];
            [0.1 * (x + z) + chart(face), 0.1 * (y - z)]
        };
        let values = mesh.faces().iter().flat_map(|face| face.map(|v| uv(face, v))).flatten().collect();
        let channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
        let wedges = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let attributes = Attributes { groups: Vec::new(), wedges, channels };
        let edges = seams(&mesh, &attributes, 16.0 / 1024.0);
        (mesh, edges)
    }

    #[test]
    fn known_prices_are_those_of_merges_at_charts() {
        let (mesh, edges) = charted_torus();
        let options = ClosedOptions::default();
        let request = ClosedRequest::new(Task::new(Input::bare(&mesh), &options));
        let original = prepare(&ClosedRequest { edges, ..request }, Pulse::NONE);
        for vertices in [400, 150, 60] {
            let collapse = Collapse::new(Pulse::NONE, &original.surface);
            let constraints = Some(Constraints::new(&original));
            let mut collapse =
                collapse.with_constraints(constraints, AttributeQuadrics::default(), Poses::default(), None);
            assert_eq!(collapse.run(Limit::from_vertices(vertices)), CollapseEnd::Reached);
            collapse.begin_pass();
            for u in collapse.remaining() {
                let pass_prices = collapse.edges_at(u).first().map_or(f32::INFINITY, |edge| edge.0);
                let known = collapse.cheapest[u as usize].price();
                assert!(
                    known == pass_prices || (known - pass_prices).abs() <= 1e-3 * pass_prices,
                    "{vertices} {u}: {known} {pass_prices}"
                );
            }
        }
    }

    fn fan(n: u32, is_closed: bool) -> TriMesh {
        let turn = std::f32::consts::TAU * if is_closed { 1.0 } else { 0.9 };
        let rim = |i: u32| {
            let angle = turn * i as f32 / n as f32;
            [angle.cos(), angle.sin(), 0.1 * (7.0 * angle).sin()]
        };
        let n_rim = if is_closed { n } else { n + 1 };
        let positions = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]].into_iter().chain((0..n_rim).map(rim));
        let next = |i: u32| 2 + (i + 1) % n_rim;
        let above = (0..n).map(|i| [0, 2 + i, next(i)]);
        let below = (0..n).filter(|_| is_closed).map(|i| [1, next(i), 2 + i]);
        let positions: Vec<[f32; 3]> = positions.collect();
        compact(&positions, above.chain(below).collect()).unwrap().0
    }

    #[test]
    fn a_vertex_with_very_many_neighbours_stays_and_the_rest_is_collapsed() {
        for (n, is_closed) in [(5000, false), (5000, true), (70_000, false)] {
            let mesh = fan(n, is_closed);
            let (_, end, output) = collapse_to(&mesh, mesh.positions().len() / 10);
            assert_eq!((end, output.positions.len()), (CollapseEnd::Reached, mesh.positions().len() / 10));
            let faces = output.faces().to_vec();
            let lighter = TriMesh::new(output.positions.iter().map(|p| p.to_array()).collect(), faces).unwrap();
            let (before, after) = (topology(&mesh), topology(&lighter));
            assert_eq!(after.non_manifold_edges + after.non_manifold_vertices + after.unreferenced_vertices, 0);
            assert_eq!((after.euler, after.components), (before.euler, before.components));
            assert_eq!((after.boundary_loops, after.inconsistent_edges), (before.boundary_loops, 0));
        }
    }

    #[test]
    fn output_vertices_are_near_and_topology_stays_on_any_surface() {
        for mesh in [shapes::torus(60, 40, 1.0, 0.4), shapes::open_cylinder(60, 40), shapes::klein_bottle(60, 40)] {
            let (surface, _, output) = collapse_to(&mesh, mesh.positions().len() / 5);
            let far = surface.positions.iter().zip(&output.vertex_of);
            let farthest = far.map(|(p, &v)| p.distance(output.positions[v as usize])).fold(0.0, f32::max);
            assert!(farthest < 0.2, "{farthest}");
            let faces = output.faces().to_vec();
            let lighter = TriMesh::new(output.positions.iter().map(|p| p.to_array()).collect(), faces).unwrap();
            let (before, after) = (topology(&mesh), topology(&lighter));
            assert_eq!(after.non_manifold_edges + after.non_manifold_vertices + after.unreferenced_vertices, 0);
            assert_eq!((after.euler, after.components), (before.euler, before.components));
            assert_eq!((after.boundary_loops, after.orientable), (before.boundary_loops, before.orientable));
        }
    }
}
