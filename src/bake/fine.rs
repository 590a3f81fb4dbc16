//! The surface of an original: which of its places belongs to one of the simplified surface, and what it looks like there.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::Original;
use super::frames::corner_normals;
use super::worn::{Sample, Spot, Worn};
use crate::geometry::triangle::area_normal;
use crate::mesh::{Attributes, Channel, Role, TriMesh};
use crate::spatial::{Hit, NearestOnTriangles};

/// Degrees between faces up to which they are drawn smooth where a file has no normals: the angle by which programs tell creases.
const SMOOTH: f32 = 30.0;
/// How far is looked along a normal, over the largest distance found: a line that meets the other surface at 70 degrees from its
/// normal is three times as long as the distance.
const CAGE: f64 = 3.0;
/// The same, at least, as a share of the diagonal of the original: where surfaces are the same, rounding remains.
const LEAST_CAGE: f64 = 1e-4;

/// Cosine between the normals of two faces above which they are on the same side of an edge.
const SAME: f32 = 0.5;

/// An original ready to be asked.
pub(super) struct Fine<'a> {
    mesh: &'a TriMesh,
    tree: NearestOnTriangles,
    /// Unit normals, n_faces.
    of_faces: Vec<Vec3>,
    /// Normals at the corners, n_faces x 3.
    normals: Vec<[Vec3; 3]>,
    worn: Worn,
    /// How far is looked along a normal.
    cage: f64,
}

/// A place of the simplified surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Question {
    /// Where it is.
    pub point: DVec3,
    /// Along which the original is looked for, both ways.
    pub ray: Vec3,
    /// The normal of the face.
    pub normal: Vec3,
    /// How far the next texel is, across and down.
    pub steps: [DVec3; 2],
}

/// What of the original belongs there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    /// The unit normal of the original.
    pub normal: Vec3,
    /// What it looks like.
    pub sample: Sample,
}

impl<'a> Fine<'a> {
    /// An original, to be asked from places of `coarse`; beside it what of its materials could not be had.
    pub fn of(original: &Original<'a>, coarse: &TriMesh) -> (Self, Vec<String>) {
        let mesh = original.mesh;
        let triangles: Vec<[[f32; 3]; 3]> = mesh.faces().par_iter().map(|face| corners(mesh, face)).collect();
        let of_faces =
            triangles.par_iter().map(|corners| area_normal(corners.map(Vec3::from)).normalize_or_zero()).collect();
        let normals = stated_normals(original.attributes).unwrap_or_else(|| corner_normals(mesh, SMOOTH));
        let (worn, notes) = Worn::of(original, &normals);
        let tree = NearestOnTriangles::new(&triangles);
        let cage = (CAGE * largest_distance(&tree, coarse)).max(LEAST_CAGE * mesh.diagonal());
        (Self { mesh, tree, of_faces, normals, worn, cage }, notes)
    }

    /// What belongs to a place of the simplified surface; `None` of an original without faces.
    pub fn at(&self, question: &Question) -> Option<Answer> {
        let (hit, side) = self.hit(question)?;
        let spot = self.spot(&hit, question.steps);
        let blend = |[a, b, c]: [Vec3; 3]| a * spot.weights[0] + b * spot.weights[1] + c * spot.weights[2];
        let own = self.of_faces[hit.triangle as usize];
        let smooth = blend(self.normals[hit.triangle as usize]).try_normalize().unwrap_or(own);
        Some(Answer { normal: side * self.worn.turned(&spot, smooth), sample: self.worn.at(&spot) })
    }

    /// The place itself, and -1 where only its back is near: along the ray the nearest face that looks the same way, else the
    /// nearest such face, else the nearest of all. Within a texel of an edge, where a ray
    /// meets both sides, it is the own one.
    fn hit(&self, Question { point, ray, normal, steps }: &Question) -> Option<(Hit, f32)> {
        let agrees = |face: u32| self.of_faces[face as usize].dot(*ray) > 0.0;
        let is_own = |face: u32| self.of_faces[face as usize].dot(*normal) > SAME;
        let front = self.tree.along(*point, ray.as_dvec3(), self.cage, agrees);
        let front = front.map(|hit| {
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

    fn spot(&self, hit: &Hit, steps: [DVec3; 2]) -> Spot {
        let weights = hit.weights.map(|weight| weight.clamp(0.0, 1.0) as f32);
        let [a, b, c] = corners(self.mesh, &self.mesh.faces()[hit.triangle as usize])
            .map(|corner| DVec3::from(corner.map(f64::from)));
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let step = |step: DVec3| {
            let [v, w] = [step.cross(ac), ab.cross(step)].map(|part| part.dot(normal) / normal.length_squared());
            // A face without area has no steps.
            let steps = [-v - w, v, w].map(|x| x as f32);
            if steps.iter().all(|x| x.is_finite()) { steps } else { [0.0; 3] }
        };
        Spot { face: hit.triangle, weights, steps: steps.map(step) }
    }
}

fn corners(mesh: &TriMesh, face: &[u32; 3]) -> [[f32; 3]; 3] {
    face.map(|v| mesh.positions()[v as usize])
}

/// The normals that the file states, n_faces x 3; `None` where it states none.
fn stated_normals(attributes: &Attributes) -> Option<Vec<[Vec3; 3]>> {
    let is_normal = |channel: &&Channel| channel.role == Role::Normal && channel.width == 3;
    let channel = attributes.channels.iter().find(is_normal)?;
    let normal = |wedge: u32| channel.value(wedge).first_chunk::<3>().map_or(Vec3::ZERO, |&normal| normal.into());
    Some(attributes.wedges.iter().map(|wedges| wedges.map(normal)).collect())
}

/// The largest distance found of a corner or the middle of a face of `coarse`.
fn largest_distance(tree: &NearestOnTriangles, coarse: &TriMesh) -> f64 {
    let middle = |face: &[u32; 3]| {
        corners(coarse, face).iter().map(|corner| DVec3::from(corner.map(f64::from))).sum::<DVec3>() / 3.0
    };
    let distance = |p: DVec3| tree.nearest(p).map_or(0.0, |hit| hit.distance2.sqrt());
    let at_corners = coarse.positions().par_iter().map(|p| distance(DVec3::from(p.map(f64::from))));
    let in_faces = coarse.faces().par_iter().map(|face| distance(middle(face)));
    at_corners.chain(in_faces).reduce(|| 0.0, f64::max)
}
