//! What is going on, for the eye and for the report: how far the run is, and the seconds of each stage.

use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use std::time::Instant;

use neural_mesh::job::{Part, Seconds, Watch};
use neural_mesh::simplify::{Event, Listener};

use crate::bar::Bar;
use crate::plan::{Plan, words_of, words_of_part};

/// Steps in which the bar moves; events come every few milliseconds.
const STEPS: f64 = 500.0;

/// A bar that shows itself where work takes longer than a second, and a clock that the library does not have.
pub struct Progress {
    bar: Bar,
    plan: RefCell<Plan>,
    /// What the bar shows, in steps; the bar never goes back.
    shown: Cell<(&'static str, u64)>,
    /// Seconds of each stage of the simplification, and of each part of the run.
    stages: Vec<(&'static str, f64)>,
    parts: Vec<(Part, f64)>,
    current: Option<(&'static str, Instant)>,
    current_part: Option<(Part, Instant)>,
    /// Who else hears of events, and may end the run.
    listener: Option<Box<Listener<'static>>>,
}

impl Progress {
    /// Starts what goes through these parts; nothing is ever said where `quiet`.
    pub fn new(quiet: bool, plan: Plan) -> Self {
        let (plan, shown) = (RefCell::new(plan), Cell::default());
        let (stages, parts) = (Vec::new(), Vec::new());
        let (current, current_part, listener) = (None, None, None);
        Self { bar: Bar::new(quiet), plan, shown, stages, parts, current, current_part, listener }
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

    /// So much of a part is done.
    pub fn move_on(&self, part: Part, done: f64) {
        self.show_at(part, words_of_part(part), done);
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

    /// The run ends: seconds of its parts, and of the stages of the simplification, in the order they came first.
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
        self.show_at(Part::Simplify, words_of(event.stage), f64::from(event.total));
        self.listener.as_mut().map_or(ControlFlow::Continue(()), |listener| listener(event))
    }
}

/// Adds the seconds since something began to those that it took before.
fn add<T: PartialEq>(seconds: &mut Vec<(T, f64)>, of: T, began: Instant) {
    let more = began.elapsed().as_secs_f64();
    match seconds.iter_mut().find(|(other, _)| *other == of) {
        Some((_, total)) => *total += more,
        None => seconds.push((of, more)),
    }
}
