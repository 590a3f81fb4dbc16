//! Document and result with the transforms of their scene.

use std::borrow::Cow;

use crate::io::{Packing, ReadError, SimplifiedPart};
use crate::mesh::cleanup::{CleanOptions, clean};
use crate::mesh::{Attributes, DistinctKeys, PositionGrid, RawMesh, TriMesh, UnitedMesh};
use crate::metrics::{QuickDistance, quick_distance};
use crate::simplify::Simplified;

use super::write::simplified_parts;
use super::{Document, Kind, PartPiece};

/// Mesh with the transforms of its scene.
pub struct PlacedSurface<'a> {
    /// Mesh in scene coordinates.
    pub mesh: Cow<'a, TriMesh>,
    /// Attributes of the mesh.
    pub attributes: Cow<'a, Attributes>,
}

impl Document {
    /// Returns the original and the result with the transforms of their scene, relative to one origin.
    pub fn place_surfaces(&self, result: &Simplified) -> Result<[PlacedSurface<'_>; 2], ReadError> {
        let Kind::Scene { asset, united, pieces } = &self.kind else {
            let result = PlacedSurface {
                mesh: Cow::Owned(result.mesh.clone()),
                attributes: Cow::Owned(result.attributes.clone()),
            };
            return Ok([
                PlacedSurface { mesh: Cow::Borrowed(self.mesh()), attributes: Cow::Borrowed(self.attributes()) },
                result,
            ]);
        };
        let before = (&united.mesh, &united.attributes);
        let mut origin = None;
        let mut place = |(mesh, attributes): (&TriMesh, &Attributes)| {
            let parts = simplified_parts(asset, united, pieces, mesh, attributes);
            let meshes: Vec<RawMesh> = parts.into_iter().map(as_raw).collect();
            let mut scene = asset.scene_mesh(&meshes)?;
            if scene.faces.is_empty() {
                // No node refers to a mesh: the mesh is used without transforms.
                return Ok(PlacedSurface {
                    mesh: Cow::Owned(mesh.clone()),
                    attributes: Cow::Owned(Attributes::default()),
                });
            }
            let origin = *origin.get_or_insert(scene.positions.first().copied().unwrap_or_default());
            scene.positions.iter_mut().flatten().zip(origin.into_iter().cycle()).for_each(|(x, from)| *x -= from);
            scene.double = false;
            let cleaned = clean(scene, &CleanOptions::default());
            let (mesh, attributes) = cleaned.map_or_else(|_| Default::default(), |it| (it.mesh, it.attributes));
            Ok(PlacedSurface { mesh: Cow::Owned(mesh), attributes: Cow::Owned(attributes) })
        };
        Ok([place(before)?, place((&result.mesh, &result.attributes))?])
    }

    fn view_of<'a>(&self, mesh: &'a TriMesh, attributes: &Attributes) -> Cow<'a, TriMesh> {
        match &self.kind {
            Kind::Mesh { .. } => Cow::Borrowed(mesh),
            Kind::Scene { united, .. } => Cow::Owned(united.view(mesh, attributes).mesh),
        }
    }

    /// Measures the distance between packed result and original; `None` if a mesh is empty.
    pub fn distance(&self, result: &Simplified, packing: Option<&Packing>, n_samples: usize) -> Option<QuickDistance> {
        let packed = match &self.kind {
            Kind::Mesh { .. } => {
                let around = if self.frame.double { [0.0; 3] } else { self.frame.origin };
                on_grid(&result.mesh, packing.and_then(|packing| packing.grid(0)), around)
            }
            Kind::Scene { united, pieces, .. } => on_grids(result, united, pieces, packing),
        };
        let original = self.view_of(self.mesh(), self.attributes());
        quick_distance(&original, &self.view_of(&packed, &result.attributes), n_samples, 0)
    }
}

fn on_grids<'a>(
    result: &'a Simplified,
    united: &UnitedMesh,
    pieces: &[Option<PartPiece>],
    packing: Option<&Packing>,
) -> Cow<'a, TriMesh> {
    let Some(packing) = packing else { return Cow::Borrowed(&result.mesh) };
    let mut grid_of = vec![(None, [0.0; 3]); pieces.iter().flatten().count()];
    for (part, piece) in pieces.iter().enumerate().filter_map(|(part, piece)| Some((part, (*piece)?))) {
        grid_of[piece.number] = (packing.grid(part), piece.origin.map(f64::from));
    }
    // Pieces that touch have common vertices, which each rounds on its own grid.
    let mut placed: DistinctKeys<(usize, u32)> = DistinctKeys::default();
    let mut place = |face: &[u32; 3], piece: usize| face.map(|v| placed.number((piece, v)));
    let groups = (0..).map(|f| united.piece_of_group(result.attributes.group(f)));
    let faces = result.mesh.faces().iter().zip(groups).map(|(face, piece)| place(face, piece)).collect();
    let positions = placed.keys.iter().map(|&(piece, v)| {
        let p = result.mesh.positions()[v as usize];
        let ((Some(grid), origin), scale) = (grid_of[piece], united.scale(piece)) else { return p };
        let own = std::array::from_fn(|axis| f64::from(p[axis]) / scale + origin[axis]);
        let rounded = grid.point(grid.round(own));
        std::array::from_fn(|axis| ((rounded[axis] - origin[axis]) * scale) as f32)
    });
    TriMesh::new(positions.collect(), faces).map_or(Cow::Borrowed(&result.mesh), Cow::Owned)
}

// `around` is the mesh's local origin in the coordinates of the grid.
fn on_grid<'a>(mesh: &'a TriMesh, grid: Option<&PositionGrid>, around: [f64; 3]) -> Cow<'a, TriMesh> {
    let Some(grid) = grid else { return Cow::Borrowed(mesh) };
    let rounded = |p: &[f32; 3]| {
        let place = grid.point(grid.round(std::array::from_fn(|axis| f64::from(p[axis]) + around[axis])));
        std::array::from_fn(|axis| (place[axis] - around[axis]) as f32)
    };
    let moved = TriMesh::new(mesh.positions().iter().map(rounded).collect(), mesh.faces().to_vec());
    moved.map_or(Cow::Borrowed(mesh), Cow::Owned)
}

fn as_raw(part: SimplifiedPart) -> RawMesh {
    let SimplifiedPart { positions, faces, attributes, .. } = part;
    let positions = positions.into_iter().map(|position| position.map(f64::from)).collect();
    let mut raw = RawMesh::new(positions, faces);
    raw.attributes = attributes;
    raw
}
