//! Progressions of documents, and jobs whose results are levels of one.

use crate::io::{Folder, Format, ReadMesh};
use crate::mesh::{Attributes, RawMesh};
use crate::metrics::CertifiedDistance;
use crate::search::prove_progression;
use crate::simplify::{ClosedOptions, Effort, Event, Progression, Simplified, Size};

use super::arguments::Arguments;
use super::document::Document;
use super::error::JobError;
use super::importance::VertexValues;
use super::request::Job;
use super::resolve::options_for;
use super::simplified_results::SimplifiedResults;
use super::watch::{JobStage, Watch};

/// Share of the progress that the collapse takes if distances are proved afterwards.
const SHARE_OF_COLLAPSE: f32 = 0.3;

/// Makes the progression of a document, and proves distances of its levels if `proves`.
///
/// # Errors
/// As [`run`](super::run).
pub fn make_progression(
    document: &Document,
    job: &Job,
    proves: bool,
    watch: &mut dyn Watch,
) -> Result<Progression, JobError> {
    job.check()?;
    watch.begin(JobStage::Simplify);
    let values = VertexValues::new(document, job)?;
    let options = options_for(document, job);
    let what = "--assembly: a progression needs closed";
    let closed = options.assembly.as_closed().ok_or_else(|| JobError::Options(what.into()))?;
    let kept = document.faces_named("--keep", &job.arguments.keep)?;
    let mut input = values.input(document);
    input.kept = &kept;
    let share = if proves { SHARE_OF_COLLAPSE } else { 1.0 };
    let mut of_collapse = |event: Event| watch.event(Event { total: share * event.total, ..event });
    let mut progression = Progression::new(input, closed, &mut of_collapse)?;
    if proves {
        let mut of_proofs = |event: Event| watch.event(Event { total: share + (1.0 - share) * event.total, ..event });
        prove_progression(&mut progression, &input, &mut of_proofs)?;
    }
    Ok(progression)
}

impl Document {
    /// Opens the document from which a progression was made; its results are then levels of the progression.
    ///
    /// # Errors
    /// [`JobError`] if the progression's files are another mesh, or if options of the job change the mesh.
    pub fn from_progression(progression: Progression, job: &Job) -> Result<Self, JobError> {
        check_options(job)?;
        let open = |job: &Job| match progression.files.split_first() {
            Some(((name, bytes), others)) => {
                let files = others.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
                Self::from_bytes_in(bytes, name, &Folder::in_memory(files), job)
            }
            None => Self::from_mesh(read_mesh(&progression), job),
        };
        // The progression does not say whether equal positions were welded, nor whether it is of a scene.
        for format in [job.format, Format::Glb] {
            for no_weld in [job.arguments.no_weld, !job.arguments.no_weld] {
                let arguments = Arguments { no_weld, ..job.arguments.clone() };
                let document = open(&Job { arguments, format, ..job.clone() })?;
                if progression.is_of(document.mesh()) {
                    return Ok(document.with_progression(progression));
                }
            }
        }
        Err(JobError::Document("its mesh is not that of its files".into()))
    }
}

/// Returns the format of the file from which a progression was made, if its name shows it.
pub fn format_of_progression(progression: &Progression) -> Option<Format> {
    progression.files.first().and_then(|(name, _)| Format::from_name(name))
}

/// Rejects options that would have to be known when the progression was made.
fn check_options(job: &Job) -> Result<(), JobError> {
    let ClosedOptions { effort, frame, .. } = job.closed_options();
    let same = ClosedOptions { effort, frame, ..ClosedOptions::default() };
    let is_plain = job.options.assembly.as_closed() == Some(&same)
        && job.arguments.repair().is_none()
        && job.arguments.bake.is_none()
        && job.arguments.weld.is_none()
        && (job.arguments.prune_below().is_none() && job.arguments.seam_error.is_none())
        && (job.arguments.importance.is_none()
            && job.arguments.keep.is_empty()
            && job.arguments.shares().is_empty()
            && job.arguments.ignore.is_empty());
    let what = "a progression has the options with which it was made: give a size, names of files and --effort alone";
    if is_plain { Ok(()) } else { Err(JobError::Options(what.into())) }
}

fn read_mesh(progression: &Progression) -> ReadMesh {
    let mut read = ReadMesh::default();
    let (mesh, attributes) = progression.original();
    let frame = progression.frame();
    read.mesh = RawMesh {
        positions: mesh.positions().iter().map(|p| frame.to_file(*p)).collect(),
        faces: mesh.faces().to_vec(),
        double: frame.double,
        attributes: attributes.clone(),
        ..RawMesh::default()
    };
    read
}

/// Returns the progression's levels for the goal of a job.
pub(super) fn levels_for_goal(
    document: &Document,
    progression: &Progression,
    job: &Job,
) -> Result<SimplifiedResults, JobError> {
    // The quick levels are those of the merges, as with the collapse alone.
    let is_refined = job.closed_options().effort != Effort::Fast;
    let make_level = |target: Size| Ok::<_, JobError>(progression.at_target(target, is_refined)?);
    let mut found = SimplifiedResults::new(Vec::new(), job);
    if job.goal.n_bytes().is_some() {
        return Err(JobError::Options("--size: a progression has levels by size or error: give one".into()));
    }
    found.results = job.goal.sizes().iter().map(|size| make_level(*size)).collect::<Result<_, _>>()?;
    for bound in job.goal.bounds() {
        let error = bound.to_absolute(document.diagonal());
        found.results.push(progression.at_error(error)?);
        // A level within the bound has the distance that is proved for it; the mesh itself has none.
        let proved = progression.proved_levels().iter().rev().find(|level| level.distance <= error);
        let upper = proved.map_or(0.0, |level| level.distance);
        found.certified.push(CertifiedDistance { lower: 0.0, upper, diagonal: document.diagonal() });
    }
    let wanted = document.input().attributes;
    found.results.iter_mut().for_each(|result| keep_wanted(result, wanted));
    Ok(found)
}

/// Discards attributes that the format of the result does not hold.
fn keep_wanted(result: &mut Simplified, wanted: &Attributes) {
    let attributes = &mut result.attributes;
    let mut near = 0;
    attributes.channels.retain(|channel| {
        let found = wanted.find_channel(&channel.name, near).filter(|&at| wanted.channels[at].role == channel.role);
        near = found.map_or(near, |at| at + 1);
        found.is_some()
    });
    if attributes.channels.is_empty() {
        attributes.wedges.clear();
    }
    if wanted.groups.is_empty() {
        attributes.groups.clear();
    }
}
