//! A convex part of a triangle, with what is known of its distance at its corners.

use glam::DVec3;

/// A plane passes through a part where both sides are thicker than this share of its size.
const LEAST_SHARE: f64 = 1e-6;

/// A corner: where, how far from the other surface at most, and which of its faces is so near, mostly the nearest.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub point: DVec3,
    pub distance: f64,
    pub face: u32,
}

/// A plane by a point of it and its normal.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub point: DVec3,
    pub normal: DVec3,
}

/// The mean of the corners.
pub(super) fn middle(corners: &[Corner]) -> DVec3 {
    corners.iter().map(|corner| corner.point).sum::<DVec3>() / corners.len() as f64
}

/// The largest distance at a corner.
pub(super) fn farthest(corners: &[Corner]) -> f64 {
    corners.iter().map(|corner| corner.distance).fold(0.0, f64::max)
}

/// How far the farthest corner is from this one.
pub(super) fn reach(corners: &[Corner], from: &Corner) -> f64 {
    corners.iter().map(|corner| corner.point.distance_squared(from.point)).fold(0.0, f64::max).sqrt()
}

/// The plane that halves the line between the two corners which are farthest apart.
pub(super) fn across_the_middle(corners: &[Corner]) -> Plane {
    let pairs = (0..corners.len()).flat_map(|i| (0..i).map(move |j| [corners[i].point, corners[j].point]));
    let length2 = |[a, b]: &[DVec3; 2]| a.distance_squared(*b);
    let [a, b] = pairs.max_by(|x, y| length2(x).total_cmp(&length2(y))).unwrap_or_default();
    Plane { point: 0.5 * (a + b), normal: (b - a).normalize_or_zero() }
}

/// The parts above and below a plane; `None` where it does not pass through. `corner_at` says what is known at a corner of the
/// cut.
pub(super) fn halves(
    corners: &[Corner],
    plane: &Plane,
    corner_at: impl Fn(DVec3) -> Corner,
) -> Option<[Vec<Corner>; 2]> {
    let height = |corner: &Corner| (corner.point - plane.point).dot(plane.normal);
    let least = LEAST_SHARE * reach(corners, &corners[0]);
    if !(corners.iter().any(|corner| height(corner) > least) && corners.iter().any(|corner| height(corner) < -least)) {
        return None;
    }
    let mut sides = [Vec::with_capacity(corners.len() + 1), Vec::with_capacity(corners.len() + 1)];
    let nexts = corners.iter().cycle().skip(1);
    for (corner, next) in corners.iter().zip(nexts) {
        let (h, to) = (height(corner), height(next));
        // What lies on the plane belongs to both sides.
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

    fn corner(point: DVec3) -> Corner {
        Corner { point, distance: point.z, face: 0 }
    }

    fn area(corners: &[Corner]) -> f64 {
        let from = corners[0].point;
        corners.windows(2).map(|pair| 0.5 * (pair[0].point - from).cross(pair[1].point - from).length()).sum()
    }

    #[test]
    fn halves_cover_the_whole_and_share_the_cut() {
        let square = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(|p| corner(p.into()));
        let plane = |point: [f64; 3], normal: [f64; 3]| Plane { point: point.into(), normal: normal.into() };
        let slanted = plane([0.5, 0.5, 0.0], [0.8, 0.6, 0.0]);
        let [above, below] = halves(&square, &slanted, corner).unwrap();
        assert!((area(&above) + area(&below) - 2.0).abs() < 1e-12 && (above.len(), below.len()) == (4, 4));
        // Through two corners: no new ones.
        let diagonal = plane([0.0; 3], [1.0, -2.0, 0.0]);
        let [above, below] = halves(&square, &diagonal, |_| unreachable!("no new corner")).unwrap();
        assert_eq!((above.len(), below.len(), area(&above)), (3, 3, 1.0));
        assert!(halves(&square, &plane([0.0; 3], [1.0, 0.0, 0.0]), corner).is_none());
        assert!(halves(&square, &plane([0.0; 3], [0.0; 3]), corner).is_none());
    }

    #[test]
    fn the_longest_line_is_halved() {
        let long = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [1.0, 1.0, 0.0]].map(|p| corner(p.into()));
        let plane = across_the_middle(&long);
        assert_eq!((plane.point, plane.normal.abs()), (DVec3::new(4.0, 0.0, 0.0), DVec3::X));
        assert_eq!(
            (reach(&long, &long[0]), farthest(&long), middle(&long)),
            (8.0, 0.0, DVec3::new(3.0, 1.0 / 3.0, 0.0))
        );
    }
}
