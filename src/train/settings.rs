//! Settings of a training.

use super::TrainError;
use crate::io::one_line;
use crate::model::Architecture;
use serde::Deserialize;
use toml::{Table, Value};

/// The default settings with their descriptions.
pub const DEFAULT_SETTINGS: &str = include_str!("settings.toml");

/// All settings; `settings.toml` describes them.
///
/// ```
/// use neural_mesh::train::{Settings, TrainError};
/// let settings = Settings::from_toml("epochs = 3 # few")?;
/// assert_eq!((settings.epochs, settings.learning_rate_decay), (3, 0.99));
/// let error = Settings::from_toml("epoch = 3").unwrap_err();
/// assert!(error.to_string().contains("unknown setting `epoch`"));
/// # Ok::<(), TrainError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[allow(missing_docs)] // The file says it once.
pub struct Settings {
    pub objective: String,
    pub seed: u64,
    pub epochs: usize,
    pub learning_rate: f64,
    pub learning_rate_decay: f64,
    pub adam_beta1: f64,
    pub adam_beta2: f64,
    pub adam_epsilon: f64,
    pub gradient_clip: f64,
    pub explosion: f64,
    pub checkpoint_minutes: f64,
    pub validation: Vec<String>,
    pub validation_ratios: Vec<f64>,
    pub ratio_min: f64,
    pub ratio_max: f64,
    pub max_vertices: usize,
    pub clouds: f64,
    pub max_samples: usize,
    pub literal: bool,
    pub lambda_sampler: f64,
    pub lambda_curvature: f64,
    pub lambda_smoothness: f64,
    pub lambda_forward: f64,
    pub lambda_reverse: f64,
    pub lambda_coverage: f64,
    pub lambda_collision: f64,
    pub lambda_crossings: f64,
    pub lambda_overlap: f64,
    pub lambda_closure: f64,
    pub lambda_agreement: f64,
    pub end_to_end: bool,
    pub probes: usize,
    pub probe_cell: usize,
    pub probe_step: f64,
    pub rotation: bool,
    pub scale: f64,
    pub noise: f64,
    #[serde(skip)]
    pub architecture: Architecture,
    #[serde(skip)]
    table: Table,
}

impl Settings {
    /// Reads settings, using defaults for missing ones.
    ///
    /// # Errors
    /// [`TrainError::Settings`] names an unknown, mistyped or out-of-range setting.
    pub fn from_toml(text: &str) -> Result<Self, TrainError> {
        let mut table = parse_table(DEFAULT_SETTINGS)?;
        for (name, value) in parse_table(text)? {
            let Some(default) = table.get_mut(&name) else {
                return refuse(format!(
                    "unknown setting `{name}`: config.toml, which each training writes to its folder, names all"
                ));
            };
            *default = convert_to_kind(&name, value, default)?;
        }
        Self::from_table(table)
    }

    fn from_table(table: Table) -> Result<Self, TrainError> {
        let settings = table.clone().try_into::<Self>();
        let mut settings = settings.map_err(|error| TrainError::Settings(one_line(error.message())))?;
        for (name, size) in settings.architecture.fields() {
            *size = table.get(name).and_then(Value::as_integer).unwrap_or_default() as usize;
        }
        settings.table = table;
        settings.check()?;
        Ok(settings)
    }

    /// Returns the settings as TOML with the default's comments.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        for line in DEFAULT_SETTINGS.lines() {
            match line.split_once(" = ").and_then(|(name, _)| Some((name, self.table.get(name)?))) {
                Some((name, value)) => text.push_str(&format!("{name} = {value}\n")),
                None => text.push_str(&format!("{line}\n")),
            }
        }
        text
    }

    /// Describes the first setting that differs, ignoring `epochs`.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let differs = |name: &&String| *name != "epochs" && self.table.get(*name) != other.table.get(*name);
        let name = self.table.keys().find(differs)?;
        let [old, new] = [self, other].map(|settings| settings.table.get(name).map(Value::to_string));
        Some(format!("`{name}` was {} and is {} now", old.unwrap_or_default(), new.unwrap_or_default()))
    }

    /// Returns the settings with another number of epochs.
    ///
    /// # Errors
    /// [`TrainError::Settings`] if the number is 0.
    pub fn with_epochs(&self, epochs: usize) -> Result<Self, TrainError> {
        self.with_values([("epochs", epochs)])
    }

    pub(super) fn with_objective(&self, objective: &str) -> Result<Self, TrainError> {
        let mut table = self.table.clone();
        table.insert("objective".into(), Value::String(objective.into()));
        Self::from_table(table)
    }

    /// Returns the settings with the sizes of a network.
    ///
    /// # Errors
    /// [`TrainError::Settings`] if a size is out of range.
    pub fn with_architecture(&self, sizes: &Architecture) -> Result<Self, TrainError> {
        self.with_values(sizes.sizes())
    }

    fn with_values<const N: usize>(&self, sizes: [(&str, usize); N]) -> Result<Self, TrainError> {
        let mut table = self.table.clone();
        for (name, size) in sizes {
            table.insert(name.into(), Value::Integer(size as i64));
        }
        Self::from_table(table)
    }

    fn check(&self) -> Result<(), TrainError> {
        let ratios = [("ratio_min", self.ratio_min), ("ratio_max", self.ratio_max)];
        let ratios = ratios.into_iter().chain(self.validation_ratios.iter().map(|&ratio| ("validation_ratios", ratio)));
        for (name, ratio) in ratios {
            check_range(name, ratio, ratio > 0.0 && ratio <= 1.0, "above 0 and at most 1")?;
        }
        check_range("ratio_min", self.ratio_min, self.ratio_min <= self.ratio_max, "at most `ratio_max`")?;
        check_range("clouds", self.clouds, (0.0..=1.0).contains(&self.clouds), "0 to 1")?;
        for (name, beta) in [("adam_beta1", self.adam_beta1), ("adam_beta2", self.adam_beta2)] {
            check_range(name, beta, (0.0..1.0).contains(&beta), "at least 0 and below 1")?;
        }
        for (name, x) in self.positive_settings() {
            check_range(name, x, x > 0.0 && x.is_finite(), "above 0")?;
        }
        for (name, x) in self.table.iter().filter_map(|(name, value)| Some((name, value.as_float()?))) {
            check_range(name, x, x >= 0.0 && x.is_finite(), "0 or above")?;
        }
        self.check_sizes()
    }

    fn positive_settings(&self) -> [(&'static str, f64); 7] {
        [
            ("learning_rate", self.learning_rate),
            ("learning_rate_decay", self.learning_rate_decay),
            ("adam_epsilon", self.adam_epsilon),
            ("probes", self.probes as f64),
            ("probe_cell", self.probe_cell as f64),
            ("probe_step", self.probe_step),
            ("epochs", self.epochs as f64),
        ]
    }

    fn check_sizes(&self) -> Result<(), TrainError> {
        match self.architecture.bad_size() {
            None => Ok(()),
            Some((name, size)) => {
                refuse(format!("`{name}` is {size}: give 1 to 1024, or 3 or 6 for `point_sampler_inputs`"))
            }
        }
    }
}

fn parse_table(text: &str) -> Result<Table, TrainError> {
    text.parse::<Table>().map_err(|error| {
        let line =
            error.span().map_or(1, |span| 1 + text.as_bytes()[..span.start].iter().filter(|b| **b == b'\n').count());
        TrainError::Settings(format!("line {line}: {}: write `name = value`", one_line(error.message())))
    })
}

/// Converts a value to the type of the default; accepts integers for fractions.
fn convert_to_kind(name: &str, value: Value, default: &Value) -> Result<Value, TrainError> {
    match (value, default) {
        (Value::Integer(n), Value::Float(_)) => Ok(Value::Float(n as f64)),
        (Value::Array(values), Value::Array(defaults)) => {
            let first = defaults.first().unwrap_or(&Value::Boolean(false)).clone();
            let values = values.into_iter().map(|value| convert_to_kind(name, value, &first));
            values.collect::<Result<_, _>>().map(Value::Array)
        }
        (Value::Integer(n), Value::Integer(_)) if n < 0 => {
            refuse(format!("the setting `{name}` is {n}: it must be a whole number from 0 on"))
        }
        (value, default) if value.same_type(default) => Ok(value),
        (value, default) => refuse(format!("`{name}` is {value}: it must be a {}", default.type_str())),
    }
}

fn check_range(name: &str, value: f64, holds: bool, range: &str) -> Result<(), TrainError> {
    if holds { Ok(()) } else { refuse(format!("`{name}` is {value}: it must be {range}")) }
}

fn refuse<T>(why: String) -> Result<T, TrainError> {
    Err(TrainError::Settings(why))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_settings_round_trip_unchanged() {
        let settings = Settings::from_toml("").unwrap();
        assert_eq!(Settings::from_toml(DEFAULT_SETTINGS).unwrap(), settings);
        assert_eq!(Settings::from_toml(&settings.to_toml()).unwrap(), settings);
        assert_eq!(settings.architecture, Architecture::default());
        let lines =
            |text: &str| text.lines().map(|line| line.split(" = ").next().unwrap().into()).collect::<Vec<String>>();
        assert_eq!(lines(&settings.to_toml()), lines(DEFAULT_SETTINGS));
    }

    #[test]
    fn what_is_written_reads_back() {
        let text = "noise = 0.1\nlearning_rate = 1e-5\nvalidation = []\nrotation = false\nobjective = \"a \\\" b\"";
        let settings = Settings::from_toml(text).unwrap();
        assert_eq!(Settings::from_toml(&settings.to_toml()).unwrap(), settings);
        assert!(settings.to_toml().contains("\nlearning_rate = 1e-5\n") || settings.learning_rate == 1e-5);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let cases = [
            ("epocs = 3", "`epocs`"),
            ("epochs = \"many\"", "`epochs`"),
            ("epochs = 0", "`epochs`"),
            ("seed = -1", "`seed`"),
            ("ratio_max = 1.5", "`ratio_max`"),
            ("ratio_min = 0.9", "`ratio_min`"),
            ("noise = nan", "`noise`"),
            ("validation = [3]", "`validation`"),
            ("validation_ratios = [0]", "`validation_ratios`"),
            ("face_knn = 5000", "`face_knn`"),
            ("adam_beta1 = 1", "`adam_beta1`"),
            ("\nepochs 3", "line 2"),
        ];
        for (text, named) in cases {
            let error = Settings::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(named) && !error.contains('\n'), "{text}: {error}");
        }
    }

    #[test]
    fn differences_are_named_but_for_the_epochs() {
        let one = Settings::from_toml("").unwrap();
        assert_eq!(one.difference(&one.with_epochs(7).unwrap()), None);
        let other = Settings::from_toml("noise = 0.5").unwrap();
        assert_eq!(one.difference(&other).unwrap(), "`noise` was 0.0 and is 0.5 now");
    }
}
