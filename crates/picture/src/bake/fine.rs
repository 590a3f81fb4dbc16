//! Queries of the original surface and its materials.

use glam::{DVec3, Vec3};

use super::BakeSource;
use super::frames::corner_normals;
use super::original_materials::{MaterialSample, OriginalMaterials, SamplePlace};
use crate::geometry::triangle::{area_normal, corners_f64};
use crate::mesh::{Attributes, TriMesh};
use crate::parallel;
use crate::spatial::{Hit, NearestOnTriangles};

/// Largest angle in degrees between faces that share normals if the file has none.
const SMOOTH: f32 = 30.0;
/// Length of search along a normal, relative to the largest distance between the surfaces.
// A line that meets the original at 70 degrees from its normal is three times as long as that distance.
const CAGE: f64 = 3.0;
/// Smallest search length, as a share of the original's diagonal.
const LEAST_CAGE: f64 = 1e-4;

/// Cosine between face normals above which faces are on one side of an edge.
const SAME: f32 = 0.5;

pub(super) struct FineSurface<'a> {
    mesh: &'a TriMesh,
    tree: NearestOnTriangles,
    // Unit normals, n_faces.
    of_faces: Vec<Vec3>,
    normals: Vec<[Vec3; 3]>,
    materials: OriginalMaterials,
    cage: f64,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceQuery {
    pub point: DVec3,
    // Direction of search, both ways.
    pub ray: Vec3,
    // Unit normal of the simplified mesh's face.
    pub normal: Vec3,
    // Vectors to the next texel, across and down.
    pub steps: [DVec3; 2],
}

#[derive(Clone, Copy, Debug)]
pub(super) struct QueryResult {
    // Unit normal of the original.
    pub normal: Vec3,
    pub sample: MaterialSample,
}

impl<'a> FineSurface<'a> {
    pub fn new(original: &BakeSource<'a>, coarse: &TriMesh) -> (Self, Vec<String>) {
        let mesh = original.mesh;
        let triangles: Vec<[[f32; 3]; 3]> = mesh.faces().iter().map(|face| corners(mesh, face)).collect();
        let normal = |face: usize| area_normal(triangles[face].map(Vec3::from)).normalize_or_zero();
        let of_faces = parallel::map(triangles.len(), 1024, normal);
        let normals = file_normals(original.attributes).unwrap_or_else(|| corner_normals(mesh, SMOOTH));
        let (materials, notes) = OriginalMaterials::new(original, &normals);
        let tree = NearestOnTriangles::new(&triangles);
        // The distance between the surfaces is not known in advance, so it is measured.
        let cage = (CAGE * largest_distance(&tree, coarse)).max(LEAST_CAGE * mesh.diagonal());
        (Self { mesh, tree, of_faces, normals, materials, cage }, notes)
    }

    pub fn query(&self, question: &SurfaceQuery) -> Option<QueryResult> {
        let (hit, side) = self.find_hit(question)?;
        let spot = self.spot(&hit, question.steps);
        let blend = |[a, b, c]: [Vec3; 3]| a * spot.weights[0] + b * spot.weights[1] + c * spot.weights[2];
        let own = self.of_faces[hit.triangle as usize];
        let smooth = blend(self.normals[hit.triangle as usize]).try_normalize().unwrap_or(own);
        Some(QueryResult {
            normal: side * self.materials.apply_normal_map(&spot, smooth),
            sample: self.materials.sample(&spot),
        })
    }

    /// Finds the original's point for a query, with 1, or -1 if only a back side is near.
    ///
    /// Order of choice: along the ray the nearest face of the same direction, else the nearest such face, else the
    /// nearest of all.
    fn find_hit(&self, SurfaceQuery { point, ray, normal, steps }: &SurfaceQuery) -> Option<(Hit, f32)> {
        let agrees = |face: u32| self.of_faces[face as usize].dot(*ray) > 0.0;
        let is_own = |face: u32| self.of_faces[face as usize].dot(*normal) > SAME;
        // Faces that look away belong to another side of the surface.
        let front = self.tree.crossing_along(*point, ray.as_dvec3(), self.cage, agrees);
        let front = front.map(|hit| {
            // Near an edge a ray may meet the other side: a face of the same side within a texel is preferred.
            let reach = steps[0].length().max(steps[1].length());
            let own = (!is_own(hit.triangle)).then(|| self.tree.nearest_within(hit.point, reach, is_own));
            own.flatten().unwrap_or(hit)
        });
        let front = front.or_else(|| self.tree.nearest_within(*point, self.cage, agrees));
        front.map(|hit| (hit, 1.0)).or_else(|| {
            let hit = self.tree.nearest(*point)?;
            Some((hit, if agrees(hit.triangle) { 1.0 } else { -1.0 }))
        })
    }

    fn spot(&self, hit: &Hit, steps: [DVec3; 2]) -> SamplePlace {
        let weights = hit.weights.map(|weight| weight.clamp(0.0, 1.0) as f32);
        let [a, b, c] = corners_f64(corners(self.mesh, &self.mesh.faces()[hit.triangle as usize]));
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let step = |step: DVec3| {
            let [v, w] = [step.cross(ac), ab.cross(step)].map(|part| part.dot(normal) / normal.length_squared());
            // A face without area has no steps.
            let steps = [-v - w, v, w].map(|x| x as f32);
            if steps.iter().all(|x| x.is_finite()) { steps } else { [0.0; 3] }
        };
        SamplePlace { face: hit.triangle, weights, steps: steps.map(step) }
    }
}

fn corners(mesh: &TriMesh, face: &[u32; 3]) -> [[f32; 3]; 3] {
    face.map(|v| mesh.positions()[v as usize])
}

fn file_normals(attributes: &Attributes) -> Option<Vec<[Vec3; 3]>> {
    let channel = attributes.normals()?;
    let normal = |wedge: u32| channel.value(wedge).first_chunk::<3>().map_or(Vec3::ZERO, |&normal| normal.into());
    Some(attributes.wedges.iter().map(|wedges| wedges.map(normal)).collect())
}

fn largest_distance(tree: &NearestOnTriangles, coarse: &TriMesh) -> f64 {
    let (positions, faces) = (coarse.positions(), coarse.faces());
    let middle = |face: &[u32; 3]| {
        corners(coarse, face).iter().map(|corner| Vec3::from(*corner).as_dvec3()).sum::<DVec3>() / 3.0
    };
    let distance = |i: usize| {
        let corner = positions.get(i).map(|p| Vec3::from(*p).as_dvec3());
        let point = corner.unwrap_or_else(|| middle(&faces[i - positions.len()]));
        tree.nearest(point).map_or(0.0, |hit| hit.distance2.sqrt())
    };
    parallel::map(positions.len() + faces.len(), 64, distance).into_iter().fold(0.0, f64::max)
}
