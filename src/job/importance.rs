//! Importance and scores of vertices from the job's options.

use crate::simplify::{Input, asked_scores, importance_of_channel, importance_of_groups};

use super::document::{Document, list_names};
use super::error::JobError;
use super::request::Job;

/// Importance and scores of vertices that a job gives; empty for none.
pub(super) struct VertexValues {
    importance: Vec<f32>,
    scores: Vec<f32>,
}

impl VertexValues {
    pub fn new(document: &Document, job: &Job) -> Result<Self, JobError> {
        let scores = asked_scores(job.closed_options().scores, document.mesh(), job.weights.as_deref());
        Ok(Self { importance: importance(document, job)?, scores })
    }

    /// Returns the document's input with these values.
    pub fn input<'a>(&'a self, document: &'a Document) -> Input<'a> {
        let mut input = document.input();
        (input.importance, input.scores) = (&self.importance, &self.scores);
        input
    }
}

/// Returns each vertex's importance, from numbers, an attribute, or `NAME=FACTOR`; empty if not set.
fn importance(document: &Document, job: &Job) -> Result<Vec<f32>, JobError> {
    if let Some(given) = document.importance() {
        let refused = || JobError::Options("importance: give numbers of at least 0, with one above 0".into());
        return given.ok_or_else(refused);
    }
    let Some(name) = &job.arguments.importance else { return Ok(Vec::new()) };
    let attributes = document.attributes();
    let Some(channel) = attributes.channels.iter().find(|channel| channel.name == *name) else {
        if let Some((part, factor)) = name.rsplit_once('=') {
            return importance_of_part(document, part, factor);
        }
        let names = list_names(attributes.channels.iter().map(|channel| channel.name.as_str()));
        return Err(JobError::Options(format!("--importance {name}: the mesh has no such attribute; it has: {names}")));
    };
    let factors = importance_of_channel(document.mesh(), attributes, channel);
    factors.ok_or_else(|| {
        JobError::Options(format!(
            "--importance {name}: the attribute must have numbers of at least 0, with one above 0"
        ))
    })
}

// Faces of the material, group or object `part` have this factor, other faces 1.
fn importance_of_part(document: &Document, part: &str, factor: &str) -> Result<Vec<f32>, JobError> {
    let refused = |why: String| JobError::Options(format!("--importance {part}={factor}: {why}"));
    let number = factor.parse().ok().filter(|number: &f32| *number > 0.0 && number.is_finite());
    let number = number.ok_or_else(|| refused("needs a number above 0 after the last =".into()))?;
    let groups = document.groups_named(part).map_err(refused)?;
    let factor_of = |group| if groups.contains(&group) { number } else { 1.0 };
    Ok(importance_of_groups(document.mesh(), document.attributes(), factor_of))
}
