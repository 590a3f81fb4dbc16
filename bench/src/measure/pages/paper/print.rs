//! The paper's numbers (Tables 1 and 2 of Potamias et al. 2022) next to ours.

use crate::evaluate::{ResultRow, Table};

use super::super::RATIOS;
use crate::measure::markdown::{number, table};

// The paper's columns: CD, WA in percent, LE, NE, and seconds for 20 meshes.
type Cells = [f64; 5];

// A row of the paper's Table 1.
struct PaperRow {
    // Name of the method here.
    method: &'static str,
    // Cells at each of the ratios.
    cells: [Cells; 4],
}

const TABLE_1: [PaperRow; 5] = [
    PaperRow {
        method: "paper",
        cells: [
            [1.02, 2.17, 0.90, 0.19, 4.1],
            [0.42, 2.21, 0.47, 0.15, 4.2],
            [0.19, 2.49, 0.24, 0.11, 4.2],
            [0.06, 3.57, 0.10, 0.06, 4.4],
        ],
    },
    PaperRow {
        method: "pointtrinet",
        cells: [
            [1.06, 12.14, 0.98, 0.20, 107.2],
            [0.47, 11.64, 0.52, 0.17, 238.1],
            [0.21, 11.48, 0.27, 0.13, 581.9],
            [0.08, 14.92, 0.12, 0.08, 1333.3],
        ],
    },
    PaperRow {
        method: "dse",
        cells: [
            [1.39, 6.64, 0.95, 0.23, 271.8],
            [0.51, 4.38, 0.50, 0.19, 490.7],
            [0.24, 3.12, 0.26, 0.15, 941.0],
            [0.07, 2.39, 0.12, 0.08, 2245.2],
        ],
    },
    PaperRow {
        method: "potamias",
        cells: [
            [10.47, 8.53, 1.23, 0.21, 105.2],
            [0.83, 8.39, 0.76, 0.17, 149.3],
            [0.49, 4.72, 0.43, 0.14, 158.7],
            [0.20, 4.67, 0.22, 0.10, 183.7],
        ],
    },
    PaperRow {
        method: "qem",
        cells: [
            [0.45, 0.00, 0.94, 0.14, 45.6],
            [0.22, 0.00, 0.53, 0.10, 31.1],
            [0.11, 0.00, 0.27, 0.07, 28.4],
            [0.05, 0.00, 0.13, 0.03, 25.6],
        ],
    },
];

// Number of meshes in the printed times.
const TIMED_MESHES: f64 = 20.0;
// Index of the ratio by whose figures methods are put in order.
const ORDER_RATIO: usize = 1;

/// Formats the paper's numbers next to ours from a table of rows.
pub fn format_comparison(rows: &Table) -> String {
    let head = ["ratio", "method", "CD over `qem`'s", "WA, %", "LE", "NE, radians", "s for 20 meshes"];
    let lines = (0..RATIOS.len()).flat_map(|at| TABLE_1.iter().map(move |printed| (at, printed)));
    let lines: Vec<Vec<String>> = lines.map(|(at, printed)| line(rows, at, printed)).collect();
    format!(
        "### Next to the paper's figures\n\n\
         Cells are means, *here / in the paper*. The paper gives no unit of CD, so CD is divided by that of `qem`. The printed NE has \
         the size of the mean angle between the normals in radians; that angle is compared. The paper's times are from another machine.\n\n{}\n\
         Methods at a ratio of 0.1, the least figure first:\n\n{}",
        table(&head, &lines),
        table(
            &["figure", "here", "in the paper"],
            &[("CD", 0), ("WA", 1), ("time", 4)].map(|figure| order(rows, figure))
        )
    )
}

fn line(rows: &Table, at: usize, printed: &PaperRow) -> Vec<String> {
    let [own, qem] = [printed.method, "qem"].map(|method| mean_cells(rows, RATIOS[at], method));
    let print_of_qem = TABLE_1.iter().find(|other| other.method == "qem").map(|other| other.cells[at]);
    let over = |own: Option<f64>, qem: Option<f64>| own.zip(qem).map(|(own, qem)| own / qem);
    let cells = (0..5).map(|column| {
        let [mut here, mut print] = [own[column], Some(printed.cells[at][column])];
        if column == 0 {
            [here, print] = [over(here, qem[0]), over(print, print_of_qem.map(|cells| cells[0]))];
        }
        format!("{} / {}", number(here), number(print))
    });
    [RATIOS[at].to_string(), format!("`{}`", printed.method)].into_iter().chain(cells).collect()
}

fn order(rows: &Table, (name, column): (&str, usize)) -> Vec<String> {
    let here =
        |printed: &PaperRow| mean_cells(rows, RATIOS[ORDER_RATIO], printed.method)[column].unwrap_or(f64::INFINITY);
    let sorted = |value: &dyn Fn(&PaperRow) -> f64| {
        let mut methods: Vec<&PaperRow> = TABLE_1.iter().collect();
        methods.sort_by(|a, b| value(a).total_cmp(&value(b)));
        methods.iter().map(|printed| printed.method).collect::<Vec<_>>().join(", ")
    };
    vec![name.into(), sorted(&here), sorted(&|printed| printed.cells[ORDER_RATIO][column])]
}

fn mean_cells(rows: &Table, ratio: f64, method: &str) -> [Option<f64>; 5] {
    let results: Vec<&ResultRow> = rows.rows.iter().filter(|row| row.method == method && row.ratio == ratio).collect();
    // Columns of Table 1 are means over the results.
    let mean = |values: Vec<f64>| (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
    let figure = |name: &str| mean(results.iter().filter_map(|row| rows.figure(row, name)).collect());
    [
        figure("chamfer"),
        figure("edges_without_two_faces"),
        figure("laplacian_functions"),
        figure("normal_angle").map(f64::to_radians),
        mean(results.iter().filter_map(|row| row.seconds).collect()).map(|seconds| TIMED_MESHES * seconds),
    ]
}

// CD and curvature error of the paper's Table 2 at 0.05, 0.2 and 0.8, without noise and with.
#[allow(clippy::approx_constant)] // one printed figure is 3.14
pub const TABLE_2: [(&str, [[f64; 6]; 2]); 4] = [
    ("farthest points", [[4.02, 3.42, 0.81, 2.99, 0.01, 2.21], [7.31, 4.79, 3.47, 4.35, 2.11, 4.07]]),
    ("uniform, with replacement", [[6.71, 2.73, 1.85, 2.44, 0.24, 2.19], [7.43, 4.20, 3.67, 3.97, 2.58, 3.71]]),
    ("potamias", [[4.78, 2.51, 1.18, 2.27, 0.03, 2.14], [7.61, 4.12, 3.38, 3.65, 2.11, 3.14]]),
    ("network", [[5.12, 2.51, 1.22, 2.24, 0.05, 2.16], [7.18, 4.01, 3.21, 3.18, 1.99, 3.12]]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_pair_our_figures_with_the_papers_and_methods_are_ordered() {
        let row = |method: &str, chamfer, seconds| ResultRow {
            method: method.into(),
            ratio: 0.1,
            seconds: Some(seconds),
            figures: vec![Some(chamfer)],
            ..ResultRow::default()
        };
        let rows = vec![row("qem", 2.0, 0.5), row("paper", 3.0, 0.25), row("dse", 8.0, 1.0)];
        let text = format_comparison(&Table { figures: vec!["chamfer".into()], rows });
        assert!(
            text.contains("| 0.1 | `paper` | 1.50 / 1.91 | - / 2.21 | - / 0.47 | - / 0.15 | 5.00 / 4.20 |"),
            "{text}"
        );
        assert!(text.contains("| time | paper, qem, dse, "), "{text}");
        assert!(text.contains("| qem, paper, pointtrinet, dse, potamias |"), "{text}");
    }
}
