//! Fewer and larger cards: stochastic simplification of aggregate detail (Cook, Halstead, Planck, Ryu 2007).
//!
//! Leaves, grass and fences are many small open components of one material. None can be merged further, so some are
//! left out, and the others grow until all together cover as much again. A smaller size keeps a subset of the cards of
//! a larger one.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use rustc_hash::FxHashSet;

use crate::geometry::triangle::area_normal_f64;
use crate::mesh::TriMesh;
use crate::spatial::curve_order;

use super::closed::vertex_components;
use super::input::Input;
use super::limits::Limit;
use super::options::SimplifyError;
use super::sub_mesh::SubMesh;

/// Largest number of faces of a card: crossed planes and bent leaves of a few quads.
const MOST_FACES: usize = 8;
/// Least number of cards of a material.
const LEAST_CARDS: usize = 100;
/// Least share of a material's faces that are cards.
const LEAST_SHARE: f64 = 0.5;
/// Distance of a card's edge from its centre in the direction of the outline, over half the side of its bounding box.
// Few cards at the outline point a corner outward. A quarter of the leaves of a crown cover 1.00 of its pixels with 0.5,
// 0.91 with 1, and 1.08 if centres stay.
const REACH: f64 = 0.5;
/// Largest diagonal of a card, over that of all cards of its material.
const LARGEST: f64 = 0.25;

struct Card {
    faces: Vec<u32>,
    area: f64,
    centre: DVec3,
    /// Half the sides of the bounding box.
    half: DVec3,
}

/// The cards of a mesh by material, each list in the order in which they stay.
#[derive(Default)]
pub(super) struct Cards(Vec<Vec<Card>>);

impl Cards {
    /// Finds the cards of a mesh; none if some faces or vertices must stay.
    pub fn find(input: &Input) -> Self {
        let is_free = input.kept.is_empty() && input.locked.is_empty();
        if !is_free || input.mesh.faces().len() < LEAST_CARDS {
            return Self::default();
        }
        let mut by_group: BTreeMap<u32, (Vec<Card>, usize)> = BTreeMap::new();
        for faces in small_components(input.mesh) {
            let (cards, _) = by_group.entry(input.attributes.group(faces[0])).or_default();
            if is_open(input.mesh, &faces) {
                cards.push(measure(input.mesh, faces));
            }
        }
        if by_group.is_empty() {
            return Self::default();
        }
        (0..input.mesh.faces().len() as u32).for_each(|face| {
            by_group.entry(input.attributes.group(face)).and_modify(|(_, n_faces)| *n_faces += 1);
        });
        Self(by_group.into_values().filter_map(|(cards, n_faces)| in_order(cards, n_faces)).collect())
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Leaves out cards so that their number falls as the size of the mesh does, and enlarges the others.
    ///
    /// # Errors
    /// [`SimplifyError::Overflow`] if a card grows beyond single precision.
    pub fn thin<'a>(&self, input: &Input<'a>, limit: Limit) -> Result<SubMesh<'a>, SimplifyError> {
        let share = limit.share_of(input.mesh);
        let mut is_dropped = vec![false; input.mesh.faces().len()];
        let mut positions = input.mesh.positions().to_vec();
        let mut n_dropped = 0;
        for cards in &self.0 {
            let n_kept = ((share * cards.len() as f64) as usize).clamp(1, cards.len());
            let (kept, dropped) = cards.split_at(n_kept);
            n_dropped += dropped.len();
            dropped.iter().flat_map(|card| &card.faces).for_each(|&face| is_dropped[face as usize] = true);
            let growth = Growth::new(cards, kept);
            kept.iter().for_each(|card| growth.apply(card, input.mesh, &mut positions));
        }
        SubMesh::without_components(input, [n_dropped, 0], |face| is_dropped[face])?.with_positions(&positions)
    }
}

/// Lists the faces of each component that is no larger than a card; none if there are few components.
fn small_components(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let (component, n) = vertex_components(mesh.positions().len(), mesh.faces());
    if n < LEAST_CARDS {
        return Vec::new();
    }
    let mut faces: Vec<Vec<u32>> = vec![Vec::new(); n];
    let of_face = mesh.faces().iter().map(|face| component[face[0] as usize]);
    (0u32..).zip(of_face).for_each(|(face, component)| faces[component as usize].push(face));
    faces.retain(|faces| (1..=MOST_FACES).contains(&faces.len()));
    faces
}

fn is_open(mesh: &TriMesh, faces: &[u32]) -> bool {
    let sides = faces.iter().flat_map(|&face| {
        let [a, b, c] = mesh.faces()[face as usize];
        [[a, b], [b, c], [c, a]]
    });
    let sides: FxHashSet<[u32; 2]> = sides.collect();
    sides.iter().any(|&[a, b]| !sides.contains(&[b, a]))
}

fn corners(mesh: &TriMesh, face: u32) -> [DVec3; 3] {
    mesh.faces()[face as usize].map(|v| Vec3::from(mesh.positions()[v as usize]).as_dvec3())
}

fn measure(mesh: &TriMesh, faces: Vec<u32>) -> Card {
    let (mut low, mut high, mut area) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0);
    for &face in &faces {
        let corners = corners(mesh, face);
        area += 0.5 * area_normal_f64(corners).length();
        (low, high) = corners.into_iter().fold((low, high), |(low, high), p| (low.min(p), high.max(p)));
    }
    Card { faces, area, centre: 0.5 * (low + high), half: 0.5 * (high - low) }
}

/// Orders the cards of a material so that each beginning of the list is spread evenly; `None` if they are none.
fn in_order(mut cards: Vec<Card>, n_faces: usize) -> Option<Vec<Card>> {
    let (low, high) = cards.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), card| {
        (low.min(card.centre), high.max(card.centre))
    });
    let most = LARGEST * low.distance(high);
    cards.retain(|card| 2.0 * card.half.length() <= most);
    let n_in_cards: usize = cards.iter().map(|card| card.faces.len()).sum();
    if cards.len() < LEAST_CARDS || (n_in_cards as f64) < LEAST_SHARE * n_faces as f64 {
        return None;
    }
    // Neighbours in space are neighbours along the curve, and reversed bits of a rank are far apart (van der Corput).
    let order = curve_order(cards.len(), |i| cards[i as usize].centre.as_vec3().to_array(), || ());
    let mut rank = vec![0; cards.len()];
    (0u32..).zip(&order).for_each(|(i, &card)| rank[card as usize] = i.reverse_bits());
    let mut ranked: Vec<(u32, Card)> = rank.into_iter().zip(cards).collect();
    ranked.sort_by_key(|(rank, _)| *rank);
    Some(ranked.into_iter().map(|(_, card)| card).collect())
}

/// Changes by which the kept cards of a material cover as much as all.
struct Growth {
    scale: f64,
    middle: DVec3,
    /// Factors on the distances of the cards from the middle, so that larger cards reach no farther out.
    inward: DVec3,
}

impl Growth {
    fn new(all: &[Card], kept: &[Card]) -> Self {
        let area = |cards: &[Card]| cards.iter().map(|card| card.area).sum::<f64>();
        let scale = (area(all) / area(kept).max(f64::MIN_POSITIVE)).sqrt();
        let (low, high) = all.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), card| {
            (low.min(card.centre - card.half), high.max(card.centre + card.half))
        });
        // Half the room for centres of cards of the mean size.
        let mean = REACH * all.iter().map(|card| card.half).sum::<DVec3>() / all.len().max(1) as f64;
        let room = |scale: f64| (0.5 * (high - low) - scale * mean).max(DVec3::ZERO);
        Self { scale, middle: 0.5 * (low + high), inward: room(scale) / room(1.0).max(DVec3::splat(f64::MIN_POSITIVE)) }
    }

    fn apply(&self, card: &Card, mesh: &TriMesh, positions: &mut [[f32; 3]]) {
        let centre = self.middle + self.inward * (card.centre - self.middle);
        // Corners are shared by faces of the card, so each starts from its place in the mesh.
        for v in card.faces.iter().flat_map(|&face| mesh.faces()[face as usize]) {
            let place = Vec3::from(mesh.positions()[v as usize]).as_dvec3();
            positions[v as usize] = (centre + self.scale * (place - card.centre)).as_vec3().to_array();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// Squares on a sphere, about as wide as the gaps between them.
    fn leaves(n: usize) -> TriMesh {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        for i in 0..n {
            let (z, angle) = (1.0 - (2 * i + 1) as f32 / n as f32, 2.4 * i as f32);
            let r = (1.0 - z * z).sqrt();
            let centre = Vec3::new(r * angle.cos(), r * angle.sin(), z);
            let (right, up) = centre.any_orthonormal_pair();
            let first = positions.len() as u32;
            let corner = |(x, y): (f32, f32)| (centre + 0.05 * (x * right + y * up)).to_array();
            positions.extend([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner));
            faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        TriMesh::new(positions, faces).unwrap()
    }

    fn area(mesh: &TriMesh) -> f64 {
        (0..mesh.faces().len() as u32).map(|face| 0.5 * area_normal_f64(corners(mesh, face)).length()).sum()
    }

    fn largest_coordinate(mesh: &TriMesh) -> f32 {
        mesh.positions().as_flattened().iter().fold(0.0, |most, x| most.max(x.abs()))
    }

    #[test]
    fn fewer_cards_cover_as_much_and_are_a_subset_of_more() {
        let mesh = leaves(400);
        let input = Input::bare(&mesh);
        let cards = Cards::find(&input);
        let thinned = [0.5, 0.25, 0.05].map(|share: f64| {
            let limit = Limit::from_vertices((share * 1600.0) as usize);
            let thin = cards.thin(&input, limit).unwrap();
            assert!(thin.origin.n_dropped == 400 - (share * 400.0) as usize);
            let thinner = thin.input().mesh;
            assert!((area(thinner) / area(&mesh) - 1.0).abs() < 1e-4);
            // Larger leaves do not make a larger tree.
            assert!(largest_coordinate(thinner) < 1.1 * largest_coordinate(&mesh));
            thin.origin.faces.clone().unwrap()
        });
        assert!(thinned.windows(2).all(|pair| pair[1].iter().all(|face| pair[0].contains(face))));
        // Each octant keeps its share.
        let is_in_octant = |&&face: &&u32| {
            mesh.faces()[face as usize].iter().all(|&v| mesh.positions()[v as usize].iter().all(|x| *x > 0.0))
        };
        let in_octant = thinned[1].iter().filter(is_in_octant).count();
        assert!((10..32).contains(&in_octant), "{in_octant}");
    }

    #[test]
    fn closed_large_and_few_components_are_no_cards() {
        let is_none = |mesh: &TriMesh| Cards::find(&Input::bare(mesh)).is_empty();
        assert!(is_none(&leaves(LEAST_CARDS - 1)) && !is_none(&leaves(LEAST_CARDS)));
        assert!(is_none(&shapes::grid(40, 40)));
        let tetrahedron = shapes::tetrahedron();
        let shifted = |i: i32| shapes::place(&tetrahedron, |[x, y, z]| [x + 3.0 * i as f32, y, z]);
        assert!(is_none(&shapes::unite((0..200).map(shifted))));
        // Locked vertices keep all.
        let mesh = leaves(200);
        let locked = vec![true; 800];
        assert!(Cards::find(&Input { locked: &locked, ..Input::bare(&mesh) }).is_empty());
    }
}
