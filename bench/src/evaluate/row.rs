//! One row of the table.

/// Outcome of a method in one case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResultRow {
    /// Mesh file.
    pub mesh: String,
    /// Target ratio of vertices.
    pub ratio: f64,
    /// Random seed.
    pub seed: u64,
    /// Method.
    pub method: String,
    /// Reason of a failure, or empty.
    pub error: String,
    /// Number of vertices of the cleaned mesh; 0 if unreadable.
    pub vertices_in: usize,
    /// Number of faces of the cleaned mesh.
    pub faces_in: usize,
    /// Target number of vertices.
    pub vertices_asked: usize,
    /// Target number of faces.
    pub faces_asked: usize,
    /// Number of vertices of the result.
    pub vertices_out: usize,
    /// Number of faces of the result.
    pub faces_out: usize,
    /// Median time of the runs, in seconds.
    pub seconds: Option<f64>,
    /// Settings, program and machine.
    pub conditions: Conditions,
    /// Figures in the order of the table's names.
    pub figures: Vec<Option<f64>>,
}

/// Settings, program and machine of a measurement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Timed scope: `method`, with the mesh in memory, or the whole `process`.
    pub timed: String,
    /// Number of timed runs.
    pub runs: usize,
    /// Threads per method.
    pub threads: usize,
    /// Time limit of a run in seconds.
    pub time_limit: f64,
    /// Number of sample points per surface.
    pub samples: usize,
    /// Largest number of eigenpairs of the Laplacian; 0 if the spectrum is not measured.
    pub eigenpairs: usize,
    /// First digits of the weights' SHA-256; empty for methods without weights.
    pub weights: String,
    /// Version of this program.
    pub version: String,
    /// Model of the processor.
    pub cpu: String,
    /// Available cores.
    pub cores: usize,
}

const COLUMNS: [&str; 22] = [
    "mesh",
    "ratio",
    "seed",
    "method",
    "error",
    "vertices_in",
    "faces_in",
    "vertices_asked",
    "faces_asked",
    "vertices_out",
    "faces_out",
    "seconds",
    "timed",
    "runs",
    "threads",
    "time_limit",
    "samples",
    "eigenpairs",
    "weights",
    "version",
    "cpu",
    "cores",
];

pub(super) fn columns(figures: &[String]) -> Vec<String> {
    COLUMNS.iter().map(|name| name.to_string()).chain(figures.iter().cloned()).collect()
}

pub(super) fn figure_names(columns: &[String]) -> Option<Vec<String>> {
    let is_table = columns.len() >= COLUMNS.len() && columns.iter().zip(COLUMNS).all(|(name, known)| name == known);
    is_table.then(|| columns[COLUMNS.len()..].to_vec())
}

impl ResultRow {
    pub(super) fn is_case(&self, mesh: &str, ratio: f64, seed: u64, method: &str) -> bool {
        self.mesh == mesh && self.ratio == ratio && self.seed == seed && self.method == method
    }

    pub(super) fn fields(&self) -> Vec<String> {
        let conditions = &self.conditions;
        let mut fields = vec![
            self.mesh.clone(),
            self.ratio.to_string(),
            self.seed.to_string(),
            self.method.clone(),
            self.error.clone(),
            self.vertices_in.to_string(),
            self.faces_in.to_string(),
            self.vertices_asked.to_string(),
            self.faces_asked.to_string(),
            self.vertices_out.to_string(),
            self.faces_out.to_string(),
            number(self.seconds),
            conditions.timed.clone(),
            conditions.runs.to_string(),
            conditions.threads.to_string(),
            conditions.time_limit.to_string(),
            conditions.samples.to_string(),
            conditions.eigenpairs.to_string(),
            conditions.weights.clone(),
            conditions.version.clone(),
            conditions.cpu.clone(),
            conditions.cores.to_string(),
        ];
        fields.extend(self.figures.iter().map(|value| number(*value)));
        fields
    }

    pub(super) fn from_fields(fields: &[String]) -> Option<Self> {
        let mut rest = fields.iter();
        let mut next = || rest.next().map(String::as_str);
        let row = Self {
            mesh: next()?.into(),
            ratio: next()?.parse().ok()?,
            seed: next()?.parse().ok()?,
            method: next()?.into(),
            error: next()?.into(),
            vertices_in: next()?.parse().ok()?,
            faces_in: next()?.parse().ok()?,
            vertices_asked: next()?.parse().ok()?,
            faces_asked: next()?.parse().ok()?,
            vertices_out: next()?.parse().ok()?,
            faces_out: next()?.parse().ok()?,
            seconds: value(next()?)?,
            conditions: Conditions {
                timed: next()?.into(),
                runs: next()?.parse().ok()?,
                threads: next()?.parse().ok()?,
                time_limit: next()?.parse().ok()?,
                samples: next()?.parse().ok()?,
                eigenpairs: next()?.parse().ok()?,
                weights: next()?.into(),
                version: next()?.into(),
                cpu: next()?.into(),
                cores: next()?.parse().ok()?,
            },
            figures: Vec::new(),
        };
        let figures = rest.map(|field| value(field)).collect::<Option<Vec<_>>>()?;
        Some(Self { figures, ..row })
    }
}

fn number(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or(String::new(), |value| value.to_string())
}

fn value(field: &str) -> Option<Option<f64>> {
    if field.is_empty() { Some(None) } else { field.parse().ok().map(Some) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_give_back_the_row() {
        let conditions = Conditions {
            timed: "method".into(),
            runs: 3,
            time_limit: 0.5,
            cpu: "a, \"b\"".into(),
            ..Conditions::default()
        };
        let row = ResultRow {
            mesh: "a b.ply".into(),
            ratio: 0.1,
            seconds: Some(1e-7),
            conditions,
            figures: vec![Some(0.1), None],
            ..ResultRow::default()
        };
        let fields = row.fields();
        assert_eq!(fields.len(), columns(&["x".into(), "y".into()]).len());
        assert_eq!(ResultRow::from_fields(&fields), Some(row));
        assert_eq!(ResultRow::from_fields(&fields[..20]), None);
    }
}
