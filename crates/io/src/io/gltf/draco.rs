//! Decoding of `KHR_draco_mesh_compression`.

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex};

use super::accessor::{component, element_size, shape_width};
use super::buffers::AssetBuffers;
use super::schema::{Accessor, Root};
use crate::io::ReadError;
use crate::io::memory::reserve;
use crate::io::one_line::one_line;

/// Largest number of unpacked bytes: the first times the bytes of all buffers, plus the second.
const GROWTH: (usize, usize) = (256, 1 << 26);

pub(super) fn decompress(root: &mut Root, buffers: &AssetBuffers) -> Result<(), ReadError> {
    let mut budget = GROWTH.0.saturating_mul(buffers.n_bytes()).saturating_add(GROWTH.1);
    let Root { meshes, accessors, buffer_views, .. } = root;
    for primitive in meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        let Some(draco) = primitive.draco_alone(accessors) else { continue };
        let broken = |why: &str| {
            let what = format!("geometry compressed by Draco cannot be decoded ({why})");
            ReadError::file(what, "export the asset again, or without the compression")
        };
        let view = draco.buffer_view.and_then(|view| buffer_views.get(view)).ok_or_else(|| broken("no buffer view"))?;
        let bytes = buffers.part(view.buffer, view.byte_offset, view.byte_length);
        let mesh = decode_mesh(bytes.ok_or_else(|| broken("no bytes"))?, budget).map_err(|why| broken(&why))?;
        // Each decoded array counts against the budget, as a small stream may grow large.
        let mut take = |accessor: Option<&mut Accessor>, values: Option<Vec<u8>>, count: usize| {
            let (Some(accessor), Some(values)) = (accessor, values) else { return Err(broken("no such values")) };
            budget = budget.checked_sub(values.len()).ok_or_else(|| broken("too many values"))?;
            (accessor.count, accessor.decoded, accessor.byte_offset) = (count, Some(values), 0);
            Ok(())
        };
        for (name, &id) in &draco.attributes {
            let index = primitive.attributes.get(name).ok_or_else(|| broken(name))?;
            let accessor = accessors.get_mut(*index);
            let attribute = mesh.attribute_by_unique_id(id);
            let values = accessor
                .as_ref()
                .zip(attribute)
                .and_then(|(accessor, it)| attribute_values(it, mesh.num_points(), accessor));
            take(accessor, values, mesh.num_points())?;
        }
        if let Some(index) = primitive.indices {
            let accessor = accessors.get_mut(index);
            let indices = accessor.as_ref().and_then(|accessor| face_indices(&mesh, accessor));
            take(accessor, indices, 3 * mesh.num_faces())?;
        }
        primitive.mode = TRIANGLES;
    }
    Ok(())
}

const TRIANGLES: u32 = 4;

fn decode_mesh(bytes: &[u8], most: usize) -> Result<Mesh, String> {
    let most = most as u64;
    let limits =
        DecodeLimits::default().with_max_points(most / 4).with_max_faces(most / 12).with_max_decoded_bytes(most);
    let mut mesh = Mesh::new();
    let status = MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh);
    status.map(|_| mesh).map_err(|error| one_line(&error.to_string()))
}

fn attribute_values(attribute: &PointAttribute, n_points: usize, accessor: &Accessor) -> Option<Vec<u8>> {
    let width = Some(shape_width(&accessor.shape)).filter(|width| *width > 0 && !accessor.shape.starts_with("MAT"))?;
    let scalar = component(accessor.component_type)?;
    let size = element_size(&accessor.shape, accessor.component_type);
    let mut values = Vec::new();
    reserve(&mut values, n_points.checked_mul(size).filter(|_| size > 0)?).ok()?;
    // Equal types are copied byte by byte, others are converted through singles.
    if component_type_of(attribute.data_type()) == Some(accessor.component_type)
        && usize::from(attribute.num_components()) == width
    {
        let stride = usize::try_from(attribute.byte_stride()).ok()?;
        let bytes = attribute.buffer().data();
        for point in 0..n_points {
            let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
            values.extend(bytes.get(value.checked_mul(stride)?..)?.get(..size)?);
        }
        return Some(values);
    }
    for value in attribute.read_f32s(n_points, width) {
        scalar.push_bytes(&mut values, f64::from(if scalar.is_whole() { value.trunc() } else { value }));
    }
    Some(values)
}

fn component_type_of(kind: DataType) -> Option<u32> {
    match kind {
        DataType::Int8 => Some(5120),
        DataType::Uint8 => Some(5121),
        DataType::Int16 => Some(5122),
        DataType::Uint16 => Some(5123),
        DataType::Uint32 => Some(5125),
        DataType::Float32 => Some(5126),
        _ => None,
    }
}

fn face_indices(mesh: &Mesh, accessor: &Accessor) -> Option<Vec<u8>> {
    let mut indices = Vec::new();
    reserve(&mut indices, 3 * mesh.num_faces() * element_size("SCALAR", accessor.component_type)).ok()?;
    for PointIndex(point) in mesh.faces().iter().flatten() {
        match accessor.component_type {
            5121 => indices.push(u8::try_from(*point).ok()?),
            5123 => indices.extend(u16::try_from(*point).ok()?.to_le_bytes()),
            5125 => indices.extend(point.to_le_bytes()),
            _ => return None,
        }
    }
    Some(indices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Asset, Format, SimplifiedPart, read, read_attributed};
    use crate::mesh::Role;
    use crate::mesh::cleanup::{CleanOptions, clean};

    const TORUS: &[u8] = include_bytes!("../../../../../tests/meshes/tiny/torus_draco.glb");

    #[test]
    fn what_is_decoded_is_the_torus_that_was_compressed() {
        let read = read_attributed(TORUS, None).unwrap();
        let off = |&[x, y, z]: &[f64; 3]| ((x.hypot(y) - 1.0).hypot(z) - 0.4).abs();
        assert!(read.mesh.positions.iter().map(off).fold(0.0, f64::max) < 1e-3);
        let uvs = read.mesh.attributes.channel(Role::Uv).unwrap();
        let (low, high) = uvs.values.iter().fold((1f32, 0f32), |(low, high), &x| (low.min(x), high.max(x)));
        assert!(low.abs() < 1e-3 && (high - 1.0).abs() < 1e-3, "{low} {high}");
        assert_eq!(read.extra.groups[0].material.as_deref(), Some("ring"));
        let mesh = clean(read.mesh, &CleanOptions::default()).unwrap().mesh;
        assert_eq!((mesh.positions().len(), mesh.faces().len()), (288, 576));
    }

    #[test]
    fn attributes_outside_the_compression_are_those_of_their_accessors() {
        let length = u32::from_le_bytes(TORUS[12..16].try_into().unwrap()) as usize;
        let json = std::str::from_utf8(&TORUS[20..20 + length]).unwrap().trim_end();
        // One accessor has bytes, those of the compressed view, and one none, which means zeros.
        let json = json
            .replace(r#""TEXCOORD_0":3}"#, r#""TEXCOORD_0":3,"TEXCOORD_1":4,"COLOR_0":5}"#)
            .replace(r#""bufferViews":"#, r#""unused":"#)
            .replace(
                r#""accessors":["#,
                r#""bufferViews":[{"buffer":0,"byteLength":2312},{"buffer":0,"byteLength":650}],"accessors":["#,
            )
            .replace(
                r#""count":325}],"#,
                r#""count":325},{"type":"VEC2","componentType":5121,"normalized":true,"count":325,"bufferView":1},
                {"type":"VEC3","componentType":5126,"count":325}],"#,
            );
        let json = format!("{json:0$}", json.len().next_multiple_of(4));
        let [all, first] = [TORUS.len() - length + json.len(), json.len()].map(|n| (n as u32).to_le_bytes());
        let glb = [&TORUS[..8], &all, &first, b"JSON", json.as_bytes(), &TORUS[20 + length..]].concat();
        let mesh = read_attributed(&glb, None).unwrap().mesh;
        let values = |name: &str| &mesh.attributes.channels.iter().find(|it| it.name == name).unwrap().values;
        assert!(values("COLOR_0").iter().all(|&x| x == 0.0));
        let stored = &TORUS[20 + length + 8..][..650];
        assert!(
            values("TEXCOORD_1")
                .iter()
                .step_by(2)
                .zip(stored.iter().step_by(2))
                .all(|(x, b)| *x == f32::from(*b) / 255.0)
        );
        assert_eq!(mesh.faces.len(), 576);
    }

    #[test]
    fn an_asset_is_written_without_the_compression_and_says_so() {
        let asset = Asset::from_bytes(TORUS, &|_| unreachable!()).unwrap();
        assert_eq!(asset.notes(), ["geometry that Draco has compressed is written uncompressed"]);
        let parts: Vec<SimplifiedPart> = asset.parts().iter().map(SimplifiedPart::from_part).collect();
        let written = &asset.write(&parts, Format::Glb, "a.glb").unwrap()[0].bytes;
        assert!(!String::from_utf8_lossy(written).contains("draco"));
        assert_eq!(read(written, None).unwrap().faces.len(), 576);
    }

    #[test]
    fn damage_is_one_line_and_what_grows_too_large_is_refused() {
        let mut damaged = TORUS.to_vec();
        let from = damaged.windows(5).position(|word| word == b"DRACO").unwrap();
        damaged[from + 20..].fill(0xff);
        let error = read(&damaged, None).unwrap_err().to_string();
        assert!(error.contains("compressed by Draco cannot be decoded (") && !error.contains('\n'), "{error}");
        assert!(decode_mesh(&TORUS[from..], 1000).is_err());
        assert_eq!(decode_mesh(&TORUS[from..], 100_000).unwrap().num_faces(), 576);
    }
}
