//! glTF 2.0: the default scene as one mesh, and whole assets ([`Asset`]).

mod accessor;
mod asset;
mod asset_looks;
mod asset_part;
mod bones;
mod buffers;
mod compressed;
mod container;
mod contents;
#[cfg(feature = "draco")]
mod draco;
#[cfg(not(feature = "draco"))]
#[path = "no_draco.rs"]
mod draco;
mod draft;
mod empty_nodes;
mod extensions;
mod files;
mod geometry;
mod image_kinds;
mod images;
mod levels;
mod load_uri;
mod materials;
mod new_asset;
mod packed;
mod placements;
mod poses;
mod primitive;
mod references;
mod refusals;
mod repack;
mod repair_values;
mod scene_mesh;
mod scene_writer;
mod schema;
mod semantics;
mod simplified_part;
mod single_mesh;
mod texture_transforms;
mod triangles;
mod vrm;

pub use asset::Asset;
pub use asset_part::AssetPart;
pub use contents::AssetContents;
pub(super) use geometry::read;
pub(super) use new_asset::write;
pub use new_asset::write_gltf;
pub use scene_writer::SceneOptions;
pub use simplified_part::SimplifiedPart;
pub(super) use single_mesh::read_attributed;
