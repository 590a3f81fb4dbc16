//! Processes with a time limit, killed with their children.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use process_wrap::std::{ChildWrapper, CommandWrap};

const LONGEST_WAIT: Duration = Duration::from_millis(20);
// Time between two checks of a process, as a fraction of its elapsed time.
const WAIT_FRACTION: f64 = 0.01;

const OUT: &str = "stdout";
const WORDS: &str = "stderr";

// Characters of output kept with a failure.
const MAX_OUTPUT: usize = 300;

#[derive(Debug, PartialEq)]
pub(super) enum RunFailure {
    Stopped,
    Failed(String),
}

/// Runs a process with `line` on its standard input and returns its output; `is_stopped` is asked regularly.
pub(super) fn run_limited(
    mut command: Command,
    line: &str,
    limit: Duration,
    scratch: &Path,
    is_stopped: fn() -> bool,
) -> Result<String, RunFailure> {
    let [out, words] = [OUT, WORDS].map(|name| scratch.join(name));
    let failed = |error: std::io::Error| RunFailure::Failed(format!("cannot be run: {error}"));
    command.stdin(Stdio::piped());
    command.stdout(File::create(&out).map_err(failed)?).stderr(File::create(&words).map_err(failed)?);
    let program = command.get_program().to_string_lossy().into_owned();
    let began = Instant::now();
    let child = wrap_in_group(command).spawn();
    let mut child = child.map_err(|error| RunFailure::Failed(format!("{program} cannot be started: {error}")))?;
    // Standard input stays open until the end, as a sign that the caller waits.
    let mut stdin = child.stdin().take();
    if let Some(stdin) = &mut stdin {
        // A program that does not read its input is fine.
        let _ = writeln!(stdin, "{line}");
    }
    let ended = wait_for_end(child.as_mut(), began, limit, is_stopped);
    // Its children must not outlive it, even after success.
    let _ = child.start_kill();
    let _ = child.wait();
    let status = ended?;
    if !status.success() {
        return Err(RunFailure::Failed(append_last_output(&describe_status(status), &[&words, &out])));
    }
    let out = std::fs::read(&out).map_err(failed)?;
    Ok(String::from_utf8_lossy(&out).into_owned())
}

fn wrap_in_group(command: Command) -> CommandWrap {
    let mut command = CommandWrap::from(command);
    #[cfg(unix)]
    command.wrap(process_wrap::std::ProcessGroup::leader());
    #[cfg(windows)]
    command.wrap(process_wrap::std::JobObject);
    command
}

fn wait_for_end(
    child: &mut dyn ChildWrapper,
    began: Instant,
    limit: Duration,
    is_stopped: fn() -> bool,
) -> Result<ExitStatus, RunFailure> {
    loop {
        let status = child.try_wait().map_err(|error| RunFailure::Failed(format!("cannot be waited for: {error}")))?;
        if let Some(status) = status {
            return Ok(status);
        }
        let elapsed = began.elapsed();
        if elapsed >= limit {
            let why = format!("took longer than the time limit of {} s", limit.as_secs_f64());
            return Err(RunFailure::Failed(why));
        }
        if is_stopped() {
            return Err(RunFailure::Stopped);
        }
        let patience = elapsed.mul_f64(WAIT_FRACTION).clamp(Duration::from_micros(200), LONGEST_WAIT);
        std::thread::sleep(patience.min(limit.saturating_sub(elapsed)));
    }
}

pub(super) fn join_lines(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

pub(super) fn describe_status(status: ExitStatus) -> String {
    match status.code() {
        Some(code) => format!("ended with exit code {code}"),
        None => format!("crashed ({status})"),
    }
}

pub(super) fn stderr_path(scratch: &Path) -> PathBuf {
    scratch.join(WORDS)
}

pub(super) fn append_last_output(failure: &str, files: &[&Path]) -> String {
    let read = |file: &&Path| join_lines(&String::from_utf8_lossy(&std::fs::read(file).unwrap_or_default()));
    let said = files.iter().map(read);
    let words = said.into_iter().find(|words| !words.is_empty()).unwrap_or_default();
    let from = words.char_indices().rev().nth(MAX_OUTPUT).map_or(0, |(at, _)| at);
    if words.is_empty() { failure.into() } else { format!("{failure}: {}", &words[from..]) }
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str, limit: f64) -> Result<String, RunFailure> {
        let folder = tempfile::tempdir().unwrap();
        let mut command = Command::new("sh");
        command.args(["-c", script]).current_dir(folder.path());
        run_limited(command, "a line", Duration::from_secs_f64(limit), folder.path(), || false)
    }

    #[test]
    fn output_of_a_program_is_captured() {
        assert_eq!(shell("read x; echo got $x", 600.0).unwrap(), "got a line\n");
        let Err(RunFailure::Failed(why)) = shell("echo alas >&2; exit 3", 600.0) else { panic!() };
        assert_eq!(why, "ended with exit code 3: alas");
        let Err(RunFailure::Failed(why)) = shell("kill -SEGV $$", 600.0) else { panic!() };
        assert!(why.contains("crashed"), "{why}");
    }

    #[test]
    fn programs_over_the_time_limit_are_killed_with_their_children() {
        let folder = tempfile::tempdir().unwrap();
        let [alive, go, mark] = ["alive", "go", "mark"].map(|name| folder.path().join(name));
        // A child that outlives its parent leaves the file `mark` once the file `go` exists.
        let child = "touch alive; while [ ! -e go ]; do sleep 0.02; done; touch mark";
        let script = format!("cd '{}'; ({child}) & sleep 6000", folder.path().display());
        // On a busy machine a short time may not be enough to start the child.
        for limit in [0.25, 1.0, 4.0, 16.0, 64.0] {
            let Err(RunFailure::Failed(why)) = shell(&script, limit) else { panic!() };
            assert!(why.contains(&format!("time limit of {limit} s")), "{why}");
            if alive.exists() {
                break;
            }
        }
        assert!(alive.exists());
        std::fs::write(go, "").unwrap();
        std::thread::sleep(Duration::from_millis(500));
        assert!(!mark.exists());
    }

    #[test]
    fn nobody_has_to_wait() {
        let folder = tempfile::tempdir().unwrap();
        let mut command = Command::new("sleep");
        command.arg("600");
        let limit = Duration::from_secs(600);
        let stopped = run_limited(command, "", limit, folder.path(), || true);
        assert_eq!(stopped.unwrap_err(), RunFailure::Stopped);
        let none = run_limited(Command::new("no-such-program"), "", limit, folder.path(), || true);
        assert!(matches!(none, Err(RunFailure::Failed(why)) if why.contains("no-such-program")));
    }
}
