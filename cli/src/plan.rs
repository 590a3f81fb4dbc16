//! Steps of a run with their costs, so that the progress bar moves evenly.

use neural_mesh::io::Format;
use neural_mesh::job::{Goal, JobStage};
use neural_mesh::mesh::TriMesh;
use neural_mesh::simplify::Assembly;

use crate::request::Request;

pub const fn describe_step(step: JobStage) -> &'static str {
    match step {
        JobStage::Read => "reading",
        JobStage::Simplify => "simplifying",
        JobStage::Bake => "baking textures",
        JobStage::Check => "measuring the distance",
        JobStage::Write => "writing",
        JobStage::Picture => "drawing",
    }
}

pub fn describe_stage(stage: &str) -> &'static str {
    match stage {
        "surface" => "analysing the surface",
        "scores" | "sample" => "choosing vertices",
        "collapse" => "merging vertices",
        "flips" | "fit" => "fitting to the original",
        "assign" | "edges" | "faces" => "choosing faces",
        "proof" => "proving the distance",
        "bytes" => "measuring the file",
        "clusters" => "making levels",
        _ => "finishing",
    }
}

/// Ratios of the measured costs: ns per face of a torus of four million faces, on one thread.
const RATIOS: [f64; 3] = [0.02, 0.1, 0.5];
const USUAL_RATIO: f64 = 0.1;
const SIMPLIFY_COSTS: [f64; 3] = [1300.0, 4500.0, 9300.0];
const CHECK_COSTS: [f64; 3] = [900.0, 1600.0, 2900.0];
/// Cost of each further level of detail, relative to the first.
const FURTHER_LEVEL_COST: f64 = 0.2;
const PAPER_COST: f64 = 30_000.0;
/// Typical number of runs in a search, and the share of time they take if distances are proved.
const SEARCH_RUNS: f64 = 3.0;
const SEARCH_SHARE: f64 = 0.4;
const WRITE_COST: f64 = 150.0;
const BAKE_COST: f64 = 50_000.0;
const PICTURE_COST: f64 = 600.0;

#[derive(Clone, Debug)]
pub struct Plan(Vec<(JobStage, f64)>);

impl Plan {
    pub fn new(steps: &[(JobStage, f64)]) -> Self {
        Self(steps.to_vec())
    }

    pub fn estimate(request: &Request, mesh: Option<&TriMesh>) -> Self {
        let n_levels = request.job.goal.n_levels().map_or(1.0, |n| n as f64);
        let ratio = expected_ratio(request, mesh).unwrap_or(USUAL_RATIO).clamp(0.0, 1.0);
        let single_run = match &request.job.options.assembly {
            Assembly::Paper(_) => PAPER_COST,
            Assembly::Closed(_) => interpolate(ratio, SIMPLIFY_COSTS) * (1.0 + FURTHER_LEVEL_COST * (n_levels - 1.0)),
        };
        // A search repeats the run several times, and proofs take most of its time.
        let simplify = match &request.job.goal {
            Goal::Error(_) => single_run * SEARCH_RUNS / SEARCH_SHARE,
            Goal::Bytes(_) => single_run * SEARCH_RUNS,
            Goal::ErrorLevels(_) => n_levels * interpolate(ratio, SIMPLIFY_COSTS) * SEARCH_RUNS / SEARCH_SHARE,
            _ => single_run,
        };
        let cost_if = |is_requested: bool, cost: f64| if is_requested { cost } else { 0.0 };
        Self::new(&[
            (JobStage::Read, reading_cost(request)),
            (JobStage::Simplify, simplify),
            (JobStage::Bake, cost_if(request.job.arguments.bake.is_some(), BAKE_COST * ratio)),
            (JobStage::Check, cost_if(!request.job.arguments.no_check, n_levels * interpolate(ratio, CHECK_COSTS))),
            (JobStage::Write, WRITE_COST * ratio),
            (JobStage::Picture, cost_if(request.picture.is_some(), PICTURE_COST)),
        ])
    }

    /// Returns the finished share of the run when `step_share` of a step is done; 0 for steps outside the plan.
    pub fn share_done(&self, step: JobStage, step_share: f64) -> f64 {
        let all: f64 = self.0.iter().map(|(_, cost)| cost).sum();
        let Some(at) = self.0.iter().position(|(other, _)| *other == step) else { return 0.0 };
        let before: f64 = self.0[..at].iter().map(|(_, cost)| cost).sum();
        (before + self.0[at].1 * step_share.clamp(0.0, 1.0)) / all.max(f64::MIN_POSITIVE)
    }
}

fn expected_ratio(request: &Request, mesh: Option<&TriMesh>) -> Option<f64> {
    if request.job.goal.is_bound() {
        return None;
    }
    let size = *request.job.goal.sizes().first()?;
    size.share().or_else(|| mesh.map(|mesh| size.share_of(mesh.positions().len(), mesh.faces().len())))
}

fn reading_cost(request: &Request) -> f64 {
    let path = Format::without_gz(&request.source.path);
    match Format::from_path(&path) {
        Some(Format::Ply) => 200.0,
        Some(Format::Stl) => 1400.0,
        _ => 600.0,
    }
}

/// Interpolates costs linearly over the logarithm of the ratio.
fn interpolate(ratio: f64, costs: [f64; 3]) -> f64 {
    let i = usize::from(ratio > RATIOS[1]);
    let t = (ratio / RATIOS[i]).max(f64::MIN_POSITIVE).ln() / (RATIOS[i + 1] / RATIOS[i]).ln();
    costs[i] + (costs[i + 1] - costs[i]) * t.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_share_the_run_by_their_costs() {
        let plan = Plan::new(&[
            (JobStage::Read, 1.0),
            (JobStage::Simplify, 6.0),
            (JobStage::Check, 0.0),
            (JobStage::Write, 3.0),
        ]);
        let done = [
            (JobStage::Read, 0.5),
            (JobStage::Simplify, 0.0),
            (JobStage::Simplify, 1.0),
            (JobStage::Check, 0.5),
            (JobStage::Write, 2.0),
        ];
        assert_eq!(done.map(|(step, step_share)| plan.share_done(step, step_share)), [0.05, 0.1, 0.7, 0.7, 1.0]);
    }

    #[test]
    fn costs_are_interpolated_between_measured_ratios() {
        assert_eq!(
            [0.001, 0.02, 0.1, 0.5, 1.0].map(|ratio| interpolate(ratio, [1.0, 3.0, 4.0])),
            [1.0, 1.0, 3.0, 4.0, 4.0]
        );
        let between = interpolate(0.05, [1.0, 3.0, 4.0]);
        assert!(between > 1.0 && between < 3.0);
    }
}
