//! Tables over measured rows, as Markdown between the marks of a page or as CSV.

use anyhow::{Context, Result};

use crate::cells::{Cell, Show};
use crate::rows::{ResultRow, Table};

/// Rows of one mesh, ratio or method; all rows where none is given.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    pub mesh: Option<String>,
    pub ratio: Option<f64>,
    pub method: Option<String>,
}

impl Choice {
    fn takes(&self, row: &ResultRow) -> bool {
        self.mesh.as_ref().is_none_or(|mesh| *mesh == row.mesh)
            && self.ratio.is_none_or(|ratio| ratio == row.ratio)
            && self.method.as_ref().is_none_or(|method| *method == row.method)
    }
}

/// A line of a table: its first cells, its rows, and whether it may be the best of a column.
#[derive(Clone, Debug)]
pub struct Line {
    pub labels: Vec<String>,
    pub choice: Choice,
    pub is_ranked: bool,
}

impl Line {
    pub fn new<const N: usize>(labels: [&str; N]) -> Self {
        Self { labels: labels.map(String::from).into(), choice: Choice::default(), is_ranked: true }
    }

    pub fn with_ratio(mut self, ratio: f64) -> Self {
        self.choice.ratio = Some(ratio);
        self
    }

    pub fn with_method(mut self, method: &str) -> Self {
        self.choice.method = Some(method.into());
        self
    }

    pub fn with_mesh(mut self, mesh: &str) -> Self {
        self.choice.mesh = Some(mesh.into());
        self
    }
}

/// Makes a line of each ratio, and one of all.
pub fn ratio_lines(ratios: &[f64]) -> Vec<Line> {
    let lines = ratios.iter().map(|&ratio| Line::new([&ratio.to_string()]).with_ratio(ratio));
    lines.chain([Line::new(["all"])]).collect()
}

type ToCell<'a> = Box<dyn Fn(&Table, &[&ResultRow]) -> Cell + 'a>;

/// A column of a table: a title, its rows, and how they become a cell.
pub struct Column<'a> {
    title: String,
    choice: Choice,
    cell: ToCell<'a>,
    is_best_bold: bool,
}

impl<'a> Column<'a> {
    pub fn new(title: &str, cell: impl Fn(&Table, &[&ResultRow]) -> Cell + 'a) -> Self {
        Self { title: title.into(), choice: Choice::default(), cell: Box::new(cell), is_best_bold: false }
    }

    /// Makes a column of an aggregate of a figure times a factor.
    pub fn of_figure(title: &str, figure: &str, factor: f64, show: Show) -> Self {
        let figure = figure.to_owned();
        let value = move |table: &Table, row: &ResultRow| table.value(row, &figure).map(|value| factor * value);
        let cell = move |table: &Table, rows: &[&ResultRow]| {
            let values = rows.iter().filter_map(|row| Some((row.mesh.as_str(), value(table, row)?)));
            show(&values.collect::<Vec<_>>())
        };
        Self::new(title, cell)
    }

    /// Makes a column of the number of rows without an error.
    pub fn of_results() -> Self {
        let count = |_: &Table, rows: &[&ResultRow]| {
            let n = rows.iter().filter(|row| row.error.is_empty()).count();
            format!("{n} of {}", rows.len()).into()
        };
        Self::new("results", count)
    }

    pub fn with_ratio(mut self, ratio: f64) -> Self {
        self.choice.ratio = Some(ratio);
        self
    }

    pub fn with_method(mut self, method: &str) -> Self {
        self.choice.method = Some(method.into());
        self
    }

    /// Prints the least value of the column in bold.
    pub fn with_best(mut self) -> Self {
        self.is_best_bold = true;
        self
    }
}

/// A table of text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextTable {
    pub head: Vec<String>,
    pub lines: Vec<Vec<String>>,
}

/// Makes a table; `corner` are the titles of the first cells.
pub fn pivot(rows: &Table, corner: &[&str], lines: &[Line], columns: &[Column]) -> TextTable {
    let cell = |line: &Line, column: &Column| {
        let is_chosen = |row: &&ResultRow| line.choice.takes(row) && column.choice.takes(row);
        (column.cell)(rows, &rows.rows.iter().filter(is_chosen).collect::<Vec<_>>())
    };
    let mut cells: Vec<Vec<Cell>> =
        columns.iter().map(|column| lines.iter().map(|line| cell(line, column)).collect()).collect();
    for (cells, _) in cells.iter_mut().zip(columns).filter(|(_, column)| column.is_best_bold) {
        let ranked = cells.iter().zip(lines).filter(|(_, line)| line.is_ranked);
        let best = ranked.filter_map(|(cell, _)| cell.value).min_by(f64::total_cmp);
        for (cell, _) in cells.iter_mut().zip(lines).filter(|(_, line)| line.is_ranked) {
            if best.is_some() && cell.value == best {
                cell.text = format!("**{}**", cell.text);
            }
        }
    }
    let line = |(at, line): (usize, &Line)| {
        line.labels.iter().cloned().chain(cells.iter().map(|column| column[at].text.clone())).collect()
    };
    let titles = columns.iter().map(|column| column.title.clone());
    TextTable {
        head: corner.iter().map(|title| title.to_string()).chain(titles).collect(),
        lines: lines.iter().enumerate().map(line).collect(),
    }
}

impl TextTable {
    /// Appends the lines of a table with the same columns.
    pub fn with_lines_of(mut self, other: Self) -> Self {
        self.head = if self.head.is_empty() { other.head } else { self.head };
        self.lines.extend(other.lines);
        self
    }

    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let rule = format!("|{}\n", "---|".repeat(self.head.len()));
        [line(&self.head), rule].into_iter().chain(self.lines.iter().map(|cells| line(cells))).collect()
    }

    /// Formats the table as CSV without backticks.
    pub fn csv(&self) -> Result<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for line in std::iter::once(&self.head).chain(&self.lines) {
            writer.write_record(line.iter().map(|cell| cell.replace('`', "")))?;
        }
        Ok(String::from_utf8(writer.into_inner()?)?)
    }
}

/// Replaces what is between `<!-- name -->` and `<!-- /name -->`; content of several lines has lines of its own.
pub fn fill(page: &str, name: &str, content: &str) -> Result<String> {
    let [begins, ends] = [format!("<!-- {name} -->"), format!("<!-- /{name} -->")];
    replace_between(
        page,
        &begins,
        &ends,
        &if content.ends_with('\n') { format!("\n{content}") } else { content.into() },
    )
}

pub fn replace_between(page: &str, begins: &str, ends: &str, content: &str) -> Result<String> {
    let missing = || format!("the page lacks {begins} ... {ends}");
    let (before, rest) = page.split_once(begins).with_context(missing)?;
    let (_, after) = rest.split_once(ends).with_context(missing)?;
    Ok(format!("{before}{begins}{content}{ends}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::{mean, worst};

    fn table() -> Table {
        let row = |mesh, ratio, method, value| ResultRow::new(mesh, ratio, method, &[value]);
        let rows = vec![
            row("a", 0.1, "ours", 1.0),
            row("b", 0.1, "ours", 3.0),
            row("a", 0.1, "theirs", 4.0),
            row("a", 0.5, "ours", 9.0),
        ];
        Table::new(&["chamfer"], rows)
    }

    #[test]
    fn lines_and_columns_choose_rows_and_the_best_is_bold() {
        let lines = [Line::new(["neural-mesh"]).with_method("ours"), Line::new(["`theirs`"]).with_method("theirs")];
        let columns = [
            Column::of_figure("CD at 0.1", "chamfer", 10.0, mean).with_ratio(0.1).with_best(),
            Column::of_figure("worst", "chamfer", 1.0, worst),
        ];
        let made = pivot(&table(), &["method"], &lines, &columns);
        let text = "| method | CD at 0.1 | worst |\n|---|---|---|\n| neural-mesh | **20.00** | a 9.00 |\n\
                    | `theirs` | 40.00 | a 4.00 |\n";
        assert_eq!(made.markdown(), text);
        assert_eq!(made.csv().unwrap().lines().last(), Some("theirs,40.00,a 4.00"));
        let mut unranked = lines;
        unranked[0].is_ranked = false;
        assert_eq!(pivot(&table(), &["method"], &unranked, &columns).lines[1][1], "**40.00**");
        let ratios = pivot(&table(), &["ratio"], &ratio_lines(&[0.1, 0.5]), &columns[1..]);
        assert_eq!(ratios.lines, [["0.1", "a 4.00"], ["0.5", "a 9.00"], ["all", "a 9.00"]]);
    }

    #[test]
    fn marks_of_a_page_are_filled_and_the_rest_stays() {
        let page = "# A\n\n<!-- x -->\n| old |\n<!-- /x -->\n\nprose <!-- y -->1<!-- /y --> of 2\n";
        let filled = fill(&fill(page, "x", "| new |\n").unwrap(), "y", "7").unwrap();
        assert_eq!(filled, page.replace("old", "new").replace("->1<", "->7<"));
        assert!(fill(page, "z", "").unwrap_err().to_string().contains("<!-- z -->"));
    }
}
