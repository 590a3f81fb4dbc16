//! The median of some figures, and how far they lie apart.

/// Median, least and largest.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    pub median: f64,
    pub low: f64,
    pub high: f64,
}

impl Spread {
    /// Of some figures; all zero where there are none. Of an even number, the mean of the middle two.
    pub fn of(mut figures: Vec<f64>) -> Self {
        figures.sort_by(f64::total_cmp);
        let (Some(&low), Some(&high)) = (figures.first(), figures.last()) else { return Self::default() };
        let n = figures.len();
        Self { median: 0.5 * (figures[(n - 1) / 2] + figures[n / 2]), low, high }
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.2} ({:.2} to {:.2})", self.median, self.low, self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn the_median_lies_in_the_middle() {
        let spread = Spread::of(vec![3.0, 1.0, 10.0, 2.0]);
        assert_eq!((spread.median, spread.low, spread.high), (2.5, 1.0, 10.0));
        assert_eq!(Spread::of(vec![7.0]).to_string(), "7.00 (7.00 to 7.00)");
    }
}
