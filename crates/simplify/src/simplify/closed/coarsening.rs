//! Sizes below the one at which every component keeps its shape.
//!
//! Limits are lifted one after the other: ceilings rise, curves no longer hold their vertices, faces may turn. After each
//! step the collapse goes on. Components are dropped where a viewer loses less by that ([`super::visible_drops`]).

use crate::simplify::limits::Limit;

use super::collapse::{Collapse, CollapseEnd};
use super::collapse_base::CollapseBase;
use super::dropping::{DroppedFaces, vertex_components};
use super::output::Output;
use super::request::ClosedRequest;
use super::visible_drops::{DropChoice, Step, choose_by_views};

/// First ceiling in the scene, over its diagonal, and the ratio of neighbouring ones.
// Below the first one no component that has a ceiling keeps its own.
const FIRST_CEILING: f64 = 0.0025;
const CEILING_STEP: f64 = 1.3;
/// Ceiling, over the scene's diagonal, from which on curves no longer hold their vertices.
const LARGEST_WITH_CURVES: f64 = 0.01;
/// Least cosines between a face's normals before and after a merge, of the last steps.
const LEAST_COSINES: [f32; 2] = [-0.2, -0.7];

#[derive(Clone, Copy)]
enum Relaxation {
    Ceiling(f64),
    Curves,
    Turns(f32),
}

/// Lists all relaxations, in the order in which they are made.
fn list_relaxations(has_ceilings: bool) -> Vec<Relaxation> {
    let ceilings = std::iter::successors(Some(FIRST_CEILING), |ceiling| Some(ceiling * CEILING_STEP));
    let ceilings: Vec<f64> = ceilings.take_while(|ceiling| has_ceilings && *ceiling < 1.0).collect();
    let (low, high): (Vec<f64>, Vec<f64>) = ceilings.into_iter().partition(|ceiling| *ceiling <= LARGEST_WITH_CURVES);
    let without_limit = has_ceilings.then_some(f64::INFINITY);
    let raise = |ceilings: Vec<f64>| ceilings.into_iter().map(Relaxation::Ceiling);
    raise(low)
        .chain([Relaxation::Curves])
        .chain(raise(high))
        .chain(without_limit.map(Relaxation::Ceiling))
        .chain(LEAST_COSINES.map(Relaxation::Turns))
        .collect()
}

/// A collapse below the size at which every component keeps its shape.
pub struct Coarsening {
    pub end: CollapseEnd,
    /// `None` if steps are not recorded.
    components: Option<StartComponents>,
    pub steps: Vec<Step>,
}

/// Continues a collapse that ended above its limit by lifting limits until it is reached.
///
/// With `records_steps`, records the sizes of all components at the beginning and after each step.
pub fn coarsen(
    base: &CollapseBase,
    collapse: &mut Collapse,
    end: CollapseEnd,
    limit: Limit,
    records_steps: bool,
) -> Coarsening {
    let components = records_steps.then(|| StartComponents::new(base, collapse));
    let mut coarsening = Coarsening { end, components, steps: Vec::new() };
    let (mut ceiling, mut has_free_curves) = (0.0, false);
    coarsening.record(collapse, ceiling, has_free_curves);
    for relaxation in list_relaxations(collapse.has_ceilings()) {
        match relaxation {
            Relaxation::Ceiling(share) => {
                ceiling = share;
                if !collapse.raise_ceilings(share) {
                    continue;
                }
            }
            Relaxation::Curves if !collapse.soften_curves() => continue,
            Relaxation::Curves => has_free_curves = true,
            Relaxation::Turns(least_cosine) => collapse.allow_turns(least_cosine),
        }
        coarsening.end = collapse.run(limit);
        coarsening.record(collapse, ceiling, has_free_curves);
        if coarsening.end == CollapseEnd::Reached {
            break;
        }
    }
    coarsening
}

impl Coarsening {
    fn record(&mut self, collapse: &Collapse, ceiling: f64, has_free_curves: bool) {
        let sizes = |it: &StartComponents| collapse.count_by_component(&it.of_collapse_vertex, it.n);
        self.steps.extend(self.components.as_ref().map(|it| Step { ceiling, has_free_curves, sizes: sizes(it) }));
    }

    /// Chooses components to drop where a viewer loses less than by the steps; `None` if all stay.
    pub fn choose_dropped(
        &self,
        base: &CollapseBase,
        request: &ClosedRequest,
        output: &Output,
        limit: Limit,
    ) -> Option<DroppedFaces> {
        let (components, within) = (self.components.as_ref()?, request.task.drops_within()?);
        if components.n < 2 {
            return None;
        }
        let component = |face: &[u32; 3]| components.of_vertex[face[0] as usize];
        let component_of_face: Vec<u32> = base.original.surface.faces.iter().map(component).collect();
        let choice = DropChoice { component_of_face: &component_of_face, n: components.n, output, within };
        choose_by_views(&base.original, &choice, &self.steps, limit, &request.visual_properties())
    }
}

/// The components at the beginning, by which those of all steps are known.
struct StartComponents {
    /// Component of each vertex of the surface.
    of_vertex: Vec<u32>,
    /// Component of each vertex of the collapse, which also knows those that dropped components had.
    of_collapse_vertex: Vec<u32>,
    n: usize,
}

impl StartComponents {
    fn new(base: &CollapseBase, collapse: &Collapse) -> Self {
        let surface = &base.original.surface;
        let (mut of_vertex, n) = vertex_components(surface.n_vertices(), &surface.faces);
        of_vertex.resize(surface.n_vertices(), 0);
        let of_collapse_vertex = match base.collapse_vertices.len() {
            0 => of_vertex.clone(),
            _ => {
                let mut of_collapse_vertex = vec![0; collapse.n_surface_vertices()];
                let pairs = base.collapse_vertices.iter().zip(&of_vertex);
                pairs.for_each(|(&v, &component)| of_collapse_vertex[v as usize] = component);
                of_collapse_vertex
            }
        };
        Self { of_vertex, of_collapse_vertex, n }
    }
}
