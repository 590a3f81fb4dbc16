//! Input of a simplification: the mesh, its attributes, and constraints.

use crate::mesh::{Attributes, Channel, FeatureEdge, SceneView, TriMesh, UnitedMesh, creases, edges, seams};

use super::options::{ClosedOptions, SimplifyError};

/// Mesh with its attributes, importance, scene and constraints.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Input<'a> {
    /// Mesh to simplify.
    pub mesh: &'a TriMesh,
    /// Attributes of corners and faces.
    pub attributes: &'a Attributes,
    /// Positive factor on the area of each vertex; empty if the scores determine it.
    pub importance: &'a [f32],
    /// Score of each vertex, as by [`network_scores`](super::network_scores): regions of larger scores keep more
    /// vertices; empty for [`ClosedOptions::scores`] (closed assembly).
    pub scores: &'a [f32],
    /// Placement of the mesh in a scene.
    pub scene: Option<&'a UnitedMesh>,
    /// Marks faces that come back unchanged; empty for none (closed assembly).
    pub kept: &'a [bool],
    /// Marks vertices that stay in place; empty for none (closed assembly).
    pub locked: &'a [bool],
}

impl<'a> From<&'a TriMesh> for Input<'a> {
    fn from(mesh: &'a TriMesh) -> Self {
        Self::bare(mesh)
    }
}

impl<'a> From<&Input<'a>> for Input<'a> {
    fn from(input: &Input<'a>) -> Self {
        *input
    }
}

impl<'a> Input<'a> {
    /// Wraps a mesh without attributes or constraints.
    pub fn bare(mesh: &'a TriMesh) -> Self {
        Self { mesh, attributes: Attributes::NONE, importance: &[], scores: &[], scene: None, kept: &[], locked: &[] }
    }

    /// Returns the mesh as a viewer of the scene sees it.
    #[doc(hidden)]
    pub fn view(&self) -> SceneView {
        scene_view(self.scene, self.mesh, self.attributes)
    }

    #[doc(hidden)]
    pub fn check(&self) -> Result<(), SimplifyError> {
        let is_factor = |x: &f32| *x > 0.0 && x.is_finite();
        let factors_fit = self.importance.is_empty()
            || self.importance.len() == self.mesh.positions().len() && self.importance.iter().all(is_factor);
        let n_faces = self.mesh.faces().len();
        let kept_fit = self.kept.is_empty() || self.kept.len() == n_faces;
        let scores_fit = self.scores.is_empty() || self.scores.len() == self.mesh.positions().len();
        let locked_fit = self.locked.is_empty() || self.locked.len() == self.mesh.positions().len();
        let all_fit = self.attributes.is_valid_for(n_faces) && factors_fit && scores_fit && kept_fit && locked_fit;
        if all_fit { Ok(()) } else { Err(SimplifyError::BadInput) }
    }
}

fn scene_view(scene: Option<&UnitedMesh>, mesh: &TriMesh, attributes: &Attributes) -> SceneView {
    match scene {
        Some(united) => united.view(mesh, attributes),
        None => SceneView { mesh: mesh.clone(), faces: (0..mesh.faces().len() as u32).collect() },
    }
}

/// Derives vertex importance from a channel: the mean of its first three numbers over the vertex's corners.
///
/// The least importance is a thousandth of the mean. `None` if a value is negative or not finite, or if
/// all are 0.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::{Attributes, Channel, Role, shapes}, simplify::importance_of_channel};
/// let mesh = shapes::tetrahedron();
/// let channel = Channel { name: "wear".into(), role: Role::Other, width: 1, values: vec![1.0, 3.0, 0.0, 0.0] };
/// let attributes = Attributes { wedges: mesh.faces().to_vec(), channels: vec![channel], ..Attributes::default() };
/// let importance = importance_of_channel(&mesh, &attributes, &attributes.channels[0]).unwrap();
/// assert_eq!(importance, [1.0, 3.0, 0.001, 0.001]);
/// ```
pub fn importance_of_channel(mesh: &TriMesh, attributes: &Attributes, channel: &Channel) -> Option<Vec<f32>> {
    // Opacity, the fourth number of a colour, does not count.
    let value = |&wedge: &u32| {
        let values = channel.value(wedge);
        let values = &values[..values.len().min(3)];
        values.iter().sum::<f32>() / values.len() as f32
    };
    let factors = means_at_vertices(mesh, attributes.wedges.as_flattened().iter().map(value), 0.0);
    let mean = factors.iter().sum::<f32>() / factors.len() as f32;
    // Written so that NaN fails.
    let is_usable = mean > 0.0 && factors.iter().all(|x| *x >= 0.0 && x.is_finite());
    is_usable.then(|| factors.into_iter().map(|x| x.max(1e-3 * mean)).collect())
}

/// Derives vertex importance from face groups: the mean over a vertex's corners of `factor(group)`; 1 without corners.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::{Attributes, shapes}, simplify::importance_of_groups};
/// let mesh = shapes::tetrahedron();
/// let attributes = Attributes { groups: vec![0, 0, 0, 1], ..Attributes::default() };
/// let importance = importance_of_groups(&mesh, &attributes, |group| if group == 1 { 4.0 } else { 1.0 });
/// let at_the_last_face = mesh.faces()[3].map(|v| importance[v as usize]);
/// assert_eq!(at_the_last_face, [2.0; 3]); // two faces count 1, one counts 4
/// ```
pub fn importance_of_groups(mesh: &TriMesh, attributes: &Attributes, factor: impl Fn(u32) -> f32) -> Vec<f32> {
    let of_faces = (0..mesh.faces().len() as u32).flat_map(|f| [factor(attributes.group(f)); 3]);
    means_at_vertices(mesh, of_faces, 1.0)
}

fn means_at_vertices(mesh: &TriMesh, at_corners: impl Iterator<Item = f32>, none: f32) -> Vec<f32> {
    let mut sums = vec![(0.0f32, 0.0f32); mesh.positions().len()];
    for (&v, value) in mesh.faces().as_flattened().iter().zip(at_corners) {
        let sum = &mut sums[v as usize];
        *sum = (sum.0 + value, sum.1 + 1.0);
    }
    sums.into_iter().map(|(sum, n)| if n > 0.0 { sum / n } else { none }).collect()
}

pub(super) fn kept_edges(input: &Input, options: &ClosedOptions) -> Vec<FeatureEdge> {
    let mut kept = seams(input.mesh, input.attributes, options.seam_error as f32);
    if let Some(degrees) = options.crease_angle {
        kept.extend(creases(input.mesh, degrees).into_iter().map(|ends| FeatureEdge {
            ends,
            slack: 0.0,
            is_hard: false,
        }));
        // An edge that is both seam and crease is held like a crease: the entry without slack comes first and stays.
        kept.sort_unstable_by(|x, y| x.ends.cmp(&y.ends).then(x.slack.total_cmp(&y.slack)));
        kept.dedup_by(|later, stays| {
            let is_same = later.ends == stays.ends;
            stays.is_hard |= is_same && later.is_hard;
            is_same
        });
    }
    kept
}

/// Marks the caller's locked vertices, those of kept faces and, with `lock_boundaries`, those of boundaries.
pub(super) fn locked_vertices(input: &Input, options: &ClosedOptions) -> Vec<bool> {
    if !options.lock_boundaries && input.kept.is_empty() {
        return input.locked.to_vec();
    }
    // Non-manifold edges are locked like boundaries: they have other than two faces.
    let mut locked = input.locked.to_vec();
    locked.resize(input.mesh.positions().len(), false);
    if options.lock_boundaries {
        let boundary = edges(input.mesh).into_iter().filter(|edge| edge.n_faces() != 2);
        boundary.flat_map(|edge| edge.ends).for_each(|v| locked[v as usize] = true);
    }
    let kept = input.mesh.faces().iter().zip(input.kept).filter(|(_, kept)| **kept);
    kept.flat_map(|(face, _)| face).for_each(|&v| locked[v as usize] = true);
    locked
}
