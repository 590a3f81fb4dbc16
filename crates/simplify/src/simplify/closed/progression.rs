//! One collapse of all merges, and the levels that it yields.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::mesh::pulse::Pulse;
use crate::mesh::{Manifold, OneRings, TriMesh, topology};
use crate::simplify::limits::Limit;
use crate::simplify::options::SimplifyError;
use crate::simplify::progress::Progress;

use super::coarsening::coarsen;
use super::collapse::{CollapseEnd, RecordedMerge};
use super::dropping::{self, VertexCost, output_components};
use super::importance;
use super::output::Output;
use super::prepare::surface::{Normalisation, PreparedSurface};
use super::prepare::{prepare, prepare_surface};
use super::request::{ClosedRequest, Task};
use super::result::{ClosedResult, local_positions};
use super::split_sequence::SplitSequence;
use super::visible_drops::{DropChoice, order_by_views};
use super::{CollapseBase, DroppedFaces, faces_around::smallest_first, refine, start};

const NONE: u32 = u32::MAX;
/// Ratio of neighbouring sizes at which the highest price so far is noted.
const PRICE_STEP: f64 = 1.05;

/// Largest number of moves of corners in saved merges: the first per face, plus the second.
// Merges of collapses move two corners per face; others could be made to take any memory.
const MOST_MOVES: [u64; 2] = [64, 1 << 20];

/// All merges of a mesh, in the order of price.
pub struct RecordedCollapse {
    pub surface: ProgressionSurface,
    /// Keys of the merges, rising.
    pub keys: Vec<f32>,
    pub end: CollapseEnd,
}

/// Collapses a mesh to its smallest form and records all merges.
pub fn record_collapse(request: &ClosedRequest, progress: Progress) -> Result<RecordedCollapse, SimplifyError> {
    let (limit, mesh) = (Limit::from_vertices(1), request.task.input.mesh);
    let (base, collapse) = start(request, limit, progress)?;
    let mut collapse = collapse.with_recording();
    let mut end = collapse.run(limit);
    if end != CollapseEnd::Reached && request.task.options.hold_shape.is_none() {
        end = coarsen(&base, &mut collapse, end, limit, false).end;
    }
    let mut merges = collapse.take_recording();
    collapse.free_memory();
    // Merges that depend on each other have rising keys, so a stable sort keeps their order.
    merges.par_sort_by(|x, y| x.key.total_cmp(&y.key));
    progress.enter("finish", mesh.faces().len())?;
    let keys = merges.iter().map(|merge| merge.key).collect();
    // The collapse removes no vertex twice.
    let surface = ProgressionSurface::new(mesh, &base.original.surface, &merges).ok_or(SimplifyError::BadInput)?;
    Ok(RecordedCollapse { surface, keys, end })
}

/// The manifold surface of a mesh, as the collapse numbers its vertices.
pub struct ProgressionSurface {
    pub scale: Normalisation,
    /// Faces, if the surface has other vertices or another winding than the mesh.
    pub faces: Option<Vec<[u32; 3]>>,
    /// Mesh vertex of each surface vertex from the mesh's number of vertices on.
    pub copies: Vec<u32>,
    pub sequence: SplitSequence,
}

impl ProgressionSurface {
    /// Builds the splits of a mesh from its merges; `None` if the merges are of another mesh.
    fn new(mesh: &TriMesh, surface: &PreparedSurface, merges: &[RecordedMerge]) -> Option<Self> {
        let sequence = SplitSequence::new(surface.pulse, &surface.positions, &surface.faces, merges)?;
        Some(Self::from_sequence(mesh, surface, sequence))
    }

    fn from_sequence(mesh: &TriMesh, surface: &PreparedSurface, sequence: SplitSequence) -> Self {
        let copies = surface.sources().skip(mesh.positions().len()).collect();
        let faces = (*surface.faces != *mesh.faces()).then(|| surface.faces.to_vec());
        Self { scale: surface.scale, faces, copies, sequence }
    }

    /// Builds the splits of a mesh from saved merges; `None` if the merges are of another mesh.
    pub fn from_merges(mesh: &TriMesh, merges: &[RecordedMerge]) -> Option<Self> {
        let surface = PreparedSurface::new(mesh, Pulse::NONE);
        let most_moves = MOST_MOVES[0] * surface.faces.len() as u64 + MOST_MOVES[1];
        let sequence =
            SplitSequence::with_most_moves(Pulse::NONE, &surface.positions, &surface.faces, merges, most_moves)?;
        Some(Self::from_sequence(mesh, &surface, sequence))
    }

    pub fn faces<'a>(&'a self, mesh: &'a TriMesh) -> &'a [[u32; 3]] {
        self.faces.as_deref().unwrap_or(mesh.faces())
    }

    /// Returns the mesh vertex at a surface vertex.
    pub fn source(&self, mesh: &TriMesh, vertex: u32) -> u32 {
        let n_own = mesh.positions().len();
        if (vertex as usize) < n_own { vertex } else { self.copies[vertex as usize - n_own] }
    }
}

/// Size of a level, and the faces that it still has.
pub struct LevelChoice<'a> {
    /// Number of vertices of the sequence, those of dropped components included.
    pub n: usize,
    /// Faces in the whole of a mesh without the dropped components; `None` for the whole.
    pub rest: Option<&'a [u32]>,
    pub end: CollapseEnd,
}

impl ProgressionSurface {
    /// Makes a level with all that the mesh carries, refined if asked, and checked if the merges may be anyone's.
    ///
    /// # Errors
    /// [`SimplifyError::BadProgression`] if a checked level is no manifold, [`SimplifyError::Overflow`].
    pub fn make_level(
        &self,
        mesh: &TriMesh,
        request: &ClosedRequest,
        choice: &LevelChoice,
        [is_refined, is_checked]: [bool; 2],
    ) -> Result<ClosedResult, SimplifyError> {
        let base = self.base(mesh, request, choice.rest);
        let output = self.output(&base, choice.n);
        if is_checked && !is_manifold(&output) {
            return Err(SimplifyError::BadProgression("its merges are no mesh's"));
        }
        if is_refined {
            return refine(&base, request, output, choice.end, None, Progress::SILENT);
        }
        finish_unrefined(&base, request, output, choice.end)
    }

    /// Chooses components to drop at a level; `None` if all stay.
    pub fn choose_dropped(
        &self,
        mesh: &TriMesh,
        request: &ClosedRequest,
        choice: &LevelChoice,
        cost: &VertexCost,
    ) -> Option<DroppedFaces> {
        let within = request.task.drops_within()?;
        let (base, output) = self.weighed_level(mesh, request, choice);
        dropping::choose_dropped(&base.original, &output, cost, within, &request.visual_properties())
    }

    /// Lists a face of each component that goes below the smallest level, those that a viewer misses least first.
    pub fn order_drops(&self, mesh: &TriMesh, request: &ClosedRequest, choice: &LevelChoice) -> Vec<u32> {
        let Some(within) = request.task.drops_within() else { return Vec::new() };
        let (base, output) = self.weighed_level(mesh, request, choice);
        let (of_vertex, n) = output_components(&output);
        if n < 2 {
            return Vec::new();
        }
        let component = |face: &[u32; 3]| of_vertex[output.vertex_of[face[0] as usize] as usize];
        let component_of_face: Vec<u32> = base.original.surface.faces.iter().map(component).collect();
        let mut sizes = vec![[0; 2]; n];
        of_vertex.iter().for_each(|&component| sizes[component as usize][0] += 1);
        output.faces().iter().for_each(|face| sizes[of_vertex[face[0] as usize] as usize][1] += 1);
        let mut first_face = vec![NONE; n];
        for (face, &component) in (0u32..).zip(&component_of_face) {
            first_face[component as usize] = face.min(first_face[component as usize]);
        }
        let drops = DropChoice { component_of_face: &component_of_face, n, output: &output, within };
        let order = order_by_views(&base.original, &drops, sizes, &request.visual_properties());
        order.into_iter().map(|component| first_face[component]).collect()
    }

    /// Returns the surface, weighted as its components are judged, with the vertices of a level.
    fn weighed_level<'a>(
        &self,
        mesh: &TriMesh,
        request: &ClosedRequest<'a>,
        choice: &LevelChoice,
    ) -> (CollapseBase<'a>, Output) {
        let mut base = self.base(mesh, request, choice.rest);
        if request.visual_properties().is_weighed {
            importance::weigh(&mut base.original.surface, request.importance, 1.0, &request.visibility);
        }
        let output = self.output(&base, choice.n);
        (base, output)
    }

    fn base<'a>(&self, mesh: &TriMesh, request: &ClosedRequest<'a>, rest: Option<&[u32]>) -> CollapseBase<'a> {
        let Some(faces) = rest else {
            let original = prepare(request, Pulse::NONE);
            return CollapseBase { original, collapse_vertices: Vec::new() };
        };
        let rest = request.task.input.mesh;
        let (manifold, collapse_vertices) = self.rest(mesh, rest, faces);
        let surface = PreparedSurface::of_manifold(rest, manifold, self.scale, Pulse::NONE);
        CollapseBase { original: prepare_surface(surface, request), collapse_vertices }
    }

    /// Returns the surface of some faces, with the vertex of the whole surface at each of its own.
    ///
    /// Without the other faces, it might be split at other edges, and the merges would not fit.
    fn rest<'a>(&self, mesh: &TriMesh, rest: &TriMesh, faces: &[u32]) -> (Manifold<'a>, Vec<u32>) {
        let whole = |face: u32| self.faces(mesh)[face as usize];
        // Corners are identified by their mesh vertex, since surfaces may wind a face differently.
        let corner = |w: u32, face: u32| mesh.faces()[face as usize].iter().position(|&v| v == self.source(mesh, w));
        let of_face =
            |(of_rest, &face): (&[u32; 3], &u32)| whole(face).map(|w| (w, of_rest[corner(w, face).unwrap_or(0)]));
        let mut sources: Vec<(u32, u32)> = rest.faces().iter().zip(faces).flat_map(of_face).collect();
        sources.sort_unstable();
        sources.dedup();
        let n = rest.positions().len();
        let (mut vertices, mut copies) = (vec![NONE; n], Vec::new());
        let mut number = vec![NONE; self.sequence.n_vertices()];
        for (w, v) in sources {
            if vertices[v as usize] == NONE {
                (vertices[v as usize], number[w as usize]) = (w, v);
            } else {
                number[w as usize] = (n + copies.len()) as u32;
                copies.push(v);
                vertices.push(w);
            }
        }
        let corners: Vec<[u32; 3]> = faces.iter().map(|&face| whole(face).map(|w| number[w as usize])).collect();
        // Whole components of a manifold are one.
        let rings = OneRings::new(vertices.len(), &corners).unwrap_or_default();
        (Manifold { faces: Cow::Owned(corners), rings, copies, turned_faces: 0 }, vertices)
    }

    /// Returns the surface with the first `n` vertices of the sequence that it has, in the order of its own vertices.
    fn output(&self, base: &CollapseBase, n: usize) -> Output {
        let (surface, sequence) = (&base.original.surface, &self.sequence);
        let whole = |v: u32| base.collapse_vertices.get(v as usize).copied().unwrap_or(v);
        let mut rank = vec![0; sequence.n_vertices()];
        (0u32..).zip(sequence.vertices()).for_each(|(r, &v)| rank[v as usize] = r);
        // Each vertex is merged into its first ancestor that remains; parents have smaller ranks.
        let mut ancestor: Vec<u32> = (0..sequence.n_vertices() as u32).collect();
        (n..ancestor.len()).for_each(|r| ancestor[r] = ancestor[sequence.parent(r) as usize]);
        let own = (0..surface.n_vertices() as u32).map(|v| rank[whole(v) as usize]);
        let remaining: Vec<u32> =
            (0u32..).zip(own.clone()).filter(|(_, r)| (*r as usize) < n).map(|(v, _)| v).collect();
        let at = sequence.positions(n);
        let mut number = vec![NONE; n];
        let mut positions = Vec::with_capacity(remaining.len());
        for (i, &v) in (0u32..).zip(&remaining) {
            let r = rank[whole(v) as usize] as usize;
            number[r] = i;
            positions.push(at[r]);
        }
        let vertex_of: Vec<u32> = own.map(|r| number[ancestor[r as usize] as usize]).collect();
        // A face remains if its corners are merged into three vertices.
        let faces = surface.faces.iter().map(|face| face.map(|v| vertex_of[v as usize]));
        let faces = faces.filter(|&[a, b, c]| a != b && b != c && c != a).map(smallest_first).collect();
        let pins = self.pins(base, n, &remaining);
        Output::new(surface.pulse, positions, faces, pins, vertex_of)
    }

    fn pins(&self, base: &CollapseBase, n: usize, remaining: &[u32]) -> super::pins::Pins {
        let original = &base.original;
        if original.features.is_empty() && original.pins.is_empty() {
            return super::pins::Pins::default();
        }
        let sequence = &self.sequence;
        let n_own = original.surface.n_vertices();
        let mut pins = original.pins.with_surface_origins(n_own);
        // Pins follow the merges, in the numbers of the remaining surface.
        let mut of_surface: Vec<u32> = vec![NONE; sequence.n_vertices()];
        let whole = |v: u32| base.collapse_vertices.get(v as usize).copied().unwrap_or(v);
        (0..n_own as u32).for_each(|v| of_surface[whole(v) as usize] = v);
        for rank in (n..sequence.n_vertices()).rev() {
            let vertices = [sequence.parent(rank) as usize, rank].map(|rank| sequence.vertices()[rank]);
            let [kept, removed] = vertices.map(|v| of_surface[v as usize]);
            if kept != NONE && removed != NONE {
                pins.merge(kept, removed, sequence.takes_place(rank));
            }
        }
        pins.select(remaining)
    }
}

fn is_manifold(output: &Output) -> bool {
    let positions = output.positions.iter().map(|p| p.to_array()).collect();
    let mesh = TriMesh::new(positions, output.faces().to_vec());
    mesh.is_ok_and(|mesh| {
        let found = topology(&mesh);
        found.non_manifold_edges + found.non_manifold_vertices + found.unreferenced_vertices == 0
    })
}

/// Returns the highest price so far at falling numbers of vertices, all of them counted.
pub fn prices_by_size(n_vertices: usize, keys: impl Iterator<Item = f32>) -> Vec<(usize, f32)> {
    let mut prices: Vec<(usize, f32)> = Vec::new();
    let (mut left, mut most) = (n_vertices, 0.0f32);
    for key in keys {
        (left, most) = (left - 1, most.max(key));
        if prices.last().is_none_or(|(last, _)| left as f64 * PRICE_STEP <= *last as f64) {
            prices.push((left, most));
        }
    }
    prices.push((left, most));
    prices
}

/// Finishes a level whose vertices stay where the collapse put them.
fn finish_unrefined(
    base: &CollapseBase,
    request: &ClosedRequest,
    mut output: Output,
    end: CollapseEnd,
) -> Result<ClosedResult, SimplifyError> {
    let original = &base.original;
    let Task { input, options, .. } = request.task;
    let attributes = original.attributes.as_deref().or(options.map.then_some(crate::mesh::Attributes::NONE));
    attributes.into_iter().for_each(|attributes| output.record_attributes(original, attributes));
    let positions = local_positions(original, &output);
    let corner_values = attributes.and_then(|attributes| output.take_attributes(original, attributes));
    let (attributes, corner_map) = corner_values.unzip();
    let mut closed = ClosedResult::new(original, output, positions, input.kept)?;
    let map = corner_map.filter(|_| options.map).map(|corners| closed.build_map(original.mesh, corners));
    (closed.simplified.attributes, closed.simplified.map) = (attributes.unwrap_or_default(), map);
    base.complete_report(&mut closed.simplified.report, request, end);
    Ok(closed)
}
