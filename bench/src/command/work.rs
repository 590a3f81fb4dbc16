//! The process that does one job of an evaluation, so that a method that hangs or crashes takes nothing else with it.

use std::io::{BufRead, Read};

use crate::evaluate::{Worker, answer};
use anyhow::{Context, Result};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::{getpgrp, getpid};

/// This program, as a worker.
pub fn worker() -> Result<Worker> {
    let program = std::env::current_exe().context("the path of this program cannot be found")?;
    Ok(Worker { program, arguments: vec!["work".into()] })
}

/// Does the job on standard input; ends with it, and with all that it has started, because then nobody waits any more.
pub fn work() -> Result<()> {
    let mut line = String::new();
    std::io::stdin().lock().read_line(&mut line)?;
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        if getpgrp() == getpid() {
            let _ = killpg(getpgrp(), Signal::SIGKILL);
        }
        std::process::exit(1);
    });
    print!("{}", answer(&line));
    Ok(())
}
