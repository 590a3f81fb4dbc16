//! Time of a method: processor time where the system counts it, else elapsed time.

use std::time::{Duration, Instant};

#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    wall: Instant,
    thread: Option<Duration>,
}

impl Moment {
    pub fn now() -> Self {
        Self { thread: thread_time(), wall: Instant::now() }
    }

    pub fn seconds(self, n_threads: usize) -> f64 {
        let (wall, now) = (self.wall.elapsed(), thread_time());
        let thread = self.thread.zip(now).filter(|_| n_threads == 1).map(|(then, now)| now.saturating_sub(then));
        thread.unwrap_or(wall).as_secs_f64()
    }
}

fn thread_time() -> Option<Duration> {
    // The system updates the count when it looks for another thread to run.
    std::thread::yield_now();
    let counts = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    counts.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_waits_takes_no_time_of_the_processor() {
        let began = Moment::now();
        std::thread::sleep(Duration::from_millis(100));
        let [alone, shared] = [1, 2].map(|n_threads| began.seconds(n_threads));
        assert!(shared >= 0.1);
        assert!(began.thread.is_none() || alone < 0.05, "{alone}");
    }

    #[test]
    fn work_takes_time_of_the_processor() {
        let began = Moment::now();
        let sum: u64 = (0..20_000_000u64).map(std::hint::black_box).sum();
        let (alone, wall) = (began.seconds(1), began.wall.elapsed().as_secs_f64());
        assert!(sum > 0 && alone > 0.0 && alone <= 1.01 * wall + 0.01, "{alone} of {wall}");
    }
}
