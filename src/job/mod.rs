//! Complete jobs: simplify a document as a [`Job`] says, and report it.
//!
//! A [`Document`] is a mesh with the other content of its file, or a glTF scene. A [`Job`] has all options;
//! [`Arguments`] are these options by name. [`run`] returns a [`JobOutcome`]: results, report, and the bytes of files.
//! The caller opens and writes files.

mod advice;
mod arguments;
#[cfg(feature = "bake")]
mod bake;
#[cfg(not(feature = "bake"))]
#[path = "no_bake.rs"]
mod bake;
mod baked_material;
mod check;
mod choices;
mod document;
mod error;
mod files;
mod importance;
mod levels;
#[cfg(feature = "meshopt")]
mod meshopt;
#[cfg(not(feature = "meshopt"))]
#[path = "no_meshopt.rs"]
mod meshopt;
mod option_json;
mod option_names;
mod outcome;
mod parse;
mod progression;
mod report;
mod request;
mod resolve;
mod run;
mod shares;
mod simplified_results;
mod size;
mod textures;
mod to_job;
mod watch;
mod within;

pub use crate::simplify::{Size, percent};
pub use advice::list_advice;
pub use arguments::Arguments;
pub use baked_material::{BakeFigures, BakedMaterial};
pub use choices::{AssemblyName, Compression, Engine, Ignored, LodsBy};
pub use document::{Document, PlacedSurface, list_names};
pub use error::JobError;
pub use files::{Files, Meshes};
pub use option_names::{Caller, read_options, respell_options};
pub use outcome::JobOutcome;
pub use parse::{RatioOf, number_parser, parse_scaled, ratio_of, seed, share, vertices, whole_number_parser};
pub use progression::{format_of_progression, make_progression};
pub use report::{
    Certified, DistanceFigures, Dropped, JobReport, Level, MapFile, MeshSize, NamedShare, OutputFigures, REACHED,
    SAMPLES, Seconds, Shape, outcome_words, score_words, stop_reason,
};
pub use request::{Job, Names, Repair};
pub use run::run;
pub use size::{Bound, Goal};
pub use textures::Textures;
pub use watch::{JobStage, Watch};
