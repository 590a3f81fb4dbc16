//! Writing of OBJ.

use rustc_hash::FxHashMap;

use crate::io::attributed_writer::{WriteTask, WrittenModel};
use crate::io::companion_files::{FileFinder, to_reference};
use crate::io::extra::{Extra, Group, encode_text};
use crate::io::material_libraries::Libraries;
use crate::io::material_writer::MaterialLibrary;
use crate::io::texture_comments::{copy_comment_textures, texture_number};
use crate::io::write::{Content, push_singles};
use crate::io::{WriteError, shorten_name};
use crate::mesh::{Attributes, Role};

/// Writes an OBJ; its material libraries and textures are added to `finder`.
pub(in crate::io) fn write(task: &WriteTask, finder: &mut FileFinder) -> Result<WrittenModel, WriteError> {
    let WriteTask { content, attributes, .. } = task;
    let extra = &with_libraries(task.extra, attributes, &task.options.name, finder);
    let mut out = Vec::with_capacity(40 * content.n_vertices() + 24 * content.faces.len());
    let mut notes = Vec::new();
    for library in &extra.material_libraries {
        push_line(&mut out, b"mtllib", &encode_text(library, extra.latin1));
    }
    push_vertices(&mut out, content, attributes, &mut notes);
    let uvs = push_values(&mut out, b"vt ", Role::Uv, attributes);
    let normals = push_values(&mut out, b"vn ", Role::Normal, attributes);
    push_faces(&mut out, content, attributes, extra, &[uvs, normals]);
    notes.extend(describe_lost_channels(attributes));
    Ok(WrittenModel { bytes: out, notes, n_vertices: Some(content.n_vertices()), ..WrittenModel::default() })
}

fn with_libraries(extra: &Extra, attributes: &Attributes, name: &str, finder: &mut FileFinder) -> Extra {
    let mut extra = Extra { material_libraries: Libraries::find(extra, finder).names, ..extra.clone() };
    // OBJ cannot store numbers of faces (PLY columns such as `label`), so they become names of groups.
    for group in extra.groups.iter_mut().filter(|group| group.name.is_none() && !group.values.is_empty()) {
        let parts = extra.face_columns.iter().zip(&group.values);
        let parts: Vec<String> = parts.map(|(column, value)| format!("{}_{value}", column.name)).collect();
        group.name = Some(parts.join("_"));
    }
    // Materials that came with the mesh (glTF) become a library of their own.
    let own = MaterialLibrary::from_looks(&extra, name, finder);
    if !own.text.is_empty() {
        let library = finder.add_file(format!("{name}.mtl").as_ref(), &own.text);
        extra.material_libraries.push(to_reference(&library));
    }
    // Textures of a PLY become a library, unless the mesh already names one.
    let textures = copy_comment_textures(&extra, finder);
    if !textures.is_empty() && extra.material_libraries.is_empty() {
        let texts = textures.iter().enumerate();
        let text: String =
            texts.map(|(i, texture)| format!("newmtl texture_{i}\nKd 1 1 1\nmap_Kd {texture}\n")).collect();
        let library = finder.add_file(format!("{name}.mtl").as_ref(), text.as_bytes());
        extra.material_libraries = vec![to_reference(&library)];
        if extra.groups.is_empty() && attributes.groups.is_empty() {
            extra.groups = vec![Group::default()];
        }
        let number = |group: &Group| texture_number(&extra, group).filter(|&number| number < textures.len());
        let numbers: Vec<Option<usize>> = extra.groups.iter().map(number).collect();
        for (group, number) in extra.groups.iter_mut().zip(numbers) {
            group.material = number.map(|number| format!("texture_{number}"));
        }
    }
    extra
}

fn push_line(out: &mut Vec<u8>, word: &[u8], rest: &[u8]) {
    out.extend(word);
    if !rest.is_empty() {
        out.push(b' ');
        out.extend(rest);
    }
    out.push(b'\n');
}

fn push_vertices(out: &mut Vec<u8>, content: &Content, attributes: &Attributes, notes: &mut Vec<String>) {
    let colours = attributes.channel(Role::Colour).filter(|channel| channel.width >= 3);
    let mut wedge_of: Vec<Option<u32>> = vec![None; content.n_vertices()];
    let mut n_lost = 0;
    if let Some(channel) = colours {
        for (&vertex, &wedge) in content.faces.iter().flatten().zip(attributes.wedges.iter().flatten()) {
            // The first colour of a vertex is written; differing corners are counted as losses.
            let first = *wedge_of[vertex as usize].get_or_insert(wedge);
            n_lost += usize::from(channel.value(first) != channel.value(wedge));
        }
        if n_lost > 0 {
            notes.push(format!("obj stores one colour per vertex: the colours of {n_lost} corners are dropped"));
        }
        if channel.width > 3 {
            notes.push("obj cannot store alpha of colours: it is dropped".into());
        }
    }
    for (vertex, wedge) in wedge_of.iter().enumerate() {
        out.extend(b"v ");
        content.push_position(out, vertex);
        if let Some(channel) = colours {
            out.push(b' ');
            push_singles(out, wedge.map_or(&[1.0; 3], |wedge| &channel.value(wedge)[..3]));
        }
        out.push(b'\n');
    }
}

/// Writes the different values of a channel; returns the number of each wedge's line, or 0.
fn push_values(out: &mut Vec<u8>, word: &[u8], role: Role, attributes: &Attributes) -> Option<Vec<u32>> {
    let channel = attributes.channel(role)?;
    let mut of_wedges = vec![0; attributes.n_wedges()];
    let mut numbers = FxHashMap::default();
    for &wedge in attributes.wedges.iter().flatten() {
        let value = channel.value(wedge);
        // A wedge may occur at several corners; zero normals would be invalid.
        if of_wedges[wedge as usize] > 0 || role == Role::Normal && value.iter().all(|x| *x == 0.0) {
            continue;
        }
        // The key is the bits, so that equal values share a line and each differing value is kept.
        let mut key = [0; 3];
        key.iter_mut().zip(value).for_each(|(bits, x)| *bits = x.to_bits());
        let next = numbers.len() as u32 + 1;
        of_wedges[wedge as usize] = *numbers.entry(key).or_insert_with(|| {
            out.extend(word);
            push_singles(out, value);
            out.push(b'\n');
            next
        });
    }
    Some(of_wedges)
}

fn push_faces(
    out: &mut Vec<u8>,
    content: &Content,
    attributes: &Attributes,
    extra: &Extra,
    lines: &[Option<Vec<u32>>; 2],
) {
    let mut order: Vec<u32> = (0..content.faces.len() as u32).collect();
    // The sort is stable: faces keep their order within a group.
    order.sort_by_key(|&face| attributes.group(face));
    let mut state = Group::default();
    let mut digits = itoa::Buffer::new();
    for (i, &face) in order.iter().enumerate() {
        // Statements are written only if the group changes.
        if i == 0 || attributes.group(order[i - 1]) != attributes.group(face) {
            push_names(out, &mut state, extra.group(attributes.group(face)), extra.latin1);
        }
        let wedges = attributes.wedges.get(face as usize);
        // A face has values at all corners or at none: mixed forms are invalid.
        let line_numbers = lines.each_ref().map(|lines| {
            let corners = lines.as_ref().zip(wedges).map(|(lines, wedges)| wedges.map(|wedge| lines[wedge as usize]));
            corners.filter(|corners| corners.iter().all(|&line| line > 0))
        });
        out.push(b'f');
        for (corner, vertex) in content.faces[face as usize].into_iter().enumerate() {
            out.push(b' ');
            out.extend(digits.format(vertex + 1).as_bytes());
            let [uv, normal] = line_numbers.map(|corners| corners.map(|corners| corners[corner]));
            // A corner is written as `v`, `v/vt`, `v//vn` or `v/vt/vn`.
            if uv.is_some() || normal.is_some() {
                out.push(b'/');
            }
            uv.into_iter().for_each(|line| out.extend(digits.format(line).as_bytes()));
            if let Some(line) = normal {
                out.push(b'/');
                out.extend(digits.format(line).as_bytes());
            }
        }
        out.push(b'\n');
    }
}

fn push_names(out: &mut Vec<u8>, state: &mut Group, group: Option<&Group>, latin1: bool) {
    let Some(group) = group else { return };
    let names = [
        (&b"o"[..], &mut state.object, &group.object),
        (b"g", &mut state.name, &group.name),
        (b"usemtl", &mut state.material, &group.material),
        (b"s", &mut state.smoothing, &group.smoothing),
    ];
    for (word, old, new) in names {
        if let Some(name) = new.as_ref().filter(|_| old != new) {
            push_line(out, word, &encode_text(name, latin1));
            old.clone_from(new);
        }
    }
}

fn describe_lost_channels(attributes: &Attributes) -> Option<String> {
    let written = [Role::Uv, Role::Normal, Role::Colour].map(|role| attributes.channel(role).map(|c| &c.name));
    let names: Vec<_> = attributes
        .channels
        .iter()
        .filter(|channel| !written.contains(&Some(&channel.name)))
        .map(|channel| shorten_name(&channel.name))
        .collect();
    (!names.is_empty()).then(|| format!("obj cannot store {}: dropped", names.join(", ")))
}
