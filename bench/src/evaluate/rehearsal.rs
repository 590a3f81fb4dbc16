//! Each tool once on a small mesh before anything is measured: a wrong command is said at once and not in a row for every case.

use std::ops::ControlFlow;

use super::engine::{Asked, Engine};
use super::limited::Unfinished;
use super::{EvaluateError, Method, Tool};
use crate::baselines::Size;
use neural_mesh::mesh::shapes;

/// Share of the vertices that are asked for.
const RATIO: f64 = 0.5;

/// Runs each tool once on a ball, to half of its vertices. It breaks where `wait`, which hears who is at work, does.
///
/// # Errors
/// [`EvaluateError::Tool`] for the first one that fails, takes too long, or leaves no mesh.
pub(super) fn rehearse(
    engine: &Engine,
    tools: &[&Tool],
    wait: &mut dyn FnMut(&Tool) -> ControlFlow<()>,
) -> Result<ControlFlow<()>, EvaluateError> {
    let ball = shapes::icosphere(3);
    let share = |n: usize| (RATIO * n as f64) as usize;
    let size = Size { vertices: share(ball.positions().len()), faces: share(ball.faces().len()) };
    let asked = Asked { ratio: RATIO, size, seed: 0 };
    for &tool in tools {
        let method = Method::Tool(tool.clone());
        let prepared = engine.prepare(&ball, std::slice::from_ref(&method)).map_err(Unfinished::Failed);
        match prepared.and_then(|()| engine.run(&method, &asked, &mut || wait(tool))) {
            Ok(_) => {}
            Err(Unfinished::Stopped) => return Ok(ControlFlow::Break(())),
            Err(Unfinished::Failed(why)) => {
                let n = ball.positions().len();
                let what = format!("tool {}: {why}: tried on a ball of {n} vertices: correct its command", tool.name);
                return Err(EvaluateError::Tool(what));
            }
        }
    }
    Ok(ControlFlow::Continue(()))
}
