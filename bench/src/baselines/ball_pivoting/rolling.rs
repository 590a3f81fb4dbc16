//! The ball rolls over open edges, and each point on which it comes to rest makes a face.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use glam::DVec3;

use super::ball::Ball;
use super::sheet::Sheet;

/// A turn by less than this backward, in radians, is rounding: the ball rests on four points or more.
const BACKWARD: f64 = 1e-3;

/// An edge over which the ball may roll: from `edge[0]` to `edge[1]` with its face on the left.
pub(super) struct Open {
    edge: [u32; 2],
    opposite: u32,
    center: DVec3,
}

/// Three points on which a ball rests, and its center.
#[derive(Clone, Copy)]
pub(super) struct Rest {
    pub(super) face: [u32; 3],
    pub(super) center: DVec3,
}

/// Rolls the ball over open edges until it gets no further.
pub(super) fn roll(ball: &Ball, sheet: &mut Sheet, mut front: VecDeque<Open>) {
    while let Some(open) = front.pop_front() {
        if sheet.is_open(open.edge)
            && let Some(rest) = pivot(ball, sheet, &open)
        {
            front.extend(extended(sheet, rest));
        }
    }
}

/// Adds a face, and gives the edges of it that are open.
pub(super) fn extended(sheet: &mut Sheet, rest: Rest) -> VecDeque<Open> {
    sheet.add(rest.face);
    open_edges(sheet, rest).collect()
}

fn open_edges(sheet: &Sheet, Rest { face: [a, b, c], center }: Rest) -> impl Iterator<Item = Open> {
    let edges = [([a, b], c), ([b, c], a), ([c, a], b)];
    edges.into_iter().filter(|(edge, _)| sheet.is_open(*edge)).map(move |(edge, opposite)| Open {
        edge,
        opposite,
        center,
    })
}

/// The open edges of faces on which this ball, too, rests with no point inside.
pub(super) fn reopened(ball: &Ball, sheet: &Sheet) -> VecDeque<Open> {
    let at_boundary =
        sheet.faces().iter().filter(|&&[a, b, c]| [[a, b], [b, c], [c, a]].iter().any(|&e| sheet.is_open(e)));
    let rests = at_boundary.filter_map(|&face| {
        let rest = Rest { face, center: ball.center(face)? };
        let near = ball.near(ball.point(face[0]));
        ball.is_empty(rest.center, face, &near).then_some(rest)
    });
    rests.flat_map(|rest| open_edges(sheet, rest)).collect()
}

/// The first point on which the ball comes to rest when it rolls over an edge.
fn pivot(ball: &Ball, sheet: &Sheet, open: &Open) -> Option<Rest> {
    let [a, b] = open.edge;
    let middle = ball.point(a).midpoint(ball.point(b));
    let axis = (ball.point(b) - ball.point(a)).normalize_or_zero();
    let near = ball.near(middle);
    let rest = |&v: &u32| {
        let face = [b, a, v];
        let fits = v != a && v != b && v != open.opposite && sheet.can_take(face);
        let center = fits.then(|| ball.center(face))??;
        Some((turn(axis, open.center - middle, center - middle), Rest { face, center }))
    };
    let mut rests: Vec<(f64, Rest)> = near.iter().filter_map(rest).collect();
    rests.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.face.cmp(&y.1.face)));
    rests.into_iter().map(|(_, rest)| rest).find(|rest| ball.is_empty(rest.center, rest.face, &near))
}

/// The angle about `axis` from one direction to another, forward from 0 to a full turn.
fn turn(axis: DVec3, from: DVec3, to: DVec3) -> f64 {
    let angle = axis.dot(from.cross(to)).atan2(from.dot(to)).rem_euclid(TAU);
    if angle > TAU - BACKWARD { 0.0 } else { angle }
}
