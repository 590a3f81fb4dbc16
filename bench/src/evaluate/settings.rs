//! Settings of an evaluation.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::meshes::sha256;
use super::method::{Method, choose_methods};
use super::tool::Tool;
use crate::error::EvaluateError;
use crate::learned_baselines::{LearnedBaseline, LearnedWeights};
use neural_mesh::model::Weights;
use neural_mesh_cli::shared::numbers::{number_parser, parse_seed, parse_thread_count, share, whole_number_parser};

/// Settings of an evaluation, as arguments and in `settings.json`.
#[derive(Clone, Debug, PartialEq, clap::Args, Serialize, Deserialize)]
pub struct Settings {
    /// Methods, separated by commas
    #[arg(long, value_name = "A,B", value_delimiter = ',', default_value = "all")]
    pub methods: Vec<String>,
    /// External program as a method; can be repeated
    #[arg(long = "tool", value_name = "NAME='cmd {in} {out} {ratio}'", value_parser = Tool::parse)]
    pub tools: Vec<Tool>,
    /// Ratios of vertices to keep, such as 0.1 or 10%
    #[arg(long, value_name = "R,R", value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5", value_parser = share,
        allow_hyphen_values = true)]
    pub ratios: Vec<f64>,
    /// Seeds of the sampling
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "0", value_parser = parse_seed,
        allow_negative_numbers = true)]
    pub seeds: Vec<u64>,
    /// Timed runs of each method; the median counts
    #[arg(long = "repeat", value_name = "N", default_value = "3", value_parser = whole_number_parser::<usize>(1, u64::MAX),
        allow_negative_numbers = true)]
    pub repeats: usize,
    /// Time limit of a run in seconds
    #[arg(long, value_name = "SECONDS", default_value = "600", allow_negative_numbers = true,
        value_parser = number_parser("seconds above 0", |x| x > 0.0 && x <= 1e9))]
    pub time_limit: f64,
    /// Threads per method [default: one per core]; times depend on it, figures do not
    #[arg(long, value_name = "N", value_parser = parse_thread_count, allow_negative_numbers = true,
        default_value_t = rayon::current_num_threads(), hide_default_value = true)]
    pub threads: usize,
    /// Samples on each surface
    #[arg(long, value_name = "N", default_value = "50000", value_parser = whole_number_parser::<usize>(1, u64::MAX),
        allow_negative_numbers = true)]
    pub samples: usize,
    /// Measure the spectrum (the paper's LE), which takes longer than all the rest
    #[arg(long)]
    pub spectrum: bool,
    /// Compare pictures of the meshes from six sides
    #[arg(long)]
    pub appearance: bool,
    /// Only meshes whose file names begin with one of these
    #[arg(long, value_name = "PREFIX,PREFIX", value_delimiter = ',')]
    pub only: Vec<String>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            methods: vec!["all".into()],
            tools: Vec::new(),
            ratios: vec![0.05, 0.1, 0.2, 0.5],
            seeds: vec![0],
            repeats: 3,
            time_limit: 600.0,
            threads: 1,
            samples: 50_000,
            spectrum: false,
            appearance: false,
            only: Vec::new(),
        }
    }
}

impl Settings {
    /// Checks the settings and returns the methods.
    ///
    /// # Errors
    /// [`EvaluateError::Settings`] for an unknown method or a number out of range.
    pub fn resolve_methods(&self) -> Result<Vec<Method>, EvaluateError> {
        let refusal = |what: String| Err(EvaluateError::Settings(what));
        if let Some(ratio) = self.ratios.iter().find(|ratio| !(**ratio > 0.0 && **ratio <= 1.0)) {
            return refusal(format!("ratio {ratio}: give numbers above 0 and at most 1"));
        }
        if self.ratios.is_empty() || self.seeds.is_empty() {
            return refusal("no ratio or no seed: give at least one of each".into());
        }
        if self.repeats == 0 || self.threads == 0 || self.samples == 0 {
            return refusal("repeats, threads and samples: give numbers of at least 1".into());
        }
        if !(self.time_limit > 0.0 && self.time_limit <= 1e9) {
            return refusal(format!("time limit {}: give seconds above 0", self.time_limit));
        }
        choose_methods(&self.methods, &self.tools)
    }
}

// All that determines the figures in the rows; a resumed run must have it unchanged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Origin {
    pub version: String,
    pub settings: Settings,
    // SHA-256 of the weights of the closed assembly, and of the paper's.
    pub weights: [String; 2],
    // SHA-256 of learned weights by method.
    #[serde(default)]
    pub learned: BTreeMap<String, String>,
    // SHA-256 of the mesh files by name.
    pub meshes: BTreeMap<String, String>,
}

impl Origin {
    pub fn difference(&self, now: &Self) -> Option<String> {
        if self.version != now.version {
            return Some(format!(
                "they are of version {} of the program, this is version {}",
                self.version, now.version
            ));
        }
        for (kind, index) in [("weights", 0), ("paper-weights", 1)] {
            if self.weights[index] != now.weights[index] {
                return Some(format!("they were made with other --{kind}"));
            }
        }
        if self.learned != now.learned {
            return Some("they were made with other --learned-weights".into());
        }
        differing_field(&self.settings, &now.settings).or_else(|| self.changed_file(now))
    }

    fn changed_file(&self, now: &Self) -> Option<String> {
        let names = self.meshes.keys().chain(now.meshes.keys());
        let changed = names.into_iter().find(|name| self.meshes.get(*name) != now.meshes.get(*name))?;
        let what = match (self.meshes.get(changed), now.meshes.get(changed)) {
            (_, None) => "is gone",
            (None, _) => "is new",
            _ => "has changed",
        };
        Some(format!("the mesh file {changed} {what}"))
    }
}

fn differing_field(before: &Settings, now: &Settings) -> Option<String> {
    let [before, now] = [before, now].map(|settings| serde_json::to_value(settings).unwrap_or_default());
    let (Value::Object(before), Value::Object(now)) = (before, now) else { return None };
    let (name, value) = before.iter().find(|(name, value)| now.get(*name) != Some(value))?;
    Some(format!("`{}` was {value} and is {} now", name.replace('_', "-"), now.get(name).unwrap_or(&Value::Null)))
}

pub(super) fn weights_name(path: Option<&PathBuf>, shipped: &Weights) -> Result<String, EvaluateError> {
    let Some(path) = path else { return Ok(sha256(&shipped.to_bytes())) };
    let bytes = std::fs::read(path)
        .map_err(|error| EvaluateError::file(path, format!("cannot be read: {error}: check the path")))?;
    // An invalid network is rejected before any work.
    Weights::from_bytes(&bytes).map_err(|error| EvaluateError::file(path, error))?;
    Ok(sha256(&bytes))
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct LearnedFile {
    pub baseline: LearnedBaseline,
    pub path: PathBuf,
    pub sha256: String,
}

pub(super) fn learned_files(paths: &[PathBuf]) -> Result<Vec<LearnedFile>, EvaluateError> {
    let mut files: Vec<LearnedFile> = Vec::new();
    for path in paths {
        let bytes = std::fs::read(path)
            .map_err(|error| EvaluateError::file(path, format!("cannot be read: {error}: check the path")))?;
        let weights = LearnedWeights::from_bytes(&bytes).map_err(|error| EvaluateError::file(path, error))?;
        let baseline = weights.baseline();
        if files.iter().any(|file| file.baseline == baseline) {
            let what = format!("is a second file of weights for {}: give one for each method", baseline.name());
            return Err(EvaluateError::file(path, what));
        }
        files.push(LearnedFile { baseline, path: path.clone(), sha256: sha256(&bytes) });
    }
    Ok(files)
}

pub(super) fn learned_names(files: &[LearnedFile]) -> BTreeMap<String, String> {
    let name = |baseline: LearnedBaseline| {
        let file = files.iter().find(|file| file.baseline == baseline);
        let shipped = || sha256(&LearnedWeights::load_shipped(baseline).to_bytes());
        (baseline.name().to_string(), file.map_or_else(shipped, |file| file.sha256.clone()))
    };
    LearnedBaseline::ALL.into_iter().map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_is_named() {
        let origin = Origin {
            version: "1".into(),
            settings: Settings::default(),
            weights: ["1".into(), "2".into()],
            learned: BTreeMap::new(),
            meshes: [("a".to_string(), "1".to_string())].into(),
        };
        assert_eq!(origin.difference(&origin), None);
        let mut other = origin.clone();
        other.settings.time_limit = 0.1 + 0.2;
        assert!(origin.difference(&other).unwrap().contains("`time-limit` was 600.0 and is 0.30000000000000004 now"));
        let read: Origin = serde_json::from_str(&serde_json::to_string(&other).unwrap()).unwrap();
        assert_eq!(read.difference(&other), None);
        other = origin.clone();
        other.meshes.insert("b".into(), "2".into());
        assert!(origin.difference(&other).unwrap().contains("b is new"));
        assert!(other.difference(&origin).unwrap().contains("b is gone"));
    }

    #[test]
    fn files_of_learned_weights_say_whose_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let [one, other, none] = ["one", "other", "none"].map(|name| folder.path().join(name));
        let bytes = LearnedWeights::random(LearnedBaseline::Potamias, 0.25, 1).to_bytes();
        std::fs::write(&one, &bytes).unwrap();
        std::fs::write(&other, &bytes).unwrap();
        std::fs::write(&none, "words").unwrap();
        let files = learned_files(std::slice::from_ref(&one)).unwrap();
        assert_eq!((files[0].baseline, &files[0].sha256), (LearnedBaseline::Potamias, &sha256(&bytes)));
        assert!(learned_files(&[one, other]).unwrap_err().to_string().contains("give one"));
        assert!(learned_files(&[none]).is_err());
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        let good = Settings::default();
        assert!(good.resolve_methods().is_ok());
        let bad = [
            Settings { ratios: vec![f64::NAN], ..good.clone() },
            Settings { seeds: Vec::new(), ..good.clone() },
            Settings { repeats: 0, ..good.clone() },
            Settings { time_limit: f64::INFINITY, ..good.clone() },
        ];
        assert!(bad.iter().all(|settings| settings.resolve_methods().is_err()));
    }
}
