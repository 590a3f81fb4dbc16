//! The meshes of an asset where the nodes of its default scene place them, as one mesh.

use glam::DMat4;

use super::asset::Asset;
use super::placements::placements;
use super::{is_far_out, spend};
use crate::io::ReadError;
use crate::mesh::{Looks, PlacedMesh, RawMesh, side_by_side};

/// Vertices and faces of a scene at most: more would only fill the memory.
const MOST: usize = 1 << 26;

impl Asset {
    /// The scene as one mesh: `meshes`, those of the [parts](Asset::parts) or what became of them, in their order, at
    /// all places where nodes put them; what no node places is not seen. Groups are numbered through, as
    /// [`Asset::scene_looks`] has them. Skins do not move it.
    ///
    /// # Errors
    /// [`ReadError`] where nodes repeat meshes to an extreme size.
    ///
    /// ```
    /// use neural_mesh::io::Asset;
    /// let asset = Asset::read_path("tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let meshes: Vec<_> = asset.parts().iter().map(|part| part.mesh.clone()).collect();
    /// assert_eq!(asset.placed(&meshes).unwrap().faces.len(), 4);
    /// ```
    pub fn placed(&self, meshes: &[RawMesh]) -> Result<RawMesh, ReadError> {
        let first_groups = self.first_groups();
        let mut budget = MOST;
        let mut placed = Vec::new();
        for (part, transform) in self.places()? {
            let Some(mesh) = meshes.get(part) else { continue };
            spend(&mut budget, mesh.positions.len() + mesh.faces.len() + mesh.attributes.n_wedges())?;
            placed.push(PlacedMesh { mesh, transform, first_group: first_groups[part] });
        }
        let mut scene = side_by_side(&placed, |_| true);
        scene.double = is_far_out(&scene.positions);
        Ok(scene)
    }

    /// What the groups of the scene as one mesh look like: [`Asset::looks`], part after part.
    pub fn scene_looks(&self) -> (Looks, Vec<String>) {
        let (of_parts, notes) = self.looks();
        (Looks { of_groups: of_parts.concat(), v_is_up: false, linear_colours: true }, notes)
    }

    /// The number of the first primitive of each part among those of all parts.
    fn first_groups(&self) -> Vec<u32> {
        let mut first = 0;
        let mut next = |part: &super::Part| {
            first += part.materials.len() as u32;
            first - part.materials.len() as u32
        };
        self.parts().iter().map(&mut next).collect()
    }

    /// Parts, by their number, and from their coordinates to the scene's at each place where they stand.
    fn places(&self) -> Result<Vec<(usize, DMat4)>, ReadError> {
        let data = self.container.data();
        let mut places = Vec::new();
        for placed in placements(&self.container.root)? {
            let Ok(part) = self.meshes.binary_search(&placed.mesh) else { continue };
            let transforms = placed.transforms(&data, MOST)?;
            places.extend(transforms.into_iter().filter(DMat4::is_finite).map(|transform| (part, transform)));
        }
        Ok(places)
    }
}
