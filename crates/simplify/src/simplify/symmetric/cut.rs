//! The half of a mesh above the mirror plane.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::mesh::{Attributes, Channel, TriMesh, compact, edges};
use crate::simplify::SimplifyError;
use crate::simplify::closed::blend;

use super::image_plane::ImagePlane;
use super::mirror_pairs::MirrorPairs;

pub(super) struct HalfMesh {
    pub mesh: TriMesh,
    pub attributes: Attributes,
    pub importance: Vec<f32>,
    pub on_plane: Vec<bool>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum PlaneSide {
    Above,
    On,
    Below,
}

/// Cuts a mesh along the plane and keeps the half above it.
///
/// # Errors
/// [`SimplifyError::InMirrorPlane`] if faces are in the plane; [`SimplifyError::Empty`] if nothing is above it.
pub(super) fn cut(
    (mesh, attributes, importance): (&TriMesh, Attributes, &[f32]),
    plane: &ImagePlane,
    pairs: &MirrorPairs,
) -> Result<HalfMesh, SimplifyError> {
    let sides = sides(mesh, plane, pairs);
    // A face in the plane would coincide with its image.
    let lies_in_plane = |face: &&[u32; 3]| face.iter().all(|&v| sides[v as usize] == PlaneSide::On);
    match mesh.faces().iter().filter(lies_in_plane).count() {
        0 => {}
        n => return Err(SimplifyError::InMirrorPlane(n)),
    }
    // The share of an edge's length at which the edge crosses the plane.
    let crossing = |a: u32, b: u32| {
        let [x, y] = [a, b].map(|v| plane.height(mesh.positions()[v as usize]).abs());
        let crosses = [PlaneSide::Above, PlaneSide::Below]
            .into_iter()
            .all(|side| [a, b].iter().any(|&v| sides[v as usize] == side));
        crosses.then(|| if x + y > 0.0 { (x / (x + y)) as f32 } else { 0.5 })
    };
    let faces = mesh.faces().to_vec();
    let mut sheet = Sheet { positions: mesh.positions().to_vec(), faces, attributes, importance: importance.to_vec() };
    sheet.refine(&crossing, &|v| sides[v as usize] != PlaneSide::Below);
    let mut on_plane: Vec<bool> = sides.iter().map(|side| *side == PlaneSide::On).collect();
    // New vertices of the first cut are on the plane, those on split bridges (inner edges between vertices on the
    // plane) are not.
    on_plane.resize(sheet.positions.len(), true);
    sheet.split_bridges(&on_plane)?;
    on_plane.resize(sheet.positions.len(), false);
    sheet.into_half(plane, &on_plane)
}

fn sides(mesh: &TriMesh, plane: &ImagePlane, pairs: &MirrorPairs) -> Vec<PlaneSide> {
    let side = |(v, &p): (u32, &[f32; 3])| match plane.height(p) {
        _ if pairs.vertices[v as usize] == v || plane.touches(p) => PlaneSide::On,
        height if height > 0.0 => PlaneSide::Above,
        _ => PlaneSide::Below,
    };
    (0..).zip(mesh.positions()).map(side).collect()
}

struct Sheet {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    attributes: Attributes,
    importance: Vec<f32>,
}

impl Sheet {
    /// Splits edges at the share that `split` returns, from the end of smaller number, and drops corners that are not
    /// kept.
    fn refine(&mut self, split: &dyn Fn(u32, u32) -> Option<f32>, is_kept: &dyn Fn(u32) -> bool) {
        let before = std::mem::take(&mut self.faces);
        let rows = std::mem::take(&mut self.attributes.wedges);
        let groups = std::mem::take(&mut self.attributes.groups);
        let (mut vertices, mut wedges) = (FxHashMap::default(), FxHashMap::default());
        for (f, face) in before.iter().enumerate() {
            let row = rows.get(f).copied().unwrap_or_default();
            // Kept corners and cut points in order form a polygon.
            let mut corners: Vec<(u32, u32)> = Vec::with_capacity(6);
            let mut first = 0;
            for k in 0..3 {
                let [here, next] = [k, (k + 1) % 3].map(|k| (face[k], row[k]));
                corners.extend(is_kept(here.0).then_some(here));
                // Both faces of an edge must split it at one point, so its direction is fixed.
                let ends = if here.0 < next.0 { [here, next] } else { [next, here] };
                if let Some(t) = split(ends[0].0, ends[1].0) {
                    first = corners.len();
                    corners.push(self.point_between(ends, t, &mut vertices, &mut wedges));
                }
            }
            // A fan from a new corner has no three corners in a line.
            let rest: Vec<(u32, u32)> =
                corners[first.min(corners.len())..].iter().chain(&corners[..first]).copied().collect();
            for pair in rest.get(1..).unwrap_or_default().windows(2) {
                let triangle = [rest[0], pair[0], pair[1]];
                self.faces.push(triangle.map(|(v, _)| v));
                self.attributes.wedges.extend((!rows.is_empty()).then(|| triangle.map(|(_, wedge)| wedge)));
                self.attributes.groups.extend(groups.get(f));
            }
        }
    }

    /// Returns the vertex and wedge at a share of the way between two corners; adds them on first use.
    fn point_between(
        &mut self,
        [a, b]: [(u32, u32); 2],
        t: f32,
        vertices: &mut FxHashMap<[u32; 2], u32>,
        wedges: &mut FxHashMap<[u32; 2], u32>,
    ) -> (u32, u32) {
        let vertex = *vertices.entry([a.0, b.0]).or_insert_with(|| {
            let [p, q] = [a.0, b.0].map(|v| self.positions[v as usize]);
            self.positions.push(std::array::from_fn(|k| p[k] + t * (q[k] - p[k])));
            let between = |factors: &[f32]| factors[a.0 as usize] + t * (factors[b.0 as usize] - factors[a.0 as usize]);
            if !self.importance.is_empty() {
                self.importance.push(between(&self.importance));
            }
            self.positions.len() as u32 - 1
        });
        if self.attributes.channels.is_empty() {
            return (vertex, 0);
        }
        // Wedges are split separately: at a seam the new vertex has two values.
        let wedge = *wedges.entry([a.1, b.1]).or_insert_with(|| {
            self.attributes.channels.iter_mut().for_each(|channel| add_between(channel, [a.1, b.1], t));
            self.attributes.n_wedges() as u32 - 1
        });
        (vertex, wedge)
    }

    fn split_bridges(&mut self, on_plane: &[bool]) -> Result<(), SimplifyError> {
        let mesh = TriMesh::new(self.positions.clone(), self.faces.clone()).map_err(|_| SimplifyError::Overflow)?;
        let bridges = edges(&mesh).into_iter().filter(|edge| edge.n_faces() > 1);
        let bridges = bridges.filter(|edge| edge.ends.iter().all(|&v| on_plane[v as usize]));
        let bridges: FxHashSet<[u32; 2]> = bridges.map(|edge| edge.ends).collect();
        if !bridges.is_empty() {
            self.refine(&|a, b| bridges.contains(&[a, b]).then_some(0.5), &|_| true);
        }
        Ok(())
    }

    fn into_half(self, plane: &ImagePlane, on_plane: &[bool]) -> Result<HalfMesh, SimplifyError> {
        if self.faces.is_empty() {
            return Err(SimplifyError::Empty);
        }
        let (mesh, sources) = compact(&self.positions, self.faces).map_err(|_| SimplifyError::Overflow)?;
        let flags: Vec<bool> = sources.iter().map(|&v| on_plane[v as usize]).collect();
        // A vertex is on the cut only if it has a boundary edge there.
        let along_cut = edges(&mesh).into_iter().filter(|edge| edge.n_faces() == 1);
        let mut on_plane = vec![false; flags.len()];
        let along_cut = along_cut.filter(|edge| edge.ends.iter().all(|&v| flags[v as usize]));
        along_cut.flat_map(|edge| edge.ends).for_each(|v| on_plane[v as usize] = true);
        let (positions, faces) = mesh.into_parts();
        let positions = positions.into_iter().zip(&on_plane).map(|(p, &on_plane)| plane.snap(p, on_plane)).collect();
        let importance = match &self.importance[..] {
            [] => Vec::new(),
            importance => sources.iter().map(|&v| importance[v as usize]).collect(),
        };
        let mesh = TriMesh::new(positions, faces).map_err(|_| SimplifyError::Overflow)?;
        Ok(HalfMesh { mesh, attributes: self.attributes, importance, on_plane })
    }
}

fn add_between(channel: &mut Channel, [a, b]: [u32; 2], t: f32) {
    let mut value = vec![0.0; channel.width];
    blend(channel.role, [channel.value(a), channel.value(b), channel.value(b)], [1.0 - t, t, 0.0], &mut value);
    channel.values.extend(value);
}
