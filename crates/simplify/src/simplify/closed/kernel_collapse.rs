//! The collapse of bare meshes, by the crate `neural_mesh_collapse`.
//!
//! A result is what the collapse of this assembly hands to the refinement: a manifold with the topology of the surface
//! and at most one merge below the size. Where it cannot reach a size, the request goes to the collapse of this assembly,
//! which also knows what gives way first.

use neural_mesh_collapse::{
    CollapseOptions, CollapseOutcome, CollapseResult, CollapseSize, CollapseTurn, Heartbeat, collapse_in_turn,
};

use crate::mesh::pulse::Pulse;
use crate::simplify::limits::Limit;
use crate::simplify::options::{Optimize, Purpose};

use super::collapse::CollapseEvent;
use super::level_queue::NextLevel;
use super::original::Original;
use super::output::Output;
use super::pins::Pins;
use super::request::{ClosedRequest, Importance, Task};

/// Least number of vertices of a result; below, one merge a pass places corners exactly.
const LEAST_VERTICES: usize = 64;
/// Vertices of the result per locked vertex of the input, below which the distance would have to be checked.
const LOCKED_ONE_IN: usize = 2;

/// Returns whether the kernel knows all that a request asks for.
pub fn is_kernel_enough(request: &ClosedRequest, limit: Limit) -> bool {
    let Task { input, options, .. } = request.task;
    let is_free = request.edges.is_empty() && input.kept.is_empty();
    let is_bare = is_free && !request.task.is_asset();
    // Blocks of large meshes hold their shape; a price is one of this assembly.
    let is_size = request.price.is_none() && options.hold_shape.is_none();
    // The kernel has one importance, that of bending.
    let is_usual = matches!(request.importance, Importance::Bending)
        && options.optimize == Optimize::Balanced
        && options.purpose == Purpose::Shape;
    let n_locked = request.locked.iter().filter(|&&is_locked| is_locked).count();
    let has_room = limit.size() >= LEAST_VERTICES && n_locked * LOCKED_ONE_IN < limit.size();
    is_bare && is_size && is_usual && has_room && !limit.is_met_by(input.mesh)
}

/// A surface at its size.
pub struct KernelCollapse {
    pub output: Output,
    /// The merges of each pass, if they were asked for.
    pub history: Vec<CollapseEvent>,
    /// Vertices left by each pass that merged some, and its highest price, at unit size.
    pub pass_prices: Vec<(usize, f32)>,
}

/// First size of the kernel, and options for all sizes.
pub struct KernelTurns {
    pub first: NextLevel,
    /// True if a size may be larger than the one before.
    pub keeps_way: bool,
    pub records_merges: bool,
}

/// Collapses a surface to limits in turn; ends before a size that is out of reach, at once if the surface is one-sided.
///
/// `receive` gets each result before the collapse goes on, and chooses the next size.
pub fn collapse_by_kernel(
    original: &Original,
    KernelTurns { first, keeps_way, records_merges }: KernelTurns,
    pulse: Pulse,
    mut receive: impl FnMut(CollapseResult) -> Option<NextLevel>,
) {
    let Original { surface, pins, .. } = original;
    let positions: Vec<[f32; 3]> = pulse.counting_if(false).map(&surface.positions, |p| p.to_array());
    let n_vertices = positions.len();
    let locked: Vec<bool> =
        if pins.is_binding() { (0..n_vertices as u32).map(|v| pins.is_locked(v)).collect() } else { Vec::new() };
    let beat = |n_merges: usize| pulse.beat(n_merges);
    let mut options = CollapseOptions::default();
    (options.moves, options.locked, options.n_threads) = (!pins.is_subset(), &locked, 0);
    options.records_merges = records_merges;
    // Only one-sided surfaces would have to be cut: all others come as manifolds.
    (options.heartbeat, options.cuts) = (Heartbeat::new(&beat), false);
    let to_turn =
        |next: NextLevel| CollapseTurn { size: to_collapse_size(next.limit), is_last: next.is_last, keeps_way };
    let mut is_estimate = first.is_estimate;
    let receive = |result: CollapseResult| {
        let next = (is_estimate || result.outcome == CollapseOutcome::Reached).then(|| receive(result)).flatten()?;
        is_estimate = next.is_estimate;
        Some(to_turn(next))
    };
    // What the kernel refuses has no results.
    _ = collapse_in_turn(&positions, &surface.faces, to_turn(first), &options, receive);
}

fn to_collapse_size(limit: Limit) -> CollapseSize {
    match limit.faces {
        usize::MAX => CollapseSize::Vertices(limit.vertices),
        n_faces => CollapseSize::Faces(n_faces),
    }
}

impl KernelCollapse {
    pub fn new(result: CollapseResult, original: &Original) -> Self {
        let Original { surface, pins, .. } = original;
        let (n_vertices, pulse) = (surface.n_vertices(), surface.pulse);
        let n_passes = result.record.n_passes();
        let vertex_of = result.record.vertices_after(n_passes);
        let merges = (0..n_passes).map(|pass| result.record.merges(pass)).filter(|merges| !merges.is_empty());
        let history = merges.map(|merges| CollapseEvent::Pass(merges.to_vec())).collect();
        // A result vertex takes the pin of the input vertex at its place.
        let pins = if pins.is_empty() {
            Pins::default()
        } else {
            pins.with_surface_origins(n_vertices).select(&result.origins)
        };
        let positions = result.positions.into_iter().map(Into::into).collect();
        let output = Output::new(pulse.counting_if(false), positions, result.faces, pins, vertex_of);
        let output = output.with_distances(result.errors);
        let pass_prices = result.pass_prices.into_iter().map(|(n, price)| (n, price as f32)).collect();
        Self { output, history, pass_prices }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes, topology};
    use crate::simplify::closed::prepare::prepare_bare;
    use crate::simplify::input::Input;
    use crate::simplify::options::{ClosedOptions, Effort, Options, ScoreSource};
    use crate::simplify::simplify;
    use crate::simplify::size::Size;

    fn fast() -> ClosedOptions {
        ClosedOptions { effort: Effort::Fast, ..ClosedOptions::default() }
    }

    fn collapse<'a>(input: impl Into<Input<'a>>, limits: &[Limit]) -> Vec<KernelCollapse> {
        let options = fast();
        let original = prepare_bare(&ClosedRequest::new(Task::new(input.into(), &options)), Pulse::NONE);
        let mut levels = Vec::new();
        let next = |i: usize| {
            limits.get(i).map(|&limit| NextLevel { limit, is_last: i + 1 == limits.len(), is_estimate: false })
        };
        let turns = KernelTurns { first: next(0).unwrap(), keeps_way: false, records_merges: false };
        collapse_by_kernel(&original, turns, Pulse::NONE, |result| {
            levels.push(KernelCollapse::new(result, &original));
            next(levels.len())
        });
        levels
    }

    #[test]
    fn it_reaches_its_size_with_the_topology_of_the_surface() {
        let closed = [shapes::wavy_sphere(4, 8.0), shapes::torus(60, 40, 1.0, 0.4), shapes::chain_of_tori(3)];
        for mesh in closed.into_iter().chain([shapes::open_cylinder(60, 40), shapes::grid(40, 40)]) {
            let n = mesh.positions().len() / 5;
            for limit in [Limit::from_vertices(n), Limit { faces: 2 * n, ..Limit::from_vertices(usize::MAX) }] {
                let levels = collapse(&mesh, &[limit]);
                let [KernelCollapse { output, pass_prices, .. }] = levels.try_into().ok().unwrap();
                let (n_vertices, n_faces) = (output.positions.len(), output.faces().len());
                let is_size = n_vertices == limit.vertices || n_faces == limit.faces || n_faces + 1 == limit.faces;
                assert!(is_size, "{n_vertices} {n_faces}");
                assert!(pass_prices.is_sorted_by(|a, b| a.0 > b.0) && pass_prices.last().unwrap().0 == n_vertices);
                let lighter =
                    TriMesh::new(output.positions.iter().map(|p| p.to_array()).collect(), output.faces().to_vec());
                let (before, after) = (topology(&mesh), topology(&lighter.unwrap()));
                assert_eq!(after.non_manifold_edges + after.non_manifold_vertices + after.unreferenced_vertices, 0);
                assert_eq!((after.euler, after.components), (before.euler, before.components));
                assert_eq!((after.boundary_loops, after.inconsistent_edges), (before.boundary_loops, 0));
            }
        }
    }

    #[test]
    fn every_vertex_knows_what_it_became() {
        let mesh = shapes::torus(60, 40, 1.0, 0.4);
        let levels = collapse(&mesh, &[960, 480].map(Limit::from_vertices));
        let output = &levels[1].output;
        assert_eq!(levels[0].output.positions.len(), 960);
        let original = Original::bare(&mesh);
        let far = original.surface.positions.iter().zip(&output.vertex_of);
        let farthest = far.map(|(p, &v)| p.distance(output.positions[v as usize])).fold(0.0, f32::max);
        assert!(farthest < 0.2, "{farthest}");
        let mut is_used = [false; 480];
        output.vertex_of.iter().for_each(|&v| is_used[v as usize] = true);
        assert_eq!(is_used, [true; 480]);
    }

    #[test]
    fn what_is_out_of_its_reach_is_left_to_the_other_collapse() {
        let mesh = shapes::klein_bottle(60, 40);
        let size = [Limit::from_vertices(480)];
        assert!(collapse(&mesh, &size).is_empty());
        let mesh = shapes::icosphere(3);
        let locked = vec![true; mesh.positions().len()];
        assert!(collapse(Input { locked: &locked, ..Input::bare(&mesh) }, &size).is_empty());
    }

    #[test]
    fn only_bare_meshes_in_the_usual_way_go_to_the_kernel() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let is_enough = |options: &ClosedOptions, n_vertices: usize| {
            let request = ClosedRequest::new(Task::new(Input::bare(&mesh), options));
            is_kernel_enough(&request, Limit::from_vertices(n_vertices))
        };
        let others = [
            ClosedOptions { optimize: Optimize::Normals, ..fast() },
            ClosedOptions { scores: ScoreSource::Geometry, ..fast() },
            ClosedOptions { purpose: Purpose::Poses, ..fast() },
            ClosedOptions { crease_angle: Some(5.0), ..fast() },
            ClosedOptions { hold_shape: Some(0.01), ..fast() },
        ];
        for options in others {
            assert!(!is_enough(&options, 300), "{options:?}");
        }
        let alike = [
            fast(),
            ClosedOptions::default(),
            ClosedOptions { effort: Effort::Best, ..fast() },
            ClosedOptions { subset: true, ..fast() },
            ClosedOptions { map: true, ..fast() },
        ];
        for options in alike {
            assert!(is_enough(&options, 300) && !is_enough(&options, 30), "{options:?}");
        }
        assert!(!is_enough(&fast(), mesh.positions().len()));
    }

    #[test]
    fn locked_boundaries_and_subsets_keep_every_bit() {
        let mesh = shapes::grid(40, 40);
        let run = |options: ClosedOptions| {
            let options = Options::with_closed(Size::Vertices(600), options);
            simplify(&mesh, &options, &mut |_| std::ops::ControlFlow::Continue(())).unwrap().mesh
        };
        let locked = run(ClosedOptions { lock_boundaries: true, ..fast() });
        assert_eq!(locked.positions().len(), 600);
        let is_on_rim = |p: &[f32; 3]| p[..2].iter().any(|x| *x == 0.0 || *x == 1.0);
        for p in mesh.positions().iter().filter(|p| is_on_rim(p)) {
            assert!(locked.positions().contains(p), "{p:?}");
        }
        let subset = run(ClosedOptions { subset: true, ..fast() });
        assert!(subset.positions().len() == 600 && subset.positions().iter().all(|p| mesh.positions().contains(p)));
    }

    #[test]
    fn results_are_as_near_as_those_of_the_other_collapse() {
        let mesh = shapes::wavy_sphere(5, 10.0);
        let go_on = &mut |_| std::ops::ControlFlow::Continue(());
        // Shapes that are held are not for the kernel.
        let other = ClosedOptions { hold_shape: Some(1.0), ..fast() };
        let [kernel, other] = [fast(), other].map(|options| {
            let options = Options::with_closed(Size::Ratio(0.1), options);
            simplify(&mesh, &options, go_on).unwrap().mesh
        });
        assert_ne!(kernel, other);
        let distance = |result: &TriMesh| crate::metrics::quick_distance(&mesh, result, 10_000, 1).unwrap().mean;
        assert!(distance(&kernel) < 1.1 * distance(&other));
    }
}
