//! A program under a time limit: where it takes longer, it is killed with all that it started.

use std::fs::File;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use process_wrap::std::{ChildWrapper, CommandWrap};

/// Between two looks at the program; at most, and as a share of the time it has taken.
const MOST_PATIENCE: Duration = Duration::from_millis(20);
const SHARE_OF_TIME: f64 = 0.01;

/// Files of what a program says.
const OUT: &str = "stdout";
const WORDS: &str = "stderr";

/// Letters of a program's last words that are kept.
const LAST_WORDS: usize = 300;

/// A program that came to a good end.
#[derive(Debug)]
pub(super) struct Finished {
    /// From its start to its end.
    pub seconds: f64,
    /// What it wrote to standard output.
    pub out: String,
}

/// Why a program came to no good end.
#[derive(Debug, PartialEq)]
pub(super) enum Unfinished {
    /// The caller did not want to wait any longer.
    Stopped,
    /// It could not be started, failed, or took too long; the text says which.
    Failed(String),
}

/// Runs a program, with a line on its standard input, which then stays open until its end: a program that reads it
/// can tell when nobody waits for it any more. `scratch` holds what it says. `wait` is asked again and again
/// whether to go on.
pub(super) fn run_limited(
    mut command: Command,
    line: &str,
    limit: Duration,
    scratch: &Path,
    wait: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Finished, Unfinished> {
    let [out, words] = [OUT, WORDS].map(|name| scratch.join(name));
    let failed = |error: std::io::Error| Unfinished::Failed(format!("cannot be run: {error}"));
    command.stdin(Stdio::piped());
    command.stdout(File::create(&out).map_err(failed)?).stderr(File::create(&words).map_err(failed)?);
    let program = command.get_program().to_string_lossy().into_owned();
    let began = Instant::now();
    let child = grouped(command).spawn();
    let mut child = child.map_err(|error| Unfinished::Failed(format!("{program} cannot be started: {error}")))?;
    let mut stdin = child.stdin().take();
    if let Some(stdin) = &mut stdin {
        // A program that does not listen is none the worse for it.
        let _ = writeln!(stdin, "{line}");
    }
    let ended = ended(child.as_mut(), began, limit, wait);
    let seconds = began.elapsed().as_secs_f64();
    // Whatever it started goes with it, also after a good end.
    let _ = child.start_kill();
    let _ = child.wait();
    let status = ended.map_err(|unfinished| unfinished.unwrap_or_else(|| too_long(limit)))?;
    if !status.success() {
        return Err(Unfinished::Failed(with_last_words(&end(status), &[&words, &out])));
    }
    let out = std::fs::read(&out).map_err(failed)?;
    Ok(Finished { seconds, out: String::from_utf8_lossy(&out).into_owned() })
}

/// The program as the head of a group that can be killed together.
fn grouped(command: Command) -> CommandWrap {
    let mut command = CommandWrap::from(command);
    #[cfg(unix)]
    command.wrap(process_wrap::std::ProcessGroup::leader());
    #[cfg(windows)]
    command.wrap(process_wrap::std::JobObject);
    command
}

/// How it ended; an error of `None` for one that took too long.
fn ended(
    child: &mut dyn ChildWrapper,
    began: Instant,
    limit: Duration,
    wait: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<ExitStatus, Option<Unfinished>> {
    loop {
        let status =
            child.try_wait().map_err(|error| Some(Unfinished::Failed(format!("cannot be waited for: {error}"))))?;
        if let Some(status) = status {
            return Ok(status);
        }
        let elapsed = began.elapsed();
        if elapsed >= limit {
            return Err(None);
        }
        if wait().is_break() {
            return Err(Some(Unfinished::Stopped));
        }
        let patience = elapsed.mul_f64(SHARE_OF_TIME).clamp(Duration::from_micros(200), MOST_PATIENCE);
        std::thread::sleep(patience.min(limit.saturating_sub(elapsed)));
    }
}

/// The words of a text with a blank between.
pub(super) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn too_long(limit: Duration) -> Unfinished {
    Unfinished::Failed(format!("took longer than the time limit of {} s", limit.as_secs_f64()))
}

/// `exit code 3`, or the signal.
pub(super) fn end(status: ExitStatus) -> String {
    match status.code() {
        Some(code) => format!("ended with exit code {code}"),
        None => format!("crashed ({status})"),
    }
}

/// What the program last run in a scratch folder wrote to standard error.
pub(super) fn words_in(scratch: &Path) -> PathBuf {
    scratch.join(WORDS)
}

/// A failure with the end of what a program said, in one line: of the first of these files that holds anything.
pub(super) fn with_last_words(failure: &str, files: &[&Path]) -> String {
    let read = |file: &&Path| one_line(&String::from_utf8_lossy(&std::fs::read(file).unwrap_or_default()));
    let said = files.iter().map(read);
    let words = said.into_iter().find(|words| !words.is_empty()).unwrap_or_default();
    let from = words.char_indices().rev().nth(LAST_WORDS).map_or(0, |(at, _)| at);
    if words.is_empty() { failure.into() } else { format!("{failure}: {}", &words[from..]) }
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str, limit: f64) -> Result<Finished, Unfinished> {
        let folder = tempfile::tempdir().unwrap();
        let mut command = Command::new("sh");
        command.args(["-c", script]).current_dir(folder.path());
        run_limited(command, "a line", Duration::from_secs_f64(limit), folder.path(), &mut || ControlFlow::Continue(()))
    }

    #[test]
    fn what_it_says_is_heard() {
        let finished = shell("read x; echo got $x", 600.0).unwrap();
        assert_eq!(finished.out, "got a line\n");
        let Err(Unfinished::Failed(why)) = shell("echo alas >&2; exit 3", 600.0) else { panic!() };
        assert_eq!(why, "ended with exit code 3: alas");
        let Err(Unfinished::Failed(why)) = shell("kill -SEGV $$", 600.0) else { panic!() };
        assert!(why.contains("crashed"), "{why}");
    }

    #[test]
    fn what_takes_too_long_is_killed_with_its_children() {
        let folder = tempfile::tempdir().unwrap();
        let [alive, go, mark] = ["alive", "go", "mark"].map(|name| folder.path().join(name));
        // A child that outlives its parent would leave a mark when asked to.
        let child = "touch alive; while [ ! -e go ]; do sleep 0.02; done; touch mark";
        let script = format!("cd '{}'; ({child}) & sleep 6000", folder.path().display());
        // On a busy machine a short time may not be enough to start the child.
        for limit in [0.25, 1.0, 4.0, 16.0, 64.0] {
            let Err(Unfinished::Failed(why)) = shell(&script, limit) else { panic!() };
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
        let stopped = run_limited(command, "", limit, folder.path(), &mut || ControlFlow::Break(()));
        assert_eq!(stopped.unwrap_err(), Unfinished::Stopped);
        let none =
            run_limited(Command::new("no-such-program"), "", limit, folder.path(), &mut || ControlFlow::Break(()));
        assert!(matches!(none, Err(Unfinished::Failed(why)) if why.contains("no-such-program")));
    }
}
