//! Figures of sizes, edges, topology and triangles.

use super::figure::Figure;
use super::reference_mesh::ReferenceMesh;
use crate::mesh::{Topology, TriMesh};
use crate::metrics::{Surface, n_self_intersecting_faces, open_edges, triangle_quality, volume};

fn count(n: usize) -> Option<f64> {
    Some(n as f64)
}

pub fn sizes(simplified: &TriMesh) -> [Figure; 2] {
    [
        Figure::new("vertices", "vertices", "vertices of the simplified mesh", count(simplified.positions().len())),
        Figure::new("faces", "faces", "faces of the simplified mesh", count(simplified.faces().len())),
    ]
}

pub fn edges(original: &ReferenceMesh, simplified: &TriMesh, found: &Topology) -> [Figure; 7] {
    let edges = open_edges(&original.mesh, simplified);
    let crossed = n_self_intersecting_faces(simplified).map(|n| n as f64);
    let wa = "edges with one, three or more faces (the paper's WA)";
    let opened = "edges with one, three or more faces, except on boundaries of the original";
    let fans = "vertices whose faces form more than one fan";
    [
        Figure::new("edges_without_two_faces", "% of edges", wa, Some(edges.wa_percent())),
        Figure::new("open_edges", "% of edges", opened, Some(edges.open_percent())),
        Figure::new("boundary_edges", "edges", "edges with one face", count(found.boundary_edges)),
        Figure::new("non_manifold_edges", "edges", "edges with three or more faces", count(found.non_manifold_edges)),
        Figure::new(
            "flipped_edges",
            "edges",
            "edges whose two faces have opposite winding",
            count(found.inconsistent_edges),
        ),
        Figure::new("non_manifold_vertices", "vertices", fans, count(found.non_manifold_vertices)),
        Figure::new("self_intersecting_faces", "faces", "faces that intersect another face", crossed),
    ]
}

pub fn topology(original: &ReferenceMesh, simplified: &TriMesh, surface: &Surface, found: &Topology) -> [Figure; 4] {
    let more = |a: usize, b: usize| a as f64 - b as f64;
    let genus = found.genus.zip(original.topology.genus).map(|(a, b)| more(a, b));
    let change = |(a, b): (f64, f64)| 100.0 * (a - b) / b.abs();
    let volume = volume(simplified).zip(original.volume).map(change);
    let pieces = Some(more(found.components, original.topology.components));
    let area = Some(change((surface.area, original.surface.area)));
    let unit = "% of the original's";
    [
        Figure::new(
            "components_added",
            "components",
            "components of the result minus components of the original",
            pieces,
        ),
        Figure::new("genus_added", "handles", "handles (genus) of the result minus handles of the original", genus),
        Figure::new("area_change", unit, "area of the result minus area of the original", area),
        Figure::new(
            "volume_change",
            unit,
            "volume of the result minus volume of the original, if both are closed",
            volume,
        ),
    ]
}

pub fn triangles(simplified: &TriMesh) -> [Figure; 4] {
    let quality = triangle_quality(simplified);
    let mean = "mean of the smallest angle of each face";
    let aspect = "median aspect ratio of the faces: longest edge over its height, 1 for an equilateral face";
    [
        Figure::new("smallest_angle", "degrees", "smallest angle of any face", quality.map(|q| q.smallest_angle)),
        Figure::new("smallest_angle_mean", "degrees", mean, quality.map(|q| q.mean_smallest_angle)),
        Figure::new("aspect_median", "", aspect, quality.map(|q| q.median_aspect)),
        Figure::new("slivers", "faces", "faces with an angle below one degree", quality.map(|q| q.slivers as f64)),
    ]
}
