//! Options that free what holds a result which was to be smaller: those alone that the program accepts for this mesh.

use clap::ValueEnum;
use neural_mesh::mesh::{Attributes, Role};

use crate::args::IgnoreArg;
use crate::report::Output;
use crate::request::Request;
use crate::subject::Subject;

/// What frees a result, in one line for each thing that holds it.
pub fn what_frees(request: &Request, subject: &Subject, output: &Output) -> Vec<String> {
    let mut lines = Vec::new();
    if output.components_keep_shape {
        lines.push("--prune=SIZE drops components smaller than SIZE".into());
    }
    if output.kept_edges > 0 && !output.components_keep_shape {
        lines.extend(of_kept_edges(request, subject.input(&[], &[]).attributes, subject.is_scene()));
    }
    if output.locked_vertices > 0 && request.options.lock_boundaries {
        lines.push("without --lock-boundaries the boundary may go".into());
    }
    if output.locked_vertices > 0 && !request.keep.is_empty() {
        lines.push(format!("without --keep {} what is kept may go", request.keep.join(" and --keep ")));
    }
    lines
}

/// What frees edges that stay: seams, edges between materials, creases.
fn of_kept_edges(request: &Request, carried: &Attributes, is_scene: bool) -> Vec<String> {
    let carries = |role| carried.channels.iter().any(|channel| channel.role == role);
    let is_grouped = carried.groups.iter().any(|group| *group != carried.groups[0]);
    let named = [
        ("uv", carries(Role::Uv)),
        ("normals", carries(Role::Normal)),
        ("colors", carries(Role::Colour)),
        ("materials", is_grouped && !is_scene),
    ];
    let typed = |what: &IgnoreArg| what.to_possible_value().map(|value| value.get_name().to_string());
    let ignored: Vec<String> = request.ignore.iter().filter_map(typed).collect();
    let free: Vec<&str> = named.into_iter().filter(|(_, is_carried)| *is_carried).map(|(name, _)| name).collect();
    let mut lines = Vec::new();
    if !free.is_empty() {
        // Values of the option replace those given before.
        let all: Vec<&str> = ignored.iter().map(String::as_str).chain(free).collect();
        let seams = if carries(Role::Uv) { ", a larger --seam-error seams of textures" } else { "" };
        lines.push(format!("--ignore {} frees kept edges{seams}", all.join(",")));
    }
    if is_scene && is_grouped {
        lines.push("obj or ply in place of a scene, with --ignore materials, frees the edges between materials".into());
    }
    if request.options.crease_angle.is_some() {
        lines.push("without --keep-features and --crease-angle creases may go".into());
    }
    lines
}
