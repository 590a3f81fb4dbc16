//! The loop of a training: epochs over steps, a row for each, validation, checkpoints.

use super::adam::{adam_step, clipped, gradient_norm};
use super::augment::augmented;
use super::event::{Ending, Event, Wish};
use super::random::{log_uniform, shuffled};
use super::rows::quoted;
use super::validation::{Validation, validated};
use super::{Item, Mesh, Run, Settings, Step, StepFunction, TrainError};

/// Trains until all epochs are done, or until `progress` wishes to stop.
///
/// Each epoch goes once through the meshes in a new order, one Adam step per mesh, then measures the validation.
/// `steps.csv` and `epochs.csv` get their rows, `best.safetensors` and `last.safetensors` their weights. From any
/// checkpoint the same `step` goes on to the same bits.
///
/// # Errors
/// [`TrainError::Diverged`] where a loss or gradient is not finite or explodes; the last checkpoint is untouched.
/// [`TrainError::File`] where something cannot be written, [`TrainError::Step`] where the terms change their names.
///
/// ```
/// use neural_mesh::train::{Ending, Request, Wish, open, step_function, train};
/// let folder = tempfile::tempdir().unwrap();
/// std::fs::write(folder.path().join("mesh.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 2 3 4\n").unwrap();
/// let (data, run) = (folder.path(), folder.path().join("run"));
/// let mut request = Request::new(data, &run);
/// (request.objective, request.epochs) = (Some("uniform"), Some(2));
/// let mut run = open(&request).unwrap();
/// let step = step_function(&run.settings).unwrap();
/// assert_eq!(train(&mut run, &step, &mut |_| Wish::Continue), Ok(Ending::Finished));
/// assert_eq!(run.position(), (2, 0));
/// ```
pub fn train(
    run: &mut Run,
    step: &StepFunction,
    progress: &mut dyn FnMut(Event) -> Wish,
) -> Result<Ending, TrainError> {
    while run.state.position.epoch < run.settings.epochs {
        begin_epoch(run);
        while run.state.position.n_done < run.state.position.order.len() {
            if one_mesh(run, step, progress)? == Ending::Stopped {
                return Ok(Ending::Stopped);
            }
        }
        check_something_was_learned(run)?;
        let validation = match validated(run, step, progress)? {
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

/// Draws the order of an epoch that has none yet.
fn begin_epoch(run: &mut Run) {
    let position = &mut run.state.position;
    if position.order.is_empty() {
        position.order = shuffled(&mut position.random, run.data.training.len());
        position.sums = vec![0.0; position.names.len()];
        (position.n_done, position.n_summed) = (0, 0);
    }
}

/// Refuses to go on where not one mesh of an epoch could be used.
fn check_something_was_learned(run: &Run) -> Result<(), TrainError> {
    match run.state.position.n_summed {
        0 => Err(TrainError::Step("no mesh of this epoch could be used: look at the reasons given for each".into())),
        _ => Ok(()),
    }
}

/// The step of the next mesh, and what the caller wishes then.
fn one_mesh(run: &mut Run, step: &StepFunction, progress: &mut dyn FnMut(Event) -> Wish) -> Result<Ending, TrainError> {
    let position = &run.state.position;
    let (epoch, n_steps) = (position.epoch, position.order.len());
    let mesh = position.order.get(position.n_done).and_then(|&at| run.data.training.get(at as usize));
    let mesh = mesh.ok_or(TrainError::Differs("the number of meshes".into()))?.clone();
    let made = one_step(run, &mesh, step)?;
    run.state.position.n_done += 1;
    let n_done = run.state.position.n_done;
    let wish = match &made {
        Ok(terms) => progress(Event::Step { epoch, n_done, n_steps, terms }),
        Err(why) => progress(Event::PassedOver { mesh: &mesh.name, why }),
    };
    if matches!(wish, Wish::Checkpoint | Wish::Stop) {
        run.save()?;
    }
    Ok(if matches!(wish, Wish::Stop | Wish::Abandon) { Ending::Stopped } else { Ending::Finished })
}

/// What a step is told by: its terms, or why there was none.
type Made = Result<Vec<(&'static str, f64)>, String>;

fn one_step(run: &mut Run, mesh: &Mesh, step: &StepFunction) -> Result<Made, TrainError> {
    let (settings, state) = (&run.settings, &mut run.state);
    state.position.step += 1;
    let random = &mut state.position.random;
    let ratio = log_uniform(random, settings.ratio_min, settings.ratio_max);
    let item = match augmented(&mesh.mesh, settings, random) {
        Ok(changed) => Item { name: mesh.name.clone(), mesh: changed, ratio },
        Err(why) => return Ok(Err(why.to_string())),
    };
    let found = match step(&state.tensors, &item, settings, random) {
        Ok(found) => found,
        Err(why) => return Ok(Err(why)),
    };
    let diverged = |number: u64, what: String| TrainError::Diverged { step: number, mesh: mesh.name.clone(), what };
    if let Some(what) = state.position.watch.trouble(&found, settings.explosion) {
        return Err(diverged(state.position.step, what));
    }
    let norm = gradient_norm(&found.gradients);
    let learning_rate = learning_rate(settings, state.position.epoch);
    note_step(run, &item, &found, norm, learning_rate)?;
    let (settings, state) = (&run.settings, &mut run.state);
    let Step { terms, gradients } = found;
    let gradients = clipped(gradients, norm, settings.gradient_clip);
    let tensors = adam_step(&state.tensors, &gradients, &mut state.moments, settings, learning_rate);
    let checked = tensors.checked(&state.tensors.map(|_, matrix| matrix.shape()));
    state.tensors = checked.map_err(|error| diverged(state.position.step, error.to_string()))?;
    Ok(Ok(terms))
}

/// The learning rate of an epoch, counted from 0.
fn learning_rate(settings: &Settings, epoch: usize) -> f64 {
    settings.learning_rate * settings.learning_rate_decay.powi(epoch as i32)
}

/// Adds a step to the sums of its epoch and to the table.
fn note_step(run: &mut Run, item: &Item, found: &Step, norm: f64, learning_rate: f64) -> Result<(), TrainError> {
    name_terms(run, found)?;
    let position = &mut run.state.position;
    position.sums.iter_mut().zip(&found.terms).for_each(|(sum, (_, value))| *sum += value);
    position.n_summed += 1;
    let mut row = vec![(position.epoch + 1).to_string(), position.step.to_string(), quoted(&item.name)];
    let values = found.terms.iter().map(|(_, value)| *value).chain([found.total(), norm, learning_rate]);
    row.extend([item.ratio].into_iter().chain(values).map(|value| value.to_string()));
    run.steps.push(&row)
}

/// The first step names the terms, and with them the columns; the others have to follow.
fn name_terms(run: &mut Run, found: &Step) -> Result<(), TrainError> {
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
    Err(TrainError::Step(format!("its terms are {}, they were {}", names.join(", "), position.names.join(", "))))
}

fn columns(names: &[String], before: &[&str], prefix: &str, after: &[&str]) -> Vec<String> {
    let names = names.iter().map(|name| format!("{prefix}{name}"));
    let fixed = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
    fixed(before).into_iter().chain(names).chain(fixed(after)).collect()
}

/// Writes down an epoch, keeps its weights where they are the best so far, and moves on to the next.
fn end_epoch(run: &mut Run, validation: Option<&[f64]>) -> Result<Event<'static>, TrainError> {
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
    Ok(Event::Epoch { n_done: position.epoch, training: totals[0].unwrap_or(f64::NAN), validation: totals[1], is_best })
}

/// Adds an epoch to the table: terms and totals of training and validation; fields are empty without validation.
fn note_epoch(run: &mut Run, training: &[f64], validation: Option<&[f64]>) -> Result<(), TrainError> {
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
