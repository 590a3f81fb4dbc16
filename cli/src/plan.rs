//! Steps of a run with their costs, so that the progress bar moves evenly.

use neural_mesh::io::Format;
use neural_mesh::job::{Goal, JobStage};
use neural_mesh::mesh::TriMesh;
use neural_mesh::simplify::{Assembly, Target};

use crate::request::Request;

pub const fn describe_step(part: JobStage) -> &'static str {
    match part {
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
        "surface" | "symmetry" => "analysing the surface",
        "scores" | "sample" => "choosing vertices",
        "collapse" => "merging vertices",
        "flips" | "fit" => "fitting to the original",
        "assign" | "edges" | "faces" => "choosing faces",
        "proof" => "proving the distance",
        "bytes" => "measuring the file",
        _ => "finishing",
    }
}

/// Ratios of the measured costs, which are in ns per face of a torus of four million faces, on one thread.
const RATIOS: [f64; 3] = [0.02, 0.1, 0.5];
const USUAL_SHARE: f64 = 0.1;
const SIMPLIFY: [f64; 3] = [1300.0, 4500.0, 9300.0];
const CHECK: [f64; 3] = [900.0, 1600.0, 2900.0];
/// Cost of each further level of detail, relative to the first.
const OF_FURTHER: f64 = 0.2;
const PAPER: f64 = 30_000.0;
/// Typical runs of a search, and their share of the time if distances are proved.
const RUNS: f64 = 3.0;
const PROVED: f64 = 0.4;
const WRITE: f64 = 150.0;
const BAKE: f64 = 50_000.0;
const PICTURE: f64 = 600.0;

#[derive(Clone, Debug)]
pub struct Plan(Vec<(JobStage, f64)>);

impl Plan {
    pub fn new(parts: &[(JobStage, f64)]) -> Self {
        Self(parts.to_vec())
    }

    pub fn estimate(request: &Request, mesh: Option<&TriMesh>) -> Self {
        let n_levels = request.job.goal.n_levels().map_or(1.0, |n| n as f64);
        let ratio = share(request, mesh).unwrap_or(USUAL_SHARE).clamp(0.0, 1.0);
        let once = match request.job.options.assembly {
            Assembly::Paper => PAPER,
            Assembly::Closed => interpolate(ratio, SIMPLIFY) * (1.0 + OF_FURTHER * (n_levels - 1.0)),
        };
        // A search repeats the run several times, and proofs take most of its time.
        let simplify = match request.job.goal {
            Goal::Error(_) => once * RUNS / PROVED,
            Goal::ErrorLevels(_) => n_levels * interpolate(ratio, SIMPLIFY) * RUNS / PROVED,
            Goal::Size(_) => once * RUNS,
            _ => once,
        };
        let given = |is_asked: bool, cost: f64| if is_asked { cost } else { 0.0 };
        Self::new(&[
            (JobStage::Read, reading_cost(request)),
            (JobStage::Simplify, simplify),
            (JobStage::Bake, given(request.job.bake.is_some(), BAKE * ratio)),
            (JobStage::Check, given(request.job.check, n_levels * interpolate(ratio, CHECK))),
            (JobStage::Write, WRITE * ratio),
            (JobStage::Picture, given(request.picture.is_some(), PICTURE)),
        ])
    }

    /// Returns the finished share of the run when `of_part` of a step is done; 0 for steps outside the plan.
    pub fn share_done(&self, part: JobStage, of_part: f64) -> f64 {
        let all: f64 = self.0.iter().map(|(_, cost)| cost).sum();
        let Some(at) = self.0.iter().position(|(other, _)| *other == part) else { return 0.0 };
        let before: f64 = self.0[..at].iter().map(|(_, cost)| cost).sum();
        (before + self.0[at].1 * of_part.clamp(0.0, 1.0)) / all.max(f64::MIN_POSITIVE)
    }
}

fn share(request: &Request, mesh: Option<&TriMesh>) -> Option<f64> {
    match (&request.job.goal, request.job.options.target) {
        (Goal::Error(_) | Goal::ErrorLevels(_) | Goal::Size(_), _) => None,
        (Goal::ShareOfFaces(share), _) => Some(*share),
        (_, Target::Ratio(ratio)) => Some(ratio),
        (_, target) => mesh.map(|mesh| target.share_of(mesh)),
    }
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
    fn parts_share_the_run_by_their_costs() {
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
        assert_eq!(done.map(|(part, of_part)| plan.share_done(part, of_part)), [0.05, 0.1, 0.7, 0.7, 1.0]);
    }

    #[test]
    fn costs_lie_between_those_measured() {
        assert_eq!(
            [0.001, 0.02, 0.1, 0.5, 1.0].map(|ratio| interpolate(ratio, [1.0, 3.0, 4.0])),
            [1.0, 1.0, 3.0, 4.0, 4.0]
        );
        let between = interpolate(0.05, [1.0, 3.0, 4.0]);
        assert!(between > 1.0 && between < 3.0);
    }
}
