//! The process that does one job of an evaluation, so that a method that hangs or crashes affects nothing else.

use std::io::{BufRead, Read};

use crate::evaluate::{Worker, answer_job};
use anyhow::{Context, Result};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::{getpgrp, getpid};

pub fn worker() -> Result<Worker> {
    let program = std::env::current_exe().context("the path of this program cannot be found")?;
    Ok(Worker { program, arguments: vec!["work".into()] })
}

/// Runs the job on standard input; exits with all children when that closes.
pub fn run_job() -> Result<()> {
    let mut line = String::new();
    std::io::stdin().lock().read_line(&mut line)?;
    // standard input closes when the caller stops waiting
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        if getpgrp() == getpid() {
            let _ = killpg(getpgrp(), Signal::SIGKILL);
        }
        std::process::exit(1);
    });
    print!("{}", answer_job(&line));
    Ok(())
}
