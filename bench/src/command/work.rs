//! A process for one job of an evaluation, whose crash affects nothing else.

use std::io::{BufRead, Read};

use crate::evaluate::{Worker, answer_job};
use anyhow::{Context, Result};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::{getpgrp, getpid};

pub fn worker() -> Result<Worker> {
    let program = std::env::current_exe().context("the path of this program cannot be found")?;
    Ok(Worker { program, arguments: vec!["work".into()] })
}

pub fn run_job() -> Result<()> {
    let mut line = String::new();
    std::io::stdin().lock().read_line(&mut line)?;
    // Standard input closes when the caller stops waiting; then this process ends with its children.
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
