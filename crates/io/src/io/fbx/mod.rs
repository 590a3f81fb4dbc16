//! FBX by the library ufbx: all meshes as one mesh, right-handed with y up.
//!
//! Skins, morph targets and animations are dropped.

mod corners;

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};
use ufbx::{
    Allocator, AllocatorOpts, CoordinateAxes, ErrorType, FileFormat, LoadOpts, Material, Matrix, MirrorAxis, Node,
    Scene, SceneRoot,
};

use super::far_from_origin::is_far_from_origin;
use super::memory::instance_limit;
use super::one_line::one_line;
use super::unique_materials::UniqueMaterials;
use super::units;
use super::{Extra, Group, ReadError, ReadMesh};
use crate::mesh::{Look, PlacedMesh, merge_placed_meshes};
use corners::{FbxMesh, convert_mesh};

/// Largest memory in bytes: the first times the file's bytes, or the second if more.
const MEMORY: (usize, usize) = (200, 64 << 20);

/// Reads the meshes of a scene with attributes; nodes and materials become groups.
pub(super) fn read(bytes: &[u8]) -> Result<ReadMesh, ReadError> {
    let scene = load(bytes)?;
    let nodes: Vec<&Node> = scene.nodes.iter().map(|node| &**node).filter(|node| node.mesh.is_some()).collect();
    // A mesh of several nodes is converted once.
    let (mut parts, mut numbers) = (Vec::new(), BTreeMap::new());
    for node in &nodes {
        let Some(mesh) = &node.mesh else { continue };
        numbers.entry(mesh.element.element_id).or_insert_with(|| {
            parts.push(convert_mesh(mesh));
            parts.len() - 1
        });
    }
    let of_node = |node: &&Node| numbers.get(&node.mesh.as_ref()?.element.element_id).copied();
    let of_nodes: Vec<usize> = nodes.iter().filter_map(of_node).collect();
    // The check precedes the join: instances are cheap in the file and expensive as one mesh.
    check_repeats(&parts, &of_nodes)?;
    // Each node adds groups for its mesh, one per material of the mesh.
    let mut names = UniqueMaterials::default();
    let (mut extra, mut placed) =
        (Extra { unit: units::from_meters(scene.settings.unit_meters), ..Extra::default() }, Vec::new());
    for (node, &number) in nodes.iter().zip(&of_nodes) {
        let FbxMesh { mesh, slots, .. } = &parts[number];
        placed.push(PlacedMesh {
            mesh,
            transform: to_matrix(&node.geometry_to_world),
            first_group: extra.groups.len() as u32,
        });
        extra.groups.extend(slots.iter().map(|&slot| make_group(node, slot, &mut names)));
    }
    let mut mesh = merge_placed_meshes(&placed, |_| true);
    // FBX always stores doubles, so the values decide whether doubles are needed.
    let has_doubles = |part: &FbxMesh| part.mesh.positions.iter().flatten().any(|&x| f64::from(x as f32) != x);
    mesh.double = parts.iter().any(has_doubles) || is_far_from_origin(&mesh.positions);
    extra.looks = names.looks;
    extra.is_bent = scene.skin_deformers.len() + scene.blend_deformers.len() > 0;
    let n_not_finite = parts.iter().map(|part| part.n_not_finite).sum();
    Ok(ReadMesh { mesh, notes: list_losses(&scene, n_not_finite), extra, format: None })
}

fn load(bytes: &[u8]) -> Result<SceneRoot, ReadError> {
    let most = MEMORY.1.max(bytes.len().saturating_mul(MEMORY.0));
    // Both allocators are limited: temporary data may exceed the result.
    let within = || AllocatorOpts { allocator: Allocator::Libc, memory_limit: most, ..AllocatorOpts::default() };
    let options = LoadOpts {
        temp_allocator: within(),
        result_allocator: within(),
        file_format: FileFormat::Fbx,
        ignore_embedded: true,
        skip_skin_vertices: true,
        target_axes: CoordinateAxes::right_handed_y_up(),
        handedness_conversion_axis: MirrorAxis::X,
        ..LoadOpts::default()
    };
    ufbx::load_memory(bytes, options).map_err(|error| match error.type_ {
        ErrorType::MemoryLimit | ErrorType::AllocationLimit => ReadError::file(
            format!("the scene takes more than {most} bytes of memory"),
            "export the file again, or as GLB",
        ),
        _ => {
            let what = one_line(&error.description).to_lowercase();
            ReadError::file(format!("no valid FBX ({what})"), "export the file again, as FBX 7.4 or GLB")
        }
    })
}

/// Rejects a scene whose instances together exceed [`instance_limit`].
fn check_repeats(parts: &[FbxMesh], of_nodes: &[usize]) -> Result<(), ReadError> {
    let size = |part: &FbxMesh| {
        let attributes = &part.mesh.attributes;
        let width: usize = attributes.channels.iter().map(|channel| channel.width).sum();
        1 + part.mesh.positions.len() + part.mesh.faces.len() + attributes.n_wedges() * width + part.slots.len()
    };
    let sizes: Vec<usize> = parts.iter().map(size).collect();
    let most = instance_limit(sizes.iter().sum());
    match of_nodes.iter().map(|&number| sizes[number]).sum::<usize>() > most {
        true => Err(ReadError::file("the scene repeats its meshes too often", "export fewer instances")),
        false => Ok(()),
    }
}

fn make_group(node: &Node, slot: u32, names: &mut UniqueMaterials) -> Group {
    // Unnamed nodes give no group name.
    let object = Some(node.element.name.to_string()).filter(|name| !name.trim().is_empty());
    let of_mesh = || node.mesh.as_ref().and_then(|mesh| mesh.materials.get(slot as usize));
    let material = node.materials.get(slot as usize).or_else(of_mesh);
    let material = material.map(|material| names.add(&material.element.name, material_look(material)));
    Group { object, material, ..Group::default() }
}

fn material_look(material: &Material) -> Look {
    let colour = &material.pbr.base_color;
    // FBX stores a factor by which the colour is multiplied.
    let factor = if material.pbr.base_factor.has_value { material.pbr.base_factor.value_vec4.x } else { 1.0 };
    let channels = [colour.value_vec4.x, colour.value_vec4.y, colour.value_vec4.z].map(|x| (x * factor) as f32);
    let is_colour = colour.has_value && channels.iter().all(|x| x.is_finite());
    let colour = if is_colour { channels.map(|x| x.clamp(0.0, 1.0)) } else { [1.0; 3] };
    Look { colour, ..Look::default() }
}

fn to_matrix(of: &Matrix) -> DMat4 {
    let [x, y, z, origin] = [
        DVec3::new(of.m00, of.m10, of.m20),
        DVec3::new(of.m01, of.m11, of.m21),
        DVec3::new(of.m02, of.m12, of.m22),
        DVec3::new(of.m03, of.m13, of.m23),
    ];
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), origin.extend(1.0))
}

fn list_losses(scene: &Scene, n_not_finite: usize) -> Vec<String> {
    let dropped = [
        (scene.skin_deformers.len(), "skins"),
        (scene.blend_deformers.len(), "morph targets"),
        (scene.anim_curves.len(), "animations"),
        (scene.textures.len(), "textures"),
        (scene.nurbs_surfaces.len() + scene.nurbs_curves.len() + scene.line_curves.len(), "curves and their surfaces"),
    ];
    let dropped: Vec<&str> = dropped.iter().filter(|(n, _)| *n > 0).map(|(_, what)| *what).collect();
    let dropped = (!dropped.is_empty()).then(|| format!("dropped from the fbx: {}", dropped.join(", ")));
    let mended = (n_not_finite > 0).then(|| {
        format!("{n_not_finite} numbers of texture coordinates, normals or colours are not finite: they become 0")
    });
    dropped.into_iter().chain(mended).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Role;

    fn text(of_node: &str, axes: &str) -> String {
        let layers = ["Normal", "UV", "Color", "Material"].map(|kind| {
            let entry = format!("Type: \"LayerElement{kind}\"\n TypedIndex: 0");
            format!("LayerElement:  {{\n {entry}\n }}\n")
        });
        let layers = layers.concat();
        format!(
            r#"; FBX 7.4.0 project file
FBXHeaderExtension:  {{
    FBXVersion: 7400
}}
GlobalSettings:  {{
    Version: 1000
    Properties70:  {{
        {axes}
        P: "UnitScaleFactor", "double", "Number", "",2.54
    }}
}}
Objects:  {{
    Geometry: 1, "Geometry::sheet", "Mesh" {{
        Vertices: *15 {{
            a: 0,0,0,1,0,0,1,1,0,0,1,0,2,0,0
        }}
        PolygonVertexIndex: *7 {{
            a: 0,1,2,-4,1,4,-3
        }}
        LayerElementNormal: 0 {{
            MappingInformationType: "AllSame"
            ReferenceInformationType: "Direct"
            Normals: *3 {{
                a: 0,0,1
            }}
        }}
        LayerElementUV: 0 {{
            Name: "map"
            MappingInformationType: "ByPolygonVertex"
            ReferenceInformationType: "IndexToDirect"
            UV: *6 {{
                a: 0,0,0.5,0,0.5,0.25
            }}
            UVIndex: *7 {{
                a: 0,1,2,2,0,1,2
            }}
        }}
        LayerElementColor: 0 {{
            MappingInformationType: "ByVertice"
            ReferenceInformationType: "Direct"
            Colors: *20 {{
                a: 1,0,0,1,0,1,0,1,0,0,1,1,1,1,1,1,0,0,0,1
            }}
        }}
        LayerElementMaterial: 0 {{
            MappingInformationType: "ByPolygon"
            ReferenceInformationType: "IndexToDirect"
            Materials: *2 {{
                a: 1,0
            }}
        }}
        Layer: 0 {{
            {layers}
        }}
    }}
    Model: 2, "Model::seat", "Mesh" {{
        Properties70:  {{
            {of_node}
        }}
    }}
    Model: 5, "Model::seat again", "Mesh" {{
    }}
    Material: 3, "Material::wood", "" {{
        ShadingModel: "lambert"
        Properties70:  {{
            P: "DiffuseColor", "Color", "", "A",0.5,0.25,0
        }}
    }}
    Material: 4, "Material::wood", "" {{
        ShadingModel: "lambert"
    }}
}}
Connections:  {{
    C: "OO",2,0
    C: "OO",5,0
    C: "OO",1,2
    C: "OO",1,5
    C: "OO",3,2
    C: "OO",4,2
    C: "OO",3,5
    C: "OO",4,5
}}
"#
        )
    }

    #[test]
    fn meshes_stand_where_nodes_place_them_with_all_that_they_carry() {
        let moved = r#"P: "Lcl Translation", "Lcl Translation", "", "A",10,0,0"#;
        let read = crate::io::read_attributed(text(moved, "").as_bytes(), None).unwrap();
        let mesh = &read.mesh;
        assert_eq!((mesh.positions.len(), mesh.faces.len(), mesh.double), (10, 6, false));
        assert_eq!((mesh.positions[1], mesh.positions[6]), ([11.0, 0.0, 0.0], [1.0, 0.0, 0.0]));
        assert_eq!(mesh.faces[2], [1, 4, 2]);
        let value = |role, face: usize, corner: usize| {
            let channel = mesh.attributes.channel(role).unwrap();
            channel.value(mesh.attributes.wedges[face][corner]).to_vec()
        };
        assert_eq!((value(Role::Normal, 5, 0), value(Role::Uv, 2, 1)), (vec![0.0, 0.0, 1.0], vec![0.5, 0.0]));
        assert_eq!((value(Role::Uv, 2, 0), value(Role::Colour, 2, 0)), (vec![0.0, 0.0], vec![0.0, 1.0, 0.0]));
        assert_eq!(mesh.attributes.groups, [0, 0, 1, 2, 2, 3]);
        let names = |group: &Group| (group.object.clone().unwrap(), group.material.clone().unwrap());
        let names: Vec<_> = read.extra.groups.iter().map(names).collect();
        let expected = [("seat", "wood"), ("seat", "wood 2"), ("seat again", "wood"), ("seat again", "wood 2")];
        assert!(names.iter().zip(expected).all(|((a, b), expected)| (a.as_str(), b.as_str()) == expected), "{names:?}");
        let colour = |name: &str| read.extra.looks.iter().find(|(known, _)| known == name).unwrap().1.colour;
        assert_eq!(colour("wood 2"), [0.5, 0.25, 0.0]);
        assert_eq!((read.extra.unit.as_deref(), read.notes.len()), (Some("inch"), 0));
    }

    #[test]
    fn axes_are_turned_so_that_y_is_up() {
        let axes = r#"P: "UpAxis", "int", "Integer", "",2
        P: "UpAxisSign", "int", "Integer", "",1
        P: "FrontAxis", "int", "Integer", "",1
        P: "FrontAxisSign", "int", "Integer", "",-1
        P: "CoordAxis", "int", "Integer", "",0
        P: "CoordAxisSign", "int", "Integer", "",1"#;
        let mesh = read(text("", axes).as_bytes()).unwrap().mesh;
        let near = |a: [f64; 3], b: [f64; 3]| (DVec3::from(a) - DVec3::from(b)).length() < 1e-9;
        assert!(near(mesh.positions[2], [1.0, 0.0, -1.0]), "{:?}", mesh.positions);
    }

    #[test]
    fn what_is_cut_or_no_fbx_is_refused_in_one_line() {
        let whole = text("", "");
        let binary = [&b"Kaydara FBX Binary  \0\x1a\0"[..], &7400u32.to_le_bytes(), &[255; 40]].concat();
        for bytes in [&whole.as_bytes()[..300], b"", b"v 0 0 0\nf 1 1 1\n", &binary] {
            if let Err(error) = read(bytes) {
                assert!(error.what.starts_with("no valid FBX (") && !error.to_string().contains('\n'), "{error}");
            }
        }
        assert!(read(&binary).is_err() && read(b"").is_err());
    }
}
