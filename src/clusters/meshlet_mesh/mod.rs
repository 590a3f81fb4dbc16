//! Bevy's format of hierarchies, `.meshlet_mesh`, version 3 (Bevy 0.18 to 0.20).
//!
//! Clusters of one group are stored side by side and hang as one leaf in a tree of boxes and spheres, which the GPU
//! walks. Bevy compresses the content by LZ4; here its frame holds stored blocks, which every reader accepts.

mod bounds_tree;
mod numbers;
mod packed_vertices;

use crate::mesh::Role;
use crate::mesh::value_bytes::Stored;
use crate::spatial::Bounds;

use super::{Cluster, Clusters, Sphere};
use bounds_tree::{BoundsTree, Leaf};
use numbers::center_and_half;
use packed_vertices::{PackedPositions, octahedral, vertex_normals};

const MAGIC: u64 = 1_717_551_717_668;
const VERSION: u64 = 3;
/// Most faces of a meshlet.
const MOST_FACES: u32 = 128;
/// Most meshlets of a leaf; larger groups take several.
const MOST_OF_LEAF: usize = 254;
/// An LZ4 frame of independent blocks of at most 64 KiB, without checksums of content: magic, flags, checksum of flags.
const FRAME_HEADER: [u8; 7] = [0x04, 0x22, 0x4d, 0x18, 0x60, 0x40, 0x82];
const BLOCK: usize = 1 << 16;
/// Flag of a block that is stored as it is.
const STORED: u32 = 1 << 31;

/// Reason why a hierarchy cannot be written for Bevy.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshletMeshError {
    /// Cluster of more than 128 faces; holds their number.
    TooManyFaces(u32),
    /// Coordinates or sizes beyond those the format can hold.
    TooLarge,
}

impl std::fmt::Display for MeshletMeshError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooManyFaces(n) => {
                write!(f, "a cluster of {n} faces: Bevy draws at most {MOST_FACES}; build with at most as many")
            }
            Self::TooLarge => write!(f, "too large for the meshlets of Bevy: scale the mesh down, or split it"),
        }
    }
}

impl std::error::Error for MeshletMeshError {}

impl Clusters {
    /// Writes the hierarchy as the bytes of a `.meshlet_mesh` of Bevy.
    ///
    /// Positions are rounded to a grid, the same for all clusters, so that no crack opens. Normals are those of the mesh, or
    /// means of its faces; texture coordinates are those of the first set, or 0. All faces get the one material of the entity.
    ///
    /// # Errors
    /// [`MeshletMeshError`] for clusters of more than 128 faces, or for sizes beyond the format.
    ///
    /// ```
    /// use std::ops::ControlFlow;
    /// use neural_mesh::clusters::{ClusterOptions, build_clusters};
    /// use neural_mesh::{mesh::shapes, simplify::Input};
    /// let mesh = shapes::icosphere(4);
    /// let go_on = &mut |_| ControlFlow::Continue(());
    /// let clusters = build_clusters(&Input::bare(&mesh), &ClusterOptions::default(), go_on).unwrap();
    /// let bytes = clusters.to_meshlet_mesh().unwrap();
    /// assert_eq!(bytes[8..16], 3u64.to_le_bytes());
    /// ```
    pub fn to_meshlet_mesh(&self) -> Result<Vec<u8>, MeshletMeshError> {
        if let Some(cluster) = self.clusters.iter().find(|cluster| cluster.n_faces > MOST_FACES) {
            return Err(MeshletMeshError::TooManyFaces(cluster.n_faces));
        }
        // Clusters of one group are neighbours; the root has none.
        let mut order: Vec<u32> = (0..self.clusters.len() as u32).collect();
        order.sort_by_key(|&cluster| self.clusters[cluster as usize].group.unwrap_or(u32::MAX));
        let boxes: Vec<Bounds> = order.iter().map(|&cluster| self.bounds_of(cluster)).collect();
        let tree = BoundsTree::new(self.leaves(&order, &boxes));
        let mut content = Vec::new();
        let meshlets = self.write_vertices(&order, &mut content)?;
        self.write_indices(&order, &mut content);
        tree.write(&mut content);
        order.len().write(&mut content);
        content.extend(meshlets);
        order.len().write(&mut content);
        for (&cluster, bounds) in order.iter().zip(&boxes) {
            self.write_cull_data(&self.clusters[cluster as usize], bounds, &mut content);
        }
        Ok(frame(&tree, &content))
    }

    fn bounds_of(&self, cluster: u32) -> Bounds {
        let points: Vec<[f32; 3]> = self.vertices_of(cluster).iter().map(|&v| self.positions[v as usize]).collect();
        Bounds::from_points(&points)
    }

    /// Returns a leaf for each run of clusters of one group.
    fn leaves(&self, order: &[u32], boxes: &[Bounds]) -> Vec<Leaf> {
        let group = |&cluster: &u32| self.clusters[cluster as usize].group;
        let mut first = 0;
        let runs = order.chunk_by(|x, y| group(x) == group(y)).flat_map(|run| run.chunks(MOST_OF_LEAF));
        runs.map(|run| {
            let range = first..first + run.len();
            first = range.end;
            let bounds = boxes[range.clone()].iter().fold(Bounds::EMPTY, |all, own| all.union(own));
            let own = group(&run[0]).map(|group| &self.groups[group as usize]);
            let spheres = run.iter().map(|&cluster| self.lod_sphere(&self.clusters[cluster as usize]));
            Leaf {
                level: run.iter().map(|&cluster| self.clusters[cluster as usize].level).max().unwrap_or(0),
                bounds,
                sphere: own.map_or_else(|| Sphere::enclose(spheres), |group| group.sphere),
                // Nothing takes the root's place.
                error: own.map_or(f32::MAX, |group| group.error),
                first: range.start as u32,
                n_meshlets: run.len() as u8,
            }
        })
        .collect()
    }

    /// Returns the sphere of the group that made a cluster; at level 0 the cluster's own.
    fn lod_sphere(&self, cluster: &Cluster) -> Sphere {
        cluster.source.map_or(cluster.sphere, |group| self.groups[group as usize].sphere)
    }

    fn vertices_of(&self, cluster: u32) -> &[u32] {
        let cluster = &self.clusters[cluster as usize];
        &self.vertices[cluster.first_vertex as usize..][..cluster.n_vertices as usize]
    }

    /// Writes positions, normals and texture coordinates; returns the rows of the array of meshlets.
    fn write_vertices(&self, order: &[u32], content: &mut Vec<u8>) -> Result<Vec<u8>, MeshletMeshError> {
        let mut packed = PackedPositions::new(&self.positions).ok_or(MeshletMeshError::TooLarge)?;
        let (mut rows, mut vertices, mut n_corners) = (Vec::new(), Vec::new(), 0u32);
        for &cluster in order {
            let own = self.vertices_of(cluster);
            let first_bit = packed.n_bits();
            let channels = packed.push(own.iter().map(|&v| self.positions[v as usize]));
            let first_bit = u32::try_from(first_bit).map_err(|_| MeshletMeshError::TooLarge)?;
            [first_bit, vertices.len() as u32, n_corners].write(&mut rows);
            let n_faces = self.clusters[cluster as usize].n_faces;
            rows.extend([(own.len() - 1) as u8, n_faces as u8, 0, 0]);
            rows.extend(channels.map(|(bits, _)| bits));
            rows.push(packed.factor());
            channels.into_iter().for_each(|(_, least)| (least as f32).write(&mut rows));
            vertices.extend_from_slice(own);
            n_corners = n_corners.checked_add(3 * n_faces).ok_or(MeshletMeshError::TooLarge)?;
        }
        packed.write(content);
        let normals = vertex_normals(self);
        vertices.len().write(content);
        vertices.iter().for_each(|&v| octahedral(normals[v as usize]).write(content));
        let uvs = self.channels.iter().find(|channel| channel.role == Role::Uv);
        vertices.len().write(content);
        for &v in &vertices {
            uvs.map_or([0.0; 2], |uvs| [uvs.value(v)[0], uvs.value(v)[1]]).write(content);
        }
        Ok(rows)
    }

    fn write_indices(&self, order: &[u32], content: &mut Vec<u8>) {
        let mut indices: Vec<u8> = Vec::with_capacity(3 * self.faces.len());
        for &cluster in order {
            let cluster = &self.clusters[cluster as usize];
            let faces = &self.faces[cluster.first_face as usize..][..cluster.n_faces as usize];
            indices.extend(faces.as_flattened());
        }
        // Arrays are whole words.
        indices.resize(indices.len().next_multiple_of(4), 0);
        indices.write(content);
    }

    fn write_cull_data(&self, cluster: &Cluster, bounds: &Bounds, content: &mut Vec<u8>) {
        let (center, half) = center_and_half(bounds);
        let error = cluster.source.map_or(0.0, |group| self.groups[group as usize].error);
        ((center, error), (half, 0u32)).write(content);
        self.lod_sphere(cluster).write(content);
    }
}

/// Joins the head of the file, which is not compressed, and the content in an LZ4 frame.
fn frame(tree: &BoundsTree, content: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(content.len() + content.len() / BLOCK * 4 + 64);
    [MAGIC, VERSION].write(&mut bytes);
    let (center, half) = center_and_half(&tree.bounds());
    (center, half).write(&mut bytes);
    tree.depth().write(&mut bytes);
    bytes.extend(FRAME_HEADER);
    for block in content.chunks(BLOCK) {
        (block.len() as u32 | STORED).write(&mut bytes);
        bytes.extend(block);
    }
    0u32.write(&mut bytes);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clusters::{ClusterOptions, ViewPoint, build_clusters};
    use crate::mesh::shapes;
    use crate::simplify::Input;
    use glam::Vec3;
    use std::collections::BTreeSet;
    use std::ops::ControlFlow;

    struct Arrays {
        positions: Vec<u8>,
        normals: Vec<u8>,
        indices: Vec<u8>,
        nodes: Vec<u8>,
        meshlets: Vec<u8>,
        cull_data: Vec<u8>,
    }

    fn u32_at(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    fn f32_at(bytes: &[u8], at: usize) -> f32 {
        f32::from_bits(u32_at(bytes, at))
    }

    fn decode(bytes: &[u8]) -> Arrays {
        assert_eq!(bytes[..8], [0x24, 0x5d, 0x0f, 0xe6, 0x8f, 0x01, 0, 0]);
        let (mut rest, mut content) = (&bytes[44 + FRAME_HEADER.len()..], Vec::new());
        loop {
            let size = u32_at(rest, 0);
            rest = &rest[4..];
            if size == 0 {
                break;
            }
            let (block, after) = rest.split_at((size & !STORED) as usize);
            content.extend(block);
            rest = after;
        }
        assert!(rest.is_empty());
        let mut rest = &content[..];
        let mut array = |stride: usize| {
            let count = u64::from_le_bytes(rest[..8].try_into().unwrap()) as usize;
            let (own, after) = rest[8..].split_at(count * stride);
            rest = after;
            assert!(!own.is_empty() && own.len() % 4 == 0);
            own.to_vec()
        };
        let (positions, normals, _uvs, indices) = (array(4), array(4), array(8), array(1));
        Arrays { positions, normals, indices, nodes: array(400), meshlets: array(32), cull_data: array(48) }
    }

    impl Arrays {
        fn position(&self, meshlet: usize, vertex: u32) -> [f32; 3] {
            let row = &self.meshlets[32 * meshlet..][..32];
            let bits = [row[16], row[17], row[18]].map(u32::from);
            let mut at = u32_at(row, 0) + vertex * bits.iter().sum::<u32>();
            std::array::from_fn(|k| {
                let bit = |i: u32| u32_at(&self.positions, 4 * (i / 32) as usize) >> (i % 32) & 1;
                let value = (0..bits[k]).map(|i| bit(at + i) << i).sum::<u32>();
                at += bits[k];
                (value as f32 + f32_at(row, 20 + 4 * k)) / ((1u32 << row[19]) as f32 * 100.0)
            })
        }

        fn faces(&self, meshlet: usize) -> Vec<[[f32; 3]; 3]> {
            let row = &self.meshlets[32 * meshlet..][..32];
            let corners = &self.indices[u32_at(row, 8) as usize..][..3 * usize::from(row[13])];
            corners.as_chunks().0.iter().map(|face: &[u8; 3]| face.map(|v| self.position(meshlet, v.into()))).collect()
        }

        /// Walks the tree as the shaders do; returns the drawn meshlets.
        fn list_drawn(&self, view: &ViewPoint, pixels: f64) -> BTreeSet<u32> {
            let is_small = |sphere: &[u8], error: f32| {
                let sphere = Sphere { center: [0, 4, 8].map(|at| f32_at(sphere, at)), radius: f32_at(sphere, 12) };
                f64::from(error) * view.pixels / sphere.distance(view.eye).max(view.near) <= pixels
            };
            let (mut pending, mut drawn) = (vec![0usize], BTreeSet::new());
            while let Some(node) = pending.pop() {
                let node = &self.nodes[400 * node..][..400];
                for child in (0..8).take_while(|child| node[384 + child] > 0) {
                    let (entry, offset) = (&node[32 * child..], u32_at(node, 32 * child + 28));
                    if is_small(&node[256 + 16 * child..], f32_at(entry, 12)) {
                        continue;
                    }
                    match node[384 + child] {
                        IS_NODE => pending.push(offset as usize),
                        n => drawn.extend((offset..offset + u32::from(n)).filter(|&meshlet| {
                            let data = &self.cull_data[48 * meshlet as usize..];
                            is_small(&data[32..], f32_at(data, 12))
                        })),
                    }
                }
            }
            drawn
        }
    }

    const IS_NODE: u8 = u8::MAX;

    fn torus() -> Clusters {
        let mesh = shapes::torus(120, 60, 2.0, 0.6);
        let options = ClusterOptions { max_faces: 32, clusters_per_group: 6, ..ClusterOptions::default() };
        build_clusters(&Input::bare(&mesh), &options, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn the_tree_draws_the_cut_of_every_view() {
        let clusters = torus();
        let arrays = decode(&clusters.to_meshlet_mesh().unwrap());
        let mut order: Vec<u32> = (0..clusters.clusters.len() as u32).collect();
        order.sort_by_key(|&cluster| clusters.clusters[cluster as usize].group.unwrap_or(u32::MAX));
        for step in 0..20 {
            let view = ViewPoint { eye: [0.4 * step as f32, 1.0, 3.0], pixels: 800.0, near: 0.1 };
            let pixels = 0.02 * 1.6f64.powi(step);
            let drawn: BTreeSet<u32> =
                arrays.list_drawn(&view, pixels).into_iter().map(|m| order[m as usize]).collect();
            assert_eq!(drawn, clusters.cut_for_view(&view, pixels).into_iter().collect(), "{step}");
        }
    }

    #[test]
    fn positions_are_those_of_the_clusters_on_a_grid() {
        let clusters = torus();
        let arrays = decode(&clusters.to_meshlet_mesh().unwrap());
        let n_faces: usize = (0..clusters.clusters.len()).map(|meshlet| arrays.faces(meshlet).len()).sum();
        assert_eq!(n_faces, clusters.faces.len());
        let root = arrays.faces(clusters.clusters.len() - 1);
        let expected = clusters.faces_of(clusters.roots()[0]).map(|face| face.map(|v| clusters.positions[v as usize]));
        for (found, expected) in root.into_iter().zip(expected) {
            let off = found.as_flattened().iter().zip(expected.as_flattened()).map(|(x, y)| (x - y).abs());
            assert!(off.fold(0.0, f32::max) < 2e-6 * 2.6);
        }
        let normal = |at: usize| {
            let [x, y] = [0, 2]
                .map(|k| f32::from(i16::from_le_bytes([arrays.normals[at + k], arrays.normals[at + k + 1]])) / 32767.0);
            let z = 1.0 - x.abs() - y.abs();
            let fold = (-z).max(0.0);
            Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize()
        };
        // Normals of a torus point away from its middle circle.
        for vertex in 0..clusters.clusters[0].n_vertices {
            let meshlet = (0..clusters.clusters.len()).find(|&m| u32_at(&arrays.meshlets[32 * m..], 4) == 0).unwrap();
            let p = Vec3::from(arrays.position(meshlet, vertex));
            let axis = Vec3::new(p.x, p.y, 0.0).normalize() * 2.0;
            assert!(normal(4 * vertex as usize).dot((p - axis).normalize()) > 0.9);
        }
    }

    #[test]
    fn what_bevy_cannot_hold_is_refused() {
        let mesh = shapes::icosphere(4);
        let options = ClusterOptions { max_faces: 200, ..ClusterOptions::default() };
        let go_on = &mut |_| ControlFlow::Continue(());
        let large = build_clusters(&Input::bare(&mesh), &options, go_on).unwrap();
        assert!(matches!(large.to_meshlet_mesh(), Err(MeshletMeshError::TooManyFaces(129..=200))));
        let far = mesh.positions().iter().map(|p| p.map(|x| x + 1e6)).collect();
        let far = crate::mesh::TriMesh::new(far, mesh.faces().to_vec()).unwrap();
        let far = build_clusters(&Input::bare(&far), &ClusterOptions::default(), go_on).unwrap();
        assert_eq!(far.to_meshlet_mesh(), Err(MeshletMeshError::TooLarge));
    }
}
