//! One case (mesh, ratio, seed), whose methods run in turns.

use std::ops::ControlFlow;

use super::engine::{Engine, RunResult, RunTarget, TimedScope};
use super::limited::{RunFailure, join_lines};
use super::method::Method;
use crate::baselines::TargetCounts;
use neural_mesh::mesh::TriMesh;

pub(super) struct MethodOutcome {
    pub size: TargetCounts,
    pub seconds: Vec<f64>,
    pub timed: Option<TimedScope>,
    pub result: Result<TriMesh, String>,
}

pub(super) struct ContestCase<'a> {
    pub mesh: &'a TriMesh,
    pub ratio: f64,
    pub seed: u64,
    // The first of our methods, whose resulting number of faces is the target of the others.
    pub leader: Option<&'a Method>,
    pub n_faces: Option<usize>,
}

impl ContestCase<'_> {
    fn size(&self, n_faces: Option<usize>) -> TargetCounts {
        let share = |n: usize| ((n as f64 * self.ratio) as usize).max(1);
        let faces = n_faces.unwrap_or_else(|| share(self.mesh.faces().len()));
        TargetCounts { vertices: share(self.mesh.positions().len()), faces }
    }
}

/// Runs each method once per round, `repeats` rounds; `None` if `wait` breaks.
pub(super) fn run_case(
    engine: &Engine,
    case: &ContestCase,
    methods: &[Method],
    repeats: usize,
    wait: &mut dyn FnMut(&Method, usize) -> ControlFlow<()>,
) -> Option<Vec<MethodOutcome>> {
    let mut n_faces = case.n_faces;
    let mut outcomes: Vec<Option<MethodOutcome>> = methods.iter().map(|_| None).collect();
    // Turns let a slow spell of the machine affect all methods.
    for round in 0..repeats.max(1) {
        for at in leader_first(methods, case.leader) {
            let outcome = &mut outcomes[at];
            // A method that failed is not run again and keeps its first error.
            if matches!(outcome, Some(MethodOutcome { result: Err(_), .. })) {
                continue;
            }
            let size = outcome.as_ref().map_or_else(|| case.size(n_faces), |outcome| outcome.size);
            let target = RunTarget { ratio: case.ratio, size, seed: case.seed };
            let method = &methods[at];
            match engine.run(method, &target, &mut || wait(method, round)) {
                Err(RunFailure::Stopped) => return None,
                Err(RunFailure::Failed(why)) => {
                    *outcome =
                        Some(MethodOutcome { size, seconds: Vec::new(), timed: None, result: Err(join_lines(&why)) });
                }
                Ok(done) => {
                    // The leader's number of faces is the target of all methods that follow.
                    if case.leader == Some(method) {
                        n_faces = Some(done.mesh.faces().len());
                    }
                    add_run(outcome, size, done);
                }
            }
        }
    }
    outcomes.into_iter().collect()
}

fn add_run(outcome: &mut Option<MethodOutcome>, size: TargetCounts, done: RunResult) {
    match outcome {
        Some(outcome) => outcome.seconds.push(done.seconds),
        None => {
            let RunResult { mesh, seconds, timed } = done;
            *outcome = Some(MethodOutcome { size, seconds: vec![seconds], timed: Some(timed), result: Ok(mesh) });
        }
    }
}

fn leader_first(methods: &[Method], leader: Option<&Method>) -> Vec<usize> {
    let is_leader = |&at: &usize| leader == Some(&methods[at]);
    let (leader, others): (Vec<usize>, Vec<usize>) = (0..methods.len()).partition(is_leader);
    [leader, others].concat()
}
