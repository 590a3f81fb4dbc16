//! Ranges of distances at which levels are visible.

use bevy_camera::visibility::VisibilityRange;

/// Returns the range of each level: level `i` fades in from `starts[i]` on, while the level before fades out.
///
/// The first level is visible from distance 0. A fade takes the share `fade` of its start: with 0.1, from 20 to 22. If a
/// start is before the end of the fade before, it moves to that end; so ranges neither overlap outside of fades nor leave
/// gaps. The last level vanishes from `end` on, or never.
///
/// ```
/// use neural_mesh_bevy::visibility_ranges;
/// let ranges = visibility_ranges(&[0.0, 20.0, 60.0], 0.25, None);
/// assert_eq!((&ranges[0].end_margin, &ranges[1].start_margin), (&(20.0..25.0), &(20.0..25.0)));
/// assert_eq!(ranges[1].end_margin, 60.0..75.0);
/// assert!(ranges[2].is_visible_at_all(1e6));
/// ```
pub fn visibility_ranges(starts: &[f32], fade: f32, end: Option<f32>) -> Vec<VisibilityRange> {
    let fade = fade.max(0.0);
    let mut margins = vec![0.0..0.0];
    let mut before = 0.0f32;
    for start in starts.iter().copied().skip(1).chain(end) {
        let start = start.max(before);
        before = start * (1.0 + fade);
        margins.push(start..before);
    }
    if end.is_none() {
        // Not infinity, which shaders need not know.
        margins.push(f32::MAX..f32::MAX);
    }
    let range = |pair: &[std::ops::Range<f32>]| VisibilityRange {
        start_margin: pair[0].clone(),
        end_margin: pair[1].clone(),
        // The boxes of levels differ, and with them the distances: the fade of one would not be that of the next.
        use_aabb: false,
    };
    margins.windows(2).map(range).take(starts.len()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the number of levels that are visible at a distance.
    fn n_visible(ranges: &[VisibilityRange], distance: f32) -> usize {
        ranges.iter().filter(|range| range.is_visible_at_all(distance)).count()
    }

    #[test]
    fn every_distance_has_one_level_or_two_that_fade() {
        let starts = [0.0, 3.0, 3.1, 3.2, 40.0, 39.0];
        let ranges = visibility_ranges(&starts, 0.2, None);
        assert_eq!(ranges.len(), starts.len());
        for pair in ranges.windows(2) {
            assert_eq!(pair[0].end_margin, pair[1].start_margin);
        }
        for range in &ranges {
            assert!(range.start_margin.end <= range.end_margin.start, "{range:?}", range = range.start_margin);
        }
        for step in 0..1000 {
            let distance = 0.1 * step as f32;
            let fades = ranges.iter().any(|range| range.end_margin.contains(&distance));
            assert_eq!(n_visible(&ranges, distance), if fades { 2 } else { 1 }, "at {distance}");
        }
    }

    #[test]
    fn the_last_level_vanishes_where_it_should() {
        let ranges = visibility_ranges(&[0.0, 10.0], 0.1, Some(100.0));
        assert_eq!((n_visible(&ranges, 99.0), n_visible(&ranges, 111.0)), (1, 0));
        let abrupt = visibility_ranges(&[0.0, 10.0], 0.0, None);
        assert!(abrupt.iter().all(VisibilityRange::is_abrupt));
        assert_eq!((n_visible(&abrupt, 9.99), n_visible(&abrupt, 10.0)), (1, 1));
        assert!(visibility_ranges(&[], 0.1, None).is_empty());
    }
}
