//! The corners of the result: which of them share values, and where on the original those values stand.
//!
//! Every face of the result comes of one face of the original, whose corners lie in the three regions; so it belongs to that
//! face's group, and lies on its side of every seam. Around a vertex, faces that meet over edges that are no seams share a
//! wedge. The values of a wedge are those of the original at the point nearest to the vertex, looked for on the wedge's
//! side: from the faces that the wedge comes of, over edges that are no seams. Texture coordinates and colours are then fitted
//! over the faces (`values`).

use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::mesh::union_find::UnionFind;
use crate::mesh::{Attributes, Channel, Role, TriMesh};

use crate::simplify::closed::attributes::values::Fit;
use crate::simplify::closed::prepare::features::Features;
use crate::simplify::closed::prepare::surface::Surface;
use crate::simplify::closed::refine::faces_around::FacesAround;

const NONE: u32 = u32::MAX;
/// Squared distance over that of the nearest face so far, up to which a search for the nearest goes on from a face.
const SLACK: f32 = 1.5;

/// What each corner of the result has to do with the original.
pub struct Corners {
    /// The wedge of each corner, n_faces x 3, as the faces are; kept in step by whoever flips an edge.
    pub wedges: Vec<[u32; 3]>,
    /// The face of the original that each wedge first came of, and all others.
    origins: Vec<Vec<u32>>,
    /// The output vertex of each wedge.
    vertices: Vec<u32>,
}

impl Corners {
    /// The corners of `faces`, over the vertices that `vertex_of` says the surface's became; each face begins with its
    /// smallest vertex.
    pub fn new(
        surface: &Surface,
        features: &Features,
        attributes: &Attributes,
        vertex_of: &[u32],
        faces: &[[u32; 3]],
    ) -> Self {
        let came_of = faces_they_came_of(surface, vertex_of, faces);
        let seams: FxHashSet<[u32; 2]> = features.edges_between(vertex_of).into_iter().collect();
        let n_vertices = faces.as_flattened().iter().max().map_or(0, |&last| last as usize + 1);
        let around = FacesAround::new(n_vertices, faces);
        let mut sets = UnionFind::new(3 * faces.len());
        let corner = |f: u32, v: u32| 3 * f + faces[f as usize].iter().position(|&w| w == v).unwrap_or(0) as u32;
        let group = |f: u32| match came_of[f as usize] {
            NONE => NONE,
            face => attributes.group(face),
        };
        for (f, &[a, b, c]) in (0u32..).zip(faces) {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                let twin = around.along(b, a).filter(|&g| g > f && group(f) == group(g));
                if let Some(g) = twin.filter(|_| !seams.contains(&[a.min(b), a.max(b)])) {
                    [a, b].into_iter().for_each(|v| _ = sets.union(corner(f, v), corner(g, v)));
                }
            }
        }
        Self::numbered(&mut sets, faces, &came_of)
    }

    /// The sets of corners as wedges, in the order of their first corners.
    fn numbered(sets: &mut UnionFind, faces: &[[u32; 3]], came_of: &[u32]) -> Self {
        let mut number = vec![NONE; 3 * faces.len()];
        let (mut origins, mut vertices): (Vec<Vec<u32>>, Vec<u32>) = (Vec::new(), Vec::new());
        let mut wedge = |corner: usize| {
            let first = sets.find(corner as u32) as usize;
            if number[first] == NONE {
                number[first] = origins.len() as u32;
                origins.push(Vec::new());
                vertices.push(faces.as_flattened()[corner]);
            }
            let face = came_of[corner / 3];
            origins[number[first] as usize].extend((face != NONE).then_some(face));
            number[first]
        };
        let wedges = (0..faces.len()).map(|f| [3 * f, 3 * f + 1, 3 * f + 2].map(&mut wedge)).collect();
        Self { wedges, origins, vertices }
    }

    /// Whether the edge `a b` between two faces is a seam.
    pub fn is_seam(&self, faces: &[[u32; 3]], [f, g]: [u32; 2], [a, b]: [u32; 2]) -> bool {
        [a, b].into_iter().any(|v| self.at(faces, f, v) != self.at(faces, g, v))
    }

    /// The corners of the two faces `a b c` and `b a d`, which are still these, when they become `c d b` and `d c a`.
    pub fn flip(&mut self, faces: &[[u32; 3]], [f, g]: [u32; 2], [a, b, c, d]: [u32; 4]) {
        let [wa, wb, wc] = [a, b, c].map(|v| self.at(faces, f, v));
        let wd = self.at(faces, g, d);
        (self.wedges[f as usize], self.wedges[g as usize]) = ([wc, wd, wb], [wd, wc, wa]);
    }

    fn at(&self, faces: &[[u32; 3]], f: u32, v: u32) -> u32 {
        let corner = faces[f as usize].iter().position(|&w| w == v).unwrap_or(0);
        self.wedges[f as usize][corner]
    }

    /// What the corners carry when the output vertices are at `positions`; `mesh` is what the surface was made of. At vertices
    /// that stay, and where all vertices are the mesh's, the values are the original's.
    pub fn attributes(
        self,
        (mesh, surface): (&TriMesh, &Surface),
        features: &Features,
        attributes: &Attributes,
        (positions, stays): (&[Vec3], &[bool]),
    ) -> (Attributes, CornerMap) {
        let group = |wedges: &[u32; 3]| {
            let first = self.origins[wedges[0] as usize].first();
            first.map_or(0, |&face| attributes.group(face))
        };
        let groups = if attributes.groups.is_empty() { Vec::new() } else { self.wedges.iter().map(group).collect() };
        let original = Original {
            surface,
            orders: corner_orders(surface, mesh),
            seams: features.edges.iter().copied().collect(),
            around: FacesAround::new(surface.n_vertices(), &surface.faces),
        };
        let places: Vec<Place> = (0..self.vertices.len())
            .into_par_iter()
            .map(|wedge| original.place(positions[self.vertices[wedge] as usize], &self.origins[wedge]))
            .collect();
        let at_corners = self.wedges.iter().map(|wedges| wedges.map(|wedge| places[wedge as usize]));
        let (faces, weights) = at_corners.map(|at| (at.map(|p| p.face), at.map(|p| p.weights))).unzip();
        let of_wedges = (self.wedges.as_slice(), self.vertices.as_slice());
        let fit = || Fit::new(&original, of_wedges, &places, positions, stays);
        let is_fitted = |channel: &Channel| matches!(channel.role, Role::Uv | Role::Colour);
        let fit = (!features.subset && attributes.channels.iter().any(is_fitted)).then(fit);
        let channel = |channel: &Channel| {
            let nearest = carried(channel, &attributes.wedges, &places);
            match &fit {
                Some(fit) if is_fitted(channel) => fit.values(nearest, channel, &attributes.wedges),
                _ => nearest,
            }
        };
        let channels: Vec<Channel> = attributes.channels.iter().map(channel).collect();
        let wedges = if channels.is_empty() { Vec::new() } else { self.wedges };
        (Attributes { wedges, channels, groups }, CornerMap { faces, weights })
    }
}

/// Where on the mesh the corners of the result stand.
pub struct CornerMap {
    /// The face of the mesh for each corner, n_faces x 3.
    pub faces: Vec<[u32; 3]>,
    /// The weights of its corners, n_faces x 3 x 3.
    pub weights: Vec<[[f32; 3]; 3]>,
}

/// For each output face the input face whose corners became its corners.
fn faces_they_came_of(surface: &Surface, vertex_of: &[u32], faces: &[[u32; 3]]) -> Vec<u32> {
    let number: FxHashMap<[u32; 3], u32> = faces.iter().copied().zip(0..).collect();
    let mut came_of = vec![NONE; faces.len()];
    for (face, corners) in (0u32..).zip(surface.faces.iter()) {
        let [a, b, c] = corners.map(|v| vertex_of[v as usize]);
        if a == b || b == c || c == a {
            continue;
        }
        let first = a.min(b).min(c);
        let [x, y, z] = if a == first {
            [a, b, c]
        } else if b == first {
            [b, c, a]
        } else {
            [c, a, b]
        };
        // On a surface that has no two sides the face may have been met from the other one.
        if let Some(&f) = number.get(&[x, y, z]).or_else(|| number.get(&[x, z, y])) {
            came_of[f as usize] = face;
        }
    }
    came_of
}

/// For each corner of the surface's faces which corner of the mesh's it is: some faces are wound the other way.
pub fn corner_orders(surface: &Surface, mesh: &TriMesh) -> Vec<[u8; 3]> {
    let order = |(corners, before): (&[u32; 3], &[u32; 3])| {
        corners.map(|v| before.iter().position(|&w| w == surface.source(v)).unwrap_or(0) as u8)
    };
    surface.faces.iter().zip(mesh.faces()).map(order).collect()
}

/// A point of the original: a face and weights of the corners that it has in the mesh.
#[derive(Clone, Copy)]
pub struct Place {
    /// The face.
    pub face: u32,
    /// The weights of its corners.
    pub weights: [f32; 3],
}

/// The original, walked over.
pub struct Original<'a> {
    surface: &'a Surface<'a>,
    /// Which corner of the mesh each corner of the surface is, n_faces x 3.
    orders: Vec<[u8; 3]>,
    seams: FxHashSet<[u32; 2]>,
    around: FacesAround,
}

impl Original<'_> {
    /// The point nearest to `p` among the faces that a search from `starts` meets, which goes on from the nearest faces as long
    /// as they lie hardly farther than the best: a corner or an edge may be nearest on several faces before the next is nearer.
    pub fn place(&self, p: Vec3, starts: &[u32]) -> Place {
        let mut met: Vec<u32> = Vec::new();
        let mut open: Vec<(f32, Place)> = Vec::new();
        let mut best = (f32::INFINITY, Place { face: starts.first().copied().unwrap_or(0), weights: [1.0 / 3.0; 3] });
        let mut meet = |face: u32, open: &mut Vec<(f32, Place)>, best: &mut (f32, Place)| {
            if !met.contains(&face) {
                met.push(face);
                let here = self.nearest(p, face);
                open.push(here);
                if here.0 < best.0 {
                    *best = here;
                }
            }
        };
        starts.iter().for_each(|&face| meet(face, &mut open, &mut best));
        while let Some(next) = (0..open.len()).min_by(|&i, &j| open[i].0.total_cmp(&open[j].0)) {
            let (distance, place) = open.swap_remove(next);
            if distance > SLACK * best.0 {
                break;
            }
            self.beside(place.face).for_each(|face| meet(face, &mut open, &mut best));
        }
        best.1
    }

    /// The squared distance of a point from a face, and the nearest point of it.
    fn nearest(&self, p: Vec3, face: u32) -> (f32, Place) {
        let corners = self.surface.faces[face as usize].map(|v| self.surface.positions[v as usize]);
        let weights = nearest_weights_f64(p.as_dvec3(), corners.map(Vec3::as_dvec3)).map(|w| w as f32);
        let point = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let mut of_mesh = [0.0; 3];
        self.orders[face as usize].iter().zip(weights).for_each(|(&corner, w)| of_mesh[corner as usize] = w);
        (point.distance_squared(p), Place { face, weights: of_mesh })
    }

    /// The faces beyond the edges of a face that are no seams.
    fn beside(&self, face: u32) -> impl Iterator<Item = u32> {
        let [a, b, c] = self.surface.faces[face as usize];
        let open = |(a, b): &(u32, u32)| !self.seams.contains(&[*a.min(b), *a.max(b)]);
        [(a, b), (b, c), (c, a)].into_iter().filter(open).filter_map(|(a, b)| self.around.along(b, a))
    }
}

/// The values of a channel at these places.
fn carried(channel: &Channel, wedges: &[[u32; 3]], places: &[Place]) -> Channel {
    let width = channel.width;
    let mut values = vec![0.0; places.len() * width];
    values.par_chunks_mut(width).zip(places).for_each(|(out, place)| {
        let corners = wedges[place.face as usize].map(|wedge| channel.of(wedge));
        blend(channel.role, corners, place.weights, out);
    });
    Channel { values, name: channel.name.clone(), ..*channel }
}

/// The mean of three values under these weights, as their role has it.
pub fn blend(role: Role, corners: [&[f32]; 3], weights: [f32; 3], out: &mut [f32]) {
    match role {
        Role::Skin => blend_joints(corners, weights, out),
        Role::Label => out.copy_from_slice(corners[heaviest(weights)]),
        _ => blend_numbers(corners, weights, out),
    }
    match role {
        Role::Normal => normalise(out, corners, weights),
        Role::Tangent => {
            if let Some((direction, [sign, ..])) = out.split_at_mut_checked(3) {
                normalise(direction, corners.map(|corner| &corner[..3]), weights);
                *sign = if *sign < 0.0 { -1.0 } else { 1.0 };
            }
        }
        _ => {}
    }
}

fn blend_numbers(corners: [&[f32]; 3], weights: [f32; 3], out: &mut [f32]) {
    for (i, out) in out.iter_mut().enumerate() {
        // What weighs nothing must not count, not even where it is no number.
        let terms = (0..3).filter(|&k| weights[k] > 0.0).map(|k| weights[k] * corners[k][i]);
        *out = terms.sum();
    }
}

/// Unit length again; where the directions cancel out, the one that weighs most.
fn normalise(out: &mut [f32], corners: [&[f32]; 3], weights: [f32; 3]) {
    let length = out.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > 1e-6 {
        out.iter_mut().for_each(|x| *x /= length);
    } else {
        out.copy_from_slice(corners[heaviest(weights)]);
    }
}

/// The corner that weighs most.
fn heaviest(weights: [f32; 3]) -> usize {
    (0..3).max_by(|&i, &j| weights[i].total_cmp(&weights[j])).unwrap_or(0)
}

/// Adds up the weights of each joint and keeps the heaviest, their sum as it was.
fn blend_joints(corners: [&[f32]; 3], weights: [f32; 3], out: &mut [f32]) {
    let n = out.len() / 2;
    let mut joints: Vec<(f32, f32)> = Vec::new();
    for (corner, weight) in corners.into_iter().zip(weights) {
        for (&joint, &share) in corner[..n].iter().zip(&corner[n..]).filter(|(_, share)| **share > 0.0) {
            match joints.iter_mut().find(|(other, _)| *other == joint) {
                Some((_, sum)) => *sum += weight * share,
                None => joints.push((joint, weight * share)),
            }
        }
    }
    let whole: f32 = joints.iter().map(|(_, weight)| weight).sum();
    joints.sort_by(|x, y| y.1.total_cmp(&x.1).then(x.0.total_cmp(&y.0)));
    joints.retain(|(_, weight)| *weight > 0.0);
    joints.truncate(n);
    let kept: f32 = joints.iter().map(|(_, weight)| weight).sum();
    out.fill(0.0);
    for (i, (joint, weight)) in joints.into_iter().enumerate() {
        (out[i], out[n + i]) = (joint, weight * whole / kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_keep_their_length_and_joints_their_sum() {
        let mut normal = [0.0; 3];
        blend(Role::Normal, [&[1.0, 0.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 0.0, 1.0]], [0.5, 0.5, 0.0], &mut normal);
        assert!((normal[0] - 0.5f32.sqrt()).abs() < 1e-6 && normal[0] == normal[1] && normal[2] == 0.0);
        blend(Role::Normal, [&[1.0, 0.0, 0.0], &[-1.0, 0.0, 0.0], &[0.0; 3]], [0.5, 0.5, 0.0], &mut normal);
        assert_eq!(normal, [-1.0, 0.0, 0.0]);
        let mut skin = [0.0; 4];
        blend(Role::Skin, [&[3.0, 5.0, 0.5, 0.5], &[5.0, 7.0, 0.9, 0.1], &[0.0; 4]], [0.5, 0.5, 0.0], &mut skin);
        assert_eq!(skin[..2], [5.0, 3.0]);
        assert!((skin[2] + skin[3] - 1.0).abs() < 1e-6 && (skin[2] / skin[3] - 0.7 / 0.25).abs() < 1e-5);
    }

    #[test]
    fn a_tangent_without_a_sign_is_no_harm() {
        let mut tangent = [0.0; 3];
        blend(Role::Tangent, [&[1.0, 0.0, 0.0], &[0.0; 3], &[0.0; 3]], [1.0, 0.0, 0.0], &mut tangent);
        assert_eq!(tangent, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn what_weighs_nothing_does_not_count() {
        let mut uv = [0.0; 2];
        blend(Role::Uv, [&[1.0, 2.0], &[f32::NAN, 0.0], &[3.0, 4.0]], [0.5, 0.0, 0.5], &mut uv);
        assert_eq!(uv, [2.0, 3.0]);
    }
}
