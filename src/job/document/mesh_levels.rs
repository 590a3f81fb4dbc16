//! Levels of a mesh in one glTF: the mesh becomes a scene, whose levels engines find by their nodes.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use crate::io::{self, Asset, Extra, Format, Group, Model, SimplifiedPart, WriteError, WriteOptions};
use crate::job::choices::Ignored;
use crate::job::request::Job;
use crate::mesh::{Attributes, TriMesh};
use crate::simplify::Simplified;

use super::{Document, Kind};

/// The mesh of a document as a scene with a node for each object, and its levels.
pub(super) struct MeshLevels {
    pub asset: Asset,
    pub levels: Vec<Vec<SimplifiedPart>>,
    /// Content that glTF cannot store, one line each.
    pub notes: Vec<String>,
}

/// Mesh of a scene and primitive of that mesh.
type PrimitivePlace = (usize, u32);

impl Document {
    /// Makes a scene of the results, named after the file; `None` for a scene, or if each level has its own file.
    pub(super) fn mesh_levels(&self, results: &[&Simplified], job: &Job) -> Result<Option<MeshLevels>, WriteError> {
        let Kind::Mesh { extra, .. } = &self.kind else { return Ok(None) };
        let is_apart = job.has_file_per_level(false) || job.names.are_several();
        if job.goal.n_levels().is_none() || is_apart {
            return Ok(None);
        }
        let extra = with_named_objects(kept_extra(extra, job).into_owned(), job.names.file(0));
        // The scene needs each material once; all faces come from the levels.
        let (least, attributes) = self.least_mesh();
        let (scene, notes) = self.to_scene((&least, &attributes), &extra, job)?;
        let places = find_primitives(&attributes, &extra);
        let level = |result: &&Simplified| {
            let (made, _) = self.to_scene((&result.mesh, &result.attributes), &extra, job)?;
            Ok(move_faces(&made, &find_primitives(&result.attributes, &extra), (&scene, &places)))
        };
        let levels = results.iter().map(level).collect::<Result<_, _>>()?;
        Ok(Some(MeshLevels { asset: scene, levels, notes }))
    }

    fn to_scene(
        &self,
        (mesh, attributes): (&TriMesh, &Attributes),
        extra: &Extra,
        job: &Job,
    ) -> Result<(Asset, Vec<String>), WriteError> {
        let mut options = WriteOptions::new(Format::Glb, String::new());
        options.allow_outside = job.arguments.allow_outside;
        let written = io::write_attributed(&Model::new(mesh, self.frame, attributes, extra), &options)?;
        let asset = Asset::from_stream(&written.bytes).map_err(|error| WriteError::new(error.to_string()))?;
        Ok((asset, written.notes))
    }
}

/// Returns what a result carries over from the file: with materials ignored, and in bare formats, the unit alone.
pub(super) fn kept_extra<'a>(extra: &'a Extra, job: &Job) -> Cow<'a, Extra> {
    if !job.arguments.ignore.contains(&Ignored::Materials) && !job.format.is_bare() {
        return Cow::Borrowed(extra);
    }
    let mut nameless = Extra::default();
    nameless.unit.clone_from(&extra.unit);
    Cow::Owned(nameless)
}

/// Names objects without a name after the file, as levels are found by the names of nodes.
fn with_named_objects(mut named: Extra, file_name: &str) -> Extra {
    let stem = Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    if named.groups.is_empty() {
        named.groups.push(Group::default());
    }
    named.groups.iter_mut().for_each(|group| group.object = group.object.take().or_else(|| Some(stem.clone())));
    named
}

/// Finds the primitive of each group in a written mesh: objects and groups are in the order of the groups' numbers.
fn find_primitives(attributes: &Attributes, extra: &Extra) -> BTreeMap<u32, PrimitivePlace> {
    let mut groups = attributes.groups.clone();
    groups.sort_unstable();
    groups.dedup();
    // Without numbers, all faces are of group 0.
    if groups.is_empty() {
        groups.push(0);
    }
    let mut objects: Vec<(Option<&str>, u32)> = Vec::new();
    let mut find_primitive = |group: u32| {
        let object = extra.groups.get(group as usize).and_then(|group| group.object.as_deref());
        let at = objects.iter().position(|(known, _)| *known == object).unwrap_or_else(|| {
            objects.push((object, 0));
            objects.len() - 1
        });
        objects[at].1 += 1;
        (at, objects[at].1 - 1)
    };
    groups.into_iter().map(|group| (group, find_primitive(group))).collect()
}

/// Moves the faces of a level's scene to the primitives that their groups have in another scene.
fn move_faces(
    level: &Asset,
    of_level: &BTreeMap<u32, PrimitivePlace>,
    (scene, places): (&Asset, &BTreeMap<u32, PrimitivePlace>),
) -> Vec<SimplifiedPart> {
    let without_faces = |part| {
        let SimplifiedPart { attributes, .. } = SimplifiedPart::from_part(part);
        SimplifiedPart::new(Vec::new(), Vec::new(), attributes.select_faces(&[]).unwrap_or_default())
    };
    let mut moved: Vec<SimplifiedPart> = scene.parts().iter().map(without_faces).collect();
    let targets: BTreeMap<PrimitivePlace, PrimitivePlace> =
        of_level.iter().filter_map(|(group, own)| Some((*own, *places.get(group)?))).collect();
    for (number, part) in level.parts().iter().enumerate() {
        let mut part = SimplifiedPart::from_part(part);
        part.attributes.groups.resize(part.faces.len(), 0);
        let Some(&(target, _)) = targets.get(&(number, 0)) else { continue };
        for primitive in &mut part.attributes.groups {
            *primitive = targets.get(&(number, *primitive)).map_or(0, |(_, primitive)| *primitive);
        }
        moved[target] = part;
    }
    moved
}
