//! What is going on, for the eye and for the report: how far the run is, and the seconds of each stage.

use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use std::time::Instant;

use neural_mesh::simplify::{Event, Listener};

use crate::bar::Bar;
use crate::plan::{Part, Plan, words_of};

/// Steps in which the bar moves; events come every few milliseconds.
const STEPS: f64 = 500.0;

/// A bar that shows itself where work takes longer than a second, and a clock that the library does not have.
pub struct Progress {
    bar: Bar,
    plan: RefCell<Plan>,
    /// What the bar shows, in steps; the bar never goes back.
    shown: Cell<(&'static str, u64)>,
    stages: Vec<(&'static str, f64)>,
    current: Option<(&'static str, Instant)>,
    /// Who else hears of events, and may end the run.
    listener: Option<Box<Listener<'static>>>,
}

impl Progress {
    /// Starts what goes through these parts; nothing is ever said where `quiet`.
    pub fn new(quiet: bool, plan: Plan) -> Self {
        let (plan, shown) = (RefCell::new(plan), Cell::default());
        Self { bar: Bar::new(quiet), plan, shown, stages: Vec::new(), current: None, listener: None }
    }

    /// Says nothing.
    pub fn silent() -> Self {
        Self::new(true, Plan::new(&[]))
    }

    /// Says nothing; what the simplification tells goes to a listener, too.
    pub fn heard_by(listener: Box<Listener<'static>>) -> Self {
        Self { listener: Some(listener), ..Self::silent() }
    }

    /// Parts cost something else than was thought.
    pub fn follow(&self, plan: Plan) {
        self.plan.replace(plan);
    }

    /// A stage of the simplification begins or moves on.
    pub fn event(&mut self, event: Event) -> ControlFlow<()> {
        if self.current.is_none_or(|(stage, _)| stage != event.stage) {
            self.end_stage();
            self.current = Some((event.stage, Instant::now()));
        }
        self.show_at(Part::Simplify, words_of(event.stage), f64::from(event.total));
        self.listener.as_mut().map_or(ControlFlow::Continue(()), |listener| listener(event))
    }

    /// A part of the run begins.
    pub fn show(&self, part: Part) {
        self.move_on(part, 0.0);
    }

    /// So much of a part is done.
    pub fn move_on(&self, part: Part, done: f64) {
        self.show_at(part, part.words(), done);
    }

    /// Says something where the bar stands.
    pub fn aside(&self, say: impl FnOnce()) {
        self.bar.aside(say);
    }

    /// Moves the bar, if there is something to see.
    fn show_at(&self, part: Part, words: &'static str, of_part: f64) {
        let (_, before) = self.shown.get();
        let steps = ((STEPS * self.plan.borrow().done(part, of_part)) as u64).max(before);
        if self.shown.replace((words, steps)) != (words, steps) {
            self.bar.show(words, steps as f64 / STEPS);
        }
    }

    /// The simplification ends: seconds of its stages, in the order they came first.
    pub fn take_stages(&mut self) -> Vec<(&'static str, f64)> {
        self.end_stage();
        std::mem::take(&mut self.stages)
    }

    fn end_stage(&mut self) {
        let Some((stage, began)) = self.current.take() else { return };
        let seconds = began.elapsed().as_secs_f64();
        match self.stages.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, total)) => *total += seconds,
            None => self.stages.push((stage, seconds)),
        }
    }
}
