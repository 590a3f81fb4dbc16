//! Jobs: all options for the simplification of a document.

use std::path::PathBuf;
use std::sync::Arc;

use crate::io::Format;
use crate::model::Weights;
use crate::simplify::{Assembly, ClosedOptions, Options};

use super::arguments::Arguments;
use super::choices::Engine;
use super::size::{Bound, Goal};

// That of Blender's extension, in degrees.
const FIELD_OF_VIEW: f64 = 60.0;

/// Request to simplify a document: how to read, repair, simplify, pack and write it.
///
/// ```
/// use neural_mesh::job::{Bound, Goal, Job};
/// use neural_mesh::io::Format;
/// use neural_mesh::simplify::{Options, Size};
///
/// let mut job = Job::new(Options::new(Size::Ratio(1.0)), Format::Glb);
/// job.goal = Goal::Error(Bound::Percent(1.0));
/// assert!(job.check().is_ok());
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Job {
    /// Options as asked for.
    pub arguments: Arguments,
    /// Options of the simplifier.
    pub options: Options,
    /// Goal of the job, which replaces `options.target`.
    pub goal: Goal,
    /// Weights of the network, as of the file that `arguments.weights` names; the shipped ones if none.
    pub weights: Option<Arc<Weights>>,
    /// Format of the results.
    pub format: Format,
    /// Names of the result files.
    pub names: Names,
    /// True if topology is reported.
    pub shapes: bool,
}

impl Job {
    /// Makes a job with these options and this format; the rest has defaults.
    pub fn new(options: Options, format: Format) -> Self {
        let goal = Goal::One(options.target);
        let seed = if let Assembly::Paper(paper) = &options.assembly { paper.seed } else { 0 };
        Self {
            arguments: Arguments { seed, ..Arguments::default() },
            options,
            goal,
            weights: None,
            format,
            names: Names::default(),
            shapes: false,
        }
    }

    /// Returns the options of the simplifier with the size of the first result and the weights.
    pub fn simplifier_options(&self) -> Options {
        let mut options = self.options.clone();
        options.target = self.goal.sizes().first().copied().unwrap_or(options.target);
        if let Assembly::Paper(paper) = &mut options.assembly {
            paper.weights.clone_from(&self.weights);
        }
        options
    }

    /// Returns the options of the closed assembly; the defaults with the paper's.
    pub fn closed_options(&self) -> ClosedOptions {
        self.options.assembly.as_closed().cloned().unwrap_or_default()
    }

    /// Returns whether a glTF stays a scene instead of one mesh.
    pub(super) fn takes_scenes(&self) -> bool {
        self.arguments.writes_scenes(self.format)
    }

    /// Returns whether levels of detail of a scene are nodes under one, and not of `MSFT_lod`.
    pub(super) fn has_sibling_levels(&self) -> bool {
        matches!(self.arguments.engine, Some(Engine::Unity | Engine::Godot)) && self.goal.n_levels().is_some()
    }

    /// Returns the vertical field of view for switch distances, in degrees.
    pub fn field_of_view(&self) -> f64 {
        self.arguments.field_of_view.unwrap_or(FIELD_OF_VIEW)
    }

    /// Returns whether each level of detail gets its own file.
    pub fn has_file_per_level(&self, is_scene: bool) -> bool {
        self.goal.n_levels().is_some() && !self.arguments.shares_file(self.format, is_scene)
    }

    /// Returns whether some vertices are locked: at boundaries or at kept faces.
    pub(super) fn keeps_unmoved_positions(&self) -> bool {
        self.closed_options().lock_boundaries || !self.arguments.keep.is_empty() || !self.arguments.shares().is_empty()
    }

    /// Returns whether some vertices must keep their exact positions.
    pub(super) fn keeps_positions(&self) -> bool {
        self.arguments.subset || self.closed_options().subset || self.keeps_unmoved_positions()
    }
}

/// Names of result files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// One file name for all results, or one each; empty if unknown.
    pub files: Vec<String>,
    /// Base name of companion files that levels of detail share.
    pub shared: Option<String>,
    /// Folder of the files, if they are written to disk.
    pub folder: Option<PathBuf>,
    /// True if companion files change no file that the folder has, read or not.
    pub keeps_all: bool,
}

impl Names {
    /// Returns the file name of a result.
    pub fn file(&self, number: usize) -> &str {
        self.files.get(number).map_or("mesh", String::as_str)
    }

    /// Returns whether each result has its own file.
    pub fn are_several(&self) -> bool {
        self.files.len() > 1
    }
}

/// Repair before simplification.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Repair {
    /// Closes holes of at most this many edges.
    FillHoles(usize),
    /// Makes a solid; drops components below this size.
    Printable(Bound),
}
