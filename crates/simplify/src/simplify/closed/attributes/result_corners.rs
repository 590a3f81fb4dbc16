//! Corners of the result, which share their values in wedges.
//!
//! Every output face takes its group and its sides of seams from one input face. Faces around a vertex that meet at
//! edges other than seams share a wedge.

use glam::Vec3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::mesh::union_find::UnionFind;
use crate::mesh::{Attributes, Channel, Role};
use crate::parallel;
use crate::simplify::closed::faces_around::{FacesAround, smallest_first};
use crate::simplify::closed::original::{Original, SeamBoundedSearch, SurfacePoint};
use crate::simplify::closed::pins::Pins;

use super::blend::blend;
use super::normals::{fit_normals, straighten_tangents};
use super::values::{ResultWedges, ValueFit};

const NONE: u32 = u32::MAX;

pub struct ResultCorners {
    wedges: Vec<[u32; 3]>,
    origins: Vec<Vec<u32>>,
    vertices: Vec<u32>,
    /// Number of each wedge's normal, shared by wedges that no hard edge separates.
    normals: Vec<u32>,
}

impl ResultCorners {
    /// Builds the corners of the collapse's output; `vertex_of` maps surface vertices to output vertices.
    ///
    /// With `has_free_curves`, merges may have left the curves, which then no longer separate all charts.
    pub fn new(
        original: &Original,
        attributes: &Attributes,
        vertex_of: &[u32],
        (faces, around): (&[[u32; 3]], &FacesAround),
        has_free_curves: bool,
    ) -> Self {
        // Groups and wedges follow from the input face of each output face.
        let source_faces = find_source_faces(original, vertex_of, faces);
        let seams: FxHashSet<[u32; 2]> = original.features.edges_between(vertex_of).into_iter().collect();
        let hard: FxHashSet<[u32; 2]> = original.features.hard_edges_between(vertex_of).into_iter().collect();
        let (mut sets, mut smooth) = (UnionFind::new(3 * faces.len()), UnionFind::new(3 * faces.len()));
        let corner = |f: u32, v: u32| 3 * f + faces[f as usize].iter().position(|&w| w == v).unwrap_or(0) as u32;
        let group = |f: u32| match source_faces[f as usize] {
            NONE => NONE,
            face => attributes.group(face),
        };
        let charts = has_free_curves.then(|| number_charts(original, original.features.edges.iter().copied()));
        let smooth_charts = has_free_curves.then(|| number_charts(original, original.features.hard_edges()));
        let are_in_one = |charts: &Option<Vec<u32>>, faces: [u32; 2]| {
            let chart = |charts: &Vec<u32>, f: u32| charts.get(source_faces[f as usize] as usize).copied();
            charts.as_ref().is_none_or(|charts| chart(charts, faces[0]) == chart(charts, faces[1]))
        };
        for (f, &[a, b, c]) in (0u32..).zip(faces) {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                // Each edge is visited once, from its face of smaller number.
                let Some(g) = around.face_along(b, a).filter(|&g| g > f) else { continue };
                let (edge, corners) = ([a.min(b), a.max(b)], [a, b].map(|v| [corner(f, v), corner(g, v)]));
                if !seams.contains(&edge) && group(f) == group(g) && are_in_one(&charts, [f, g]) {
                    corners.iter().for_each(|[x, y]| _ = sets.union(*x, *y));
                }
                // Normals continue across texture seams and material borders.
                if !hard.contains(&edge) && are_in_one(&smooth_charts, [f, g]) {
                    corners.iter().for_each(|[x, y]| _ = smooth.union(*x, *y));
                }
            }
        }
        Self::from_sets([&mut sets, &mut smooth], faces, &source_faces)
    }

    fn from_sets([sets, smooth]: [&mut UnionFind; 2], faces: &[[u32; 3]], source_faces: &[u32]) -> Self {
        let mut number = vec![NONE; 3 * faces.len()];
        let (mut origins, mut vertices): (Vec<Vec<u32>>, Vec<u32>) = (Vec::new(), Vec::new());
        let mut wedge = |corner: usize| {
            let first = sets.find(corner as u32) as usize;
            if number[first] == NONE {
                number[first] = origins.len() as u32;
                origins.push(Vec::new());
                vertices.push(faces.as_flattened()[corner]);
            }
            let face = source_faces[corner / 3];
            origins[number[first] as usize].extend((face != NONE).then_some(face));
            number[first]
        };
        let wedges = (0..faces.len()).map(|f| [3 * f, 3 * f + 1, 3 * f + 2].map(&mut wedge)).collect();
        let mut corners = Self { normals: vec![NONE; origins.len()], wedges, origins, vertices };
        corners.number_normals(smooth);
        corners
    }

    fn number_normals(&mut self, smooth: &mut UnionFind) {
        let mut number = vec![NONE; 3 * self.wedges.len()];
        let mut n_normals = 0;
        for (corner, &wedge) in (0u32..).zip(self.wedges.as_flattened()) {
            let number = &mut number[smooth.find(corner) as usize];
            if *number == NONE {
                *number = n_normals;
                n_normals += 1;
            }
            self.normals[wedge as usize] = *number;
        }
    }

    pub fn is_seam(&self, faces: &[[u32; 3]], [f, g]: [u32; 2], [a, b]: [u32; 2]) -> bool {
        [a, b].into_iter().any(|v| self.wedge_at(faces, f, v) != self.wedge_at(faces, g, v))
    }

    /// Updates the wedges for a flip of the edge between faces `a b c` and `b a d`; must precede the flip.
    pub fn flip(&mut self, faces: &[[u32; 3]], [f, g]: [u32; 2], [a, b, c, d]: [u32; 4]) {
        let [wa, wb, wc] = [a, b, c].map(|v| self.wedge_at(faces, f, v));
        let wd = self.wedge_at(faces, g, d);
        (self.wedges[f as usize], self.wedges[g as usize]) = ([wc, wd, wb], [wd, wc, wa]);
    }

    fn wedge_at(&self, faces: &[[u32; 3]], f: u32, v: u32) -> u32 {
        let corner = faces[f as usize].iter().position(|&w| w == v).unwrap_or(0);
        self.wedges[f as usize][corner]
    }

    pub fn attributes(
        self,
        original: &Original,
        attributes: &Attributes,
        positions: &[Vec3],
        pins: &Pins,
    ) -> (Attributes, CornerMap) {
        // If the input has no groups, the output gets none.
        let groups = if attributes.groups.is_empty() { Vec::new() } else { self.groups(attributes) };
        let sides = original.seam_bounded_search();
        // The closest points give values for all channels, and the start of the fit.
        let surface_points = closest_points(&sides, &self.vertices, &self.origins, positions);
        let of_output =
            ResultWedges { face_wedges: &self.wedges, vertices: &self.vertices, surface_points: &surface_points };
        // Only values that a face interpolates are fitted; normals are fitted separately.
        let is_fitted = |channel: &Channel| matches!(channel.role, Role::Uv | Role::Colour | Role::MorphPosition);
        let fit = || ValueFit::new(&sides, of_output, positions, pins);
        let fit = (!pins.is_subset() && attributes.channels.iter().any(is_fitted)).then(fit);
        let channel = |channel: &Channel| {
            let nearest = interpolate_channel(channel, &attributes.wedges, &surface_points);
            match &fit {
                Some(fit) if is_fitted(channel) => fit.values(nearest, channel, &attributes.wedges),
                _ => nearest,
            }
        };
        let mut channels: Vec<Channel> = attributes.channels.iter().map(channel).collect();
        drop(fit);
        if !pins.is_subset() && attributes.channel(Role::Normal).is_some() {
            // The search for normals crosses texture seams and stops at hard edges.
            let sides = sides.with_seams(original.features.hard_edges());
            self.fit_normals(&mut channels, attributes, &sides, positions, pins);
        }
        // The map to the input contains the same points.
        let at_corners = self.wedges.iter().map(|wedges| wedges.map(|wedge| surface_points[wedge as usize]));
        let (faces, weights) = at_corners.map(|at| (at.map(|p| p.face), at.map(|p| p.weights))).unzip();
        let wedges = if channels.is_empty() { Vec::new() } else { self.wedges };
        (Attributes { wedges, channels, groups }, CornerMap { faces, weights })
    }

    fn fit_normals(
        &self,
        channels: &mut [Channel],
        attributes: &Attributes,
        sides: &SeamBoundedSearch,
        positions: &[Vec3],
        pins: &Pins,
    ) {
        let n_normals = self.normals.iter().max().map_or(0, |&most| most as usize + 1);
        // Wedges that share a normal are joined for this fit.
        let (mut origins, mut vertices) = (vec![Vec::new(); n_normals], vec![NONE; n_normals]);
        for (wedge, &normal) in self.normals.iter().enumerate() {
            origins[normal as usize].extend(&self.origins[wedge]);
            vertices[normal as usize] = self.vertices[wedge];
        }
        let face_wedges: Vec<[u32; 3]> =
            self.wedges.iter().map(|wedges| wedges.map(|w| self.normals[w as usize])).collect();
        let surface_points = closest_points(sides, &vertices, &origins, positions);
        let fit = ValueFit::new(
            sides,
            ResultWedges { face_wedges: &face_wedges, vertices: &vertices, surface_points: &surface_points },
            positions,
            pins,
        );
        // Locked vertices keep their values on each side of every seam.
        let may_change = |wedge: &usize| !pins.is_locked(self.vertices[*wedge]);
        let of_original = attributes.channels.iter().zip(channels.iter_mut());
        for (original, channel) in
            of_original.filter(|(original, _)| original.role == Role::Normal && original.width == 3)
        {
            let nearest = interpolate_channel(original, &attributes.wedges, &surface_points);
            let fitted = fit_normals(&fit, nearest, original, &attributes.wedges);
            for wedge in (0..self.normals.len()).filter(may_change) {
                channel.values[3 * wedge..][..3].copy_from_slice(fitted.value(self.normals[wedge]));
            }
        }
        straighten_tangents(channels, may_change);
    }

    fn groups(&self, attributes: &Attributes) -> Vec<u32> {
        let group = |wedges: &[u32; 3]| {
            let first = self.origins[wedges[0] as usize].first();
            first.map_or(0, |&face| attributes.group(face))
        };
        self.wedges.iter().map(group).collect()
    }
}

pub struct CornerMap {
    pub faces: Vec<[u32; 3]>,
    pub weights: Vec<[[f32; 3]; 3]>,
}

fn find_source_faces(original: &Original, vertex_of: &[u32], faces: &[[u32; 3]]) -> Vec<u32> {
    // Finds the number of an output face by its corners.
    let number: FxHashMap<[u32; 3], u32> = faces.iter().copied().zip(0..).collect();
    let mut source_faces = vec![NONE; faces.len()];
    for (face, corners) in (0u32..).zip(original.surface.faces.iter()) {
        let [a, b, c] = corners.map(|v| vertex_of[v as usize]);
        if a == b || b == c || c == a {
            continue;
        }
        let [x, y, z] = smallest_first([a, b, c]);
        // On a one-sided surface, such as a Möbius strip, the output may wind the face the other way.
        if let Some(&f) = number.get(&[x, y, z]).or_else(|| number.get(&[x, z, y])) {
            source_faces[f as usize] = face;
        }
    }
    source_faces
}

/// Numbers the charts into which edges divide the original, by face.
fn number_charts(original: &Original, edges: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let surface = &original.surface;
    let edges: FxHashSet<[u32; 2]> = edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    let around = FacesAround::new(surface.pulse, surface.n_vertices(), &surface.faces);
    let mut sets = UnionFind::new(surface.faces.len());
    for (f, &[a, b, c]) in (0u32..).zip(surface.faces.iter()) {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            if let Some(g) = around.face_along(b, a).filter(|_| !edges.contains(&[a.min(b), a.max(b)])) {
                sets.union(f, g);
            }
        }
    }
    sets.number_sets(surface.pulse).0
}

/// Finds the point of the original closest to each wedge's vertex, on the wedge's side of the seams.
fn closest_points(
    sides: &SeamBoundedSearch,
    vertices: &[u32],
    origins: &[Vec<u32>],
    positions: &[Vec3],
) -> Vec<SurfacePoint> {
    let closest = |i: usize| sides.closest_point(positions[vertices[i] as usize], &origins[i]);
    parallel::map(vertices.len(), 16, closest)
}

fn interpolate_channel(channel: &Channel, wedges: &[[u32; 3]], surface_points: &[SurfacePoint]) -> Channel {
    let width = channel.width;
    let mut values = vec![0.0; surface_points.len() * width];
    parallel::rows_mut(&mut values, width, 1024, |number, out| {
        let place = &surface_points[number];
        let corners = wedges[place.face as usize].map(|wedge| channel.value(wedge));
        blend(channel.role, corners, place.weights, out);
    });
    Channel { values, name: channel.name.clone(), ..*channel }
}
