//! Measured rows: one for each mesh, ratio, seed and method, with its figures by name.

use std::collections::HashMap;

/// Outcome of a method on a mesh at a ratio.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResultRow {
    /// Mesh.
    pub mesh: String,
    /// Target ratio of vertices.
    pub ratio: f64,
    /// Random seed.
    pub seed: u64,
    /// Method.
    pub method: String,
    /// Reason of a failure, or empty.
    pub error: String,
    /// Processor and cores; empty where no time is taken.
    pub machine: String,
    /// Values of the table's figures; `None` where a figure was not measured.
    pub values: Vec<Option<f64>>,
}

/// Rows and the names of their figures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the figures.
    pub figures: Vec<String>,
    /// Rows in the order of measurement.
    pub rows: Vec<ResultRow>,
}

const KEYS: [&str; 6] = ["mesh", "ratio", "seed", "method", "error", "machine"];

// Smaller values in quotients are noise of single precision or of the clock.
const NOISE: [(&str, f64); 4] =
    [("distance_mean", 1e-5), ("distance_max", 1e-5), ("normal_error_signed", 1e-6), ("seconds", 1e-6)];

impl ResultRow {
    /// Makes a row without seed, error and machine; NaN is no value.
    pub fn new(mesh: &str, ratio: f64, method: &str, values: &[f64]) -> Self {
        let values = values.iter().map(|&value| Some(value).filter(|value| !value.is_nan())).collect();
        Self { mesh: mesh.into(), ratio, method: method.into(), values, ..Self::default() }
    }

    pub(crate) fn is_case(&self, mesh: &str, ratio: f64, seed: u64, method: &str) -> bool {
        self.mesh == mesh && self.ratio == ratio && self.seed == seed && self.method == method
    }

    pub(crate) fn fields(&self) -> Vec<String> {
        let Self { mesh, ratio, seed, method, error, machine, values } = self;
        let number = |value: &Option<f64>| value.filter(|x| x.is_finite()).map_or(String::new(), |x| x.to_string());
        let keys = [mesh, &ratio.to_string(), &seed.to_string(), method, error, machine].map(String::clone);
        keys.into_iter().chain(values.iter().map(number)).collect()
    }

    pub(crate) fn from_fields(fields: &[String]) -> Option<Self> {
        let ([mesh, ratio, seed, method, error, machine], values) = fields.split_first_chunk()?;
        let value = |field: &String| if field.is_empty() { Some(None) } else { field.parse().ok().map(Some) };
        Some(Self {
            mesh: mesh.clone(),
            ratio: ratio.parse().ok()?,
            seed: seed.parse().ok()?,
            method: method.clone(),
            error: error.clone(),
            machine: machine.clone(),
            values: values.iter().map(value).collect::<Option<_>>()?,
        })
    }
}

impl Table {
    /// Makes a table of rows with these figures.
    #[cfg(test)]
    pub fn new(figures: &[&str], rows: Vec<ResultRow>) -> Self {
        Self { figures: figures.iter().map(|name| name.to_string()).collect(), rows }
    }

    pub(crate) fn columns(figures: &[String]) -> Vec<String> {
        KEYS.iter().map(|name| name.to_string()).chain(figures.iter().cloned()).collect()
    }

    pub(crate) fn figures_of(columns: &[String]) -> Option<Vec<String>> {
        columns.strip_prefix(&KEYS.map(String::from)).map(<[String]>::to_vec)
    }

    /// Returns a figure of a row; `None` if the row has no value or the table no such figure.
    pub fn value(&self, row: &ResultRow, figure: &str) -> Option<f64> {
        let at = self.figures.iter().position(|name| name == figure)?;
        row.values.get(at).copied().flatten()
    }

    /// Returns the rows that fulfil a condition.
    pub fn filter(&self, is_wanted: impl Fn(&ResultRow) -> bool) -> Self {
        let rows = self.rows.iter().filter(|row| is_wanted(row)).cloned().collect();
        Self { figures: self.figures.clone(), rows }
    }

    /// Adds quotients of each figure, named `/figure`, over a method's on the same mesh, at the same ratio and seed.
    ///
    /// Quotients that are not finite are left out.
    pub fn with_quotients_over(&self, method: &str) -> Self {
        let case = |row: &ResultRow| (row.mesh.clone(), row.ratio.to_bits(), row.seed);
        let others: HashMap<_, _> =
            self.rows.iter().filter(|row| row.method == method).map(|row| (case(row), row)).collect();
        let noise_of = |figure: &String| NOISE.iter().find(|(name, _)| name == figure).map(|(_, noise)| *noise);
        let noise: Vec<Option<f64>> = self.figures.iter().map(noise_of).collect();
        let divide = |row: &ResultRow| {
            let other = others.get(&case(row));
            let quotient = |at: usize| {
                let [a, b] = [row.values[at]?, other?.values[at]?].map(|x| noise[at].map_or(x, |noise| x.max(noise)));
                Some(a / b).filter(|quotient| quotient.is_finite())
            };
            let quotients = (0..row.values.len()).map(quotient);
            ResultRow { values: row.values.iter().copied().chain(quotients).collect(), ..row.clone() }
        };
        let names = self.figures.iter().map(|figure| format!("/{figure}"));
        let figures = self.figures.iter().cloned().chain(names).collect();
        Self { figures, rows: self.rows.iter().map(divide).collect() }
    }

    /// Returns the mean of a figure over the rows of a method at a ratio.
    pub fn mean(&self, ratio: f64, method: &str, figure: &str) -> Option<f64> {
        let rows = self.rows.iter().filter(|row| row.ratio == ratio && row.method == method);
        let values: Vec<f64> = rows.filter_map(|row| self.value(row, figure)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }

    /// Returns the distinct names of methods in their order.
    pub fn methods(&self) -> Vec<&str> {
        distinct(self.rows.iter().map(|row| row.method.as_str()))
    }

    /// Returns the distinct names of meshes in their order.
    pub fn meshes(&self) -> Vec<&str> {
        distinct(self.rows.iter().map(|row| row.mesh.as_str()))
    }
}

pub(crate) fn distinct<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut seen = Vec::new();
    for item in items {
        if !seen.contains(&item) {
            seen.push(item);
        }
    }
    seen
}

/// Returns the median, for an even number the mean of the middle two; `None` for no values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let last = values.get(n / 2)?;
    Some(if n % 2 == 1 { *last } else { 0.5 * (values[n / 2 - 1] + last) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_give_back_the_row() {
        let mut row = ResultRow::new("a b.ply", 0.1, "qem", &[0.1, 1e-7]);
        (row.values[1], row.error, row.machine) = (None, "a, \"b\"".into(), "EPYC, 2 cores".into());
        let fields = row.fields();
        assert_eq!(fields.len(), Table::columns(&["x".into(), "y".into()]).len());
        assert_eq!(ResultRow::from_fields(&fields), Some(row));
        assert_eq!(ResultRow::from_fields(&fields[..5]), None);
    }

    #[test]
    fn the_median_of_an_even_number_is_between_the_middle_two() {
        assert_eq!([median(vec![3.0, 1.0, 2.0, 9.0]), median(vec![5.0]), median(vec![])], [Some(2.5), Some(5.0), None]);
    }

    #[test]
    fn quotients_are_those_of_the_same_case() {
        let mut rows: Vec<ResultRow> =
            [("a", 1.0), ("b", 9.0), ("c", 5.0)].map(|(mesh, x)| ResultRow::new(mesh, 0.1, "x", &[x, 0.0])).into();
        rows.extend([("b", 3.0), ("a", 2.0), ("c", 0.0)].map(|(mesh, x)| ResultRow::new(mesh, 0.1, "y", &[x, 0.0])));
        let quotients = Table::new(&["chamfer", "seconds"], rows).with_quotients_over("y");
        let values: Vec<_> = quotients.rows[..3].iter().map(|row| quotients.value(row, "/chamfer")).collect();
        assert_eq!(values, [Some(0.5), Some(3.0), None]);
        // Noise over noise is 1.
        assert_eq!(quotients.value(&quotients.rows[0], "/seconds"), Some(1.0));
        assert_eq!(quotients.mean(0.1, "x", "chamfer"), Some(5.0));
        assert!(quotients.with_quotients_over("none").rows.iter().all(|row| row.values[4..] == [None; 4]));
    }
}
