//! `neural-mesh progression`: one collapse whose levels `simplify` reads, and a page that shows them.

use std::path::Path;

use neural_mesh::io::{FilesRead, Format};
use neural_mesh::job::{Arguments, Document, Job, JobStage, RatioOf, Watch, make_progression};
use neural_mesh::simplify::{Options, Progression, Size};

use crate::args::ProgressionArgs;
use crate::document;
use crate::failure::Failure;
use crate::files::{self, OutputPaths};
use crate::interrupt;
use crate::messages::{MessageStream, group_digits};
use crate::names::{is_progression_name, is_stream};
use crate::page::embed_file;
use crate::page::empty_pages::empty_page;
use crate::plan::Plan;
use crate::progress::Progress;
use crate::request::Request;
use crate::simplify::in_pool;

/// Folders below the mesh's in which files that it names are looked for.
const MOST_FOLDERS_DEEP: usize = 2;
/// Largest number of entries of a folder that are looked at.
const MOST_FILES: usize = 4096;

pub fn run(args: &ProgressionArgs) -> Result<(), Failure> {
    if is_stream(&args.input) || is_stream(&args.output) {
        return Err(Failure::Usage("progression: give the names of files, not -".into()));
    }
    if !is_progression_name(&args.output) {
        let what = format!("{}: end the name in .nmp, so that simplify reads it", args.output.display());
        return Err(Failure::Usage(what));
    }
    if args.html.as_deref().is_some_and(is_stream) {
        return Err(Failure::Usage("--html needs the name of a file".into()));
    }
    // A progression is no mesh, so it never replaces its input.
    let read = files::list_files_read(None, [args.input.as_path()]);
    let outputs = [Some(&args.output), args.html.as_ref()].into_iter().flatten();
    files::check_output_paths(&OutputPaths::new([], outputs), &read, args.force)?;
    interrupt::handle_signals(Failure::Interrupted);
    in_pool(args.threads, || write_progression(args, &read))
}

fn write_progression(args: &ProgressionArgs, read: &FilesRead) -> Result<(), Failure> {
    let mut request = create_request(args)?;
    let mut progress = Progress::new(args.quiet, Plan::estimate(&request, None));
    progress.begin(JobStage::Read);
    let document = document::open(&mut request)?;
    let to_failure = |error| request.failure(error);
    let made = make_progression(&document, &request.job, args.prove, &mut progress);
    let mut progression = made.map_err(to_failure)?;
    progress.begin(JobStage::Write);
    progression.files = read_files(&args.input, read)?;
    read.join(&document.files_read());
    let bytes = progression.to_bytes();
    check_reopens(&bytes, &request)?;
    let mut pending = vec![files::prepare_file(&args.output, &bytes, args.force)?];
    if let Some(path) = &args.html {
        let page = embed_file(empty_page("progression.html"), &progression.files[0].0, &bytes);
        pending.push(files::prepare_file(path, page.as_bytes(), args.force)?);
    }
    let seconds = progress.seconds();
    drop(progress);
    files::place_files(pending, read)?;
    let voice = if args.quiet { MessageStream::Quiet } else { MessageStream::Out };
    let n_faces = group_digits(progression.n_faces());
    voice.print_line(&format!("{n_faces} faces, all levels; {} bytes", group_digits(bytes.len())));
    if args.prove && progression.proved_levels().is_empty() {
        voice.print_line("no distance could be proved: --error will not work with it, but sizes will");
    }
    if let (Some(first), Some(last)) = (progression.proved_levels().first(), progression.proved_levels().last()) {
        let distances = format!("{:.3e} to {:.3e}", first.distance, last.distance);
        voice.print_line(&format!("proved distances of {} levels: {distances}", progression.proved_levels().len()));
    }
    voice.print_line(&crate::messages::time_line(&seconds));
    Ok(())
}

/// Opens the document again from the written bytes, so that a file that cannot be used is not written.
fn check_reopens(bytes: &[u8], request: &Request) -> Result<(), Failure> {
    let mut job = Job::new(Options::new(Size::Ratio(1.0)), request.job.format);
    job.arguments.no_weld = request.job.arguments.no_weld;
    let reopened = Progression::from_bytes(bytes).map_err(|error| Failure::in_file(&request.source.path, error))?;
    Document::from_progression(reopened, &job).map(drop).map_err(|error| request.failure(error))
}

/// Reads the mesh file and the files of its folder that it names, and adds them to `read`.
pub fn read_files(path: &Path, read: &FilesRead) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let name = path.file_name().unwrap_or("mesh".as_ref()).to_string_lossy().into_owned();
    let bytes = files::read(path)?;
    let mut files = vec![(name, bytes)];
    // Formats in one piece name no other files.
    if !matches!(Format::from_path(path), Some(Format::Obj | Format::Gltf)) {
        return Ok(files);
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut others = list_files(folder, "", MOST_FOLDERS_DEEP);
    others.sort();
    // A file counts as named where its name occurs; a material library may name textures in turn.
    let mut next = 0;
    while next < files.len() {
        let text = String::from_utf8_lossy(&files[next].1).into_owned();
        let is_named = |name: &String| text.contains(name.as_str()) || text.contains(&name.replace(' ', "%20"));
        let (named, rest): (Vec<String>, Vec<String>) = others.into_iter().partition(is_named);
        for name in named {
            let path = folder.join(&name);
            read.add(&path);
            let bytes = files::read(&path)?;
            files.push((name, bytes));
        }
        (others, next) = (rest, next + 1);
    }
    Ok(files)
}

/// Lists the files of a folder and of those in it, by relative name.
fn list_files(folder: &Path, before: &str, deep: usize) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(if folder.as_os_str().is_empty() { Path::new(".") } else { folder }) else {
        return Vec::new();
    };
    let mut names = Vec::new();
    for entry in entries.flatten().take(MOST_FILES) {
        let name = format!("{before}{}", entry.file_name().to_string_lossy());
        match entry.file_type() {
            Ok(kind) if kind.is_file() => names.push(name),
            Ok(kind) if kind.is_dir() && deep > 0 => {
                names.extend(list_files(&entry.path(), &format!("{name}/"), deep - 1));
            }
            _ => {}
        }
    }
    names
}

fn create_request(args: &ProgressionArgs) -> Result<Request, Failure> {
    let arguments = Arguments {
        ratio: vec![RatioOf { name: None, share: 1.0 }],
        no_weld: args.no_weld,
        lock_boundaries: args.lock_boundaries,
        subset: args.subset,
        keep_features: args.keep_features,
        keep_components: args.keep_components,
        optimize: args.optimize,
        effort: args.effort,
        scores: args.scores,
        keep: args.keep.clone(),
        ..Arguments::default()
    };
    let mut request = Request::without_output(&args.input, None, &arguments)?;
    request.stays_in_memory = true;
    Ok(request)
}
