//! What is known of the largest distance so far, and how sharply it has to be known.

/// How sharp the bounds have to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sharpness {
    /// The upper bound may exceed the lower by this share of it.
    pub gap: f64,
    /// Nor need the upper bound be sharper than this distance.
    pub enough: f64,
    /// Once the lower bound exceeds this distance, the search ends with infinity as the upper bound.
    pub too_much: f64,
}

impl Default for Sharpness {
    /// One percent apart, whatever the distance.
    fn default() -> Self {
        Self { gap: 0.01, enough: 0.0, too_much: f64::INFINITY }
    }
}

/// What is known of the largest distance so far.
pub(super) struct Bounds {
    pub lower: f64,
    /// Of all that was put aside.
    pub upper: f64,
    pub asked: Sharpness,
}

impl Bounds {
    /// Whether a triangle with this upper bound need not be cut.
    pub(super) fn allow(&self, upper: f64) -> bool {
        upper <= self.asked.enough.max(self.lower * (1.0 + self.asked.gap))
    }

    pub(super) fn raise_to(&mut self, distance: f64) {
        self.lower = self.lower.max(distance);
    }

    pub(super) fn is_beyond(&self) -> bool {
        self.lower > self.asked.too_much
    }
}
