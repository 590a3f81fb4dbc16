//! Range of a chart's axis.

/// Returns the range of positive values on an axis; `margin` is the factor above the largest.
pub fn axis_range(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, 0.0), |(low, high), value| (value.min(low), value.max(high)));
    (low / 1.3, high * margin)
}
