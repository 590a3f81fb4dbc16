//! Runs of either assembly on a mesh whose vertices are all used.

use crate::mesh::pulse::Pulse;
use crate::mesh::{Attributes, Role, TriMesh, compact, is_shaded_flat, with_flat_normals};

use super::closed::{
    ChangedResults, ClosedRequest, ClosedResult, DroppedFaces, LevelQueue, LevelState, Task, simplify_levels,
};
use super::input::Input;
use super::limits::Limit;
use super::options::{PaperOptions, Report, ScoreSource, Simplified, SimplifyError};
use super::paper;
use super::progress::Progress;
use super::sub_mesh::SubMesh;

/// Simplifies to the sizes of a queue with one collapse, dropping components that a viewer would hardly miss.
///
/// Ends before a size that is larger than the last, unless the collapse has kept its way.
pub(super) fn simplify_closed<'p>(
    task: &Task,
    state: &mut LevelState<'p>,
    queue: &mut dyn LevelQueue,
    progress: Progress<'p>,
) -> Result<(), SimplifyError> {
    let Some(dropped) = simplify_whole(task, state, queue, progress)? else { return Ok(()) };
    // At a size where a component is dropped, the rest is simplified again, from a saved collapse if there is one. It
    // then loses no further component.
    let rest = SubMesh::without_components(&task.input, [dropped.n_components, 0], |face| dropped.faces[face])?;
    let lift = |closed: &mut ClosedResult| rest.lift(&mut closed.simplified, &mut closed.derivative);
    state.n_without_dropping = 1;
    simplify_closed(&Task { input: rest.input(), ..*task }, state, &mut ChangedResults::new(queue, lift), progress)
}

/// Simplifies without dropping components; stops before the level at which one should be dropped.
fn simplify_whole<'p>(
    task: &Task,
    state: &mut LevelState<'p>,
    queue: &mut dyn LevelQueue,
    progress: Progress<'p>,
) -> Result<Option<DroppedFaces>, SimplifyError> {
    let plain = PlainInput::new(&task.input);
    let request = ClosedRequest::new(Task { input: plain.input(), ..*task });
    let restore = |closed: &mut ClosedResult| plain.restore(closed);
    simplify_levels(&request, state, &mut ChangedResults::new(queue, restore), progress)
}

/// Input without stored normals that equal the face normals.
// Such normals carry no information, and would make every edge a held hard edge.
pub(super) struct PlainInput<'a> {
    given: Input<'a>,
    /// Index and name of the channel left out.
    flat_normals: Option<(usize, &'a str)>,
    others: Option<Attributes>,
}

impl<'a> PlainInput<'a> {
    pub fn new(input: &Input<'a>) -> Self {
        let Input { mesh, attributes, .. } = *input;
        let mut channels = attributes.channels.iter().enumerate();
        let normals = channels.find(|(_, channel)| channel.role == Role::Normal);
        let normals = normals.filter(|_| is_shaded_flat(mesh, attributes));
        let others = normals.map(|_| attributes.clone().keep_roles(|role| role != Role::Normal, true));
        Self { given: *input, flat_normals: normals.map(|(at, channel)| (at, channel.name.as_str())), others }
    }

    pub fn input(&self) -> Input<'_> {
        Input { attributes: self.others.as_ref().unwrap_or(self.given.attributes), ..self.given }
    }

    /// Gives a result flat normals if the input had them, and kept faces all their values.
    pub fn restore(&self, closed: &mut ClosedResult) {
        if let Some((at, name)) = self.flat_normals {
            let Simplified { mesh, attributes, .. } = &mut closed.simplified;
            *attributes = with_flat_normals(mesh, attributes, name);
            // Channels keep the order of the input, by which others find them.
            let channels = &mut attributes.channels;
            channels[at..].rotate_right(1);
        }
        closed.restore_kept(self.given.attributes);
    }
}

pub(super) fn simplify_by_paper(
    mesh: &TriMesh,
    options: &PaperOptions,
    limit: Limit,
    progress: Progress,
) -> Result<Simplified, SimplifyError> {
    // The network's target is a number of vertices; a closed surface has about half as many vertices as faces.
    let n_target = limit.vertices.min((limit.faces / 2).max(3));
    let result = paper::simplify_in_run(mesh, n_target, options, progress)?;
    let mut positions = mesh.positions().to_vec();
    result.vertices.iter().zip(&result.positions).for_each(|(&v, &position)| positions[v as usize] = position);
    let (mesh, kept) = compact(&positions, result.faces).map_err(|_| SimplifyError::Overflow)?;
    let report = Report::for_mesh(progress.pulse, &mesh);
    let attributes = Attributes::default();
    Ok(Simplified { mesh, attributes, source_vertices: Some(kept), map: None, report })
}

pub(super) fn unchanged_result(pulse: Pulse, input: &Input, scores: ScoreSource) -> Simplified {
    let mesh = input.mesh;
    Simplified {
        mesh: mesh.clone(),
        attributes: input.attributes.clone(),
        source_vertices: Some((0..mesh.positions().len() as u32).collect()),
        map: None,
        report: Report { scores, ..Report::for_mesh(pulse, mesh) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Channel, shapes};
    use crate::simplify::{Options, Size, simplify};
    use std::ops::ControlFlow;

    #[test]
    fn flat_normals_keep_their_place_among_the_channels() {
        let mesh = shapes::icosphere(3);
        let values = mesh.positions().iter().flat_map(|p| [p[0], p[1]]).collect();
        let uv = Channel { name: "uv".into(), role: Role::Uv, width: 2, values };
        let wedges = mesh.faces().to_vec();
        let textured = Attributes { wedges, channels: vec![uv], ..Attributes::default() };
        let mut attributes = with_flat_normals(&mesh, &textured, "normal");
        attributes.channels.rotate_right(1);
        let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
        let options = Options::new(Size::Faces(200));
        let result = simplify(input, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        assert!(result.attributes.is_valid_for(200) && is_shaded_flat(&result.mesh, &result.attributes));
        let names: Vec<&str> = result.attributes.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["normal", "uv"]);
    }
}
