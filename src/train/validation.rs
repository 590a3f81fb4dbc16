//! Validation: losses of the step function on unchanged meshes at fixed ratios.

use super::event::{TrainEvent, Wish};
use super::{StepFunction, StepResult, TrainError, TrainingItem, TrainingRun};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

pub(super) enum Validation {
    /// Means of the loss terms over all meshes and ratios.
    Means(Vec<f64>),
    /// No mesh could be measured.
    Nothing,
    Stopped,
}

/// Measures the current weights; each mesh has a fixed random state, so that epochs are comparable.
pub(super) fn measure_validation(
    run: &mut TrainingRun,
    step: &StepFunction,
    progress: &mut dyn FnMut(TrainEvent) -> Wish,
) -> Result<Validation, TrainError> {
    let mut sums = vec![0.0; run.state.position.names.len()];
    let (mut n_summed, n_meshes) = (0, run.data.validation.len());
    for at in 0..n_meshes {
        for found in measure_mesh(run, at, step)? {
            sums.iter_mut().zip(&found.terms).for_each(|(sum, (_, value))| *sum += value);
            n_summed += 1;
        }
        match progress(TrainEvent::Validated { epoch: run.state.position.epoch, n_done: at + 1, n_meshes }) {
            Wish::Continue => {}
            Wish::Checkpoint => run.save()?,
            Wish::Stop | Wish::Abandon => return Ok(Validation::Stopped),
        }
    }
    Ok(match n_summed {
        0 => Validation::Nothing,
        n => Validation::Means(sums.iter().map(|sum| sum / f64::from(n)).collect()),
    })
}

fn measure_mesh(run: &TrainingRun, at: usize, step: &StepFunction) -> Result<Vec<StepResult>, TrainError> {
    let mesh = &run.data.validation[at];
    let random = Xoshiro256PlusPlus::seed_from_u64(run.settings.seed.wrapping_add(at as u64));
    let at_ratio = |&ratio: &f64| {
        let item = TrainingItem { name: mesh.name.clone(), mesh: mesh.mesh.clone(), ratio };
        step(&run.state.tensors, &item, &run.settings, &mut random.clone()).ok()
    };
    let found: Vec<StepResult> = run.settings.validation_ratios.iter().filter_map(at_ratio).collect();
    let mut terms = found.iter().flat_map(|step| &step.terms);
    match terms.find(|(_, value)| !value.is_finite()) {
        None => Ok(found),
        Some((name, value)) => {
            let what = format!("the term `{name}` is {value} in the validation");
            Err(TrainError::Diverged { step: run.state.position.step, mesh: mesh.name.clone(), what })
        }
    }
}
