//! `--memory` on a mesh that takes more: its shape alone, simplified in blocks that wait on the disk beside the output.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use neural_mesh::blocks::{OutOfCore, OutOfCoreError, Room, simplify_pieces};
use neural_mesh::io::{self, Extra, Model, Pieces, WriteOptions};
use neural_mesh::mesh::Attributes;
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Assembly, Hidden, SimplifyError, Target};

use crate::done::Done;
use crate::failure::Failure;
use crate::files;
use crate::memory::estimate;
use crate::names::is_stream;
use crate::plan::Part;
use crate::progress::Progress;
use crate::report::{self, Output, Report, Seconds, Size};
use crate::request::{Goal, Request};

/// What to do instead.
const REMEDY: &str = "allow more with --memory";
/// Of the memory that is allowed, what the program takes beside.
const BESIDE: u64 = 16 << 20;

/// Simplifies what takes more memory than is allowed; `None` where it does not.
pub fn simplified(
    request: &Request,
    weights: Option<&Weights>,
    progress: &mut Progress,
) -> Result<Option<Done>, Failure> {
    let path = &request.source.path;
    let Some(n_bytes) = request.memory.filter(|most| !is_stream(path) && estimate(path, request.bake) > *most) else {
        return Ok(None);
    };
    let began = Instant::now();
    // What cannot be read in pieces may fit after all.
    let Ok(pieces) = Pieces::open(path) else { return Ok(None) };
    check(request, &pieces)?;
    let folder = request.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let room = Room { n_bytes: n_bytes.saturating_sub(BESIDE), folder };
    let mut options = request.options.clone();
    options.target = request.target(usize::try_from(pieces.n_faces()).unwrap_or(usize::MAX));
    let found = simplify_pieces(&pieces, weights, &options, &room, &mut move |done| {
        progress.move_on(Part::Simplify, done);
        ControlFlow::Continue(())
    });
    let found = found.map_err(|error| match error {
        OutOfCoreError::Simplify(SimplifyError::Interrupted) => Failure::Interrupted,
        error => Failure::of(path, error),
    })?;
    let seconds = Seconds { simplify: began.elapsed().as_secs_f64(), ..Seconds::default() };
    written(request, found, options.target, seconds).map(Some)
}

/// Refuses what needs more of the mesh than its shape, or all of it at once.
fn check(request: &Request, pieces: &Pieces) -> Result<(), Failure> {
    let options = &request.options;
    let named = [
        ("--error", matches!(request.goal, Goal::Error(_))),
        ("--size", matches!(request.goal, Goal::Size(_))),
        ("--lods", matches!(request.goal, Goal::Levels(_))),
        ("--assembly paper", options.assembly == Assembly::Paper),
        ("--importance", request.importance.is_some()),
        ("--map", request.map.is_some()),
        ("--picture", request.picture.is_some()),
        ("--lock-boundaries", options.lock_boundaries),
        ("--subset", options.subset),
        ("--symmetric", options.symmetric.is_some()),
        ("--fill-holes or --printable", request.repair.is_some()),
        ("--bake", request.bake.is_some()),
        ("--compress", request.compress.is_some()),
        ("--prune", request.prune_below.is_some()),
        ("--hidden", options.hidden != Hidden::Keep),
        ("--for poses", options.for_poses),
        ("--no-weld or --weld", !request.source.weld || request.source.weld_near.is_some()),
    ];
    let whole = "the mesh takes more memory than is allowed and is simplified in pieces";
    if let Some((name, _)) = named.into_iter().find(|(_, is_asked)| *is_asked) {
        return Err(Failure::of(&request.source.path, format!("{whole}, which {name} is not for: {REMEDY}")));
    }
    let more = pieces.carries().filter(|_| request.ignore.is_empty() && !request.output_format.is_bare());
    let refused = |more| {
        let what =
            format!("{whole}, its shape alone, without {more}: {REMEDY}, or say --ignore uv,normals,colors,materials");
        Failure::of(&request.source.path, what)
    };
    more.map_or(Ok(()), |more| Err(refused(more)))
}

/// A result on its way to its file.
fn written(request: &Request, found: OutOfCore, target: Target, mut seconds: Seconds) -> Result<Done, Failure> {
    let OutOfCore { simplified, frame, counts, n_vertices, n_faces, n_blocks, .. } = found;
    let began = Instant::now();
    let extra = Extra::default();
    let model = Model::new(&simplified.mesh, frame, Attributes::NONE, &extra);
    let path = request.output.as_deref();
    let shown = path.unwrap_or(Path::new("standard output"));
    let written = io::write_attributed(&model, &WriteOptions::new(request.output_format, "mesh"));
    let written = written.map_err(|error| Failure::of(shown, error))?;
    let mut pending: Vec<_> =
        path.map(|path| files::prepare(path, &written.bytes, request.force)).transpose()?.into_iter().collect();
    let bytes = path.is_none().then_some(written.bytes);
    seconds.write = began.elapsed().as_secs_f64();
    let mut output = Output::of(Size::of(&simplified.mesh, request.report.is_some()), &simplified.report);
    output.vertices_written = written.n_vertices;
    let in_blocks = format!("in {n_blocks} blocks, for want of memory: the distance is not measured");
    let report = Report {
        input: Size { vertices: n_vertices, faces: n_faces, shape: None },
        output,
        target: report::target(&request.goal, target),
        outcome: report::outcome(&simplified.report.outcome),
        scores: report::scores(simplified.report.scores),
        oversample: simplified.report.oversample,
        seed: request.options.seed,
        threads: rayon::current_num_threads(),
        seconds,
        cleaned: (&counts).into(),
        repaired: None,
        baked: None,
        distance: None,
        certified: None,
        mirror: None,
        levels: Vec::new(),
        notes: written.notes.into_iter().chain([in_blocks]).collect(),
    };
    let json = files::prepare_json(request.report.as_deref(), &report, request.force, &mut pending)?;
    let cleaned = counts.to_string();
    Ok(Done { report, cleaned, bytes: bytes.or(json), pending, beside: None, force: request.force })
}
