//! Learning with a Python function as objective.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};

use neural_mesh::autodiff::Tensors;
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::simplify::WeightedResult;
use neural_mesh::train::{
    CustomObjective, Ending, Errors, OWN_OBJECTIVE, Settings, TrainError, TrainEvent, TrainRequest, TrainingItem,
    TrainingRun, Wish, estimate_gradient, open, step_from_objective, step_function, train as run_training,
};
use neural_mesh_cli::embedded::Failure;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

use crate::arrays::{array, indices, numbers, sequence, triples};
use crate::background::{ProgressChannel, TICK, lock, run_in_background};
use crate::failure::invalid_array;
use crate::mesh_arrays::MeshArrays;

/// Python function that judges results.
///
/// Maps `(name, ratio, vertices, faces, result vertices, result faces, vertex_of)` to one number, or to one per vertex
/// or face of the original.
struct Judge {
    function: Py<PyAny>,
    raised: RaisedError,
    channel: ProgressChannel,
    origin: [f64; 3],
}

#[derive(Clone, Default)]
struct RaisedError(Arc<Mutex<Option<PyErr>>>);

impl RaisedError {
    fn keep(&self, error: PyErr) {
        lock(&self.0).get_or_insert(error);
    }

    fn is_set(&self) -> bool {
        lock(&self.0).is_some()
    }

    fn error_or<T>(&self, done: PyResult<T>) -> PyResult<T> {
        lock(&self.0).take().map_or(done, Err)
    }
}

impl Judge {
    fn errors(&self, name: &str, ratio: f64, original: &TriMesh, result: &WeightedResult) -> Result<Errors, String> {
        if self.channel.check_cancelled().is_break() || self.raised.is_set() {
            return Err("is cancelled".into());
        }
        // While Python shuts down, its functions can no longer be called.
        let called = Python::try_attach(|py| self.call(py, name, ratio, original, result));
        let values = called.unwrap_or_else(|| Err(invalid_array("Python is ending"))).map_err(|error| {
            self.raised.keep(error);
            "the objective raised an exception".to_string()
        })?;
        let (n_vertices, n_faces) = (original.positions().len(), original.faces().len());
        match values.len() {
            1 => Ok(Errors::Whole(values[0])),
            n if n == n_vertices => Ok(Errors::Vertices(values)),
            n if n == n_faces => Ok(Errors::Faces(values)),
            n => {
                let due = format!("one number, {n_vertices} (vertices) or {n_faces} (faces of the original)");
                self.raised.keep(invalid_array(format!("the objective returned {n} numbers: return {due}")));
                Err("the objective returned a wrong number of values".into())
            }
        }
    }

    fn call(
        &self,
        py: Python,
        name: &str,
        ratio: f64,
        original: &TriMesh,
        result: &WeightedResult,
    ) -> PyResult<Vec<f64>> {
        let positions = |mesh: &TriMesh| {
            let to_file = |p: &[f32; 3]| std::array::from_fn(|axis| f64::from(p[axis]) + self.origin[axis]);
            array::<f64, 3>(py, mesh.positions().iter().map(to_file).collect())
        };
        let faces = |mesh: &TriMesh| triples(py, mesh.faces().to_vec());
        let vertex_of = indices(py, result.vertex_of.clone())?;
        let mesh = &result.mesh;
        let arguments =
            (name, ratio, positions(original)?, faces(original)?, positions(mesh)?, faces(mesh)?, vertex_of);
        let values = self.function.call1(py, arguments)?;
        let values: PyReadonlyArray1<f64> = values.extract(py)?;
        Ok(numbers(&values, "errors")?.to_vec())
    }
}

/// Training request: data folder, output folder, settings (TOML), objective, epochs, and whether to resume.
type TrainArguments = (String, String, Option<String>, Option<String>, Option<usize>, bool);

/// Trains weights on a folder of meshes and returns whether all epochs are done.
///
/// `judge` is a custom objective; `init` are initial weights, "default" for those of the library.
#[pyfunction]
#[pyo3(signature = (arguments, judge, init, threads, progress))]
pub fn train(
    py: Python,
    arguments: TrainArguments,
    judge: Option<Py<PyAny>>,
    init: Option<Vec<u8>>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<bool> {
    let raised = RaisedError::default();
    let (alive, ended) = channel::<()>();
    let raised_in_work = raised.clone();
    let done = run_in_background(py, threads, None, move |channel| {
        // The sender is dropped when the work ends, with or without an error.
        let _alive = alive;
        let judge = judge.map(|function| Judge {
            function,
            raised: raised_in_work.clone(),
            channel: channel.clone(),
            origin: [0.0; 3],
        });
        let on_event = |event: TrainEvent| next_wish(&event, progress.as_ref(), &raised_in_work, channel);
        run_request(&arguments, judge, init, on_event)
    });
    if done.is_err() {
        // The current step ends with a checkpoint, from which the next call continues.
        let ended = Mutex::new(ended);
        while py.detach(|| lock(&ended).recv_timeout(TICK)) == Err(RecvTimeoutError::Timeout) {
            py.check_signals()?;
        }
    }
    raised.error_or(done)
}

fn run_request(
    arguments: &TrainArguments,
    judge: Option<Judge>,
    init: Option<Vec<u8>>,
    mut on_event: impl FnMut(TrainEvent) -> Wish,
) -> Result<bool, Failure> {
    let failed = |error: TrainError| Failure::Failed(error.to_string());
    let (data, folder, settings, objective, epochs, resume) = arguments;
    let mut request = TrainRequest::new(data.as_ref(), folder.as_ref());
    request.settings = settings.as_deref();
    request.objective = if judge.is_some() { Some(OWN_OBJECTIVE) } else { objective.as_deref() };
    request.epochs = *epochs;
    request.resume = *resume;
    request.init = init.as_deref();
    let mut run = open(&request).map_err(failed)?;
    let mut passed_over = None;
    let mut on_event_with_reason = |event: TrainEvent| {
        if let TrainEvent::Skipped { mesh, why } = event {
            passed_over.get_or_insert_with(|| format!(" ({mesh}: {why})"));
        }
        on_event(event)
    };
    let ending = run_steps(&mut run, judge, &mut on_event_with_reason);
    let reason = passed_over.unwrap_or_default();
    Ok(ending.map_err(|error| Failure::Failed(format!("{error}{reason}")))? == Ending::Finished)
}

fn run_steps(
    run: &mut TrainingRun,
    judge: Option<Judge>,
    on_event: &mut dyn FnMut(TrainEvent) -> Wish,
) -> Result<Ending, TrainError> {
    let Some(judge) = judge else {
        let step = step_function(&run.settings)?;
        return run_training(run, &step, on_event);
    };
    let step = |tensors: &Tensors<Arc<Matrix>>, item: &TrainingItem, settings: &Settings, random: &mut _| {
        let own = CustomObjective(|original: &TriMesh, result: &WeightedResult| {
            judge.errors(&item.name, item.ratio, original, result)
        });
        step_from_objective(&own)(tensors, item, settings, random)
    };
    run_training(run, &step, on_event)
}

/// Event for Python: kind, the counts of a [`TrainEvent`] or 0, and numbers by name.
type EventTuple = (&'static str, usize, usize, usize, Vec<(String, f64)>);

fn to_tuple(event: &TrainEvent) -> Option<EventTuple> {
    let named = |values: Vec<(&str, Option<f64>)>| {
        values.into_iter().filter_map(|(name, value)| Some((name.to_string(), value?))).collect()
    };
    match event {
        TrainEvent::Step { epoch, n_done, n_steps, terms } => {
            let terms = terms.iter().map(|(name, value)| (*name, Some(*value))).collect();
            Some(("step", *epoch, *n_done, *n_steps, named(terms)))
        }
        TrainEvent::Epoch { n_done, training, validation, is_best } => {
            let best = f64::from(u8::from(*is_best));
            let values = vec![("training", Some(*training)), ("validation", *validation), ("is_best", Some(best))];
            Some(("epoch", *n_done, 0, 0, named(values)))
        }
        _ => None,
    }
}

fn next_wish(
    event: &TrainEvent,
    progress: Option<&Py<PyAny>>,
    raised: &RaisedError,
    channel: &ProgressChannel,
) -> Wish {
    let (tuple, is_step) = (to_tuple(event), matches!(event, TrainEvent::Step { .. }));
    if let (Some(tuple), Some(progress)) = (tuple, progress) {
        let called = Python::try_attach(|py| progress.call1(py, tuple));
        if let Some(Err(error)) = called {
            raised.keep(error);
        }
    }
    match (channel.check_cancelled().is_break() || raised.is_set(), is_step) {
        // A mesh whose judgement was cancelled counts as skipped; the run resumes before it, to judge it again.
        (true, false) => Wish::Abandon,
        (true, true) => Wish::Stop,
        // A checkpoint follows each step, since it costs little compared with a step's simplifications.
        (false, _) => Wish::Checkpoint,
    }
}

/// Estimates the mean error of results, its gradient by the scores, and the gradient's variance, n_given each.
#[pyfunction]
#[pyo3(signature = (mesh, scores, ratio, judge, settings, seed, threads))]
#[allow(clippy::too_many_arguments)]
pub fn estimate(
    py: Python,
    mesh: MeshArrays,
    scores: PyReadonlyArray1<f32>,
    ratio: f64,
    judge: Py<PyAny>,
    settings: &str,
    seed: u64,
    threads: Option<usize>,
) -> PyResult<(f64, Py<PyAny>, Py<PyAny>)> {
    let raw = mesh.read()?.mesh;
    let n_given = raw.positions.len();
    let scores = numbers(&scores, "scores")?.to_vec();
    if scores.len() != n_given {
        let n = scores.len();
        return Err(invalid_array(format!("scores: {n} numbers for {n_given} vertices: give one for each")));
    }
    let settings = Settings::from_toml(settings).map_err(|error| invalid_array(error.to_string()))?;
    let raised = RaisedError::default();
    let raised_in_work = raised.clone();
    let done = run_in_background(py, threads, None, move |channel| {
        let failed = |what: String| Failure::Failed(what);
        let cleaned = clean(raw, &CleanOptions::default()).map_err(|error| failed(error.to_string()))?;
        let judge =
            Judge { function: judge, raised: raised_in_work, channel: channel.clone(), origin: cleaned.frame.origin };
        let own = CustomObjective(|mesh: &TriMesh, result: &WeightedResult| judge.errors("mesh", ratio, mesh, result));
        let scores: Vec<f32> = cleaned.source.iter().map(|&v| scores[v as usize]).collect();
        let n_output = (cleaned.mesh.positions().len() as f64 * ratio).round().max(1.0) as usize;
        let found = estimate_gradient(&own, &cleaned.mesh, &scores, n_output, &settings, seed).map_err(failed)?;
        Ok((found, cleaned.source))
    });
    let (found, sources) = raised.error_or(done)?;
    // The terms sum to the logarithm of the mean error.
    let mean = found.terms.iter().map(|(_, value)| value).sum::<f64>().exp();
    let to_input_vertices = |values: &[f64], factor: f64| {
        let mut input_values = vec![0.0f64; n_given];
        sources.iter().zip(values).for_each(|(&v, value)| input_values[v as usize] = factor * value);
        sequence(py, input_values)
    };
    Ok((mean, to_input_vertices(&found.gradient, mean), to_input_vertices(&found.variance, mean * mean)))
}
