//! Hierarchies of clusters by handle, from arrays.
#![allow(clippy::too_many_arguments, reason = "they are arrays with their counts and strides")]

use std::ops::ControlFlow;
use std::ptr::null_mut;
use std::sync::OnceLock;

use neural_mesh::clusters::{Cluster, ClusterGroup, ClusterOptions, Clusters, Sphere, build_clusters};
use neural_mesh::mesh::{Attributes, Channel, Role, TriMesh};
use neural_mesh::simplify::Input;

use crate::errors::{CallError, run_guarded};
use crate::pointers::{borrow_handle, into_handle, read_rows, read_triangles, take_handle, write_number};

/// Number of a missing group.
pub const NM_NO_GROUP: u32 = u32::MAX;

/// Cluster: neighbouring triangles that are drawn together.
#[repr(C)]
pub struct NmCluster {
    /// Center of the sphere around the triangles.
    pub center: [f32; 3],
    /// Radius of this sphere.
    pub radius: f32,
    /// Group whose result contains the cluster; `NM_NO_GROUP` for triangles of the mesh.
    pub source: u32,
    /// Group that simplifies the cluster; `NM_NO_GROUP` for the root.
    pub group: u32,
    /// Level, 0 for triangles of the mesh.
    pub level: u32,
    /// First entry of `nm_clusters_vertices`.
    pub first_vertex: u32,
    /// Number of vertices, at most 256.
    pub vertex_count: u32,
    /// First triangle of `nm_clusters_triangles`.
    pub first_triangle: u32,
    /// Number of triangles, at most 256.
    pub triangle_count: u32,
}

/// Group: clusters that are simplified together.
#[repr(C)]
pub struct NmClusterGroup {
    /// Center of a sphere that contains those of all groups below.
    pub center: [f32; 3],
    /// Radius of this sphere.
    pub radius: f32,
    /// Proved distance between the result and the mesh, in the unit of the positions; grows with the levels.
    pub error: f32,
    /// Largest level of the clusters.
    pub level: u32,
}

/// Hierarchy of clusters.
pub struct NmClusters {
    clusters: Vec<NmCluster>,
    groups: Vec<NmClusterGroup>,
    made: Clusters,
    /// The file, made when it is first asked for.
    bytes: OnceLock<Vec<u8>>,
}

impl NmClusters {
    fn new(made: Clusters) -> Self {
        let clusters = made.clusters.iter().map(cluster).collect();
        let groups = made.groups.iter().map(group).collect();
        Self { clusters, groups, made, bytes: OnceLock::new() }
    }
}

fn cluster(cluster: &Cluster) -> NmCluster {
    let Sphere { center, radius } = cluster.sphere;
    NmCluster {
        center,
        radius,
        source: cluster.source.unwrap_or(NM_NO_GROUP),
        group: cluster.group.unwrap_or(NM_NO_GROUP),
        level: cluster.level,
        first_vertex: cluster.first_vertex,
        vertex_count: cluster.n_vertices,
        first_triangle: cluster.first_face,
        triangle_count: cluster.n_faces,
    }
}

fn group(group: &ClusterGroup) -> NmClusterGroup {
    let Sphere { center, radius } = group.sphere;
    NmClusterGroup { center, radius, error: group.error, level: group.level }
}

/// Returns the hierarchy of a mesh, to be freed by `nm_clusters_free`; null on failure.
///
/// A cluster has at most `max_vertices` vertices and `max_triangles` triangles, 4 to 256 each. Vertices at one position are
/// joined; their attributes, `attribute_count` numbers each, stay apart. `vertex_attributes` may be null.
///
/// # Safety
/// Each array has as many values as its count says; strides are in bytes.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_build(
    indices: *const u32,
    index_count: usize,
    vertex_positions: *const f32,
    vertex_count: usize,
    vertex_positions_stride: usize,
    vertex_attributes: *const f32,
    vertex_attributes_stride: usize,
    attribute_count: usize,
    max_vertices: usize,
    max_triangles: usize,
) -> *mut NmClusters {
    run_guarded(null_mut(), || {
        let n_attributes = if vertex_attributes.is_null() { 0 } else { attribute_count };
        let positions = read_rows("vertex_positions", vertex_positions, vertex_count, 3, vertex_positions_stride)?;
        let stride = vertex_attributes_stride;
        let attributes = read_rows("vertex_attributes", vertex_attributes, vertex_count, n_attributes, stride)?;
        let mut triangles = read_triangles(indices, index_count)?;
        triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        let mesh = TriMesh::new(positions.as_chunks().0.to_vec(), triangles)?;
        let options = ClusterOptions { max_vertices, max_faces: max_triangles, ..ClusterOptions::default() };
        Ok(into_handle(NmClusters::new(build(&mesh, (attributes, n_attributes), &options)?)))
    })
}

fn build(mesh: &TriMesh, (values, width): (Vec<f32>, usize), options: &ClusterOptions) -> Result<Clusters, CallError> {
    let mut attributes = Attributes::default();
    if width > 0 {
        attributes.wedges = mesh.faces().to_vec();
        attributes.channels = vec![Channel { name: "attributes".into(), role: Role::Other, width, values }];
    }
    let mut input = Input::bare(mesh);
    input.attributes = &attributes;
    Ok(build_clusters(&input, options, &mut |_| ControlFlow::Continue(()))?)
}

/// Frees a hierarchy; does nothing for null.
///
/// # Safety
/// The hierarchy comes from `nm_clusters_build`, and nothing uses it any more.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_free(clusters: *mut NmClusters) {
    run_guarded((), || {
        drop(take_handle(clusters));
        Ok(())
    });
}

/// Returns an array of a hierarchy and writes its number of rows to `count`.
fn array<T>(clusters: *const NmClusters, count: *mut usize, width: usize, of: fn(&NmClusters) -> &[T]) -> *const T {
    run_guarded(std::ptr::null(), || {
        let found = of(borrow_handle("clusters", clusters)?);
        write_number(count, found.len() / width);
        Ok(found.as_ptr())
    })
}

/// Returns the clusters, level by level; null on failure. Arrays are valid until the hierarchy is freed.
///
/// # Safety
/// The hierarchy is valid; `count` is null or has room for one number.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_clusters(clusters: *const NmClusters, count: *mut usize) -> *const NmCluster {
    array(clusters, count, 1, |it| &it.clusters)
}

/// Returns the groups, level by level; null on failure.
///
/// # Safety
/// As for `nm_clusters_clusters`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_groups(clusters: *const NmClusters, count: *mut usize) -> *const NmClusterGroup {
    array(clusters, count, 1, |it| &it.groups)
}

/// Returns the positions of all vertices, 3 numbers each; null on failure.
///
/// # Safety
/// As for `nm_clusters_clusters`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_positions(clusters: *const NmClusters, count: *mut usize) -> *const f32 {
    array(clusters, count, 3, |it| it.made.positions.as_flattened())
}

/// Returns the attributes of all vertices, as many numbers each as were given; `count` receives the number of all numbers.
///
/// # Safety
/// As for `nm_clusters_clusters`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_attributes(clusters: *const NmClusters, count: *mut usize) -> *const f32 {
    array(clusters, count, 1, |it| it.made.channels.first().map_or(&[], |channel| &channel.values))
}

/// Returns the vertices of all clusters; null on failure.
///
/// # Safety
/// As for `nm_clusters_clusters`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_vertices(clusters: *const NmClusters, count: *mut usize) -> *const u32 {
    array(clusters, count, 1, |it| &it.made.vertices)
}

/// Returns the triangles of all clusters, 3 places in the cluster's vertices each; null on failure.
///
/// # Safety
/// As for `nm_clusters_clusters`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_triangles(clusters: *const NmClusters, count: *mut usize) -> *const u8 {
    array(clusters, count, 3, |it| it.made.faces.as_flattened())
}

/// Returns the bytes of the hierarchy as a file, `.nmc`; null on failure.
///
/// # Safety
/// As for `nm_clusters_clusters`.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn nm_clusters_bytes(clusters: *const NmClusters, count: *mut usize) -> *const u8 {
    array(clusters, count, 1, |it| it.bytes.get_or_init(|| it.made.to_bytes()))
}
