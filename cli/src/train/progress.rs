//! Progress of a training.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use neural_mesh::train::{TrainEvent, TrainingRun, Wish};

use crate::messages::MessageStream;
use crate::stopping::is_stop_requested;

pub struct TrainProgress {
    bar: ProgressBar,
    voice: MessageStream,
    began: Instant,
    /// Number of steps done before this run.
    n_before: usize,
    n_steps: usize,
    n_epochs: usize,
    saved: Instant,
    checkpoint_every: Duration,
}

impl TrainProgress {
    pub fn new(run: &TrainingRun, voice: MessageStream) -> Self {
        let (n_steps, n_epochs) = (run.data.training.len(), run.settings.epochs);
        let target =
            if voice == MessageStream::Quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some((n_steps * n_epochs) as u64), target);
        if let Ok(style) = ProgressStyle::with_template("[{bar:30}] {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        let (epoch, n_done) = run.position();
        let checkpoint_every = Duration::try_from_secs_f64(60.0 * run.settings.checkpoint_minutes);
        Self {
            bar,
            voice,
            began: Instant::now(),
            n_before: epoch * n_steps + n_done,
            n_steps,
            n_epochs,
            saved: Instant::now(),
            checkpoint_every: checkpoint_every.unwrap_or(Duration::MAX),
        }
    }

    pub fn handle(&mut self, event: TrainEvent) -> Wish {
        match event {
            TrainEvent::Step { epoch, n_done, n_steps, terms } => self.show_step(epoch * n_steps + n_done, terms),
            TrainEvent::Skipped { mesh, why } => self.print_line(&format!("skipped   {mesh}: {why}")),
            TrainEvent::Validated { n_done, n_meshes, .. } => {
                self.bar.set_message(format!("validation: {n_done} of {n_meshes} meshes"));
            }
            TrainEvent::Epoch { n_done, training, validation, is_best } => {
                self.saved = Instant::now();
                self.print_epoch(n_done, training, validation, is_best);
            }
            _ => {}
        }
        self.next_wish()
    }

    fn show_step(&self, n_done: usize, terms: &[(&str, f64)]) {
        self.bar.set_position(n_done as u64);
        let terms: Vec<String> =
            terms.iter().map(|(name, value)| format!("{name} {}", format_figure(*value))).collect();
        self.bar.set_message(format!("{} left, {}", self.remaining_time(n_done), terms.join(", ")));
    }

    fn print_epoch(&self, n_done: usize, training: f64, validation: Option<f64>, is_best: bool) {
        let validation = validation.map_or(String::new(), |total| format!(", validation {}", format_figure(total)));
        let best = if is_best { ", the best" } else { "" };
        let (n_epochs, left) = (self.n_epochs, self.remaining_time(n_done * self.n_steps));
        let training = format_figure(training);
        self.print_line(&format!(
            "epoch     {n_done} of {n_epochs}: training {training}{validation}{best}; {left} left"
        ));
    }

    fn next_wish(&mut self) -> Wish {
        if is_stop_requested() {
            return Wish::Stop;
        }
        if self.saved.elapsed() < self.checkpoint_every {
            return Wish::Continue;
        }
        self.saved = Instant::now();
        Wish::Checkpoint
    }

    fn print_line(&self, line: &str) {
        self.bar.suspend(|| self.voice.print_line(line));
    }

    fn remaining_time(&self, n_done: usize) -> String {
        let done = n_done.saturating_sub(self.n_before).max(1);
        let rest = (self.n_steps * self.n_epochs).saturating_sub(n_done);
        let seconds = (self.began.elapsed().as_secs_f64() * rest as f64 / done as f64) as u64;
        format!("{}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
    }
}

impl Drop for TrainProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

fn format_figure(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let decimals = (3.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}
