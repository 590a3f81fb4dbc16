//! Progress of a run, and the seconds of its stages.

use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use std::time::Instant;

use neural_mesh::job::{JobStage, Seconds, Watch};
use neural_mesh::simplify::{Event, Listener};

use crate::bar::Bar;
use crate::plan::{Plan, describe_stage, describe_step};

const BAR_STEPS: f64 = 500.0;

pub struct Progress {
    bar: Bar,
    plan: RefCell<Plan>,
    /// Text and position of the bar; the position, in steps, never falls.
    shown: Cell<(&'static str, u64)>,
    stages: Vec<(&'static str, f64)>,
    steps: Vec<(JobStage, f64)>,
    current: Option<(&'static str, Instant)>,
    current_step: Option<(JobStage, Instant)>,
    listener: Option<Box<Listener<'static>>>,
}

impl Progress {
    pub fn new(quiet: bool, plan: Plan) -> Self {
        let (plan, shown) = (RefCell::new(plan), Cell::default());
        let (stages, steps) = (Vec::new(), Vec::new());
        let (current, current_step, listener) = (None, None, None);
        Self { bar: Bar::new(quiet), plan, shown, stages, steps, current, current_step, listener }
    }

    pub fn silent() -> Self {
        Self::new(true, Plan::new(&[]))
    }

    /// Starts a run without output that forwards events to a listener.
    pub fn with_listener(listener: Box<Listener<'static>>) -> Self {
        Self { listener: Some(listener), ..Self::silent() }
    }

    pub fn set_plan(&self, plan: Plan) {
        self.plan.replace(plan);
    }

    pub fn show_step_done(&self, step: JobStage, done: f64) {
        self.show_at(step, describe_step(step), done);
    }

    pub fn suspend(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    fn show_at(&self, step: JobStage, activity: &'static str, step_share: f64) {
        let (_, before) = self.shown.get();
        // A new plan may give finished work a smaller share, but the bar must not move back.
        let steps = ((BAR_STEPS * self.plan.borrow().share_done(step, step_share)) as u64).max(before);
        if self.shown.replace((activity, steps)) != (activity, steps) {
            self.bar.show(activity, steps as f64 / BAR_STEPS);
        }
    }

    /// Ends the run; returns the seconds of its steps and stages, in order of first appearance.
    pub fn seconds(&mut self) -> Seconds {
        self.end_step();
        let stages = self.stages.iter().map(|(stage, seconds)| (stage.to_string(), (*seconds).into())).collect();
        let seconds_of = |step| self.steps.iter().find(|(other, _)| *other == step).map(|(_, seconds)| *seconds);
        let [read, simplify, write, check] = [JobStage::Read, JobStage::Simplify, JobStage::Write, JobStage::Check]
            .map(|step| seconds_of(step).unwrap_or_default());
        let [bake, picture] = [JobStage::Bake, JobStage::Picture].map(seconds_of);
        Seconds { read, simplify, write, check, bake, picture, stages }
    }

    fn end_step(&mut self) {
        self.end_stage();
        if let Some((step, began)) = self.current_step.take() {
            add_seconds(&mut self.steps, step, began);
        }
    }

    fn end_stage(&mut self) {
        if let Some((stage, began)) = self.current.take() {
            add_seconds(&mut self.stages, stage, began);
        }
    }
}

impl Watch for Progress {
    fn begin(&mut self, step: JobStage) {
        self.end_step();
        self.current_step = Some((step, Instant::now()));
        self.show_step_done(step, 0.0);
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

fn add_seconds<T: PartialEq>(seconds: &mut Vec<(T, f64)>, key: T, began: Instant) {
    let elapsed = began.elapsed().as_secs_f64();
    match seconds.iter_mut().find(|(other, _)| *other == key) {
        Some((_, total)) => *total += elapsed,
        None => seconds.push((key, elapsed)),
    }
}
