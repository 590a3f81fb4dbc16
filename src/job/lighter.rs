//! Results of the simplifier, before they are measured.

use crate::io::PackOptions;
use crate::metrics::CertifiedDistance;
use crate::simplify::Simplified;

use super::report::NamedShare;
use super::request::Job;

/// Results, and what else is known of them.
pub(super) struct Lighter {
    /// One, or one for each level of detail.
    pub results: Vec<Simplified>,
    /// A proof for each, where distances were asked for.
    pub certified: Vec<CertifiedDistance>,
    /// What a search could not look at.
    pub note: Option<&'static str>,
    /// How numbers are to be packed.
    pub pack: Option<PackOptions>,
    /// What became of names with shares of their own.
    pub named: Vec<NamedShare>,
}

impl Lighter {
    /// Results of which nothing else is known.
    pub fn of(results: Vec<Simplified>, job: &Job) -> Self {
        Self { results, certified: Vec::new(), note: None, pack: job.compress, named: Vec::new() }
    }
}
