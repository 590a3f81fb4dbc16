//! Edge collapse by quadrics (Garland and Heckbert 1997), memoryless ones, down to a target, on a closed complex.
//!
//! Boundaries are closed by ghost vertices that never move, so the link condition of closed surfaces (Dey et al. 1999)
//! is all that keeps the topology: the ends of an edge share exactly the two vertices opposite to it. In which order edges go
//! is said in `rounds`.
//!
//! What is read most lies closest together: a vertex with its quadric fills one cache line, the complex is the ordered
//! neighbours of its vertices alone, and faces are made of them at the end. Large complexes are first collapsed in blocks
//! (`blocks`), side by side and each within the cache.

mod at_height;
mod attribute_quadrics;
mod blocks;
mod complex;
mod constraints;
mod copy;
mod half;
mod history;
mod hubs;
mod links;
mod memoryless;
mod merge;
mod pair;
mod poses;
mod rounds;
mod shape;

pub use attribute_quadrics::of_attributes;
pub use complex::{Collapse, End, merges_to};
pub use constraints::Constraints;
pub use history::{Event, Renewal, first_quadrics};
pub use pair::Place;
pub use poses::Poses;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle::nearest_point;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{Attributes, Channel, KeptEdge, Role, TriMesh, seams, shapes};
    use crate::simplify::closed::Keep;
    use crate::simplify::closed::cluster::assignment::Assignment;
    use crate::simplify::closed::cluster::placement::{Placement, Places};
    use crate::simplify::closed::output::Output;
    use crate::simplify::closed::prepare::prepare;
    use crate::simplify::closed::prepare::surface::Surface;
    use crate::simplify::limits::Limit;
    use attribute_quadrics::AttributeQuadrics;
    use glam::Vec3;

    /// Vertices over those asked for where the last stretch begins.
    const LAST_STRETCH: f64 = 1.1;

    fn begin(mesh: &TriMesh) -> (Surface<'_>, Collapse<'static>) {
        let surface = Surface::new(mesh, Pulse::NONE);
        let placed = Placement::new(&surface, Places::default(), &[]);
        let collapse = Collapse::new(Pulse::NONE, &placed, &surface.rings);
        (surface, collapse)
    }

    fn down_to(mesh: &TriMesh, vertices: usize) -> (Surface<'_>, End, Output) {
        let (surface, mut collapse) = begin(mesh);
        let end = collapse.run(Limit::of_vertices(vertices), LAST_STRETCH);
        let output = collapse.output(&Assignment::identity(surface.n_vertices()));
        (surface, end, output)
    }

    fn assert_corners_stay(mesh: &TriMesh, corners: &[[f32; 3]]) {
        let (surface, end, output) = down_to(mesh, corners.len());
        assert_eq!((end, output.positions.len()), (End::Reached, corners.len()));
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
            let (_, end, output) = down_to(shape, 1);
            assert_eq!((end, output.faces().len()), (End::Smallest, shape.faces().len()));
        }
        for shape in [shapes::icosphere(2), shapes::cuboid([1.0; 3], 3)] {
            let (_, end, output) = down_to(&shape, 1);
            assert!(end != End::Reached && output.positions.len() <= 8, "{end:?}");
        }
    }

    #[test]
    fn every_vertex_is_told_what_became_of_it() {
        let mesh = shapes::torus(24, 10, 1.0, 0.3);
        let (_, _, output) = down_to(&mesh, 50);
        assert_eq!(output.vertex_of.len(), mesh.positions().len());
        let mut used = vec![false; 50];
        output.vertex_of.iter().for_each(|&v| used[v as usize] = true);
        assert_eq!(used, [true; 50]);
        assert_eq!(output.faces().len(), 100);
    }

    /// Sum of the squared distances of the surface's vertices from the faces around what they became.
    pub fn error(surface: &Surface, collapse: &Collapse) -> f64 {
        let output = collapse.output(&Assignment::identity(surface.n_vertices()));
        let distance = |(&p, &v): (&Vec3, &u32)| {
            let faces = output.around().faces(v).map(|f| nearest_point(p, output.triangle(f)).distance_squared(p));
            f64::from(faces.fold(f32::INFINITY, f32::min))
        };
        surface.positions.iter().zip(&output.vertex_of).map(distance).sum()
    }

    /// Always the cheapest edge that may go, all edges priced anew each time, on the last stretch by quadrics summed anew.
    fn naive_run(collapse: &mut Collapse, vertices: usize) {
        let stretch = Limit::of_vertices(vertices).times(LAST_STRETCH);
        while collapse.n_vertices > vertices {
            if collapse.n_vertices <= stretch.vertices {
                collapse.renew_all();
            }
            collapse.unpriced = None;
            collapse.price();
            let price = |&[u, v]: &[u32; 2]| collapse.pair(u, v).placement().price;
            let of = |u: u32| collapse.ring(u).filter(move |&v| v > u).map(move |v| [u, v]);
            let mut edges: Vec<[u32; 2]> =
                collapse.living().flat_map(of).filter(|&[_, v]| !collapse.is_ghost(v)).collect();
            edges.sort_by(|x, y| price(x).total_cmp(&price(y)));
            assert!(edges.iter().any(|&[u, v]| collapse.try_collapse(u, v)));
        }
    }

    #[test]
    fn rounds_are_as_good_as_pricing_all_edges_each_time() {
        for mesh in [shapes::wavy_sphere(3, 10.0), shapes::open_cylinder(20, 12)] {
            let ((surface, mut in_rounds), mut naive) = (begin(&mesh), begin(&mesh).1);
            in_rounds.run(Limit::of_vertices(60), LAST_STRETCH);
            naive_run(&mut naive, 60);
            let (in_rounds, naive) = (error(&surface, &in_rounds), error(&surface, &naive));
            assert!(in_rounds < 1.4 * naive + 1e-12, "{in_rounds} {naive}");
        }
    }

    /// A torus in small charts, whose seams have a price.
    fn charted() -> (TriMesh, Vec<KeptEdge>) {
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
    fn prices_that_are_known_are_those_that_would_be_paid_where_charts_go() {
        let (mesh, edges) = charted();
        let original = prepare(&mesh, &Keep { edges: &edges, ..Keep::default() }, Pulse::NONE);
        let placed = Placement::new(&original.surface, Places::default(), &[]);
        for vertices in [400, 150, 60] {
            let own: Vec<u32> = (0..original.surface.n_vertices() as u32).collect();
            let constraints = Constraints::new(&original, &own, own.clone());
            let collapse = Collapse::new(Pulse::NONE, &placed, &original.surface.rings);
            let mut collapse = collapse.under(Some(constraints), AttributeQuadrics::default(), Poses::default(), None);
            assert_eq!(collapse.run(Limit::of_vertices(vertices), LAST_STRETCH), End::Reached);
            for u in collapse.living() {
                let ring = collapse.nodes[u as usize].ring;
                for (i, block) in ring.blocks().enumerate() {
                    let known = collapse.links.block(block).iter().zip(collapse.links.prices(block));
                    for (&v, &price) in known.take(ring.len() - i * links::WIDTH) {
                        let paid = collapse.constrained_price(u, v);
                        assert!(
                            price == paid || (price - paid).abs() <= 1e-3 * price,
                            "{vertices} {u} {v}: {price} {paid}"
                        );
                    }
                }
            }
        }
    }
}
