//! Faces from which the ball starts, and its rolling over open edges.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use glam::DVec3;

use super::ball::Ball;
use super::sheet::Sheet;

// A turn that ends less than this angle, in radians, behind its start counts as no turn: rounding made it.
const BACKWARD: f64 = 1e-3;

// Free points nearest to one that are tried for its first face.
const SEED_POINTS: usize = 32;

// The face is on the left of the edge.
pub(super) struct OpenEdge {
    edge: [u32; 2],
    opposite: u32,
    center: DVec3,
}

#[derive(Clone, Copy)]
pub(super) struct RestingBall {
    pub(super) face: [u32; 3],
    pub(super) center: DVec3,
}

pub(super) fn roll(ball: &Ball, sheet: &mut Sheet, mut front: VecDeque<OpenEdge>) {
    while let Some(open) = front.pop_front() {
        if sheet.is_open(open.edge)
            && let Some(rest) = pivot(ball, sheet, &open)
        {
            front.extend(add_face(sheet, rest));
        }
    }
}

pub(super) fn add_face(sheet: &mut Sheet, rest: RestingBall) -> VecDeque<OpenEdge> {
    sheet.add(rest.face);
    open_edges(sheet, rest).collect()
}

fn open_edges(sheet: &Sheet, RestingBall { face: [a, b, c], center }: RestingBall) -> impl Iterator<Item = OpenEdge> {
    let edges = [([a, b], c), ([b, c], a), ([c, a], b)];
    edges.into_iter().filter(|(edge, _)| sheet.is_open(*edge)).map(move |(edge, opposite)| OpenEdge {
        edge,
        opposite,
        center,
    })
}

pub(super) fn reopen_edges(ball: &Ball, sheet: &Sheet) -> VecDeque<OpenEdge> {
    let at_boundary =
        sheet.faces.iter().filter(|&&[a, b, c]| [[a, b], [b, c], [c, a]].iter().any(|&e| sheet.is_open(e)));
    let rests = at_boundary.filter_map(|&face| {
        let rest = RestingBall { face, center: ball.center(face)? };
        let near = ball.points_near(ball.point(face[0]));
        ball.is_empty(rest.center, face, &near).then_some(rest)
    });
    rests.flat_map(|rest| open_edges(sheet, rest)).collect()
}

fn pivot(ball: &Ball, sheet: &Sheet, open: &OpenEdge) -> Option<RestingBall> {
    let [a, b] = open.edge;
    let middle = ball.point(a).midpoint(ball.point(b));
    let axis = (ball.point(b) - ball.point(a)).normalize_or_zero();
    let near = ball.points_near(middle);
    let rest = |&v: &u32| {
        let face = [b, a, v];
        let fits = v != a && v != b && v != open.opposite && sheet.can_take(face);
        let center = fits.then(|| ball.center(face))??;
        Some((pivot_angle(axis, open.center - middle, center - middle), RestingBall { face, center }))
    };
    let mut rests: Vec<(f64, RestingBall)> = near.iter().filter_map(rest).collect();
    // The ball stops at the first position where it rests on a third point.
    rests.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.face.cmp(&y.1.face)));
    rests.into_iter().map(|(_, rest)| rest).find(|rest| ball.is_empty(rest.center, rest.face, &near))
}

fn pivot_angle(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    let angle = axis.dot(from.cross(to)).atan2(from.dot(to)).rem_euclid(TAU);
    if angle > TAU - BACKWARD { 0.0 } else { angle }
}

pub(super) fn find_seed(ball: &Ball, sheet: &Sheet, v: u32) -> Option<RestingBall> {
    if !sheet.is_free(v) {
        return None;
    }
    let near = ball.points_near(ball.point(v));
    let mut free: Vec<u32> = near.iter().copied().filter(|&w| w != v && sheet.is_free(w)).collect();
    let distance2 = |w: u32| ball.point(w).distance_squared(ball.point(v));
    free.sort_by(|&x, &y| distance2(x).total_cmp(&distance2(y)).then(x.cmp(&y)));
    free.truncate(SEED_POINTS);
    let pairs = (1..free.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
    let faces = pairs.flat_map(|(i, j)| [[v, free[i], free[j]], [v, free[j], free[i]]]);
    let mut rests = faces.filter_map(|face| Some(RestingBall { face, center: ball.center(face)? }));
    rests.find(|rest| ball.is_empty(rest.center, rest.face, &near))
}
