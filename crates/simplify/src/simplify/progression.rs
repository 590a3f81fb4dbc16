//! Progressions: one collapse, from which a mesh of any size is made.

use crate::mesh::{Attributes, Frame, TriMesh, UnitedMesh};

use super::assemblies::{PlainInput, unchanged_result};
use super::closed::{
    ClosedRequest, CollapseEnd, LevelChoice, ProgressionSurface, RecordedCollapse, Task, VertexCost, is_sound,
    prices_by_size, record_collapse, vertex_components,
};
use super::components::prune;
use super::input::Input;
use super::limits::{Limit, resolve_limit_of};
use super::map::identity_map;
use super::network_scores::used_scores;
use super::options::{ClosedOptions, DroppedComponent, Listener, Report, ScoreSource, Simplified, SimplifyError};
use super::progress::{Progress, closed_stages, run_with_listener};
use super::size::Size;
use super::sub_mesh::{SubMesh, SubMeshOrigin};
use crate::mesh::pulse::Pulse;

/// Ratio of neighbouring sizes at which components to drop are chosen.
const DROP_STEP: f64 = 2.0;
/// Least share of the vertices of a smallest form that components dropped below it free together.
// Smaller steps would make as many drops as there are components, and levels are looked up through all drops.
const LEAST_FREED: f64 = 1.0 / 16.0;
/// Least size at which components to drop are chosen: that of a tetrahedron.
const LEAST_SIZE: usize = 4;
/// Share of the vertices for which the progress of making is estimated.
const USUAL_RATIO: f64 = 0.02;

/// All merges of one collapse, from which a mesh of any size is made without another one.
///
/// The vertices and faces of a level that is not refined are the first ones of every finer level.
pub struct Progression {
    pub(super) mesh: TriMesh,
    pub(super) attributes: Attributes,
    pub(super) kept: Vec<bool>,
    pub(super) locked: Vec<bool>,
    pub(super) scene: Option<UnitedMesh>,
    pub(super) options: ClosedOptions,
    pub(super) scores: ScoreSource,
    /// Number of kept edges that the report names.
    pub(super) n_kept_edges: usize,
    pub(super) end: CollapseEnd,
    /// Numbers of vertices and faces to which ratios refer: those before components were dropped in any case.
    pub(super) size: [usize; 2],
    /// Origins of the mesh: in the used vertices, and in the caller's mesh.
    pub(super) origins: [SubMeshOrigin; 2],
    pub(super) surface: ProgressionSurface,
    /// Component of each vertex of the surface; empty for a single one.
    pub(super) components: Vec<u32>,
    /// Components that smaller levels lack, largest size first.
    pub(super) drops: Vec<Drop>,
    /// Levels with a proved distance, largest size first; distances rise.
    pub(super) proofs: Vec<ProvedLevel>,
    /// Files from which the mesh was read, by name; the mesh file first. Empty if unknown.
    pub files: Vec<(String, Vec<u8>)>,
    /// True if the merges may be of any origin, so that levels are checked.
    pub(super) is_from_bytes: bool,
}

/// A level that is not refined, and its proved distance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ProvedLevel {
    /// Number of vertices.
    pub n_vertices: usize,
    /// Proved upper bound of the two-sided largest distance to the original, in mesh units or, of a scene, in its.
    pub distance: f64,
}

impl ProvedLevel {
    #[doc(hidden)]
    pub fn new(n_vertices: usize, distance: f64) -> Self {
        Self { n_vertices, distance }
    }
}

/// Components without which a level is made.
pub(super) struct Drop {
    /// Largest number of vertices of a level without the components.
    pub n_vertices: usize,
    pub components: Vec<u32>,
    pub dropped: Vec<DroppedComponent>,
}

/// A level's vertices in the sequence, and components that it lacks.
struct ProgressionLevel {
    n: usize,
    /// Marks dropped components; empty for none.
    is_dropped: Vec<bool>,
    drops: usize,
    is_reached: bool,
}

impl Progression {
    /// Collapses a mesh to its smallest form and keeps all merges; `progress` can stop the run.
    ///
    /// # Errors
    /// As [`simplify`](super::simplify).
    ///
    /// ```
    /// # use neural_mesh_simplify as neural_mesh;
    /// use std::ops::ControlFlow;
    /// use neural_mesh::{mesh::shapes, simplify::{ClosedOptions, Progression}};
    /// let mesh = shapes::icosphere(4);
    /// let options = ClosedOptions::default();
    /// let progression = Progression::new(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    /// assert_eq!(progression.at_faces(1000, false).unwrap().mesh.faces().len(), 1000);
    /// assert_eq!(progression.at_vertices(100, true).unwrap().mesh.positions().len(), 100);
    /// ```
    pub fn new<'a>(
        input: impl Into<Input<'a>>,
        options: &ClosedOptions,
        progress: &mut Listener,
    ) -> Result<Self, SimplifyError> {
        let task = Task::new(input.into(), options);
        task.input.check()?;
        let scores = used_scores(&task.input, options);
        let task = task.with_scores(&scores);
        let stages = closed_stages(1, USUAL_RATIO);
        run_with_listener(progress, &stages, |progress| Self::record(&task, progress))
    }

    fn record(task: &Task, progress: Progress) -> Result<Self, SimplifyError> {
        let input = &task.input;
        progress.enter("surface", input.mesh.faces().len())?;
        let used = SubMesh::without_unused_vertices(progress.pulse, input)?;
        let used_input = used.input();
        let size = [used_input.mesh.positions().len(), used_input.mesh.faces().len()];
        // Components that the options drop in any case are removed before anything is prepared.
        let pruned = prune(progress.pulse, &used_input, task.options)?;
        let input = pruned.input();
        let plain = PlainInput::new(&input);
        let request = ClosedRequest::new(Task { input: plain.input(), ..*task });
        let RecordedCollapse { surface, keys, end } = record_collapse(&request, progress)?;
        let faces = surface.faces(input.mesh);
        let (components, _) = vertex_components(surface.sequence.n_vertices(), faces);
        let mut progression = Self {
            attributes: input.attributes.clone(),
            kept: input.kept.to_vec(),
            locked: input.locked.to_vec(),
            scene: input.scene.map(UnitedMesh::without_mesh),
            options: task.options.clone(),
            scores: request.scores,
            n_kept_edges: request.edges.len(),
            end,
            size,
            origins: [pruned.origin.clone(), used.origin.clone()],
            surface,
            components,
            drops: Vec::new(),
            proofs: Vec::new(),
            files: Vec::new(),
            is_from_bytes: false,
            mesh: input.mesh.clone(),
        };
        progression.choose_drops(&Task { input, ..*task }, &request.visibility, &keys)?;
        Ok(progression)
    }

    /// Returns the number of vertices of the finest level.
    pub fn n_vertices(&self) -> usize {
        self.size[0]
    }

    /// Returns the number of faces of the finest level.
    pub fn n_faces(&self) -> usize {
        self.size[1]
    }

    /// Makes a mesh of `n` vertices, refined as [`simplify`](super::simplify) does if `refined`.
    ///
    /// Otherwise vertices stay where the merges put them.
    ///
    /// # Errors
    /// [`SimplifyError::BadTarget`] for no vertices, [`SimplifyError::Overflow`].
    pub fn at_vertices(&self, n: usize, refined: bool) -> Result<Simplified, SimplifyError> {
        self.at_target(Size::Vertices(n), refined)
    }

    /// Makes a mesh of `n` faces as [`at_vertices`](Self::at_vertices) does.
    ///
    /// # Errors
    /// As [`at_vertices`](Self::at_vertices).
    pub fn at_faces(&self, n: usize, refined: bool) -> Result<Simplified, SimplifyError> {
        self.at_target(Size::Faces(n), refined)
    }

    /// Makes a mesh of any size as [`at_vertices`](Self::at_vertices) does.
    ///
    /// # Errors
    /// As [`at_vertices`](Self::at_vertices).
    pub fn at_target(&self, target: Size, refined: bool) -> Result<Simplified, SimplifyError> {
        let limit = resolve_limit_of(self.size, target)?;
        let is_whole = limit.vertices >= self.size[0] && limit.faces >= self.size[1];
        let mut simplified = if is_whole && is_sound(&self.mesh, &self.options.frame) {
            let map = self.options.map.then(|| identity_map(&self.mesh));
            Simplified { map, ..unchanged_result(Pulse::NONE, &self.input(), self.scores) }
        } else {
            let level = self.level(if is_whole { Limit::NONE } else { limit });
            if refined || !self.is_bare() { self.make_whole(&level, refined)? } else { self.make_bare(&level)? }
        };
        self.origins.iter().for_each(|origin| origin.lift(&mut simplified, &mut None));
        Ok(simplified)
    }

    /// Makes the smallest of the proved levels that are within `error` of the original, without refinement.
    ///
    /// `error` is in mesh units, or of a scene in its units. `search::prove_progression`
    /// proves the levels. If none is within `error`, returns the mesh itself.
    ///
    /// # Errors
    /// [`SimplifyError::BadError`] if `error` is negative or not a number, [`SimplifyError::NotProved`] without proved
    /// levels.
    pub fn at_error(&self, error: f64) -> Result<Simplified, SimplifyError> {
        if error.is_nan() || error < 0.0 {
            return Err(SimplifyError::BadError(error));
        }
        if self.proofs.is_empty() {
            return Err(SimplifyError::NotProved);
        }
        // Distances rise as levels get smaller.
        let n_within = self.proofs.partition_point(|level| level.distance <= error);
        let n_vertices = n_within.checked_sub(1).map_or(self.size[0], |last| self.proofs[last].n_vertices);
        self.at_vertices(n_vertices, false)
    }

    /// Returns the levels with a proved distance, largest first; distances rise.
    pub fn proved_levels(&self) -> &[ProvedLevel] {
        &self.proofs
    }

    /// Returns the mesh without unused vertices and dropped components, and its attributes.
    pub fn original(&self) -> (&TriMesh, &Attributes) {
        (&self.mesh, &self.attributes)
    }

    /// Returns origin and precision of the coordinates.
    pub fn frame(&self) -> Frame {
        self.options.frame
    }

    #[doc(hidden)]
    pub fn set_proved_levels(&mut self, levels: Vec<ProvedLevel>) {
        self.proofs = levels;
    }

    /// Returns whether the progression was made from this mesh.
    pub fn is_of(&self, mesh: &TriMesh) -> bool {
        let [pruned, used] = &self.origins;
        let is_as_large = used.n_vertices == mesh.positions().len() && self.size[1] == mesh.faces().len();
        // Vertices and faces are looked up in the whole, from which components may have been dropped.
        let row = |rows: &Option<Vec<u32>>, i: u32| rows.as_ref().map_or(i, |rows| rows[i as usize]);
        let vertex = |v: u32| row(&used.vertices, row(&pruned.vertices, v));
        let mut positions = (0u32..).zip(self.mesh.positions());
        let mut faces = (0u32..).zip(self.mesh.faces());
        is_as_large
            && positions.all(|(v, p)| mesh.positions()[vertex(v) as usize] == *p)
            && faces.all(|(f, face)| mesh.faces()[row(&pruned.faces, f) as usize] == face.map(vertex))
    }

    pub(super) fn input(&self) -> Input<'_> {
        let (attributes, scene) = (&self.attributes, self.scene.as_ref());
        Input { attributes, kept: &self.kept, locked: &self.locked, scene, ..Input::bare(&self.mesh) }
    }

    /// Returns whether levels need nothing but positions and faces.
    fn is_bare(&self) -> bool {
        let ClosedOptions { lock_boundaries, subset, map, .. } = self.options;
        let is_constrained = lock_boundaries || subset || !self.kept.is_empty() || !self.locked.is_empty();
        self.attributes.is_empty() && !map && !is_constrained
    }

    /// Finds the level of a size: the largest within the limit, or else the smallest.
    fn level(&self, limit: Limit) -> ProgressionLevel {
        let mut level = self.level_without(limit, Vec::new());
        for drop in &self.drops {
            // Below the smallest form of the remaining components, the next ones go.
            if level.is_reached && self.count(&level)[0] > drop.n_vertices {
                break;
            }
            level.is_dropped.resize(self.n_components(), false);
            drop.components.iter().for_each(|&component| level.is_dropped[component as usize] = true);
            level = ProgressionLevel { drops: level.drops + 1, ..self.level_without(limit, level.is_dropped) };
        }
        level
    }

    pub(super) fn n_components(&self) -> usize {
        self.components.iter().max().map_or(1, |&last| last as usize + 1)
    }

    fn level_without(&self, limit: Limit, is_dropped: Vec<bool>) -> ProgressionLevel {
        let sequence = &self.surface.sequence;
        let mut level = ProgressionLevel { n: 0, is_dropped, drops: 0, is_reached: true };
        if level.is_dropped.is_empty() {
            level.n = sequence.largest_within(limit.vertices, limit.faces);
        } else {
            // Vertices of dropped components count for nothing.
            level.n = sequence.n_roots();
            let [mut n_vertices, mut n_faces] = self.count(&level);
            for vertex in sequence.n_roots()..sequence.n_vertices() {
                if !self.is_dropped(&level, vertex) {
                    (n_vertices, n_faces) = (n_vertices + 1, n_faces + sequence.new_faces(vertex));
                    if n_vertices > limit.vertices || n_faces > limit.faces {
                        break;
                    }
                }
                level.n = vertex + 1;
            }
        }
        let [n_vertices, n_faces] = self.count(&level);
        level.is_reached = n_vertices <= limit.vertices && n_faces <= limit.faces;
        level
    }

    fn is_dropped(&self, level: &ProgressionLevel, vertex: usize) -> bool {
        let component = |&v: &u32| self.components[v as usize] as usize;
        !level.is_dropped.is_empty() && level.is_dropped[component(&self.surface.sequence.vertices()[vertex])]
    }

    /// Returns the numbers of vertices and faces of a level.
    fn count(&self, level: &ProgressionLevel) -> [usize; 2] {
        let sequence = &self.surface.sequence;
        if level.is_dropped.is_empty() {
            return [level.n, sequence.n_faces(level.n)];
        }
        let stays = |vertex: &usize| !self.is_dropped(level, *vertex);
        let of_roots = sequence.faces(sequence.n_roots());
        let n_faces = of_roots.iter().filter(|face| stays(&(face[0] as usize))).count();
        let n_further = (sequence.n_roots()..level.n).filter(stays).map(|vertex| sequence.new_faces(vertex));
        [(0..level.n).filter(stays).count(), n_faces + n_further.sum::<usize>()]
    }

    /// Makes a level from positions and faces alone.
    fn make_bare(&self, level: &ProgressionLevel) -> Result<Simplified, SimplifyError> {
        let sequence = &self.surface.sequence;
        let scale = self.surface.scale;
        let positions = sequence.positions(level.n);
        let mut positions: Vec<[f32; 3]> = positions.iter().map(|p| scale.restore(p.as_dvec3())).collect();
        let mut faces = sequence.faces(level.n);
        if !level.is_dropped.is_empty() {
            let mut number = vec![u32::MAX; level.n];
            let stays = |vertex: &usize| !self.is_dropped(level, *vertex);
            let remaining = (0..level.n).filter(stays);
            (0u32..).zip(remaining.clone()).for_each(|(i, vertex)| number[vertex] = i);
            positions = remaining.map(|vertex| positions[vertex]).collect();
            faces.retain(|face| number[face[0] as usize] != u32::MAX);
            faces.as_flattened_mut().iter_mut().for_each(|vertex| *vertex = number[*vertex as usize]);
        }
        let mesh = TriMesh::new(positions, faces).map_err(|_| SimplifyError::Overflow)?;
        let mut report = Report::for_mesh(Pulse::NONE, &mesh);
        self.complete_report(&mut report, level);
        let dropped = self.drops[..level.drops].iter().flat_map(|drop| &drop.dropped);
        report.dropped = dropped.copied().collect();
        report.dropped.sort_unstable_by_key(|component| component.face);
        report.components_pruned = report.dropped.len();
        Ok(Simplified { mesh, attributes: Attributes::default(), source_vertices: None, map: None, report })
    }

    fn complete_report(&self, report: &mut Report, level: &ProgressionLevel) {
        let end = self.end_of(level);
        (report.scores, report.outcome, report.kept_edges) = (self.scores, end.outcome(), self.n_kept_edges);
        report.split_vertices = self.surface.copies.len();
    }

    fn end_of(&self, level: &ProgressionLevel) -> CollapseEnd {
        if level.is_reached { CollapseEnd::Reached } else { self.end }
    }

    /// Makes a level with all that the mesh carries.
    fn make_whole(&self, level: &ProgressionLevel, is_refined: bool) -> Result<Simplified, SimplifyError> {
        let input = self.input();
        let rest = self.select_rest(&input, level)?;
        let rest_input = rest.input();
        let plain = PlainInput::new(&rest_input);
        let request = ClosedRequest::without_visibility(Task::new(plain.input(), &self.options));
        let choice = LevelChoice { n: level.n, rest: rest.origin.faces.as_deref(), end: self.end_of(level) };
        let mut closed = self.surface.make_level(&self.mesh, &request, &choice, [is_refined, self.is_from_bytes])?;
        plain.restore(&mut closed);
        let mut simplified = closed.simplified;
        simplified.report.scores = self.scores;
        rest.lift(&mut simplified, &mut None);
        Ok(simplified)
    }

    fn select_rest<'a>(&self, input: &Input<'a>, level: &ProgressionLevel) -> Result<SubMesh<'a>, SimplifyError> {
        let n_dropped = self.drops[..level.drops].iter().map(|drop| drop.components.len()).sum();
        let faces = self.surface.faces(&self.mesh);
        let is_dropped = |face: usize| {
            let component = self.components[faces[face][0] as usize];
            level.is_dropped[component as usize]
        };
        SubMesh::without_components(input, [n_dropped, 0], is_dropped)
    }

    /// Chooses the components that smaller levels lack, as a collapse to each of falling sizes would.
    fn choose_drops(&mut self, task: &Task, visibility: &[f32], keys: &[f32]) -> Result<(), SimplifyError> {
        if self.components.is_empty() {
            return Ok(());
        }
        let mut n_asked = self.mesh.positions().len() as f64 / DROP_STEP;
        while n_asked >= LEAST_SIZE as f64 {
            let limit = Limit::from_vertices(n_asked as usize);
            let level = self.level(limit);
            self.drops.extend(self.choose_drop(task, visibility, keys, (limit, &level))?);
            // Below the smallest form views decide.
            if !level.is_reached && self.drops.len() == level.drops {
                break;
            }
            n_asked /= DROP_STEP;
        }
        let drops = self.drop_below_smallest(task, visibility)?;
        self.drops.extend(drops);
        Ok(())
    }

    /// Chooses the components that go below the smallest form of all, by what a viewer misses.
    fn drop_below_smallest(&self, task: &Task, visibility: &[f32]) -> Result<Vec<Drop>, SimplifyError> {
        let level = self.level(Limit::from_vertices(1));
        let rest = self.select_rest(&task.input, &level)?;
        let rest_input = rest.input();
        let plain = PlainInput::new(&rest_input);
        let request = rest_request(Task { input: plain.input(), ..*task }, &rest.origin, visibility);
        if level.is_reached || task.options.hold_shape.is_some() {
            return Ok(Vec::new());
        }
        let faces = rest.origin.faces.as_deref();
        let choice = LevelChoice { n: level.n, rest: faces, end: self.end };
        let order = self.surface.order_drops(&self.mesh, &request, &choice);
        let whole_faces = self.surface.faces(&self.mesh);
        let whole_face = |face: u32| faces.map_or(face, |faces| faces[face as usize]) as usize;
        let component = |face: u32| self.components[whole_faces[whole_face(face)][0] as usize];
        let mut n_roots = vec![0; self.n_components()];
        let roots = &self.surface.sequence.vertices()[..self.surface.sequence.n_roots()];
        roots.iter().for_each(|&v| n_roots[self.components[v as usize] as usize] += 1);
        // Levels that keep as many vertices as this lack nothing more.
        let mut n_left = self.count(&level)[0];
        let (mut drops, mut components, mut n_freed) = (Vec::new(), Vec::new(), 0);
        for component in order.iter().map(|&face| component(face)) {
            components.push(component);
            n_freed += n_roots[component as usize];
            // Many small components go together, so that a list of drops stays short.
            if n_freed as f64 >= LEAST_FREED * n_left as f64 {
                drops.push(self.make_drop(n_left - 1, std::mem::take(&mut components)));
                (n_left, n_freed) = (n_left - n_freed, 0);
            }
        }
        if !components.is_empty() {
            drops.push(self.make_drop(n_left - 1, components));
        }
        Ok(drops)
    }

    fn choose_drop(
        &self,
        task: &Task,
        visibility: &[f32],
        keys: &[f32],
        (limit, level): (Limit, &ProgressionLevel),
    ) -> Result<Option<Drop>, SimplifyError> {
        let rest = self.select_rest(&task.input, level)?;
        let rest_input = rest.input();
        let plain = PlainInput::new(&rest_input);
        let request = rest_request(Task { input: plain.input(), ..*task }, &rest.origin, visibility);
        // Prices are those of the merges in the remaining components.
        let sequence = &self.surface.sequence;
        let ranks = (sequence.n_roots()..sequence.n_vertices()).rev();
        let own = ranks.zip(keys).filter(|(vertex, _)| !self.is_dropped(level, *vertex)).map(|(_, key)| *key);
        let n_rest = (0..sequence.n_vertices()).filter(|vertex| !self.is_dropped(level, *vertex)).count();
        let pass_prices = prices_by_size(n_rest, own);
        let end = self.end_of(level);
        let must_fit = matches!(end, CollapseEnd::Smallest | CollapseEnd::LosesShape);
        let cost = VertexCost { pass_prices: &pass_prices, limit, must_fit };
        let faces = rest.origin.faces.as_deref();
        let choice = LevelChoice { n: level.n, rest: faces, end };
        let Some(dropped) = self.surface.choose_dropped(&self.mesh, &request, &choice, &cost) else {
            return Ok(None);
        };
        let whole_face = |face: usize| faces.map_or(face, |faces| faces[face] as usize);
        let whole_faces = self.surface.faces(&self.mesh);
        let gone = (0..dropped.faces.len()).filter(|&face| dropped.faces[face]);
        let mut components: Vec<u32> =
            gone.map(|face| self.components[whole_faces[whole_face(face)][0] as usize]).collect();
        components.sort_unstable();
        components.dedup();
        // A level that is too large lacks the components only below its own size.
        let n_vertices = self.count(level)[0] - usize::from(!level.is_reached);
        Ok(Some(self.make_drop(n_vertices, components)))
    }

    fn make_drop(&self, n_vertices: usize, components: Vec<u32>) -> Drop {
        // Faces come in order, so the first face found is the first of its component.
        let mut found: Vec<Option<DroppedComponent>> = vec![None; self.n_components()];
        let mut is_dropped = vec![false; found.len()];
        components.iter().for_each(|&component| is_dropped[component as usize] = true);
        let component = |corners: &[u32; 3]| self.components[corners[0] as usize] as usize;
        let faces = (0u32..).zip(self.surface.faces(&self.mesh).iter().map(component));
        for (face, component) in faces.filter(|(_, component)| is_dropped[*component]) {
            found[component].get_or_insert(DroppedComponent { face, n_faces: 0 }).n_faces += 1;
        }
        Drop { n_vertices, components, dropped: found.into_iter().flatten().collect() }
    }
}

/// Plans a run on what some dropped components leave, with the visibility of all vertices.
fn rest_request<'a>(task: Task<'a>, origin: &SubMeshOrigin, visibility: &[f32]) -> ClosedRequest<'a> {
    let visibility = match origin.vertices.as_deref() {
        _ if visibility.is_empty() => Vec::new(),
        None => visibility.to_vec(),
        Some(rows) => rows.iter().map(|&v| visibility[v as usize]).collect(),
    };
    ClosedRequest { visibility, ..ClosedRequest::without_visibility(task) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::{Channel, Role, shapes, topology};
    use crate::simplify::{Options, Outcome, simplify};

    fn progression<'a>(input: impl Into<Input<'a>>) -> Progression {
        Progression::new(input, &ClosedOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap()
    }

    fn sphere_with_dust() -> TriMesh {
        let (large, small) = (shapes::wavy_sphere(4, 6.0), shapes::icosphere(0));
        let grain = |i: u32| {
            let angle = 0.157 * i as f32;
            let at = [1.03 * angle.cos(), 1.03 * angle.sin(), 0.0];
            shapes::place(&small, |p| [0, 1, 2].map(|k| 0.004 * p[k] + at[k]))
        };
        shapes::unite([large].into_iter().chain((0..40).map(grain)))
    }

    #[test]
    fn levels_have_the_requested_size_and_are_closed() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let progression = progression(&mesh);
        for n in [2560, 1281, 700, 333, 100, 20] {
            for refined in [false, true] {
                let level = progression.at_vertices(n, refined).unwrap();
                assert_eq!(level.mesh.positions().len(), n);
                assert!(topology(&level.mesh).is_closed_manifold());
                assert_eq!(level.report.outcome, Outcome::Reached);
                let level = progression.at_faces(2 * n + 1, refined).unwrap();
                assert_eq!(level.mesh.faces().len(), 2 * n);
            }
        }
        assert_eq!(progression.at_target(Size::Ratio(1.0), true).unwrap().mesh, mesh);
        assert_eq!(progression.at_faces(0, true), Err(SimplifyError::BadTarget(Size::Faces(0))));
        let smallest = progression.at_vertices(1, false).unwrap();
        assert!(matches!(smallest.report.outcome, Outcome::Stopped(_)) && smallest.mesh.positions().len() < 9);
    }

    #[test]
    fn refined_levels_are_as_near_as_single_results() {
        use crate::metrics::{Surface, surface_distance};
        let mesh = shapes::wavy_sphere(5, 8.0);
        let (progression, whole) = (progression(&mesh), Surface::new(&mesh, 20_000, 0));
        let distance = |mesh: &TriMesh| surface_distance(&whole, &Surface::new(mesh, 20_000, 0)).unwrap().both.mean;
        for ratio in [0.5, 0.2, 0.1, 0.05, 0.01] {
            let options = Options::new(Size::Ratio(ratio));
            let single = simplify(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
            let level = progression.at_target(options.target, true).unwrap();
            let ratio_of_distances = distance(&level.mesh) / distance(&single.mesh);
            assert!(ratio_of_distances < 1.1, "{ratio} {ratio_of_distances}");
        }
    }

    #[test]
    fn dust_is_dropped_as_single_results_drop_it() {
        let mesh = sphere_with_dust();
        let progression = progression(&mesh);
        for n in [1500, 400, 150, 60] {
            let options = Options::new(Size::Vertices(n));
            let single = simplify(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
            for refined in [false, true] {
                let level = progression.at_vertices(n, refined).unwrap();
                assert_eq!(level.mesh.positions().len(), n);
                assert!(topology(&level.mesh).is_closed_manifold());
                let (found, naive) = (level.report.components_pruned, single.report.components_pruned);
                assert!(found.abs_diff(naive) <= 8, "{n} {refined}: {found} {naive}");
                assert_eq!(level.report.dropped.len(), found);
                assert_eq!(topology(&level.mesh).components, 41 - found);
            }
        }
    }

    #[test]
    fn levels_go_below_the_smallest_form_of_all_components() {
        // Spheres in a row, so that none hides another.
        let sphere = shapes::icosphere(2);
        let mesh = shapes::unite((0..9).map(|i| shapes::place(&sphere, |[x, y, z]| [x + 3.0 * i as f32, y, z])));
        let attributes = Attributes { groups: vec![0; mesh.faces().len()], ..Attributes::default() };
        let progression = progression(Input { attributes: &attributes, ..Input::bare(&mesh) });
        let progression = Progression::from_bytes(&progression.to_bytes()).unwrap();
        for (n, n_left) in [(36, 9), (35, 8), (20, 5), (7, 1), (4, 1)] {
            for refined in [false, true] {
                let level = progression.at_vertices(n, refined).unwrap();
                assert_eq!((level.mesh.positions().len(), level.report.outcome), (n, Outcome::Reached));
                assert_eq!((topology(&level.mesh).components, level.report.components_pruned), (n_left, 9 - n_left));
                assert!(topology(&level.mesh).is_closed_manifold());
            }
        }
        let smallest = progression.at_vertices(3, true).unwrap();
        assert!(matches!(smallest.report.outcome, Outcome::Stopped(_)) && smallest.mesh.positions().len() == 4);
    }

    #[test]
    fn kept_components_have_a_smallest_form() {
        let mesh = sphere_with_dust();
        let options = ClosedOptions { prune: false, ..ClosedOptions::default() };
        let progression = Progression::new(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        let smallest = progression.at_vertices(10, false).unwrap();
        assert_eq!(topology(&smallest.mesh).components, 41);
    }

    #[test]
    fn levels_carry_attributes_and_map_to_the_input() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let north = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() > 0.0;
        let values = mesh.positions().iter().flat_map(|p| [p[0], p[1]]).collect();
        let attributes = Attributes {
            groups: mesh.faces().iter().map(|face| u32::from(north(face))).collect(),
            wedges: mesh.faces().to_vec(),
            channels: vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }],
        };
        // Vertices without a face count for nothing, and the map names those of the caller.
        let (mut positions, faces) = mesh.clone().into_parts();
        positions.insert(0, [9.0; 3]);
        let mesh = TriMesh::new(positions, faces.iter().map(|face| face.map(|v| v + 1)).collect()).unwrap();
        let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
        let options = ClosedOptions { map: true, ..ClosedOptions::default() };
        let progression = Progression::new(input, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        for refined in [false, true] {
            let level = progression.at_vertices(300, refined).unwrap();
            assert_eq!((level.mesh.positions().len(), topology(&level.mesh).is_closed_manifold()), (300, true));
            assert!(level.attributes.is_valid_for(level.mesh.faces().len()) && level.attributes.groups.contains(&1));
            let map = level.map.unwrap();
            assert_eq!((map.output_vertices.len(), map.output_vertices[0]), (mesh.positions().len(), u32::MAX));
            let uv = &level.attributes.channels[0];
            for (face, wedges) in level.mesh.faces().iter().zip(&level.attributes.wedges) {
                for (&v, &wedge) in face.iter().zip(wedges) {
                    let p = level.mesh.positions()[v as usize];
                    assert!(uv.value(wedge).iter().zip(p).all(|(x, y)| (x - y).abs() < 0.2));
                }
            }
        }
    }

    #[test]
    fn locked_vertices_and_subsets_stay_in_place() {
        let mesh = shapes::open_cylinder(40, 30);
        for (lock_boundaries, subset) in [(true, false), (false, true)] {
            let options = ClosedOptions { lock_boundaries, subset, ..ClosedOptions::default() };
            let progression = Progression::new(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
            for refined in [false, true] {
                let level = progression.at_vertices(200, refined).unwrap().mesh;
                let is_input = |p: &&[f32; 3]| mesh.positions().contains(p);
                let n_in_place = level.positions().iter().filter(is_input).count();
                assert!(n_in_place >= if subset { 200 } else { 80 }, "{n_in_place}");
            }
        }
    }
}
