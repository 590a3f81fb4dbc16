//! Ball pivoting: points with normals become triangles where a ball rests on three of them (Bernardini et al. 1999).
//!
//! A ball starts on three points with none inside, and rolls over each open edge of the faces so far until it rests on
//! a next point. Larger balls go on where smaller ones fell through. What no ball bridges stays a hole.
//!
//! Ours, since the only crate for it, `bpa_rs`, knows one radius alone.

mod ball;
mod sheet;

use std::collections::VecDeque;
use std::f64::consts::TAU;

use crate::spatial::nearest_neighbours;
use ball::Ball;
use glam::DVec3;
use sheet::Sheet;

/// Radii of the balls over the average distance of a point to its nearest one, as is usual in Open3D and MeshLab.
const RADII: [f64; 4] = [1.0, 1.5, 2.0, 4.0];

/// Nearest points of which a first face is made.
const SEED_POINTS: usize = 32;

/// A turn by less than this backward, in radians, is rounding: the ball rests on four points or more.
const BACKWARD: f64 = 1e-3;

/// Meshes points by balls of several sizes.
///
/// Faces are wound so that they look along the normals of their corners. No edge has more than two faces. Takes time
/// quadratic in the number of points that a ball of the average spacing covers.
///
/// # Shapes
/// - `points`, `normals`: n x 3, finite; normals of any length
/// - returns n_faces x 3
///
/// # Panics
/// When there is not one normal per point.
///
/// ```
/// use neural_mesh::baselines::ball_pivoting;
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0]];
/// assert_eq!(ball_pivoting(&points, &[[0.0, 0.0, 1.0]; 3]), [[0, 1, 2]]);
/// ```
pub fn ball_pivoting(points: &[[f32; 3]], normals: &[[f32; 3]]) -> Vec<[u32; 3]> {
    assert_eq!(points.len(), normals.len(), "one normal per point");
    let [points, normals] = [points, normals].map(in_double);
    let mut sheet = Sheet::new(points.len());
    let Some(spacing) = average_spacing(&points) else { return Vec::new() };
    for radius in RADII.map(|multiple| multiple * spacing) {
        let ball = Ball::new(&points, &normals, radius);
        let front = reopened(&ball, &sheet);
        roll(&ball, &mut sheet, front);
        for v in 0..points.len() as u32 {
            if let Some(seed) = seed(&ball, &sheet, v) {
                let front = extended(&mut sheet, seed);
                roll(&ball, &mut sheet, front);
            }
        }
    }
    sheet.into_faces()
}

fn in_double(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|row| DVec3::from_array(row.map(f64::from))).collect()
}

/// The mean distance of a point to its nearest one; none where all points are one.
fn average_spacing(points: &[DVec3]) -> Option<f64> {
    let single: Vec<[f32; 3]> = points.iter().map(|p| p.as_vec3().to_array()).collect();
    let nearest = nearest_neighbours(&single, 1);
    let sum: f64 = nearest.iter().zip(points).map(|(&at, p)| p.distance(points[at as usize])).sum();
    Some(sum / nearest.len() as f64).filter(|spacing| *spacing > 0.0 && spacing.is_finite())
}

/// An edge over which the ball may roll: from `edge[0]` to `edge[1]` with its face on the left.
struct Open {
    edge: [u32; 2],
    opposite: u32,
    center: DVec3,
}

/// Three points on which a ball rests, and its center.
#[derive(Clone, Copy)]
struct Rest {
    face: [u32; 3],
    center: DVec3,
}

/// Rolls the ball over open edges until it gets no further.
fn roll(ball: &Ball, sheet: &mut Sheet, mut front: VecDeque<Open>) {
    while let Some(open) = front.pop_front() {
        if sheet.is_open(open.edge)
            && let Some(rest) = pivot(ball, sheet, &open)
        {
            front.extend(extended(sheet, rest));
        }
    }
}

/// Adds a face, and gives the edges of it that are open.
fn extended(sheet: &mut Sheet, rest: Rest) -> VecDeque<Open> {
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
fn reopened(ball: &Ball, sheet: &Sheet) -> VecDeque<Open> {
    let at_border =
        sheet.faces().iter().filter(|&&[a, b, c]| [[a, b], [b, c], [c, a]].iter().any(|&e| sheet.is_open(e)));
    let rests = at_border.filter_map(|&face| {
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

/// Where the ball rests on a point that no face has and on two more of these, if it does.
fn seed(ball: &Ball, sheet: &Sheet, v: u32) -> Option<Rest> {
    if !sheet.is_free(v) {
        return None;
    }
    let near = ball.near(ball.point(v));
    let mut free: Vec<u32> = near.iter().copied().filter(|&w| w != v && sheet.is_free(w)).collect();
    let distance2 = |w: u32| ball.point(w).distance_squared(ball.point(v));
    free.sort_by(|&x, &y| distance2(x).total_cmp(&distance2(y)).then(x.cmp(&y)));
    free.truncate(SEED_POINTS);
    let pairs = (1..free.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
    let faces = pairs.flat_map(|(i, j)| [[v, free[i], free[j]], [v, free[j], free[i]]]);
    let mut rests = faces.filter_map(|face| Some(Rest { face, center: ball.center(face)? }));
    rests.find(|rest| ball.is_empty(rest.center, rest.face, &near))
}
