//! One case, a mesh at a size with a seed: the methods take turns, one at a time, so that what slows the machine for a
//! while slows all of them.

use std::ops::ControlFlow;

use super::Method;
use super::engine::{Asked, Done, Engine, Timed};
use super::limited::{Unfinished, one_line};
use crate::baselines::Size;
use neural_mesh::mesh::TriMesh;

/// What came of a method.
pub(super) struct Outcome {
    /// What it was asked for.
    pub size: Size,
    /// Of each run.
    pub seconds: Vec<f64>,
    /// What they cover.
    pub timed: Option<Timed>,
    /// The result, or why there is none.
    pub result: Result<TriMesh, String>,
}

/// What is asked of all methods.
pub(super) struct Case<'a> {
    pub mesh: &'a TriMesh,
    pub ratio: f64,
    pub seed: u64,
    /// The first method of ours that takes part, whose number of faces the others are given.
    pub leader: Option<&'a Method>,
    /// That number, if it is known already.
    pub n_faces: Option<usize>,
}

impl Case<'_> {
    /// The size for all: a share of the vertices, and as many faces as ours came to, else the same share of them.
    fn size(&self, n_faces: Option<usize>) -> Size {
        let share = |n: usize| ((n as f64 * self.ratio) as usize).max(1);
        let faces = n_faces.unwrap_or_else(|| share(self.mesh.faces().len()));
        Size { vertices: share(self.mesh.positions().len()), faces }
    }
}

/// Runs each of the methods `repeats` times, by turns; a method that fails once is not run again. The outcomes stand in
/// the order of the methods; `None` where `wait`, which hears who is at work, did not want to wait any longer.
pub(super) fn contest(
    engine: &Engine,
    case: &Case,
    methods: &[Method],
    repeats: usize,
    wait: &mut dyn FnMut(&Method, usize) -> ControlFlow<()>,
) -> Option<Vec<Outcome>> {
    let mut n_faces = case.n_faces;
    let mut outcomes: Vec<Option<Outcome>> = methods.iter().map(|_| None).collect();
    for round in 0..repeats.max(1) {
        for at in leader_first(methods, case.leader) {
            let outcome = &mut outcomes[at];
            if matches!(outcome, Some(Outcome { result: Err(_), .. })) {
                continue;
            }
            let size = outcome.as_ref().map_or_else(|| case.size(n_faces), |outcome| outcome.size);
            let asked = Asked { ratio: case.ratio, size, seed: case.seed };
            let method = &methods[at];
            match engine.run(method, &asked, &mut || wait(method, round)) {
                Err(Unfinished::Stopped) => return None,
                Err(Unfinished::Failed(why)) => {
                    *outcome = Some(Outcome { size, seconds: Vec::new(), timed: None, result: Err(one_line(&why)) });
                }
                Ok(done) => {
                    if case.leader == Some(method) {
                        n_faces = Some(done.mesh.faces().len());
                    }
                    add(outcome, size, done);
                }
            }
        }
    }
    outcomes.into_iter().collect()
}

fn add(outcome: &mut Option<Outcome>, size: Size, done: Done) {
    match outcome {
        Some(outcome) => outcome.seconds.push(done.seconds),
        None => {
            let Done { mesh, seconds, timed } = done;
            *outcome = Some(Outcome { size, seconds: vec![seconds], timed: Some(timed), result: Ok(mesh) });
        }
    }
}

/// Indices of the methods, that of the leader first.
fn leader_first(methods: &[Method], leader: Option<&Method>) -> Vec<usize> {
    let is_leader = |&at: &usize| leader == Some(&methods[at]);
    let (leader, others): (Vec<usize>, Vec<usize>) = (0..methods.len()).partition(is_leader);
    [leader, others].concat()
}
