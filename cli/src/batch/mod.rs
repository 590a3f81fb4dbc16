//! `neural-mesh simplify` on many meshes: a file and a manifest row for each.

mod inputs;
mod lock;
mod manifest;
mod outputs;
mod path_text;
mod places;
mod schedule;
mod unfinished;

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use neural_mesh::io::Format;
use neural_mesh::model::Weights;

use crate::args::{PurposeArg, SimplifyArgs};
use crate::bar::Bar;
use crate::failure::Failure;
use crate::names::{format_of, is_stream, level_paths, writable};
use crate::progress::Progress;
use crate::request::{self, Request, Source, strict};
use crate::words::Voice;
use crate::{files, interrupt, memory, read, simplify};
use inputs::Input;
use manifest::{BatchFolders, Manifest, ManifestRow, with_more};
use neural_mesh::job::{Job, JobReport, RatioOf};
use places::Places;

const REPORT: &str = ".json";
const PICTURE: &str = ".png";

/// Returns whether the arguments mean a batch: a list, several meshes, a folder or a pattern.
pub fn is_meant(args: &SimplifyArgs) -> bool {
    args.list.is_some() || args.inputs.len() > 1 || args.inputs.iter().any(|path| are_many(path))
}

pub fn are_many(path: &Path) -> bool {
    path.is_dir() || inputs::is_pattern(path)
}

pub fn run(args: SimplifyArgs) -> Result<(), Failure> {
    let (format, job) = check_arguments(&args)?;
    let inputs = inputs::find(&args)?;
    let folder = outputs::open(&args.output)?;
    // The folder stays locked until the batch ends.
    let _lock = lock::lock(&folder)?;
    outputs::prepare_path(&folder, Path::new(manifest::NAME))?;
    let names = outputs::names(&inputs, format);
    let names = if args.lods.is_empty() { names } else { outputs::with_level_placeholders(&inputs, names, format) };
    let rows = ManifestRow::all(&inputs, &names, &request_words(&args));
    let place =
        BatchFolders { folder: folder.clone(), n_levels: args.lods.len(), side_folders: open_side_folders(&args)? };
    // Every mesh has a row from the start, so that a killed batch can be resumed.
    let mut manifest = Manifest::open(place, rows, [args.resume, args.force])?;
    interrupt::watch(Failure::Stopped("interrupted: continue with --resume".into()));
    let alone = unfinished::find_unfinished(&folder, &mut manifest, args.resume)?;
    let weights = read::read_weights(args.weights.as_deref(), job.options.assembly)?;
    let places = Places::new(folder.clone(), &manifest.outputs(), args.force);
    let progress = Mutex::new(BatchProgress { bar: Bar::new(args.quiet), n_meshes: 0, cost: 0.0 });
    let batch = Batch { progress, args, job, folder, format, inputs, manifest, places, alone, weights };
    let began = Instant::now();
    let written = batch.simplify_all().and_then(|()| batch.manifest.save());
    written?;
    batch.report_end(began.elapsed().as_secs_f64())
}

fn open_side_folders(args: &SimplifyArgs) -> Result<Vec<(PathBuf, &'static str)>, Failure> {
    let folders = [(&args.report, REPORT), (&args.picture, PICTURE)].into_iter();
    let open = |(folder, ending): (&Option<PathBuf>, _)| Some((folder.as_deref()?.to_path_buf(), ending));
    folders.filter_map(open).map(|(folder, ending)| Ok((outputs::open(&folder)?, ending))).collect()
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
    inputs::check(args)?;
    memory::bound(args.memory);
    let job = request::job(&request::arguments(args)?, None)?;
    Ok((args.format.as_deref().map(|name| writable(format_of(name)?)).transpose()?, job))
}

/// Spells out the options for the manifest; a resumed batch must have the same.
fn request_words(args: &SimplifyArgs) -> String {
    let mut words = [
        size_words(args),
        format!("--assembly {:?} --optimize {:?} --effort {:?}", args.assembly, args.optimize, args.effort),
        format!("--hidden {:?} --seed {}", args.hidden, args.seed),
    ]
    .join(" ");
    words.make_ascii_lowercase();
    let named = [
        args.scores.map(|scores| format!(" --scores {scores:?}").to_ascii_lowercase()),
        args.weights.as_ref().map(|path| format!(" --weights {}", path.display())),
        args.format.as_ref().map(|format| format!(" --format {format}")),
        args.prune.as_ref().map(|size| option_words("--prune", size.as_ref())),
        args.keep_components.then(|| " --keep-components".into()),
        args.fill_holes.map(|most| option_words("--fill-holes", most)),
        args.printable.as_ref().map(|size| option_words("--printable", size.as_ref())),
        args.bake.map(|size| format!(" --bake {size}")),
        args.compress.map(|how| format!(" --compress={how:?}").to_ascii_lowercase()),
        args.textures.map(|side| format!(" --textures {side}")),
        args.weld.as_ref().map(|distance| format!(" --weld {distance}")),
        args.no_weld.then(|| " --no-weld".into()),
        args.no_check.then(|| " --no-check".into()),
        args.lock_boundaries.then(|| " --lock-boundaries".into()),
        args.subset.then(|| " --subset".into()),
        args.close.then(|| " --close".into()),
        args.place.then(|| " --place".into()),
        args.keep_features.then(|| " --keep-features".into()),
        args.crease_angle.map(|degrees| format!(" --crease-angle {degrees}")),
        (args.purpose != PurposeArg::Shape).then(|| format!(" --for {:?}", args.purpose).to_ascii_lowercase()),
        args.seam_error.map(|texels| format!(" --seam-error {texels}")),
        (!args.ignore.is_empty()).then(|| format!(" --ignore {:?}", args.ignore).to_ascii_lowercase()),
        args.symmetric.as_ref().map(|plane| option_words("--symmetric", plane.as_ref())),
        args.importance.as_ref().map(|name| format!(" --importance {name}")),
        (!args.keep.is_empty()).then(|| format!(" --keep {:?}", args.keep)),
        args.allow_outside.then(|| " --allow-outside".into()),
    ];
    words.extend(named.into_iter().flatten());
    words
}

fn size_words(args: &SimplifyArgs) -> String {
    let sizes = [
        (!args.ratio.is_empty()).then(|| {
            let named = |of: &RatioOf| of.name.as_ref().map_or_else(String::new, |name| format!("{name}="));
            let words = args.ratio.iter().map(|of| format!("--ratio {}{}", named(of), of.share));
            words.collect::<Vec<_>>().join(" ")
        }),
        args.vertices.map(|n| format!("--vertices {n}")),
        args.faces.map(|n| format!("--faces {n}")),
        args.error.as_ref().map(|error| format!("--error {error}")),
        args.size.as_ref().map(|size| format!("--size {size}")),
        (!args.lods.is_empty()).then(|| format!("--lods {}", args.lods.join(","))),
        args.lods_by.map(|by| format!("--lods-by {by:?}")),
    ];
    sizes.into_iter().flatten().collect::<Vec<_>>().join(" ")
}

fn option_words(option: &str, value: Option<impl std::fmt::Display>) -> String {
    value.map_or(format!(" {option}"), |value| format!(" {option}={value}"))
}

struct BatchProgress {
    bar: Bar,
    n_meshes: usize,
    cost: f64,
}

impl BatchProgress {
    fn one_more(&mut self, share: f64, n_all: usize) {
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
    manifest: Manifest,
    places: Places,
    /// Meshes to run alone, since an earlier run ran out of memory.
    alone: Vec<usize>,
    weights: Option<Weights>,
    progress: Mutex<BatchProgress>,
}

impl Batch {
    fn simplify_all(&self) -> Result<(), Failure> {
        let waiting = self.manifest.waiting();
        let bound = self.args.memory.map_or_else(memory::default_bound, memory::bytes_of);
        let sizes: HashMap<usize, u64> =
            waiting.iter().map(|&i| (i, memory::estimate(&self.inputs[i].path, self.args.bake))).collect();
        let all: f64 = sizes.values().map(|&size| size as f64).sum();
        // An infinite cost makes the schedule run a mesh alone.
        let cost = |i: usize| if self.alone.contains(&i) { u64::MAX } else { sizes[&i] };
        let costs = waiting.iter().map(|&i| (i, cost(i))).collect();
        let share = |i: usize| sizes[&i] as f64 / all;
        schedule::run(costs, bound, self.args.threads, &|i| self.simplify_into_row(i, share(i), waiting.len()))
    }

    fn simplify_into_row(&self, i: usize, share: f64, n_meshes: usize) -> Result<(), Failure> {
        let began = Instant::now();
        // A panic in one mesh must not end the batch.
        let done = crate::out_of_memory::track(i, || catch_unwind(AssertUnwindSafe(|| self.simplify_one(i))));
        let done = done.unwrap_or_else(|_| Err(Failure::Failed("internal error: please report it".into())));
        if let Err(failure) = &done {
            let line = format!("failed    {}: {failure}", self.manifest.name(i));
            self.lock_progress().bar.suspend(|| if self.args.quiet { Voice::Quiet } else { Voice::Err }.say(&line));
        }
        self.lock_progress().one_more(share, n_meshes);
        self.manifest.set(i, done, began.elapsed().as_secs_f64())
    }

    fn lock_progress(&self) -> MutexGuard<'_, BatchProgress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn simplify_one(&self, i: usize) -> Result<JobReport, Failure> {
        let below = self.manifest.output(i);
        let output = outputs::prepare_path(&self.folder, &below)?;
        // An existing file may be the result of an earlier run, so it does not count as an obstacle here.
        level_paths(&output, self.args.lods.len()).iter().try_for_each(|path| files::check_place(path, true))?;
        let mut request = self.request(&self.inputs[i], output, self.manifest.may_replace(i))?;
        let done = simplify::simplify_file(&mut request, self.weights.as_ref(), &mut Progress::silent())?;
        let done = done.put_by(&|_, beside| self.places.write_beside(&below, beside), files::place_or_find)?;
        Ok(done.0)
    }

    fn request(&self, input: &Input, output: PathBuf, force: bool) -> Result<Request, Failure> {
        let format = self.format.unwrap_or_else(|| outputs::format_for(input));
        let mut job = self.job.clone();
        job.format = format;
        job.check_format().map_err(|error| Failure::Usage(error.to_string()))?;
        let mut request = Request {
            source: Source::new(input.path.clone(), None, !self.args.no_weld).with_as_one(self.args.bake.is_some()),
            job,
            follows_input: false,
            stays_in_memory: false,
            output: Some(output),
            memory: None,
            map: None,
            explain: false,
            weights: None,
            n_threads: None,
            report: self.side_file(input, REPORT)?,
            picture: self.side_file(input, PICTURE)?,
            view: self.args.view,
            wires: self.args.wires,
            quiet: true,
            strict: false,
            force,
        };
        request.job.shapes = request.report.is_some();
        request.name_files();
        Ok(request)
    }

    fn side_file(&self, input: &Input, ending: &str) -> Result<Option<PathBuf>, Failure> {
        let folders = &self.manifest.folders().side_folders;
        let place = folders
            .iter()
            .find(|(_, its)| *its == ending)
            .map(|(folder, _)| outputs::prepare_path(folder, &with_more(&input.below, ending)));
        place.transpose()
    }

    fn report_end(&self, seconds: f64) -> Result<(), Failure> {
        let ends = self.manifest.ends();
        let voice = if self.args.quiet { Voice::Quiet } else { Voice::Out };
        voice.say(&format!(
            "meshes    {}: {} reached the target, {} stopped before it, {} failed",
            self.inputs.len(),
            ends.reached,
            ends.stopped,
            ends.failed
        ));
        voice.say(&format!("time      {seconds:.3} s"));
        match (ends.failed, ends.stopped) {
            (0, n) if n > 0 && strict(&self.args) => {
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
