//! The paper's tables: Table 1, simplified meshes; Table 2, samplers.

pub mod cost;
mod maps;
mod print;
mod samplers;
pub mod sizes;
mod table_1;

use std::ops::ControlFlow;
use std::path::PathBuf;

use crate::evaluate::{Facts, Overview, Settings, Table, overview};
use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, chamfer, open_edges, surface_distance};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Options, PaperOptions, Target, simplify};

use super::{RATIOS, write_csv};
use crate::measure::root;
use crate::measure::workbench::Bench;

// TOSCA's classes that the weights have not seen.
pub const CLASSES: [&str; 4] = ["cat", "gorilla", "victoria", "wolf"];
pub const METHODS: [&str; 10] = [
    "paper",
    "paper-closed",
    "paper-placed",
    "pointtrinet",
    "dse",
    "potamias",
    "qem",
    "meshopt",
    "farthest-bpa",
    "uniform-bpa",
];
// First letters of the meshes of `test` with at most 41 thousand faces; `pointtrinet` takes minutes for more.
const OF_TEST: [&str; 20] = [
    "eight",
    "suzanne",
    "cow",
    "spot",
    "teapot",
    "duck",
    "anchor",
    "fertility",
    "casting",
    "max_planck",
    "knot2",
    "homer",
    "fandisk",
    "cheburashka",
    "screwdriver",
    "rocker_arm",
    "camelhead",
    "mannequin_devil",
    "beetle",
    "elephant",
];
// Text that compares the order of the methods with that in the paper.
const ORDER: &str = "\nThe order by WA is the same in both.\n\n\
    - **CD:** `dse` and `potamias` change places at 0.05, where they are nearly equal, and at 0.1. The layers of `dse` have an eighth of the \
    paper's widths here.\n\
    - **time:** `qem` is written in Rust and takes a tenth of the printed seconds. `pointtrinet` has a quarter of the widths and runs on one \
    thread.\n\n\
    The paper reports that its method is better than the three learned ones in WA and time at every ratio, and in CD from 0.1 on. \
    Here the mean of `paper` is the best of these four in WA, time and CD at every ratio.\n";
// Time limit of a run in seconds.
const TIME_LIMIT: f64 = 1800.0;

pub fn page(bench: &Bench) -> Result<String> {
    let [tosca, test] = [evaluate_tosca(bench)?, evaluate_test(bench)?];
    let [of_tosca, of_test] = [&tosca, &test].map(|rows| overview(rows, Some(table_1::REFERENCE)));
    let rows = [table_1::csv_rows("TOSCA", &of_tosca), table_1::csv_rows("test", &of_test)].concat();
    let link = write_csv("paper-table-1", &table_1::csv_head(), &rows)?;
    Ok(format!(
        "Methods and figures are defined in [evaluate.md](../evaluate.md); CD is in 1e-6 of the squared diagonal. The closed assembly on \
         these meshes: [weights.md](weights.md). Figure 6: [pictures.md](pictures.md).\n\n\
         ## Table 1: simplified meshes\n\n{}{}{}\n\
         ## Learned and exact maps\n\n{}\n## Table 2: samplers\n\n{}",
        first_part(&of_tosca, &link),
        print::format_comparison(&tosca) + ORDER,
        other_meshes(&of_test),
        maps::section(bench)?,
        samplers::table_2(bench)?
    ))
}

fn first_part(summary: &Overview, link: &str) -> String {
    let Facts { meshes, samples, runs, machines, .. } = &summary.facts;
    let samples: Vec<String> = samples.iter().map(ToString::to_string).collect();
    format!(
        "The {meshes} cats, gorillas, victorias and wolves of TOSCA (Bronstein, Bronstein and Kimmel 2008). The weights of `paper`, \
         `weights/paper-tosca.safetensors`, were trained on other classes. {} samples on each surface. Times: {}, runs per case: {runs}.\n\n\
         Cells are means over the meshes, lower is better, the best mean is bold. `paper-closed` also fills holes, \
         `paper-placed` also moves vertices. Medians, quotients at every ratio, and the number of results: {link}.\n{}\n\
         ### Quotients at {}\n\n\
         Medians of the quotients over `qem` per mesh, without meshes where `qem` has 0; the CSV has their number.\n\n{}\n",
        samples.join(", "),
        machines.join("; "),
        table_1::format_means(summary),
        summary.ratios[0],
        table_1::format_quotients(summary, 0)
    )
}

fn other_meshes(summary: &Overview) -> String {
    format!(
        "\n### Other meshes\n\nThe CSV also has the {} meshes of `test` with at most 41 thousand faces, with the weights that ship. There the \
         medians of CD of `paper` over that of `qem` are {} at {}.\n",
        summary.facts.meshes,
        table_1::format_chamfer_quotients(summary, METHODS[0]),
        RATIOS.map(|ratio| ratio.to_string()).join(", ")
    )
}

/// Returns the settings of an evaluation of the classes.
pub fn settings(methods: &[&str]) -> Settings {
    Settings {
        methods: methods.iter().map(|name| name.to_string()).collect(),
        ratios: RATIOS.into(),
        repeats: 1,
        time_limit: TIME_LIMIT,
        only: CLASSES.map(String::from).into(),
        ..Settings::default()
    }
}

/// Returns the settings of the evaluation of all methods, with the spectrum.
pub fn with_spectrum() -> Settings {
    let mut settings = settings(&METHODS);
    settings.spectrum = true;
    settings
}

/// Returns the path of the weights trained on TOSCA.
pub fn weights() -> PathBuf {
    root().join("weights/paper-tosca.safetensors")
}

fn evaluate_tosca(bench: &Bench) -> Result<Table> {
    bench.evaluate_set("paper", "tosca", with_spectrum(), Some(weights()))
}

fn evaluate_test(bench: &Bench) -> Result<Table> {
    let mut settings = with_spectrum();
    settings.only = OF_TEST.map(String::from).into();
    bench.evaluate_set("paper-test", "test", settings, None)
}

/// Simplifies by the paper's assembly, without weights by those that ship.
fn simplify_by_paper(mesh: &TriMesh, weights: Option<&Weights>, ratio: f64) -> Result<TriMesh> {
    let options = Options::with_paper(Target::Ratio(ratio), PaperOptions::default());
    Ok(simplify(mesh, weights, &options, &mut |_| ControlFlow::Continue(()))?.mesh)
}

/// Returns CD in 1e-6 of the squared diagonal, NE, and WA in percent, with as many samples as the original has.
fn measure_result(mesh: &TriMesh, original: &Surface, simplified: &TriMesh) -> Result<[f64; 3]> {
    let surface = Surface::new(simplified, original.samples.len(), 1);
    let cd = chamfer(&original.samples, &surface.samples).context("the result is empty")?.sum();
    let distance = surface_distance(original, &surface).context("the result is empty")?;
    let open = open_edges(mesh, simplified).wa_percent();
    Ok([1e6 * cd / original.diagonal.powi(2), distance.both.unsigned_normal_error, open])
}
