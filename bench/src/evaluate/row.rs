//! One row: a mesh, a size, a method, a seed, and all that is known of the outcome.

/// What is known of one result, and of how it was measured. Without a result there is an `error`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Name of the mesh file.
    pub mesh: String,
    /// Share of the vertices asked for.
    pub ratio: f64,
    /// Seed of the sampling.
    pub seed: u64,
    /// Name of the method.
    pub method: String,
    /// Why there is no result; empty where there is one.
    pub error: String,
    /// Vertices of the mesh as cleaned; 0 where it could not be read.
    pub vertices_in: usize,
    /// Its faces.
    pub faces_in: usize,
    /// Vertices asked for.
    pub vertices_asked: usize,
    /// Faces asked for.
    pub faces_asked: usize,
    /// Vertices of the result.
    pub vertices_out: usize,
    /// Its faces.
    pub faces_out: usize,
    /// Median over the runs.
    pub seconds: Option<f64>,
    /// How it was measured.
    pub how: How,
    /// Figures of `metrics::compare`, in the order of the table's columns.
    pub figures: Vec<Option<f64>>,
}

/// How a row was measured: settings, program and machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct How {
    /// What the seconds cover: `method`, with the mesh in memory (also where a tool tells them), or `process`, with its
    /// start, reading and writing.
    pub timed: String,
    /// Runs that were timed.
    pub runs: usize,
    /// Threads that a method may use.
    pub threads: usize,
    /// Seconds that a run may take.
    pub time_limit: f64,
    /// Samples on each surface.
    pub samples: usize,
    /// Eigenpairs of the Laplacian, at most; 0 where they were not asked for.
    pub eigenpairs: usize,
    /// The beginning of the SHA-256 of the weights; empty for methods without.
    pub weights: String,
    /// Version of this program.
    pub version: String,
    /// Model of the processor.
    pub cpu: String,
    /// Its cores, as far as the program may use them.
    pub cores: usize,
}

/// The columns before the figures.
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

/// Names of all columns, with these figures.
pub(super) fn columns(figures: &[String]) -> Vec<String> {
    COLUMNS.iter().map(|name| name.to_string()).chain(figures.iter().cloned()).collect()
}

/// The names of the figures among these columns; `None` where they are not those of a table of rows.
pub(super) fn figures_of(columns: &[String]) -> Option<Vec<String>> {
    let is_table = columns.len() >= COLUMNS.len() && columns.iter().zip(COLUMNS).all(|(name, known)| name == known);
    is_table.then(|| columns[COLUMNS.len()..].to_vec())
}

impl Row {
    /// Whether it stands for this mesh, size, seed and method.
    pub(super) fn is_of(&self, mesh: &str, ratio: f64, seed: u64, method: &str) -> bool {
        self.mesh == mesh && self.ratio == ratio && self.seed == seed && self.method == method
    }

    /// The fields as text, in the order of the columns.
    pub(super) fn fields(&self) -> Vec<String> {
        let how = &self.how;
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
            how.timed.clone(),
            how.runs.to_string(),
            how.threads.to_string(),
            how.time_limit.to_string(),
            how.samples.to_string(),
            how.eigenpairs.to_string(),
            how.weights.clone(),
            how.version.clone(),
            how.cpu.clone(),
            how.cores.to_string(),
        ];
        fields.extend(self.figures.iter().map(|value| number(*value)));
        fields
    }

    /// The row with these fields; `None` where they are none.
    pub(super) fn of_fields(fields: &[String]) -> Option<Self> {
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
            how: How {
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

/// A number that may be missing, as text; one that is not finite is none.
fn number(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or(String::new(), |value| value.to_string())
}

/// The other way round; `None` for text that is no number.
fn value(field: &str) -> Option<Option<f64>> {
    if field.is_empty() { Some(None) } else { field.parse().ok().map(Some) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_give_back_the_row() {
        let how = How { timed: "method".into(), runs: 3, time_limit: 0.5, cpu: "a, \"b\"".into(), ..How::default() };
        let row = Row {
            mesh: "a b.ply".into(),
            ratio: 0.1,
            seconds: Some(1e-7),
            how,
            figures: vec![Some(0.1), None],
            ..Row::default()
        };
        let fields = row.fields();
        assert_eq!(fields.len(), columns(&["x".into(), "y".into()]).len());
        assert_eq!(Row::of_fields(&fields), Some(row));
        assert_eq!(Row::of_fields(&fields[..20]), None);
    }
}
