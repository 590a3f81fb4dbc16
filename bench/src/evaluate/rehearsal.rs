//! A trial of each tool on a small mesh.

use std::ops::ControlFlow;

use super::engine::{Engine, RunTarget};
use super::limited::RunFailure;
use super::{EvaluateError, Method, Tool};
use crate::baselines::Size;
use neural_mesh::mesh::shapes;

const RATIO: f64 = 0.5;

/// Runs each tool once on a ball; breaks when `wait` does.
pub(super) fn try_each(
    engine: &Engine,
    tools: &[&Tool],
    wait: &mut dyn FnMut(&Tool) -> ControlFlow<()>,
) -> Result<ControlFlow<()>, EvaluateError> {
    let ball = shapes::icosphere(3);
    let share = |n: usize| (RATIO * n as f64) as usize;
    let size = Size { vertices: share(ball.positions().len()), faces: share(ball.faces().len()) };
    let target = RunTarget { ratio: RATIO, size, seed: 0 };
    for &tool in tools {
        let method = Method::Tool(tool.clone());
        let prepared = engine.prepare(&ball, std::slice::from_ref(&method)).map_err(RunFailure::Failed);
        match prepared.and_then(|()| engine.run(&method, &target, &mut || wait(tool))) {
            Ok(_) => {}
            Err(RunFailure::Stopped) => return Ok(ControlFlow::Break(())),
            Err(RunFailure::Failed(why)) => {
                let n = ball.positions().len();
                let what = format!("tool {}: {why}: tried on a ball of {n} vertices: correct its command", tool.name);
                return Err(EvaluateError::Tool(what));
            }
        }
    }
    Ok(ControlFlow::Continue(()))
}
