//! `neural-mesh train`: trains, shows progress, draws the curves.

mod args;
mod curves;
mod progress;

use std::path::{Path, PathBuf};

use neural_mesh::train::{
    Ending, OBJECTIVES, OUTPUT_FILES, OwnNetwork, StepFunction, TrainError, TrainRequest, TrainingRun, open,
    step_function, train,
};

use crate::failure::{Failure, display_path};
use crate::files;
use crate::messages::{MessageStream, print_error};
use crate::simplify::in_pool;
use crate::stopping;
pub use args::TrainArgs;
use progress::TrainProgress;

/// Network other than the paper's, and its training step.
pub struct OtherNetwork<'a> {
    /// Value of the setting `objective`.
    pub objective: &'a str,
    /// Initial weights and description of the network.
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
        (Some(folder), _, _) => plot(folder, message_stream(args)),
        (None, Some(data), Some(out)) => {
            stopping::handle_stop_signals();
            in_pool(args.threads, || train_and_plot((args, other), data, out))
        }
        _ => Err(Failure::Usage(
            "--data and --out are missing: give a folder of meshes to --data, and a folder for the results to --out"
                .into(),
        )),
    }
}

fn train_and_plot((args, other): (&TrainArgs, Option<&OtherNetwork>), data: &Path, out: &Path) -> Result<(), Failure> {
    let settings = args.config.as_deref().map(read_text).transpose()?;
    let init = args.init.as_deref().map(files::read).transpose()?;
    let read = files::list_files_read(None, [&args.config, &args.init].into_iter().flatten().map(PathBuf::as_path));
    for path in OUTPUT_FILES.map(|name| out.join(name)) {
        read.check(&path, false).map_err(|error| Failure::in_file(&path, error))?;
    }
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
    print_run(&run, message_stream(args));
    let mut progress = TrainProgress::new(&run, message_stream(args));
    let ending = train(&mut run, &step, &mut |event| progress.handle(event));
    drop(progress);
    match ending.map_err(|error| to_failure(error, args))? {
        Ending::Finished => {
            // The weights are saved, so a failed picture does not make the training fail.
            if let Err(failure) = plot(out, message_stream(args)) {
                print_error(&Failure::Failed(format!("the training is done, but its curves are not drawn: {failure}")));
            }
            Ok(())
        }
        Ending::Stopped => Err(interruption(&run)),
    }
}

fn message_stream(args: &TrainArgs) -> MessageStream {
    if args.quiet { MessageStream::Quiet } else { MessageStream::Out }
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
    let progress = format!("{epochs} epochs and {steps} steps of the next are done");
    Failure::Stopped(format!(
        "interrupted: {progress} and saved in {}: continue with --resume",
        display_path(&run.folder)
    ))
}

fn print_run(run: &TrainingRun, voice: MessageStream) {
    for (mesh, why) in &run.data.left_out {
        voice.print_line(&format!("left out  {mesh}: {why}"));
    }
    let learned = OBJECTIVES.iter().find(|(name, _)| *name == run.settings.objective);
    learned.iter().for_each(|(name, what)| voice.print_line(&format!("objective {name}: {what}")));
    let (training, validation) = (run.data.training.len(), run.data.validation.len());
    voice.print_line(&format!(
        "meshes    {training} for training, {validation} for validation{}",
        validation_words(run)
    ));
    if run.position() != (0, 0) {
        let (epochs, steps) = run.position();
        voice.print_line(&format!("resumed   after {epochs} epochs and {steps} steps of the next"));
    }
}

fn validation_words(run: &TrainingRun) -> String {
    let is_used =
        |beginning: &&String| run.data.validation.iter().any(|mesh| mesh.name.starts_with(beginning.as_str()));
    let found: Vec<&str> = run.settings.validation.iter().filter(is_used).map(String::as_str).collect();
    match found.is_empty() {
        true => ": no mesh name begins with an entry of the setting `validation`".into(),
        false => format!(", whose names begin with {}: the setting `validation`", found.join(", ")),
    }
}

fn plot(folder: &Path, voice: MessageStream) -> Result<(), Failure> {
    let table = folder.join("epochs.csv");
    let text = read_text(&table)?;
    let path = folder.join("curves.svg");
    let picture = curves::draw_curves(&text).map_err(|what| Failure::in_file(&table, what))?;
    let read = files::list_files_read(None, [table.as_path()]);
    files::place_files(vec![files::prepare_file(&path, picture.as_bytes(), true)?], &read)?;
    voice.print_line(&format!("curves    {}", path.display()));
    Ok(())
}
