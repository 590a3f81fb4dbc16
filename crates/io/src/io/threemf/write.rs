//! Writing of a 3MF: a package of one model.

use std::io::{Cursor, Write};

use quick_xml::escape::escape;
use rustc_hash::FxHashMap;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::io::attributed_writer::{WriteTask, WrittenModel, describe_losses};
use crate::io::companion_files::FileFinder;
use crate::io::group_looks::read_looks;
use crate::io::write::Content;
use crate::io::{Extra, WriteError, units};
use crate::mesh::{Attributes, Channel, DistinctKeys, Look, Role, srgb};

const TYPES: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n\
    <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n\
    <Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n</Types>\n";

const RELATIONS: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n\
    <Relationship Id=\"rel0\" Target=\"/3D/3dmodel.model\" \
    Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>\n</Relationships>\n";

const MATERIALS: u32 = 1;
const COLOURS: u32 = 2;

pub(in crate::io) fn write(task: &WriteTask, _: &mut FileFinder) -> Result<WrittenModel, WriteError> {
    let WriteTask { content, attributes, extra, options } = task;
    let (looks, missing) = read_looks(extra, options.allow_outside);
    let losses = describe_losses(options.format, attributes, extra);
    let mut notes = losses.into_iter().chain(missing).collect();
    // Objects come first: if they cannot be separate, the rest changes.
    let objects = group_by_object(content, attributes, extra, &mut notes);
    let palette = Palette::from_channels(attributes);
    let mut materials = BaseMaterials::from_groups(attributes, extra, &looks.of_groups);
    // If corners have colours, a face without a material needs no white material of its own.
    if palette.colours.is_empty() {
        materials.add_plain();
    }
    let mut out = model_head(extra);
    materials.push(&mut out);
    palette.push(&mut out);
    let paint = FacePaint { attributes, materials: &materials, palette: &palette };
    for ((name, faces), id) in objects.iter().zip(COLOURS + 1..) {
        push_object(&mut out, content, &paint, (id, name, faces));
    }
    out.extend(b"</resources>\n<build>\n");
    for id in (COLOURS + 1..).take(objects.len()) {
        out.extend(format!("<item objectid=\"{id}\"/>\n").into_bytes());
    }
    out.extend(b"</build>\n</model>\n");
    notes.extend(paint.notes(content));
    let parts =
        [("[Content_Types].xml", TYPES.as_bytes()), ("_rels/.rels", RELATIONS.as_bytes()), ("3D/3dmodel.model", &out)];
    let bytes = package(&parts).map_err(|error| {
        WriteError::new(format!("the zip archive of the 3MF cannot be made: {error}: write ply or obj"))
    })?;
    Ok(WrittenModel { bytes, notes, n_vertices: Some(content.n_vertices()), ..WrittenModel::default() })
}

pub(super) fn package(parts: &[(&str, &[u8])]) -> zip::result::ZipResult<Vec<u8>> {
    // The time is fixed, so that equal models give equal bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .large_file(parts.iter().any(|(_, bytes)| bytes.len() >= u32::MAX as usize));
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        archive.start_file(*name, options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

fn model_head(extra: &Extra) -> Vec<u8> {
    let unit = extra.unit.as_deref().filter(|unit| units::is_known(unit)).unwrap_or("millimeter");
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"{unit}\" xml:lang=\"en-US\" \
         xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
         xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">\n\
         <metadata name=\"Application\">neural-mesh {version}</metadata>\n<resources>\n"
    )
    .into_bytes()
}

type NamedObjects<'a> = Vec<(&'a str, Vec<u32>)>;

fn group_by_object<'a>(
    content: &Content,
    attributes: &Attributes,
    extra: &'a Extra,
    notes: &mut Vec<String>,
) -> NamedObjects<'a> {
    let n_faces = content.faces.len() as u32;
    let mut objects: NamedObjects = Vec::new();
    let mut numbers: FxHashMap<&str, usize> = FxHashMap::default();
    let mut of_vertices: Vec<Option<usize>> = vec![None; content.n_vertices()];
    let mut is_shared = false;
    for face in 0..n_faces {
        let name = extra.group(attributes.group(face)).and_then(|group| group.object.as_deref()).unwrap_or_default();
        let number = *numbers.entry(name).or_insert(objects.len());
        if number == objects.len() {
            objects.push((name, Vec::new()));
        }
        objects[number].1.push(face);
        for &vertex in &content.faces[face as usize] {
            // Each object of 3MF has its own vertices.
            is_shared |= *of_vertices[vertex as usize].get_or_insert(number) != number;
        }
    }
    // Separate objects would tear shared vertices apart.
    if is_shared {
        notes.push(format!("{} objects share vertices: written as one", objects.len()));
        objects = vec![("", (0..n_faces).collect())];
    }
    objects
}

#[derive(Default)]
struct BaseMaterials<'a> {
    names: Vec<(&'a str, [f32; 4])>,
    of_groups: Vec<Option<usize>>,
}

impl<'a> BaseMaterials<'a> {
    fn from_groups(attributes: &Attributes, extra: &'a Extra, looks: &[Look]) -> Self {
        let mut materials = Self::default();
        let mut numbers: FxHashMap<&str, usize> = FxHashMap::default();
        // Without group numbers, only a single group applies to all faces.
        if attributes.groups.is_empty() && extra.groups.len() != 1 {
            return materials;
        }
        for (i, group) in extra.groups.iter().enumerate() {
            let number = group.material.as_deref().map(|name| {
                let next = materials.names.len();
                let number = *numbers.entry(name).or_insert(next);
                if number == next {
                    let [red, green, blue] = looks.get(i).map_or([1.0; 3], |look| look.colour.map(srgb));
                    materials.names.push((name, [red, green, blue, 1.0]));
                }
                number
            });
            materials.of_groups.push(number);
        }
        materials
    }

    fn add_plain(&mut self) {
        // Faces without a material would inherit that of the object.
        let plain = self.names.len();
        if plain > 0 && self.of_groups.contains(&None) {
            self.names.push(("default", [1.0; 4]));
            self.of_groups.iter_mut().filter(|material| material.is_none()).for_each(|it| *it = Some(plain));
        }
    }

    fn push(&self, out: &mut Vec<u8>) {
        if self.names.is_empty() {
            return;
        }
        out.extend(format!("<basematerials id=\"{MATERIALS}\">\n").into_bytes());
        for (name, colour) in &self.names {
            let line = format!("<base name=\"{}\" displaycolor=\"{}\"/>\n", escape_name(name), hex(*colour));
            out.extend(line.into_bytes());
        }
        out.extend(b"</basematerials>\n");
    }
}

#[derive(Default)]
struct Palette {
    colours: Vec<String>,
    of_wedges: Vec<u32>,
    white: Option<u32>,
}

impl Palette {
    fn from_channels(attributes: &Attributes) -> Self {
        let is_colour = |channel: &&Channel| channel.role == Role::Colour && channel.width >= 3;
        let Some(channel) = attributes.channels.iter().find(is_colour) else { return Self::default() };
        let mut colours = DistinctKeys::default();
        let rows = channel.values.chunks_exact(channel.width);
        let colour = |row: &[f32]| hex([row[0], row[1], row[2], row.get(3).copied().unwrap_or(1.0)]);
        let of_wedges = rows.map(|row| colours.number(colour(row))).collect();
        let white = colours.keys.iter().position(|colour| colour == "#FFFFFFFF").map(|number| number as u32);
        Self { colours: colours.keys, of_wedges, white }
    }

    fn push(&self, out: &mut Vec<u8>) {
        if self.colours.is_empty() {
            return;
        }
        out.extend(format!("<m:colorgroup id=\"{COLOURS}\">\n").into_bytes());
        for colour in &self.colours {
            out.extend(format!("<m:color color=\"{colour}\"/>\n").into_bytes());
        }
        out.extend(b"</m:colorgroup>\n");
    }
}

struct FacePaint<'a> {
    attributes: &'a Attributes,
    materials: &'a BaseMaterials<'a>,
    palette: &'a Palette,
}

impl FacePaint<'_> {
    fn colours(&self, face: u32) -> Option<[u32; 3]> {
        let wedges = self.attributes.wedges.get(face as usize).filter(|_| !self.palette.colours.is_empty())?;
        let colours = wedges.map(|wedge| self.palette.of_wedges[wedge as usize]);
        // Faces are white by default, so a material is worth more.
        let is_white = colours.iter().all(|&colour| Some(colour) == self.palette.white);
        (!is_white || self.material(face).is_none()).then_some(colours)
    }

    fn material(&self, face: u32) -> Option<usize> {
        *self.materials.of_groups.get(self.attributes.group(face) as usize)?
    }

    fn notes(&self, content: &Content) -> Option<String> {
        let has_both = |&face: &u32| self.material(face).is_some() && self.colours(face).is_some();
        let n_both = (0..content.faces.len() as u32).filter(has_both).count();
        (n_both > 0).then(|| {
            format!("3mf stores either a material or colours for a face: the materials of {n_both} coloured faces are dropped")
        })
    }

    fn push(&self, out: &mut Vec<u8>, face: u32) {
        if let Some([a, b, c]) = self.colours(face) {
            let more = if a == b && b == c { String::new() } else { format!(" p2=\"{b}\" p3=\"{c}\"") };
            out.extend(format!(" pid=\"{COLOURS}\" p1=\"{a}\"{more}").into_bytes());
        } else if let Some(material) = self.material(face) {
            out.extend(format!(" pid=\"{MATERIALS}\" p1=\"{material}\"").into_bytes());
        }
    }
}

fn push_object(out: &mut Vec<u8>, content: &Content, paint: &FacePaint, (id, name, faces): (u32, &str, &[u32])) {
    let name = if name.is_empty() { String::new() } else { format!(" name=\"{}\"", escape_name(name)) };
    out.extend(
        format!("<object id=\"{id}\" type=\"model\"{name}{}>\n<mesh>\n<vertices>\n", object_attributes(paint, faces))
            .into_bytes(),
    );
    // Vertices are renumbered within the object, in their order.
    let mut numbers: Vec<u32> = vec![u32::MAX; content.n_vertices()];
    faces.iter().flat_map(|&face| content.faces[face as usize]).for_each(|vertex| numbers[vertex as usize] = 0);
    let mut n_vertices = 0;
    for (vertex, number) in numbers.iter_mut().enumerate().filter(|(_, number)| **number == 0) {
        (*number, n_vertices) = (n_vertices, n_vertices + 1);
        push_vertex(out, content, vertex);
    }
    out.extend(b"</vertices>\n<triangles>\n");
    let mut digits = itoa::Buffer::new();
    for &face in faces {
        out.extend(b"<triangle");
        for (word, vertex) in [" v1=\"", " v2=\"", " v3=\""].iter().zip(content.faces[face as usize]) {
            out.extend(word.as_bytes());
            out.extend(digits.format(numbers[vertex as usize]).as_bytes());
            out.push(b'"');
        }
        paint.push(out, face);
        out.extend(b"/>\n");
    }
    out.extend(b"</triangles>\n</mesh>\n</object>\n");
}

fn object_attributes(paint: &FacePaint, faces: &[u32]) -> String {
    // Some programs require attributes of the object even if all faces have their own.
    let first = faces.first().copied().unwrap_or_default();
    match (paint.colours(first), paint.material(first)) {
        (Some([colour, ..]), _) => format!(" pid=\"{COLOURS}\" pindex=\"{colour}\""),
        (None, Some(material)) => format!(" pid=\"{MATERIALS}\" pindex=\"{material}\""),
        (None, None) => String::new(),
    }
}

fn push_vertex(out: &mut Vec<u8>, content: &Content, vertex: usize) {
    let mut position = Vec::new();
    content.push_position(&mut position, vertex);
    out.extend(b"<vertex");
    for (word, number) in [" x=\"", " y=\"", " z=\""].iter().zip(position.split(|&byte| byte == b' ')) {
        out.extend(word.as_bytes());
        out.extend(number);
        out.push(b'"');
    }
    out.extend(b"/>\n");
}

fn hex(colour: [f32; 4]) -> String {
    let [red, green, blue, alpha] = colour.map(|x| (x.clamp(0.0, 1.0) * 255.0).round() as u8);
    format!("#{red:02X}{green:02X}{blue:02X}{alpha:02X}")
}

fn escape_name(name: &str) -> String {
    // Control characters are invalid in XML, even escaped.
    let plain: String =
        name.chars().filter(|letter| !letter.is_control() && !matches!(letter, '\u{fffe}' | '\u{ffff}')).collect();
    escape(&plain).into_owned()
}
