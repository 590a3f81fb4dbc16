//! Geometry of the glTF 2.0 schema.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::compressed::Compressed;

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Root {
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<GltfBuffer>,
    pub meshes: Vec<GltfMesh>,
    pub nodes: Vec<GltfNode>,
    pub skins: Vec<Skin>,
    pub scenes: Vec<GltfScene>,
    pub scene: Option<usize>,
    pub images: Vec<GltfImage>,
    pub materials: Vec<GltfMaterial>,
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
}

// Array of `count` elements in a buffer view; zeros without a view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    pub count: usize,
    #[serde(default)]
    pub normalized: bool,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Sparse>,
    // Decompressed elements, if they were compressed.
    #[serde(skip)]
    pub decoded: Option<Vec<u8>>,
}

impl Accessor {
    pub fn is_bare(&self) -> bool {
        self.buffer_view.is_none() && self.sparse.is_none() && self.decoded.is_none()
    }
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub count: usize,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    #[serde(default)]
    pub extensions: ViewExtensions,
}

// The extension has two names for one format.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Option<Compressed>,
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Option<Compressed>,
}

impl ViewExtensions {
    pub fn compression(&self) -> Option<&Compressed> {
        self.khr.as_ref().or(self.ext.as_ref())
    }
}

// Without a URI, the bytes are those of the GLB container.
#[derive(Deserialize)]
pub(super) struct GltfBuffer {
    pub uri: Option<String>,
    #[serde(default)]
    pub extensions: BufferExtensions,
}

// A fallback buffer is for readers that cannot decompress.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct BufferExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Fallback,
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Fallback,
}

impl BufferExtensions {
    pub fn is_fallback(&self) -> bool {
        self.ext.fallback || self.khr.fallback
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Fallback {
    fallback: bool,
}

#[derive(Deserialize)]
pub(super) struct GltfMaterial {
    pub name: Option<String>,
}

#[derive(Deserialize)]
pub(super) struct GltfImage {
    pub uri: Option<String>,
}

#[derive(Deserialize)]
pub(super) struct GltfMesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
}

// Triangles (modes 4 to 6), lines or points over one set of vertices.
#[derive(Deserialize)]
pub(super) struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    #[serde(default = "triangle_list")]
    pub mode: u32,
    // Accessors of each morph target, by attribute.
    #[serde(default)]
    pub targets: Vec<BTreeMap<String, usize>>,
    #[serde(default)]
    extensions: PrimitiveExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    draco: Option<Draco>,
}

impl Primitive {
    pub fn triangle_positions(&self) -> Option<usize> {
        self.attributes.get("POSITION").copied().filter(|_| (4..=6).contains(&self.mode))
    }

    // Draco counts only if an array has no uncompressed copy.
    pub fn draco_alone(&self, accessors: &[Accessor]) -> Option<&Draco> {
        let draco = self.extensions.draco.as_ref()?;
        let named = self.attributes.values().chain(&self.indices);
        named.filter_map(|&index| accessors.get(index)).any(Accessor::is_bare).then_some(draco)
    }
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Draco {
    pub buffer_view: Option<usize>,
    pub attributes: BTreeMap<String, u32>,
}

// Matrices are column-major, rotations quaternions x, y, z, w.
#[derive(Deserialize)]
pub(super) struct GltfNode {
    #[serde(default)]
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    #[serde(default)]
    extensions: NodeExtensions,
}

impl GltfNode {
    pub fn instances(&self) -> Option<&BTreeMap<String, usize>> {
        self.extensions.instancing.as_ref().map(|instancing| &instancing.attributes)
    }
}

#[derive(Clone, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Skin {
    pub joints: Vec<usize>,
    pub inverse_bind_matrices: Option<usize>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<Instancing>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Instancing {
    attributes: BTreeMap<String, usize>,
}

#[derive(Deserialize)]
pub(super) struct GltfScene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

fn triangle_list() -> u32 {
    4
}
