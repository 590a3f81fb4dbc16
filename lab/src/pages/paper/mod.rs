//! The paper's tables: Table 1, simplified meshes; Table 2, samplers; Figure 6, distances along the surface.

mod maps;
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
pub const METHODS: [&str; 9] =
    ["network", "paper", "pointtrinet", "dse", "potamias", "qem", "meshopt", "farthest-bpa", "uniform-bpa"];
/// Columns of the paper's Table 1.
const COLUMNS: [&str; 5] = ["CD", "WA", "LE", "NE", "time"];
/// Seconds that a run may take.
const TIME_LIMIT: f64 = 1800.0;

pub fn page(bench: &Bench) -> Result<String> {
    Ok(format!(
        "The cats, gorillas, victorias and wolves of TOSCA (Bronstein, Bronstein and Kimmel 2008): classes that the weights of `paper`, \
         `weights/paper-tosca.safetensors`, have not seen. `network` is the closed assembly with its usual weights, which have seen no \
         mesh of TOSCA. The others: [evaluate.md](../evaluate.md).\n\n## Table 1: simplified meshes\n\n{}\n\
         ## Learned and exact maps\n\n{}\n## Table 2: samplers\n\n{}\n## Figure 6: distances along the surface\n\n{}",
        table_1(bench)?,
        maps::section(bench)?,
        samplers::table_2(bench)?,
        figure_6(bench)?
    ))
}

/// What an evaluation of the classes asks for.
pub fn settings(methods: &[&str]) -> Settings {
    let mut settings = Settings::default();
    settings.methods = methods.iter().map(|name| name.to_string()).collect();
    settings.ratios = RATIOS.into();
    settings.repeats = 1;
    settings.time_limit = TIME_LIMIT;
    settings.only = CLASSES.map(String::from).into();
    settings
}

/// What the evaluation of all methods asks for, the spectrum too.
pub fn with_spectrum() -> Settings {
    let mut settings = settings(&METHODS);
    settings.spectrum = true;
    settings
}

/// Weights that have learned from TOSCA.
pub fn weights() -> PathBuf {
    root().join("weights/paper-tosca.safetensors")
}

/// The tables that `evaluate` makes, their titles one level down.
fn table_1(bench: &Bench) -> Result<String> {
    bench.evaluated("paper", "tosca", with_spectrum(), Some(weights()))?;
    let folder = bench.run_of("paper");
    report(&folder, Some("qem"))?;
    let text = std::fs::read_to_string(folder.join("tables.md"))?;
    let (_, body) = text.split_once("# Evaluation\n\n").context("the tables have no title")?;
    let (body, _) = body.split_once("\n## More of the same").context("the tables have no second part")?;
    Ok(shortened(body))
}

/// The lines of the tables: titles one level down, the list of columns without those of the second part, and what stands over
/// every table of quotients said once.
fn shortened(body: &str) -> String {
    let mut n_quotients = 0;
    let mut keeps = |line: &str| {
        n_quotients += usize::from(line.starts_with("Relative to"));
        let is_repeated = line.starts_with("Relative to") && n_quotients > 1;
        let is_other =
            line.starts_with("- *") && !COLUMNS.iter().any(|column| line.starts_with(&format!("- *{column}")));
        !is_repeated && !is_other
    };
    let lines = body.lines().filter(|line| keeps(line));
    lines.map(|line| if line.starts_with("##") { format!("#{line}\n") } else { format!("{line}\n") }).collect()
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
        "A cat at a tenth of its vertices: errors of geodesic and biharmonic distances from one point; lines of equal distance.\n\n{printed}\n![Distances on a cat, and on what three methods make of it](figure6.png)\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn what_stands_over_every_table_is_said_once() {
        let body = "- *CD* (`x`)\n- *curvature* (`y`)\n## Title\n\nRelative to qem: words\n\n| 1 |\n\nRelative to qem: words\n| 2 |\n";
        assert_eq!(shortened(body), "- *CD* (`x`)\n### Title\n\nRelative to qem: words\n\n| 1 |\n\n| 2 |\n");
    }
}
