//! Results of the simplifier before they are measured.

use crate::io::PackOptions;
use crate::metrics::CertifiedDistance;
use crate::simplify::Simplified;

use super::report::NamedShare;
use super::request::Job;

pub(super) struct SimplifiedResults {
    pub results: Vec<Simplified>,
    // Proved distance of each result, if the goal is a distance.
    pub certified: Vec<CertifiedDistance>,
    pub note: Option<&'static str>,
    pub pack: Option<PackOptions>,
    pub named: Vec<NamedShare>,
}

impl SimplifiedResults {
    pub fn new(results: Vec<Simplified>, job: &Job) -> Self {
        Self { results, certified: Vec::new(), note: None, pack: job.arguments.packing(), named: Vec::new() }
    }

    /// Removes levels as large as the one before, which gets their outcome; returns a line that names their sizes.
    pub fn leave_out_repeats(&mut self, sizes: &[String]) -> Option<String> {
        let count = |result: &Simplified| [result.mesh.positions().len(), result.mesh.faces().len()];
        let (mut left_out, mut repeated) = (Vec::new(), None);
        let mut results: Vec<Simplified> = Vec::new();
        for (i, result) in std::mem::take(&mut self.results).into_iter().enumerate() {
            let Some(last) = results.last_mut().filter(|last| count(last) == count(&result)) else {
                results.push(result);
                continue;
            };
            repeated = Some(count(last));
            last.report.outcome = result.report.outcome;
            if results.len() < self.certified.len() {
                self.certified.remove(results.len());
            }
            left_out.extend(sizes.get(i).cloned());
        }
        self.results = results;
        let ([n_vertices, n_faces], sizes) = (repeated?, left_out.join(", "));
        Some(format!("levels left out: {sizes}: they repeat the one of {n_vertices} vertices, {n_faces} faces"))
    }
}
