//! The paper's Table 1, simplified meshes, and the paper's figures next to ours; Table 2 is in `samplers`.

use anyhow::Result;

use super::bench::{Bench, Blocks, CLASSES, RATIOS, tosca_weights};
use super::benchmark::inspect_inputs;
use super::samplers;
use crate::cells::{mean_digits, median_digits, n_values, number};
use crate::evaluate::Settings;
use crate::rows::Table;
use crate::tables::{Column, Line, TextTable, pivot};

const METHODS: [&str; 10] = [
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
// Largest number of faces of other meshes; `pointtrinet` takes minutes for more.
const MOST_FACES: f64 = 41_000.0;
// Time limit of a run in seconds.
const TIME_LIMIT: f64 = 1800.0;
// Method by whose figures the others are divided.
const REFERENCE: &str = "qem";
// Title, figure and factor of a column.
const COLUMNS: [(&str, &str, f64); 5] = [
    ("CD", "chamfer", 1e6),
    ("WA, %", "edges_without_two_faces", 1.0),
    ("LE", "laplacian_functions", 1.0),
    ("NE", "normal_error", 1.0),
    ("time, s", "seconds", 1.0),
];

pub fn measure(bench: &Bench) -> Result<Blocks> {
    let with_spectrum = |only: &[&str]| Settings { spectrum: true, ..settings(&METHODS, only) };
    let tosca = bench
        .evaluate_set("paper", "tosca", with_spectrum(&CLASSES), Some(tosca_weights()))?
        .with_quotients_over(REFERENCE);
    let inputs = inspect_inputs(bench)?;
    let small = inputs.rows.iter().filter(|row| inputs.value(row, "faces") <= Some(MOST_FACES));
    let small: Vec<&str> = small.map(|row| row.mesh.as_str()).collect();
    let test = bench.evaluate_set("paper-test", "test", with_spectrum(&small), None)?.with_quotients_over(REFERENCE);
    let csv = [("TOSCA", &tosca), ("test", &test)].map(|(meshes, rows)| csv_table(meshes, rows));
    let csv = csv.into_iter().fold(TextTable::default(), TextTable::with_lines_of);
    bench.write_csv("paper-table-1", &csv)?;
    let chamfers = RATIOS.map(|ratio| {
        let column = [Column::of_figure("", "/chamfer", 1.0, median_digits)];
        pivot(&test, &[], &[Line::new([]).with_method("paper").with_ratio(ratio)], &column).lines[0][0].clone()
    });
    let means = ["table-1-at-0.05", "table-1-at-0.1", "table-1-at-0.2", "table-1-at-0.5"];
    let means = means.into_iter().zip(RATIOS).map(|(name, ratio)| (name, mean_table(&tosca, ratio).markdown()));
    let mut blocks: Blocks = means.collect();
    blocks.extend([
        ("quotients", quotient_table(&tosca).markdown()),
        ("comparison", comparison(&tosca).markdown()),
        ("order", order_table(&tosca).markdown()),
        ("chamfer-of-test", chamfers.join(", ")),
    ]);
    blocks.extend(samplers::measure(bench)?);
    Ok(blocks)
}

/// Returns the settings of an evaluation of methods at all ratios.
fn settings(methods: &[&str], only: &[&str]) -> Settings {
    let [methods, only] = [methods, only].map(|names| names.iter().map(|name| name.to_string()).collect());
    Settings { methods, only, ratios: RATIOS.into(), repeats: 1, time_limit: TIME_LIMIT, ..Settings::default() }
}

/// Returns the settings of an evaluation of methods on TOSCA's unseen classes.
pub fn class_settings(methods: &[&str]) -> Settings {
    settings(methods, &CLASSES)
}

fn lines() -> [Line; 10] {
    METHODS.map(|method| Line::new([method]).with_method(method))
}

fn mean_table(rows: &Table, ratio: f64) -> TextTable {
    let column = |(title, figure, factor): (&str, &str, f64)| {
        Column::of_figure(title, figure, factor, mean_digits).with_ratio(ratio).with_best()
    };
    pivot(rows, &["method"], &lines(), &COLUMNS.map(column))
}

fn quotient_table(rows: &Table) -> TextTable {
    let column = |(title, figure, _): (&str, &str, f64)| {
        Column::of_figure(short(title), &format!("/{figure}"), 1.0, median_digits).with_ratio(RATIOS[0])
    };
    pivot(rows, &["method / qem"], &lines(), &COLUMNS.map(column))
}

fn csv_table(meshes: &str, rows: &Table) -> TextTable {
    let columns = |(title, figure, factor): (&str, &str, f64)| {
        let (title, quotient) = (short(title), format!("/{figure}"));
        [
            Column::of_figure(&format!("{title} mean"), figure, factor, mean_digits),
            Column::of_figure(&format!("{title} median"), figure, factor, median_digits),
            Column::of_figure(&format!("{title} / {REFERENCE}"), &quotient, 1.0, median_digits),
            Column::of_figure("quotients", &quotient, 1.0, n_values),
        ]
    };
    let columns: Vec<Column> =
        [Column::of_results()].into_iter().chain(COLUMNS.into_iter().flat_map(columns)).collect();
    let line = |ratio: f64| {
        METHODS.map(|method| Line::new([meshes, &ratio.to_string(), method]).with_method(method).with_ratio(ratio))
    };
    pivot(rows, &["meshes", "ratio", "method"], &RATIOS.map(line).concat(), &columns)
}

// Title of a column without its unit.
fn short(title: &str) -> &str {
    title.split(',').next().unwrap_or_default()
}

// The paper's Table 1 (Potamias et al. 2022), with seconds for 20 meshes, and its methods.
const TABLE_1: &str = include_str!("printed_table_1.csv");
const PRINTED_METHODS: [&str; 5] = ["paper", "pointtrinet", "dse", "potamias", "qem"];
// Number of meshes in the printed times.
const TIMED_MESHES: f64 = 20.0;
// Ratio by whose figures methods are put in order.
const ORDER_RATIO: f64 = RATIOS[1];

fn printed_cells(ratio: f64, method: &str) -> [f64; 5] {
    let line = TABLE_1.lines().find_map(|line| line.strip_prefix(&format!("{method},{ratio},")));
    let mut cells = line.expect("a line of each method").split(',').map(|cell| cell.parse().expect("a number"));
    std::array::from_fn(|_| cells.next().expect("five columns"))
}

// Our means in the paper's columns.
fn mean_cells(rows: &Table, ratio: f64, method: &str) -> [Option<f64>; 5] {
    let [chamfer, open, spectrum, angle, seconds] =
        ["chamfer", "edges_without_two_faces", "laplacian_functions", "normal_angle", "seconds"]
            .map(|figure| rows.mean(ratio, method, figure));
    [chamfer, open, spectrum, angle.map(f64::to_radians), seconds.map(|seconds| TIMED_MESHES * seconds)]
}

fn comparison(rows: &Table) -> TextTable {
    let line = |(ratio, method): (f64, &str)| {
        let [mut here, qem] = [method, REFERENCE].map(|method| mean_cells(rows, ratio, method));
        let [mut print, printed_qem] = [method, REFERENCE].map(|method| printed_cells(ratio, method));
        // The paper gives no unit of CD.
        here[0] = here[0].zip(qem[0]).map(|(own, qem)| own / qem);
        print[0] /= printed_qem[0];
        let cells = here.into_iter().zip(print);
        let cells = cells.map(|(here, print)| format!("{} / {}", number(here), number(Some(print))));
        [ratio.to_string(), format!("`{method}`")].into_iter().chain(cells).collect()
    };
    let head = ["ratio", "method", "CD over `qem`'s", "WA, %", "LE", "NE, radians", "s for 20 meshes"];
    let cases = RATIOS.into_iter().flat_map(|ratio| PRINTED_METHODS.map(|method| (ratio, method)));
    TextTable { head: head.map(String::from).into(), lines: cases.map(line).collect() }
}

fn order_table(rows: &Table) -> TextTable {
    let sorted = |value: &dyn Fn(&str) -> f64| {
        let mut methods = PRINTED_METHODS;
        methods.sort_by(|a, b| value(a).total_cmp(&value(b)));
        methods.join(", ")
    };
    let line = |(name, column): (&str, usize)| {
        let here = |method: &str| mean_cells(rows, ORDER_RATIO, method)[column].unwrap_or(f64::INFINITY);
        vec![name.into(), sorted(&here), sorted(&|method| printed_cells(ORDER_RATIO, method)[column])]
    };
    let head = ["figure", "here", "in the paper"].map(String::from).into();
    TextTable { head, lines: [("CD", 0), ("WA", 1), ("time", 4)].map(line).into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::ResultRow;

    #[test]
    fn cells_pair_our_figures_with_the_papers_and_methods_are_ordered() {
        let row = |method: &str, chamfer, seconds| ResultRow::new("a", 0.1, method, &[chamfer, seconds]);
        let rows = vec![row("qem", 2.0, 0.5), row("paper", 3.0, 0.25), row("dse", 8.0, 1.0)];
        let rows = Table::new(&["chamfer", "seconds"], rows);
        let text = comparison(&rows).markdown();
        let line = "| 0.1 | `paper` | 1.50 / 1.91 | - / 2.21 | - / 0.47 | - / 0.15 | 5.00 / 4.20 |";
        assert!(text.contains(line), "{text}");
        let text = order_table(&rows).markdown();
        assert!(text.contains("| time | paper, qem, dse, "), "{text}");
        assert!(text.contains("| qem, paper, pointtrinet, dse, potamias |"), "{text}");
    }

    #[test]
    fn the_page_has_means_and_the_csv_all_figures() {
        let row = |mesh: &str, method: &str, chamfer| ResultRow::new(mesh, 0.1, method, &[chamfer, 0.5]);
        let rows = vec![row("a", "qem", 1e-6), row("b", "qem", 3e-6), row("a", "paper", 4e-6), row("b", "paper", 6e-6)];
        let rows = Table::new(&["chamfer", "seconds"], rows).with_quotients_over(REFERENCE);
        let means = mean_table(&rows, 0.1).markdown();
        assert!(means.contains("| qem | **2.00** | - | - | - | **0.500** |"), "{means}");
        let csv = csv_table("two", &rows);
        assert_eq!(csv.lines[10][..8], ["two", "0.1", "paper", "2 of 2", "5.00", "5.00", "3.00", "2"]);
        assert_eq!((csv.lines[10].len(), csv.head.len()), (24, 24));
    }
}
