//! Progress of a run for the terminal, and the seconds of its stages for the report.

use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use std::time::Instant;

use neural_mesh::job::{Part, Seconds, Watch};
use neural_mesh::simplify::{Event, Listener};

use crate::bar::Bar;
use crate::plan::{Plan, describe_stage, describe_step};

/// Steps of the bar; events arrive every few milliseconds.
const STEPS: f64 = 500.0;

/// A progress bar and the clock of a run.
pub struct Progress {
    bar: Bar,
    plan: RefCell<Plan>,
    /// Position of the bar in steps; it never moves back.
    shown: Cell<(&'static str, u64)>,
    /// Seconds of each stage of the simplification, and of each step of the run.
    stages: Vec<(&'static str, f64)>,
    parts: Vec<(Part, f64)>,
    current: Option<(&'static str, Instant)>,
    current_part: Option<(Part, Instant)>,
    /// Another listener, which may stop the run.
    listener: Option<Box<Listener<'static>>>,
}

impl Progress {
    /// Starts a run with a plan; with `quiet` nothing is printed.
    pub fn new(quiet: bool, plan: Plan) -> Self {
        let (plan, shown) = (RefCell::new(plan), Cell::default());
        let (stages, parts) = (Vec::new(), Vec::new());
        let (current, current_part, listener) = (None, None, None);
        Self { bar: Bar::new(quiet), plan, shown, stages, parts, current, current_part, listener }
    }

    /// Starts a run without output.
    pub fn silent() -> Self {
        Self::new(true, Plan::new(&[]))
    }

    /// Starts a run without output whose events also go to a listener.
    pub fn with_listener(listener: Box<Listener<'static>>) -> Self {
        Self { listener: Some(listener), ..Self::silent() }
    }

    /// Replaces the plan when costs are better known.
    pub fn follow(&self, plan: Plan) {
        self.plan.replace(plan);
    }

    /// Shows that the share `done` of a step is done.
    pub fn move_on(&self, part: Part, done: f64) {
        self.show_at(part, describe_step(part), done);
    }

    /// Runs `say` with the bar hidden.
    pub fn suspend(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }

    /// Moves the bar if the change is visible.
    fn show_at(&self, part: Part, words: &'static str, of_part: f64) {
        let (_, before) = self.shown.get();
        // A new plan may put the same work at a smaller share, and the bar must not move back.
        let steps = ((STEPS * self.plan.borrow().share_done(part, of_part)) as u64).max(before);
        if self.shown.replace((words, steps)) != (words, steps) {
            self.bar.show(words, steps as f64 / STEPS);
        }
    }

    /// Ends the run and returns the seconds of its steps and stages, in order of first appearance.
    pub fn seconds(&mut self) -> Seconds {
        self.end_part();
        let stages = self.stages.iter().map(|(stage, seconds)| (stage.to_string(), (*seconds).into())).collect();
        let of = |part| self.parts.iter().find(|(other, _)| *other == part).map(|(_, seconds)| *seconds);
        let [read, simplify, write, check] =
            [Part::Read, Part::Simplify, Part::Write, Part::Check].map(|part| of(part).unwrap_or_default());
        Seconds { read, simplify, write, check, bake: of(Part::Bake), stages }
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
    fn begin(&mut self, part: Part) {
        self.end_part();
        self.current_part = Some((part, Instant::now()));
        self.move_on(part, 0.0);
    }

    fn event(&mut self, event: Event) -> ControlFlow<()> {
        if self.current.is_none_or(|(stage, _)| stage != event.stage) {
            self.end_stage();
            self.current = Some((event.stage, Instant::now()));
        }
        self.show_at(Part::Simplify, describe_stage(event.stage), f64::from(event.total));
        self.listener.as_mut().map_or(ControlFlow::Continue(()), |listener| listener(event))
    }
}

/// Adds the seconds since `began` to the total of a step or stage.
fn add<T: PartialEq>(seconds: &mut Vec<(T, f64)>, of: T, began: Instant) {
    let more = began.elapsed().as_secs_f64();
    match seconds.iter_mut().find(|(other, _)| *other == of) {
        Some((_, total)) => *total += more,
        None => seconds.push((of, more)),
    }
}
