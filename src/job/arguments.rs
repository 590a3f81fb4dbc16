//! Options of a job by name, as text or numbers.

use std::collections::BTreeMap;
use std::fmt::Display;

use serde::Deserialize;

use crate::io::{Format, PackOptions, shorten_name};
use crate::simplify::{
    Assembly, ClosedOptions, Effort, Hidden, Optimize, Options, PaperOptions, Purpose, ScoreSource, Target,
};

use super::error::JobError;
use super::levels::{LodsBy, levels};
use super::meshopt;
use super::option_value::OptionValue;
use super::parse::{bound, count, n_bytes, share, symmetry};
use super::request::{Ignored, Job, Repair};
use super::size::{Bound, Count, Goal};

// Size below which a bare `--printable` drops components, in percent of the diagonal: 1 mm of 10 cm.
const PIECE_PERCENT: f64 = 1.0;
const POSITION_BITS: u32 = 14;
const FEATURE_ANGLE: f64 = 30.0;

/// Default of `--hold-shape`: deformation of a component in percent of the scene's diagonal.
const HELD_PERCENT: f64 = 1.0;

/// Options of `neural-mesh simplify` by name, with `_` for `-`; unknown names are errors.
///
/// Numbers may be given as text, such as `"10%"`.
///
/// ```
/// use neural_mesh::job::{Arguments, Bound, Goal};
///
/// let arguments: Arguments = serde_json::from_str(r#"{"error": "0.5%", "format": "glb", "effort": "best"}"#).unwrap();
/// assert_eq!(arguments.job().unwrap().goal, Goal::Error(Bound::Percent(0.5)));
/// assert!(serde_json::from_str::<Arguments>(r#"{"rato": 0.1}"#).is_err());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(missing_docs, reason = "the program's help says what each is")]
pub struct Arguments {
    pub ratio: Option<OptionValue>,
    pub ratio_of: BTreeMap<String, OptionValue>,
    pub vertices: Option<OptionValue>,
    pub faces: Option<OptionValue>,
    pub error: Option<OptionValue>,
    pub size: Option<OptionValue>,
    pub lods: Vec<OptionValue>,
    pub lods_by: Option<String>,
    pub format: Option<String>,
    pub assembly: Option<String>,
    pub scores: Option<String>,
    pub optimize: Option<String>,
    pub effort: Option<String>,
    pub hidden: Option<String>,
    #[serde(rename = "for")]
    pub purpose: Option<String>,
    pub seed: u64,
    pub lock_boundaries: bool,
    pub subset: bool,
    pub close: bool,
    pub place: bool,
    pub keep_components: bool,
    pub keep_features: bool,
    pub crease_angle: Option<f64>,
    pub seam_error: Option<f64>,
    pub ignore: Vec<String>,
    pub symmetric: Option<OptionValue>,
    pub keep: Vec<String>,
    pub importance: Option<String>,
    pub map: bool,
    pub prune: Option<OptionValue>,
    pub hold_shape: Option<OptionValue>,
    pub fill_holes: Option<OptionValue>,
    pub printable: Option<OptionValue>,
    pub bake: Option<usize>,
    pub compress: Option<OptionValue>,
    pub textures: Option<usize>,
    pub weld: Option<OptionValue>,
    pub no_weld: bool,
    pub no_check: bool,
    pub allow_outside: bool,
    /// True if the caller passes network weights to [`run`](super::run()).
    #[serde(skip)]
    pub has_weights: bool,
}

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
        let is_paper = one_of("--assembly", self.assembly.as_ref(), &ASSEMBLIES)?;
        let mut job = Job::new(Options::with_closed(self.target()?, self.closed_options(is_paper)?), format);
        (job.seed, job.goal) = (self.seed, self.goal()?);
        let named = |(name, of): (&String, &OptionValue)| Ok((name.clone(), parse_value("--ratio", of, share)?));
        job.shares = self.ratio_of.iter().map(named).collect::<Result<_, JobError>>()?;
        (job.weld, job.weld_near) = (!self.no_weld, distance("--weld", self.weld.as_ref())?);
        (job.seam_texels, job.prune_below) = (self.seam_error, self.prune_below()?);
        job.hold_shape = self.hold_shape()?;
        (job.repair, job.compress) = (self.repair()?, self.packing()?);
        (job.bake, job.textures) = (self.bake, self.textures);
        let ignored = |name: &String| one_of("--ignore", Some(name), &IGNORED);
        job.ignore = self.ignore.iter().map(ignored).collect::<Result<_, _>>()?;
        (job.importance, job.keep) = (self.importance.clone(), self.keep.clone());
        (job.allow_outside, job.check) = (self.allow_outside, !self.no_check);
        // The paper's assembly has no option for this, as its vertices stay anyway.
        job.exact = self.subset;
        self.set_assembly(is_paper, &mut job)?;
        job.check_options()?;
        Ok(job)
    }

    fn closed_options(&self, is_paper: bool) -> Result<ClosedOptions, JobError> {
        let angle = self.keep_features.then_some(FEATURE_ANGLE).or(self.crease_angle);
        let mut options = ClosedOptions {
            optimize: one_of("--optimize", self.optimize.as_ref(), &OPTIMIZE)?,
            effort: one_of("--effort", self.effort.as_ref(), &EFFORTS)?,
            hidden: one_of("--hidden", self.hidden.as_ref(), &HIDDEN)?,
            purpose: one_of("--for", self.purpose.as_ref(), &PURPOSES)?,
            scores: one_of("--scores", self.scores.as_ref(), &SCORES)?,
            prune: !self.keep_components,
            lock_boundaries: self.lock_boundaries,
            subset: self.subset,
            map: self.map,
            crease_angle: angle.map(|degrees| degrees as f32),
            ..ClosedOptions::default()
        };
        if self.scores.is_none() && self.has_weights {
            options.scores = ScoreSource::Network;
        }
        self.check_no_network(&options, is_paper)?;
        let plane = self.symmetric.as_ref().filter(|plane| plane.is_given());
        options.symmetric = plane.map(|plane| symmetry(plane.text().as_deref())).transpose()?;
        Ok(options)
    }

    /// Sets the paper's assembly if it is named; rejects options of the other assembly.
    fn set_assembly(&self, is_paper: bool, job: &mut Job) -> Result<(), JobError> {
        if is_paper {
            job.check_paper()?;
            let (seed, close, place) = (self.seed, self.close, self.place);
            job.options.assembly = Assembly::Paper(PaperOptions { seed, close, place });
            return Ok(());
        }
        let what = match (self.close, self.place) {
            (true, _) => {
                "--close is for --assembly paper: leave it out, the closed assembly makes no holes (--fill-holes closes those of the input)"
            }
            (_, true) => "--place is for --assembly paper: leave it out, the closed assembly always places vertices",
            _ => return Ok(()),
        };
        Err(options_error(what))
    }

    // A size that is known only with the mesh leaves the target at a ratio of 1.0.
    fn target(&self) -> Result<Target, JobError> {
        if let Some(ratio) = &self.ratio {
            return parse_value("--ratio", ratio, share).map(Target::Ratio);
        }
        // A share of the faces becomes a number later, in `Job::target`, which knows the mesh.
        Ok(match (&self.vertices, &self.faces, self.goal()?) {
            (Some(text), ..) => match parse_value("--vertices", text, count)? {
                Count::Share(ratio) => Target::Ratio(ratio),
                Count::Number(n) => Target::Vertices(n),
            },
            (_, _, Goal::Levels(sizes)) => sizes.first().map_or(Target::Ratio(1.0), |size| size.target(usize::MAX)),
            (_, Some(text), _) => match parse_value("--faces", text, count)? {
                Count::Number(n) => Target::Faces(n),
                Count::Share(_) => Target::Ratio(1.0),
            },
            _ => Target::Ratio(1.0),
        })
    }

    fn goal(&self) -> Result<Goal, JobError> {
        if let Some(text) = &self.faces
            && let Count::Share(share) = parse_value("--faces", text, count)?
        {
            return Ok(Goal::ShareOfFaces(share));
        }
        match (distance("--error", self.error.as_ref())?, &self.size) {
            (Some(error), _) => Ok(Goal::Error(error)),
            (_, Some(size)) => n_bytes(&size.text().unwrap_or_default()).map(Goal::Size),
            _ if !self.lods.is_empty() => {
                let by = self.lods_by.as_ref().map(|by| one_of("--lods-by", Some(by), &LODS_BY)).transpose()?;
                levels(&self.lods.iter().filter_map(OptionValue::text).collect::<Vec<_>>(), by)
            }
            _ => Ok(Goal::Target),
        }
    }

    // `--prune` without a size drops components smaller than the distance of `--error`.
    fn prune_below(&self) -> Result<Option<Bound>, JobError> {
        match &self.prune {
            Some(OptionValue::Flag(true)) => distance("--error", self.error.as_ref()),
            size => distance("--prune", size.as_ref()),
        }
    }

    fn hold_shape(&self) -> Result<Option<Bound>, JobError> {
        let Some(most) = self.hold_shape.as_ref().filter(|most| most.is_given()) else { return Ok(None) };
        Ok(distance("--hold-shape", Some(most))?.or(Some(Bound::Percent(HELD_PERCENT))))
    }

    fn repair(&self) -> Result<Option<Repair>, JobError> {
        if self.printable.as_ref().is_some_and(OptionValue::is_given) {
            let size = distance("--printable", self.printable.as_ref())?;
            return Ok(Some(Repair::Printable(size.unwrap_or(Bound::Percent(PIECE_PERCENT)))));
        }
        let Some(most) = self.fill_holes.as_ref().filter(|most| most.is_given()) else { return Ok(None) };
        let whole = |text: &str| text.parse().map_err(|_| "give a whole number of at least 0".to_string());
        let most = most.text().map_or(Ok(usize::MAX), |text| whole(&text));
        most.map(|most| Some(Repair::FillHoles(most))).map_err(|why| options_error(format!("--fill-holes: {why}")))
    }

    fn packing(&self) -> Result<Option<PackOptions>, JobError> {
        let Some(how) = self.compress.as_ref().filter(|how| how.is_given()) else { return Ok(None) };
        let compress = how.text().map_or(Ok(true), |how| one_of("--compress", Some(&how), &COMPRESS))?;
        if compress {
            meshopt::check()?;
        }
        Ok(Some(PackOptions { bits: POSITION_BITS, compress }))
    }

    /// Rejects weights and the paper's assembly if another option rules them out.
    fn check_no_network(&self, options: &ClosedOptions, is_paper: bool) -> Result<(), JobError> {
        let option = match (&self.scores, options.scores) {
            (Some(_), ScoreSource::Geometry) => "--scores geometry",
            (Some(_), ScoreSource::Bending) => "--scores bending",
            _ if options.optimize == Optimize::Mean => "--optimize mean",
            _ => return Ok(()),
        };
        let why = match (is_paper, self.has_weights) {
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
        let (printable, fill_holes) = (is_given(&self.printable), is_given(&self.fill_holes));
        let (symmetric, compress, weld) = (is_given(&self.symmetric), is_given(&self.compress), is_given(&self.weld));
        let pairs = [
            (keep, "--keep", printable, "--printable"),
            (keep, "--keep", fill_holes, "--fill-holes"),
            (keep, "--keep", weld, "--weld"),
            (keep, "--keep", bake, "--bake"),
            (fill_holes, "--fill-holes", symmetric, "--symmetric"),
            (printable, "--printable", fill_holes, "--fill-holes"),
            (printable, "--printable", symmetric, "--symmetric"),
            (printable, "--printable", self.no_weld, "--no-weld"),
            (bake, "--bake", is_given(&self.size), "--size"),
            (bake, "--bake", lods, "--lods"),
            (bake, "--bake", !self.ignore.is_empty(), "--ignore"),
            (compress, "--compress", symmetric, "--symmetric"),
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
        let sizes = [
            ("--ratio", is_given(&self.ratio)),
            ("--vertices", is_given(&self.vertices)),
            ("--faces", is_given(&self.faces)),
            ("--error", is_given(&self.error)),
            ("--size", is_given(&self.size)),
            ("--lods", !self.lods.is_empty()),
        ];
        let mut named = sizes.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name);
        match (named.next(), named.next()) {
            (None, _) if self.ratio_of.is_empty() => {
                Err(options_error("give a size: --ratio, --vertices, --faces, --error, --size or --lods"))
            }
            (Some("--ratio"), Some(other)) => {
                let what = "give one size for the whole mesh, and others as NAME=R";
                Err(options_error(format!("--ratio cannot be used with {other}: {what}")))
            }
            (Some(one), Some(other)) => Err(conflict_error(one, other)),
            _ if self.lods_by.is_some() && self.lods.is_empty() => Err(options_error("--lods-by: give --lods, too")),
            _ => Ok(()),
        }
    }
}

fn is_given(value: &Option<OptionValue>) -> bool {
    value.as_ref().is_some_and(OptionValue::is_given)
}

// True for the paper's.
const ASSEMBLIES: [(&str, bool); 2] = [("closed", false), ("paper", true)];
const OPTIMIZE: [(&str, Optimize); 5] = [
    ("balanced", Optimize::Balanced),
    ("mean", Optimize::Mean),
    ("max", Optimize::Max),
    ("normals", Optimize::Normals),
    ("looks", Optimize::Looks),
];
const EFFORTS: [(&str, Effort); 3] = [("standard", Effort::Standard), ("fast", Effort::Fast), ("best", Effort::Best)];
const HIDDEN: [(&str, Hidden); 2] = [("keep", Hidden::Keep), ("drop", Hidden::Drop)];
const PURPOSES: [(&str, Purpose); 2] = [("shape", Purpose::Shape), ("poses", Purpose::Poses)];
const SCORES: [(&str, ScoreSource); 3] =
    [("bending", ScoreSource::Bending), ("network", ScoreSource::Network), ("geometry", ScoreSource::Geometry)];
const LODS_BY: [(&str, LodsBy); 3] =
    [("vertices", LodsBy::Vertices), ("faces", LodsBy::Faces), ("error", LodsBy::Error)];
const COMPRESS: [(&str, bool); 2] = [("meshopt", true), ("quantize", false)];
const IGNORED: [(&str, Ignored); 4] = [
    ("uv", Ignored::Uv),
    ("normals", Ignored::Normals),
    ("colors", Ignored::Colors),
    ("materials", Ignored::Materials),
];

fn one_of<T: Copy>(option: &str, given: Option<&String>, names: &[(&str, T)]) -> Result<T, JobError> {
    let found = given.map_or(names.first(), |given| names.iter().find(|(name, _)| name == given));
    found.map(|(_, of)| *of).ok_or_else(|| {
        let names: Vec<&str> = names.iter().map(|(name, _)| *name).collect();
        options_error(format!("{option} {}: choose from {}", given.map_or("", String::as_str), names.join(", ")))
    })
}

fn parse_value<T>(option: &str, value: &OptionValue, read: fn(&str) -> Result<T, String>) -> Result<T, JobError> {
    let text = value.text().unwrap_or_default();
    read(&text).map_err(|why| options_error(format!("{option} {}: {why}", shorten_name(&text))))
}

fn distance(option: &str, value: Option<&OptionValue>) -> Result<Option<Bound>, JobError> {
    value.and_then(OptionValue::text).map(|text| bound(option, &text)).transpose()
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

    fn job(json: &str) -> Result<Job, String> {
        let arguments: Arguments = serde_json::from_str(json).map_err(|error| error.to_string())?;
        arguments.job().map_err(|error| error.to_string())
    }

    #[test]
    fn numbers_and_texts_mean_what_they_mean_on_the_command_line() {
        for (json, target) in [
            (r#"{"ratio": 0.1}"#, Target::Ratio(0.1)),
            (r#"{"ratio": "10%"}"#, Target::Ratio(0.1)),
            (r#"{"vertices": "1.5k"}"#, Target::Vertices(1500)),
            (r#"{"faces": 5000}"#, Target::Faces(5000)),
        ] {
            assert_eq!(job(json).unwrap().options.target, target, "{json}");
        }
        assert_eq!(job(r#"{"faces": "10%"}"#).unwrap().goal, Goal::ShareOfFaces(0.1));
        assert_eq!(job(r#"{"size": "2MB"}"#).unwrap().goal, Goal::Size(2_000_000));
        assert_eq!(job(r#"{"lods": [0.5, "10%"]}"#).unwrap().goal.n_levels(), Some(2));
        let pruned = job(r#"{"error": 0.5, "prune": true, "printable": true}"#).unwrap();
        assert_eq!(
            (pruned.prune_below, pruned.repair),
            (Some(Bound::Absolute(0.5)), Some(Repair::Printable(Bound::Percent(PIECE_PERCENT))))
        );
        let named = job(r#"{"ratio_of": {"head": "50%"}, "for": "poses", "format": "glb"}"#).unwrap();
        assert_eq!(
            (named.shares.len(), named.closed_options().purpose, named.format),
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
            (r#"{"ratio": 0.1, "fill_holes": "few"}"#, "--fill-holes: give a whole number"),
            (r#"{"ratio": 0.1, "scores": "geometry", "assembly": "paper"}"#, "--scores geometry: the paper's assembly"),
            (r#"{"ratio": 0.1, "close": true}"#, "--close is for --assembly paper"),
            (r#"{"ratio": 0.1, "place": true}"#, "--place is for --assembly paper"),
            (
                r#"{"ratio": 0.1, "assembly": "paper", "map": true}"#,
                "--map: not available with --assembly paper: leave one out",
            ),
            (r#"{"rato": 0.1}"#, "unknown field `rato`"),
        ] {
            let said = job(json).unwrap_err();
            assert!(said.starts_with(why) && !said.contains('\n'), "{json}: {said}");
        }
    }
}
