//! Position grids that several meshes of an asset share.

use crate::io::gltf::references::list;
use glam::DMat4;
use rustc_hash::FxHashMap;
use serde_json::Value;

use crate::io::gltf::asset::Asset;
use crate::io::gltf::placements::placements;
use crate::io::gltf::simplified_part::SimplifiedPart;
use crate::io::packing::{LevelMesh, PackOptions, Packing, grid_for, unpacked_words};
use crate::mesh::longest_side;
use crate::mesh::union_find::UnionFind;

impl Asset {
    /// Chooses a grid for each of the [`parts`](Self::parts), valid in all `levels`; notes name parts that get none.
    ///
    /// Meshes of one skin share a grid, as do meshes with equal transforms and a position in common.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Asset, SimplifiedPart, PackOptions};
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let parts: Vec<SimplifiedPart> = asset.parts().iter().map(SimplifiedPart::from_part).collect();
    /// let (packing, notes) = asset.packing(&[&parts], &PackOptions { bits: 14, compress: false });
    /// assert!(packing.grid(0).is_some() && notes.is_empty());
    /// ```
    pub fn packing(&self, levels: &[&[SimplifiedPart]], options: &PackOptions) -> (Packing, Vec<String>) {
        let (sets, has_no_grid) = self.grid_sharing();
        let (mut grids, mut notes) = (vec![None; self.parts().len()], Vec::new());
        for members in sets {
            let of_members = levels.iter().flat_map(|level| members.iter().filter_map(|&part| level.get(part)));
            let meshes: Vec<LevelMesh> = of_members.map(|part| (&part.positions[..], &part.faces[..])).collect();
            // A part that must stay in single precision keeps all parts of its set in single precision.
            let is_free = members.iter().all(|&part| !has_no_grid[part]);
            // All levels count: each must survive the rounding.
            let grid = is_free.then(|| grid_for(&meshes, options.bits)).flatten();
            if grid.is_none() && meshes.iter().any(|(_, faces)| !faces.is_empty()) {
                notes.extend(
                    members.iter().map(|&part| format!("{}: positions {}", self.parts()[part].name, unpacked_words())),
                );
            }
            members.iter().for_each(|&part| grids[part] = grid);
        }
        (Packing { grids, compress: options.compress }, notes)
    }

    /// Returns for each part the longest side of the box that its grid covers.
    pub fn packing_sides(&self) -> Vec<f64> {
        let mut sides = vec![0.0; self.parts().len()];
        for members in self.grid_sharing().0 {
            let positions = members.iter().flat_map(|&part| &self.parts()[part].mesh.positions);
            let longest = longest_side(positions.copied());
            members.iter().for_each(|&part| sides[part] = longest);
        }
        sides
    }

    fn grid_sharing(&self) -> (Vec<Vec<usize>>, Vec<bool>) {
        let n = self.parts().len();
        let (mut sets, mut has_no_grid) = (UnionFind::new(n), self.parts_without_grid());
        self.join_by_skins(&mut sets, &mut has_no_grid);
        self.join_by_positions(&mut sets);
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); n];
        (0..n).for_each(|part| members[sets.find(part as u32) as usize].push(part));
        members.retain(|members| !members.is_empty());
        (members, has_no_grid)
    }

    fn parts_without_grid(&self) -> Vec<bool> {
        let root = &self.container.root;
        let names = list(&self.document, "extensionsUsed").iter();
        let has_bodies = names.filter_map(Value::as_str).any(|name| name.contains("physics"));
        // Lines, points, instances and physics rely on the original coordinates.
        let has_no_grid = |&mesh: &usize| {
            let is_repeated = root.nodes.iter().any(|node| node.mesh == Some(mesh) && node.instances().is_some());
            let mut primitives = root.meshes.get(mesh).into_iter().flat_map(|mesh| &mesh.primitives);
            has_bodies || is_repeated || primitives.any(|primitive| primitive.triangle_positions().is_none())
        };
        self.meshes.iter().map(has_no_grid).collect()
    }

    fn join_by_skins(&self, sets: &mut UnionFind, has_no_grid: &mut [bool]) {
        // The matrices of a skin undo one grid, which all its parts share.
        let mut first: FxHashMap<usize, Option<usize>> = FxHashMap::default();
        for node in &self.container.root.nodes {
            let (Some(skin), Some(mesh)) = (node.skin, node.mesh) else { continue };
            let part = self.meshes.binary_search(&mesh).ok();
            let known = *first.entry(skin).or_insert(part);
            match (known, part) {
                (Some(known), Some(part)) => {
                    sets.union(known as u32, part as u32);
                }
                (bound, other) => bound.into_iter().chain(other).for_each(|part| has_no_grid[part] = true),
            }
        }
    }

    fn join_by_positions(&self, sets: &mut UnionFind) {
        let mut first_at: FxHashMap<([u64; 16], [u64; 3]), u32> = FxHashMap::default();
        for placed in placements(&self.container.data()).unwrap_or_default() {
            let Ok(part) = self.meshes.binary_search(&placed.mesh) else { continue };
            // Joints position skinned meshes, so these can meet whatever their nodes.
            let transform = if placed.skinned { DMat4::IDENTITY } else { placed.transform };
            let transform = transform.to_cols_array().map(|x| (x + 0.0).to_bits());
            for position in &self.parts()[part].mesh.positions {
                let key = (transform, position.map(|x| (x + 0.0).to_bits()));
                let known = *first_at.entry(key).or_insert(part as u32);
                sets.union(known, part as u32);
            }
        }
    }
}
