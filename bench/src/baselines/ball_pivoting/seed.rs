//! Search for faces from which the ball starts.

use super::ball::Ball;
use super::rolling::RestingBall;
use super::sheet::Sheet;

const SEED_POINTS: usize = 32;

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
