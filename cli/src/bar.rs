//! Progress display: a bar on a terminal, occasional lines elsewhere.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::escapes::escape_controls;

const SHOW_DELAY: Duration = Duration::from_secs(1);
/// Shortest time between two lines without a terminal; later a tenth of the elapsed time.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
const STEPS: f64 = 1000.0;
/// Finished share of the run from which the remaining time is estimated.
const MIN_ESTIMATED_SHARE: f32 = 0.02;

/// Progress bar that appears after a second.
pub struct Bar(ProgressBar);

impl Bar {
    pub fn new(quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(STEPS as u64), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("[{bar:30}] {percent:>3} % {msg}, {passed}{left}");
        if let Ok(style) = style {
            let elapsed = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = write!(out, "{}", format_duration(state.elapsed()));
            };
            let remaining = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
                let _ = out.write_str(&describe_remaining_time(state.elapsed(), state.fraction()));
            };
            bar.set_style(style.with_key("passed", elapsed).with_key("left", remaining).progress_chars("=> "));
        }
        if !quiet {
            show_later(bar.clone());
        }
        Self(bar)
    }

    /// Shows the current activity and the finished share, 0 to 1.
    pub fn show(&self, activity: impl Into<Cow<'static, str>>, done: f64) {
        self.0.set_message(activity);
        self.0.set_position((STEPS * done.clamp(0.0, 1.0)) as u64);
    }

    pub fn suspend(&self, print: impl FnOnce()) {
        self.0.suspend(print);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

fn show_later(bar: ProgressBar) {
    std::thread::spawn(move || {
        std::thread::sleep(SHOW_DELAY);
        // Work that ends within the first second shows no bar.
        if bar.is_finished() {
            return;
        }
        if std::io::stderr().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.enable_steady_tick(Duration::from_millis(100));
        } else {
            print_lines(&bar);
        }
    });
}

fn print_lines(bar: &ProgressBar) {
    let began = Instant::now();
    let mut next = LINE_INTERVAL;
    while !bar.is_finished() {
        std::thread::sleep(SHOW_DELAY);
        let elapsed = began.elapsed();
        if elapsed >= next && !bar.is_finished() {
            // Lines become rarer as the run gets longer.
            next = elapsed + LINE_INTERVAL.max(elapsed / 10);
            let done = bar.position() as f32 / STEPS as f32;
            let mut line = format!("progress  {:.0} % {}", 100.0 * done, escape_controls(&bar.message()));
            let _ =
                write!(line, ", {}{}", format_duration(bar.elapsed()), describe_remaining_time(bar.elapsed(), done));
            let _ = writeln!(std::io::stderr(), "{line}");
        }
    }
}

/// Returns text such as `, about 20 seconds left`, or nothing below [`MIN_ESTIMATED_SHARE`].
fn describe_remaining_time(elapsed: Duration, done: f32) -> String {
    if done < MIN_ESTIMATED_SHARE {
        return String::new();
    }
    let remaining = elapsed.as_secs_f64() * (1.0 / f64::from(done) - 1.0);
    format!(", about {} left", format_duration(Duration::from_secs_f64(remaining)))
}

fn format_duration(time: Duration) -> String {
    HumanDuration(Duration::from_secs(time.as_secs())).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remaining_time_follows_from_the_finished_share() {
        let minute = Duration::from_secs(60);
        assert_eq!(describe_remaining_time(minute, 0.25), ", about 3 minutes left");
        assert_eq!(describe_remaining_time(minute, 0.75), ", about 20 seconds left");
        assert_eq!(describe_remaining_time(minute, 0.001), "");
    }
}
