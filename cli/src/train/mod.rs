//! `neural-mesh train`: trains, shows progress, draws the curves.

mod args;
mod curves;
mod progress;

use std::path::Path;

use neural_mesh::train::{
    Ending, OBJECTIVES, OwnNetwork, StepFunction, TrainError, TrainRequest, TrainingRun, open, step_function, train,
};

use crate::failure::{Failure, name};
use crate::files;
use crate::simplify::in_pool;
use crate::stopping;
use crate::words::{Voice, complain};
pub use args::TrainArgs;
use progress::TrainProgress;

/// Network other than the paper's, and its training step.
pub struct OtherNetwork<'a> {
    /// Value of the setting `objective`.
    pub objective: &'a str,
    /// Architecture of the network.
    pub network: &'a OwnNetwork,
    /// Creates the training step.
    pub step: &'a (dyn Fn() -> Box<StepFunction<'static>> + Sync),
}

pub fn run(args: &TrainArgs) -> Result<(), Failure> {
    run_for(args, None)
}

/// Trains the paper's network or another one.
pub fn run_for(args: &TrainArgs, other: Option<&OtherNetwork>) -> Result<(), Failure> {
    match (&args.plot, &args.data, &args.out) {
        (Some(folder), _, _) => plot(folder, voice(args)),
        (None, Some(data), Some(out)) => {
            stopping::watch_for_a_good_end();
            in_pool(args.threads, || learn((args, other), data, out))
        }
        _ => Err(Failure::Usage(
            "--data and --out are missing: give a folder of meshes to --data, and a folder for the results to --out"
                .into(),
        )),
    }
}

fn learn((args, other): (&TrainArgs, Option<&OtherNetwork>), data: &Path, out: &Path) -> Result<(), Failure> {
    let settings = args.config.as_deref().map(read_text).transpose()?;
    let init = args.init.as_deref().map(files::read).transpose()?;
    let mut request = TrainRequest::new(data, out);
    request.settings = settings.as_deref();
    request.objective = other.map(|other| other.objective).or(args.objective.as_deref());
    request.network = other.map(|other| other.network);
    request.epochs = args.epochs;
    request.resume = args.resume;
    request.init = init.as_deref();
    let mut run = open(&request).map_err(|error| to_failure(error, args))?;
    let step = match other {
        Some(other) => (other.step)(),
        None => step_function(&run.settings).map_err(|error| to_failure(error, args))?,
    };
    say_what_is_there(&run, voice(args));
    let mut progress = TrainProgress::new(&run, voice(args));
    let ending = train(&mut run, &step, &mut |event| progress.handle(event));
    drop(progress);
    match ending.map_err(|error| to_failure(error, args))? {
        Ending::Finished => {
            // The weights are saved, so a failed picture does not make the training fail.
            if let Err(failure) = plot(out, voice(args)) {
                complain(&Failure::Failed(format!("the training is done, but its curves are not drawn: {failure}")));
            }
            Ok(())
        }
        Ending::Stopped => Err(interruption(&run)),
    }
}

fn voice(args: &TrainArgs) -> Voice {
    if args.quiet { Voice::Quiet } else { Voice::Out }
}

fn read_text(path: &Path) -> Result<String, Failure> {
    String::from_utf8(files::read(path)?).map_err(|_| Failure::in_file(path, "is not UTF-8: save it as UTF-8"))
}

/// Converts an error of the training; errors in settings name the settings file.
fn to_failure(error: TrainError, args: &TrainArgs) -> Failure {
    match (&error, &args.config) {
        (TrainError::Settings(what), Some(path)) => Failure::in_file(path, what),
        _ => Failure::Failed(error.to_string()),
    }
}

fn interruption(run: &TrainingRun) -> Failure {
    let (epochs, steps) = run.position();
    let place = format!("{epochs} epochs and {steps} steps are done");
    Failure::Stopped(format!("interrupted: {place} and saved in {}: continue with --resume", name(&run.folder)))
}

fn say_what_is_there(run: &TrainingRun, voice: Voice) {
    for (mesh, why) in &run.data.left_out {
        voice.say(&format!("left out  {mesh}: {why}"));
    }
    let learned = OBJECTIVES.iter().find(|(name, _)| *name == run.settings.objective);
    learned.iter().for_each(|(name, what)| voice.say(&format!("objective {name}: {what}")));
    let (training, validation) = (run.data.training.len(), run.data.validation.len());
    voice.say(&format!("meshes    {training} for training, {validation} for validation{}", why_for_validation(run)));
    if run.position() != (0, 0) {
        let (epochs, steps) = run.position();
        voice.say(&format!("resumed   after {epochs} epochs and {steps} steps"));
    }
}

fn why_for_validation(run: &TrainingRun) -> String {
    let is_of = |beginning: &&String| run.data.validation.iter().any(|mesh| mesh.name.starts_with(beginning.as_str()));
    let found: Vec<&str> = run.settings.validation.iter().filter(is_of).map(String::as_str).collect();
    match found.is_empty() {
        true => ": no mesh name begins with an entry of the setting `validation`".into(),
        false => format!(", whose names begin with {}: the setting `validation`", found.join(", ")),
    }
}

fn plot(folder: &Path, voice: Voice) -> Result<(), Failure> {
    let table = folder.join("epochs.csv");
    let text = read_text(&table)?;
    let path = folder.join("curves.svg");
    let picture = curves::draw(&text).map_err(|what| Failure::in_file(&table, what))?;
    files::place(vec![files::prepare(&path, picture.as_bytes(), true)?])?;
    voice.say(&format!("curves    {}", path.display()));
    Ok(())
}
