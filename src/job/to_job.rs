//! The job that arguments describe, and options that exclude each other.

use std::collections::BTreeMap;
use std::fmt::Display;

use crate::io::{Format, PackOptions};
use crate::simplify::{Assembly, ClosedOptions, Draw, Optimize, Options, PaperOptions, ScoreSource, Size};

use super::arguments::Arguments;
use super::choices::{AssemblyName, Compression, Engine};
use super::error::JobError;
use super::levels::levels;
use super::meshopt;
use super::request::{Job, Repair};
use super::size::{Bound, Goal};

// Size below which a bare `--printable` drops components, in percent of the diagonal: 1 mm of 10 cm.
const PIECE_PERCENT: f64 = 1.0;
const POSITION_BITS: u32 = 14;
const FEATURE_ANGLE: f64 = 30.0;

/// Default of `--hold-shape`: deformation of a component in percent of the scene's diagonal.
const HELD_PERCENT: f64 = 1.0;

impl Arguments {
    /// Returns the job; the format is OBJ if none is given.
    ///
    /// # Errors
    /// [`JobError::Options`] if an option is out of range or two options contradict each other.
    pub fn job(&self) -> Result<Job, JobError> {
        let format = self.format.as_deref().unwrap_or("obj");
        let unknown =
            || options_error(format!("--format {format}: unknown format: choose from {}", Format::NAMES.join(", ")));
        let job = self.job_as(Format::from_name(format).ok_or_else(unknown)?)?;
        job.check()?;
        Ok(job)
    }

    /// Returns the job for `format`, unchecked against what that format can store.
    ///
    /// # Errors
    /// As [`job`](Self::job).
    pub fn job_as(&self, format: Format) -> Result<Job, JobError> {
        self.check()?;
        let (is_paper, goal) = (self.assembly == AssemblyName::Paper, self.goal()?);
        // The target of goals that a search finds is the whole mesh.
        let target = goal.sizes().first().copied().unwrap_or(Size::Ratio(1.0));
        let mut job = Job::new(Options::with_closed(target, self.closed_options(is_paper)?), format);
        (job.arguments, job.goal) = (self.clone(), goal);
        if self.compress == Some(Compression::Meshopt) {
            meshopt::check()?;
        }
        self.set_assembly(is_paper, &mut job)?;
        job.check_options()?;
        Ok(job)
    }

    /// Returns the share of all vertices, if it is given.
    fn whole_ratio(&self) -> Option<f64> {
        self.ratio.iter().find(|of| of.name.is_none()).map(|of| of.share)
    }

    fn closed_options(&self, is_paper: bool) -> Result<ClosedOptions, JobError> {
        let angle = self.keep_features.then_some(FEATURE_ANGLE).or(self.crease_angle);
        let default_scores = if self.weights.is_some() { ScoreSource::Network } else { ScoreSource::default() };
        let options = ClosedOptions {
            optimize: self.optimize,
            effort: self.effort,
            hidden: self.hidden,
            purpose: self.purpose,
            scores: self.scores.unwrap_or(default_scores),
            prune: !self.keep_components,
            lock_boundaries: self.lock_boundaries,
            subset: self.subset,
            map: self.map,
            crease_angle: angle.map(|degrees| degrees as f32),
            ..ClosedOptions::default()
        };
        self.check_no_network(&options, is_paper)?;
        Ok(options)
    }

    /// Sets the paper's assembly if it is named; rejects options of the other assembly.
    fn set_assembly(&self, is_paper: bool, job: &mut Job) -> Result<(), JobError> {
        if is_paper {
            job.check_paper()?;
            let (seed, draw, close, place) = (self.seed, self.draw, self.close, self.place);
            job.options.assembly = Assembly::Paper(PaperOptions { weights: None, seed, draw, close, place });
            return Ok(());
        }
        let what = match (self.close, self.place) {
            _ if self.draw != Draw::default() => {
                "--draw is for --assembly paper: leave it out, the closed assembly draws no samples"
            }
            (true, _) => {
                "--close is for --assembly paper: leave it out, the closed assembly makes no holes (--fill-holes closes those of the input)"
            }
            (_, true) => "--place is for --assembly paper: leave it out, the closed assembly always places vertices",
            _ => return Ok(()),
        };
        Err(options_error(what))
    }

    fn goal(&self) -> Result<Goal, JobError> {
        let size = self.whole_ratio().map(Size::Ratio).or(self.vertices).or(self.faces).map(Goal::One);
        match size.or(self.error.map(Goal::Error)).or(self.size.map(Goal::Bytes)) {
            Some(goal) => Ok(goal),
            None if !self.lods.is_empty() => levels(&self.lods, self.lods_by),
            // Shares by name alone leave the rest as it is.
            None => Ok(Goal::One(Size::Ratio(1.0))),
        }
    }

    /// Returns the share of each named material, group or object that stays.
    pub fn shares(&self) -> BTreeMap<&str, f64> {
        let named = self.ratio.iter().filter_map(|of| Some((of.name.as_deref()?, of.share)));
        self.ratio_of.iter().map(|(name, share)| (name.as_str(), *share)).chain(named).collect()
    }

    /// Returns the size below which components are dropped.
    pub fn prune_below(&self) -> Option<Bound> {
        self.prune.and_then(|size| size.or(self.error))
    }

    /// Returns the largest deformation of a component that no requested size may exceed.
    pub(super) fn most_deformation(&self) -> Option<Bound> {
        self.hold_shape.map(|most| most.unwrap_or(Bound::Percent(HELD_PERCENT)))
    }

    /// Returns the repair before simplification.
    pub fn repair(&self) -> Option<Repair> {
        let printable = self.printable.map(|size| Repair::Printable(size.unwrap_or(Bound::Percent(PIECE_PERCENT))));
        printable.or(self.fill_holes.map(|most| Repair::FillHoles(most.unwrap_or(usize::MAX))))
    }

    /// Returns whether the meshes of a scene become one: baked textures are of one, and the paper's assembly knows no other.
    pub fn joins_scenes(&self) -> bool {
        self.bake.is_some() || self.assembly == AssemblyName::Paper
    }

    /// Returns whether a glTF that is written in this format stays a scene instead of one mesh.
    pub(super) fn writes_scenes(&self, format: Format) -> bool {
        matches!(format, Format::Gltf | Format::Glb) && !self.joins_scenes()
    }

    /// Returns whether levels of detail share a file: in a glTF those of a scene or for an engine, except Unreal.
    pub fn shares_file(&self, format: Format, is_scene: bool) -> bool {
        let is_apart = self.engine == Some(Engine::Unreal) || !is_scene && self.engine.is_none();
        self.writes_scenes(format) && !is_apart
    }

    /// Returns the packing of a glTF.
    pub(super) fn packing(&self) -> Option<PackOptions> {
        let pack = |how| PackOptions { bits: POSITION_BITS, compress: how == Compression::Meshopt };
        self.compress.map(pack)
    }

    /// Rejects weights and the paper's assembly if another option rules them out.
    fn check_no_network(&self, options: &ClosedOptions, is_paper: bool) -> Result<(), JobError> {
        let option = match (&self.scores, options.scores) {
            (Some(_), ScoreSource::Geometry) => "--scores geometry",
            (Some(_), ScoreSource::Bending) => "--scores bending",
            _ if options.optimize == Optimize::Mean => "--optimize mean",
            _ => return Ok(()),
        };
        let why = match (is_paper, self.weights.is_some()) {
            (true, _) => "the paper's assembly needs a network: use --assembly closed",
            (_, true) => "it uses no network: leave --weights out",
            _ => return Ok(()),
        };
        Err(options_error(format!("{option}: {why}")))
    }

    /// Rejects options that exclude each other.
    fn check(&self) -> Result<(), JobError> {
        self.check_size()?;
        let (keep, bake, lods) = (!self.keep.is_empty(), self.bake.is_some(), !self.lods.is_empty());
        let (printable, fill_holes) = (self.printable.is_some(), self.fill_holes.is_some());
        let (compress, weld) = (self.compress.is_some(), self.weld.is_some());
        let pairs = [
            (keep, "--keep", printable, "--printable"),
            (keep, "--keep", fill_holes, "--fill-holes"),
            (keep, "--keep", weld, "--weld"),
            (keep, "--keep", bake, "--bake"),
            (printable, "--printable", fill_holes, "--fill-holes"),
            (printable, "--printable", self.no_weld, "--no-weld"),
            (bake, "--bake", self.size.is_some(), "--size"),
            (bake, "--bake", lods, "--lods"),
            (bake, "--bake", !self.ignore.is_empty(), "--ignore"),
            (compress, "--compress", self.lock_boundaries, "--lock-boundaries"),
            (compress, "--compress", self.subset, "--subset"),
            (self.textures.is_some(), "--textures", bake, "--bake"),
            (weld, "--weld", self.no_weld, "--no-weld"),
            (self.crease_angle.is_some(), "--crease-angle", self.keep_features, "--keep-features"),
        ];
        let both = pairs.into_iter().find(|(one, _, other, _)| *one && *other);
        both.map_or(Ok(()), |(_, one, _, other)| Err(conflict_error(one, other)))
    }

    /// Rejects a missing size and two sizes.
    fn check_size(&self) -> Result<(), JobError> {
        if self.ratio.iter().filter(|of| of.name.is_none()).count() > 1 {
            let what = "--ratio is given twice for the whole mesh: give it once, and others as NAME=R";
            return Err(options_error(what));
        }
        let sizes = [
            ("--ratio", self.whole_ratio().is_some()),
            ("--vertices", self.vertices.is_some()),
            ("--faces", self.faces.is_some()),
            ("--error", self.error.is_some()),
            ("--size", self.size.is_some()),
            ("--lods", !self.lods.is_empty()),
        ];
        let mut named = sizes.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name);
        match (named.next(), named.next()) {
            (None, _) if self.ratio.is_empty() && self.ratio_of.is_empty() => {
                Err(options_error("give a size: --ratio, --vertices, --faces, --error, --size or --lods"))
            }
            (Some("--ratio"), Some(other)) => {
                let what = "give one size for the whole mesh, and others as NAME=R";
                Err(options_error(format!("--ratio cannot be used with {other}: {what}")))
            }
            (Some(one), Some(other)) => Err(conflict_error(one, other)),
            _ if self.lods_by.is_some() && self.lods.is_empty() => Err(options_error("--lods-by: give --lods, too")),
            _ if self.engine.is_some() && self.lods.is_empty() => Err(options_error("--engine: give --lods, too")),
            _ if self.field_of_view.is_some() && self.lods.is_empty() => {
                Err(options_error("--field-of-view: give --lods, too"))
            }
            _ => Ok(()),
        }
    }
}

fn conflict_error(one: &str, other: &str) -> JobError {
    options_error(format!("{one} cannot be used with {other}: leave one out"))
}

fn options_error(what: impl Display) -> JobError {
    JobError::Options(what.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::read_options;
    use crate::simplify::Purpose;

    fn job(json: &str) -> Result<Job, String> {
        let arguments = read_options::<Arguments>(serde_json::from_str(json).unwrap());
        arguments.and_then(|arguments| arguments.job()).map_err(|error| error.to_string())
    }

    #[test]
    fn numbers_and_texts_mean_what_they_mean_on_the_command_line() {
        for (json, target) in [
            (r#"{"ratio": 0.1}"#, Size::Ratio(0.1)),
            (r#"{"ratio": "10%"}"#, Size::Ratio(0.1)),
            (r#"{"vertices": "1.5k"}"#, Size::Vertices(1500)),
            (r#"{"faces": 5000}"#, Size::Faces(5000)),
        ] {
            assert_eq!(job(json).unwrap().options.target, target, "{json}");
        }
        assert_eq!(job(r#"{"faces": "10%"}"#).unwrap().goal, Goal::One(Size::FaceRatio(0.1)));
        assert_eq!(job(r#"{"size": "2MB"}"#).unwrap().goal, Goal::Bytes(2_000_000));
        assert_eq!(job(r#"{"lods": [0.5, "10%"]}"#).unwrap().goal.n_levels(), Some(2));
        let pruned = job(r#"{"error": 0.5, "prune": true, "printable": true}"#).unwrap();
        assert_eq!(
            (pruned.arguments.prune_below(), pruned.arguments.repair()),
            (Some(Bound::Absolute(0.5)), Some(Repair::Printable(Bound::Percent(PIECE_PERCENT))))
        );
        let named = job(r#"{"ratio_of": {"head": "50%"}, "for": "poses", "format": "glb"}"#).unwrap();
        assert_eq!(
            (named.arguments.shares().len(), named.closed_options().purpose, named.format),
            (1, Purpose::Poses, Format::Glb)
        );
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line() {
        for (json, why) in [
            (r#"{}"#, "give a size: --ratio"),
            (r#"{"ratio": 2}"#, "--ratio 2: give a share above 0"),
            (r#"{"ratio": 0.1, "faces": 3}"#, "--ratio cannot be used with --faces"),
            (r#"{"ratio": 0.1, "optimize": "speed"}"#, "--optimize speed: choose from balanced, mean, max, normals"),
            (r#"{"ratio": 0.1, "keep": ["a"], "bake": 512}"#, "--keep cannot be used with --bake: leave one out"),
            (r#"{"ratio": 0.1, "format": "doc"}"#, "--format doc: unknown format"),
            (r#"{"ratio": 0.1, "fill_holes": "few"}"#, "--fill-holes few: give a whole number"),
            (r#"{"ratio": 0.1, "scores": "geometry", "assembly": "paper"}"#, "--scores geometry: the paper's assembly"),
            (r#"{"ratio": 0.1, "close": true}"#, "--close is for --assembly paper"),
            (r#"{"ratio": 0.1, "draw": "multinomial"}"#, "--draw is for --assembly paper"),
            (r#"{"ratio": 0.1, "place": true}"#, "--place is for --assembly paper"),
            (
                r#"{"ratio": 0.1, "assembly": "paper", "map": true}"#,
                "--map: not available with --assembly paper: leave one out",
            ),
            (r#"{"ratio_of": {"head": 2}}"#, "--ratio-of 2: give a share above 0"),
            (
                r#"{"ratio": 0.1, "ignore": ["uv", "smell"]}"#,
                "--ignore smell: choose from uv, normals, colors, materials",
            ),
            (r#"{"ratio": 0.1, "crease_angle": 200}"#, "--crease-angle 200: give degrees from 0 to 180"),
            (r#"{"lods": ["10%"], "field_of_view": 0}"#, "--field-of-view 0: give degrees above 0 and below 180"),
            (r#"{"ratio": 0.1, "field_of_view": 40}"#, "--field-of-view: give --lods, too"),
            (r#"{"error": true}"#, "--error true: give a number or a text"),
            (r#"{"rato": 0.1}"#, "no such option: rato"),
        ] {
            let said = job(json).unwrap_err();
            assert!(said.starts_with(why) && !said.contains('\n'), "{json}: {said}");
        }
    }
}
