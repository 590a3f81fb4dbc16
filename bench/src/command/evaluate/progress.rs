//! Progress of an evaluation: a bar, and a line for every mesh and failure.

use std::time::{Duration, Instant};

use crate::evaluate::Event;
use crate::rows::ResultRow;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use neural_mesh_cli::shared::{MessageStream, escape_controls};

// Shortest interval between updates of the bar.
const UPDATE_INTERVAL: Duration = Duration::from_millis(200);

pub struct EvaluateProgress {
    bar: ProgressBar,
    stream: MessageStream,
    case: String,
    mesh: String,
    shown: Instant,
}

impl EvaluateProgress {
    pub fn new(stream: MessageStream) -> Self {
        let target =
            if stream == MessageStream::Quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(1), target);
        if let Ok(style) = ProgressStyle::with_template("[{bar:30}] {msg}, {elapsed}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, stream, case: String::new(), mesh: String::new(), shown: Instant::now() }
    }

    pub fn show_event(&mut self, event: Event) {
        match event {
            Event::Case { mesh, ratio, seed, n_done, n_cases } => {
                self.bar.set_length(n_cases as u64);
                self.bar.set_position(n_done as u64);
                self.case = format!("{mesh} at {ratio}, seed {seed}");
                if self.mesh != mesh {
                    self.mesh = mesh.into();
                    self.print_line(&format!("mesh      {mesh} ({n_done} of {n_cases} cases done)"));
                }
            }
            Event::Running { method, round } if self.shown.elapsed() > UPDATE_INTERVAL => {
                self.shown = Instant::now();
                self.show(&format!("{}: {}, run {}", self.case, method.name(), round + 1));
            }
            Event::Judging => self.show(&format!("{}: measuring", self.case)),
            Event::Row(row) => self.show_failure(row),
            _ => {}
        }
    }

    fn show_failure(&self, ResultRow { mesh, ratio, method, error, .. }: &ResultRow) {
        if !error.is_empty() {
            self.print_line(&format!("failed    {mesh} at {ratio}, {method}: {error}"));
        }
    }

    fn show(&self, words: &str) {
        self.bar.set_message(escape_controls(words).into_owned());
    }

    fn print_line(&self, line: &str) {
        self.bar.suspend(|| self.stream.print_line(line));
    }
}

impl Drop for EvaluateProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
