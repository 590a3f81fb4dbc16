//! Measurements of asset features.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{DistanceTolerance, Surface, certified_distance, surface_distance};
use neural_mesh::search::simplify_to_error;
use neural_mesh::simplify::{ClosedOptions, Input, Options, Size, simplify_levels_of_detail};

use super::bench::{Bench, Blocks, LARGE, RATIOS, root, thread_pool};
use super::meshes::load;
use super::textured::compare_model;
use crate::baselines::{Baseline, TargetCounts, simplify_by};
use crate::cells::{Cell, MeshValue, Show, largest, least, median, one_decimal, three_decimals, whole_number};
use crate::clock::measure_time;
use crate::evaluate::{Settings, simplify_ours};
use crate::rows::{ResultRow, Table, median as median_of};
use crate::tables::{Column, Line, TextTable, pivot, ratio_lines};

// Models made by `scripts/textured_models.py`.
const MODELS: [&str; 4] = ["planet", "vase", "terrain", "statue"];
// Beginnings of the names of the training meshes that are machine parts.
const PARTS: [&str; 6] = ["csg_", "jaco_", "so101_", "soarm_", "wingnut", "hammer"];
const PROVED: [(&str, &str); 10] = [
    ("train", "celtic_skull"),
    ("train", "csg_bracket"),
    ("train", "dog_pose0"),
    ("train", "human_skull"),
    ("train", "koala"),
    ("train", "penguin"),
    ("train", "so101_wrist_roll_pitch_v2"),
    ("train", "statue_ugolino"),
    ("test", "nefertiti"),
    ("test", "spot"),
];
// Bounds of the largest distance in percent of the diagonal.
const LIMITS: [f64; 2] = [1.0, 0.25];
const PROOF_SAMPLES: usize = 200_000;
const SAMPLES: usize = 50_000;
const LEVELS: [f64; 4] = [0.5, 0.25, 0.1, 0.05];
const ROUNDS: usize = 3;

const SPREAD: [(&str, Show); 3] = [("median", median), ("least", least), ("largest", largest)];

pub fn measure(bench: &Bench) -> Result<Blocks> {
    let mut blocks = vec![("textured", measure_textures(bench)?), ("machine-parts", measure_parts(bench)?)];
    blocks.extend(measure_proofs(bench)?);
    blocks.push(("levels", measure_levels(bench)?));
    Ok(blocks)
}

// A line for each aggregate, a column for each titled figure.
fn aggregate_table(rows: &Table, figures: &[(String, &str)], shows: &[(&str, Show)]) -> TextTable {
    let line = |&(name, show): &(&str, Show)| {
        let columns: Vec<Column> =
            figures.iter().map(|(title, figure)| Column::of_figure(title, figure, 1.0, show)).collect();
        pivot(rows, &[""], &[Line::new([name])], &columns)
    };
    shows.iter().map(line).fold(TextTable::default(), TextTable::with_lines_of)
}

fn mesh_lines(rows: &Table) -> Vec<Line> {
    rows.meshes().into_iter().map(|mesh| Line::new([mesh]).with_mesh(mesh)).collect()
}

fn signed_median(values: &[MeshValue]) -> Cell {
    let middle = median_of(values.iter().map(|(_, value)| *value).collect()).unwrap_or_default();
    format!("{middle:+.2}").into()
}

fn n_positive(values: &[MeshValue]) -> Cell {
    let n_positive = values.iter().filter(|(_, value)| *value > 0.0).count();
    format!("{n_positive} of {}", values.len()).into()
}

fn measure_textures(bench: &Bench) -> Result<String> {
    let given = ["spot_textured/spot.obj", "duck.glb"].map(|file| bench.set_folder("test").join(file));
    let made = MODELS.map(|name| PathBuf::from(name).with_extension("obj"));
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let items = given.into_iter().chain(made).map(|path| (name(&path), path));
    let figures = ["faces", "distance", "likeness", "quotient", "gain"];
    let rows = bench
        .measure("textured", &figures, items, |name, path| compare_model(name, &make_model(bench, path)?, &RATIOS))?;
    let methods = [("neural-mesh", "ours"), ("meshoptimizer normals", "normals"), ("meshoptimizer uv", "uv")];
    let of_methods = |title: &str, figure: &str, factor: f64, show: Show| {
        methods.map(|(name, method)| {
            Column::of_figure(&format!("{title}: {name}"), figure, factor, show).with_method(method)
        })
    };
    let columns: Vec<Column> = of_methods("faces", "faces", 1.0, whole_number)
        .into_iter()
        .chain(of_methods("distance in 1/1000 of the diagonal", "distance", 1e3, three_decimals))
        .chain([Column::of_figure("distance: quotient", "quotient", 1.0, median)])
        .chain(of_methods("PSNR in dB", "likeness", 1.0, median))
        .chain([Column::of_figure("PSNR: difference", "gain", 1.0, signed_median)])
        .collect();
    let at = |mesh: &str| RATIOS.map(|ratio| Line::new([mesh, &ratio.to_string()]).with_mesh(mesh).with_ratio(ratio));
    let lines: Vec<Line> = rows.meshes().into_iter().flat_map(at).collect();
    bench.write_csv("assets-textured", &pivot(&rows, &["model", "ratio"], &lines, &columns))?;
    let columns = [
        Column::of_figure("distance, quotient: median", "quotient", 1.0, median),
        Column::of_figure("PSNR, difference in dB: median", "gain", 1.0, signed_median),
        Column::of_figure("PSNR better on", "gain", 1.0, n_positive),
    ];
    Ok(pivot(&rows, &["ratio"], &ratio_lines(&RATIOS), &columns).markdown())
}

fn make_model(bench: &Bench, path: &Path) -> Result<PathBuf> {
    if path.exists() {
        return Ok(path.into());
    }
    let folder = bench.scratch("models")?;
    if !folder.join(path).exists() {
        let source = bench.set_folder("train").join("obj_caballito.ply");
        let mut python = Command::new("python3");
        python.arg(root().join("scripts/textured_models.py")).arg(source).arg(&folder);
        ensure!(python.status().context("python3")?.success(), "scripts/textured_models.py failed: it needs numpy");
    }
    Ok(folder.join(path))
}

fn measure_parts(bench: &Bench) -> Result<String> {
    let meshes = bench.meshes("train")?;
    let is_there = |part: &&&str| meshes.iter().any(|(name, _)| name.starts_with(**part));
    let settings = Settings {
        methods: ["closed", "meshopt"].map(String::from).into(),
        ratios: RATIOS.into(),
        repeats: 1,
        only: PARTS.iter().filter(is_there).map(|part| part.to_string()).collect(),
        ..Settings::default()
    };
    let rows = bench.evaluate_set("machine-parts", "train", settings, None)?.with_quotients_over("meshopt");
    let rows = rows.filter(|row| row.method == "closed");
    let figures = [
        ("mean distance", "/distance_mean"),
        ("largest distance", "/distance_max"),
        ("normal error", "/normal_error_signed"),
    ];
    let columns = figures.map(|(title, figure)| {
        [Column::of_figure(title, figure, 1.0, median), Column::of_figure("worst ratio", figure, 1.0, largest)]
    });
    let columns: Vec<Column> = columns.into_iter().flatten().collect();
    bench.write_csv("assets-machine-parts", &pivot(&rows, &["part"], &mesh_lines(&rows), &columns))?;
    let figures = figures.map(|(title, figure)| (title.to_owned(), figure));
    Ok(aggregate_table(&rows, &figures, &[("median", median), ("worst", largest)]).markdown())
}

fn measure_proofs(bench: &Bench) -> Result<Blocks> {
    let path = |set: &str, mesh: &str| bench.set_folder(set).join(mesh).with_extension("ply");
    let items = PROVED.map(|(set, mesh)| (mesh.to_owned(), path(set, mesh)));
    let figures = ["proved", "sampled", "ours", "theirs", "quotient", "seconds"];
    let rows = bench.measure("proofs", &figures, items, |name, path| {
        LIMITS.iter().map(|&limit| prove_limit(name, path, limit)).collect()
    })?;
    let lines = rows
        .meshes()
        .into_iter()
        .flat_map(|mesh| LIMITS.map(|limit| Line::new([mesh, &limit.to_string()]).with_mesh(mesh).with_ratio(limit)));
    let columns = [
        Column::of_figure("proved, %", "proved", 1.0, three_decimals),
        Column::of_figure("sampled, %", "sampled", 1.0, three_decimals),
        Column::of_figure("faces, ours", "ours", 1.0, whole_number),
        Column::of_figure("faces, meshoptimizer", "theirs", 1.0, whole_number),
        Column::of_figure("ours / meshoptimizer", "quotient", 1.0, median),
        Column::of_figure("seconds", "seconds", 1.0, one_decimal),
    ];
    let csv = pivot(&rows, &["mesh", "limit, %"], &lines.collect::<Vec<_>>(), &columns);
    bench.write_csv("assets-certain-distances", &csv)?;
    let n_over = rows.rows.iter().filter(|row| rows.value(row, "sampled") > Some(row.ratio)).count();
    let spread = aggregate_table(&rows, &[(String::new(), "quotient")], &SPREAD);
    let [middle, least, largest] = [0, 1, 2].map(|line| &spread.lines[line][1]);
    Ok(vec![
        ("proofs-exceeded", format!("{n_over} of {}", rows.rows.len())),
        ("proofs-faces", format!("{middle}, from {least} to {largest}")),
    ])
}

// The limit, in percent of the diagonal, takes the place of the ratio.
fn prove_limit(name: &str, path: &Path, limit: f64) -> Result<ResultRow> {
    let mesh = load(path)?;
    let (input, options, diagonal) = (Input::bare(&mesh), ClosedOptions::default(), mesh.diagonal());
    let error = 0.01 * limit * diagonal;
    let (ours, time) =
        measure_time(|| Ok(simplify_to_error(&input, &options, error, &mut |_| ControlFlow::Continue(()))?))?;
    let lighter = &ours.simplified.mesh;
    let found = surface_distance(&Surface::new(&mesh, PROOF_SAMPLES, 5), &Surface::new(lighter, PROOF_SAMPLES, 6));
    let [proved, sampled] =
        [ours.distance.upper, found.context("no faces")?.both.max].map(|distance| 100.0 * distance / diagonal);
    let [own, theirs] = [lighter.faces().len(), fewest_faces(&mesh, error)?].map(|n| n as f64);
    Ok(ResultRow::new(name, limit, "closed", &[proved, sampled, own, theirs, own / theirs, time.wall]))
}

// Searches the smallest result of meshoptimizer that is proved to be within a distance.
fn fewest_faces(mesh: &TriMesh, error: f64) -> Result<usize> {
    let wanted = DistanceTolerance { enough: error, too_much: error, gap: 0.0 };
    let (mut too_few, mut enough) = (0usize, mesh.faces().len());
    let mut fewest = enough;
    while enough as f64 > (too_few as f64 * 1.02).max(too_few as f64 + 2.0) {
        let middle = if too_few == 0 { enough / 4 } else { too_few.midpoint(enough) };
        let result = simplify_by(Baseline::Meshoptimizer, mesh, TargetCounts { vertices: middle, faces: middle }, 0)?;
        let holds = certified_distance(mesh, &result, &wanted).is_some_and(|distance| distance.upper <= error);
        if holds {
            (enough, fewest) = (middle, fewest.min(result.faces().len()));
        } else {
            too_few = middle;
        }
        if holds && result.faces().len() > middle {
            break;
        }
    }
    Ok(fewest)
}

fn mean_distance(original: &Surface, simplified: &TriMesh) -> Result<f64> {
    Ok(surface_distance(original, &Surface::new(simplified, SAMPLES, 1)).context("no faces")?.both.mean)
}

fn measure_levels(bench: &Bench) -> Result<String> {
    let names = ["faces", "seconds", "time", "distance_0", "distance_1", "distance_2", "distance_3"];
    let rows = bench.measure("levels", &names, bench.meshes("test")?, |name, path| compare_levels(name, path))?;
    let distances = LEVELS.iter().zip(&names[3..]);
    let distances = distances.map(|(ratio, figure)| (format!("mean distance at {ratio}"), *figure));
    let figures: Vec<(String, &str)> = [("time".to_owned(), "time")].into_iter().chain(distances).collect();
    let sizes = [
        Column::of_figure("faces", "faces", 1.0, whole_number),
        Column::of_figure("four runs, s", "seconds", 1.0, three_decimals),
    ];
    let columns = figures.iter().map(|(title, figure)| Column::of_figure(title, figure, 1.0, median));
    let columns: Vec<Column> = sizes.into_iter().chain(columns).collect();
    bench.write_csv("assets-levels", &pivot(&rows, &["mesh"], &mesh_lines(&rows), &columns))?;
    Ok(aggregate_table(&rows, &figures, &SPREAD).markdown())
}

fn compare_levels(name: &str, path: &Path) -> Result<Vec<ResultRow>> {
    let mesh = load(path)?;
    if mesh.faces().len() <= LARGE {
        return Ok(Vec::new());
    }
    let one = thread_pool(1)?;
    let (mut alone, mut quotients) = (Vec::new(), Vec::new());
    let (mut chain, mut single) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let (levels, together) = one.install(|| measure_time(|| simplify_levels(&mesh)))?;
        let (results, apart) = one.install(|| measure_time(|| simplify_each(&mesh)))?;
        quotients.push(together.thread / apart.thread);
        alone.push(apart.thread);
        (chain, single) = (levels, results);
    }
    let original = Surface::new(&mesh, SAMPLES, 0);
    let [seconds, time] = [alone, quotients].map(|values| median_of(values).unwrap_or_default());
    let mut figures = vec![mesh.faces().len() as f64, seconds, time];
    for (level, run) in chain.iter().zip(&single) {
        figures.push(mean_distance(&original, level)? / mean_distance(&original, run)?);
    }
    Ok(vec![ResultRow::new(name, 1.0, "closed", &figures)])
}

fn simplify_levels(mesh: &TriMesh) -> Result<Vec<TriMesh>> {
    let (input, options, targets) = (Input::bare(mesh), ClosedOptions::default(), LEVELS.map(Size::Ratio));
    let levels = simplify_levels_of_detail(input, &options, &targets, &mut |_| ControlFlow::Continue(()))?;
    Ok(levels.into_iter().map(|level| level.mesh).collect())
}

fn simplify_each(mesh: &TriMesh) -> Result<Vec<TriMesh>> {
    LEVELS.into_iter().map(|ratio| simplify_ours(mesh, None, Options::new(Size::Ratio(ratio)))).collect()
}
