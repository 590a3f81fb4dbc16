//! Simplification of a file or of arrays.

use std::ops::ControlFlow;
use std::path::Path;

use neural_mesh::io::{self, Format};
use neural_mesh::job::{Arguments, Document, Files, Job, JobStage, Seconds, Watch, read_options, run};
use neural_mesh::simplify::Event;
use serde::Deserialize;
use serde_json::{Value, json};

use super::arrays::{Arrays, add_result};
use super::clock::seconds;
use super::file::File;
use crate::message::{Answer, Message, ProgressListener};
use crate::refusal::Refusal;

/// Steps of a job; a step's index is its number in calls of `progress`.
const STEPS: [JobStage; 6] =
    [JobStage::Read, JobStage::Simplify, JobStage::Bake, JobStage::Check, JobStage::Write, JobStage::Picture];

#[derive(Deserialize)]
struct SimplifyRequest {
    #[serde(skip)]
    options: Arguments,
    file: Option<File>,
    mesh: Option<Arrays>,
    /// Name of the result; without it no file is written.
    out: Option<String>,
    #[serde(default)]
    arrays: bool,
}

pub fn simplify_document(
    message: &Message,
    mut json: Value,
    answer: &mut Answer,
    listener: ProgressListener,
) -> Result<Value, Refusal> {
    let options = json.get_mut("options").map(Value::take).filter(|options| !options.is_null());
    let mut request_json: SimplifyRequest = serde_json::from_value(json)?;
    request_json.options = options.map_or_else(|| Ok(Arguments::default()), read_options)?;
    let mut job = request_json.to_job()?;
    let mut watch = Watcher { listener, step: 0, is_ended: false, since: seconds(), seconds: [0.0; STEPS.len()] };
    watch.begin(JobStage::Read);
    let document = request_json.read_document(message, &job)?;
    request_json.name_files(&mut job, &document);
    let mut outcome = run(&document, &job, &mut watch)?;
    watch.begin(JobStage::Write);
    let mut files = Vec::new();
    if request_json.out.is_some() {
        let written = outcome.write(&document, &job)?;
        let named = job.names.files.iter().zip(written);
        files =
            named.map(|(name, written)| add_file(name, written, answer)).collect::<Result<Vec<Value>, Refusal>>()?;
    }
    if watch.is_ended {
        return Err(Refusal { what: "interrupted".into(), is_interrupted: true });
    }
    let mut results = Vec::new();
    for result in outcome.results.iter().filter(|_| request_json.arrays) {
        results.push(add_result(&document, result, document.exact_positions(result, &job), answer));
    }
    outcome.report.seconds = watch.seconds();
    Ok(json!({ "report": outcome.report, "files": files, "results": results, "notes": outcome.report.notes }))
}

impl SimplifyRequest {
    /// Returns the job, with the format that the name of the result implies.
    fn to_job(&self) -> Result<Job, Refusal> {
        let named = self.out.as_deref().map(|name| {
            let format =
                Format::from_path(Path::new(name)).or_else(|| Format::from_name(self.options.format.as_deref()?));
            format
                .ok_or_else(|| Refusal::new(format!("{name}: unknown format: name it by {}", Format::NAMES.join(", "))))
        });
        // A result in memory uses a format that holds all attributes.
        let mut job = self.options.job_as(named.transpose()?.unwrap_or(Format::Ply))?;
        if self.out.is_some() {
            job.check_format()?;
        }
        // Shapes are measured together with distances, since both take about equally long.
        job.shapes = !job.arguments.no_check;
        Ok(job)
    }

    fn read_document(&self, message: &Message, job: &Job) -> Result<Document, Refusal> {
        match (&self.file, &self.mesh) {
            (Some(file), None) => {
                let (bytes, folder) = file.open(message)?;
                Document::from_bytes_in(bytes, &file.name, &folder, job).map_err(|error| file.refusal(error))
            }
            (None, Some(arrays)) => {
                let (read, importance) = arrays.read(message)?;
                Ok(Document::from_mesh(read, job)?.with_importance(importance))
            }
            _ => Err(Refusal::new("give one mesh, as a file or as arrays")),
        }
    }

    /// Names the files of the results: one, or one per level of detail.
    fn name_files(&self, job: &mut Job, document: &Document) {
        let Some(name) = &self.out else { return };
        let n_levels = job.goal.n_levels().filter(|_| job.has_file_per_level(document.is_scene()));
        let path = Format::without_gz(Path::new(name)).into_owned();
        let [stem, ending] = [path.file_stem(), path.extension()].map(|it| it.unwrap_or_default().to_string_lossy());
        let rest = &name[path.as_os_str().len().min(name.len())..];
        let level = |number: usize| format!("{stem}-{number}.{ending}{rest}");
        job.names.files = n_levels.map_or_else(|| vec![name.clone()], |n| (1..=n).map(level).collect());
        job.names.shared = job.goal.n_levels().map(|_| stem.clone().into_owned());
    }
}

fn add_file(name: &str, written: Files, answer: &mut Answer) -> Result<Value, Refusal> {
    let bytes = io::compress_by_name(name.as_ref(), &written.bytes)
        .map_err(|error| Refusal::new(format!("{name}: {error}")))?;
    let bytes = answer.add(bytes.into_owned());
    let beside = written.companion_files.into_iter().map(|file| {
        let name = file.path.to_string_lossy().into_owned();
        json!({ "name": name, "bytes": answer.add(file.bytes) })
    });
    let beside: Vec<Value> = beside.collect();
    Ok(json!({ "name": name, "bytes": bytes, "beside": beside }))
}

struct Watcher {
    listener: ProgressListener,
    step: u32,
    is_ended: bool,
    /// Start of the present step, in seconds.
    since: f64,
    /// Duration of each step, in seconds.
    seconds: [f64; STEPS.len()],
}

impl Watcher {
    fn end_step(&mut self) {
        let now = seconds();
        self.seconds[self.step as usize] += now - std::mem::replace(&mut self.since, now);
    }

    fn seconds(&mut self) -> Seconds {
        self.end_step();
        let [read, simplify, bake, check, write, _] = self.seconds;
        let bake = Some(bake).filter(|bake| *bake > 0.0);
        Seconds { read, simplify, bake, check, write, ..Seconds::default() }
    }
}

impl Watch for Watcher {
    fn begin(&mut self, step: JobStage) {
        self.end_step();
        self.step = STEPS.iter().position(|other| *other == step).unwrap_or_default() as u32;
        self.is_ended |= (self.listener)(0.0, self.step).is_break();
    }

    fn event(&mut self, event: Event) -> ControlFlow<()> {
        self.is_ended |= (self.listener)(f64::from(event.total), self.step).is_break();
        if self.is_ended { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
