//! The file format of hierarchies, `.nmc`: a header in JSON, aligned arrays, and pages of which each can be loaded alone.
//!
//! `docs/clusters.md` describes every byte.

mod read;
#[cfg(feature = "io")]
mod stored;
mod write;

use serde::{Deserialize, Serialize};

use crate::mesh::Role;
use crate::mesh::value_bytes::store_fields;

use super::{Clusters, Sphere};

#[cfg(feature = "io")]
pub use stored::StoredPages;

/// Version of the format, stored in each file.
pub const CONTAINER_VERSION: u32 = 1;

const MAGIC: [u8; 4] = *b"nmc\0";
/// Bytes before the header: magic, version, length of the header.
const PREAMBLE: usize = 16;
/// Boundary at which arrays begin.
const ALIGNMENT: usize = 64;
const PAGE_SIZE: usize = 1 << 16;
/// Stored number of a missing group.
const NONE: u32 = u32::MAX;

/// Row of the array of clusters.
struct ClusterRow {
    sphere: Sphere,
    /// Groups, or [`NONE`].
    source: u32,
    group: u32,
    level: u32,
    place: PagePlace,
    n_vertices: u32,
    n_faces: u32,
    unused: u32,
}

/// Row of the array of groups.
struct GroupRow {
    sphere: Sphere,
    error: f32,
    level: u32,
    unused: [u32; 2],
}

/// Place of a cluster's bytes.
#[derive(Clone, Copy, Debug)]
struct PagePlace {
    page: u32,
    offset: u32,
}

store_fields! {
    PagePlace { page: u32, offset: u32 };
    ClusterRow { sphere: Sphere, source: u32, group: u32, level: u32, place: PagePlace, n_vertices: u32, n_faces: u32,
        unused: u32 };
    GroupRow { sphere: Sphere, error: f32, level: u32, unused: [u32; 2] };
}

/// The JSON of the header.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct Header {
    /// Bytes of a page.
    page_size: usize,
    /// Origin of the positions.
    origin: [f64; 3],
    /// Lowest and highest coordinates of the finest level, from the origin; `None` if its positions are on disk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bounds: Option<[[f32; 3]; 2]>,
    pages: ArrayPlace,
    clusters: ArrayPlace,
    groups: ArrayPlace,
    /// Single-precision numbers, n_groups x n_channels.
    attribute_errors: ArrayPlace,
    /// True if faces have material numbers.
    has_face_groups: bool,
    channels: Vec<ChannelHead>,
}

/// First byte and number of rows of an array.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
struct ArrayPlace {
    offset: usize,
    count: usize,
}

#[derive(Debug, Deserialize, PartialEq, Serialize)]
struct ChannelHead {
    name: String,
    role: String,
    width: usize,
}

/// Reason why bytes are no hierarchy.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ContainerError {
    /// Bytes of another format.
    NotAContainer,
    /// Another version of the format; holds its number.
    Version(u32),
    /// Damaged content, described by the text.
    Damaged(String),
}

impl std::fmt::Display for ContainerError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotAContainer => write!(f, "no hierarchy of clusters: the first bytes are not \"nmc\""),
            Self::Version(version) => {
                write!(f, "version {version} of the format, but {CONTAINER_VERSION} is read here: make the file again")
            }
            Self::Damaged(what) => write!(f, "damaged hierarchy of clusters: {what}"),
        }
    }
}

impl std::error::Error for ContainerError {}

const ROLES: [(Role, &str); 9] = [
    (Role::Normal, "normal"),
    (Role::Tangent, "tangent"),
    (Role::Uv, "uv"),
    (Role::Colour, "colour"),
    (Role::Skin, "skin"),
    (Role::MorphPosition, "morph position"),
    (Role::MorphDirection, "morph direction"),
    (Role::Other, "other"),
    (Role::Label, "label"),
];

/// Returns the bytes of a cluster in its page, without alignment.
fn cluster_bytes(n_vertices: usize, n_faces: usize, width: usize, has_face_groups: bool) -> usize {
    4 * n_vertices * (3 + width) + if has_face_groups { 4 * n_faces } else { 0 } + 3 * n_faces
}

impl Clusters {
    /// Writes the hierarchy as the bytes of an `.nmc` file.
    ///
    /// ```
    /// use std::ops::ControlFlow;
    /// use neural_mesh::clusters::{ClusterOptions, Clusters, build_clusters};
    /// use neural_mesh::{mesh::shapes, simplify::Input};
    /// let mesh = shapes::icosphere(4);
    /// let go_on = &mut |_| ControlFlow::Continue(());
    /// let clusters = build_clusters(&Input::bare(&mesh), &ClusterOptions::default(), go_on).unwrap();
    /// let read = Clusters::from_bytes(&clusters.to_bytes()).unwrap();
    /// assert_eq!(read.groups, clusters.groups);
    /// assert_eq!(read.mesh_of(&read.roots()).0, clusters.mesh_of(&clusters.roots()).0);
    /// ```
    pub fn to_bytes(&self) -> Vec<u8> {
        write::write(self)
    }

    /// Reads the bytes of an `.nmc` file. Each cluster has vertices of its own; vertices at one position are equal bit for bit.
    ///
    /// # Errors
    /// [`ContainerError`] for other bytes, another version, or damage.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ContainerError> {
        read::read(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clusters::{ClusterOptions, build_clusters};
    use crate::mesh::{Attributes, Channel, shapes};
    use crate::simplify::Input;
    use std::ops::ControlFlow;

    fn textured_clusters(n_around: u32) -> Clusters {
        let mesh = shapes::torus(n_around, n_around / 2, 2.0, 0.7);
        let values = mesh.positions().iter().flat_map(|p| [p[0], p[2]]).collect();
        let channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
        let groups = mesh.faces().iter().map(|face| u32::from(mesh.positions()[face[0] as usize][0] > 0.0)).collect();
        let attributes = Attributes { wedges: mesh.faces().to_vec(), channels, groups };
        let mut input = Input::bare(&mesh);
        input.attributes = &attributes;
        build_clusters(&input, &ClusterOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        let clusters = textured_clusters(60);
        let read = Clusters::from_bytes(&clusters.to_bytes()).unwrap();
        assert_eq!(read.groups, clusters.groups);
        assert_eq!((&read.faces, &read.face_groups), (&clusters.faces, &clusters.face_groups));
        for cut in [clusters.roots(), clusters.cut_at_error(0.05), clusters.cut_at_error(0.0)] {
            let ((mesh, attributes), (own, own_attributes)) = (read.mesh_of(&cut), clusters.mesh_of(&cut));
            // Vertices are numbered differently.
            let corners = |mesh: &crate::mesh::TriMesh| -> Vec<[f32; 3]> {
                mesh.faces().iter().flatten().map(|&v| mesh.positions()[v as usize]).collect()
            };
            let uvs = |attributes: &Attributes| -> Vec<f32> {
                let wedges = attributes.wedges.iter().flatten();
                wedges.flat_map(|&wedge| attributes.channels[0].value(wedge).to_vec()).collect()
            };
            assert_eq!(corners(&mesh), corners(&own));
            assert_eq!((uvs(&attributes), attributes.groups), (uvs(&own_attributes), own_attributes.groups));
        }
        assert_eq!(Clusters::from_bytes(&read.to_bytes()), Ok(read));
    }

    #[test]
    fn the_header_bounds_the_finest_level() {
        let clusters = textured_clusters(60);
        let header = read::read_header(&clusters.to_bytes()).unwrap();
        let finest = clusters.mesh_of(&clusters.cut_at_error(0.0)).0;
        let extreme = |pick: fn(f32, f32) -> f32| {
            finest
                .positions()
                .iter()
                .copied()
                .reduce(|a, b| std::array::from_fn(|axis| pick(a[axis], b[axis])))
                .unwrap()
        };
        assert_eq!(header.bounds, Some([extreme(f32::min), extreme(f32::max)]));
    }

    #[test]
    fn each_page_can_be_loaded_alone() {
        let bytes = textured_clusters(60).to_bytes();
        let header = read::read_header(&bytes).unwrap();
        assert_eq!((header.page_size, header.pages.offset % PAGE_SIZE), (PAGE_SIZE, 0));
        assert_eq!(bytes.len(), header.pages.offset + header.pages.count * PAGE_SIZE);
    }

    #[test]
    fn damaged_bytes_give_an_error_or_a_sound_hierarchy() {
        // Every damage reads all of the file again, so the hierarchy is small.
        let clusters = textured_clusters(20);
        assert!(clusters.roots().len() < clusters.cut_at_error(0.0).len());
        let bytes = clusters.to_bytes();
        assert_eq!(Clusters::from_bytes(b"glTF"), Err(ContainerError::NotAContainer));
        assert!(Clusters::from_bytes(&bytes[..bytes.len() - 1]).is_err());
        let end = read::read_header(&bytes).unwrap().pages.offset + 4096;
        for at in (0..end).step_by(7) {
            for value in [0, 1, 0x7f, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                if let Ok(read) = Clusters::from_bytes(&damaged) {
                    assert!(read.clusters.len() < 1000);
                    let all: Vec<u32> = (0..read.clusters.len() as u32).collect();
                    read.mesh_of(&all);
                }
            }
        }
    }
}
