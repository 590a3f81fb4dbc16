//! CGAL's simplifiers as tools, in a small C++ program.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::evaluate::Tool;
use anyhow::{Context, Result, ensure};

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cgal/collapse.cpp");

// Folder of the library Eigen on Debian, which CGAL needs.
const EIGEN: &str = "/usr/include/eigen3";

// Method names of CGAL's QEM with optimal placement and of its Lindstrom-Turk simplifier.
pub const NAMES: [&str; 2] = ["cgal-qem", "cgal-lt"];

pub fn build_tools(folder: &Path) -> Result<Vec<Tool>> {
    let program = build_program(folder)?;
    let tool = |name: &str| {
        let command = format!("'{}' {} {{in}} {{out}} {{faces}}", program.display(), name.trim_start_matches("cgal-"));
        Tool { name: name.into(), command }
    };
    Ok(NAMES.map(tool).into())
}

fn build_program(folder: &Path) -> Result<PathBuf> {
    let program = folder.join("cgal-collapse");
    if program.exists() {
        return Ok(program);
    }
    std::fs::create_dir_all(folder)?;
    let unfinished = folder.join("cgal-collapse.new");
    let mut compiler = Command::new("c++");
    compiler.args(["-std=c++17", "-O3", "-DNDEBUG", "-I", EIGEN, SOURCE, "-o"]).arg(&unfinished);
    let status = compiler.args(["-lgmp", "-lmpfr"]).status().context("a C++ compiler is needed")?;
    ensure!(
        status.success(),
        "{SOURCE} cannot be built: it needs CGAL (Debian: apt-get install libcgal-dev libeigen3-dev)"
    );
    std::fs::rename(&unfinished, &program)?;
    Ok(program)
}
