//! `neural-mesh info`: describes meshes one by one.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use neural_mesh::blocks::{FileDescription, WorkingSpace, describe_pieces};
use neural_mesh::io::{self, Asset, Pieces, ReadError, ReadMesh};
use neural_mesh::job;
use neural_mesh::mesh::cleanup::CleanCounts;
use neural_mesh::mesh::{Attributes, Channel, Frame, Role, Topology, topology};
use neural_mesh::spatial::Bounds;
use serde::Serialize;

use crate::args::InfoArgs;
use crate::escapes::escape_controls_in_json;
use crate::failure::{Failure, display_path};
use crate::levels_info::describe_levels;
use crate::memory::{self, gib_to_bytes};
use crate::messages::{MessageStream, group_digits, print_error};
use crate::names::{check_stdin, parse_format};
use crate::read::{self, clean_mesh, parse_source};
use crate::request::Source;
use crate::scene_info::SceneInfo;

#[derive(Debug, Serialize)]
struct Info {
    file: String,
    vertices: usize,
    edges: usize,
    faces: usize,
    /// Lowest and highest coordinates, in those of the file.
    bounds: [[f64; 3]; 2],
    closed: bool,
    manifold: bool,
    boundary_edges: usize,
    boundary_loops: usize,
    non_manifold_edges: usize,
    non_manifold_vertices: usize,
    inconsistent_edges: usize,
    orientable: bool,
    components: usize,
    euler: i64,
    genus: Option<usize>,
    cleaned: CleanCounts,
    carries: Vec<String>,
    /// Contents of a glTF scene; the other fields describe its meshes joined into one.
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<SceneInfo>,
}

const FORMAT_ADVICE: &str = "--format NAME sets the format of the file";

pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let format = args.format.as_deref().map(parse_format).transpose()?;
    check_stdin(args.inputs.iter().map(PathBuf::as_path))?;
    memory::limit_memory(args.memory);
    let (mut n_printed, mut result) = (0, Ok(()));
    for path in &args.inputs {
        let source = Source::new(path.clone(), format, !args.no_weld).with_remedy(FORMAT_ADVICE);
        match describe(&source, args) {
            Ok(lines) => {
                let gap = (n_printed > 0 && !args.json).then(String::new);
                gap.iter().chain(&lines).for_each(|line| MessageStream::Out.print_line(line));
                n_printed += 1;
            }
            Err(failure) => {
                print_error(&failure);
                result = Err(Failure::Reported);
            }
        }
    }
    result
}

fn describe(source: &Source, args: &InfoArgs) -> Result<Vec<String>, Failure> {
    if let Some(lines) = describe_levels(&source.path, args.json)? {
        return Ok(lines);
    }
    let (info, counts) = match read::open_in_pieces(&source.path, args.memory.map(gib_to_bytes), None) {
        Some((pieces, most)) => describe_in_pieces(source, &pieces, most)?,
        None => describe_whole(source)?,
    };
    if args.json {
        let json = serde_json::to_string(&info).map_err(|error| Failure::in_file(&source.path, error))?;
        return Ok(vec![escape_controls_in_json(&json)]);
    }
    Ok(info_lines(&info, &counts.to_string()))
}

fn describe_whole(source: &Source) -> Result<(Info, CleanCounts), Failure> {
    let (read, scene) = if source.is_gltf() { read_scene(source)? } else { (read_mesh(source)?, None) };
    let carries = list_attributes(&read.mesh.attributes);
    let cleaned = clean_mesh(read.mesh, source)?;
    let bounds = Bounds::from_points(cleaned.mesh.positions());
    let info = collect_info(&source.path, &topology(&cleaned.mesh), (bounds, &cleaned.frame), &cleaned.counts);
    Ok((Info { carries, scene, ..info }, cleaned.counts))
}

fn read_mesh(source: &Source) -> Result<ReadMesh, Failure> {
    parse_source(source, io::read_attributed, io::read_attributed_path)
}

fn read_scene(source: &Source) -> Result<(ReadMesh, Option<SceneInfo>), Failure> {
    let to_failure = |error: ReadError| Failure::in_file(&source.path, error);
    let (read, asset) = match source.content.take(&source.path).transpose()? {
        Some(bytes) => (io::read_attributed(&bytes, source.format), Asset::from_stream(&bytes)),
        None => (io::read_attributed_path(&source.path, source.format), Asset::read_path(&source.path)),
    };
    Ok((read.map_err(to_failure)?, Some(SceneInfo::new(&asset.map_err(to_failure)?, source.weld))))
}

fn describe_in_pieces(source: &Source, pieces: &Pieces, most: u64) -> Result<(Info, CleanCounts), Failure> {
    let folder = std::env::temp_dir();
    let room = WorkingSpace { n_bytes: most, folder: &folder };
    let description = describe_pieces(pieces, &room, &mut |_| ControlFlow::Continue(()));
    let FileDescription { topology, bounds, frame, counts, .. } =
        description.map_err(|error| Failure::in_file(&source.path, error))?;
    let carries = pieces.other_content().into_iter().collect();
    Ok((Info { carries, ..collect_info(&source.path, &topology, (bounds, &frame), &counts) }, counts))
}

fn list_attributes(attributes: &Attributes) -> Vec<String> {
    let named = |channel: &Channel| match channel.role {
        Role::Normal => "normals".into(),
        Role::Tangent => "tangents".into(),
        Role::Uv => "texture coordinates".into(),
        Role::Colour => "colours".into(),
        Role::Skin => "a skin".into(),
        Role::MorphPosition | Role::MorphDirection => "morph targets".into(),
        _ => channel.name.clone(),
    };
    let groups: BTreeSet<u32> = attributes.groups.iter().copied().collect();
    let groups = (groups.len() > 1).then(|| format!("{} materials or groups", group_digits(groups.len())));
    let mut known = BTreeSet::new();
    let all = attributes.channels.iter().map(named).chain(groups);
    all.filter(|name| known.insert(name.clone())).collect()
}

fn collect_info(path: &Path, figures: &Topology, (bounds, frame): (Bounds, &Frame), counts: &CleanCounts) -> Info {
    Info {
        file: display_path(path),
        vertices: figures.vertices,
        edges: figures.edges,
        faces: figures.faces,
        bounds: [bounds.low, bounds.high].map(|corner| frame.to_file(corner)),
        closed: figures.closed,
        manifold: is_manifold(figures),
        boundary_edges: figures.boundary_edges,
        boundary_loops: figures.boundary_loops,
        non_manifold_edges: figures.non_manifold_edges,
        non_manifold_vertices: figures.non_manifold_vertices,
        inconsistent_edges: figures.inconsistent_edges,
        orientable: figures.orientable,
        components: figures.components,
        euler: figures.euler,
        genus: figures.genus,
        cleaned: *counts,
        carries: Vec::new(),
        scene: None,
    }
}

fn is_manifold(figures: &Topology) -> bool {
    figures.non_manifold_edges == 0 && figures.non_manifold_vertices == 0
}

fn info_lines(info: &Info, cleaned: &str) -> Vec<String> {
    let [vertices, edges, faces] = [info.vertices, info.edges, info.faces].map(group_digits);
    let [low, high] = format_bounds(info.bounds);
    let genus = info.genus.map_or("not defined".into(), |genus| genus.to_string());
    let mut lines = vec![
        format!("{}: {vertices} vertices, {edges} edges, {faces} faces", info.file),
        format!("bounds      {low} to {high}"),
        format!("closed      {}", describe_closed(info)),
        format!("manifold    {}", describe_manifold(info)),
        format!("components  {}", group_digits(info.components)),
        format!("genus       {genus} (Euler characteristic {})", info.euler),
        format!(
            "attributes  {}",
            if info.carries.is_empty() {
                "none".into()
            } else {
                job::list_names(info.carries.iter().map(String::as_str))
            }
        ),
        format!("cleaned     {cleaned}"),
    ];
    lines.extend(info.scene.iter().flat_map(SceneInfo::lines));
    lines
}

/// Formats bounds with the decimals that single precision has at their extent.
fn format_bounds([low, high]: [[f64; 3]; 2]) -> [String; 2] {
    let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let decimals = if extent > 0.0 { (6.0 - extent.log10().floor()).clamp(0.0, 17.0) as usize } else { 6 };
    [low, high].map(|corner| corner.map(|x| format!("{x:.decimals$}")).join(" "))
}

fn describe_closed(info: &Info) -> String {
    match info.closed {
        true => "yes".into(),
        false => {
            let loops = if info.boundary_loops == 1 { "loop" } else { "loops" };
            format!(
                "no: {} boundary edges in {} {loops}",
                group_digits(info.boundary_edges),
                group_digits(info.boundary_loops)
            )
        }
    }
}

fn describe_manifold(info: &Info) -> String {
    let winding = match (info.inconsistent_edges, info.orientable) {
        (0, _) => String::new(),
        (n, true) => format!(", winding changes across {} edges", group_digits(n)),
        (n, false) => format!(", winding changes across {} edges and cannot be made consistent", group_digits(n)),
    };
    match info.manifold {
        true => format!("yes{winding}"),
        false => {
            let [edges, vertices] = [info.non_manifold_edges, info.non_manifold_vertices].map(group_digits);
            format!(
                "no: {edges} edges with more than two faces, {vertices} vertices where surfaces touch without a common edge{winding}"
            )
        }
    }
}
