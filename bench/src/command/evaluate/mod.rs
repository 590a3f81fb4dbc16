//! `neural-mesh-bench evaluate`: measurement, progress and report.

mod args;
mod progress;

use std::ops::ControlFlow;
use std::path::Path;

use crate::evaluate::{Ending, EvaluateError, REPORT, Request, evaluate, write_report};
use neural_mesh_cli::shared::{Failure, MessageStream, display_path, stopping};

use super::work::worker;
pub use args::EvaluateArgs;
use progress::EvaluateProgress;

pub fn run(args: &EvaluateArgs) -> Result<(), Failure> {
    match (&args.report, &args.data, &args.out) {
        (Some(folder), _, _) => publish(folder, args),
        (None, Some(data), Some(out)) => measure(args, data, out),
        _ => Err(Failure::Usage("--data and --out are needed: give a folder of meshes and one for the rows".into())),
    }
}

fn measure(args: &EvaluateArgs, data: &Path, out: &Path) -> Result<(), Failure> {
    let request = make_request(args, data, out)?;
    let methods = request.settings.resolve_methods().map_err(to_failure)?;
    if let Some(other) = args.relative_to.as_ref().filter(|other| !methods.iter().any(|m| m.name() == other.as_str())) {
        return Err(Failure::Usage(format!("--relative-to {other}: is not among the methods: add it to --methods")));
    }
    stopping::handle_stop_signals();
    let mut progress = EvaluateProgress::new(message_stream(args));
    let flow = |is_stopping| if is_stopping { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let ending = evaluate(&request, &mut |event| {
        progress.show_event(event);
        flow(stopping::is_stop_requested())
    });
    drop(progress);
    let ending = ending.map_err(to_failure)?;
    publish(out, args)?;
    match ending {
        Ending::Finished => Ok(()),
        Ending::Stopped => {
            let what =
                format!("interrupted: the rows so far are kept in {}: continue with --resume", display_path(out));
            Err(Failure::Stopped(what))
        }
    }
}

fn make_request(args: &EvaluateArgs, data: &Path, out: &Path) -> Result<Request, Failure> {
    let worker = worker().map_err(|error| Failure::Failed(format!("{error:#}: start it by its full path")))?;
    let mut request = Request::new(data, out, worker);
    request.settings = args.settings.clone();
    request.weights = args.weights.clone();
    request.paper_weights = args.paper_weights.clone();
    request.learned_weights = args.learned_weights.clone();
    request.resume = args.resume;
    Ok(request)
}

fn to_failure(error: EvaluateError) -> Failure {
    match error {
        EvaluateError::Settings(what) => Failure::Usage(what),
        other => Failure::Failed(other.to_string()),
    }
}

fn message_stream(args: &EvaluateArgs) -> MessageStream {
    if args.quiet { MessageStream::Quiet } else { MessageStream::Out }
}

fn publish(folder: &Path, args: &EvaluateArgs) -> Result<(), Failure> {
    write_report(folder, args.relative_to.as_deref()).map_err(to_failure)?;
    message_stream(args).print_line(&format!("wrote     {}", display_path(&folder.join(REPORT))));
    Ok(())
}
