//! What is going on, for the eye and for the report: a bar on a terminal, and the seconds of each stage.

use std::cell::Cell;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use neural_mesh::simplify::{Event, Listener};

/// Work below this needs no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// What the program goes through, each part with its share of the time without a picture: of a torus of a million faces at a
/// ratio of 0.1 on one thread. A picture, which few runs draw, comes when all else is done.
const PARTS: [(&str, f32); 5] = [("read", 0.1), (SIMPLIFY, 0.73), ("check", 0.16), ("write", 0.01), ("picture", 0.0)];
/// The simplification, which says itself how far it is.
const SIMPLIFY: &str = "simplify";

/// A bar that shows itself where work takes longer than a second, and a clock that the library does not have.
pub struct Progress {
    bar: ProgressBar,
    /// What the bar shows.
    shown: Cell<(&'static str, u64)>,
    stages: Vec<(&'static str, f64)>,
    current: Option<(&'static str, Instant)>,
    /// Who else hears of events, and may end the run.
    listener: Option<Box<Listener<'static>>>,
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
        Self { bar, shown: Cell::default(), stages: Vec::new(), current: None, listener: None }
    }

    /// Draws nothing; what the simplification tells goes to a listener, too.
    pub fn heard_by(listener: Box<Listener<'static>>) -> Self {
        let mut progress = Self::new(true);
        progress.listener = Some(listener);
        progress
    }

    /// A stage of the simplification begins or moves on.
    pub fn event(&mut self, event: Event) -> ControlFlow<()> {
        if self.current.is_none_or(|(stage, _)| stage != event.stage) {
            self.end_stage();
            self.current = Some((event.stage, Instant::now()));
        }
        self.show_at(event.stage, percent(SIMPLIFY, event.total));
        self.listener.as_mut().map_or(ControlFlow::Continue(()), |listener| listener(event))
    }

    /// A part of the run beside the simplification begins.
    pub fn show(&self, part: &'static str) {
        self.show_at(part, percent(part, 0.0));
    }

    /// Says something where the bar stands.
    pub fn aside(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }

    /// Moves the bar, if there is something to see: events come every few milliseconds.
    fn show_at(&self, message: &'static str, percent: u64) {
        if self.shown.replace((message, percent)) != (message, percent) {
            self.bar.set_message(message);
            self.bar.set_position(percent);
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

/// How much of the run is done where so much of a part is; of the first part that is not known nothing.
fn percent(part: &str, done: f32) -> u64 {
    let at = PARTS.iter().position(|(name, _)| *name == part).unwrap_or(0);
    let before: f32 = PARTS[..at].iter().map(|(_, share)| share).sum();
    (100.0 * (before + PARTS[at].1 * done.clamp(0.0, 1.0))) as u64
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
