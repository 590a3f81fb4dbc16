//! Which faces go on into which at edges with more than two: the floor under a wall, the two sides of a doubled sheet.
//!
//! Of the ways to cut a set of polygons into a manifold (Gueziec, Taubin, Lazarus and Horn, "Cutting and stitching", 2001) the
//! plain one makes each face at such an edge a border, and what was one thing falls to pieces. Here the faces at the edge
//! that go on into each other best stay joined, unless the surface would have one side then, where it had two.

use std::f32::consts::PI;

use glam::Vec3;
use rustc_hash::FxHashMap;

/// Angle, in radians, that a pair of faces wound against each other has to be flatter to be joined before one that agrees.
const DISAGREEMENT: f32 = 0.5 * PI;
/// Faces of an edge that are compared each with each, at most: thousands at one edge are no surface, and would fill the memory.
const MOST_FACES: usize = 128;

/// Half-edges as 3 x face + place, by their partner over an edge with more than two faces.
pub(super) type Partners = FxHashMap<u32, u32>;

/// The partners of the half-edges at all edges of `faces` with more than two faces; where the faces of an edge are odd in
/// number, one has none.
pub(super) fn partners(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Partners {
    let mut partners = Partners::default();
    let half_edges = half_edges(faces);
    let edges = || half_edges.chunk_by(|a, b| a.0 == b.0);
    let mut sides = Sides::new(faces.len());
    for edge in edges() {
        if let &[(_, g), (_, h)] = edge {
            sides.join([g / 3, h / 3], runs_up(faces, g) == runs_up(faces, h));
        }
    }
    for some in edges().filter(|edge| edge.len() > 2).flat_map(|edge| edge.chunks(MOST_FACES)) {
        let fan: Vec<Blade> = some.iter().map(|&(ends, half)| Blade::new(positions, faces, ends, half)).collect();
        for [g, h] in matched(&fan, &mut sides) {
            partners.insert(g, h);
            partners.insert(h, g);
        }
    }
    partners
}

/// All half-edges by the ends of their edge, ascending.
fn half_edges(faces: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let corners = faces.as_flattened();
    let end = |half: usize| corners[half - half % 3 + (half + 1) % 3];
    let edge = |half: usize| [corners[half].min(end(half)), corners[half].max(end(half))];
    let mut all: Vec<([u32; 2], u32)> = (0..corners.len()).map(|half| (edge(half), half as u32)).collect();
    all.sort_unstable();
    all
}

/// Whether a face runs along one of its edges from its lower end to its higher one.
fn runs_up(faces: &[[u32; 3]], half: u32) -> bool {
    let (face, place) = (faces[half as usize / 3], half as usize % 3);
    face[place] < face[(place + 1) % 3]
}

/// Faces that hang together, and which of them are wound against each other.
struct Sides {
    parents: Vec<u32>,
    /// Whether a face is wound against its parent.
    is_against: Vec<bool>,
}

impl Sides {
    fn new(n_faces: usize) -> Self {
        Self { parents: (0..n_faces as u32).collect(), is_against: vec![false; n_faces] }
    }

    /// The face that stands for all that hang together with this one, and whether this one is wound against it.
    fn root(&mut self, mut face: u32) -> (u32, bool) {
        let mut against = false;
        loop {
            let parent = self.parents[face as usize];
            let grandparent = self.parents[parent as usize];
            if parent != grandparent {
                self.is_against[face as usize] ^= self.is_against[parent as usize];
                self.parents[face as usize] = grandparent;
            }
            against ^= self.is_against[face as usize];
            if parent == grandparent {
                return (parent, against);
            }
            face = grandparent;
        }
    }

    /// Joins two faces, which are wound against each other or not; false, and nothing is joined, where the surface would have
    /// one side.
    fn join(&mut self, [f, g]: [u32; 2], against: bool) -> bool {
        let ((f, f_against), (g, g_against)) = (self.root(f), self.root(g));
        let between_roots = f_against ^ g_against ^ against;
        if f == g {
            return !between_roots;
        }
        self.parents[g as usize] = f;
        self.is_against[g as usize] = between_roots;
        true
    }
}

/// A face at an edge.
struct Blade {
    half: u32,
    /// Whether the face runs along the edge from its lower end to its higher one.
    is_along: bool,
    /// Where it stands off the edge, a unit vector; zero where it has no width.
    direction: Vec3,
}

impl Blade {
    fn new(positions: &[[f32; 3]], faces: &[[u32; 3]], [low, high]: [u32; 2], half: u32) -> Self {
        let face = faces[half as usize / 3];
        let [from, to, tip] =
            [low, high, face[(half as usize + 2) % 3]].map(|vertex| Vec3::from(positions[vertex as usize]));
        let along = (to - from).normalize_or_zero();
        let arm = tip - from;
        let direction = (arm - arm.dot(along) * along).normalize_or_zero();
        Self { half, is_along: face[half as usize % 3] == low, direction }
    }

    /// How little it goes on into another: the angle by which the surface bends there, and more where the sides do not agree.
    fn bend(&self, other: &Self) -> f32 {
        let bend = PI - self.direction.angle_between(other.direction);
        let bend = if bend.is_finite() { bend } else { PI };
        if self.is_along == other.is_along { bend + DISAGREEMENT } else { bend }
    }
}

/// Pairs of half-edges, those that bend least first; each at most once, none that leaves the surface with one side.
fn matched(fan: &[Blade], sides: &mut Sides) -> Vec<[u32; 2]> {
    let pairs = (0..fan.len()).flat_map(|i| (0..i).map(move |j| [j, i]));
    let mut pairs: Vec<(f32, [usize; 2])> = pairs.map(|[j, i]| (fan[j].bend(&fan[i]), [j, i])).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut is_taken = vec![false; fan.len()];
    let mut matched = Vec::new();
    for (_, [j, i]) in pairs {
        let (a, b) = (&fan[j], &fan[i]);
        if !is_taken[j] && !is_taken[i] && sides.join([a.half / 3, b.half / 3], a.is_along == b.is_along) {
            (is_taken[j], is_taken[i]) = (true, true);
            matched.push([a.half, b.half]);
        }
    }
    matched
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pairs of faces that are partners at the edge from 0 to 1, lower number first.
    fn pairs(tips: &[[f32; 3]], is_turned: &[bool]) -> Vec<[u32; 2]> {
        let ends = [[0.0; 3], [0.0, 0.0, 1.0]];
        let positions: Vec<[f32; 3]> = ends.iter().chain(tips).copied().collect();
        let face = |(tip, &turned): (u32, &bool)| if turned { [1, 0, tip] } else { [0, 1, tip] };
        let faces: Vec<[u32; 3]> = (2..).zip(is_turned).map(face).collect();
        let partners = partners(&positions, &faces);
        let mut pairs: Vec<[u32; 2]> = partners.iter().map(|(g, h)| [g / 3, h / 3]).filter(|[g, h]| g < h).collect();
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn a_floor_goes_on_under_a_wall() {
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
    fn the_two_sides_of_a_doubled_sheet_stay_sides() {
        let tips = [[1.0, 0.0, 0.5], [1.0, 0.0, 0.5], [-1.0, 0.0, 0.5], [-1.0, 0.0, 0.5]];
        assert_eq!(pairs(&tips, &[false, true, false, true]), [[0, 3], [1, 2]]);
    }

    #[test]
    fn nothing_is_joined_to_a_surface_with_one_side() {
        let mut sides = Sides::new(5);
        assert!(sides.join([0, 1], false) && sides.join([1, 2], true) && sides.join([3, 4], true));
        assert!(!sides.join([0, 2], false) && sides.join([0, 2], true));
        assert!(sides.join([4, 2], false) && sides.join([0, 3], false) && !sides.join([0, 3], true));
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
