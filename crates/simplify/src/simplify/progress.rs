//! Progress events of a run, and its interruption.
//!
//! Long loops report by beats of a [`Pulse`], and a beat may call the listener. If the listener stops the run, the next
//! beat on any thread unwinds to the start of the run.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::mesh::pulse::Pulse;

use super::options::{Event, Listener, SimplifyError};

#[derive(Clone, Copy)]
pub(super) struct Stage {
    name: &'static str,
    share: f32,
    passes: f32,
}

const fn stage(name: &'static str, share: f32, passes: f32) -> Stage {
    Stage { name, share, passes }
}

// Stages of the closed assembly with their shares of the time at `MEASURED_RATIOS`, for a scan of 871 thousand faces on
// one thread.
const CLOSED_STAGES: [(Stage, [f32; 3]); 6] = [
    (stage("surface", 0.0, 5.0), [0.075, 0.06, 0.05]),
    (stage("scores", 0.0, 1.2), [0.015, 0.013, 0.01]),
    (stage("collapse", 0.0, 1.0), [0.77, 0.67, 0.665]),
    (stage("flips", 0.0, 1.0), [0.053, 0.0, 0.0]),
    (stage("fit", 0.0, 1.0), [0.056, 0.24, 0.23]),
    (stage("finish", 0.0, 5.0), [0.03, 0.017, 0.045]),
];

/// Name of the stage in which the caller looks at a result before it chooses the next size; no time of the run itself.
pub(super) const LOOK: &str = "proof";

const MEASURED_RATIOS: [f32; 3] = [0.02, 0.1, 0.5];

/// Index of the first stage that every further level repeats, in `FURTHER_LEVEL_TIME` of the first level's time.
const FIRST_STAGE_OF_LEVEL: usize = 2;
const FURTHER_LEVEL_TIME: f32 = 0.3;

// Stages of the paper's assembly, which beat only at their beginnings. Shares are means of victoria0 of TOSCA at ratios
// of 0.05 and 0.2 on one thread.
pub(super) const PAPER_STAGES: [Stage; 6] = [
    stage("scores", 0.37, 1.0),
    stage("sample", 0.14, 1.0),
    stage("assign", 0.12, 1.0),
    stage("edges", 0.13, 1.0),
    stage("faces", 0.23, 1.0),
    stage("assemble", 0.01, 1.0),
];

pub(super) const POINTS: [Stage; 5] =
    [PAPER_STAGES[0], PAPER_STAGES[2], PAPER_STAGES[3], PAPER_STAGES[4], PAPER_STAGES[5]];

/// Lists the stages of `n_levels` levels; `ratio` is the first level's share of the vertices.
pub(super) fn closed_stages(n_levels: usize, ratio: f64) -> Vec<Stage> {
    let stage_at_ratio =
        |&(stage, shares): &(Stage, [f32; 3])| Stage { share: interpolate_share(ratio as f32, shares), ..stage };
    let further = |stage: Stage| Stage { share: stage.share * FURTHER_LEVEL_TIME, ..stage };
    let first: Vec<Stage> = CLOSED_STAGES.iter().map(stage_at_ratio).collect();
    let further: Vec<Stage> =
        (1..n_levels).flat_map(|_| first[FIRST_STAGE_OF_LEVEL..].iter().copied().map(further)).collect();
    first.into_iter().chain(further).collect()
}

fn interpolate_share(ratio: f32, shares: [f32; 3]) -> f32 {
    // The measured interval that contains the ratio, or is nearest to it.
    let i = usize::from(ratio > MEASURED_RATIOS[1]);
    let t =
        (ratio / MEASURED_RATIOS[i]).max(f32::MIN_POSITIVE).ln() / (MEASURED_RATIOS[i + 1] / MEASURED_RATIOS[i]).ln();
    shares[i] + (shares[i + 1] - shares[i]) * t.clamp(0.0, 1.0)
}

#[derive(Clone, Copy)]
pub(super) struct Progress<'a> {
    enter_stage: &'a dyn Fn(&'static str, usize) -> Result<(), SimplifyError>,
    pub pulse: Pulse<'a>,
}

impl Progress<'_> {
    pub const SILENT: Self = Self { enter_stage: &|_, _| Ok(()), pulse: Pulse::NONE };

    /// Enters a stage with its number of items; does nothing if already there.
    pub fn enter(self, stage: &'static str, size: usize) -> Result<(), SimplifyError> {
        (self.enter_stage)(stage, size)
    }
}

/// Runs `work` through these stages and reports to a listener.
///
/// # Errors
/// Those of `work`; [`SimplifyError::Interrupted`] if the listener stopped the run.
pub(super) fn run_with_listener<T>(
    listener: &mut Listener,
    stages: &[Stage],
    work: impl FnOnce(Progress) -> Result<T, SimplifyError>,
) -> Result<T, SimplifyError> {
    let reporter = ProgressReporter::new(listener, stages);
    let (enter_stage, beats) = (|stage, size| reporter.enter(stage, size), |n| reporter.beat(n));
    let progress = Progress { enter_stage: &enter_stage, pulse: Pulse::new(&beats) };
    // Only unwinding with the payload `Stopped` ends here; panics continue. Unwinding runs no panic hook, and costs
    // less than a `Result` in every loop.
    match catch_unwind(AssertUnwindSafe(|| work(progress))) {
        Ok(result) => result,
        Err(payload) if payload.is::<Stopped>() => Err(SimplifyError::Interrupted),
        Err(payload) => resume_unwind(payload),
    }
}

struct Stopped;

struct ProgressReporter<'a> {
    state: Mutex<ReporterState<'a>>,
    stops: AtomicBool,
    n_done: AtomicUsize,
}

struct ReporterState<'a> {
    listener: &'a mut Listener<'a>,
    stages: &'a [Stage],
    stage: Option<(&'static str, usize)>,
    n_items: f32,
    done: f32,
    total: f32,
}

impl<'a> ProgressReporter<'a> {
    fn new(listener: &'a mut Listener<'a>, stages: &'a [Stage]) -> Self {
        let state = ReporterState { listener, stages, stage: None, n_items: 1.0, done: 0.0, total: 0.0 };
        Self { state: Mutex::new(state), stops: AtomicBool::new(false), n_done: AtomicUsize::new(0) }
    }

    fn enter(&self, stage: &'static str, size: usize) -> Result<(), SimplifyError> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.stage.is_none_or(|(name, _)| name != stage) && !self.stops.load(Relaxed) {
            self.n_done.store(0, Relaxed);
            self.update(state, |state| state.begin(stage, size));
        }
        if self.stops.load(Relaxed) { Err(SimplifyError::Interrupted) } else { Ok(()) }
    }

    fn beat(&self, n_items: usize) {
        // The thread that gets the lock reports for all; the others only count.
        let n_done = self.n_done.fetch_add(n_items, Relaxed) + n_items;
        if !self.stops.load(Relaxed)
            && let Ok(state) = self.state.try_lock()
        {
            self.update(state, |state| state.advance(n_done));
        }
        // Threads that did not report unwind at their next beat.
        if cfg!(panic = "unwind") && self.stops.load(Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
    }

    fn update(
        &self,
        mut state: MutexGuard<ReporterState<'a>>,
        change: impl FnOnce(&mut ReporterState<'a>) -> ControlFlow<()>,
    ) {
        if change(&mut state).is_break() {
            self.stops.store(true, Relaxed);
        }
    }
}

impl ReporterState<'_> {
    fn begin(&mut self, name: &'static str, size: usize) -> ControlFlow<()> {
        let first = self.stage.map_or(0, |(_, at)| at + 1);
        // Stages may be skipped but not repeated; an unknown stage leaves the place as it is.
        let ahead = self.stages.iter().skip(first).position(|stage| stage.name == name);
        let at = ahead.map_or(first.saturating_sub(1), |ahead| first + ahead);
        self.stage = Some((name, at));
        self.n_items = self.stages.get(at).map_or(1.0, |stage| stage.passes * size as f32).max(1.0);
        self.done = 0.0;
        self.advance(0)
    }

    fn advance(&mut self, n_done: usize) -> ControlFlow<()> {
        let Some((stage, at)) = self.stage else { return ControlFlow::Continue(()) };
        self.done = (n_done as f32 / self.n_items).min(1.0).max(self.done);
        let share = |stages: &[Stage]| stages.iter().map(|stage| stage.share).sum::<f32>();
        let within = self.stages.get(at).map_or(0.0, |stage| stage.share * self.done);
        let total = (share(&self.stages[..at]) + within) / share(self.stages).max(f32::MIN_POSITIVE);
        // Estimates may be wrong, but shares never fall.
        self.total = total.min(1.0).max(self.total);
        (self.listener)(Event { stage, done: self.done, total: self.total })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::{ClosedOptions, Options, Simplified, Size, simplify, simplify_levels_of_detail};

    fn go_on(_: Event) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn collect_events(work: impl FnOnce(&mut Listener)) -> Vec<Event> {
        let mut events: Vec<Event> = Vec::new();
        work(&mut |event| {
            let last = events.last().copied().unwrap_or(Event { stage: "", done: 0.0, total: 0.0 });
            assert!((last.total..=1.0).contains(&event.total), "{last:?} {event:?}");
            let least = if last.stage == event.stage { last.done } else { 0.0 };
            assert!((least..=1.0).contains(&event.done), "{last:?} {event:?}");
            assert!(last.stage == event.stage || event.done == 0.0, "{event:?}");
            events.push(event);
            ControlFlow::Continue(())
        });
        events
    }

    fn stages(events: &[Event]) -> Vec<&'static str> {
        events.chunk_by(|x, y| x.stage == y.stage).map(|events| events[0].stage).collect()
    }

    #[test]
    fn progress_rises_to_nearly_one_on_any_number_of_threads() {
        let mesh = shapes::torus(300, 150, 1.0, 0.4);
        for (ratio, n_threads) in [(0.03, 1), (0.03, 4), (0.5, 2)] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            let options = Options::new(Size::Ratio(ratio));
            let run = |listener: &mut Listener| _ = pool.install(|| simplify(&mesh, &options, listener)).unwrap();
            let events = collect_events(run);
            assert_eq!(stages(&events), CLOSED_STAGES.map(|(stage, _)| stage.name));
            assert!(events.last().unwrap().total > 0.95, "{:?}", events.last());
            for stage in ["surface", "collapse", "fit"] {
                let of_stage: Vec<&Event> = events.iter().filter(|event| event.stage == stage).collect();
                let done = of_stage.last().unwrap().done;
                assert!(of_stage.len() > 6 && done > 0.7, "{stage}: {} {done}", of_stage.len());
            }
        }
    }

    #[test]
    fn levels_of_detail_are_parts_of_one_run() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let options = ClosedOptions::default();
        let sizes = [Size::Ratio(0.5), Size::Ratio(0.2), Size::Vertices(50)];
        let run = |listener: &mut Listener| {
            _ = simplify_levels_of_detail(&mesh, &options, &sizes, listener).unwrap();
        };
        let events = collect_events(run);
        assert_eq!(stages(&events).iter().filter(|stage| **stage == "collapse").count(), 3);
        let of_first = events.iter().find(|event| event.stage == "finish").unwrap();
        assert!(of_first.total < 0.8 && events.last().unwrap().total > 0.9);
    }

    fn stop_at(event: usize, mesh: &TriMesh, options: &Options) -> Result<Simplified, SimplifyError> {
        let mut n_events = 0;
        simplify(mesh, options, &mut |_| {
            n_events += 1;
            if n_events > event { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    }

    #[test]
    fn stopped_at_any_event_it_says_so_quietly_and_the_next_run_is_unharmed() {
        static IS_LOUD: AtomicBool = AtomicBool::new(false);
        let others = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if info.payload().is::<Stopped>() {
                IS_LOUD.store(true, Relaxed);
            } else {
                others(info);
            }
        }));
        let options = Options::new(Size::Ratio(0.05));
        // Every event of a short run, some of a longer one.
        for (mesh, step) in [(shapes::icosphere(3), 1), (shapes::torus(200, 100, 1.0, 0.4), 25)] {
            let options = if step == 1 { options.clone() } else { Options::new(Size::Ratio(0.5)) };
            let expected = simplify(&mesh, &options, &mut go_on);
            for n_threads in [1, 4] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
                let n_events = collect_events(|listener| {
                    _ = pool.install(|| simplify(&mesh, &options, listener));
                });
                assert!(n_events.len() > 40, "{}", n_events.len());
                // With several threads, simultaneous events merge, so that some runs have fewer.
                let last = if n_threads == 1 { n_events.len() } else { n_events.len() / 2 };
                for event in (0..last).step_by(step) {
                    let result = pool.install(|| stop_at(event, &mesh, &options));
                    assert_eq!(result, Err(SimplifyError::Interrupted), "{event} of {}", n_events.len());
                }
                assert_eq!(pool.install(|| simplify(&mesh, &options, &mut go_on)), expected);
            }
        }
        assert!(!IS_LOUD.load(Relaxed));
    }

    #[test]
    fn a_panic_of_the_listener_propagates() {
        let mesh = shapes::icosphere(3);
        let run = || simplify(&mesh, &Options::new(Size::Vertices(50)), &mut |_| resume_unwind(Box::new(7u8)));
        let payload = catch_unwind(AssertUnwindSafe(run)).unwrap_err();
        assert_eq!(payload.downcast_ref(), Some(&7u8));
    }
}
