//! Time and memory of simplification.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{Frame, TriMesh};
use neural_mesh::metrics::{Surface, quick_distance, surface_distance};
use neural_mesh::simplify::{ClosedOptions, Options, ScoreSource, Size, simplify};

use super::bench::{Bench, Blocks, LARGE, RATIOS, build_program, thread_pool};
use super::meshes::{bumpy_torus, hausdorff_distance, load};
use crate::baselines::meshoptimizer_faces;
use crate::cells::{MeshValue, count, least, median, n_values, one_decimal, spread, whole_number};
use crate::clock::{measure_program_time, measure_time, peak_bytes, reset_peak, thread_time};
use crate::evaluate::simplify_ours;
use crate::rows::{ResultRow, Table, median as median_of};
use crate::tables::{Column, Line, TextTable, pivot, ratio_lines};

const ROUNDS: usize = 3;
const FORMATS: [&str; 4] = ["ply", "stl", "obj", "off"];
const FORMAT_ROUNDS: usize = 5;
const FORMAT_FACES: usize = 1_000_000;
const GROWTH: [usize; 7] = [10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000];
// Number of input faces over all timed rounds of one mesh, which has one to nine rounds whatever its size.
const GROWTH_WORK: usize = 10_000_000;
const CHECK_RATIOS: [f64; 2] = [0.1, 0.5];
const QUICK_SAMPLES: usize = 8_000;
// Samples per surface of the reference measurement.
const MANY_SAMPLES: usize = 300_000;
// A result whose mean distance is below this fraction of the diagonal is skipped as noise.
const NOISE: f64 = 1e-6;
// A printed largest distance of at least this fraction of the certified one counts as correct.
const RIGHT: f64 = 0.97;

pub fn measure(bench: &Bench) -> Result<Blocks> {
    let test = bench.meshes("test")?;
    let speed =
        bench.measure("speed", &["quotient", "nanoseconds"], test.clone(), |name, path| measure_speed(name, path))?;
    let plys = test.iter().filter(|(_, path)| path.extension().is_some_and(|ending| ending == "ply")).cloned();
    let whole = bench.measure("whole", &["wall", "processor"], plys, |name, path| measure_whole(bench, name, path))?;
    let sizes = GROWTH.map(|n_faces| (count(n_faces), n_faces));
    let growth = bench.measure("growth", &["faces", "meshoptimizer", "one", "two", "memory"], sizes, measure_growth)?;
    let all = [("all".to_owned(), bench.meshes("train")?)];
    let batch = bench.measure("batch", &["rate", "quotient"], all, |_, meshes| measure_batch(bench, meshes))?;
    let formats = FORMATS.map(|format| (format.to_owned(), ()));
    let files =
        bench.measure("files", &["size", "read", "clean", "write"], formats, |name, ()| measure_format(bench, name))?;
    let check = bench
        .measure("check", &["deviation", "largest", "nanoseconds"], test, |name, path| measure_check(name, path))?;
    let spreads = |titles: &[(&str, &str, &str)]| -> Vec<Column<'static>> {
        let column = |&(title, figure, method): &(&str, &str, &str)| {
            Column::of_figure(title, figure, 1.0, spread).with_method(method)
        };
        titles.iter().map(column).collect()
    };
    let times = [("one thread", "one"), ("one thread, `--scores geometry`", "geometry"), ("two threads", "two")];
    let times = spreads(&times.map(|(title, method)| (title, "quotient", method)));
    let whole_times = spreads(&[("wall-clock time", "wall", ""), ("processor time", "processor", "")]);
    let rate = pivot(&batch, &[], &[Line::new([])], &spreads(&[("", "rate", ""), ("", "quotient", "")]));
    Ok(vec![
        ("speed", pivot(&speed, &["ratio"], &ratio_lines(&RATIOS), &times).markdown()),
        ("stages", stage_table(&speed).markdown()),
        ("growth", growth_table(&growth).markdown()),
        ("whole", pivot(&whole, &["ratio"], &ratio_lines(&RATIOS), &whole_times).markdown()),
        ("batch-rate", rate.lines[0][0].clone()),
        ("batch-quotient", rate.lines[0][1].clone()),
        ("files", file_table(&files).markdown()),
        ("check", check_table(&check).markdown()),
    ])
}

fn middle(values: impl IntoIterator<Item = f64>) -> f64 {
    median_of(values.into_iter().collect()).unwrap_or_default()
}

// Rows are of the default on one thread and on two, without scores, of each stage, of all stages, and of meshoptimizer.
fn measure_speed(name: &str, path: &Path) -> Result<Vec<ResultRow>> {
    let mesh = load(path)?;
    if mesh.faces().len() <= LARGE {
        return Ok(Vec::new());
    }
    Ok(RATIOS.iter().map(|&ratio| measure_speed_at(name, &mesh, ratio)).collect::<Result<Vec<_>>>()?.concat())
}

fn measure_speed_at(name: &str, mesh: &TriMesh, ratio: f64) -> Result<Vec<ResultRow>> {
    let n_left = (ratio * mesh.faces().len() as f64).round() as usize;
    let options = Options::new(Size::Faces(n_left));
    let geometry = ClosedOptions { scores: ScoreSource::Geometry, ..ClosedOptions::default() };
    let geometry = Options::with_closed(options.target, geometry);
    let [one, two] = [thread_pool(1)?, thread_pool(2)?];
    let (mut theirs, mut quotients) = (Vec::new(), [const { Vec::new() }; 3]);
    let mut stages: Vec<Vec<(String, f64)>> = Vec::new();
    for _ in 0..ROUNDS {
        let their = measure_time(|| Ok(meshoptimizer_faces(mesh, n_left)))?.1;
        let (found, ours) = one.install(|| measure_time(|| stage_times(mesh, &options)))?;
        let even = one.install(|| measure_time(|| stage_times(mesh, &geometry)))?.1;
        let shared = two.install(|| measure_time(|| stage_times(mesh, &options)))?.1;
        theirs.push(their.thread);
        quotients[0].push(ours.thread / their.thread);
        quotients[1].push(even.thread / their.thread);
        quotients[2].push(shared.wall / their.wall);
        stages.push(found);
    }
    let per_face = |seconds: f64| 1e9 * seconds / mesh.faces().len() as f64;
    let row = |method: &str, quotient, nanoseconds| ResultRow::new(name, ratio, method, &[quotient, nanoseconds]);
    let mut rows: Vec<ResultRow> = ["one", "geometry", "two"]
        .into_iter()
        .zip(quotients)
        .map(|(method, quotients)| row(method, middle(quotients), f64::NAN))
        .collect();
    let seconds = |at: usize| middle(stages.iter().filter_map(|run| run.get(at)).map(|stage| stage.1));
    let medians: Vec<f64> = (0..stages[0].len()).map(seconds).collect();
    rows.extend(stages[0].iter().zip(&medians).map(|(stage, &seconds)| row(&stage.0, f64::NAN, per_face(seconds))));
    rows.push(row("all", f64::NAN, per_face(medians.iter().sum())));
    rows.push(row("meshoptimizer's `simplify`", 1.0, per_face(middle(theirs))));
    Ok(rows)
}

fn stage_times(mesh: &TriMesh, options: &Options) -> Result<Vec<(String, f64)>> {
    let mut entered = vec![("beginning", thread_time())];
    simplify(mesh, options, &mut |event| {
        entered.push((event.stage, thread_time()));
        ControlFlow::Continue(())
    })?;
    entered.push(("end", thread_time()));
    let mut stages: Vec<(String, f64)> = Vec::new();
    for pair in entered.windows(2) {
        // Any thread may report with its own processor time, so a later report can have a smaller time.
        let seconds = pair[1].1.saturating_sub(pair[0].1).as_secs_f64();
        // A stage reports repeatedly while it runs.
        match stages.iter_mut().find(|stage| stage.0 == pair[0].0) {
            Some(stage) => stage.1 += seconds,
            None => stages.push((pair[0].0.into(), seconds)),
        }
    }
    Ok(stages)
}

fn stage_table(speed: &Table) -> TextTable {
    let timed = speed.filter(|row| speed.value(row, "nanoseconds").is_some());
    // The sum and meshoptimizer come after all stages, also those that only later meshes have.
    let (stages, sums): (Vec<&str>, Vec<&str>) =
        timed.methods().into_iter().partition(|name| *name != "all" && !name.starts_with("meshoptimizer"));
    let lines: Vec<Line> = stages.into_iter().chain(sums).map(|stage| Line::new([stage]).with_method(stage)).collect();
    let columns =
        RATIOS.map(|ratio| Column::of_figure(&ratio.to_string(), "nanoseconds", 1.0, median).with_ratio(ratio));
    pivot(&timed, &["stage"], &lines, &columns)
}

fn measure_growth(name: &str, &n_faces: &usize) -> Result<Vec<ResultRow>> {
    let mesh = bumpy_torus(n_faces);
    let n_faces = mesh.faces().len();
    let n_left = (0.1 * n_faces as f64).round() as usize;
    let [one, two] = [thread_pool(1)?, thread_pool(2)?];
    let ours = || simplify_ours(&mesh, None, Options::new(Size::Faces(n_left)));
    reset_peak()?;
    two.install(ours)?;
    let memory = peak_bytes()? as f64 / n_faces as f64;
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..(GROWTH_WORK / n_faces).clamp(1, 9) {
        times[0].push(measure_time(|| Ok(meshoptimizer_faces(&mesh, n_left)))?.1.thread);
        times[1].push(one.install(|| measure_time(ours))?.1.thread);
        times[2].push(two.install(|| measure_time(ours))?.1.wall);
    }
    let [theirs, one, two] = times.map(|seconds| 1e9 * middle(seconds) / n_faces as f64);
    Ok(vec![ResultRow::new(name, 0.1, "", &[n_faces as f64, theirs, one, two, memory])])
}

fn growth_table(growth: &Table) -> TextTable {
    let faces = |row: &ResultRow| count(growth.value(row, "faces").unwrap_or_default() as usize);
    let lines: Vec<Line> = growth.rows.iter().map(|row| Line::new([&faces(row)]).with_mesh(&row.mesh)).collect();
    let columns = [
        ("meshoptimizer", "meshoptimizer"),
        ("one thread", "one"),
        ("two threads", "two"),
        ("memory, bytes per face", "memory"),
    ];
    let columns = columns.map(|(title, figure)| Column::of_figure(title, figure, 1.0, whole_number));
    pivot(growth, &["faces"], &lines, &columns)
}

fn measure_whole(bench: &Bench, name: &str, path: &Path) -> Result<Vec<ResultRow>> {
    let n_faces = load(path)?.faces().len();
    if n_faces <= LARGE {
        return Ok(Vec::new());
    }
    let (program, output) = (build_program()?, bench.scratch("whole")?.join("out.ply"));
    let measure_ratio = |ratio: f64| {
        let mut ours = Command::new(&program);
        ours.arg("simplify").arg(path).arg("-o").arg(&output);
        ours.args(["--quiet", "--force", "--ratio", &ratio.to_string()]);
        let mut other = Command::new(std::env::current_exe()?);
        let n_left = (ratio * n_faces as f64).round() as usize;
        other.arg("whole-other").arg(path).arg(&output).arg(n_left.to_string());
        let mut rounds = [const { Vec::new() }; 2];
        for _ in 0..ROUNDS {
            let (own, other) = (measure_program_time(&mut ours)?, measure_program_time(&mut other)?);
            (0..2).for_each(|at| rounds[at].push(own[at] / other[at]));
        }
        Ok(ResultRow::new(name, ratio, "", &rounds.map(middle)))
    };
    RATIOS.iter().map(|&ratio| measure_ratio(ratio)).collect()
}

// Rates are in meshes per second: in one batch, and over one process per mesh.
fn measure_batch(bench: &Bench, meshes: &[(String, PathBuf)]) -> Result<Vec<ResultRow>> {
    let (program, folder) = (build_program()?, bench.scratch("batch")?);
    let simplify = |arguments: &mut dyn FnMut(&mut Command)| {
        let mut command = Command::new(&program);
        command.args(["simplify", "--ratio", "0.1", "--quiet", "--force"]);
        arguments(&mut command);
        Ok::<f64, anyhow::Error>(measure_program_time(&mut command)?[0])
    };
    let round = |_| {
        let mut one_by_one = 0.0;
        for (name, mesh) in meshes {
            let output = folder.join(name).with_extension("ply");
            one_by_one += simplify(&mut |command| {
                command.arg(mesh).arg("-o").arg(&output).args(["--threads", "1"]);
            })?;
        }
        let at_once = simplify(&mut |command| {
            command.args(meshes.iter().map(|(_, path)| path)).arg("-o").arg(folder.join("all"));
        })?;
        std::fs::remove_dir_all(folder.join("all"))?;
        Ok(ResultRow::new("all", 0.1, "", &[meshes.len() as f64 / at_once, one_by_one / at_once]))
    };
    (0..ROUNDS).map(round).collect()
}

// Bytes per face, and nanoseconds per face of reading, cleaning and writing.
fn measure_format(bench: &Bench, name: &str) -> Result<Vec<ResultRow>> {
    let format = Format::from_name(name).context("no such format")?;
    let path = bench.scratch("files")?.join("mesh").with_extension(name);
    let mesh = bumpy_torus(FORMAT_FACES);
    let n_faces = mesh.faces().len() as f64;
    let times = thread_pool(1)?.install(|| -> Result<_> {
        let mut times = [const { Vec::new() }; 3];
        for _ in 0..FORMAT_ROUNDS {
            let writing = measure_time(|| Ok(write_path(&path, &write(&mesh, &Frame::default(), format)?, true)?))?.1;
            let (raw, reading) = measure_time(|| Ok(read_path(&path, None)?))?;
            let cleaning = measure_time(|| Ok(clean(raw, &CleanOptions::default())?))?.1;
            times.iter_mut().zip([reading, cleaning, writing]).for_each(|(all, time)| all.push(time.thread));
        }
        Ok(times)
    })?;
    let size = path.metadata()?.len() as f64 / n_faces;
    std::fs::remove_file(path)?;
    let [read, clean, write] = times.map(|seconds| 1e9 * middle(seconds) / n_faces);
    Ok(vec![ResultRow::new(name, 1.0, "", &[size, read, clean, write])])
}

fn file_table(files: &Table) -> TextTable {
    let lines = FORMATS.map(|format| Line::new([format]).with_mesh(format));
    let times = ["read", "clean", "write"].map(|title| Column::of_figure(title, title, 1.0, one_decimal));
    let size = Column::of_figure("bytes per face", "size", 1.0, whole_number);
    pivot(files, &["format"], &lines, &[size].into_iter().chain(times).collect::<Vec<_>>())
}

// Deviation of the mean in percent, largest distance over the certified one, nanoseconds per input face.
fn measure_check(name: &str, path: &Path) -> Result<Vec<ResultRow>> {
    let mesh = load(path)?;
    let original = Surface::new(&mesh, MANY_SAMPLES, 77);
    let mut rows = Vec::new();
    for ratio in CHECK_RATIOS {
        let result = simplify_ours(&mesh, None, Options::new(Size::Ratio(ratio)))?;
        let many = surface_distance(&original, &Surface::new(&result, MANY_SAMPLES, 78)).context("no faces")?;
        let one = thread_pool(1)?;
        let (quick, time) = one.install(|| measure_time(|| Ok(quick_distance(&mesh, &result, QUICK_SAMPLES, 0))))?;
        let quick = quick.context("nothing to measure")?;
        if many.both.mean > NOISE * many.diagonal {
            let off = 100.0 * (quick.mean / many.both.mean - 1.0).abs();
            let largest = quick.max / hausdorff_distance(&mesh, &result)?;
            let nanoseconds = 1e9 * time.thread / mesh.faces().len() as f64;
            rows.push(ResultRow::new(name, ratio, "", &[off, largest, nanoseconds]));
        }
    }
    Ok(rows)
}

fn check_table(check: &Table) -> TextTable {
    let percent = |values: &[MeshValue]| format!("{} %", median(values).text).into();
    let worst =
        |values: &[MeshValue]| format!("{:.1} %", values.iter().fold(0.0, |most: f64, value| most.max(value.1))).into();
    let n_right = move |table: &Table, rows: &[&ResultRow]| {
        let is_right = |row: &&&ResultRow| table.value(row, "largest") >= Some(RIGHT);
        format!("{} of {}", rows.iter().filter(is_right).count(), rows.len()).into()
    };
    let columns = [
        Column::of_figure("meshes", "deviation", 1.0, n_values),
        Column::of_figure("mean: median deviation", "deviation", 1.0, percent),
        Column::of_figure("worst", "deviation", 1.0, worst),
        Column::of_figure("largest / certified: median", "largest", 1.0, median),
        Column::of_figure("least", "largest", 1.0, least),
        Column::new("within 3 %", n_right),
        Column::of_figure("time, ns per face", "nanoseconds", 1.0, whole_number),
    ];
    pivot(check, &["ratio"], &ratio_lines(&CHECK_RATIOS)[..2], &columns)
}
