//! Subset of the faces and vertices of an input, and results lifted from it to the whole.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::mesh::union_find::join_faces;
use crate::mesh::{Attributes, TriMesh, compact};
use crate::parallel;

use super::closed::Derivative;
use super::input::Input;
use super::options::{DroppedComponent, Simplified, SimplifyError};

#[doc(hidden)]
pub struct SubMesh<'a> {
    whole: Input<'a>,
    mesh: Cow<'a, TriMesh>,
    attributes: Cow<'a, Attributes>,
    importance: Cow<'a, [f32]>,
    scores: Cow<'a, [f32]>,
    kept: Cow<'a, [bool]>,
    locked: Cow<'a, [bool]>,
    pub origin: SubMeshOrigin,
}

/// Origin of a subset's vertices and faces in the whole mesh.
#[derive(Clone, Debug, Default)]
#[doc(hidden)]
pub struct SubMeshOrigin {
    /// Number of vertices of the whole.
    pub n_vertices: usize,
    /// Vertices of the whole; `None` for all.
    pub vertices: Option<Vec<u32>>,
    /// Faces of the whole; `None` for all.
    pub faces: Option<Vec<u32>>,
    pub n_dropped: usize,
    pub n_hidden: usize,
    pub dropped: Vec<DroppedComponent>,
}

impl<'a> SubMesh<'a> {
    pub fn whole(input: &Input<'a>) -> Self {
        Self {
            whole: *input,
            mesh: Cow::Borrowed(input.mesh),
            attributes: Cow::Borrowed(input.attributes),
            importance: Cow::Borrowed(input.importance),
            scores: Cow::Borrowed(input.scores),
            kept: Cow::Borrowed(input.kept),
            locked: Cow::Borrowed(input.locked),
            origin: SubMeshOrigin { n_vertices: input.mesh.positions().len(), ..SubMeshOrigin::default() },
        }
    }

    /// Removes unused vertices.
    ///
    /// # Errors
    /// [`SimplifyError::Empty`] for a mesh without faces.
    pub fn without_unused_vertices(pulse: Pulse, input: &Input<'a>) -> Result<Self, SimplifyError> {
        let mesh = input.mesh;
        if mesh.faces().is_empty() {
            return Err(SimplifyError::Empty);
        }
        // Marks commute, so threads may set them in any order.
        let used: Vec<AtomicBool> = (0..mesh.positions().len()).map(|_| AtomicBool::new(false)).collect();
        let mark = |face: &[u32; 3]| face.iter().for_each(|&v| used[v as usize].store(true, Relaxed));
        for faces in pulse.chunks(mesh.faces()) {
            parallel::chunks(faces, PARALLEL, |_, faces| faces.iter().for_each(mark));
        }
        let whole = Self::whole(input);
        if used.into_iter().all(AtomicBool::into_inner) { Ok(whole) } else { whole.compact(mesh.faces().to_vec()) }
    }

    /// Removes faces of `n_dropped` surfaces, of which `n_hidden` are hidden; keeps all if there are none.
    pub fn without_components(
        input: &Input<'a>,
        [n_dropped, n_hidden]: [usize; 2],
        is_dropped: impl Fn(usize) -> bool,
    ) -> Result<Self, SimplifyError> {
        if n_dropped == 0 {
            return Ok(Self::whole(input));
        }
        let faces: Vec<u32> = (0..input.mesh.faces().len() as u32).filter(|&f| !is_dropped(f as usize)).collect();
        let attributes = input.attributes.clone().select_faces(&faces).ok_or(SimplifyError::BadInput)?;
        let corners = faces.iter().map(|&f| input.mesh.faces()[f as usize]).collect();
        let kept = select_rows(input.kept, &faces);
        let dropped = dropped_components(input.mesh, is_dropped);
        // Sheets that were separated are one component of the input where they touch.
        let n_dropped = dropped.len();
        let mut part = Self { attributes: Cow::Owned(attributes), kept, ..Self::whole(input) };
        part.origin = SubMeshOrigin { faces: Some(faces), n_dropped, n_hidden, dropped, ..part.origin };
        part.compact(corners)
    }

    fn compact(self, faces: Vec<[u32; 3]>) -> Result<Self, SimplifyError> {
        let Input { mesh, importance, scores, locked, .. } = self.whole;
        let (mesh, vertices) = compact(mesh.positions(), faces).map_err(|_| SimplifyError::Overflow)?;
        let [importance, scores] = [importance, scores].map(|rows| select_rows(rows, &vertices));
        let locked = select_rows(locked, &vertices);
        let origin = SubMeshOrigin { vertices: Some(vertices), ..self.origin };
        Ok(Self { mesh: Cow::Owned(mesh), importance, scores, locked, origin, ..self })
    }

    /// Moves all vertices; `positions` has a row per vertex of the whole.
    ///
    /// # Errors
    /// [`SimplifyError::Overflow`] if a position is not finite.
    pub fn with_positions(self, positions: &[[f32; 3]]) -> Result<Self, SimplifyError> {
        let positions = match &self.origin.vertices {
            Some(vertices) => vertices.iter().map(|&v| positions[v as usize]).collect(),
            None => positions.to_vec(),
        };
        let mesh = TriMesh::new(positions, self.mesh.faces().to_vec()).map_err(|_| SimplifyError::Overflow)?;
        Ok(Self { mesh: Cow::Owned(mesh), ..self })
    }

    pub fn input(&self) -> Input<'_> {
        let Self { mesh, attributes, importance, scores, kept, locked, .. } = self;
        Input { mesh, attributes, importance, scores, kept, locked, ..self.whole }
    }

    /// Converts a result for these faces to one for the whole.
    pub(super) fn lift(&self, simplified: &mut Simplified, derivative: &mut Option<Derivative>) {
        self.origin.lift(simplified, derivative);
    }
}

impl SubMeshOrigin {
    /// Converts a result for a subset to one for the whole.
    pub(super) fn lift(&self, simplified: &mut Simplified, derivative: &mut Option<Derivative>) {
        let Simplified { source_vertices, map, report, .. } = simplified;
        if let Some(faces) = &self.faces {
            report.components_pruned += self.n_dropped;
            report.components_hidden += self.n_hidden;
            report.dropped.iter_mut().for_each(|component| component.face = faces[component.face as usize]);
            report.dropped.extend(&self.dropped);
            report.dropped.sort_unstable_by_key(|component| component.face);
            let corner_faces = map.iter_mut().flat_map(|map| map.corner_faces.as_flattened_mut());
            corner_faces.for_each(|face| *face = faces[*face as usize]);
        }
        let Some(vertices) = &self.vertices else { return };
        if let Some(map) = map {
            let mut outputs = vec![u32::MAX; self.n_vertices];
            vertices.iter().zip(&map.output_vertices).for_each(|(&v, &x)| outputs[v as usize] = x);
            map.output_vertices = outputs;
            let sources = map.input_vertices.iter_mut().filter(|v| **v != u32::MAX);
            sources.for_each(|v| *v = vertices[*v as usize]);
        }
        source_vertices.iter_mut().flatten().for_each(|v| *v = vertices[*v as usize]);
        derivative.iter_mut().for_each(|derivative| derivative.extend_to(vertices));
    }
}

fn dropped_components(mesh: &TriMesh, is_dropped: impl Fn(usize) -> bool) -> Vec<DroppedComponent> {
    let faces: Vec<u32> = (0u32..).take(mesh.faces().len()).filter(|&f| is_dropped(f as usize)).collect();
    let corners: Vec<[u32; 3]> = faces.iter().map(|&f| mesh.faces()[f as usize]).collect();
    let (component, n) = join_faces(mesh.positions().len(), &corners, |_| true).number_sets(Pulse::NONE);
    // Faces come in order, so the first face found is the first of its component.
    let mut dropped: Vec<Option<DroppedComponent>> = vec![None; n];
    for (&face, component) in faces.iter().zip(component) {
        dropped[component as usize].get_or_insert(DroppedComponent { face, n_faces: 0 }).n_faces += 1;
    }
    dropped.into_iter().flatten().collect()
}

fn select_rows<'a, T: Copy>(rows: &'a [T], numbers: &[u32]) -> Cow<'a, [T]> {
    if rows.is_empty() { Cow::Borrowed(rows) } else { numbers.iter().map(|&number| rows[number as usize]).collect() }
}
