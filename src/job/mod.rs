//! Complete jobs: simplify a document as a [`Job`] says, and report it.
//!
//! A [`Document`] is a mesh with the other content of its file, or a glTF scene. A [`Job`] has all options;
//! [`Arguments`] are these options by name. [`run`] returns an [`Outcome`]: results, report, and the bytes of files.
//! The caller opens and writes files.

mod advice;
mod arguments;
#[cfg(feature = "bake")]
mod bake;
#[cfg(not(feature = "bake"))]
#[path = "no_bake.rs"]
mod bake;
mod check;
mod document;
mod dress;
mod error;
mod files;
mod importance;
mod levels;
mod lighter;
#[cfg(feature = "meshopt")]
mod meshopt;
#[cfg(not(feature = "meshopt"))]
#[path = "no_meshopt.rs"]
mod meshopt;
mod outcome;
mod parse;
mod report;
mod request;
mod run;
mod shares;
mod size;
mod textures;
mod value;
mod watch;
mod within;

pub use advice::what_frees;
pub use arguments::Arguments;
pub use document::{Document, Seen, listed};
pub use dress::{Baked, Dress};
pub use error::JobError;
pub use files::{Files, Meshes};
pub use outcome::Outcome;
pub use parse::{RatioOf, bound, count, ratio_of, scaled, share};
pub use report::{
    Certified, Cleaned, Distance, Dropped, Level, MapFile, NamedShare, Output, REACHED, Repaired, Report, SAMPLES,
    Seconds, Shape, Size, TargetWords, outcome_words, score_words, target_words, why_stopped,
};
pub use request::{Ignored, Job, Names, Repair};
pub use run::run;
pub use size::{Bound, Count, Goal, LevelSize, percent};
pub use textures::Textures;
pub use value::Value;
pub use watch::{Part, Watch};
