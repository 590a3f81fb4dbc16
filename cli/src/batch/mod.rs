//! `neural-mesh simplify` on many meshes: a file and a manifest row for each.

mod extra_files;
mod inputs;
mod manifest;
mod outputs;
mod schedule;

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use neural_mesh::job::{Arguments, JobReport};
use neural_mesh::model::Weights;
use serde_json::Value;

use crate::args::SimplifyArgs;
use crate::bar::Bar;
use crate::failure::Failure;
use crate::messages::MessageStream;
use crate::names::{MeshPaths, check_writable, is_stream, parse_format};
use crate::progress::Progress;
use crate::request::{self, Request, Source, is_strict};
use crate::{files, interrupt, memory, out_of_memory, read, simplify};
use extra_files::ExtraFiles;
use inputs::Input;
use manifest::{BatchFolders, Manifest};

const REPORT_ENDING: &str = ".json";
const PICTURE_ENDING: &str = ".png";
/// File in OUTDIR with the names of meshes in progress when memory ran out.
const OUT_OF_MEMORY_FILE: &str = ".neural-mesh-out-of-memory";

/// Returns whether the arguments mean a batch: a list, several meshes, a folder or a pattern.
pub fn is_batch(args: &SimplifyArgs) -> bool {
    args.list.is_some() || args.inputs.len() > 1 || args.inputs.iter().any(|path| names_several_meshes(path))
}

pub fn names_several_meshes(path: &Path) -> bool {
    path.is_dir() || inputs::is_pattern(path)
}

pub fn run(args: SimplifyArgs) -> Result<(), Failure> {
    check_arguments(&args)?;
    let job = request::create_job(&args.options, None)?;
    let format = args.options.format.as_deref().map(|name| check_writable(parse_format(name)?)).transpose()?;
    let inputs = inputs::find_meshes(&args)?;
    let folder = outputs::create_folder(&args.output)?;
    // The folder stays locked until the batch has counted its results.
    let _lock = outputs::lock_folder(&folder)?;
    outputs::prepare_path(&folder, Path::new(manifest::MANIFEST_FILE))?;
    let outputs = outputs::choose_names(&inputs, format, &args.options, files::ignores_case(&folder))?;
    let read = files::list_files_read(None, args.list.as_deref().into_iter().chain(args.options.weights.as_deref()));
    inputs.iter().for_each(|input| read.add(&input.path));
    let folders =
        BatchFolders { folder, n_levels: args.options.lods.len(), side_folders: open_side_folders(&args)?, read };
    let extra_files = ExtraFiles::new(&folders, &outputs, args.force);
    // Every mesh has a row from the start, so that a killed batch can be resumed.
    let options = spell_options(&args.options)?;
    let manifest = Manifest::open(folders, &inputs, &outputs, &options, [args.resume, args.force])?;
    interrupt::handle_signals(Failure::Stopped("interrupted: continue with --resume".into()));
    let weights = read::read_weights(args.options.weights.as_deref(), &job.options.assembly)?;
    let progress = Mutex::new((Bar::new(args.quiet), 0));
    let input_folders = list_folders(&inputs);
    let batch = Batch { progress, input_folders, args, inputs, outputs, manifest, extra_files, weights };
    let began = Instant::now();
    batch.simplify_all()?;
    batch.report_end(began.elapsed().as_secs_f64())
}

fn list_folders(inputs: &[Input]) -> BTreeSet<PathBuf> {
    let folder = |input: &Input| files::resolve_folder(&input.path).parent().map(Path::to_path_buf);
    inputs.iter().filter_map(folder).collect()
}

fn open_side_folders(args: &SimplifyArgs) -> Result<Vec<(PathBuf, &'static str)>, Failure> {
    let folders = [(&args.report, REPORT_ENDING), (&args.picture, PICTURE_ENDING)].into_iter();
    let given = folders.filter_map(|(folder, ending)| Some((folder.as_deref()?, ending)));
    given.map(|(folder, ending)| Ok((outputs::create_folder(folder)?, ending))).collect()
}

/// Rejects options that a batch cannot use.
fn check_arguments(args: &SimplifyArgs) -> Result<(), Failure> {
    let usage = |what: &str| Err(Failure::Usage(what.into()));
    if args.json || args.map.is_some() || args.explain {
        return usage(
            "--json, --map and --explain are for a single mesh: leave them out, and see manifest.csv of the batch",
        );
    }
    if [&args.report, &args.picture].into_iter().flatten().any(|folder| is_stream(folder)) {
        return usage("a batch writes a report and a picture for each mesh: give a folder to --report and --picture");
    }
    if is_stream(&args.output) || args.inputs.iter().any(|path| is_stream(path)) {
        return usage(
            "a batch reads files and writes to a folder: give -o OUTDIR, and --list - for names on standard input",
        );
    }
    inputs::check_arguments(args)?;
    memory::limit_memory(args.memory);
    Ok(())
}

/// Spells out the options that are not the default for the manifest; a resumed batch must have the same.
fn spell_options(args: &Arguments) -> Result<String, Failure> {
    let to_json = |args| serde_json::to_value(args).map_err(|error| Failure::Failed(format!("options: {error}")));
    let (given, usual) = (to_json(args)?, to_json(&Arguments::default())?);
    let changed = given.as_object().into_iter().flatten().filter(|(name, value)| usual[*name] != **value);
    let mut words: Vec<String> =
        changed.flat_map(|(name, value)| spell_option(&name.replace('_', "-"), value)).collect();
    words.extend(args.weights.as_ref().map(|path| format!("--weights {}", path.display())));
    Ok(words.join(" "))
}

/// Spells an option, once for each of its values.
fn spell_option(name: &str, value: &Value) -> Vec<String> {
    match value {
        Value::Array(values) => values.iter().flat_map(|value| spell_option(name, value)).collect(),
        Value::Bool(_) => vec![format!("--{name}")],
        Value::String(text) => vec![format!("--{name} {text}")],
        other => vec![format!("--{name} {other}")],
    }
}

struct Batch {
    args: SimplifyArgs,
    inputs: Vec<Input>,
    /// Paths of the results in OUTDIR, with `{level}` for levels of detail.
    outputs: Vec<PathBuf>,
    /// Folders of the meshes, without links.
    input_folders: BTreeSet<PathBuf>,
    manifest: Manifest,
    extra_files: ExtraFiles,
    weights: Option<Arc<Weights>>,
    /// Bar and number of finished meshes.
    progress: Mutex<(Bar, usize)>,
}

impl Batch {
    fn simplify_all(&self) -> Result<(), Failure> {
        let bound = self.args.memory.map_or_else(memory::default_limit, memory::gib_to_bytes);
        let cost = |i: usize| (i, memory::estimate_bytes(&self.inputs[i].path, self.args.options.bake));
        let exhausting = self.start_memory_record()?;
        let (last, first): (Vec<usize>, Vec<usize>) =
            self.manifest.pending.iter().partition(|&&i| exhausting.contains(&self.inputs[i].name));
        schedule::run_jobs(first.into_iter().map(cost).collect(), bound, self.args.threads, &|i| {
            self.simplify_into_row(i)
        })?;
        // Meshes with which memory ran out come last and alone; where it runs out again, the row of that mesh is there.
        for i in last {
            let what = "ran out of memory: raise --memory, and continue with --resume";
            self.manifest.set_result(i, Err(Failure::Failed(what.into())), 0.0)?;
            self.manifest.save()?;
            simplify::in_pool(self.args.threads, || self.simplify_into_row(i))?;
        }
        let _ = std::fs::remove_file(self.manifest.folders.folder.join(OUT_OF_MEMORY_FILE));
        self.manifest.save()
    }

    /// Returns the names of meshes in progress when memory ran out in earlier runs, and records those of this run.
    fn start_memory_record(&self) -> Result<Vec<String>, Failure> {
        let path = self.manifest.folders.folder.join(OUT_OF_MEMORY_FILE);
        let known = if self.args.resume && path.is_file() { files::read(&path)? } else { Vec::new() };
        if !self.args.resume {
            // The file is missing, or belongs to a batch that this one replaces.
            let _ = std::fs::remove_file(&path);
        }
        out_of_memory::register_batch(path, self.inputs.iter().map(|input| input.name.clone()).collect());
        Ok(String::from_utf8_lossy(&known).lines().map(String::from).collect())
    }

    fn simplify_into_row(&self, i: usize) -> Result<(), Failure> {
        let began = Instant::now();
        // A panic in one mesh must not end the batch.
        let result = out_of_memory::track_mesh(i, || catch_unwind(AssertUnwindSafe(|| self.simplify_one(i))));
        let result = result.unwrap_or_else(|_| Err(Failure::Failed("internal error: please report it".into())));
        let mut progress = self.lock_progress();
        if let Err(failure) = &result {
            let line = format!("failed    {}: {failure}", self.inputs[i].name);
            let stream = if self.args.quiet { MessageStream::Quiet } else { MessageStream::Err };
            progress.0.suspend(|| stream.print_line(&line));
        }
        progress.1 += 1;
        let (n_done, n_all) = (progress.1, self.manifest.pending.len());
        progress.0.show(format!("{n_done} of {n_all} meshes"), n_done as f64 / n_all as f64);
        drop(progress);
        self.manifest.set_result(i, result, began.elapsed().as_secs_f64())
    }

    fn lock_progress(&self) -> MutexGuard<'_, (Bar, usize)> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn simplify_one(&self, i: usize) -> Result<JobReport, Failure> {
        let output = outputs::prepare_path(&self.manifest.folders.folder, &self.outputs[i])?;
        let mut request = self.request(&self.inputs[i], output, self.manifest.may_replace[i])?;
        // An existing file may be the result of an earlier run, so only other obstacles count here.
        simplify::check_outputs(&request, true)?;
        request.job.weights.clone_from(&self.weights);
        let run = simplify::simplify_file(&mut request, &mut Progress::silent())?;
        let read = run.read.clone();
        let write = |_: &Path, files: &[_]| self.extra_files.write(&self.outputs[i], files, &read);
        Ok(run.place_results_with(&write, files::place_missing_files)?.0)
    }

    fn request(&self, input: &Input, output: PathBuf, force: bool) -> Result<Request, Failure> {
        let args = &self.args;
        let paths = MeshPaths { input: &input.path, output: &output, format: args.options.format.as_deref() };
        let mut request = Request {
            // In a batch, --format is always that of the results.
            source: Source::new(input.path.clone(), None, !args.options.no_weld)
                .with_joined_scene(args.options.joins_scenes()),
            strict: false,
            report: self.side_file(input, REPORT_ENDING)?,
            picture: self.side_file(input, PICTURE_ENDING)?,
            view: args.view,
            wires: args.wires,
            force,
            read: self.manifest.folders.read.with_mesh_path(&input.path),
            ..Request::new(&paths, &args.options)?
        };
        request.job.names.keeps_all = self.holds_inputs(output.parent());
        request.output = Some(output);
        request.job.shapes = request.report.is_some();
        request.name_files();
        Ok(request)
    }

    /// Returns whether a mesh of the batch is in the folder or below, so that its companion files may be there, too.
    fn holds_inputs(&self, folder: Option<&Path>) -> bool {
        let Some(folder) = folder.and_then(|folder| folder.canonicalize().ok()) else { return false };
        // Folders below come right after a folder in this order.
        self.input_folders.range(folder.clone()..).next().is_some_and(|input| input.starts_with(&folder))
    }

    fn side_file(&self, input: &Input, ending: &str) -> Result<Option<PathBuf>, Failure> {
        let folder = self.manifest.folders.side_folders.iter().find(|(_, its)| *its == ending);
        let path =
            |(folder, _): &(PathBuf, _)| outputs::prepare_path(folder, format!("{}{ending}", input.name).as_ref());
        folder.map(path).transpose()
    }

    fn report_end(&self, seconds: f64) -> Result<(), Failure> {
        let [reached, stopped, failed] = self.manifest.count_outcomes();
        let voice = if self.args.quiet { MessageStream::Quiet } else { MessageStream::Out };
        voice.print_line(&format!(
            "meshes    {}: {reached} reached the target, {stopped} stopped before it, {failed} failed",
            self.inputs.len()
        ));
        voice.print_line(&format!("time      {seconds:.3} s"));
        let path = &self.manifest.path;
        match (failed, stopped) {
            (0, n) if n > 0 && is_strict(&self.args) => {
                let what = "meshes missed the target: manifest.csv gives the reasons";
                Err(Failure::Unmet(format!("{}: {n} {what}", path.display())))
            }
            (0, _) => Ok(()),
            (1, _) => Err(Failure::in_file(path, "1 mesh failed: manifest.csv gives the reason")),
            (n, _) => Err(Failure::in_file(path, format!("{n} meshes failed: manifest.csv gives the reasons"))),
        }
    }
}
