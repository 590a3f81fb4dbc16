//! What is going on, for the eye and for the report: a bar on a terminal, and the seconds of each stage.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use neural_mesh::simplify::Event;

/// Work below this needs no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// What a run goes through, each with about its share of the time on a large mesh.
const PARTS: [(&str, f32); 13] = [
    ("read", 0.02),
    ("surface", 0.05),
    ("samples", 0.09),
    ("cuts", 0.08),
    ("quotient", 0.09),
    ("placement", 0.01),
    ("collapse", 0.03),
    ("flips", 0.06),
    ("fit", 0.11),
    ("finish", 0.01),
    ("write", 0.01),
    ("check", 0.37),
    ("picture", 0.07),
];

/// A bar that shows itself where work takes longer than a second, and a clock that the library does not have.
pub struct Progress {
    bar: ProgressBar,
    stages: Vec<(&'static str, f64)>,
    current: Option<(&'static str, Instant)>,
}

impl Progress {
    /// Starts; nothing is ever drawn where `quiet` or where standard error is no terminal.
    pub fn new(quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(100), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("[{bar:40}] {msg}, {elapsed}") {
            bar.set_style(style.progress_chars("=> "));
        }
        if !quiet {
            show_later(bar.clone());
        }
        Self { bar, stages: Vec::new(), current: None }
    }

    /// A stage of the simplification begins or moves on.
    pub fn event(&mut self, event: Event) {
        if self.current.is_none_or(|(stage, _)| stage != event.stage) {
            self.end_stage();
            self.current = Some((event.stage, Instant::now()));
        }
        self.show(event.stage, event.done);
    }

    /// A part of the run begins or moves on; `done` is in 0..=1. A part that is not known moves nothing.
    pub fn show(&self, part: &'static str, done: f32) {
        self.bar.set_message(part);
        if let Some(at) = PARTS.iter().position(|(name, _)| *name == part) {
            let before: f32 = PARTS[..at].iter().map(|(_, share)| share).sum();
            self.bar.set_position((100.0 * (before + PARTS[at].1 * done.clamp(0.0, 1.0))) as u64);
        }
    }

    /// The simplification ends: seconds of its stages, in the order they came first.
    pub fn take_stages(&mut self) -> Vec<(&'static str, f64)> {
        self.end_stage();
        std::mem::take(&mut self.stages)
    }

    fn end_stage(&mut self) {
        let Some((stage, began)) = self.current.take() else { return };
        let seconds = began.elapsed().as_secs_f64();
        match self.stages.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, total)) => *total += seconds,
            None => self.stages.push((stage, seconds)),
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Draws the bar from a second on, unless all is done by then.
fn show_later(bar: ProgressBar) {
    std::thread::spawn(move || {
        std::thread::sleep(PATIENCE);
        if !bar.is_finished() {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.enable_steady_tick(Duration::from_millis(100));
        }
    });
}
