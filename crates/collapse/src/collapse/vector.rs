//! Vectors of three numbers, one at a time.

pub(crate) type Point = [f32; 3];

pub(crate) type Point64 = [f64; 3];

#[inline(always)]
pub(crate) fn subtract(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(crate) fn dot(a: Point, b: Point) -> f32 {
    a[0] * b[0] + (a[1] * b[1] + a[2] * b[2])
}

#[inline(always)]
pub(crate) fn scale(a: Point, t: f32) -> Point {
    [t * a[0], t * a[1], t * a[2]]
}

/// Returns the squared distance of `point` from the segment between the origin and `end`.
pub(crate) fn squared_distance_to_segment(point: Point, end: Point) -> f32 {
    let t = (dot(end, point) / dot(end, end).max(1e-37)).clamp(0.0, 1.0);
    let rest = [point[0] - t * end[0], point[1] - t * end[1], point[2] - t * end[2]];
    dot(rest, rest)
}
