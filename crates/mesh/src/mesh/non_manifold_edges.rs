//! Pairs the faces at edges with more than two faces.
//!
//! Cutting every such edge (Gueziec, Taubin, Lazarus and Horn, "Cutting and stitching", 2001) tears surfaces apart.
//! Here the faces that continue each other best stay joined, unless that makes a two-sided surface one-sided. An even
//! number of faces is paired completely, so closed surfaces stay closed.

use std::f32::consts::PI;

use glam::Vec3;
use rustc_hash::FxHashMap;

use super::half_edges::{HalfEdge, for_each_edge, next, start};
use super::surroundings::Surroundings;
use super::windings::Windings;

/// Extra angle, in radians, for a pair with inconsistent winding.
const DISAGREEMENT: f32 = 0.5 * PI;
/// Largest number of faces at an edge that are compared pairwise.
const MOST_FACES: usize = 128;

pub(super) type Partners = FxHashMap<u32, u32>;

/// Matches the half-edges at all edges with more than two faces.
pub(super) fn partners(positions: &[[f32; 3]], around: &Surroundings) -> Partners {
    let (faces, cluster) = (&around.faces, |face: u32| around.clusters[face as usize]);
    let mut sides = Windings::new(around.n_clusters);
    let mut fans: Vec<Vec<EdgeFace>> = Vec::new();
    for_each_edge(positions.len(), faces, |ends, half_edges| {
        if let &[g, h] = half_edges {
            sides.join([cluster(g.face()), cluster(h.face())], g.runs_up(faces) == h.runs_up(faces));
        } else if half_edges.len() > 2 {
            let fan = |some: &[HalfEdge]| some.iter().map(|&h| EdgeFace::new(positions, faces, ends, h)).collect();
            fans.extend(half_edges.chunks(MOST_FACES).map(fan));
        }
    });
    let mut partners = Partners::default();
    for fan in fans {
        let joined = |a: &EdgeFace, b: &EdgeFace| {
            a.tip != b.tip && sides.join([cluster(a.half / 3), cluster(b.half / 3)], a.is_along == b.is_along)
        };
        for [g, h] in match_half_edges(&fan, joined) {
            partners.insert(g, h);
            partners.insert(h, g);
        }
    }
    partners
}

struct EdgeFace {
    half: u32,
    is_along: bool,
    tip: u32,
    direction: Vec3,
}

impl EdgeFace {
    fn new(positions: &[[f32; 3]], faces: &[[u32; 3]], [low, high]: [u32; 2], half: HalfEdge) -> Self {
        let across = start(faces, next(next(half.half_edge)));
        let [from, to, tip] = [low, high, across].map(|vertex| Vec3::from(positions[vertex as usize]));
        let along = (to - from).normalize_or_zero();
        let arm = tip - from;
        let direction = (arm - arm.dot(along) * along).normalize_or_zero();
        Self { half: half.half_edge, is_along: half.runs_up(faces), tip: across, direction }
    }

    /// Returns the bending angle between two faces in radians, plus a penalty for inconsistent winding.
    fn bend(&self, other: &Self) -> f32 {
        let bend = PI - self.direction.angle_between(other.direction);
        let bend = if bend.is_finite() { bend } else { PI };
        if self.is_along == other.is_along { bend + DISAGREEMENT } else { bend }
    }
}

/// Matches half-edges, least bend first, each at most once.
///
/// Coincident faces (walls between bodies) match first, never each other. On closed bodies opposite directions match
/// first. Then pairs match that keep the surface two-sided, and for an even number finally any.
fn match_half_edges(fan: &[EdgeFace], mut joined: impl FnMut(&EdgeFace, &EdgeFace) -> bool) -> Vec<[u32; 2]> {
    let pairs = (0..fan.len()).flat_map(|i| (0..i).map(move |j| [j, i]));
    let mut pairs: Vec<(f32, [usize; 2])> = pairs.map(|[j, i]| (fan[j].bend(&fan[i]), [j, i])).collect();
    let is_wall = |i: usize| fan.iter().enumerate().any(|(k, blade)| k != i && blade.tip == fan[i].tip);
    let is_wall: Vec<bool> = (0..fan.len()).map(is_wall).collect();
    let rank = |&[j, i]: &[usize; 2]| !is_wall[j] && !is_wall[i];
    pairs.sort_by(|a, b| rank(&a.1).cmp(&rank(&b.1)).then(a.0.total_cmp(&b.0)).then(a.1.cmp(&b.1)));
    let mut is_taken = vec![false; fan.len()];
    let mut matched = Vec::new();
    let mut take = |may: &mut dyn FnMut(&EdgeFace, &EdgeFace) -> bool| {
        for &(_, [j, i]) in &pairs {
            if !is_taken[j] && !is_taken[i] && may(&fan[j], &fan[i]) {
                (is_taken[j], is_taken[i]) = (true, true);
                matched.push([fan[j].half, fan[i].half]);
            }
        }
    };
    if 2 * fan.iter().filter(|blade| blade.is_along).count() == fan.len() {
        take(&mut |a, b| a.is_along != b.is_along && joined(a, b));
    }
    take(&mut joined);
    if fan.len().is_multiple_of(2) {
        take(&mut |_, _| true);
    }
    matched
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(tips: &[[f32; 3]], is_turned: &[bool]) -> Vec<[u32; 2]> {
        let ends = [[0.0; 3], [0.0, 0.0, 1.0]];
        let positions: Vec<[f32; 3]> = ends.iter().chain(tips).copied().collect();
        let face = |(tip, &turned): (u32, &bool)| if turned { [1, 0, tip] } else { [0, 1, tip] };
        pairs_of(&positions, &(2..).zip(is_turned).map(face).collect::<Vec<_>>())
    }

    fn pairs_of(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<[u32; 2]> {
        let partners = partners(positions, &Surroundings::whole(faces));
        let mut pairs: Vec<[u32; 2]> = partners.iter().map(|(g, h)| [g / 3, h / 3]).filter(|[g, h]| g < h).collect();
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn a_floor_continues_under_a_wall() {
        let tips = [[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [-1.0, 0.1, 0.5]];
        assert_eq!(pairs(&tips, &[false, true, true]), [[0, 2]]);
        assert_eq!(pairs(&tips, &[false, false, true]), [[0, 2]]);
    }

    #[test]
    fn sheets_that_cross_stay_sheets() {
        let tips = [[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [-1.0, 0.0, 0.5], [0.0, -1.0, 0.5]];
        assert_eq!(pairs(&tips, &[false, false, true, true]), [[0, 2], [1, 3]]);
    }

    #[test]
    fn an_even_number_of_faces_is_matched_completely() {
        let tips = [[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [-1.0, 0.0, 0.5], [0.0, -1.0, 0.5]];
        for turned in 0..16 {
            let is_turned: Vec<bool> = (0..4).map(|face| turned >> face & 1 == 1).collect();
            assert_eq!(pairs(&tips, &is_turned).len(), 2, "{is_turned:?}");
        }
    }

    #[test]
    fn the_two_sides_of_a_doubled_sheet_stay_sides() {
        let tips = [[1.0, 0.0, 0.5], [1.0, 0.0, 0.5], [-1.0, 0.0, 0.5], [-1.0, 0.0, 0.5]];
        assert_eq!(pairs(&tips, &[false, true, false, true]), [[0, 3], [1, 2]]);
    }

    #[test]
    fn the_wall_between_two_bodies_belongs_to_both() {
        let positions = [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-0.1, 1.0, 0.5], [-0.1, -1.0, 0.5]];
        let faces = [[0, 1, 2], [1, 0, 2], [0, 1, 3], [1, 0, 4]];
        assert_eq!(pairs_of(&positions, &faces), [[0, 3], [1, 2]]);
    }

    #[test]
    fn thousands_of_faces_at_one_edge_take_no_longer_than_their_number() {
        let tips: Vec<[f32; 3]> = (0..60_000).map(|i| [1.0 + i as f32, 1.0, 0.5]).collect();
        assert_eq!(pairs(&tips, &vec![false; tips.len()]).len(), tips.len() / 2);
    }

    #[test]
    fn edges_with_two_faces_and_faces_without_width_are_no_matter() {
        assert!(pairs(&[[1.0, 0.0, 0.5], [-1.0, 0.0, 0.5]], &[false, true]).is_empty());
        assert_eq!(pairs(&[[0.0, 0.0, 0.5]; 3], &[false, true, false]).len(), 1);
    }
}
