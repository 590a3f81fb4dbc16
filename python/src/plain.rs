//! The small path: clean meshes without data, by the kernel alone.

use std::time::Instant;

use neural_mesh::job::{Arguments, Goal, Size};
use neural_mesh_cli::embedded::Failure;
use neural_mesh_collapse::{
    CollapseOptions, CollapseOutcome, CollapseResult, CollapseSize, PassListener, collapse, weld,
};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{array, indices, rows, triples};
use crate::background::{ProgressChannel, run_in_background};
use crate::failure::option_error;
use crate::mesh_arrays::{Positions, parse_options};
use crate::values;

/// Most faces in all for which starting threads takes longer than the work.
const MOST_FACES_HERE: usize = 20_000;

#[pyclass(frozen, get_all, module = "neural_mesh._native")]
pub struct PlainResult {
    vertices: Py<PyAny>,
    faces: Py<PyAny>,
    /// Number of input vertices that have a face.
    n_used: usize,
    threads: usize,
    /// The kernel's estimate of the largest distance, in the unit of the mesh.
    error: f64,
    seconds: f64,
    target: Py<PyAny>,
    /// An input vertex that became each of the result's.
    origins: Py<PyAny>,
    /// The result's vertex that each of the input's became; -1 for one without a face.
    became: Option<Py<PyAny>>,
}

/// Simplifies meshes to a size by the kernel; `None` for each that is not clean, or for which merges alone do not reach it.
///
/// `options` has a size of vertices or faces, and nothing else; `None` is returned for one of another kind. With `welds`
/// a mesh with two vertices at one position is not clean. `keeps_merges` fills `became`.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "they are what Python has")]
#[pyo3(signature = (options, meshes, n_fit_steps, locks_boundaries, welds, keeps_merges, threads, progress))]
pub fn simplify_plain(
    py: Python,
    options: &Bound<PyAny>,
    meshes: Vec<(Positions, PyReadonlyArray2<u32>)>,
    n_fit_steps: usize,
    locks_boundaries: bool,
    welds: bool,
    keeps_merges: bool,
    threads: Option<usize>,
    progress: Option<Bound<PyAny>>,
) -> PyResult<Option<Vec<Option<PlainResult>>>> {
    let arguments: Arguments = parse_options(options)?;
    let job = arguments.job().map_err(option_error)?;
    let Goal::One(size) = job.goal else { return Ok(None) };
    let meshes: Vec<PlainMesh> = meshes.iter().map(PlainMesh::read).collect::<PyResult<_>>()?;
    let n_faces: usize = meshes.iter().map(|mesh| mesh.faces.len()).sum();
    let task = Task { size, n_fit_steps, locks_boundaries, welds };
    let is_short = n_faces <= MOST_FACES_HERE || threads == Some(1) && n_faces < 10 * MOST_FACES_HERE;
    let lighter: Vec<Option<Lighter>> = if is_short && progress.is_none() {
        py.detach(|| meshes.iter().map(|mesh| mesh.simplify(task, 1, None)).collect())
    } else {
        run_in_background(py, threads, progress, move |channel| Ok::<_, Failure>(simplify_all(&meshes, task, channel)))?
    };
    let target = serde_json::to_value(&job.goal).map_err(option_error)?;
    let convert = |lighter: Option<Lighter>| {
        lighter.map(|lighter| lighter.convert(py, values::to_python(py, &target)?, keeps_merges)).transpose()
    };
    Ok(Some(lighter.into_iter().map(convert).collect::<PyResult<_>>()?))
}

/// One mesh on all threads, several on one each.
fn simplify_all(meshes: &[PlainMesh], task: Task, channel: &ProgressChannel) -> Vec<Option<Lighter>> {
    let listener = |share: f32| channel.hear(0.9 * share, "surface");
    match meshes {
        [mesh] => vec![mesh.simplify(task, 0, Some(&listener))],
        meshes => meshes.par_iter().with_max_len(1).map(|mesh| mesh.simplify(task, 1, None)).collect(),
    }
}

/// The task of all meshes of a call.
#[derive(Clone, Copy)]
struct Task {
    size: Size,
    n_fit_steps: usize,
    locks_boundaries: bool,
    welds: bool,
}

/// A mesh as the kernel takes it.
struct PlainMesh {
    /// In the caller's unit; around `center` for double precision.
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    double: Option<DoublePositions>,
}

/// Positions of double precision, which do not fit into those of the kernel.
struct DoublePositions {
    center: [f64; 3],
    exact: Vec<[f64; 3]>,
}

struct Lighter {
    result: CollapseResult,
    exact: Option<Vec<[f64; 3]>>,
    used: Vec<u32>,
    n_input: usize,
    n_threads: usize,
    seconds: f64,
}

impl PlainMesh {
    fn read((positions, faces): &(Positions, PyReadonlyArray2<u32>)) -> PyResult<Self> {
        let faces = rows(faces, "faces")?.to_vec();
        Ok(match positions {
            Positions::Single(array) => Self { positions: rows(array, "vertices")?.to_vec(), faces, double: None },
            Positions::Double(array) => {
                let exact: Vec<[f64; 3]> = rows(array, "vertices")?.to_vec();
                let mut mean = [0.0; 3];
                for p in faces.iter().flatten().filter_map(|&v| exact.get(v as usize)) {
                    (0..3).for_each(|k| mean[k] += p[k] / (3 * faces.len()) as f64);
                }
                let shift = |p: &[f64; 3]| [0, 1, 2].map(|k| (p[k] - mean[k]) as f32);
                Self {
                    positions: exact.iter().map(shift).collect(),
                    faces,
                    double: Some(DoublePositions { center: mean, exact }),
                }
            }
        })
    }

    /// Returns the lighter mesh, if the mesh is clean and the merges reach the size.
    fn simplify(&self, task: Task, n_threads: usize, listener: Option<PassListener>) -> Option<Lighter> {
        let start = Instant::now();
        let used = self.list_clean(task.welds)?;
        let is_of_faces = task.size.is_of_faces();
        let n = if is_of_faces { self.faces.len() } else { used.len() };
        let count = task.size.count(n);
        if count >= n {
            return None;
        }
        let size = if is_of_faces { CollapseSize::Faces(count) } else { CollapseSize::Vertices(count) };
        let mut options = CollapseOptions::default();
        (options.n_fit_steps, options.n_threads) = (task.n_fit_steps, n_threads);
        (options.locks_boundaries, options.cuts) = (task.locks_boundaries, false);
        options.listener = listener;
        let result = self.collapse_used(&used, size, &options)?;
        let is_whole = result.outcome == CollapseOutcome::Reached && !result.faces.is_empty();
        let exact = self.double.as_ref().map(|double| self.place_exactly(double, &result));
        let (n_input, seconds) = (self.positions.len(), start.elapsed().as_secs_f64());
        let n_threads = if n_threads == 0 { rayon::current_num_threads() } else { n_threads };
        is_whole.then_some(Lighter { result, exact, used, n_input, n_threads, seconds })
    }

    /// Simplifies the vertices that have a face, so that others change nothing.
    fn collapse_used(&self, used: &[u32], size: CollapseSize, options: &CollapseOptions) -> Option<CollapseResult> {
        if used.len() == self.positions.len() {
            return collapse(&self.positions, &self.faces, size, options).ok();
        }
        let mut numbers = vec![0; self.positions.len()];
        for (number, &v) in used.iter().enumerate() {
            numbers[v as usize] = number as u32;
        }
        let positions: Vec<[f32; 3]> = used.iter().map(|&v| self.positions[v as usize]).collect();
        let faces: Vec<[u32; 3]> = self.faces.iter().map(|face| face.map(|v| numbers[v as usize])).collect();
        let mut result = collapse(&positions, &faces, size, options).ok()?;
        result.origins.iter_mut().for_each(|origin| *origin = used[*origin as usize]);
        Some(result)
    }

    /// Returns the vertices that have a face, if nothing else is to be cleaned.
    fn list_clean(&self, welds: bool) -> Option<Vec<u32>> {
        let n = self.positions.len();
        let mut is_used = vec![false; n];
        for &[a, b, c] in &self.faces {
            if a == b || b == c || c == a || a.max(b).max(c) as usize >= n {
                return None;
            }
            for v in [a, b, c] {
                is_used[v as usize] = true;
            }
        }
        let has_copies = welds && weld(&self.positions).iter().zip(0..).any(|(&first, v)| first != v);
        (!has_copies).then(|| (0..n as u32).filter(|&v| is_used[v as usize]).collect())
    }

    /// Returns positions of double precision: those of the input where a vertex has not moved.
    fn place_exactly(&self, double: &DoublePositions, result: &CollapseResult) -> Vec<[f64; 3]> {
        let place = |(position, &origin): (&[f32; 3], &u32)| {
            if *position == self.positions[origin as usize] {
                return double.exact[origin as usize];
            }
            [0, 1, 2].map(|k| double.center[k] + f64::from(position[k]))
        };
        result.positions.iter().zip(&result.origins).map(place).collect()
    }
}

impl Lighter {
    /// Returns the result's vertex that each of the input's became; `u32::MAX` for one without a face.
    fn list_became(&self) -> Vec<u32> {
        let mut became = vec![u32::MAX; self.n_input];
        let record = &self.result.record;
        for (&v, number) in self.used.iter().zip(record.vertices_after(record.n_passes())) {
            became[v as usize] = number;
        }
        became
    }

    fn convert(self, py: Python, target: Py<PyAny>, keeps_merges: bool) -> PyResult<PlainResult> {
        let n_used = self.used.len();
        let became = keeps_merges.then(|| indices(py, self.list_became())).transpose()?;
        let Self { result, exact, n_threads, seconds, .. } = self;
        let vertices = match exact {
            Some(exact) => array(py, exact)?,
            None => array(py, result.positions)?,
        };
        Ok(PlainResult {
            vertices,
            faces: triples(py, result.faces)?,
            n_used,
            threads: n_threads,
            error: f64::from(result.error),
            seconds,
            target,
            origins: indices(py, result.origins)?,
            became,
        })
    }
}
