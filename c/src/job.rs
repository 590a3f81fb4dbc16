//! Whole jobs by handle, from files, bytes or arrays.

use std::borrow::Cow;
use std::ffi::{CString, c_char, c_void};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

use neural_mesh::io::{FilesRead, Folder, Format, OutputFile, ReadMesh, read_file, write_files};
use neural_mesh::job::{Document, Files, Job, JobOutcome, JobStage, Watch, run};
use neural_mesh::mesh::RawMesh;
use neural_mesh::simplify::{Event, Simplified};
use rayon::ThreadPoolBuilder;

use crate::errors::{CallError, run_guarded};
use crate::options::NamedOptions;
use crate::pointers::{
    UserPointer, borrow_handle, into_handle, read_bytes, read_numbers, read_rows, read_text, take_handle, write_number,
};

const MAX_THREADS: usize = 1024;

/// Callback with the progress of a run, from 0 to 1, and the name of the stage.
///
/// A result other than 0 ends the run. Calls may come from another thread, but never from two at once.
pub type NmProgress = Option<extern "C" fn(user: *mut c_void, done: f32, stage: *const c_char) -> i32>;

/// Job: a mesh to simplify, and options.
pub struct NmJob {
    settings: Mutex<JobSettings>,
    is_cancelled: AtomicBool,
}

#[derive(Default)]
struct JobSettings {
    options: NamedOptions,
    n_threads: usize,
    source: MeshSource,
    progress: NmProgress,
    user: Option<UserPointer>,
}

#[derive(Clone, Default)]
enum MeshSource {
    #[default]
    None,
    /// Bytes of a file, its name, and the folder with the files that it names.
    File(Vec<u8>, String, Option<Folder>),
    Arrays(Box<ReadMesh>),
}

/// Result of a job.
pub struct NmResult {
    outcome: JobOutcome,
    report: CString,
    /// Files of each level of detail, or of one file with all levels.
    files: Vec<Files>,
    read: FilesRead,
    /// Document and job, if companion files may need other names in the folder where they are written.
    origin: Option<(Document, Job)>,
}

impl NmJob {
    fn lock_settings(&self) -> MutexGuard<'_, JobSettings> {
        self.settings.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns a job without mesh and options, to be freed by `nm_job_free`; null on failure.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn nm_job_new() -> *mut NmJob {
    let new = || Ok(into_handle(NmJob { settings: Mutex::default(), is_cancelled: AtomicBool::new(false) }));
    run_guarded(std::ptr::null_mut(), new)
}

/// Frees a job; does nothing for null.
///
/// # Safety
/// The job comes from `nm_job_new`, and nothing uses it any more.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_free(job: *mut NmJob) {
    run_guarded((), || {
        drop(take_handle(job));
        Ok(())
    });
}

/// Sets an option of `neural-mesh simplify`, named with `_` for `-`, to a value as typed there.
///
/// Examples: `ratio` to `10%`, `subset` to `true`, `threads` to `2`. Returns 1, or 0 on failure.
///
/// # Safety
/// Job and texts are valid.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_set(job: *const NmJob, name: *const c_char, value: *const c_char) -> i32 {
    run_guarded(0, || {
        let (name, value) = (read_text("name", name)?, read_text("value", value)?);
        let mut settings = borrow_handle("job", job)?.lock_settings();
        if name == "threads" {
            let n = value.parse().ok().filter(|n| (1..=MAX_THREADS).contains(n));
            settings.n_threads = n.ok_or_else(|| CallError::new("threads", format!("give 1 to {MAX_THREADS}")))?;
        } else {
            settings.options.set(&name, &value)?;
        }
        Ok(1)
    })
}

/// Reads the mesh from a file, and the files that it names from its folder. Returns 1, or 0 on failure.
///
/// # Safety
/// Job and text are valid.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_read_file(job: *const NmJob, path: *const c_char) -> i32 {
    run_guarded(0, || {
        let (job, path) = (borrow_handle("job", job)?, read_text("path", path)?);
        let file = read_file(Path::new(&path)).map_err(|error| CallError::new(&path, error))?;
        job.lock_settings().source = MeshSource::File(file, path.clone(), Some(Folder::from_file(Path::new(&path))));
        Ok(1)
    })
}

/// Reads the mesh from the bytes of a file. Returns 1, or 0 on failure.
///
/// `name`, which may be null, gives the format if the bytes do not.
///
/// # Safety
/// Job and text are valid, and `data` has `byte_count` bytes.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_read_bytes(
    job: *const NmJob,
    data: *const c_void,
    byte_count: usize,
    name: *const c_char,
) -> i32 {
    run_guarded(0, || {
        let name = if name.is_null() { String::new() } else { read_text("name", name)? };
        let job = borrow_handle("job", job)?;
        job.lock_settings().source = MeshSource::File(read_bytes("data", data, byte_count)?, name, None);
        Ok(1)
    })
}

/// Reads the mesh from positions and triangles. Returns 1, or 0 on failure.
///
/// # Safety
/// The job is valid, and each array has as many values as its count says; the stride is in bytes.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_read_arrays(
    job: *const NmJob,
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    indices: *const u32,
    index_count: usize,
) -> i32 {
    run_guarded(0, || {
        let positions = read_rows("vertex_positions", vertex_positions, vertex_count, 3, vertex_positions_stride)?;
        if !index_count.is_multiple_of(3) {
            return Err(CallError::new("index_count", format!("{index_count}: give a multiple of 3")));
        }
        let faces = read_numbers("indices", indices, index_count)?.as_chunks().0.to_vec();
        let positions = positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect();
        let mut read = ReadMesh::default();
        read.mesh = RawMesh::new(positions, faces);
        borrow_handle("job", job)?.lock_settings().source = MeshSource::Arrays(Box::new(read));
        Ok(1)
    })
}

/// Sets the progress callback, which receives `user`; null removes the callback. Returns 1, or 0 on failure.
///
/// # Safety
/// The job is valid, and the function may be called until the job is freed.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_listen(job: *const NmJob, progress: NmProgress, user: *mut c_void) -> i32 {
    run_guarded(0, || {
        let mut settings = borrow_handle("job", job)?.lock_settings();
        (settings.progress, settings.user) = (progress, Some(UserPointer(user)));
        Ok(1)
    })
}

/// Cancels a job from any thread: a run ends soon, later runs end at once. Returns 1, or 0 on failure.
///
/// # Safety
/// The job is valid.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_cancel(job: *const NmJob) -> i32 {
    run_guarded(0, || {
        borrow_handle("job", job)?.is_cancelled.store(true, Relaxed);
        Ok(1)
    })
}

/// Runs a job and returns its result, to be freed by `nm_result_free`; null on failure.
///
/// A job may run again, with other options.
///
/// # Safety
/// The job is valid.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_run(job: *const NmJob) -> *mut NmResult {
    run_guarded(std::ptr::null_mut(), || {
        let job = borrow_handle("job", job)?;
        let (options, n_threads, source, watcher) = {
            let settings = job.lock_settings();
            let watcher = Watcher { is_cancelled: &job.is_cancelled, progress: settings.progress, user: settings.user };
            (settings.options.clone(), settings.n_threads, settings.source.clone(), watcher)
        };
        let work = || run_job(&options, source, watcher);
        let result = if n_threads == 0 {
            work()?
        } else {
            ThreadPoolBuilder::new().num_threads(n_threads).build()?.install(work)?
        };
        Ok(into_handle(result))
    })
}

fn run_job(options: &NamedOptions, source: MeshSource, mut watcher: Watcher) -> Result<NmResult, CallError> {
    let arguments = options.to_arguments()?;
    let format = arguments.format.as_deref().unwrap_or("ply");
    let unknown = || CallError::new("format", format!("{format}: choose from {}", Format::NAMES.join(", ")));
    let mut job = arguments.job_as(Format::from_name(format).ok_or_else(unknown)?)?;
    watcher.begin(JobStage::Read);
    let document = match source {
        MeshSource::None => return Err(CallError("no mesh: read one first".into())),
        MeshSource::File(bytes, name, folder) => {
            let folder = folder.unwrap_or_else(|| Folder::in_memory(std::iter::empty::<(String, Vec<u8>)>()));
            Document::from_bytes_in(&bytes, &name, &folder, &job)?
        }
        MeshSource::Arrays(read) => Document::from_mesh(*read, &job)?,
    };
    name_files(&mut job, &document);
    let mut outcome = run(&document, &job, &mut watcher)?;
    let files = outcome.write(&document, &job)?;
    let report = CString::new(serde_json::to_string(&outcome.report)?)?;
    let (read, has_companions) = (document.files_read(), files.iter().any(|file| !file.companion_files.is_empty()));
    Ok(NmResult { outcome, report, files, read, origin: has_companions.then_some((document, job)) })
}

/// Names the result's files: one, or one per level of detail.
fn name_files(job: &mut Job, document: &Document) {
    let n_levels = job.goal.n_levels().filter(|_| job.has_file_per_level(document.is_scene()));
    let ending = job.format.name();
    let level = |number: usize| format!("mesh-{number}.{ending}");
    job.names.files = n_levels.map_or_else(|| vec![format!("mesh.{ending}")], |n| (0..n).map(level).collect());
}

struct Watcher<'a> {
    is_cancelled: &'a AtomicBool,
    progress: NmProgress,
    user: Option<UserPointer>,
}

impl Watcher<'_> {
    fn report_progress(&self, done: f32, stage: &str) -> ControlFlow<()> {
        let user = self.user.map_or(std::ptr::null_mut(), |user| user.0);
        let stage = CString::new(stage).unwrap_or_default();
        let ends = self.progress.is_some_and(|progress| progress(user, done, stage.as_ptr()) != 0);
        if ends || self.is_cancelled.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Watch for Watcher<'_> {
    fn begin(&mut self, _: JobStage) {}

    fn event(&mut self, event: Event) -> ControlFlow<()> {
        self.report_progress(event.total, event.stage)
    }
}

impl NmResult {
    fn find_level(&self, level: usize) -> Result<&Simplified, CallError> {
        let n = self.outcome.results.len();
        self.outcome
            .results
            .get(level)
            .ok_or_else(|| CallError::new("level", format!("{level}: there are only {n} levels")))
    }

    fn find_file(&self, level: usize) -> Result<&Files, CallError> {
        let n = self.files.len();
        self.files.get(level).ok_or_else(|| CallError::new("level", format!("{level}: there are only {n} files")))
    }

    /// Writes a level's file; companion files get other names where they would change a file that was read.
    fn write_file(&self, level: usize, path: &Path, force: bool) -> Result<(), CallError> {
        let name = path.file_name().ok_or_else(|| CallError::new("path", "names no file"))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut file = Cow::Borrowed(self.find_file(level)?);
        if let Some((document, job)) = &self.origin {
            let mut job = job.clone();
            job.names.folder = Some(folder.into());
            file = Cow::Owned(self.outcome.make_files(document, &job)?.swap_remove(level));
        }
        self.read.check(path, true).map_err(|error| CallError::new("path", error))?;
        self.read.check_companions(folder, &file.companion_files)?;
        let mut files = vec![OutputFile { path: name.into(), bytes: file.bytes.clone() }];
        files.extend(file.companion_files.iter().cloned());
        self.read.forget_mesh(path);
        Ok(write_files(folder, &files, force)?)
    }
}

/// Returns the number of levels of detail, 1 for a single mesh; 0 on failure.
///
/// # Safety
/// The result is valid.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_levels(result: *const NmResult) -> usize {
    run_guarded(0, || Ok(borrow_handle("result", result)?.outcome.results.len()))
}

/// Returns the report as JSON, zero-terminated UTF-8 that lives as long as the result; null on failure.
///
/// # Safety
/// The result is valid.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_report(result: *const NmResult) -> *const c_char {
    run_guarded(std::ptr::null(), || Ok(borrow_handle("result", result)?.report.as_ptr()))
}

/// Writes the addresses and counts of a level's positions (3 numbers each) and indices. Returns 1, or 0 on failure.
///
/// Null pointers receive nothing. The arrays live as long as the result.
///
/// # Safety
/// The result is valid, and so are the pointers that are not null.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_arrays(
    result: *const NmResult,
    level: usize,
    vertex_positions: *mut *const f32,
    vertex_count: *mut usize,
    indices: *mut *const u32,
    index_count: *mut usize,
) -> i32 {
    run_guarded(0, || {
        let mesh = &borrow_handle("result", result)?.find_level(level)?.mesh;
        write_number(vertex_positions, mesh.positions().as_flattened().as_ptr());
        write_number(vertex_count, mesh.positions().len());
        write_number(indices, mesh.faces().as_flattened().as_ptr());
        write_number(index_count, 3 * mesh.faces().len());
        Ok(1)
    })
}

/// Returns the bytes of a level's file, and writes their number to `byte_count`; null on failure.
///
/// The option `format` sets the format (PLY by default). The bytes live as long as the result.
///
/// # Safety
/// The result is valid; `byte_count` is valid or null.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_bytes(
    result: *const NmResult,
    level: usize,
    byte_count: *mut usize,
) -> *const c_void {
    run_guarded(std::ptr::null(), || {
        let file = borrow_handle("result", result)?.find_file(level)?;
        write_number(byte_count, file.bytes.len());
        Ok(file.bytes.as_ptr().cast())
    })
}

/// Writes a level's file and the files that belong to it. Returns 1, or 0 on failure.
///
/// Existing files are replaced if `force` is not 0, but of the files that were read only the mesh itself.
///
/// # Safety
/// Result and text are valid.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_write(
    result: *const NmResult,
    level: usize,
    path: *const c_char,
    force: i32,
) -> i32 {
    run_guarded(0, || {
        let (result, path) = (borrow_handle("result", result)?, read_text("path", path)?);
        result.write_file(level, Path::new(&path), force != 0)?;
        Ok(1)
    })
}

/// Frees a result; does nothing for null.
///
/// # Safety
/// The result comes from `nm_job_run`, and nothing uses it or its arrays any more.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_free(result: *mut NmResult) {
    run_guarded((), || {
        drop(take_handle(result));
        Ok(())
    });
}
