//! Advice for results that stopped above the requested size.

use crate::mesh::{Attributes, Role};

use super::choices::Ignored;
use super::document::Document;
use super::report::OutputFigures;
use super::request::Job;

/// Returns one line per reason that kept the result too large, with an option that removes it.
pub fn list_advice(job: &Job, document: &Document, output: &OutputFigures) -> Vec<String> {
    let mut lines = Vec::new();
    if output.kept_edges > 0 {
        lines.extend(of_kept_edges(job, document.input().attributes, document.is_scene()));
    }
    if job.arguments.hold_shape.is_some() {
        lines.push("without --hold-shape shapes give way to the size".into());
    }
    if output.locked_vertices > 0 && job.closed_options().lock_boundaries {
        lines.push("without --lock-boundaries the boundary is simplified too".into());
    }
    if output.locked_vertices > 0 && !job.arguments.keep.is_empty() {
        lines
            .push(format!("without --keep {} those faces are simplified too", job.arguments.keep.join(" and --keep ")));
    }
    lines
}

fn of_kept_edges(job: &Job, carried: &Attributes, is_scene: bool) -> Vec<String> {
    let carries = |role| carried.channel(role).is_some();
    let is_grouped = carried.groups.iter().any(|group| *group != carried.groups[0]);
    let named = [
        ("uv", carries(Role::Uv)),
        ("normals", carries(Role::Normal)),
        ("colors", carries(Role::Colour)),
        ("materials", is_grouped && !is_scene),
    ];
    let free: Vec<&str> = named.into_iter().filter(|(_, is_carried)| *is_carried).map(|(name, _)| name).collect();
    let mut lines = Vec::new();
    if !free.is_empty() {
        // A second `--ignore` replaces the first, so the advice repeats the values given already.
        let all: Vec<&str> = job.arguments.ignore.iter().copied().map(Ignored::name).chain(free).collect();
        let seams = if carries(Role::Uv) { "; a larger --seam-error frees texture seams" } else { "" };
        lines.push(format!("--ignore {} frees kept edges{seams}", all.join(",")));
    }
    if is_scene && is_grouped {
        lines.push(
            "writing obj or ply instead of a scene, with --ignore materials, frees the edges between materials".into(),
        );
    }
    if job.closed_options().crease_angle.is_some() {
        lines.push("without --keep-features or --crease-angle creases are simplified too".into());
    }
    lines
}
