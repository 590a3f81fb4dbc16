//! `--ratio NAME=50%`: named faces are simplified first, then the rest to the total size.

use crate::simplify::{ClosedOptions, Event, GroupRatio, Simplified, SimplifiedGroups, simplify_groups};

use super::document::Document;
use super::error::JobError;
use super::importance::VertexValues;
use super::report::NamedShare;
use super::request::Job;
use super::watch::Watch;

/// Share of the progress bar that named faces take.
const SHARE_OF_RUN: f32 = 0.5;

/// Simplifies each name to its share and locks kept faces; returns the input for the rest.
pub fn simplify_named(
    document: &Document,
    values: &VertexValues,
    options: &ClosedOptions,
    job: &Job,
    watch: &mut dyn Watch,
) -> Result<(SimplifiedGroups, Vec<NamedShare>), JobError> {
    let mut ratios = Vec::new();
    let kept = job.arguments.keep.iter().map(|name| ("--keep", name.as_str(), 1.0));
    let shares = job.arguments.shares();
    for (option, name, ratio) in kept.chain(shares.iter().map(|(name, ratio)| ("--ratio", *name, *ratio))) {
        let groups = document.groups_named(name);
        let groups = groups.map_err(|why| JobError::Options(format!("{option} {name}: {why}")))?;
        ratios.push(GroupRatio { groups, ratio });
    }
    let attributes = document.attributes_with_groups();
    let mut input = values.input(document);
    input.attributes = &attributes;
    let mut forward_event = |mut event: Event| {
        event.total *= SHARE_OF_RUN;
        watch.event(event)
    };
    let simplified = simplify_groups(&input, options, &ratios, &mut forward_event);
    let mut simplified = simplified?;
    let before = &attributes.groups;
    let n_of = |groups: &[u32], of: &[u32]| groups.iter().filter(|group| of.contains(group)).count();
    let named_shares =
        shares.into_iter().zip(&ratios[job.arguments.keep.len()..]).map(|((name, ratio), group)| NamedShare {
            name: name.into(),
            ratio,
            faces_before: n_of(before, &group.groups),
            faces: n_of(&simplified.attributes.groups, &group.groups),
        });
    let named_shares = named_shares.collect();
    if document.input().attributes.groups.is_empty() {
        simplified.attributes.groups.clear();
    }
    Ok((simplified, named_shares))
}

/// Converts source vertices and faces in `results` to indices of the mesh that was read.
pub fn renumber(results: &mut [Simplified], simplified: &SimplifiedGroups) {
    for result in results {
        result
            .report
            .dropped
            .iter_mut()
            .for_each(|component| component.face = simplified.faces[component.face as usize]);
        let of_mesh = |own: Vec<u32>, sources: &Vec<u32>| own.into_iter().map(|v| sources[v as usize]).collect();
        result.source_vertices =
            result.source_vertices.take().zip(simplified.sources.as_ref()).map(|(own, sources)| of_mesh(own, sources));
    }
}
