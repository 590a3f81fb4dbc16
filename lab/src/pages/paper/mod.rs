//! The paper's tables: Table 1, simplified meshes; Table 2, samplers; Figure 6, distances along the surface.

mod samplers;

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use neural_mesh::evaluate::{Settings, report};

use super::RATIOS;
use crate::bench::Bench;
use crate::root;

/// The classes of TOSCA that the weights have not seen.
pub const CLASSES: [&str; 4] = ["cat", "gorilla", "victoria", "wolf"];
pub const METHODS: [&str; 6] = ["network", "paper", "qem", "meshopt", "farthest-bpa", "uniform-bpa"];
/// Seconds that a run may take.
const TIME_LIMIT: f64 = 1800.0;

pub fn page(bench: &Bench) -> Result<String> {
    Ok(format!(
        "The cats, gorillas, victorias and wolves of TOSCA (Bronstein, Bronstein and Kimmel 2008), 30 meshes: classes that \
         `weights/paper-tosca.safetensors`, used for the method `paper`, has not seen. `network` is the closed assembly with the weights \
         that ship, which have seen no mesh of TOSCA. The others: [evaluate.md](../evaluate.md).\n\n## Table 1: simplified meshes\n\n{}\n\
         ## Table 2: samplers\n\n{}\n## Figure 6: distances along the surface\n\n{}",
        table_1(bench)?,
        samplers::table_2(bench)?,
        figure_6(bench)?
    ))
}

/// What an evaluation of the classes asks for.
pub fn settings(methods: &[&str]) -> Settings {
    Settings {
        methods: methods.iter().map(|name| name.to_string()).collect(),
        ratios: RATIOS.into(),
        repeats: 1,
        threads: 1,
        time_limit: TIME_LIMIT,
        only: CLASSES.map(String::from).into(),
        ..Settings::default()
    }
}

/// Weights that have learned from TOSCA.
pub fn weights() -> PathBuf {
    root().join("weights/paper-tosca.safetensors")
}

/// The tables that `evaluate` makes, their titles one level down.
fn table_1(bench: &Bench) -> Result<String> {
    bench.evaluated("paper", "tosca", Settings { spectrum: true, ..settings(&METHODS) }, Some(weights()))?;
    let folder = bench.run_of("paper");
    report(&folder, Some("qem"))?;
    let text = std::fs::read_to_string(folder.join("tables.md"))?;
    let (_, body) = text.split_once("# Evaluation\n\n").context("the tables have no title")?;
    let lines =
        body.lines().map(|line| if line.starts_with("##") { format!("#{line}\n") } else { format!("{line}\n") });
    Ok(lines.collect())
}

/// The paper's Figure 6 by the example of that name: the picture, and the errors that it prints.
fn figure_6(bench: &Bench) -> Result<String> {
    let picture = "docs/measured/figure6.png";
    let printed: String = bench.kept("figure6", || {
        std::fs::create_dir_all(root().join("docs/measured"))?;
        let mut cargo = Command::new("cargo");
        cargo.args(["run", "--quiet", "--release", "--example", "figure6", "--features", "baselines,spectrum", "--"]);
        let mesh = std::path::absolute(bench.set("tosca").join("cat0.ply"))?;
        let done = cargo.arg(mesh).arg(weights()).arg(picture).current_dir(root()).output().context("cargo")?;
        ensure!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        Ok(String::from_utf8(done.stdout)?)
    })?;
    Ok(format!(
        "A cat at a tenth of its vertices: errors of geodesic and biharmonic distances from one point, which the figure shows with lines \
         of equal distance.\n\n{printed}\n![Distances on a cat, and on what three methods make of it](figure6.png)\n"
    ))
}
