//! Results of the simplifier before they are measured.

use crate::io::PackOptions;
use crate::metrics::CertifiedDistance;
use crate::simplify::Simplified;

use super::report::NamedShare;
use super::request::Job;

/// Results and what is known about them.
pub(super) struct Lighter {
    /// One result, or one per level of detail.
    pub results: Vec<Simplified>,
    /// Proved distance of each, if an error was given.
    pub certified: Vec<CertifiedDistance>,
    /// Remark about the search.
    pub note: Option<&'static str>,
    /// Packing for the results.
    pub pack: Option<PackOptions>,
    /// Results of named shares.
    pub named: Vec<NamedShare>,
}

impl Lighter {
    /// Makes results about which nothing else is known.
    pub fn of(results: Vec<Simplified>, job: &Job) -> Self {
        Self { results, certified: Vec::new(), note: None, pack: job.compress, named: Vec::new() }
    }
}
