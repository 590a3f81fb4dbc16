//! Checks for options that contradict each other.

use crate::io::Format;
use crate::simplify::{Effort, Hidden, Optimize, Purpose};

use super::bake;
use super::choices::Engine;
use super::error::JobError;
use super::request::Job;

// Name of an option, and true if the option is given.
type Given = (&'static str, bool);

impl Job {
    /// Rejects options that contradict each other or that the format cannot store.
    ///
    /// # Errors
    /// [`JobError::Options`] names the options.
    pub fn check(&self) -> Result<(), JobError> {
        self.check_options().and_then(|()| self.check_format())
    }

    /// Rejects options that the format cannot store.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn check_format(&self) -> Result<(), JobError> {
        let (format, name) = (self.format, self.format.name());
        let is_gltf = matches!(format, Format::Glb | Format::Gltf);
        let what = match self.arguments.bake {
            Some(size) if !is_gltf && format != Format::Obj => {
                format!("--bake {size}: {name} cannot store textures: write glb, gltf or obj")
            }
            _ if self.arguments.compress.is_some() && !is_gltf => {
                format!("--compress: {name} is not glTF: write glb or gltf")
            }
            _ if self.arguments.engine == Some(Engine::Gltf) && !is_gltf => {
                format!("--engine gltf: {name} is not glTF: write glb or gltf")
            }
            _ if self.arguments.textures.is_some()
                && !is_gltf
                && !matches!(format, Format::Obj | Format::Ply | Format::PlyAscii) =>
            {
                format!("--textures: {name} cannot store textures: write glb, gltf, obj or ply")
            }
            _ => return Ok(()),
        };
        Err(JobError::Options(what))
    }

    /// Rejects options that contradict each other in any format.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn check_options(&self) -> Result<(), JobError> {
        self.arguments.bake.map_or(Ok(()), bake::check_size)?;
        if self.options.assembly.as_closed().is_none() {
            self.check_paper()?;
        }
        if !self.arguments.shares().is_empty() {
            reject_first(&self.not_with_shares(), |name| {
                format!("--ratio NAME=R cannot be used with {name}: leave one out")
            })?;
        }
        Ok(())
    }

    /// Rejects options that the paper's assembly lacks.
    pub(super) fn check_paper(&self) -> Result<(), JobError> {
        let options = self.closed_options();
        let given = [
            ("--lock-boundaries", options.lock_boundaries),
            ("--prune", self.arguments.prune_below().is_some() && !self.goal.is_by_error()),
            ("--hold-shape", self.arguments.hold_shape.is_some()),
            ("--hidden", options.hidden != Hidden::Keep),
            ("--keep-components", !options.prune),
            ("--keep-features or --crease-angle", options.crease_angle.is_some()),
            ("--importance", self.arguments.importance.is_some()),
            ("--keep", !self.arguments.keep.is_empty()),
            ("--ratio NAME=R", !self.arguments.shares().is_empty()),
            ("--optimize", options.optimize != Optimize::Balanced),
            ("--effort", options.effort != Effort::Standard),
            ("--map", options.map),
            ("--printable", self.arguments.printable.is_some()),
            ("--for", options.purpose != Purpose::Shape),
            ("--error", self.goal.is_by_error() && self.goal.n_levels().is_none()),
            ("--size", self.goal.n_bytes().is_some()),
            ("--lods", self.goal.n_levels().is_some_and(|n| n > 1 || self.goal.is_by_error())),
        ];
        reject_first(&given, |name| format!("{name}: not available with --assembly paper: leave one out"))
    }

    fn not_with_shares(&self) -> [Given; 3] {
        let options = self.closed_options();
        [("--error", self.goal.is_by_error()), ("--map", options.map), ("--bake", self.arguments.bake.is_some())]
    }
}

/// Rejects the first option that is given.
fn reject_first(given: &[Given], what: impl Fn(&str) -> String) -> Result<(), JobError> {
    let first = given.iter().find(|(_, is_given)| *is_given);
    first.map_or(Ok(()), |(name, _)| Err(JobError::Options(what(name))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Bound, Compression, Goal};
    use crate::simplify::{Assembly, ClosedOptions, Options, PaperOptions, Size};

    fn error_message(change: impl FnOnce(&mut Job)) -> String {
        let mut job = Job::new(Options::new(Size::Ratio(0.5)), Format::Obj);
        assert_eq!(job.check(), Ok(()));
        change(&mut job);
        job.check().err().map_or(String::new(), |error| error.to_string())
    }

    #[test]
    fn options_that_contradict_each_other_are_named() {
        let paper = |job: &mut Job| job.options.assembly = Assembly::Paper(PaperOptions::default());
        let closed = |job: &mut Job, options| job.options.assembly = Assembly::Closed(options);
        assert_eq!(error_message(paper), "");
        let by_error = error_message(|job| {
            paper(job);
            job.goal = Goal::Error(Bound::Percent(1.0));
        });
        assert_eq!(by_error, "--error: not available with --assembly paper: leave one out");
        let by_name = error_message(|job| {
            closed(job, ClosedOptions { map: true, ..ClosedOptions::default() });
            job.arguments.ratio_of = [("head".into(), 0.5)].into();
        });
        assert_eq!(by_name, "--ratio NAME=R cannot be used with --map: leave one out");
    }

    #[test]
    fn what_the_format_has_no_place_for_is_refused() {
        let packed = error_message(|job| job.arguments.compress = Some(Compression::Quantize));
        assert_eq!(packed, "--compress: obj is not glTF: write glb or gltf");
        let textures = error_message(|job| (job.format, job.arguments.textures) = (Format::Stl, Some(512)));
        assert_eq!(textures, "--textures: stl cannot store textures: write glb, gltf, obj or ply");
    }
}
