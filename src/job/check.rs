//! Checks for options that contradict each other.

use crate::io::Format;
use crate::simplify::{Assembly, Effort, Hidden, Optimize, Purpose};

use super::bake;
use super::error::JobError;
use super::request::{Job, Repair};
use super::size::Goal;

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
        let what = match self.bake {
            Some(size) if !is_gltf && format != Format::Obj => {
                format!("--bake {size}: {name} cannot store textures: write glb, gltf or obj")
            }
            _ if self.compress.is_some() && !is_gltf => format!("--compress: {name} is not glTF: write glb or gltf"),
            _ if self.textures.is_some()
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
        self.bake.map_or(Ok(()), bake::check_size)?;
        let refused = |what: String| Err(JobError::Options(what));
        if self.options.close && self.options.assembly != Assembly::Paper {
            return refused(
                "--close is for --assembly paper: leave it out, the closed assembly makes no holes (--fill-holes closes those of the input)".into(),
            );
        }
        if self.options.place && self.options.assembly != Assembly::Paper {
            return refused(
                "--place is for --assembly paper: leave it out, the closed assembly always places vertices".into(),
            );
        }
        let first = |given: &[Given]| given.iter().find(|(_, is_given)| *is_given).map(|(name, _)| *name);
        if self.options.assembly == Assembly::Paper
            && let Some(name) = first(&self.not_with_paper())
        {
            return refused(format!("{name}: not available with --assembly paper: leave one out"));
        }
        if self.options.symmetric.is_some()
            && let Some(name) = first(&self.not_mirrored())
        {
            return refused(format!("{name} and --symmetric cannot be combined: leave one out"));
        }
        if !self.shares.is_empty()
            && let Some(name) = first(&self.not_with_shares())
        {
            return refused(format!("--ratio NAME=R cannot be used with {name}: leave one out"));
        }
        Ok(())
    }

    fn not_with_paper(&self) -> [Given; 17] {
        let options = &self.options;
        [
            ("--lock-boundaries", options.lock_boundaries),
            ("--prune", self.prune_below.is_some() && !self.is_by_error()),
            ("--hidden", options.hidden != Hidden::Keep),
            ("--keep-components", !options.prune),
            ("--keep-features or --crease-angle", options.crease_angle.is_some()),
            ("--importance", self.importance.is_some()),
            ("--keep", !self.keep.is_empty()),
            ("--ratio NAME=R", !self.shares.is_empty()),
            ("--optimize", options.optimize != Optimize::Balanced),
            ("--effort", options.effort != Effort::Standard),
            ("--map", options.map),
            ("--printable", matches!(self.repair, Some(Repair::Printable(_)))),
            ("--for", options.purpose != Purpose::Shape),
            ("--symmetric", options.symmetric.is_some()),
            ("--error", matches!(self.goal, Goal::Error(_))),
            ("--size", matches!(self.goal, Goal::Size(_))),
            ("--lods", matches!(self.goal, Goal::ErrorLevels(_)) || self.goal.n_levels().is_some_and(|n| n > 1)),
        ]
    }

    fn not_mirrored(&self) -> [Given; 7] {
        [
            ("--lock-boundaries", self.options.lock_boundaries),
            ("--subset", self.options.subset),
            ("--keep", !self.keep.is_empty()),
            ("--prune", self.prune_below.is_some()),
            ("--hidden", self.options.hidden != Hidden::Keep),
            ("--map", self.options.map),
            ("--for", self.options.purpose != Purpose::Shape),
        ]
    }

    fn not_with_shares(&self) -> [Given; 4] {
        [
            ("--error", self.is_by_error()),
            ("--symmetric", self.options.symmetric.is_some()),
            ("--map", self.options.map),
            ("--bake", self.bake.is_some()),
        ]
    }

    fn is_by_error(&self) -> bool {
        matches!(self.goal, Goal::Error(_) | Goal::ErrorLevels(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::PackOptions;
    use crate::job::Bound;
    use crate::simplify::{Options, Symmetry, Target};

    fn error_message(change: impl FnOnce(&mut Job)) -> String {
        let mut job = Job::new(Options::new(Target::Ratio(0.5)), Format::Obj);
        assert_eq!(job.check(), Ok(()));
        change(&mut job);
        job.check().err().map_or(String::new(), |error| error.to_string())
    }

    #[test]
    fn options_that_contradict_each_other_are_named() {
        let paper = |job: &mut Job| job.options.assembly = Assembly::Paper;
        assert_eq!(error_message(paper), "");
        let by_error = error_message(|job| {
            paper(job);
            job.goal = Goal::Error(Bound::Percent(1.0));
        });
        assert_eq!(by_error, "--error: not available with --assembly paper: leave one out");
        assert!(error_message(|job| job.options.close = true).starts_with("--close is for --assembly paper"));
        assert!(error_message(|job| job.options.place = true).starts_with("--place is for --assembly paper"));
        let mirrored = error_message(|job| (job.options.symmetric, job.options.subset) = (Some(Symmetry::Best), true));
        assert_eq!(mirrored, "--subset and --symmetric cannot be combined: leave one out");
        let by_name = error_message(|job| (job.shares, job.options.map) = (vec![("head".into(), 0.5)], true));
        assert_eq!(by_name, "--ratio NAME=R cannot be used with --map: leave one out");
    }

    #[test]
    fn what_the_format_has_no_place_for_is_refused() {
        let packed = error_message(|job| job.compress = Some(PackOptions { bits: 14, compress: false }));
        assert_eq!(packed, "--compress: obj is not glTF: write glb or gltf");
        let textures = error_message(|job| (job.format, job.textures) = (Format::Stl, Some(512)));
        assert_eq!(textures, "--textures: stl cannot store textures: write glb, gltf, obj or ply");
    }
}
