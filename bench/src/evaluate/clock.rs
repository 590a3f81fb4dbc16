//! Time of a method: processor time on one thread, elapsed time on several.

use std::time::{Duration, Instant};

use nix::time::ClockId;

#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    wall: Instant,
    thread: Duration,
}

impl Moment {
    pub fn now() -> Self {
        Self { thread: thread_time(), wall: Instant::now() }
    }

    pub fn seconds(self, n_threads: usize) -> f64 {
        let time = if n_threads == 1 { thread_time().saturating_sub(self.thread) } else { self.wall.elapsed() };
        time.as_secs_f64()
    }
}

/// Returns the processor time of the calling thread.
pub(crate) fn thread_time() -> Duration {
    ClockId::CLOCK_THREAD_CPUTIME_ID.now().map_or(Duration::ZERO, Duration::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_takes_no_processor_time() {
        let began = Moment::now();
        std::thread::sleep(Duration::from_millis(100));
        let [alone, shared] = [1, 2].map(|n_threads| began.seconds(n_threads));
        assert!(shared >= 0.1);
        assert!(alone < 0.05, "{alone}");
    }

    #[test]
    fn work_takes_processor_time() {
        let began = Moment::now();
        let sum: u64 = (0..20_000_000u64).map(std::hint::black_box).sum();
        let (alone, wall) = (began.seconds(1), began.wall.elapsed().as_secs_f64());
        assert!(sum > 0 && alone > 0.0 && alone <= 1.01 * wall + 0.01, "{alone} of {wall}");
    }
}
