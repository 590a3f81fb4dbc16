//! Cells of tables: numbers as text, and the aggregates of values.

use crate::rows::median as median_of;

/// A cell with the number by which it competes for the best of its column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    pub text: String,
    pub value: Option<f64>,
}

impl From<String> for Cell {
    /// Makes a cell that does not compete.
    fn from(text: String) -> Self {
        Self { text, value: None }
    }
}

/// A value with its mesh.
pub type MeshValue<'a> = (&'a str, f64);

/// An aggregate of values as a cell.
pub type Show = fn(&[MeshValue]) -> Cell;

/// Formats a number with two decimals, or none from 100 on.
pub fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| if value.abs() >= 100.0 { format!("{value:.0}") } else { format!("{value:.2}") })
}

/// Formats a number with three significant digits.
pub fn significant(value: Option<f64>) -> String {
    let Some(value) = value else { return "-".into() };
    let size = value.abs();
    if size == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{value:.2e}");
    }
    let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

/// Formats a whole number with commas.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let commas = |(at, digit): (usize, char)| {
        let is_group = at > 0 && (digits.len() - at).is_multiple_of(3);
        is_group.then_some(',').into_iter().chain([digit])
    };
    digits.chars().enumerate().flat_map(commas).collect()
}

fn numbers(values: &[MeshValue]) -> Vec<f64> {
    values.iter().map(|(_, value)| *value).collect()
}

pub fn mean_of(values: &[MeshValue]) -> Option<f64> {
    (!values.is_empty()).then(|| numbers(values).iter().sum::<f64>() / values.len() as f64)
}

fn worst_of<'a>(values: &[MeshValue<'a>]) -> Option<MeshValue<'a>> {
    values.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))
}

fn cell(value: Option<f64>, format: fn(Option<f64>) -> String) -> Cell {
    Cell { text: format(value), value }
}

pub fn median(values: &[MeshValue]) -> Cell {
    cell(median_of(numbers(values)), number)
}

pub fn least(values: &[MeshValue]) -> Cell {
    cell(numbers(values).into_iter().reduce(f64::min), number)
}

pub fn largest(values: &[MeshValue]) -> Cell {
    cell(worst_of(values).map(|worst| worst.1), number)
}

fn with_decimals(values: &[MeshValue], decimals: usize) -> Cell {
    let value = median_of(numbers(values));
    Cell { text: value.map_or("-".into(), |value| format!("{value:.decimals$}")), value }
}

/// Formats the median, which is the value where there is one.
pub fn whole_number(values: &[MeshValue]) -> Cell {
    with_decimals(values, 0)
}

pub fn one_decimal(values: &[MeshValue]) -> Cell {
    with_decimals(values, 1)
}

pub fn three_decimals(values: &[MeshValue]) -> Cell {
    with_decimals(values, 3)
}

pub fn mean(values: &[MeshValue]) -> Cell {
    cell(mean_of(values), number)
}

pub fn mean_digits(values: &[MeshValue]) -> Cell {
    cell(mean_of(values), significant)
}

pub fn median_digits(values: &[MeshValue]) -> Cell {
    cell(median_of(numbers(values)), significant)
}

pub fn worst_mesh(values: &[MeshValue]) -> Cell {
    worst_of(values).map_or("-".to_owned(), |(mesh, _)| mesh.into()).into()
}

/// Formats the mesh of the largest value with this value.
pub fn worst(values: &[MeshValue]) -> Cell {
    format!("{} {}", worst_mesh(values).text, largest(values).text).into()
}

/// Formats median, least and largest as `0.98 (0.70 to 1.20)`.
pub fn spread(values: &[MeshValue]) -> Cell {
    let middle = median_of(numbers(values));
    let ends = [f64::min as fn(f64, f64) -> f64, f64::max].map(|end| numbers(values).into_iter().reduce(end));
    let text = middle.zip(ends[0].zip(ends[1]));
    let text = text.map_or("-".into(), |(middle, (least, most))| format!("{middle:.2} ({least:.2} to {most:.2})"));
    Cell { text, value: middle }
}

pub fn sum(values: &[MeshValue]) -> Cell {
    let sum = numbers(values).iter().sum::<f64>();
    Cell { text: count(sum as usize), value: Some(sum) }
}

/// Formats the number of zeros as `7 of 9`.
pub fn zeros(values: &[MeshValue]) -> Cell {
    let n_zero = values.iter().filter(|(_, value)| *value == 0.0).count();
    format!("{n_zero} of {}", values.len()).into()
}

/// Formats the number of values.
pub fn n_values(values: &[MeshValue]) -> Cell {
    values.len().to_string().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_few_digits() {
        assert_eq!([number(Some(0.456)), number(Some(456.7)), number(None)], ["0.46", "457", "-"]);
        assert_eq!([count(12), count(123_456), count(1_234_567)], ["12", "123,456", "1,234,567"]);
        let numbers = [0.0, 1.0, 0.0123456, 123.456, 123456.0, 1e-7, -2.5].map(|value| significant(Some(value)));
        assert_eq!(numbers, ["0", "1.00", "0.0123", "123", "123456", "1.00e-7", "-2.50"]);
        assert_eq!(significant(None), "-");
    }

    #[test]
    fn aggregates_name_the_worst_and_the_ends() {
        let values = [("a", 3.0), ("b", 1.0), ("c", 10.0), ("d", 2.0)];
        assert_eq!(spread(&values).text, "2.50 (1.00 to 10.00)");
        assert_eq!((worst(&values).text.as_str(), least(&values).value), ("c 10.00", Some(1.0)));
        assert_eq!([spread(&[]).text, worst(&[]).text, median(&[]).text], ["-", "- -", "-"]);
        assert_eq!([zeros(&[("a", 0.0), ("b", 1.0)]).text, sum(&values).text], ["1 of 2", "16"]);
    }
}
