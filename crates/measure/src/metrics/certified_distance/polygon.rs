//! Convex polygons within a face.

use glam::DVec3;

/// Least thickness on both sides of a cut, relative to the polygon's size.
const MIN_THICKNESS: f64 = 1e-6;

/// A corner, an upper bound of its distance to the target, and the face that gives it.
#[derive(Clone, Copy, Default)]
pub(super) struct PolygonCorner {
    pub point: DVec3,
    pub distance: f64,
    pub face: u32,
}

#[derive(Clone, Copy)]
pub(super) struct CutPlane {
    pub point: DVec3,
    pub normal: DVec3,
}

pub(super) fn middle(corners: &[PolygonCorner]) -> DVec3 {
    corners.iter().map(|corner| corner.point).sum::<DVec3>() / corners.len() as f64
}

pub(super) fn largest_corner_distance(corners: &[PolygonCorner]) -> f64 {
    corners.iter().map(|corner| corner.distance).fold(0.0, f64::max)
}

pub(super) fn radius_from(corners: &[PolygonCorner], from: &PolygonCorner) -> f64 {
    corners.iter().map(|corner| corner.point.distance_squared(from.point)).fold(0.0, f64::max).sqrt()
}

pub(super) fn bisecting_plane(corners: &[PolygonCorner]) -> CutPlane {
    let pairs = (0..corners.len()).flat_map(|i| (0..i).map(move |j| [corners[i].point, corners[j].point]));
    let length2 = |[a, b]: &[DVec3; 2]| a.distance_squared(*b);
    let [a, b] = pairs.max_by(|x, y| length2(x).total_cmp(&length2(y))).unwrap_or_default();
    CutPlane { point: 0.5 * (a + b), normal: (b - a).normalize_or_zero() }
}

/// Splits a polygon at a plane; `None` if a side would be too thin.
pub(super) fn split_polygon(
    corners: &[PolygonCorner],
    plane: &CutPlane,
    corner_at: impl Fn(DVec3) -> PolygonCorner,
) -> Option<[Vec<PolygonCorner>; 2]> {
    let height = |corner: &PolygonCorner| (corner.point - plane.point).dot(plane.normal);
    let least = MIN_THICKNESS * radius_from(corners, &corners[0]);
    if !(corners.iter().any(|corner| height(corner) > least) && corners.iter().any(|corner| height(corner) < -least)) {
        return None;
    }
    let mut sides = [Vec::with_capacity(corners.len() + 1), Vec::with_capacity(corners.len() + 1)];
    let nexts = corners.iter().cycle().skip(1);
    for (corner, next) in corners.iter().zip(nexts) {
        let (h, to) = (height(corner), height(next));
        // Corners on the plane belong to both sides.
        for (side, up) in sides.iter_mut().zip([h, -h]) {
            if up >= -least {
                side.push(*corner);
            }
        }
        if h.abs() > least && to.abs() > least && (h > 0.0) != (to > 0.0) {
            let new = corner_at(corner.point.lerp(next.point, h / (h - to)));
            sides.iter_mut().for_each(|side| side.push(new));
        }
    }
    Some(sides)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(point: DVec3) -> PolygonCorner {
        PolygonCorner { point, distance: point.z, face: 0 }
    }

    fn area(corners: &[PolygonCorner]) -> f64 {
        let from = corners[0].point;
        corners.windows(2).map(|pair| 0.5 * (pair[0].point - from).cross(pair[1].point - from).length()).sum()
    }

    #[test]
    fn halves_cover_the_whole_and_share_the_cut() {
        let square = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(|p| corner(p.into()));
        let plane = |point: [f64; 3], normal: [f64; 3]| CutPlane { point: point.into(), normal: normal.into() };
        let slanted = plane([0.5, 0.5, 0.0], [0.8, 0.6, 0.0]);
        let [above, below] = split_polygon(&square, &slanted, corner).unwrap();
        assert!((area(&above) + area(&below) - 2.0).abs() < 1e-12 && (above.len(), below.len()) == (4, 4));
        // A cut through two corners makes no new ones.
        let diagonal = plane([0.0; 3], [1.0, -2.0, 0.0]);
        let [above, below] = split_polygon(&square, &diagonal, |_| unreachable!("no new corner")).unwrap();
        assert_eq!((above.len(), below.len(), area(&above)), (3, 3, 1.0));
        assert!(split_polygon(&square, &plane([0.0; 3], [1.0, 0.0, 0.0]), corner).is_none());
        assert!(split_polygon(&square, &plane([0.0; 3], [0.0; 3]), corner).is_none());
    }

    #[test]
    fn the_longest_line_is_halved() {
        let long = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [1.0, 1.0, 0.0]].map(|p| corner(p.into()));
        let plane = bisecting_plane(&long);
        assert_eq!((plane.point, plane.normal.abs()), (DVec3::new(4.0, 0.0, 0.0), DVec3::X));
        assert_eq!(
            (radius_from(&long, &long[0]), largest_corner_distance(&long), middle(&long)),
            (8.0, 0.0, DVec3::new(3.0, 1.0 / 3.0, 0.0))
        );
    }
}
