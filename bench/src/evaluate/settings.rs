//! Settings of an evaluation.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::{Args, Command, FromArgMatches};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::meshes::sha256;
use super::method::{Method, choose_methods};
use super::tool::Tool;
use crate::learned_baselines::{LearnedBaseline, LearnedWeights};
use neural_mesh::model::Weights;
use neural_mesh_cli::shared::numbers::{number_parser, parse_seed, parse_thread_count, share, whole_number_parser};
use neural_mesh_cli::shared::{Failure, files};

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
    /// Returns the defaults of the arguments, on one thread.
    fn default() -> Self {
        let given = Self::augment_args(Command::new("evaluate")).get_matches_from(["evaluate", "--threads", "1"]);
        Self::from_arg_matches(&given).expect("defaults are valid")
    }
}

impl Settings {
    /// Returns the methods of these names and the tools, each once.
    ///
    /// # Errors
    /// [`Failure::Usage`] for an unknown method or a tool with a name that is taken.
    pub fn resolve_methods(&self) -> Result<Vec<Method>, Failure> {
        choose_methods(&self.methods, &self.tools)
    }
}

/// Settings of an evaluation, its weights, and whether it continues.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct EvaluateOptions {
    #[command(flatten)]
    pub settings: Settings,
    /// Weights for the method network [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Weights for the method paper [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub paper_weights: Option<PathBuf>,
    /// Continue with the rows in RUN
    #[arg(long)]
    pub resume: bool,
}

// All that determines the figures in the rows; a resumed run must have it unchanged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Origin {
    pub version: String,
    pub settings: Settings,
    // SHA-256 of the weights by method.
    pub weights: BTreeMap<String, String>,
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
        if self.weights != now.weights {
            return Some("they were made with other weights".into());
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

/// Returns the SHA-256 of the weights of the closed assembly, of the paper's, and of each learned method.
///
/// # Errors
/// [`Failure`] for a file that cannot be read or is no network, before any work.
pub(super) fn weights_checksums(options: &EvaluateOptions) -> Result<BTreeMap<String, String>, Failure> {
    let checksum = |path: Option<&PathBuf>, shipped: &Weights| -> Result<String, Failure> {
        let Some(path) = path else { return Ok(sha256(&shipped.to_bytes())) };
        let bytes = files::read(path)?;
        Weights::from_bytes(&bytes).map_err(|error| Failure::in_file(path, error))?;
        Ok(sha256(&bytes))
    };
    let of_learned = |baseline: LearnedBaseline| sha256(&LearnedWeights::load_shipped(baseline).to_bytes());
    let learned = LearnedBaseline::ALL.map(|baseline| (baseline.name().into(), of_learned(baseline)));
    let ours = [
        ("closed".into(), checksum(options.weights.as_ref(), Weights::shipped_default())?),
        ("paper".into(), checksum(options.paper_weights.as_ref(), Weights::shipped_paper_open())?),
    ];
    Ok(ours.into_iter().chain(learned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_is_named() {
        let origin = Origin {
            version: "1".into(),
            settings: Settings::default(),
            weights: [("closed".to_string(), "1".to_string())].into(),
            meshes: [("a".to_string(), "1".to_string())].into(),
        };
        assert_eq!(origin.difference(&origin), None);
        let mut other = origin.clone();
        other.settings.time_limit = 0.1 + 0.2;
        assert!(origin.difference(&other).unwrap().contains("`time-limit` was 600.0 and is 0.30000000000000004 now"));
        let read: Origin = serde_json::from_str(&serde_json::to_string(&other).unwrap()).unwrap();
        assert_eq!(read.difference(&other), None);
        other = origin.clone();
        other.weights.insert("dse".into(), "2".into());
        assert!(origin.difference(&other).unwrap().contains("other weights"));
        other = origin.clone();
        other.meshes.insert("b".into(), "2".into());
        assert!(origin.difference(&other).unwrap().contains("b is new"));
        assert!(other.difference(&origin).unwrap().contains("b is gone"));
    }
}
