//! Writing of a new asset from a mesh.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::draft::{Draft, NumberStorage, vector_shape};
use super::extensions::{drop_unused_names, name_extension};
use super::files::one_file;
use super::image_kinds::rename_images;
use super::images::move_to_files;
use super::materials::MaterialWriter;
use super::packed::{PrimitivePacking, QUANTIZATION, UvGrids, pack_as};
use super::primitive::{AttributeStorage, PrimitiveVertices, PrimitiveWriter};
use super::repack::{PackedBuffer, drop_unused};
use super::scene_writer::faces_by_group;
use super::simplified_part::SimplifiedPart;
use crate::io::attributed_writer::{WriteTask, WrittenModel};
use crate::io::companion_files::FileFinder;
use crate::io::extra::Group;
use crate::io::group_looks::read_looks;
use crate::io::write_options::WriteOptions;
use crate::io::{Format, OutputFile, Packing, WriteError};
use crate::mesh::{Channel, Look, PositionGrid, Role, linear_light};

const BASE_ONLY: &str = "gltf takes names, colours (Kd, Ke), roughness, metal and textures (map_Kd, map_Ke, norm) from a material library: its other properties are left out";

/// Writes a mesh as a single glTF file: GLB, or JSON with the buffer inside.
///
/// A node moves the mesh to `origin`. Each group becomes a primitive with a material. Channels are written by role,
/// with v downwards. The second result has one line per loss.
///
/// # Errors
/// [`WriteError`] if the part is not a valid mesh, or the format cannot store it.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::{Format, SimplifiedPart, read, write_gltf};
/// use neural_mesh::mesh::Attributes;
/// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let part = SimplifiedPart::new(positions, vec![[0, 1, 2]], Attributes::default());
/// let (bytes, notes) = write_gltf(part, [5e6, 0.0, 0.0], &["skin".into()], Format::Glb).unwrap();
/// assert_eq!(read(&bytes, None).unwrap().positions[1], [5e6 + 1.0, 0.0, 0.0]);
/// assert!(notes.is_empty());
/// ```
pub fn write_gltf(
    part: SimplifiedPart,
    origin: [f64; 3],
    group_names: &[String],
    format: Format,
) -> Result<(Vec<u8>, Vec<String>), WriteError> {
    let named = GroupProperties { names: group_names, ..GroupProperties::default() };
    let written = write_with_looks(part, origin, &named, &WriteOptions::new(format, ""))?;
    Ok((written.bytes, written.notes))
}

#[derive(Clone, Copy, Debug, Default)]
struct GroupProperties<'a> {
    names: &'a [String],
    groups: &'a [Group],
    looks: &'a [Look],
}

impl GroupProperties<'_> {
    fn material<'a>(
        &'a self,
        part: &SimplifiedPart,
        group: u32,
        draft: &mut Draft,
        materials: &mut MaterialWriter<'a>,
    ) -> Option<Value> {
        let look = self.looks.get(group as usize);
        let has_look = look.is_some_and(|look| look.texture.is_some());
        if part.attributes.groups.is_empty() && self.names.is_empty() && !has_look {
            return None;
        }
        let name = self.names.get(group as usize).cloned().unwrap_or_else(|| format!("group {group}"));
        Some(materials.push(draft, &name, look))
    }

    fn uv_grids(&self, part: &SimplifiedPart) -> UvGrids {
        let is_textured = |group: u32| {
            // The draft is thrown away: only writing shows whether a texture will be accepted.
            let (mut draft, mut materials) =
                (Draft { document: json!({}), views: Vec::new() }, MaterialWriter::default());
            self.material(part, group, &mut draft, &mut materials);
            draft.document.get("textures").is_some()
        };
        let textured: BTreeSet<u32> = faces_by_group(part).into_keys().filter(|&group| is_textured(group)).collect();
        UvGrids::of_groups(part, |group| textured.contains(&group))
    }
}

fn write_with_looks(
    mut part: SimplifiedPart,
    origin: [f64; 3],
    named: &GroupProperties,
    options: &WriteOptions,
) -> Result<WrittenModel, WriteError> {
    let (format, packing) = (options.format, options.packing.as_ref());
    if !matches!(format, Format::Gltf | Format::Glb) {
        return Err(WriteError::new(format!("{} is not glTF: choose gltf or glb", format.name())));
    }
    // glTF has no empty arrays, so an empty mesh cannot be written.
    if !part.is_mesh() || part.faces.is_empty() || !origin.iter().all(|x| x.is_finite()) {
        return Err(WriteError::new("glTF cannot store an empty or broken mesh: give faces and finite positions"));
    }
    // Names come first: attributes are found by them below.
    let mut notes = rename_channels(&mut part);
    let generator = concat!("neural-mesh ", env!("CARGO_PKG_VERSION"));
    let document = json!({"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}]});
    let mut draft = Draft { document, views: Vec::new() };
    let uvs = packing.map(|_| named.uv_grids(&part)).unwrap_or_default();
    let materials = MaterialWriter::new(options.images);
    let mut objects = ObjectPrimitives { materials, groups: Vec::new(), named: Vec::new(), n_vertices: 0 };
    for (group, faces) in faces_by_group(&part) {
        let (surface, compress) = (Some(group as usize), packing.is_some_and(Packing::is_compressed));
        let packed = packing.map(|packing| PrimitivePacking { grid: packing.grid(0), uvs: &uvs, surface, compress });
        objects.add(&mut draft, (&part, group, &faces), named, packed);
    }
    let grid = packing.and_then(|packing| packing.grid(0)).copied();
    // Without a grid, positions are written as they are.
    let grid = grid.unwrap_or(PositionGrid { origin: [0.0; 3], step: 1.0 });
    let place = PositionGrid { origin: std::array::from_fn(|axis| origin[axis] + grid.origin[axis]), ..grid };
    objects.named.into_iter().for_each(|(name, primitives)| push_object(&mut draft, &place, name, primitives));
    // Materials undo the grids of texture coordinates; the node undoes that of positions.
    if packing.is_some() {
        uvs.undo(&mut draft.document, |material| objects.groups[material]);
        name_extension(&mut draft.document, QUANTIZATION);
        drop_unused_names(&mut draft.document);
    }
    notes.append(&mut objects.materials.notes);
    let images = move_images(&mut draft, options);
    let mut buffer = PackedBuffer::default();
    pack_as(&mut draft, &mut buffer, usize::MAX, packing)?;
    let bytes = one_file(draft.document, &buffer.bytes, format)?;
    Ok(WrittenModel { bytes, companion_files: images, notes, n_vertices: Some(objects.n_vertices) })
}

fn move_images(draft: &mut Draft, options: &WriteOptions) -> Vec<OutputFile> {
    if !options.shares_images || options.format != Format::Gltf {
        return Vec::new();
    }
    let mut moved = move_to_files(draft, &options.name, &[]);
    rename_images(&mut draft.document, &mut moved, options.folder.as_ref(), None);
    // Only the views of the moved images are unused.
    if !moved.is_empty() {
        drop_unused(draft);
    }
    moved
}

struct ObjectPrimitives<'a> {
    materials: MaterialWriter<'a>,
    groups: Vec<usize>,
    named: Vec<(Option<&'a str>, Vec<Value>)>,
    n_vertices: usize,
}

impl<'a> ObjectPrimitives<'a> {
    fn add(
        &mut self,
        draft: &mut Draft,
        (part, group, faces): (&SimplifiedPart, u32, &[u32]),
        named: &'a GroupProperties,
        packed: Option<PrimitivePacking>,
    ) {
        let vertices = PrimitiveVertices::for_packing(part, faces, packed);
        self.n_vertices += vertices.len();
        let mut writer = PrimitiveWriter { draft, part, vertices: &vertices, packed };
        let mut primitive =
            json!({"attributes": writer.attributes(&attribute_storage(part)), "indices": writer.indices()});
        if let Some(material) = named.material(part, group, draft, &mut self.materials) {
            primitive["material"] = material;
            self.groups.push(group as usize);
        }
        let object = named.groups.get(group as usize).and_then(|group| group.object.as_deref());
        // Groups of one object go into one mesh, whatever their order.
        match self.named.iter_mut().find(|(known, _)| *known == object) {
            Some((_, primitives)) => primitives.push(primitive),
            None => self.named.push((object, vec![primitive])),
        }
    }
}

/// Writes a mesh as glTF: flips v and makes sRGB colours linear.
pub(in crate::io) fn write(task: &WriteTask, _: &mut FileFinder) -> Result<WrittenModel, WriteError> {
    let WriteTask { content, extra, options, .. } = task;
    // Single precision suffices relative to the origin, which the node stores in doubles.
    let (origin, positions) = content.local_positions();
    let mut attributes = task.attributes.clone();
    for channel in attributes.channels.iter_mut().filter(|channel| channel.role == Role::Uv) {
        channel.values.iter_mut().skip(1).step_by(2).for_each(|v| *v = 1.0 - *v);
    }
    for channel in attributes.channels.iter_mut().filter(|channel| channel.role == Role::Colour) {
        let colours = channel.values.chunks_exact_mut(channel.width.max(1));
        colours.flat_map(|colour| colour.iter_mut().take(3)).for_each(|x| *x = linear_light(*x));
    }
    // A mesh with one unnamed group has no material.
    let is_material = |group: &&Group| !attributes.groups.is_empty() || group.material.is_some();
    let groups: Vec<String> = extra.groups.iter().filter(is_material).map(Group::title).collect();
    let (looks, missing) = read_looks(extra, options.allow_outside);
    let named = GroupProperties { names: &groups, groups: &extra.groups, looks: &looks.of_groups };
    let part = SimplifiedPart { positions, faces: content.faces.to_vec(), attributes };
    let mut written = write_with_looks(part, origin, &named, options)?;
    let of_library = (!extra.material_libraries.is_empty()).then(|| BASE_ONLY.into());
    written.notes = of_library.into_iter().chain(missing).chain(written.notes).collect();
    Ok(written)
}

fn push_object(draft: &mut Draft, place: &PositionGrid, name: Option<&str>, primitives: Vec<Value>) {
    let mut mesh = json!({"primitives": primitives});
    let mut node = json!({});
    if let Some(name) = name {
        (mesh["name"], node["name"]) = (name.into(), name.into());
    }
    if place.origin != [0.0; 3] {
        node["translation"] = place.origin.to_vec().into();
    }
    if place.step != 1.0 {
        node["scale"] = vec![place.step; 3].into();
    }
    node["mesh"] = draft.push("meshes", mesh);
    let number = draft.push("nodes", node);
    if let Some(nodes) = draft.document["scenes"][0]["nodes"].as_array_mut() {
        nodes.push(number);
    }
}

fn rename_channels(part: &mut SimplifiedPart) -> Vec<String> {
    let (mut notes, mut counts) = (Vec::new(), [0; 2]);
    let mut next = |which: usize| {
        counts[which] += 1;
        counts[which] - 1
    };
    let mut kept: Vec<Channel> = Vec::new();
    for channel in std::mem::take(&mut part.attributes.channels) {
        let name = match (channel.role, channel.width) {
            (Role::Normal, 3) => "NORMAL".into(),
            (Role::Tangent, 4) => "TANGENT".into(),
            (Role::Uv, 2) => format!("TEXCOORD_{}", next(0)),
            (Role::Colour, 3 | 4) => format!("COLOR_{}", next(1)),
            (Role::Skin | Role::MorphPosition | Role::MorphDirection, _) | (_, 0 | 5..) => {
                notes.push(format!("glTF cannot store {} of a mesh without a scene: it is left out", channel.name));
                continue;
            }
            _ => custom_name(&channel.name),
        };
        if kept.iter().any(|other| other.name == name) {
            notes.push(format!("glTF stores {name} only once: a second channel is left out"));
        } else {
            kept.push(Channel { name, ..channel });
        }
    }
    part.attributes.channels = kept;
    notes
}

fn custom_name(name: &str) -> String {
    let letter = |letter: char| if letter.is_ascii_alphanumeric() { letter.to_ascii_uppercase() } else { '_' };
    let name: String = name.chars().map(letter).collect();
    format!("_{}", name.trim_start_matches('_'))
}

fn attribute_storage(part: &SimplifiedPart) -> AttributeStorage {
    let shape = |width: usize| NumberStorage::floats(vector_shape(width));
    let own = part.attributes.channels.iter().map(|channel| (channel.name.clone(), shape(channel.width)));
    std::iter::once(("POSITION".into(), shape(3))).chain(own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::Asset;
    use crate::mesh::{Attributes, Frame, TriMesh};

    fn channel(name: &str, role: Role, width: usize) -> Channel {
        let values = (0..6 * width).map(|at| at as f32 / 64.0).collect();
        Channel { name: name.into(), role, width, values }
    }

    #[test]
    fn what_corners_carry_comes_back() {
        let channels = vec![
            channel("vt", Role::Uv, 2),
            channel("confidence of it", Role::Other, 1),
            channel("rgb", Role::Colour, 3),
            channel("bones", Role::Skin, 8),
        ];
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let attributes = Attributes { wedges: vec![[0, 1, 2], [3, 4, 5]], channels, groups: vec![2, 0] };
        let part = SimplifiedPart { positions, faces: vec![[0, 1, 2], [2, 1, 3]], attributes };
        for format in [Format::Glb, Format::Gltf] {
            let (bytes, notes) = write_gltf(part.clone(), [0.0; 3], &["paper".into()], format).unwrap();
            assert_eq!(notes.len(), 1);
            assert_eq!(Format::from_content(&bytes), Some(format));
            let no_files = |_: &str| Err(crate::io::ReadError::file("none", ""));
            let asset = Asset::from_bytes(&bytes, &no_files).unwrap();
            let read = &asset.parts()[0].mesh.attributes;
            let names: Vec<&str> = read.channels.iter().map(|channel| channel.name.as_str()).collect();
            assert_eq!(names, ["COLOR_0", "TEXCOORD_0", "_CONFIDENCE_OF_IT"]);
            assert_eq!(read.channels[1].value(read.wedges[1][2]), [4.0 / 64.0, 5.0 / 64.0]);
            assert_eq!(asset.document["materials"][0]["name"], "paper");
            assert_eq!(asset.document["materials"][1]["name"], "group 2");
        }
    }

    #[test]
    fn far_out_it_keeps_its_precision() {
        let mesh = TriMesh::new(vec![[0.0; 3], [0.001, 0.0, 0.0], [0.0, 0.5, 0.0]], vec![[0, 1, 2]]).unwrap();
        let frame = Frame { origin: [5e6, -4e6, 0.0], double: true };
        for format in [Format::Glb, Format::Gltf] {
            let read = crate::io::read(&crate::io::write(&mesh, &frame, format).unwrap(), None).unwrap();
            assert_eq!(read.positions[1], frame.to_file([0.001, 0.0, 0.0]));
            assert!(read.double);
        }
        let exact = vec![[5e6, 0.0, 0.0], [5e6 + 0.25, 0.0, 0.0], [5e6, 0.1, 0.0]];
        let bytes = crate::io::write_exact(&mesh, exact, Format::Glb).unwrap();
        assert_eq!(crate::io::read(&bytes, None).unwrap().positions[1], [5e6 + 0.25, 0.0, 0.0]);
    }
}
