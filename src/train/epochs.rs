//! The training loop: epochs of steps, table rows, validation, checkpoints.

use super::adam::{adam_step, clip_gradients, gradient_norm};
use super::augment::augment_mesh;
use super::csv_table::quote_field;
use super::event::{Ending, TrainEvent, Wish};
use super::random::{log_uniform, shuffle_indices};
use super::validation::{Validation, measure_validation};
use super::{Settings, StepFunction, StepResult, TrainError, TrainingItem, TrainingMesh, TrainingRun};

/// Trains until all epochs are done or `progress` asks to stop.
///
/// Each epoch visits the meshes once in random order, one Adam step each, then measures the validation. Writes `steps.csv`,
/// `epochs.csv`, `best.safetensors` and `last.safetensors`.
///
/// # Errors
/// [`TrainError::Diverged`] if a loss or gradient is not finite or explodes; [`TrainError::File`], [`TrainError::Step`].
///
/// ```
/// use neural_mesh::train::{Ending, TrainRequest, Wish, open, step_function, train};
/// let folder = tempfile::tempdir().unwrap();
/// std::fs::write(folder.path().join("mesh.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 3 4\n").unwrap();
/// let (data, run) = (folder.path(), folder.path().join("run"));
/// let mut request = TrainRequest::new(data, &run);
/// (request.objective, request.epochs) = (Some("bending"), Some(2));
/// let mut run = open(&request).unwrap();
/// let step = step_function(&run.settings).unwrap();
/// assert_eq!(train(&mut run, &step, &mut |_| Wish::Continue), Ok(Ending::Finished));
/// assert_eq!(run.position(), (2, 0));
/// ```
pub fn train(
    run: &mut TrainingRun,
    step: &StepFunction,
    progress: &mut dyn FnMut(TrainEvent) -> Wish,
) -> Result<Ending, TrainError> {
    while run.state.position.epoch < run.settings.epochs {
        begin_epoch(run);
        while run.state.position.n_done < run.state.position.order.len() {
            if train_on_mesh(run, step, progress)? == Ending::Stopped {
                return Ok(Ending::Stopped);
            }
        }
        check_mesh_was_used(run)?;
        let validation = match measure_validation(run, step, progress)? {
            Validation::Means(means) => Some(means),
            Validation::Nothing => None,
            Validation::Stopped => {
                run.save()?;
                return Ok(Ending::Stopped);
            }
        };
        let event = end_epoch(run, validation.as_deref())?;
        run.save()?;
        if matches!(progress(event), Wish::Stop | Wish::Abandon) && run.state.position.epoch < run.settings.epochs {
            return Ok(Ending::Stopped);
        }
    }
    run.write_weights("last.safetensors")?;
    Ok(Ending::Finished)
}

fn begin_epoch(run: &mut TrainingRun) {
    let position = &mut run.state.position;
    if position.order.is_empty() {
        position.order = shuffle_indices(&mut position.random, run.data.training.len());
        position.sums = vec![0.0; position.names.len()];
        (position.n_done, position.n_summed) = (0, 0);
    }
}

fn check_mesh_was_used(run: &TrainingRun) -> Result<(), TrainError> {
    match run.state.position.n_summed {
        0 => Err(TrainError::Step("no mesh of this epoch could be used: see the reason for each mesh".into())),
        _ => Ok(()),
    }
}

fn train_on_mesh(
    run: &mut TrainingRun,
    step: &StepFunction,
    progress: &mut dyn FnMut(TrainEvent) -> Wish,
) -> Result<Ending, TrainError> {
    let position = &run.state.position;
    let (epoch, n_steps) = (position.epoch, position.order.len());
    let mesh = position.order.get(position.n_done).and_then(|&at| run.data.training.get(at as usize));
    let mesh = mesh.ok_or(TrainError::Differs("the number of meshes".into()))?.clone();
    let made = make_step(run, &mesh, step)?;
    run.state.position.n_done += 1;
    let n_done = run.state.position.n_done;
    let wish = match &made {
        Ok(terms) => progress(TrainEvent::Step { epoch, n_done, n_steps, terms }),
        Err(why) => progress(TrainEvent::Skipped { mesh: &mesh.name, why }),
    };
    if matches!(wish, Wish::Checkpoint | Wish::Stop) {
        run.save()?;
    }
    Ok(if matches!(wish, Wish::Stop | Wish::Abandon) { Ending::Stopped } else { Ending::Finished })
}

/// Loss terms of a step by name, or the reason why its mesh was skipped.
type StepOutcome = Result<Vec<(&'static str, f64)>, String>;

fn make_step(run: &mut TrainingRun, mesh: &TrainingMesh, step: &StepFunction) -> Result<StepOutcome, TrainError> {
    let (settings, state) = (&run.settings, &mut run.state);
    state.position.step += 1;
    let random = &mut state.position.random;
    // The step number and the random state advance even if the mesh is skipped.
    let ratio = log_uniform(random, settings.ratio_min, settings.ratio_max);
    let item = match augment_mesh(&mesh.mesh, settings, random) {
        Ok(changed) => TrainingItem { name: mesh.name.clone(), mesh: changed, ratio },
        Err(why) => return Ok(Err(why.to_string())),
    };
    let found = match step(&state.tensors, &item, settings, random) {
        Ok(found) => found,
        Err(why) => return Ok(Err(why)),
    };
    let diverged = |number: u64, what: String| TrainError::Diverged { step: number, mesh: mesh.name.clone(), what };
    // A loss that is not finite or explodes ends the training before the weights change.
    if let Some(what) = state.position.watch.find_trouble(&found, settings.explosion) {
        return Err(diverged(state.position.step, what));
    }
    let norm = gradient_norm(&found.gradients);
    let learning_rate = learning_rate(settings, state.position.epoch);
    note_step(run, &item, &found, norm, learning_rate)?;
    let (settings, state) = (&run.settings, &mut run.state);
    let StepResult { terms, gradients } = found;
    let gradients = clip_gradients(gradients, norm, settings.gradient_clip);
    let tensors = adam_step(&state.tensors, &gradients, &mut state.moments, settings, learning_rate);
    let checked = tensors.check_shapes(&state.tensors.map(|_, matrix| matrix.shape()));
    state.tensors = checked.map_err(|error| diverged(state.position.step, error.to_string()))?;
    Ok(Ok(terms))
}

fn learning_rate(settings: &Settings, epoch: usize) -> f64 {
    settings.learning_rate * settings.learning_rate_decay.powi(epoch as i32)
}

fn note_step(
    run: &mut TrainingRun,
    item: &TrainingItem,
    found: &StepResult,
    norm: f64,
    learning_rate: f64,
) -> Result<(), TrainError> {
    name_terms(run, found)?;
    let position = &mut run.state.position;
    position.sums.iter_mut().zip(&found.terms).for_each(|(sum, (_, value))| *sum += value);
    position.n_summed += 1;
    let mut row = vec![(position.epoch + 1).to_string(), position.step.to_string(), quote_field(&item.name)];
    let values = found.terms.iter().map(|(_, value)| *value).chain([found.total(), norm, learning_rate]);
    row.extend([item.ratio].into_iter().chain(values).map(|value| value.to_string()));
    run.steps.push(&row)
}

fn name_terms(run: &mut TrainingRun, found: &StepResult) -> Result<(), TrainError> {
    let position = &mut run.state.position;
    let names: Vec<String> = found.terms.iter().map(|(name, _)| name.to_string()).collect();
    if position.names.is_empty() {
        position.sums = vec![0.0; names.len()];
        position.names = names;
        return run.steps.push(&columns(
            &position.names,
            &["epoch", "step", "mesh", "ratio"],
            "",
            &["total", "gradient_norm", "learning_rate"],
        ));
    }
    if position.names == names {
        return Ok(());
    }
    Err(TrainError::Step(format!(
        "its loss has the terms {}, but earlier steps had {}: return equal terms in all steps",
        names.join(", "),
        position.names.join(", ")
    )))
}

fn columns(names: &[String], before: &[&str], prefix: &str, after: &[&str]) -> Vec<String> {
    let names = names.iter().map(|name| format!("{prefix}{name}"));
    let fixed = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
    fixed(before).into_iter().chain(names).chain(fixed(after)).collect()
}

fn end_epoch(run: &mut TrainingRun, validation: Option<&[f64]>) -> Result<TrainEvent<'static>, TrainError> {
    let position = &mut run.state.position;
    let training: Vec<f64> = position.sums.iter().map(|sum| sum / position.n_summed as f64).collect();
    let totals = [Some(&training[..]), validation].map(|terms| terms.map(|terms| terms.iter().sum::<f64>()));
    let judged = totals[1].or(totals[0]);
    let is_best = position.best.is_none_or(|best| judged.is_some_and(|total| total < best));
    if is_best {
        position.best = judged;
        run.write_weights("best.safetensors")?;
    }
    note_epoch(run, &training, validation)?;
    let position = &mut run.state.position;
    position.epoch += 1;
    (position.order, position.n_done) = (Vec::new(), 0);
    Ok(TrainEvent::Epoch {
        n_done: position.epoch,
        training: totals[0].unwrap_or(f64::NAN),
        validation: totals[1],
        is_best,
    })
}

fn note_epoch(run: &mut TrainingRun, training: &[f64], validation: Option<&[f64]>) -> Result<(), TrainError> {
    let position = &run.state.position;
    if position.epoch == 0 {
        let columns = [
            columns(&position.names, &["epoch", "learning_rate", "steps"], "train_", &["train_total"]),
            columns(&position.names, &[], "validation_", &["validation_total"]),
        ];
        run.epochs.push(&columns.concat())?;
    }
    let with_total = |terms: &[f64]| terms.iter().chain([&terms.iter().sum()]).map(f64::to_string).collect();
    let nothing = || vec![String::new(); training.len() + 1];
    let learning_rate = learning_rate(&run.settings, position.epoch);
    let mut row = vec![(position.epoch + 1).to_string(), learning_rate.to_string(), position.n_summed.to_string()];
    row.extend::<Vec<String>>(with_total(training));
    row.extend(validation.map_or_else(nothing, with_total));
    run.epochs.push(&row)
}
