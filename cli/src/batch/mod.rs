//! `neural-mesh simplify` on many meshes: a file and a manifest row for each.

mod extra_files;
mod inputs;
mod lock;
mod manifest;
mod outputs;
mod path_text;
mod schedule;
mod unfinished;

use std::collections::{BTreeSet, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use neural_mesh::io::Format;
use neural_mesh::job::{Arguments, Job, JobReport, RatioOf};
use neural_mesh::model::Weights;
use neural_mesh::simplify::Purpose;

use crate::args::SimplifyArgs;
use crate::bar::Bar;
use crate::failure::Failure;
use crate::messages::MessageStream;
use crate::names::{check_writable, is_stream, parse_format};
use crate::progress::Progress;
use crate::request::{self, Request, Source, is_strict, to_usage_failure};
use crate::{files, interrupt, memory, read, simplify};
use extra_files::ExtraFiles;
use inputs::Input;
use manifest::{BatchFolders, Manifest, ManifestRow, append_ending};

const REPORT_ENDING: &str = ".json";
const PICTURE_ENDING: &str = ".png";

/// Returns whether the arguments mean a batch: a list, several meshes, a folder or a pattern.
pub fn is_batch(args: &SimplifyArgs) -> bool {
    args.list.is_some() || args.inputs.len() > 1 || args.inputs.iter().any(|path| names_several_meshes(path))
}

pub fn names_several_meshes(path: &Path) -> bool {
    path.is_dir() || inputs::is_pattern(path)
}

pub fn run(args: SimplifyArgs) -> Result<(), Failure> {
    let (format, job) = check_arguments(&args)?;
    let inputs = inputs::find_meshes(&args)?;
    let folder = outputs::create_folder(&args.output)?;
    // The folder stays locked until the batch has counted its results.
    let _lock = lock::lock_folder(&folder)?;
    outputs::prepare_path(&folder, Path::new(manifest::MANIFEST_FILE))?;
    let names = outputs::choose_names(&inputs, format);
    let names =
        if args.options.lods.is_empty() { names } else { outputs::with_level_placeholders(&inputs, names, format) };
    let rows = ManifestRow::create_all(&inputs, &names, &spell_options(&args.options));
    let read = files::list_files_read(None, args.list.as_deref().into_iter().chain(args.options.weights.as_deref()));
    inputs.iter().for_each(|input| read.add(&input.path));
    let side_folders = open_side_folders(&args)?;
    let folders = BatchFolders { folder: folder.clone(), n_levels: args.options.lods.len(), side_folders, read };
    // Every mesh has a row from the start, so that a killed batch can be resumed.
    let mut manifest = Manifest::open(folders, rows, [args.resume, args.force])?;
    interrupt::handle_signals(Failure::Stopped("interrupted: continue with --resume".into()));
    let run_alone = unfinished::find_unfinished(&folder, &mut manifest, args.resume)?;
    let weights = read::read_weights(args.options.weights.as_deref(), &job.options.assembly)?;
    let extra_files = ExtraFiles::new(folder.clone(), &manifest.outputs(), args.force);
    let progress = Mutex::new(BatchProgress { bar: Bar::new(args.quiet), n_meshes: 0, cost: 0.0 });
    let input_folders = list_folders(&inputs);
    let batch =
        Batch { progress, input_folders, args, job, folder, format, inputs, manifest, extra_files, run_alone, weights };
    let began = Instant::now();
    let written = batch.simplify_all().and_then(|()| batch.manifest.save());
    written?;
    batch.report_end(began.elapsed().as_secs_f64())
}

fn list_folders(inputs: &[Input]) -> BTreeSet<PathBuf> {
    let folder = |input: &Input| files::resolve_folder(&input.path).parent().map(Path::to_path_buf);
    inputs.iter().filter_map(folder).collect()
}

fn open_side_folders(args: &SimplifyArgs) -> Result<Vec<(PathBuf, &'static str)>, Failure> {
    let folders = [(&args.report, REPORT_ENDING), (&args.picture, PICTURE_ENDING)].into_iter();
    let open = |(folder, ending): (&Option<PathBuf>, _)| Some((folder.as_deref()?.to_path_buf(), ending));
    folders.filter_map(open).map(|(folder, ending)| Ok((outputs::create_folder(&folder)?, ending))).collect()
}

/// Rejects options that a batch cannot use; returns the common format, if any, and the job.
fn check_arguments(args: &SimplifyArgs) -> Result<(Option<Format>, Job), Failure> {
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
    let job = request::create_job(&args.options, None)?;
    Ok((args.options.format.as_deref().map(|name| check_writable(parse_format(name)?)).transpose()?, job))
}

/// Spells out the options for the manifest; a resumed batch must have the same.
fn spell_options(args: &Arguments) -> String {
    let mut words = [
        spell_target(args),
        format!("--assembly {:?} --optimize {:?} --effort {:?}", args.assembly, args.optimize, args.effort),
        format!("--hidden {:?} --seed {}", args.hidden, args.seed),
    ]
    .join(" ");
    words.make_ascii_lowercase();
    let named = [
        args.scores.map(|scores| format!(" --scores {scores:?}").to_ascii_lowercase()),
        args.weights.as_ref().map(|path| format!(" --weights {}", path.display())),
        args.format.as_ref().map(|format| format!(" --format {format}")),
        args.prune.map(|size| spell_option("--prune", size)),
        args.hold_shape.map(|most| spell_option("--hold-shape", most)),
        args.keep_components.then(|| " --keep-components".into()),
        args.fill_holes.map(|most| spell_option("--fill-holes", most)),
        args.printable.map(|size| spell_option("--printable", size)),
        args.bake.map(|size| format!(" --bake {size}")),
        args.compress.map(|how| format!(" --compress={how:?}").to_ascii_lowercase()),
        args.textures.map(|side| format!(" --textures {side}")),
        args.weld.map(|distance| format!(" --weld {distance}")),
        args.no_weld.then(|| " --no-weld".into()),
        args.no_check.then(|| " --no-check".into()),
        args.lock_boundaries.then(|| " --lock-boundaries".into()),
        args.subset.then(|| " --subset".into()),
        args.close.then(|| " --close".into()),
        args.place.then(|| " --place".into()),
        args.keep_features.then(|| " --keep-features".into()),
        args.crease_angle.map(|degrees| format!(" --crease-angle {degrees}")),
        (args.purpose != Purpose::Shape).then(|| format!(" --for {:?}", args.purpose).to_ascii_lowercase()),
        args.seam_error.map(|texels| format!(" --seam-error {texels}")),
        (!args.ignore.is_empty()).then(|| format!(" --ignore {:?}", args.ignore).to_ascii_lowercase()),
        args.symmetric.map(|plane| spell_option("--symmetric", plane)),
        args.importance.as_ref().map(|name| format!(" --importance {name}")),
        (!args.keep.is_empty()).then(|| format!(" --keep {:?}", args.keep)),
        args.allow_outside.then(|| " --allow-outside".into()),
    ];
    words.extend(named.into_iter().flatten());
    words
}

fn spell_target(args: &Arguments) -> String {
    let sizes = [
        (!args.ratio.is_empty()).then(|| {
            let prefix = |of: &RatioOf| of.name.as_ref().map_or_else(String::new, |name| format!("{name}="));
            let words = args.ratio.iter().map(|of| format!("--ratio {}{}", prefix(of), of.share));
            words.collect::<Vec<_>>().join(" ")
        }),
        args.vertices.map(|n| format!("--vertices {n}")),
        args.faces.map(|n| format!("--faces {n}")),
        args.error.map(|error| format!("--error {error}")),
        args.size.map(|size| format!("--size {size}")),
        (!args.lods.is_empty()).then(|| format!("--lods {}", args.lods.join(","))),
        args.lods_by.map(|by| format!("--lods-by {by:?}")),
    ];
    sizes.into_iter().flatten().collect::<Vec<_>>().join(" ")
}

fn spell_option(option: &str, value: Option<impl std::fmt::Display>) -> String {
    value.map_or(format!(" {option}"), |value| format!(" {option}={value}"))
}

struct BatchProgress {
    bar: Bar,
    n_meshes: usize,
    cost: f64,
}

impl BatchProgress {
    fn count_mesh(&mut self, share: f64, n_all: usize) {
        (self.n_meshes, self.cost) = (self.n_meshes + 1, self.cost + share);
        self.bar.show(format!("{} of {n_all} meshes", self.n_meshes), self.cost);
    }
}

struct Batch {
    args: SimplifyArgs,
    job: Job,
    folder: PathBuf,
    format: Option<Format>,
    inputs: Vec<Input>,
    /// Folders of the meshes, without links.
    input_folders: BTreeSet<PathBuf>,
    manifest: Manifest,
    extra_files: ExtraFiles,
    /// Indices of meshes that run alone, since an earlier run ran out of memory with them.
    run_alone: Vec<usize>,
    weights: Option<Weights>,
    progress: Mutex<BatchProgress>,
}

impl Batch {
    fn simplify_all(&self) -> Result<(), Failure> {
        let pending = self.manifest.pending_meshes();
        let bound = self.args.memory.map_or_else(memory::default_limit, memory::gib_to_bytes);
        let sizes: HashMap<usize, u64> = pending
            .iter()
            .map(|&i| (i, memory::estimate_bytes(&self.inputs[i].path, self.args.options.bake)))
            .collect();
        let all: f64 = sizes.values().map(|&size| size as f64).sum();
        // An infinite cost makes the schedule run a mesh alone.
        let cost = |i: usize| if self.run_alone.contains(&i) { u64::MAX } else { sizes[&i] };
        let costs = pending.iter().map(|&i| (i, cost(i))).collect();
        let share = |i: usize| sizes[&i] as f64 / all;
        schedule::run_jobs(costs, bound, self.args.threads, &|i| self.simplify_into_row(i, share(i), pending.len()))
    }

    fn simplify_into_row(&self, i: usize, share: f64, n_meshes: usize) -> Result<(), Failure> {
        let began = Instant::now();
        // A panic in one mesh must not end the batch.
        let result = crate::out_of_memory::track_mesh(i, || catch_unwind(AssertUnwindSafe(|| self.simplify_one(i))));
        let result = result.unwrap_or_else(|_| Err(Failure::Failed("internal error: please report it".into())));
        if let Err(failure) = &result {
            let line = format!("failed    {}: {failure}", self.manifest.name(i));
            self.lock_progress()
                .bar
                .suspend(|| if self.args.quiet { MessageStream::Quiet } else { MessageStream::Err }.print_line(&line));
        }
        self.lock_progress().count_mesh(share, n_meshes);
        self.manifest.set_result(i, result, began.elapsed().as_secs_f64())
    }

    fn lock_progress(&self) -> MutexGuard<'_, BatchProgress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn simplify_one(&self, i: usize) -> Result<JobReport, Failure> {
        let below = self.manifest.output(i);
        let output = outputs::prepare_path(&self.folder, &below)?;
        let mut request = self.request(&self.inputs[i], output, self.manifest.may_replace(i))?;
        // An existing file may be the result of an earlier run, so only other obstacles count here.
        simplify::check_outputs(&request, true)?;
        let run = simplify::simplify_file(&mut request, self.weights.as_ref(), &mut Progress::silent())?;
        let read = run.read.clone();
        let (report, _) = run
            .place_results_with(&|_, files| self.extra_files.write(&below, files, &read), files::place_missing_files)?;
        Ok(report)
    }

    fn request(&self, input: &Input, output: PathBuf, force: bool) -> Result<Request, Failure> {
        let format = self.format.unwrap_or_else(|| outputs::default_format(input));
        let mut job = self.job.clone();
        job.format = format;
        job.check_format().map_err(|error| to_usage_failure(&error))?;
        let mut request = Request {
            source: Source::new(input.path.clone(), None, !self.args.options.no_weld)
                .with_joined_scene(self.args.options.bake.is_some()),
            job,
            takes_input_format: false,
            stays_in_memory: false,
            output: Some(output),
            memory: None,
            map: None,
            explain: false,
            weights: None,
            n_threads: None,
            report: self.side_file(input, REPORT_ENDING)?,
            picture: self.side_file(input, PICTURE_ENDING)?,
            view: self.args.view,
            wires: self.args.wires,
            quiet: true,
            strict: false,
            force,
            read: self.manifest.folders().read.with_mesh_path(&input.path),
        };
        request.job.names.keeps_all = self.holds_inputs(request.output.as_deref().and_then(Path::parent));
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
        let folders = &self.manifest.folders().side_folders;
        let path = folders
            .iter()
            .find(|(_, its)| *its == ending)
            .map(|(folder, _)| outputs::prepare_path(folder, &append_ending(&input.relative_path, ending)));
        path.transpose()
    }

    fn report_end(&self, seconds: f64) -> Result<(), Failure> {
        let counts = self.manifest.count_outcomes();
        let voice = if self.args.quiet { MessageStream::Quiet } else { MessageStream::Out };
        voice.print_line(&format!(
            "meshes    {}: {} reached the target, {} stopped before it, {} failed",
            self.inputs.len(),
            counts.reached,
            counts.stopped,
            counts.failed
        ));
        voice.print_line(&format!("time      {seconds:.3} s"));
        match (counts.failed, counts.stopped) {
            (0, n) if n > 0 && is_strict(&self.args) => {
                let what = "meshes missed the target: manifest.csv gives the reasons";
                Err(Failure::Unmet(format!("{}: {n} {what}", self.manifest.path().display())))
            }
            (0, _) => Ok(()),
            (1, _) => Err(Failure::in_file(self.manifest.path(), "1 mesh failed: manifest.csv gives the reason")),
            (n, _) => Err(Failure::in_file(
                self.manifest.path(),
                format!("{n} meshes failed: manifest.csv gives the reasons"),
            )),
        }
    }
}
