//! Ratios of figures and their medians.

use crate::row::Row;

/// A figure that both methods have; smaller is better.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    Mean,
    Rms,
    Hausdorff,
    NormalError,
    Time,
}

impl Figure {
    pub const ALL: [Self; 5] = [Self::Mean, Self::Rms, Self::Hausdorff, Self::NormalError, Self::Time];

    pub fn title(self) -> &'static str {
        match self {
            Self::Mean => "distance, mean",
            Self::Rms => "distance, root mean square",
            Self::Hausdorff => "Hausdorff",
            Self::NormalError => "normal error",
            Self::Time => "time",
        }
    }

    pub fn of(self, row: &Row) -> f64 {
        match self {
            Self::Mean => row.mean,
            Self::Rms => row.rms,
            Self::Hausdorff => row.hausdorff,
            Self::NormalError => row.normal_error,
            Self::Time => row.seconds,
        }
    }

    /// Below this a figure is rounding noise and counts as this much: `f32` coordinates, or a timer's tick.
    fn floor(self) -> f64 {
        match self {
            Self::Mean | Self::Rms | Self::Hausdorff => 1e-7,
            Self::NormalError | Self::Time => 1e-6,
        }
    }

    /// Our figure over theirs.
    pub fn ratio(self, ours: &Row, theirs: &Row) -> f64 {
        self.of(ours).max(self.floor()) / self.of(theirs).max(self.floor())
    }
}

/// The value below which a share of the values lies, in line between neighbours; `None` for no values.
pub fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let place = share * (values.len().checked_sub(1)? as f64);
    let (low, high) = (values[place.floor() as usize], values[place.ceil() as usize]);
    Some(low + (high - low) * place.fract())
}

pub fn median(values: Vec<f64>) -> Option<f64> {
    quantile(values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(quantile(vec![0.0, 10.0], 0.9), Some(9.0));
        assert_eq!(median(Vec::new()), None);
    }

    #[test]
    fn what_is_lossless_on_both_sides_is_equal() {
        let row = |mean| Row { mean, ..Row::default() };
        assert_eq!(Figure::Mean.ratio(&row(1e-9), &row(0.0)), 1.0);
        assert_eq!(Figure::Mean.ratio(&row(2e-4), &row(1e-4)), 2.0);
    }
}
