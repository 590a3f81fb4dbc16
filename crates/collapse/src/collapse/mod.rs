//! Edge collapse of plain triangle meshes: [`collapse`] takes positions and faces, and returns fewer of both.
//!
//! The method is that of Garland and Heckbert (Surface Simplification Using Quadric Error Metrics, 1997) with quadrics of
//! the present faces without memory and placements toward the kept volume (Lindstrom and Turk, Evaluation of Memoryless
//! Simplification, 1999), in passes that merge many edges each. Quadrics count more where the surface bends.
//!
//! - The mesh is its one-rings and nothing else (`rings`): no faces, no corners.
//! - A pass (`passes`) sums a quadric per vertex (`quadric`), prices every edge once (`price`), chooses up to which price
//!   vertices are visited (`selection`, `threshold`), merges (`rounds`, `visit`, `merge`, `boundary`) and writes new
//!   rings (`rebuild`).
//! - At the end vertices may move nearer to the input (`fit`), without a search: the [`CollapseRecord`] tells what became what.
//!
//! A manifold stays manifold, what is closed stays closed, and no face turns by more than 60 degrees in a merge.
//! Results have the same bits on any number of threads and with any instruction set: no operation is fused, and all
//! sums have one order.

mod attributes;
mod boundary;
mod build;
mod curve;
mod cut;
mod fit;
mod frame;
mod guard;
mod lanes;
mod merge;
mod merges;
mod options;
mod passes;
mod placement;
mod prepare;
mod price;
mod quadric;
mod rebuild;
mod record;
mod rings;
mod roots;
mod rounds;
mod samples;
mod selection;
mod sides;
mod stretch;
mod team;
#[cfg(test)]
pub(crate) mod tests;
mod threshold;
mod vector;
mod visit;
mod wedges;

pub use merges::{MergePlace, PassMerge, StartRing};
pub use options::{
    CollapseError, CollapseOptions, CollapseOutcome, CollapseSize, CollapseTurn, Heartbeat, PassListener,
};
pub use placement::VOLUME_SHARE;
pub use quadric::{BOUNDARY_WEIGHT, LEAST_BENDING, PULL};
pub use record::CollapseRecord;

use attributes::WedgeAttributes;
use build::is_face;
use fit::FitInput;
pub(crate) use frame::bounding_box;
use passes::{Collapsed, largest_error, measure_size, run_passes};
use prepare::Prepared;
use rings::Vertex;
pub(crate) use roots::find_root;
use selection::SizeGoal;
use sides::SideArrays;
use team::Team;
use visit::Unit;
pub(crate) use wedges::{SidesInput, WedgeFace};

/// Ratio of the sizes at which the mesh is kept on the way to a size.
const KEPT_STEP: usize = 2;
/// Least size of the mesh, over that of a kept one.
// A larger part of the mesh would cost more memory than it saves time.
const LARGEST_KEPT: usize = 5;

/// A simplified mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CollapseResult {
    /// Positions of the vertices, in the input's units.
    pub positions: Vec<[f32; 3]>,
    /// Faces by vertices of the result, with the direction of the input.
    pub faces: Vec<[u32; 3]>,
    /// For each vertex of the result one of the input's that became it; at its place, if vertices did not move.
    pub origins: Vec<u32>,
    /// Which input vertices became which vertex of the result.
    pub record: CollapseRecord,
    /// Estimate of the largest distance between result and input, in the input's units: sums of the distances that
    /// merges moved the surface by. No bound; the fit is not in it.
    pub error: f32,
    /// Estimate of that distance at each vertex of the result.
    pub errors: Vec<f32>,
    /// For each pass that merged, the number of vertices left and the price up to which it merged.
    ///
    /// A price is an area times a squared distance from its planes, as the mean over all importances, in the input's units.
    pub pass_prices: Vec<(usize, f64)>,
    /// For each such pass the number of vertices left, and the largest of the errors then.
    pub pass_errors: Vec<(usize, f64)>,
    /// Whether the size was reached.
    pub outcome: CollapseOutcome,
}

/// Simplifies a mesh to a size.
///
/// With `cuts` vertices that are no disk are cut into copies, which keep their position. Faces that use a vertex twice are left out.
///
/// # Shapes
/// `positions`: one point per vertex, in any unit; `faces`: three vertices each.
///
/// # Errors
/// Refuses indices out of range, coordinates that are not finite, meshes of more than 2^31 vertices, and, without
/// `cuts`, meshes that are no manifold.
///
/// # Examples
/// ```
/// use neural_mesh_collapse::{CollapseOptions, CollapseOutcome, CollapseSize, collapse};
///
/// // A strip of ten squares.
/// let positions: Vec<[f32; 3]> = (0..22).map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
/// let faces: Vec<[u32; 3]> = (0..10).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]]).collect();
/// let result = collapse(&positions, &faces, CollapseSize::Faces(4), &CollapseOptions::default()).unwrap();
/// assert_eq!((result.faces.len(), result.outcome), (4, CollapseOutcome::Reached));
/// ```
pub fn collapse(
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    size: CollapseSize,
    options: &CollapseOptions,
) -> Result<CollapseResult, CollapseError> {
    let mut run = Run::new(positions, faces, options)?;
    run.go_to(size, None);
    Ok(run.finish(positions, faces))
}

/// Simplifies a mesh to several sizes in one run: each result is where the next one goes on.
///
/// `receive` gets each result and chooses the next size, if any. The first result is that of [`collapse()`], and a size
/// that is not below the one before is met at once. With `keeps_way` each result begins where the way to the first size was
/// at least twice as large, or once more.
///
/// # Errors
/// As [`collapse()`].
pub fn collapse_in_turn(
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    first: CollapseTurn,
    options: &CollapseOptions,
    mut receive: impl FnMut(CollapseResult) -> Option<CollapseTurn>,
) -> Result<(), CollapseError> {
    // Meshes to go on from, the smallest last: on the way to the first size, or the last result.
    let mut kept: Vec<Run> = Vec::new();
    let mut next = Some(first);
    while let Some(CollapseTurn { size, is_last, keeps_way }) = next {
        let begun = match keeps_way {
            true => kept.iter().rev().find(|run| run.is_far_above(size)).cloned(),
            false => kept.pop(),
        };
        let mut run = begun.map_or_else(|| Run::new(positions, faces, options), Ok)?;
        if keeps_way && kept.is_empty() {
            run.keep_way(size, &mut kept);
        }
        run.go_to(size, None);
        if !keeps_way && !is_last {
            kept.push(run.clone());
        }
        next = receive(run.finish(positions, faces));
    }
    Ok(())
}

/// The faces that are left of a mesh, by wedges.
pub(crate) struct WedgeResult {
    /// Positions of the vertices that the faces name.
    pub positions: Vec<[f32; 3]>,
    /// In the order of the input.
    pub faces: Vec<WedgeFace>,
    pub attributes: Option<WedgeAttributes>,
    /// As of a [`CollapseResult`].
    pub error: f32,
}

/// Simplifies as [`collapse`] without a fit, and returns the faces of the input that are left, by wedges.
pub(crate) fn collapse_by_wedges(
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    size: CollapseSize,
    options: &CollapseOptions,
    sides: SidesInput,
) -> Result<WedgeResult, CollapseError> {
    // Where each vertex is its only wedge, the record tells at the end what others follow from pass to pass.
    let followed = (sides.has_copies || sides.width > 0).then_some(sides);
    let mut run = Run::new(positions, faces, options)?;
    let mut sides = followed.map(|sides| run.prepared.make_sides(faces, sides));
    run.go_to(size, sides.as_mut());
    run.name_origins();
    let out = run.place_vertices(positions);
    let error = run.error();
    let (faces, attributes) = match sides {
        Some(SideArrays { wedges, attributes }) => (wedges.faces, attributes),
        None => (run.list_faces(faces), None),
    };
    Ok(WedgeResult { positions: out, faces, attributes, error })
}

/// A mesh after some merges, and how it came to be.
#[derive(Clone)]
struct Run<'a> {
    options: &'a CollapseOptions<'a>,
    team: Team<'a>,
    prepared: Prepared,
    collapsed: Collapsed,
}

impl<'a> Run<'a> {
    fn new(
        positions: &[[f32; 3]],
        faces: &[[u32; 3]],
        options: &'a CollapseOptions<'a>,
    ) -> Result<Run<'a>, CollapseError> {
        let team = Team::new(options.n_threads, options.heartbeat);
        let mut prepared = prepare::prepare(positions, faces, options, team)?;
        let collapsed = Collapsed::new(std::mem::take(&mut prepared.rings));
        Ok(Run { options, team, prepared, collapsed })
    }

    fn go_to(&mut self, size: CollapseSize, sides: Option<&mut SideArrays>) {
        let (unit, size) = size.to_unit_and_number();
        self.go_to_number(unit, [size; 2], sides);
    }

    // Merges toward a size, and ends after the pass that comes down to `pause`.
    fn go_to_number(&mut self, unit: Unit, [size, pause]: [usize; 2], sides: Option<&mut SideArrays>) {
        let CollapseOptions { moves, records_merges, listener, max_error, .. } = *self.options;
        let max_error = self.prepared.frame.to_unit_length(max_error);
        let goal = SizeGoal { unit, size, pause, max_error, moves, records_merges, listener };
        run_passes(&mut self.collapsed, goal, sides, self.team);
    }

    // Goes on toward a size and keeps the mesh after some passes.
    fn keep_way(&mut self, size: CollapseSize, kept: &mut Vec<Self>) {
        let (unit, size) = size.to_unit_and_number();
        loop {
            let n = measure_size(&self.collapsed.rings, unit);
            let first = if kept.is_empty() { LARGEST_KEPT } else { KEPT_STEP };
            if n / first <= size {
                return;
            }
            self.go_to_number(unit, [size, n / first], None);
            if measure_size(&self.collapsed.rings, unit) > n / first {
                return;
            }
            kept.push(self.clone());
        }
    }

    // Whether at least half of the vertices go on the way to a size, so that it hardly matters where the way led to.
    fn is_far_above(&self, size: CollapseSize) -> bool {
        let (unit, size) = size.to_unit_and_number();
        measure_size(&self.collapsed.rings, unit) / 2 >= size
    }

    // With the vertices fitted to the input, if that is asked for.
    fn finish(mut self, positions: &[[f32; 3]], faces: &[[u32; 3]]) -> CollapseResult {
        let CollapseOptions { moves, n_fit_steps, listener, .. } = *self.options;
        let fits = moves && n_fit_steps > 0 && !self.collapsed.numbers.is_empty();
        if fits && listener.is_none_or(|listener| listener(1.0).is_continue()) {
            let numbers = self.prepared.compose(&self.collapsed.numbers);
            let faces = self.prepared.cut_faces().unwrap_or(faces);
            let input = FitInput { faces, numbers: &numbers, farthest: self.collapsed.farthest };
            let position = |v: u32| self.prepared.unit_position(v, positions);
            fit::fit(&mut self.collapsed.rings, input, position, n_fit_steps, self.team);
        }
        self.assemble(positions)
    }

    // Positions of the vertices of the rings, in the input's units.
    fn place_vertices(&self, positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let frame = self.prepared.frame;
        let place = |(v, &origin): (&Vertex, &u32)| {
            let original = positions[origin as usize];
            // What has not moved keeps its bits.
            if frame.to_unit(original) == v.position { original } else { frame.to_input(v.position) }
        };
        self.collapsed.rings.vertices.iter().zip(&self.collapsed.origins).map(place).collect()
    }

    // Turns places along the curve into input vertices.
    fn name_origins(&mut self) {
        let names = self.prepared.list_origins();
        self.collapsed.origins.iter_mut().for_each(|rank| *rank = names[*rank as usize]);
        self.collapsed.merges.iter_mut().flatten().for_each(|merge| merge.rename(&names));
    }

    fn error(&self) -> f32 {
        self.prepared.frame.to_input_length(largest_error(&self.collapsed.rings))
    }

    // The faces of the input whose corners are still apart, each corner by what it came from.
    fn list_faces(&self, faces: &[[u32; 3]]) -> Vec<WedgeFace> {
        let numbers = self.prepared.compose(&self.collapsed.numbers);
        let faces = self.prepared.cut_faces().unwrap_or(faces);
        let list = (0..).zip(faces).filter_map(|(source, face)| {
            let vertices = face.map(|v| numbers[v as usize]);
            let wedges = || vertices.map(|v| self.collapsed.origins[v as usize]);
            is_face(&vertices).then(|| WedgeFace { vertices, wedges: wedges(), source })
        });
        list.collect()
    }

    // With one vertex for copies that are joined again.
    fn assemble(mut self, positions: &[[f32; 3]]) -> CollapseResult {
        self.name_origins();
        let (mut out, error) = (self.place_vertices(positions), self.error());
        let Run { mut prepared, collapsed, .. } = self;
        let Collapsed { rings, numbers, mut origins, is_reached, pass_prices, pass_errors, merges, .. } = collapsed;
        let mut record = prepared.take_record(numbers, merges, positions.len());
        let mut faces = rings.to_faces();
        let mut errors: Vec<f32> = rings.errors.iter().map(|&error| prepared.frame.to_input_length(error)).collect();
        prepared.join_copies(&mut faces, (&mut out, &mut origins, &mut errors), &mut record);
        let outcome = if is_reached { CollapseOutcome::Reached } else { CollapseOutcome::Stopped };
        let to_input = |(n, price): (usize, f32)| (n, f64::from(price) * prepared.frame.unit_of_prices());
        let to_input_error =
            |(&(n, _), error): (&(usize, f32), f32)| (n, f64::from(prepared.frame.to_input_length(error)));
        let pass_errors = pass_prices.iter().zip(pass_errors).map(to_input_error).collect();
        let pass_prices = pass_prices.into_iter().map(to_input).collect();
        CollapseResult { positions: out, faces, origins, record, error, errors, pass_prices, pass_errors, outcome }
    }
}
