//! Clocks and memory counters.

use std::time::Duration;

use anyhow::{Context, Result, ensure};
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;
use nix::time::ClockId;

#[derive(Clone, Copy, Debug)]
pub struct Seconds {
    pub wall: f64,
    // Processor time of the calling thread.
    pub thread: f64,
}

pub fn measure_time<T>(work: impl FnOnce() -> Result<T>) -> Result<(T, Seconds)> {
    let (wall, thread) = (now(ClockId::CLOCK_MONOTONIC), thread_time());
    let made = work()?;
    let wall = (now(ClockId::CLOCK_MONOTONIC) - wall).as_secs_f64();
    Ok((made, Seconds { wall, thread: (thread_time() - thread).as_secs_f64() }))
}

/// Returns the processor time of the calling thread.
pub fn thread_time() -> Duration {
    now(ClockId::CLOCK_THREAD_CPUTIME_ID)
}

fn now(clock: ClockId) -> Duration {
    clock.now().map_or(Duration::ZERO, Duration::from)
}

pub fn measure_program_time(command: &mut std::process::Command) -> Result<[f64; 2]> {
    let before = children_time()?;
    let (status, seconds) = measure_time(|| Ok(command.stdout(std::process::Stdio::null()).status()?))?;
    ensure!(status.success(), "{command:?}: {status}");
    Ok([seconds.wall, children_time()? - before])
}

fn children_time() -> Result<f64> {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN)?;
    Ok(1e-6 * (usage.user_time().num_microseconds() + usage.system_time().num_microseconds()) as f64)
}

pub fn reset_peak() -> Result<()> {
    std::fs::write("/proc/self/clear_refs", "5").context("the peak of memory cannot be reset")
}

pub fn peak_bytes() -> Result<u64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).context("no VmHWM in /proc/self/status")?;
    let kib = line.trim().trim_end_matches("kB").trim();
    Ok(1024 * kib.parse::<u64>().with_context(|| format!("VmHWM: {kib}"))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_both_times_and_waiting_no_processor_time() {
        let (sum, seconds) = measure_time(|| Ok((0..20_000_000u64).map(std::hint::black_box).sum::<u64>())).unwrap();
        assert!(sum > 0 && seconds.thread > 0.0 && seconds.wall >= 0.9 * seconds.thread - 0.01, "{seconds:?}");
        let wait = || {
            std::thread::sleep(Duration::from_millis(100));
            Ok(())
        };
        let ((), waited) = measure_time(wait).unwrap();
        assert!(waited.wall >= 0.1 && waited.thread < 0.05, "{waited:?}");
    }
}
