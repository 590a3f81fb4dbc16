//! Progress of a run, and the seconds of its stages.

use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use std::time::Instant;

use neural_mesh::job::{JobStage, Seconds, Watch};
use neural_mesh::simplify::{Event, Listener};

use crate::bar::Bar;
use crate::plan::{Plan, describe_stage, describe_step};

const STEPS: f64 = 500.0;

pub struct Progress {
    bar: Bar,
    plan: RefCell<Plan>,
    /// Words and position of the bar; the position, in steps, never falls.
    shown: Cell<(&'static str, u64)>,
    stages: Vec<(&'static str, f64)>,
    parts: Vec<(JobStage, f64)>,
    current: Option<(&'static str, Instant)>,
    current_part: Option<(JobStage, Instant)>,
    listener: Option<Box<Listener<'static>>>,
}

impl Progress {
    pub fn new(quiet: bool, plan: Plan) -> Self {
        let (plan, shown) = (RefCell::new(plan), Cell::default());
        let (stages, parts) = (Vec::new(), Vec::new());
        let (current, current_part, listener) = (None, None, None);
        Self { bar: Bar::new(quiet), plan, shown, stages, parts, current, current_part, listener }
    }

    pub fn silent() -> Self {
        Self::new(true, Plan::new(&[]))
    }

    /// Starts a run without output that forwards events to a listener.
    pub fn with_listener(listener: Box<Listener<'static>>) -> Self {
        Self { listener: Some(listener), ..Self::silent() }
    }

    pub fn follow(&self, plan: Plan) {
        self.plan.replace(plan);
    }

    pub fn move_on(&self, part: JobStage, done: f64) {
        self.show_at(part, describe_step(part), done);
    }

    pub fn suspend(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }

    fn show_at(&self, part: JobStage, words: &'static str, of_part: f64) {
        let (_, before) = self.shown.get();
        // A new plan may put the same work at a smaller share, and the bar must not move back.
        let steps = ((STEPS * self.plan.borrow().share_done(part, of_part)) as u64).max(before);
        if self.shown.replace((words, steps)) != (words, steps) {
            self.bar.show(words, steps as f64 / STEPS);
        }
    }

    /// Ends the run; returns the seconds of its steps and stages, in order of first appearance.
    pub fn seconds(&mut self) -> Seconds {
        self.end_part();
        let stages = self.stages.iter().map(|(stage, seconds)| (stage.to_string(), (*seconds).into())).collect();
        let of = |part| self.parts.iter().find(|(other, _)| *other == part).map(|(_, seconds)| *seconds);
        let [read, simplify, write, check] = [JobStage::Read, JobStage::Simplify, JobStage::Write, JobStage::Check]
            .map(|part| of(part).unwrap_or_default());
        Seconds { read, simplify, write, check, bake: of(JobStage::Bake), stages }
    }

    fn end_part(&mut self) {
        self.end_stage();
        if let Some((part, began)) = self.current_part.take() {
            add(&mut self.parts, part, began);
        }
    }

    fn end_stage(&mut self) {
        if let Some((stage, began)) = self.current.take() {
            add(&mut self.stages, stage, began);
        }
    }
}

impl Watch for Progress {
    fn begin(&mut self, part: JobStage) {
        self.end_part();
        self.current_part = Some((part, Instant::now()));
        self.move_on(part, 0.0);
    }

    fn event(&mut self, event: Event) -> ControlFlow<()> {
        if self.current.is_none_or(|(stage, _)| stage != event.stage) {
            self.end_stage();
            self.current = Some((event.stage, Instant::now()));
        }
        self.show_at(JobStage::Simplify, describe_stage(event.stage), f64::from(event.total));
        self.listener.as_mut().map_or(ControlFlow::Continue(()), |listener| listener(event))
    }
}

fn add<T: PartialEq>(seconds: &mut Vec<(T, f64)>, of: T, began: Instant) {
    let more = began.elapsed().as_secs_f64();
    match seconds.iter_mut().find(|(other, _)| *other == of) {
        Some((_, total)) => *total += more,
        None => seconds.push((of, more)),
    }
}
