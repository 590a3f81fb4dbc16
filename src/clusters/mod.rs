//! Hierarchies of clusters: the level of detail varies over the surface, without cracks.
//!
//! A mesh is split into clusters of neighbouring faces. Groups of neighbouring clusters are simplified to half their
//! faces, while vertices that other groups use stay, and are split into clusters again. Each level forms other groups,
//! so that vertices held at one level are free at the next, until one cluster is left (Karis, Stubbe and Wihlidal
//! 2021, "A deep dive into Nanite virtualized geometry").

mod ancestors;
mod build;
#[cfg(feature = "job")]
mod container;
mod cut;
mod cut_pieces;
mod error;
mod face_split;
mod footprint;
mod grouping;
#[cfg(all(feature = "io", feature = "job"))]
mod in_blocks;
mod meshlet_mesh;
mod overlay;
mod overlay_surface;
mod reduction;
mod sharpening;
mod sphere;
mod vertices;

#[cfg(feature = "io")]
use crate::blocks::OutOfCoreError;
use crate::mesh::Channel;
use crate::simplify::{ClosedOptions, SimplifyError};

pub use build::build_clusters;
#[cfg(feature = "job")]
pub use container::{CONTAINER_VERSION, ContainerError};
pub use cut::ViewPoint;
#[cfg(all(feature = "io", feature = "job"))]
pub use in_blocks::{StoredClusters, cluster_pieces};
pub use meshlet_mesh::MeshletMeshError;
pub use sphere::Sphere;

/// Largest number of faces and of vertices that [`ClusterOptions`] accept; faces hold vertex numbers of one byte.
pub const LARGEST_CLUSTER: usize = 256;
const SMALLEST_CLUSTER: usize = 4;

/// Settings of a hierarchy.
#[derive(Clone, Debug, PartialEq)]
// Not `non_exhaustive`, so that callers can write `..ClusterOptions::default()`.
pub struct ClusterOptions {
    /// Most faces of a cluster, 4 to [`LARGEST_CLUSTER`].
    pub max_faces: usize,
    /// Most vertices of a cluster, 4 to [`LARGEST_CLUSTER`].
    pub max_vertices: usize,
    /// About how many clusters form a group, at least 2.
    pub clusters_per_group: usize,
    /// Settings of the collapse within groups. Pruning, `hidden` and `map` have no effect.
    pub simplify: ClosedOptions,
}

impl Default for ClusterOptions {
    fn default() -> Self {
        Self { max_faces: 128, max_vertices: 256, clusters_per_group: 16, simplify: ClosedOptions::default() }
    }
}

impl ClusterOptions {
    fn check(&self) -> Result<(), ClusterError> {
        for (name, value) in [("max_faces", self.max_faces), ("max_vertices", self.max_vertices)] {
            if !(SMALLEST_CLUSTER..=LARGEST_CLUSTER).contains(&value) {
                return Err(ClusterError::BadSize { name, value });
            }
        }
        match self.clusters_per_group {
            0 | 1 => Err(ClusterError::BadSize { name: "clusters_per_group", value: self.clusters_per_group }),
            _ => Ok(()),
        }
    }
}

/// Reason for a failed hierarchy.
#[derive(Debug)]
#[non_exhaustive]
pub enum ClusterError {
    /// Option out of range.
    BadSize {
        /// Name of the option.
        name: &'static str,
        /// Its value.
        value: usize,
    },
    /// Error of the simplifier.
    Simplify(SimplifyError),
    /// Error of a mesh larger than memory.
    #[cfg(feature = "io")]
    InBlocks(OutOfCoreError),
}

impl std::fmt::Display for ClusterError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::BadSize { name: "clusters_per_group", value } => {
                write!(f, "invalid clusters_per_group {value}: give at least 2")
            }
            Self::BadSize { name, value } => {
                write!(f, "invalid {name} {value}: give {SMALLEST_CLUSTER} to {LARGEST_CLUSTER}")
            }
            Self::Simplify(error) => error.fmt(f),
            // A hierarchy has no target that could be chosen smaller.
            #[cfg(feature = "io")]
            Self::InBlocks(OutOfCoreError::TooLittle(n_bytes)) => {
                let gib = (*n_bytes as f64 / f64::from(1 << 30) * 10.0).ceil() / 10.0;
                write!(f, "a hierarchy of this mesh needs about {gib} GiB of memory: allow more memory")
            }
            #[cfg(feature = "io")]
            Self::InBlocks(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ClusterError {}

impl From<SimplifyError> for ClusterError {
    fn from(error: SimplifyError) -> Self {
        Self::Simplify(error)
    }
}

#[cfg(feature = "io")]
impl From<OutOfCoreError> for ClusterError {
    fn from(error: OutOfCoreError) -> Self {
        match error {
            OutOfCoreError::Simplify(error) => Self::Simplify(error),
            error => Self::InBlocks(error),
        }
    }
}

#[cfg(feature = "io")]
impl From<std::io::Error> for ClusterError {
    fn from(error: std::io::Error) -> Self {
        Self::InBlocks(OutOfCoreError::Disk(error))
    }
}

/// A hierarchy of clusters over one array of vertices.
///
/// Clusters and groups are a directed acyclic graph: a cluster belongs to the group that simplifies it, and, except
/// at level 0, comes from the group of which it is a part of the result.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clusters {
    /// Origin of the positions, in the coordinates of the file.
    pub origin: [f64; 3],
    /// Positions, n_vertices x 3. Vertices of a seam share a position bit for bit.
    pub positions: Vec<[f32; 3]>,
    /// Attributes, one row per vertex.
    pub channels: Vec<Channel>,
    /// All clusters, level by level.
    pub clusters: Vec<Cluster>,
    /// All groups, level by level.
    pub groups: Vec<ClusterGroup>,
    /// Vertices of all clusters, one range per cluster.
    pub vertices: Vec<u32>,
    /// Corners of all faces, one range per cluster, as places in the cluster's range of [`Clusters::vertices`].
    pub faces: Vec<[u8; 3]>,
    /// Material, primitive or group of each face; empty if all are 0. Faces of a cluster are sorted by it.
    pub face_groups: Vec<u32>,
}

/// Neighbouring faces that are drawn together.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cluster {
    /// Level: 0 for faces of the input, otherwise one more than that of the group it comes from.
    pub level: u32,
    /// First entry in [`Clusters::vertices`].
    pub first_vertex: u32,
    /// Number of vertices.
    pub n_vertices: u32,
    /// First entry in [`Clusters::faces`].
    pub first_face: u32,
    /// Number of faces.
    pub n_faces: u32,
    /// Group whose result contains this cluster; `None` at level 0.
    pub source: Option<u32>,
    /// Group that simplifies this cluster; `None` for the root.
    pub group: Option<u32>,
    /// Sphere around the faces.
    pub sphere: Sphere,
}

/// Clusters that are simplified together.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClusterGroup {
    /// Largest level of its clusters.
    pub level: u32,
    /// Proved bound of the largest distance between its result and the input surface, both ways, in the mesh's unit.
    ///
    /// It is never below the error of a group from which one of its clusters comes.
    pub error: f32,
    /// Mean change of each channel, sampled at the centroids of faces, in the channel's unit, added up over the levels.
    pub attribute_errors: Vec<f32>,
    /// Sphere around its faces, and around the spheres of the groups from which its clusters come.
    pub sphere: Sphere,
}

/// Sizes of a hierarchy.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ClusterFigures {
    /// Number of clusters.
    pub n_clusters: usize,
    /// Number of groups.
    pub n_groups: usize,
    /// Number of levels, with level 0.
    pub n_levels: u32,
    /// Number of clusters without a group.
    pub n_roots: usize,
    /// Number of their faces.
    pub n_root_faces: usize,
    /// Number of faces of all clusters.
    pub n_faces: usize,
    /// Proved distance of the coarsest level, in the mesh's unit.
    pub root_error: f32,
}

impl Clusters {
    /// Counts clusters, groups, levels and faces.
    pub fn figures(&self) -> ClusterFigures {
        let roots = self.clusters.iter().filter(|cluster| cluster.group.is_none());
        ClusterFigures {
            n_clusters: self.clusters.len(),
            n_groups: self.groups.len(),
            n_levels: self.clusters.iter().map(|cluster| cluster.level + 1).max().unwrap_or(0),
            n_roots: roots.clone().count(),
            n_root_faces: roots.map(|cluster| cluster.n_faces as usize).sum(),
            n_faces: self.clusters.iter().map(|cluster| cluster.n_faces as usize).sum(),
            root_error: self.groups.iter().map(|group| group.error).fold(0.0, f32::max),
        }
    }

    /// Returns the clusters without a group: the last level.
    pub fn roots(&self) -> Vec<u32> {
        (0u32..).zip(&self.clusters).filter(|(_, cluster)| cluster.group.is_none()).map(|(c, _)| c).collect()
    }

    /// Returns the corners of a cluster's faces as vertices, n_faces x 3.
    pub fn faces_of(&self, cluster: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        let cluster = &self.clusters[cluster as usize];
        let vertices = &self.vertices[cluster.first_vertex as usize..][..cluster.n_vertices as usize];
        let faces = &self.faces[cluster.first_face as usize..][..cluster.n_faces as usize];
        faces.iter().map(|face| face.map(|corner| vertices[usize::from(corner)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::run_on_threads;
    use crate::mesh::{Attributes, Role, TriMesh, edges, shapes, topology};
    use crate::metrics::{Surface, surface_distance};
    use crate::simplify::Input;
    use proptest::prelude::*;
    use std::ops::ControlFlow;

    fn build(input: &Input, options: &ClusterOptions) -> Clusters {
        build_clusters(input, options, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    const MOST_ROOTS_OF_ANY_MESH: usize = 4;

    fn small() -> ClusterOptions {
        ClusterOptions { max_faces: 32, max_vertices: 64, clusters_per_group: 8, ..ClusterOptions::default() }
    }

    pub fn assert_sound(clusters: &Clusters, options: &ClusterOptions) {
        let groups = &clusters.groups;
        for cluster in &clusters.clusters {
            assert!(cluster.n_faces as usize <= options.max_faces && cluster.n_faces > 0);
            assert!(cluster.n_vertices as usize <= options.max_vertices);
            let source = cluster.source.map(|group| &groups[group as usize]);
            assert_eq!(cluster.level, source.map_or(0, |group| group.level + 1));
            if let (Some(source), Some(group)) = (source, cluster.group) {
                let group = &groups[group as usize];
                assert!(group.error >= source.error && group.sphere.contains(&source.sphere));
                assert!(
                    group.attribute_errors.iter().zip(&source.attribute_errors).all(|(after, before)| after >= before)
                );
            }
        }
        assert!(groups.iter().all(|group| group.error.is_finite()));
    }

    pub fn assert_sound_with_one_root(clusters: &Clusters, options: &ClusterOptions) {
        assert_sound(clusters, options);
        assert_eq!(clusters.roots().len(), 1);
    }

    fn two_parts() -> TriMesh {
        let (sphere, box_) = (shapes::wavy_sphere(4, 5.0), shapes::cuboid([1.0; 3], 12));
        shapes::unite([&sphere, &shapes::place(&box_, |[x, y, z]| [x + 3.0, y, z])])
    }

    #[test]
    fn every_cut_of_a_closed_mesh_is_closed() {
        for mesh in [shapes::torus(80, 40, 1.0, 0.3), two_parts(), shapes::bolt(48)] {
            let clusters = build(&Input::bare(&mesh), &small());
            assert_sound_with_one_root(&clusters, &small());
            let steps = 30;
            for step in 0..=steps {
                let turn = step as f32;
                let eye = [3.0 * turn.cos(), 3.0 * turn.sin(), 0.1 * turn];
                let view = ViewPoint { eye, pixels: 1000.0, near: 0.01 };
                let cut = clusters.cut_for_view(&view, 0.05 * 1.3f64.powi(step));
                let (cut, _) = clusters.mesh_of(&cut);
                assert!(edges(&cut).iter().all(|edge| edge.n_faces() % 2 == 0) || cut.faces().len() == 1, "{step}");
            }
            let (whole, _) = clusters.mesh_of(&clusters.cut_at_error(-1.0));
            assert_eq!(topology(&whole).faces, mesh.faces().len());
        }
    }

    #[test]
    fn errors_bound_the_distance_of_cuts() {
        let mesh = shapes::wavy_sphere(5, 6.0);
        let clusters = build(&Input::bare(&mesh), &ClusterOptions::default());
        for error in [1e-3, 1e-2, 5e-2] {
            let (cut, _) = clusters.mesh_of(&clusters.cut_at_error(error));
            assert!(cut.faces().len() < mesh.faces().len());
            let [a, b] = [&mesh, &cut].map(|mesh| Surface::new(mesh, 20_000, 0));
            let measured = surface_distance(&a, &b).unwrap().both.max;
            assert!(measured <= error && measured > 0.1 * error, "{measured} {error}");
        }
    }

    #[test]
    fn proved_errors_are_near_the_largest_sampled_distance() {
        // If bounds add up from level to level, ratios are up to 1.7 and 1.9.
        for mesh in [shapes::wavy_sphere(5, 6.0), shapes::icosphere(5)] {
            let clusters = build(&Input::bare(&mesh), &ClusterOptions::default());
            let mut errors: Vec<f32> = clusters.groups.iter().map(|group| group.error).collect();
            errors.sort_by(f32::total_cmp);
            for &error in errors.iter().step_by(errors.len().div_ceil(8)) {
                let (cut, _) = clusters.mesh_of(&clusters.cut_at_error(error.into()));
                let [a, b] = [&mesh, &cut].map(|mesh| Surface::new(mesh, 20_000, 1));
                let ratio = f64::from(error) / surface_distance(&a, &b).unwrap().both.max;
                assert!((1.0..1.5).contains(&ratio), "{ratio}");
            }
        }
    }

    #[test]
    fn the_number_of_threads_does_not_change_the_result() {
        let mesh = two_parts();
        let with_threads = |n| run_on_threads(n, || build(&Input::bare(&mesh), &small()));
        assert!(with_threads(1) == with_threads(3));
    }

    #[test]
    fn leaves_and_touching_parts_end_in_one_root() {
        let square = |i: u32| {
            let (x, y, z) = ((i % 16) as f32, (i / 16 % 16) as f32, (i * 7 % 5) as f32);
            [[x, y, z], [x + 0.7, y, z], [x + 0.7, y + 0.7, z], [x, y + 0.7, z]]
        };
        let faces = (0..512).flat_map(|i| [[0, 1, 2], [0, 2, 3]].map(|face| face.map(|v| 4 * i + v))).collect();
        let leaves = TriMesh::new((0..512).flat_map(square).collect(), faces).unwrap();
        let cube = shapes::cuboid([1.0; 3], 4);
        let n = cube.positions().len() as u32;
        let cubes = (0..27u32).flat_map(|i| {
            let at = [i % 3, i / 3 % 3, i / 9].map(|x| x as f32);
            let place = move |p: &[f32; 3]| std::array::from_fn(|k| p[k] + at[k]);
            cube.positions().iter().map(place).collect::<Vec<[f32; 3]>>()
        });
        let faces = (0..27).flat_map(|i| cube.faces().iter().map(move |face| face.map(|v| i * n + v))).collect();
        let touching = TriMesh::new(cubes.collect(), faces).unwrap();
        for mesh in [leaves, touching] {
            let clusters = build(&Input::bare(&mesh), &ClusterOptions::default());
            assert_sound_with_one_root(&clusters, &ClusterOptions::default());
        }
    }

    #[test]
    fn seams_and_materials_stay_on_the_surface() {
        let mesh = shapes::torus(80, 40, 2.0, 0.6);
        // Two charts with a seam at x = 0, each with the place as its texture coordinates.
        let is_right = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][0]).sum::<f32>() > 0.0;
        let n = mesh.positions().len() as u32;
        let wedges = mesh.faces().iter().map(|face| face.map(|v| v + n * u32::from(is_right(face)))).collect();
        let uv = |shift: f32| mesh.positions().iter().flat_map(move |p| [p[0] + shift, p[1]]);
        let channels =
            vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values: uv(0.0).chain(uv(10.0)).collect() }];
        let groups = mesh.faces().iter().map(|face| u32::from(is_right(face))).collect();
        let attributes = Attributes { wedges, channels, groups };
        let mut input = Input::bare(&mesh);
        input.attributes = &attributes;
        let clusters = build(&input, &small());
        assert_sound_with_one_root(&clusters, &small());
        for cluster in 0..clusters.clusters.len() as u32 {
            let first = clusters.clusters[cluster as usize].first_face;
            for (face, corners) in clusters.faces_of(cluster).enumerate() {
                let shift = 10.0 * clusters.face_groups[first as usize + face] as f32;
                for v in corners {
                    let ([x, y, _], uv) = (clusters.positions[v as usize], clusters.channels[0].value(v));
                    let off = f32::hypot(uv[0] - shift - x, uv[1] - y);
                    assert!(off < 1.0, "{off} at level {}", clusters.clusters[cluster as usize].level);
                }
            }
        }
        let root = &clusters.groups.last().unwrap();
        assert!(root.attribute_errors[0] > 0.0 && root.attribute_errors[0].is_finite());
    }

    #[test]
    fn options_out_of_range_and_stopped_runs_are_errors() {
        let mesh = shapes::icosphere(3);
        let go_on = &mut |_| ControlFlow::Continue(());
        let refuse = |options: ClusterOptions, go_on: &mut crate::simplify::Listener| {
            build_clusters(&Input::bare(&mesh), &options, go_on).unwrap_err().to_string()
        };
        let options = ClusterOptions { max_faces: 300, ..ClusterOptions::default() };
        assert_eq!(refuse(options, go_on), "invalid max_faces 300: give 4 to 256");
        let options = ClusterOptions { clusters_per_group: 1, ..ClusterOptions::default() };
        assert_eq!(refuse(options, go_on), "invalid clusters_per_group 1: give at least 2");
        let stopped = build_clusters(&Input::bare(&mesh), &small(), &mut |_| ControlFlow::Break(()));
        assert!(matches!(stopped, Err(ClusterError::Simplify(SimplifyError::Interrupted))));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]
        #[test]
        fn any_mesh_has_a_sound_hierarchy(
            points in proptest::collection::vec(proptest::array::uniform3(-4i8..4), 4..60),
            corners in proptest::collection::vec(proptest::array::uniform3(0usize..60), 1..300),
        ) {
            let positions: Vec<[f32; 3]> = points.iter().map(|p| p.map(f32::from)).collect();
            let faces = corners.iter().map(|face| face.map(|v| (v % positions.len()) as u32));
            let distinct = |[a, b, c]: [u32; 3]| {
                let position = |v: u32| positions[v as usize];
                position(a) != position(b) && position(b) != position(c) && position(c) != position(a)
            };
            let faces: Vec<[u32; 3]> = faces.filter(|&face| distinct(face)).collect();
            prop_assume!(!faces.is_empty());
            let mesh = TriMesh::new(positions.clone(), faces).unwrap();
            let options = ClusterOptions { max_faces: 8, max_vertices: 24, clusters_per_group: 4, ..ClusterOptions::default() };
            let clusters = build(&Input::bare(&mesh), &options);
            // Not every soup of faces ends in one root.
            assert_sound(&clusters, &options);
            prop_assert!((1..=MOST_ROOTS_OF_ANY_MESH).contains(&clusters.roots().len()));
            prop_assert_eq!(clusters.mesh_of(&clusters.cut_at_error(-1.0)).0.faces().len(), mesh.faces().len());
        }
    }
}
