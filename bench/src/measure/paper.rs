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

// The paper's columns: CD, WA in percent, LE, NE, and seconds for 20 meshes.
type PaperCells = [f64; 5];

// Method, and the cells at each ratio.
type PaperLine = (&'static str, [PaperCells; 4]);

// The paper's Table 1 (Potamias et al. 2022).
const TABLE_1: [PaperLine; 5] = [
    (
        "paper",
        [
            [1.02, 2.17, 0.90, 0.19, 4.1],
            [0.42, 2.21, 0.47, 0.15, 4.2],
            [0.19, 2.49, 0.24, 0.11, 4.2],
            [0.06, 3.57, 0.10, 0.06, 4.4],
        ],
    ),
    (
        "pointtrinet",
        [
            [1.06, 12.14, 0.98, 0.20, 107.2],
            [0.47, 11.64, 0.52, 0.17, 238.1],
            [0.21, 11.48, 0.27, 0.13, 581.9],
            [0.08, 14.92, 0.12, 0.08, 1333.3],
        ],
    ),
    (
        "dse",
        [
            [1.39, 6.64, 0.95, 0.23, 271.8],
            [0.51, 4.38, 0.50, 0.19, 490.7],
            [0.24, 3.12, 0.26, 0.15, 941.0],
            [0.07, 2.39, 0.12, 0.08, 2245.2],
        ],
    ),
    (
        "potamias",
        [
            [10.47, 8.53, 1.23, 0.21, 105.2],
            [0.83, 8.39, 0.76, 0.17, 149.3],
            [0.49, 4.72, 0.43, 0.14, 158.7],
            [0.20, 4.67, 0.22, 0.10, 183.7],
        ],
    ),
    (
        "qem",
        [
            [0.45, 0.00, 0.94, 0.14, 45.6],
            [0.22, 0.00, 0.53, 0.10, 31.1],
            [0.11, 0.00, 0.27, 0.07, 28.4],
            [0.05, 0.00, 0.13, 0.03, 25.6],
        ],
    ),
];

// Number of meshes in the printed times.
const TIMED_MESHES: f64 = 20.0;
// Index of the ratio by whose figures methods are put in order.
const ORDER_RATIO: usize = 1;

// Our means in the paper's columns.
fn mean_cells(rows: &Table, ratio: f64, method: &str) -> [Option<f64>; 5] {
    let [chamfer, open, spectrum, angle, seconds] =
        ["chamfer", "edges_without_two_faces", "laplacian_functions", "normal_angle", "seconds"]
            .map(|figure| rows.mean(ratio, method, figure));
    [chamfer, open, spectrum, angle.map(f64::to_radians), seconds.map(|seconds| TIMED_MESHES * seconds)]
}

fn comparison(rows: &Table) -> TextTable {
    let line = |at: usize, (method, printed): &PaperLine| {
        let [own, qem] = [method, REFERENCE].map(|method| mean_cells(rows, RATIOS[at], method));
        let over = |own: Option<f64>, qem: Option<f64>| own.zip(qem).map(|(own, qem)| own / qem);
        let cells = (0..5).map(|column| {
            let [mut here, mut print] = [own[column], Some(printed[at][column])];
            // The paper gives no unit of CD.
            if column == 0 {
                [here, print] = [over(here, qem[0]), over(print, Some(TABLE_1[4].1[at][0]))];
            }
            format!("{} / {}", number(here), number(print))
        });
        [RATIOS[at].to_string(), format!("`{method}`")].into_iter().chain(cells).collect()
    };
    let head = ["ratio", "method", "CD over `qem`'s", "WA, %", "LE", "NE, radians", "s for 20 meshes"];
    let lines = (0..RATIOS.len()).flat_map(|at| TABLE_1.iter().map(move |printed| line(at, printed))).collect();
    TextTable { head: head.map(String::from).into(), lines }
}

fn order_table(rows: &Table) -> TextTable {
    let sorted = |value: &dyn Fn(&PaperLine) -> f64| {
        let mut methods: Vec<_> = TABLE_1.iter().collect();
        methods.sort_by(|a, b| value(a).total_cmp(&value(b)));
        methods.iter().map(|printed| printed.0).collect::<Vec<_>>().join(", ")
    };
    let line = |(name, column): (&str, usize)| {
        let here =
            |printed: &PaperLine| mean_cells(rows, RATIOS[ORDER_RATIO], printed.0)[column].unwrap_or(f64::INFINITY);
        vec![name.into(), sorted(&here), sorted(&|printed| printed.1[ORDER_RATIO][column])]
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
