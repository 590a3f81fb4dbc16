//! Complete jobs: simplify a document as a [`Job`] says, and report it.
//!
//! A [`Document`] is a mesh with everything its file contains, or a glTF scene. A [`Job`] sets the size, and how to read,
//! repair, simplify, bake, pack and measure. [`run`] returns an [`Outcome`] with the results and one [`Report`]; it makes
//! the bytes of files. [`Arguments`] are the options by name. Paths, clocks, threads and printing belong to the caller.
//!
//! Errors name options as the program does: `--error`, `--keep`.

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
