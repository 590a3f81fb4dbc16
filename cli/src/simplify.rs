//! `neural-mesh simplify`: read, simplify, measure, draw, write, say.

use std::path::{Path, PathBuf};
use std::time::Instant;

use neural_mesh::io::{Format, OutputFile, PackOptions, Packing};
use neural_mesh::mesh::Role;
use neural_mesh::metrics::CertifiedDistance;
use neural_mesh::model::Weights;
use neural_mesh::search::{simplify_to_error, simplify_to_size};
use neural_mesh::simplify::{
    Event, Hidden, Input, Listener, Options, Outcome, Purpose, SEAM_ERROR, Simplified, Target, importance_of_channel,
    importance_of_groups, simplify_input, simplify_levels_of_detail,
};

use crate::advice::what_frees;
use crate::bake;
use crate::bound::Bound;
use crate::done::Done;
use crate::drawing::{drawn, pictured};
use crate::dress::{Baked, Dress};
use crate::failure::{Failure, name};
use crate::files::{self, Pending};
use crate::interrupt;
use crate::level_files::level_files;
use crate::levels::LevelSize;
use crate::names::is_stream;
use crate::out_of_core;
use crate::plan::{Part, Plan};
use crate::progress::Progress;
use crate::read::read_weights;
use crate::report::{
    self, Certified, Distance, Level, MapFile, NamedShare, Output, REACHED, Report, SAMPLES, Seconds, Size,
};
use crate::request::{Goal, Request};
use crate::shares;
use crate::subject::{Meshes, Subject, listed};
use crate::words::{self, Voice};

/// Area of a square as high as the screen, over that of the screen.
const SCREEN: f64 = 9.0 / 16.0;
/// Share of a distance that rounding may take, before coordinates get more bits.
const ROUNDING_OF_ERROR: f64 = 0.125;

/// Does what is asked, on as many threads as asked.
pub fn run(request: Request) -> Result<(), Failure> {
    check_places(&request)?;
    interrupt::watch(Failure::Interrupted);
    in_pool(request.n_threads, || run_in_pool(request))
}

/// Refuses, before any work, places where no file of the request can be put.
pub fn check_places(request: &Request) -> Result<(), Failure> {
    let results = [&request.report, &request.picture, &request.map];
    let results = results.into_iter().flatten().filter(|path| !is_stream(path)).cloned();
    let paths: Vec<PathBuf> = outputs(request).into_iter().chain(results).collect();
    files::check_places(paths.iter().map(PathBuf::as_path), request.force)
}

/// Does something on so many threads, or on one per core.
pub fn in_pool(n_threads: Option<usize>, work: impl FnOnce() -> Result<(), Failure> + Send) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads.unwrap_or(0)).build();
    let pool = pool.map_err(|error| Failure::Failed(format!("threads cannot be started: {error}: ask for fewer")))?;
    pool.install(work)
}

fn run_in_pool(mut request: Request) -> Result<(), Failure> {
    let mut progress = Progress::new(request.quiet, Plan::of(&request, None));
    let weights = read_weights(request.weights.as_deref(), request.options.assembly)?;
    let done = match out_of_core::simplified(&request, weights.as_ref(), &mut progress)? {
        Some(done) => done,
        None => simplify_file(&mut request, weights.as_ref(), &mut progress)?,
    };
    drop(progress);
    let (report, cleaned) = done.put()?;
    say(&request, &report, &cleaned);
    met(&request, &report)
}

/// Whether what was written is as asked, as far as that matters for the exit code.
pub fn met(request: &Request, report: &Report) -> Result<(), Failure> {
    let mut outcomes = std::iter::once(&report.outcome).chain(report.levels.iter().map(|level| &level.outcome));
    match outcomes.find(|outcome| *outcome != REACHED) {
        Some(outcome) if request.strict => {
            let written = request.output.as_deref().map_or("standard output".into(), name);
            let is_written =
                if request.stays_in_memory { "the result" } else { &format!("{written}: is written, but") };
            Err(Failure::Unmet(format!("{is_written} {outcome}")))
        }
        _ => Ok(()),
    }
}

/// Reads the mesh, simplifies, writes beside the places of the results, measures, draws.
pub fn simplify_file(
    request: &mut Request,
    weights: Option<&Weights>,
    progress: &mut Progress,
) -> Result<Done, Failure> {
    let mut read = 0.0;
    progress.show(Part::Read);
    let subject = timed(&mut read, || Subject::follow(request))?;
    simplify_subject(&subject, request, weights, read, progress).map(|(done, _)| done)
}

/// As [`simplify_file`], for a mesh that is read, in so many seconds; gives the results, too.
pub fn simplify_subject(
    subject: &Subject,
    request: &Request,
    weights: Option<&Weights>,
    read: f64,
    progress: &mut Progress,
) -> Result<(Done, Vec<Simplified>), Failure> {
    let mut seconds = Seconds { read, ..Seconds::default() };
    progress.follow(Plan::of(request, Some(subject.mesh())));
    let lighter = timed(&mut seconds.simplify, || lighter(subject, request, weights, progress))?;
    seconds.stages = report::stages(progress.take_stages());
    let dress = dressed(subject, &lighter.results, request, progress)?;
    seconds.bake = dress.as_ref().map(|dress| dress.figures.seconds);
    let (packing, unpacked) = packed(subject, &lighter.results.iter().collect::<Vec<_>>(), lighter.pack, request)?;
    progress.show(Part::Check);
    let measured = |result| measured(subject, result, packing.as_ref(), request);
    let mut levels: Vec<Level> = timed(&mut seconds.check, || lighter.results.iter().map(measured).collect());
    progress.show(Part::Write);
    let worn = (dress.as_ref(), packing.as_ref());
    let written = timed(&mut seconds.write, || written(subject, &lighter.results, &levels, worn, request))?;
    levels.iter_mut().zip(&written.n_vertices).for_each(|(level, n)| level.output.vertices_written = *n);
    let certified = lighter.certified.iter().map(|distance| Certified::of(distance, subject.diagonal()));
    levels.iter_mut().zip(certified).for_each(|(level, certified)| level.certified = Some(certified));
    let first = lighter.results.first().ok_or_else(|| Failure::of(&request.source.path, "no result was made"))?;
    let of_dress = dress.as_ref().map_or(Vec::new(), |dress| dress.notes.clone());
    let mut notes = [subject.notes.clone(), of_dress, unpacked, written.notes].concat();
    notes.extend(lighter.note.map(String::from).into_iter().chain(no_poses(subject, request)));
    let pictured = pictured(request, subject, (first, dress.as_ref()), &mut notes)?;
    let baked = dress.map(|dress| dress.figures);
    let report = told(request, subject, first, levels, Told { notes, baked, seconds, named: lighter.named })?;
    progress.show(Part::Picture);
    let drawn = drawn(request, pictured.as_ref(), &report)?;
    let mut pending: Vec<Pending> = written.pending.into_iter().chain(drawn).collect();
    pending.extend(mapped(request, subject, first)?);
    let json = files::prepare_json(request.report.as_deref(), &report, request.force, &mut pending)?;
    let bytes = written.bytes.or(json);
    let cleaned = subject.counts.to_string();
    let done = Done { report, cleaned, bytes, pending, beside: written.beside, force: request.force };
    Ok((done, lighter.results))
}

/// What a result wears that is baked for it, where that is asked for.
fn dressed(
    subject: &Subject,
    results: &[Simplified],
    request: &Request,
    progress: &mut Progress,
) -> Result<Option<Dress>, Failure> {
    let (Some(size), Some(result)) = (request.bake, results.first()) else { return Ok(None) };
    progress.show(Part::Bake);
    let is_gltf = matches!(request.output_format, Format::Gltf | Format::Glb);
    let (looks, missing) = subject.looks(request.allow_outside);
    let original = (subject.mesh(), subject.attributes(), &looks);
    let dress = bake::dress(size, is_gltf, original, &result.mesh);
    let dress = dress.map_err(|error| Failure::of(&request.source.path, error))?;
    Ok(Some(Dress { notes: [missing, dress.notes].concat(), ..dress }))
}

/// Does something and adds the seconds it took.
fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let began = Instant::now();
    let result = work();
    *seconds += began.elapsed().as_secs_f64();
    result
}

/// The results of a run.
struct Lighter {
    /// One, or one for each level of detail.
    results: Vec<Simplified>,
    /// A proof for each, where distances were asked for.
    certified: Vec<CertifiedDistance>,
    /// What a search could not look at.
    note: Option<&'static str>,
    /// How numbers are to be packed.
    pack: Option<PackOptions>,
    /// What became of names with shares of their own.
    named: Vec<NamedShare>,
}

impl Lighter {
    fn of(results: Vec<Simplified>, request: &Request) -> Self {
        Self { results, certified: Vec::new(), note: None, pack: request.compress, named: Vec::new() }
    }
}

/// Why a search by distance may end where a smaller result holds the bound.
const ENDED_EARLY: &str = "the search ended early, a smaller mesh may hold the bound: needles, or large faces across each other, take long to measure";

fn lighter(
    subject: &Subject,
    request: &Request,
    weights: Option<&Weights>,
    progress: &mut Progress,
) -> Result<Lighter, Failure> {
    let importance = importance(subject, request)?;
    let options = options_for(subject, request)?;
    if request.shares.is_empty() {
        let kept = subject.faces_named("--keep", &request.keep)?;
        let input = subject.input(&importance, &kept);
        return whole(subject, &input, (weights, &options), request, progress);
    }
    let (made, named) = shares::simplify_named(subject, &importance, (weights, &options), request, progress)?;
    let mut lighter = whole(subject, &made.input(subject.united()), (weights, &options), request, progress)?;
    shares::widen(&mut lighter.results, &made);
    Ok(Lighter { named, ..lighter })
}

/// Simplifies to what the request asks of the whole.
fn whole(
    subject: &Subject,
    input: &Input,
    (weights, options): (Option<&Weights>, &Options),
    request: &Request,
    progress: &mut Progress,
) -> Result<Lighter, Failure> {
    let refused = |error| Failure::of_simplify(&error, &request.source.path);
    let tell: &mut Listener = &mut |event| progress.event(event);
    let one = |result| Lighter::of(vec![result], request);
    match &request.goal {
        Goal::Target | Goal::ShareOfFaces(_) => simplify_input(input, weights, options, tell).map(one).map_err(refused),
        Goal::Levels(sizes) => {
            let target = |size: &LevelSize| numbered(size.target(subject.mesh().faces().len()), subject, request);
            let further: Vec<Target> = sizes.iter().skip(1).map(target).collect();
            let results = simplify_levels_of_detail(input, weights, options, &further, tell).map_err(refused)?;
            Ok(Lighter::of(results, request))
        }
        Goal::Error(bound) => within(&[*bound], (subject, input), (weights, options), request, progress),
        Goal::ErrorLevels(bounds) => within(bounds, (subject, input), (weights, options), request, progress),
        Goal::Size(n_bytes) => {
            subject.check_bytes(*n_bytes, request, &file_name(request, 0))?;
            let bytes_of = |result: &Simplified| bytes_of(subject, result, request);
            simplify_to_size(input, weights, options, *n_bytes, &bytes_of, tell).map(one)
        }
    }
}

/// Finds the smallest result within each of these distances, which rise. Numbers are packed for the least of them.
fn within(
    bounds: &[Bound],
    (subject, input): (&Subject, &Input),
    (weights, options): (Option<&Weights>, &Options),
    request: &Request,
    progress: &mut Progress,
) -> Result<Lighter, Failure> {
    let errors: Vec<f64> = bounds.iter().map(|bound| bound.over(subject.diagonal())).collect();
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let mut lighter = Lighter::of(Vec::new(), request);
    lighter.pack = pack_below(least, subject, request);
    let rounding = rounding_below(least, lighter.pack.as_ref(), subject, request)?;
    for (number, error) in errors.iter().enumerate() {
        let mut tell = |mut event: Event| {
            event.total = (number as f32 + event.total) / errors.len() as f32;
            progress.event(event)
        };
        let found = simplify_to_error(input, weights, options, error - rounding, &mut tell);
        let found = found.map_err(|error| Failure::of_simplify(&error, &request.source.path))?;
        lighter.note = lighter.note.or(found.ended_early.then_some(ENDED_EARLY));
        let (mut result, mut distance) = (found.simplified, widened(&found.distance, rounding));
        // What holds a smaller distance holds this one, too, and a search may end early.
        if let (Some(last), Some(held)) = (lighter.results.last(), lighter.certified.last())
            && last.mesh.faces().len() <= result.mesh.faces().len()
            && last.report.outcome == Outcome::Reached
        {
            (result, distance) = (last.clone(), *held);
        }
        lighter.results.push(result);
        lighter.certified.push(distance);
    }
    Ok(lighter)
}

/// Returns the bytes that a result takes when it is written.
fn bytes_of(subject: &Subject, result: &Simplified, request: &Request) -> Result<usize, Failure> {
    let (packing, _) = packed(subject, &[result], request.compress, request)?;
    let alone = Meshes { results: vec![result], packing: packing.as_ref(), ..Meshes::default() };
    Ok(files_of(subject, &alone, request, 0)?.n_bytes())
}

/// What is asked of the simplifier, now that the mesh is known.
fn options_for(subject: &Subject, request: &Request) -> Result<Options, Failure> {
    let prune_below = request.prune_below.map_or(0.0, |size| size.over(subject.diagonal()));
    let symmetric = request.options.symmetric.map(|symmetry| subject.symmetry(symmetry)).transpose()?;
    let seam_error = request.seam_texels.map_or(SEAM_ERROR, |texels| subject.share_of_texture(texels, request));
    let mut options = request.options.clone();
    options.frame = subject.written_frame(request);
    options.target = numbered(request.target(subject.mesh().faces().len()), subject, request);
    options.prune_below = prune_below;
    options.seam_error = seam_error;
    options.symmetric = symmetric;
    Ok(options)
}

/// Returns a target of the whole in numbers, where some names have shares: what is simplified has fewer vertices then.
fn numbered(target: Target, subject: &Subject, request: &Request) -> Target {
    if request.shares.is_empty() { target } else { shares::in_numbers(target, subject.mesh().positions().len()) }
}

/// What is done where nothing says which poses there are.
fn no_poses(subject: &Subject, request: &Request) -> Option<String> {
    let has_poses = subject.attributes().channels.iter().any(|channel| channel.role == Role::MorphPosition);
    let what = "--for poses: no skin or morph target is kept: as if every place might bend alike";
    (request.options.purpose == Purpose::Poses && !has_poses).then(|| what.into())
}

/// How far the file may round vertices, which has to be less than the distance asked for.
fn rounding_below(
    error: f64,
    pack: Option<&PackOptions>,
    subject: &Subject,
    request: &Request,
) -> Result<f64, Failure> {
    let (rounding, format) = (subject.rounding(request), request.output_format.name());
    let on_grid = pack.map_or(0.0, |pack| subject.packed_rounding(pack.bits, error));
    if on_grid > 0.0 && on_grid >= error {
        let what = format!(
            "--compress rounds vertices by up to {on_grid:.1e}, no less than the distance asked for: leave it out"
        );
        return Err(Failure::of(&request.source.path, what));
    }
    if rounding > 0.0 && rounding >= error {
        let what = format!(
            "{format} rounds vertices by up to {rounding:.1e} there, no less than the distance asked for: write ply, obj or glb"
        );
        return Err(Failure::of(&request.source.path, what));
    }
    Ok(rounding + on_grid)
}

/// How numbers are packed where a distance is asked for: with as many bits as leave nearly all of it to the simplifier.
fn pack_below(error: f64, subject: &Subject, request: &Request) -> Option<PackOptions> {
    let asked = request.compress?;
    let is_small = |bits: &u32| subject.packed_rounding(*bits, error) <= ROUNDING_OF_ERROR * error;
    let most = PackOptions::MOST_BITS;
    Some(PackOptions { bits: (asked.bits..most).find(is_small).unwrap_or(most), ..asked })
}

/// How the numbers of results are packed, where that is asked for; beside it what cannot be, in one line each.
fn packed(
    subject: &Subject,
    results: &[&Simplified],
    options: Option<PackOptions>,
    request: &Request,
) -> Result<(Option<Packing>, Vec<String>), Failure> {
    let Some(options) = options else { return Ok((None, Vec::new())) };
    let packing = subject.packing(results, request, &options);
    let (packing, notes) = packing.map_err(|error| Failure::of(&request.source.path, error))?;
    Ok((Some(packing), notes))
}

/// The bounds of a distance where vertices may be moved so far.
fn widened(distance: &CertifiedDistance, by: f64) -> CertifiedDistance {
    let mut wide = *distance;
    wide.lower = (wide.lower - by).max(0.0);
    wide.upper += by;
    wide
}

/// How much the vertices count, where the request names an attribute that says it, or a part of the mesh and its factor.
fn importance(subject: &Subject, request: &Request) -> Result<Vec<f32>, Failure> {
    if let Some(given) = subject.importance() {
        let refused = || Failure::Usage("importance: needs numbers of at least 0, not all of them 0".into());
        return given.ok_or_else(refused);
    }
    let Some(name) = &request.importance else { return Ok(Vec::new()) };
    let attributes = subject.attributes();
    let Some(channel) = attributes.channels.iter().find(|channel| channel.name == *name) else {
        if let Some((part, factor)) = name.rsplit_once('=') {
            return importance_of_part(subject, part, factor);
        }
        let names = listed(attributes.channels.iter().map(|channel| channel.name.as_str()));
        return Err(Failure::Usage(format!("--importance {name}: the mesh has no such attribute; it has: {names}")));
    };
    let factors = importance_of_channel(subject.mesh(), attributes, channel);
    factors
        .ok_or_else(|| Failure::Usage(format!("--importance {name}: needs numbers of at least 0, not all of them 0")))
}

/// How much the vertices count where the faces of one name count as often as `factor` says.
fn importance_of_part(subject: &Subject, part: &str, factor: &str) -> Result<Vec<f32>, Failure> {
    let refused = |why: String| Failure::Usage(format!("--importance {part}={factor}: {why}"));
    let number = factor.parse().ok().filter(|number: &f32| *number > 0.0 && number.is_finite());
    let number = number.ok_or_else(|| refused("needs a number above 0 after the last =".into()))?;
    let groups = subject.groups_named(part).map_err(refused)?;
    let factor_of = |group| if groups.contains(&group) { number } else { 1.0 };
    Ok(importance_of_groups(subject.mesh(), subject.attributes(), factor_of))
}

/// Where the mesh goes, or each level of detail; those of a scene are one file where the name has no place for the level.
pub fn outputs(request: &Request) -> Vec<PathBuf> {
    let Some(path) = &request.output else { return Vec::new() };
    level_files(request).unwrap_or_else(|| vec![path.clone()])
}

/// Results on their way.
#[derive(Default)]
struct OnTheirWay {
    bytes: Option<Vec<u8>>,
    pending: Vec<Pending>,
    beside: Option<(PathBuf, Vec<OutputFile>)>,
    notes: Vec<String>,
    /// Vertices of each result as its file has them.
    n_vertices: Vec<Option<usize>>,
}

/// The meshes as bytes where standard output is their place, else as files on their way.
fn written(
    subject: &Subject,
    results: &[Simplified],
    levels: &[Level],
    (dress, packing): (Option<&Dress>, Option<&Packing>),
    request: &Request,
) -> Result<OnTheirWay, Failure> {
    let mut done = OnTheirWay::default();
    if request.stays_in_memory {
        return Ok(done);
    }
    let paths = outputs(request);
    let results: Vec<&Simplified> = results.iter().collect();
    let coverage = if results.len() > 1 && paths.len() == 1 { coverage(levels) } else { Vec::new() };
    let n_each = if paths.len() > 1 { 1 } else { results.len().max(1) };
    for (number, results) in results.chunks(n_each).enumerate() {
        let meshes = Meshes { results: results.to_vec(), coverage: coverage.clone(), dress, packing };
        let files = files_of(subject, &meshes, request, number)?;
        done.notes.extend(files.notes.into_iter().filter(|_| number == 0));
        done.n_vertices.extend(files.n_vertices);
        let Some(path) = paths.get(number) else {
            let n = files.beside.len();
            done.notes.extend((n > 0).then(|| format!("{n} files beside the mesh are not written to standard output")));
            done.bytes = Some(files.bytes);
            continue;
        };
        done.pending.push(files::prepare(path, &files.bytes, request.force)?);
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let (_, beside) = done.beside.get_or_insert((folder, Vec::new()));
        let fresh = files.beside.into_iter().filter(|file| beside.iter().all(|other| other.path != file.path));
        beside.extend(fresh.collect::<Vec<_>>());
    }
    Ok(done)
}

/// Down to which share of the screen's area each level is drawn: until the next one shows no error. Nothing where errors
/// were not measured.
fn coverage(levels: &[Level]) -> Vec<f64> {
    let area = |level: &Level| level.screen_coverage.map(|height| height * height * SCREEN);
    let next: Option<Vec<f64>> = levels.iter().skip(1).map(area).collect();
    next.map(|next| next.into_iter().chain([0.0]).collect()).unwrap_or_default()
}

/// What the file of a result will be called.
fn file_name(request: &Request, number: usize) -> String {
    let paths = outputs(request);
    paths.get(number).and_then(|path| path.file_name()).unwrap_or("mesh".as_ref()).to_string_lossy().into_owned()
}

/// Results as the bytes of their files.
fn files_of(
    subject: &Subject,
    meshes: &Meshes,
    request: &Request,
    number: usize,
) -> Result<crate::subject::Files, Failure> {
    let shown = request.output.clone().unwrap_or_else(|| PathBuf::from("standard output"));
    let file_name = file_name(request, number);
    subject.written(meshes, request, &file_name).map_err(|error| Failure::of(&shown, error))
}

/// The size of a result, and how far it is from the original; what it is as a surface where someone is told.
fn measured(subject: &Subject, result: &Simplified, packing: Option<&Packing>, request: &Request) -> Level {
    let distance = || subject.distance(result, packing, SAMPLES).as_ref().map(Distance::of);
    let mut output = Output::of(Size::of(&result.mesh, request.report.is_some()), &result.report);
    output.dropped = subject.dropped(&result.report);
    Level::new(output, report::outcome(&result.report.outcome), request.check.then(distance).flatten())
}

/// What else is told of a run.
struct Told {
    notes: Vec<String>,
    baked: Option<Baked>,
    seconds: Seconds,
    named: Vec<NamedShare>,
}

fn told(
    request: &Request,
    subject: &Subject,
    result: &Simplified,
    levels: Vec<Level>,
    Told { notes, baked, seconds, named }: Told,
) -> Result<Report, Failure> {
    let with_shape = request.report.is_some() || result.report.components_pruned > 0;
    let several = request.goal.n_levels().is_some();
    let is_by_name = request.prune_below.is_some() || request.options.hidden == Hidden::Drop;
    let is_of_rest = matches!(request.goal, Goal::Error(_) | Goal::ErrorLevels(_))
        && is_by_name
        && result.report.components_pruned > 0;
    let of_rest = is_of_rest.then(|| "what is certain is the distance of what --prune and --hidden left; the line distance counts what they dropped".into());
    let notes = notes.into_iter().chain(of_rest).collect();
    let Some(first) = levels.first().cloned() else { return Err(Failure::Failed("no result was made".into())) };
    let is_stopped = report::why_stopped(&first.outcome).is_some();
    let free = if is_stopped { what_frees(request, subject, &first.output) } else { Vec::new() };
    Ok(Report {
        free,
        input: Size::of(subject.mesh(), with_shape),
        output: first.output,
        target: report::target(&request.goal, request.options.target),
        outcome: first.outcome,
        scores: report::scores(result.report.scores),
        seed: request.options.seed,
        threads: rayon::current_num_threads(),
        seconds,
        cleaned: (&subject.counts).into(),
        repaired: subject.repaired.as_ref().map(Into::into),
        baked,
        named,
        distance: first.distance,
        certified: first.certified,
        mirror: result.report.mirror.map(|plane| subject.plane_of_file(plane).to_string()),
        levels: if several { levels } else { Vec::new() },
        notes,
    })
}

/// The map on its way to its file, where one is asked for.
fn mapped(request: &Request, subject: &Subject, result: &Simplified) -> Result<Option<Pending>, Failure> {
    let (Some(path), Some(map)) = (&request.map, &result.map) else { return Ok(None) };
    let file = MapFile::of(map, subject.file_vertices());
    let json = serde_json::to_vec(&file).map_err(|error| Failure::of(path, error))?;
    files::prepare(path, &json, request.force).map(Some)
}

fn say(request: &Request, report: &Report, cleaned: &str) {
    let voice = match request.output {
        _ if request.quiet => Voice::Quiet,
        Some(_) if !request.reports_to_stdout() => Voice::Out,
        _ => Voice::Err,
    };
    words::notes(report, cleaned).iter().for_each(|line| voice.say(line));
    if request.explain {
        words::explained(report).iter().for_each(|line| voice.say(line));
    }
    match &report.levels[..] {
        [] => {
            voice.say(&words::size(&report.input, &report.output.size));
            bytes(request).iter().for_each(|bytes| voice.say(&words::bytes(*bytes)));
            words::written(&report.output).iter().for_each(|line| voice.say(line));
            report.certified.iter().for_each(|distance| voice.say(&words::certified(distance)));
            report.distance.iter().for_each(|distance| voice.say(&words::distance(distance)));
        }
        levels => levels.iter().enumerate().for_each(|(i, level)| voice.say(&words::level(i, &report.input, level))),
    }
    voice.say(&words::time(&report.seconds));
}

/// Bytes of the input and of the result, where each is one file.
fn bytes(request: &Request) -> Option<[u64; 2]> {
    let (input, result) = (&request.source.path, request.output.as_deref()?);
    if [Format::from_path(input), Some(request.output_format)].contains(&Some(Format::Gltf)) {
        return None;
    }
    let of = |path: &Path| std::fs::metadata(path).ok().filter(|found| found.is_file()).map(|found| found.len());
    Some([of(input)?, of(result)?])
}
