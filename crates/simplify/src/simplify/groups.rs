//! Groups of faces with targets of their own.

use std::ops::ControlFlow;

use rustc_hash::FxHashSet;

use crate::mesh::{Attributes, TriMesh, UnitedMesh};

use super::input::Input;
use super::levels::simplify_forcing_size;
use super::options::{ClosedOptions, Event, Hidden, Listener, SimplifyError};
use super::size::{Size, count_of_share};

/// Groups with the share of their vertices to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupRatio {
    /// Group numbers, as in [`Attributes::group`].
    pub groups: Vec<u32>,
    /// Share above 0 and at most 1; 1 keeps the faces unchanged.
    pub ratio: f64,
}

/// Mesh whose selected groups are simplified.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SimplifiedGroups {
    /// Partly simplified mesh.
    pub mesh: TriMesh,
    /// Attributes of corners and faces.
    pub attributes: Attributes,
    /// Importance of the vertices; empty if the scores determine it.
    pub importance: Vec<f32>,
    /// Scores of the vertices; empty for none.
    pub scores: Vec<f32>,
    /// Marks faces of the simplified groups, which the run for the rest must keep.
    pub kept: Vec<bool>,
    /// Input face beneath each face.
    pub faces: Vec<u32>,
    /// Input vertex of each vertex, if all have one.
    pub sources: Option<Vec<u32>>,
}

impl SimplifiedGroups {
    /// Returns the input of a run that simplifies the other groups.
    pub fn input<'a>(&'a self, scene: Option<&'a UnitedMesh>) -> Input<'a> {
        let Self { mesh, attributes, importance, scores, kept, .. } = self;
        Input { scene, kept, attributes, importance, scores, ..Input::bare(mesh) }
    }
}

/// Simplifies each entry's groups to its share, in order; faces that share no vertex with these groups stay.
///
/// No component is dropped.
///
/// # Errors
/// As [`simplify`](super::simplify); [`SimplifyError::BadTarget`] for a share out of range.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::{Attributes, shapes};
/// use neural_mesh::simplify::{ClosedOptions, GroupRatio, Input, Options, Size, simplify_groups, simplify};
/// let mesh = shapes::icosphere(4);
/// let north = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() > 0.0;
/// let groups = mesh.faces().iter().map(|face| u32::from(north(face))).collect();
/// let attributes = Attributes { groups, ..Attributes::default() };
/// let mut input = Input::bare(&mesh);
/// input.attributes = &attributes;
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let halved = GroupRatio { groups: vec![1], ratio: 0.3 };
/// let before = simplify_groups(&input, &ClosedOptions::default(), &[halved], go_on).unwrap();
/// let n_north = before.kept.iter().filter(|kept| **kept).count();
/// assert!((0.25..0.35).contains(&(n_north as f64 / 2560.0)));
/// let whole = Options::new(Size::Vertices(512));
/// let result = simplify(&before.input(None), &whole, go_on).unwrap();
/// assert_eq!(result.mesh.positions().len(), 512);
/// ```
pub fn simplify_groups(
    input: &Input,
    options: &ClosedOptions,
    ratios: &[GroupRatio],
    progress: &mut Listener,
) -> Result<SimplifiedGroups, SimplifyError> {
    // Shares are checked before any work, written so that NaN fails too.
    let refused = ratios.iter().find(|of| !(of.ratio > 0.0 && of.ratio <= 1.0));
    if let Some(refused) = refused {
        return Err(SimplifyError::BadTarget(Size::Ratio(refused.ratio)));
    }
    let n_faces = input.mesh.faces().len() as u32;
    let mut current = SimplifiedGroups {
        mesh: input.mesh.clone(),
        attributes: input.attributes.clone(),
        importance: input.importance.to_vec(),
        scores: input.scores.to_vec(),
        kept: vec![false; n_faces as usize],
        faces: (0..n_faces).collect(),
        sources: Some((0..input.mesh.positions().len() as u32).collect()),
    };
    // Groups of share 1 are held from the beginning, the others once they are simplified.
    let mut kept_groups: FxHashSet<u32> =
        ratios.iter().filter(|of| of.ratio == 1.0).flat_map(|of| &of.groups).copied().collect();
    let smaller: Vec<&GroupRatio> = ratios.iter().filter(|of| of.ratio < 1.0).collect();
    for (number, of) in smaller.iter().enumerate() {
        let mut report = |mut event: Event| -> ControlFlow<()> {
            // Each group is an equal share of the run's progress.
            event.total = (number as f32 + event.total) / smaller.len() as f32;
            progress(event)
        };
        current = simplify_group(current, (of, &kept_groups), (options, input.scene), &mut report)?;
        kept_groups.extend(&of.groups);
    }
    current.kept = (0..current.mesh.faces().len() as u32)
        .map(|face| kept_groups.contains(&current.attributes.group(face)))
        .collect();
    Ok(current)
}

fn simplify_group(
    before: SimplifiedGroups,
    (of, kept_groups): (&GroupRatio, &FxHashSet<u32>),
    (options, scene): (&ClosedOptions, Option<&UnitedMesh>),
    progress: &mut Listener,
) -> Result<SimplifiedGroups, SimplifyError> {
    let (kept, n_own) = mark_kept_faces(&before, of, kept_groups);
    // The target is the whole mesh less what the group loses.
    let n_removed = n_own - count_of_share(n_own, of.ratio).min(n_own);
    let n_used = before.mesh.faces().as_flattened().iter().copied().collect::<FxHashSet<u32>>().len();
    let target = Size::Vertices((n_used - n_removed).max(1));
    let options = options_for_group(options);
    let input = Input { kept: &kept, ..before.input(scene) };
    let result = simplify_forcing_size(&input, &options, target, progress)?;
    // Importance, scores and origins follow the map from group to group.
    let map = result.map.unwrap_or_default();
    let carried = |rows: &[f32]| map.input_vertices.iter().filter_map(|&v| rows.get(v as usize).copied()).collect();
    let [importance, scores] = [&before.importance, &before.scores].map(|rows| carried(rows));
    let sources = result.source_vertices.zip(before.sources.as_ref());
    Ok(SimplifiedGroups {
        importance,
        scores,
        kept: Vec::new(),
        faces: map.corner_faces.iter().map(|corners| before.faces[corners[0] as usize]).collect(),
        sources: sources.map(|(own, before)| own.iter().map(|&v| before[v as usize]).collect()),
        mesh: result.mesh,
        attributes: result.attributes,
    })
}

fn mark_kept_faces(before: &SimplifiedGroups, of: &GroupRatio, kept_groups: &FxHashSet<u32>) -> (Vec<bool>, usize) {
    let faces = before.mesh.faces();
    let group = |face: usize| before.attributes.group(face as u32);
    let is_own = |face: usize| of.groups.contains(&group(face)) && !kept_groups.contains(&group(face));
    let mut is_touched = vec![false; before.mesh.positions().len()];
    let own = faces.iter().enumerate().filter(|(face, _)| is_own(*face));
    own.flat_map(|(_, corners)| corners).for_each(|&v| is_touched[v as usize] = true);
    // A face next to the group shares vertices with it, and so may change.
    let touches = |corners: &[u32; 3]| corners.iter().any(|&v| is_touched[v as usize]);
    let kept = faces
        .iter()
        .enumerate()
        .map(|(face, corners)| kept_groups.contains(&group(face)) || !touches(corners))
        .collect();
    (kept, is_touched.iter().filter(|is_touched| **is_touched).count())
}

fn options_for_group(options: &ClosedOptions) -> ClosedOptions {
    let hidden = if options.hidden == Hidden::Drop { Hidden::Keep } else { options.hidden };
    ClosedOptions { hidden, map: true, prune: false, prune_below: 0.0, ..options.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, topology};
    use crate::simplify::{Options, simplify};

    fn banded_sphere() -> (TriMesh, Attributes) {
        let mesh = shapes::wavy_sphere(4, 6.0);
        let height = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() / 3.0;
        let band = |face: &[u32; 3]| {
            if height(face) > 0.5 {
                3
            } else if height(face) > 0.0 {
                2
            } else {
                u32::from(height(face) > -0.5)
            }
        };
        let groups = mesh.faces().iter().map(band).collect();
        (mesh, Attributes { groups, ..Attributes::default() })
    }

    fn count_faces(attributes: &Attributes, group: u32) -> usize {
        attributes.groups.iter().filter(|of| **of == group).count()
    }

    #[test]
    fn each_group_has_its_share_and_the_surface_stays_whole() {
        let (mesh, attributes) = banded_sphere();
        let mut input = Input::bare(&mesh);
        let importance = vec![1.0; mesh.positions().len()];
        (input.attributes, input.importance) = (&attributes, &importance);
        let ratios = [(3, 0.5), (1, 1.0), (0, 0.2)].map(|(group, ratio)| GroupRatio { groups: vec![group], ratio });
        let mut go_on = |_| ControlFlow::Continue(());
        let made = simplify_groups(&input, &ClosedOptions::default(), &ratios, &mut go_on).unwrap();
        assert!(topology(&made.mesh).is_closed_manifold());
        assert_eq!(made.importance.len(), made.mesh.positions().len());
        let share =
            |after: &Attributes, group| count_faces(after, group) as f64 / count_faces(&attributes, group) as f64;
        for (group, ratio) in [(3, 0.5), (1, 1.0), (0, 0.2)] {
            let found = share(&made.attributes, group);
            assert!((found - ratio).abs() < 0.08, "{group}: {found}");
        }
        assert!(
            made.faces
                .iter()
                .zip(&made.attributes.groups)
                .all(|(&face, group)| attributes.groups[face as usize] == *group)
        );
        let whole = Options::new(Size::Vertices(made.mesh.positions().len() * 24 / 25));
        let result = simplify(made.input(None), &whole, &mut go_on).unwrap();
        assert!(topology(&result.mesh).is_closed_manifold());
        let kept = |group| count_faces(&result.attributes, group) == count_faces(&made.attributes, group);
        assert!(kept(3) && kept(1) && kept(0) && !kept(2));
    }

    #[test]
    fn shares_out_of_range_are_refused() {
        let (mesh, attributes) = banded_sphere();
        let mut input = Input::bare(&mesh);
        input.attributes = &attributes;
        for ratio in [0.0, -1.0, 1.5, f64::NAN] {
            let ratios = [GroupRatio { groups: vec![0], ratio }];
            let refused =
                simplify_groups(&input, &ClosedOptions::default(), &ratios, &mut |_| ControlFlow::Continue(()));
            assert!(matches!(refused, Err(SimplifyError::BadTarget(_))), "{ratio}");
        }
    }
}
