//! Meshes of an asset as one mesh, with the transforms of its default scene.

use glam::DMat4;

use super::asset::Asset;
use super::placements::placements;
use super::refusals::spend;
use crate::io::ReadError;
use crate::io::far_from_origin::is_far_from_origin;
use crate::mesh::{Looks, PlacedMesh, RawMesh, merge_placed_meshes};

/// Largest number of vertices and faces: the first times the bytes of the asset, plus the second.
const REPEATS: (usize, usize) = (256, 1 << 22);
const MOST: usize = 1 << 26;

impl Asset {
    /// Joins `meshes`, versions of the [parts](Asset::parts), with the transforms of their nodes; drops parts without a
    /// node.
    ///
    /// # Errors
    /// [`ReadError`] if nodes repeat meshes to an extreme size.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let meshes: Vec<_> = asset.parts().iter().map(|part| part.mesh.clone()).collect();
    /// assert_eq!(asset.scene_mesh(&meshes).unwrap().faces.len(), 4);
    /// ```
    pub fn scene_mesh(&self, meshes: &[RawMesh]) -> Result<RawMesh, ReadError> {
        let first_groups = self.first_groups();
        let cost = |mesh: &RawMesh| mesh.positions.len() + mesh.faces.len() + mesh.attributes.n_wedges();
        // Costs are checked before anything is joined.
        let places = self.list_placements(|part| meshes.get(part).map_or(0, cost))?;
        let meshes: Vec<_> = meshes.iter().enumerate().map(|(part, mesh)| self.with_transforms(part, mesh)).collect();
        let placed = places.into_iter().filter_map(|(part, transform)| {
            Some(PlacedMesh { mesh: meshes.get(part)?, transform, first_group: first_groups[part] })
        });
        let placed: Vec<PlacedMesh> = placed.collect();
        let mut scene = merge_placed_meshes(&placed, |_| true);
        scene.double = is_far_from_origin(&scene.positions);
        Ok(scene)
    }

    /// Reads the materials of [`scene_mesh`](Self::scene_mesh)'s groups, and one line per problem.
    pub fn scene_looks(&self) -> (Looks, Vec<String>) {
        let (of_parts, notes) = self.looks();
        (Looks { of_groups: of_parts.concat(), v_is_up: false, linear_colours: true }, notes)
    }

    fn first_groups(&self) -> Vec<u32> {
        let mut first = 0;
        let mut next = |part: &super::AssetPart| {
            first += part.materials.len() as u32;
            first - part.materials.len() as u32
        };
        self.parts().iter().map(&mut next).collect()
    }

    /// Returns the transforms of each of the [parts](Asset::parts); the identity if no part has a node.
    ///
    /// # Errors
    /// [`ReadError`] if nodes repeat meshes to an extreme size.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// assert_eq!(asset.part_transforms().unwrap()[0].len(), 1);
    /// ```
    pub fn part_transforms(&self) -> Result<Vec<Vec<DMat4>>, ReadError> {
        let mut places = vec![Vec::new(); self.parts().len()];
        let all = self.list_placements(|_| 0)?;
        // Some files have meshes and do not place them.
        if all.is_empty() {
            places.fill(vec![DMat4::IDENTITY]);
        }
        all.into_iter().for_each(|(part, place)| places[part].push(place));
        Ok(places)
    }

    fn list_placements(&self, cost: impl Fn(usize) -> usize) -> Result<Vec<(usize, DMat4)>, ReadError> {
        let data = self.container.data();
        let mut budget = MOST.min(REPEATS.0.saturating_mul(self.n_bytes).saturating_add(REPEATS.1));
        let mut places = Vec::new();
        for placed in placements(&data)? {
            // Mesh indices of the parts are ascending.
            let Ok(part) = self.meshes.binary_search(&placed.mesh) else { continue };
            let n_places = placed.n_instances(&data)?;
            // The charge precedes the transforms: an accessor of zeros may claim any number.
            spend(&mut budget, n_places.saturating_mul(1 + cost(part)))?;
            let transforms = placed.transforms(&data, MOST)?;
            places.extend(transforms.into_iter().filter(DMat4::is_finite).map(|transform| (part, transform)));
        }
        Ok(places)
    }
}

#[cfg(test)]
mod tests {
    use crate::io::{Asset, ReadError};
    use crate::mesh::RawMesh;

    #[test]
    fn instances_of_zeros_are_refused_before_they_are_made() {
        let scene = |count: usize| {
            let text = format!(
                r#"{{"nodes": [{{"mesh": 0, "extensions": {{"EXT_mesh_gpu_instancing": {{"attributes": {{"TRANSLATION": 1}}}}}}}}],
                "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
                "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
                    {{"componentType": 5126, "count": {count}, "type": "VEC3"}}],
                "bufferViews": [{{"buffer": 0, "byteLength": 36}}], "buffers": [{{"uri": "a.bin"}}]}}"#
            );
            let bytes = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
            let asset = Asset::from_bytes(text.as_bytes(), &|_| Ok(bytes.clone())).unwrap();
            let meshes: Vec<RawMesh> = asset.parts().iter().map(|part| part.mesh.clone()).collect();
            asset.scene_mesh(&meshes).map(|scene: RawMesh| scene.faces.len())
        };
        assert_eq!(scene(7), Ok(7));
        for count in [1 << 20, 22_000_000, usize::MAX] {
            let error: ReadError = scene(count).unwrap_err();
            assert!(error.what.contains("repeats its meshes too often"), "{count}: {error}");
        }
    }
}
