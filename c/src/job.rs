//! Whole jobs by handle: a file, its bytes or arrays in; arrays, bytes or files and a report out.

use std::ffi::{CString, c_char, c_void};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

use neural_mesh::io::{Folder, Format, OutputFile, ReadMesh, read_file, write_files};
use neural_mesh::job::{Document, Files, Job, Outcome, Part, Watch, run};
use neural_mesh::mesh::RawMesh;
use neural_mesh::simplify::{Event, Simplified};
use rayon::ThreadPoolBuilder;

use crate::errors::{Refused, guarded};
use crate::options::Options;
use crate::pointers::{User, bytes, given, numbers, rows, shared, taken, text, write_one};

/// More threads than any machine has.
const MOST_THREADS: usize = 1024;

/// Hears how far a run is, from 0 to 1, and at what; anything but 0 ends it. It may be called on another thread than the one that runs the
/// job, never on two at once.
pub type NmProgress = Option<extern "C" fn(user: *mut c_void, done: f32, stage: *const c_char) -> i32>;

/// What is to be simplified, and how.
pub struct NmJob {
    asked: Mutex<Asked>,
    is_cancelled: AtomicBool,
}

/// What a job has been told.
#[derive(Default)]
struct Asked {
    options: Options,
    n_threads: usize,
    source: Source,
    progress: NmProgress,
    user: Option<User>,
}

/// Where the mesh comes from.
#[derive(Clone, Default)]
enum Source {
    #[default]
    None,
    /// The bytes of a file, its name, and the folder that it lies in.
    File(Vec<u8>, String, Option<Folder>),
    Arrays(Box<ReadMesh>),
}

/// What came of a job.
pub struct NmResult {
    outcome: Outcome,
    report: CString,
    /// The file of each level, or one of all.
    files: Vec<Files>,
}

impl NmJob {
    fn asked(&self) -> MutexGuard<'_, Asked> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns a job without a mesh and without options; `nm_job_free` gives it back. Null where it fails.
#[unsafe(no_mangle)]
pub extern "C" fn nm_job_new() -> *mut NmJob {
    let new = || Ok(given(NmJob { asked: Mutex::default(), is_cancelled: AtomicBool::new(false) }));
    guarded(std::ptr::null_mut(), new)
}

/// Gives a job back; nothing where it is null.
///
/// # Safety
/// The job is one of `nm_job_new`, and nobody uses it any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_free(job: *mut NmJob) {
    guarded((), || {
        drop(taken(job));
        Ok(())
    });
}

/// Sets an option of `neural-mesh simplify` by its name, `_` for `-`, to a value as it is typed there: `ratio` to `10%`, `subset` to `true`,
/// `threads` to `2`. Returns 1, or 0 where it fails.
///
/// # Safety
/// Job and texts are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_set(job: *const NmJob, name: *const c_char, value: *const c_char) -> i32 {
    guarded(0, || {
        let (mut asked, name, value) = (shared("job", job)?.asked(), text("name", name)?, text("value", value)?);
        if name == "threads" {
            let n = value.parse().ok().filter(|n| (1..=MOST_THREADS).contains(n));
            asked.n_threads = n.ok_or_else(|| Refused::of("threads", format!("give 1 to {MOST_THREADS}")))?;
        } else {
            asked.options.set(&name, &value)?;
        }
        Ok(1)
    })
}

/// Takes the mesh from a file; of what it names, what lies in its folder is found. Returns 1, or 0 where it fails.
///
/// # Safety
/// Job and text are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_read_file(job: *const NmJob, path: *const c_char) -> i32 {
    guarded(0, || {
        let (job, path) = (shared("job", job)?, text("path", path)?);
        let file = read_file(Path::new(&path)).map_err(|error| Refused::of(&path, error))?;
        job.asked().source = Source::File(file, path.clone(), Some(Folder::from_file(Path::new(&path))));
        Ok(1)
    })
}

/// Takes the mesh from the bytes of a file; `name`, which may be null, says the format where the bytes do not. Returns 1, or 0 where it
/// fails.
///
/// # Safety
/// Job and text are valid, and so many bytes are at the address.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_read_bytes(
    job: *const NmJob,
    data: *const c_void,
    byte_count: usize,
    name: *const c_char,
) -> i32 {
    guarded(0, || {
        let name = if name.is_null() { String::new() } else { text("name", name)? };
        let job = shared("job", job)?;
        job.asked().source = Source::File(bytes("data", data, byte_count)?, name, None);
        Ok(1)
    })
}

/// Takes the mesh from positions and triangles. Returns 1, or 0 where it fails.
///
/// # Safety
/// The job is valid, and as many values as are said are at each address; the stride is in bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_read_arrays(
    job: *const NmJob,
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    indices: *const u32,
    index_count: usize,
) -> i32 {
    guarded(0, || {
        let positions = rows("vertex_positions", vertex_positions, vertex_count, 3, vertex_positions_stride)?;
        if !index_count.is_multiple_of(3) {
            return Err(Refused::of("index_count", format!("{index_count}: give a multiple of 3")));
        }
        let faces = numbers("indices", indices, index_count)?.as_chunks().0.to_vec();
        let positions = positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect();
        let mut read = ReadMesh::default();
        read.mesh = RawMesh::new(positions, faces);
        shared("job", job)?.asked().source = Source::Arrays(Box::new(read));
        Ok(1)
    })
}

/// Lets a function hear how far a run is; `user` goes back to it. Returns 1, or 0 where it fails.
///
/// # Safety
/// The job is valid, and the function may be called until the job is given back.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_listen(job: *const NmJob, progress: NmProgress, user: *mut c_void) -> i32 {
    guarded(0, || {
        let mut asked = shared("job", job)?.asked();
        (asked.progress, asked.user) = (progress, Some(User(user)));
        Ok(1)
    })
}

/// Ends the run of a job, from any thread; one that runs it next ends at once, too. Returns 1, or 0 where it fails.
///
/// # Safety
/// The job is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_cancel(job: *const NmJob) -> i32 {
    guarded(0, || {
        shared("job", job)?.is_cancelled.store(true, Relaxed);
        Ok(1)
    })
}

/// Runs a job and returns its result, which `nm_result_free` gives back; null where it fails. A job may run again, with other options.
///
/// # Safety
/// The job is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_job_run(job: *const NmJob) -> *mut NmResult {
    guarded(std::ptr::null_mut(), || {
        let job = shared("job", job)?;
        let (options, n_threads, source, watcher) = {
            let asked = job.asked();
            let watcher = Watcher { is_cancelled: &job.is_cancelled, progress: asked.progress, user: asked.user };
            (asked.options.clone(), asked.n_threads, asked.source.clone(), watcher)
        };
        let work = || result(&options, source, watcher);
        let made = if n_threads == 0 {
            work()?
        } else {
            ThreadPoolBuilder::new().num_threads(n_threads).build()?.install(work)?
        };
        Ok(given(made))
    })
}

fn result(options: &Options, source: Source, mut watcher: Watcher) -> Result<NmResult, Refused> {
    let arguments = options.arguments()?;
    let format = arguments.format.as_deref().map_or(Some(Format::Ply), Format::from_name);
    let mut job = arguments.job_as(format.ok_or_else(|| Refused::of("format", "is not known"))?)?;
    watcher.begin(Part::Read);
    let document = match source {
        Source::None => return Err(Refused("no mesh: read one first".into())),
        Source::File(bytes, name, folder) => {
            let folder = folder.unwrap_or_else(|| Folder::in_memory(std::iter::empty::<(String, Vec<u8>)>()));
            Document::from_bytes_in(&bytes, &name, &folder, &job)?
        }
        Source::Arrays(read) => Document::from_mesh(*read, &job)?,
    };
    name_files(&mut job, &document);
    let mut outcome = run(&document, &job, None, &mut watcher)?;
    let files = outcome.write(&document, &job)?;
    let report = CString::new(serde_json::to_string(&outcome.report)?)?;
    Ok(NmResult { outcome, report, files })
}

/// Names the files of the levels: those of a scene are in one.
fn name_files(job: &mut Job, document: &Document) {
    let n_levels = job.goal.n_levels().filter(|_| !document.is_scene());
    let ending = job.format.name();
    let level = |number: usize| format!("mesh-{number}.{ending}");
    job.names.files = n_levels.map_or_else(|| vec![format!("mesh.{ending}")], |n| (0..n).map(level).collect());
}

/// Tells how far a run is.
struct Watcher<'a> {
    is_cancelled: &'a AtomicBool,
    progress: NmProgress,
    user: Option<User>,
}

impl Watcher<'_> {
    fn told(&self, done: f32, stage: &str) -> ControlFlow<()> {
        let user = self.user.map_or(std::ptr::null_mut(), |user| user.0);
        let stage = CString::new(stage).unwrap_or_default();
        let ends = self.progress.is_some_and(|progress| progress(user, done, stage.as_ptr()) != 0);
        if ends || self.is_cancelled.load(Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Watch for Watcher<'_> {
    fn begin(&mut self, _: Part) {}

    fn event(&mut self, event: Event) -> ControlFlow<()> {
        self.told(event.total, event.stage)
    }
}

impl NmResult {
    fn simplified(&self, level: usize) -> Result<&Simplified, Refused> {
        let n = self.outcome.results.len();
        self.outcome.results.get(level).ok_or_else(|| Refused::of("level", format!("{level}: there are {n}")))
    }

    /// The file of a level; of a scene all levels are in one.
    fn file(&self, level: usize) -> Result<&Files, Refused> {
        let n = self.files.len();
        self.files.get(level).ok_or_else(|| Refused::of("level", format!("{level}: there are files of {n}")))
    }
}

/// Returns how many levels of detail a result has, 1 without such; 0 where it fails.
///
/// # Safety
/// The result is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_levels(result: *const NmResult) -> usize {
    guarded(0, || Ok(shared("result", result)?.outcome.results.len()))
}

/// Returns the report as JSON, UTF-8 that ends with a zero and lasts as long as the result; null where it fails.
///
/// # Safety
/// The result is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_report(result: *const NmResult) -> *const c_char {
    guarded(std::ptr::null(), || Ok(shared("result", result)?.report.as_ptr()))
}

/// Gives the addresses of a level's positions (3 numbers each) and indices, and how many there are; they last as long as the result. Places
/// that are null get nothing. Returns 1, or 0 where it fails.
///
/// # Safety
/// The result is valid, and so are the places that are not null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_arrays(
    result: *const NmResult,
    level: usize,
    vertex_positions: *mut *const f32,
    vertex_count: *mut usize,
    indices: *mut *const u32,
    index_count: *mut usize,
) -> i32 {
    guarded(0, || {
        let mesh = &shared("result", result)?.simplified(level)?.mesh;
        write_one(vertex_positions, mesh.positions().as_flattened().as_ptr());
        write_one(vertex_count, mesh.positions().len());
        write_one(indices, mesh.faces().as_flattened().as_ptr());
        write_one(index_count, 3 * mesh.faces().len());
        Ok(1)
    })
}

/// Returns the bytes of a level's file, in the format of the option `format`, PLY without it, and writes how many to `byte_count`; they last
/// as long as the result. Null where it fails.
///
/// # Safety
/// The result is valid, and so is the place unless it is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_bytes(
    result: *const NmResult,
    level: usize,
    byte_count: *mut usize,
) -> *const c_void {
    guarded(std::ptr::null(), || {
        let file = shared("result", result)?.file(level)?;
        write_one(byte_count, file.bytes.len());
        Ok(file.bytes.as_ptr().cast())
    })
}

/// Writes a level's file, with what belongs beside it; one that is there is replaced where `force` is not 0. Returns 1, or 0 where it fails.
///
/// # Safety
/// Result and text are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_write(
    result: *const NmResult,
    level: usize,
    path: *const c_char,
    force: i32,
) -> i32 {
    guarded(0, || {
        let (result, path) = (shared("result", result)?, text("path", path)?);
        let path = Path::new(&path);
        let name = path.file_name().ok_or_else(|| Refused::of("path", "names no file"))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let made = result.file(level)?;
        let mut files = vec![OutputFile { path: name.into(), bytes: made.bytes.clone() }];
        files.extend(made.beside.iter().cloned());
        write_files(folder, &files, force != 0)?;
        Ok(1)
    })
}

/// Gives a result back; nothing where it is null.
///
/// # Safety
/// The result is one of `nm_job_run`, and nobody uses it or what it gave any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_result_free(result: *mut NmResult) {
    guarded((), || {
        drop(taken(result));
        Ok(())
    });
}
