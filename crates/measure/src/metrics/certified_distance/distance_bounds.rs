//! Bounds of the largest distance, and their tolerance.

/// Tolerance of a [`CertifiedDistance`](super::CertifiedDistance).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceTolerance {
    /// Accepted excess of the upper bound over the lower, as a share of the lower.
    pub gap: f64,
    /// Upper bound, in the mesh's unit, that need not be tightened further.
    pub enough: f64,
    /// Lower bound, in the mesh's unit, above which the search ends; the upper bound is then infinite.
    pub too_much: f64,
}

impl Default for DistanceTolerance {
    fn default() -> Self {
        Self { gap: 0.01, enough: 0.0, too_much: f64::INFINITY }
    }
}

pub(super) struct DistanceBounds {
    pub lower: f64,
    /// Largest upper bound of the polygons that need no further cut.
    pub upper: f64,
    pub tolerance: DistanceTolerance,
}

impl DistanceBounds {
    pub(super) fn is_tight_enough(&self, upper: f64) -> bool {
        upper <= self.tolerance.enough.max(self.lower * (1.0 + self.tolerance.gap))
    }

    pub(super) fn raise_lower(&mut self, distance: f64) {
        self.lower = self.lower.max(distance);
    }

    pub(super) fn is_too_far(&self) -> bool {
        self.lower > self.tolerance.too_much
    }
}
