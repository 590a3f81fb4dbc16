//! The most memory that this process had, since a moment of its own choice (Linux).

use anyhow::{Context, Result};

/// Forgets the peak so far.
pub fn forget_peak() -> Result<()> {
    std::fs::write("/proc/self/clear_refs", "5").context("the peak of memory cannot be reset")
}

/// Most bytes resident since [`forget_peak`].
pub fn peak_bytes() -> Result<u64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).context("no VmHWM in /proc/self/status")?;
    let kib = line.trim().trim_end_matches("kB").trim();
    Ok(1024 * kib.parse::<u64>().with_context(|| format!("VmHWM: {kib}"))?)
}
