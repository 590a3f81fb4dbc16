//! 3MF, with parts of the production and materials extensions.

mod document;
mod faces;
mod package;
mod required;
mod write;
mod xml_attribute;

use std::collections::{BTreeMap, BTreeSet};

use glam::DMat4;

pub(super) use write::write;

use super::extra::has_too_many_groups;
use super::far_from_origin::is_far_from_origin;
use super::memory::instance_limit;
use super::units;
use super::{Extra, ReadError, ReadMesh, shorten_name};
use crate::mesh::{PlacedMesh, merge_placed_meshes};
use document::{ModelDocument, REMEDY, Reference, parse};
use faces::{IgnoredContent, ObjectMeshes};
use package::Package;

const DEPTH: usize = 64;

/// Reads the build of a package; objects and materials become groups.
pub(super) fn read(bytes: &[u8]) -> Result<ReadMesh, ReadError> {
    let mut models = Models::open(bytes)?;
    let root = models.root.clone();
    // Only objects that the build lists are printed, so others are not read.
    let items = models.build_items(&root)?;
    for item in &items {
        models.place(&root, item, DMat4::IDENTITY, 0)?;
    }
    // An object that is placed several times is converted once.
    let mut parts = ObjectMeshes::default();
    // Objects get names only where there are several.
    let n_meshes = models.placed.iter().map(|(place, _)| place).collect::<BTreeSet<_>>().len();
    let mut known: BTreeMap<&ObjectId, usize> = BTreeMap::new();
    let mut transforms = Vec::new();
    for (place, transform) in &models.placed {
        let Some(ModelDocument { objects, properties, .. }) = models.documents.get_mut(&place.0) else { continue };
        let Some(object) = objects.get_mut(&place.1) else { continue };
        let part = *known.entry(place).or_insert_with(|| parts.add(object, properties, n_meshes > 1));
        transforms.push((part, *transform));
    }
    models.scene(parts, &transforms)
}

type ObjectId = (String, u32);

struct Models<'a> {
    package: Package<'a>,
    root: String,
    documents: BTreeMap<String, ModelDocument>,
    placed: Vec<(ObjectId, DMat4)>,
    n_made: usize,
    notes: Vec<String>,
}

impl<'a> Models<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let mut package = Package::open(bytes)?;
        let root = package.model_part()?.trim_start_matches('/').to_string();
        let (documents, placed, notes) = Default::default();
        Ok(Self { package, root, documents, placed, n_made: 0, notes })
    }

    fn document(&mut self, part: &str) -> Result<&mut ModelDocument, ReadError> {
        // Parts are parsed when first needed, as components may be spread over many.
        if !self.documents.contains_key(part) {
            let document = parse(&self.package.text(part)?, part)?;
            self.documents.insert(part.into(), document);
        }
        let gone = || ReadError::file(format!("there is no part {:?}", shorten_name(part)), REMEDY);
        self.documents.get_mut(part).ok_or_else(gone)
    }

    fn build_items(&mut self, root: &str) -> Result<Vec<Reference>, ReadError> {
        let document = self.document(root)?;
        let items = std::mem::take(&mut document.items);
        if !items.is_empty() {
            return Ok(items);
        }
        // Numbers are sorted, as a hash map has no fixed order.
        let mut ids: Vec<u32> = document.objects.values().filter(|it| !it.faces.is_empty()).map(|it| it.id).collect();
        ids.sort_unstable();
        if !ids.is_empty() {
            self.notes.push("the 3mf has no build items: all its objects are read".into());
        }
        Ok(ids.into_iter().map(|object| Reference { path: None, object, transform: DMat4::IDENTITY }).collect())
    }

    /// Places the meshes of the object that `named` refers to; `above` is the parent's transform.
    fn place(&mut self, part: &str, named: &Reference, above: DMat4, depth: usize) -> Result<(), ReadError> {
        // A path is only needed for objects of other parts.
        let path = named.path.as_deref().map_or(part, |path| path.trim_start_matches('/')).to_string();
        let transform = above * named.transform;
        // The budget alone would not stop a deep chain before the stack ends.
        if depth > DEPTH {
            return Err(ReadError::file(format!("components nest more than {DEPTH} deep"), REMEDY));
        }
        let missing = || {
            let what = format!("there is no object {} in {:?}", named.object, shorten_name(&path));
            ReadError::file(what, REMEDY)
        };
        let object = self.document(&path)?.objects.get_mut(&named.object).ok_or_else(missing)?;
        let n_made = 1 + object.positions.len() + object.faces.len();
        let has_faces = !object.faces.is_empty();
        let is_circle = std::mem::replace(&mut object.is_open, true);
        if is_circle {
            let what = format!("object {} contains itself as a component", named.object);
            return Err(ReadError::file(what, REMEDY));
        }
        let components = std::mem::take(&mut object.components);
        // The budget is charged before anything is placed: nested components can double the number of objects at each
        // level.
        self.spend(n_made)?;
        if has_faces {
            self.placed.push(((path.clone(), named.object), transform));
        }
        for component in &components {
            self.place(&path, component, transform, depth + 1)?;
        }
        if let Some(object) = self.document(&path)?.objects.get_mut(&named.object) {
            (object.components, object.is_open) = (components, false);
        }
        Ok(())
    }

    fn spend(&mut self, n: usize) -> Result<(), ReadError> {
        let too_many = || ReadError::file("the build repeats its objects too often", "export fewer copies");
        self.n_made = self.n_made.saturating_add(n);
        if self.n_made > instance_limit(self.package.n_unpacked()) { Err(too_many()) } else { Ok(()) }
    }

    fn scene(mut self, parts: ObjectMeshes, transforms: &[(usize, DMat4)]) -> Result<ReadMesh, ReadError> {
        // Colours are repeated with their meshes, so they count too.
        let width = parts.colour_width();
        for &(part, _) in transforms {
            self.spend(parts.meshes[part].attributes.n_wedges() * width)?;
        }
        let placed: Vec<PlacedMesh> = transforms
            .iter()
            .map(|&(part, transform)| PlacedMesh {
                mesh: &parts.meshes[part],
                transform,
                first_group: parts.first_groups[part],
            })
            .collect();
        let mut mesh = merge_placed_meshes(&placed, |_| true);
        mesh.double = self.documents.values().any(|document| document.double) || is_far_from_origin(&mesh.positions);
        let mut extra = Extra { unit: self.unit(), ..Extra::default() };
        // A single unnamed group tells nothing about its faces.
        let is_bare = parts.groups.len() <= 1 && parts.groups.iter().all(|group| group.title().is_empty());
        if is_bare || parts.groups.len() == 1 {
            mesh.attributes.groups.clear();
        // The limit compares groups with all faces, so it is checked after joining.
        } else if has_too_many_groups(parts.groups.len(), mesh.faces.len()) {
            mesh.attributes.groups.clear();
            self.notes.push(format!(
                "the materials are dropped: {} for {} faces are too many to form groups",
                parts.groups.len(),
                mesh.faces.len()
            ));
        }
        if !is_bare && (parts.groups.len() == 1 || !mesh.attributes.groups.is_empty()) {
            (extra.groups, extra.looks) = (parts.groups, parts.materials.looks);
        }
        let has_beams = self.documents.values().any(|document| document.has_beams);
        self.notes.extend(IgnoredContent { has_beams, ..parts.notes }.lines());
        Ok(ReadMesh { mesh, extra, notes: self.notes, format: None })
    }

    fn unit(&mut self) -> Option<String> {
        let unit = self.documents.get(&self.root)?.unit.clone()?;
        // Writers need a unit that 3MF knows.
        let is_known = units::is_known(&unit);
        if !is_known {
            self.notes.push(format!("the unit {:?} is none of 3mf: it is dropped", shorten_name(&unit)));
        }
        is_known.then_some(unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Format, Model, WriteOptions, write_attributed};
    use crate::mesh::cleanup::{CleanOptions, clean};
    use crate::mesh::{Attributes, shapes};

    const RELATIONS: &str = r#"<Relationships><Relationship Target="/3D/m.model" Id="a"
        Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;

    fn package(parts: &[(&str, &str)]) -> Vec<u8> {
        let parts = [&[("_rels/.rels", RELATIONS)], parts].concat();
        let parts: Vec<(&str, &[u8])> = parts.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
        write::package(&parts).unwrap()
    }

    fn tetrahedron(of_first: &str) -> String {
        let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"].map(|corner| {
            let [x, y, z] = corner.split(' ').collect::<Vec<_>>().try_into().unwrap();
            format!(r#"<vertex x="{x}" y="{y}" z="{z}"/>"#)
        });
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|[a, b, c]| (a, b, c));
        let more = [of_first, "", "", ""];
        let faces =
            faces.iter().zip(more).map(|((a, b, c), more)| format!(r#"<triangle v1="{a}" v2="{b}" v3="{c}" {more}/>"#));
        format!(
            "<mesh><vertices>{}</vertices><triangles>{}</triangles></mesh>",
            corners.concat(),
            faces.collect::<String>()
        )
    }

    fn model(resources: &str, build: &str) -> String {
        format!(
            r#"<?xml version="1.0"?><model unit="inch" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
            xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06" requiredextensions="p">
            <resources>{resources}</resources><build>{build}</build></model>"#
        )
    }

    fn read_model(resources: &str, build: &str) -> Result<ReadMesh, ReadError> {
        read(&package(&[("3D/m.model", &model(resources, build))]))
    }

    #[test]
    fn items_and_components_stand_where_they_are_placed_also_from_other_parts() {
        let other = model(&format!(r#"<object id="7" name="tip &amp; tail">{}</object>"#, tetrahedron("")), "");
        let root = model(
            r#"<object id="1"><components><component p:path="/3D/other.model" objectid="7" transform="0 2 0 -2 0 0 0 0 2 1 0 0"/>
            <component p:path="/3d/OTHER.model" objectid="7" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/></components></object>"#,
            r#"<item objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 10"/>"#,
        );
        let parts = [("3D/m.model", root.as_str()), ("3D/other.model", other.as_str())];
        let read = read(&package(&parts)).unwrap();
        assert_eq!(read.mesh.positions[..4], [[1.0, 0.0, 10.0], [1.0, 2.0, 10.0], [-1.0, 0.0, 10.0], [1.0, 0.0, 12.0]]);
        // Mirrored, it is turned round.
        assert_eq!((read.mesh.positions[5], read.mesh.faces[4]), ([-1.0, 0.0, 10.0], [4, 5, 6]));
        assert_eq!(
            (read.extra.unit.as_deref(), read.extra.groups[0].object.as_deref()),
            (Some("inch"), Some("tip & tail"))
        );
        assert_eq!(clean(read.mesh, &CleanOptions::default()).unwrap().mesh.faces().len(), 8);
    }

    #[test]
    fn materials_become_groups_and_colours_stand_at_corners() {
        let resources = r##"<basematerials id="1"><base name="red" displaycolor="#FF0000"/><base name="blue" displaycolor="#0000FF80"/></basematerials>
            <m:colorgroup id="2"><m:color color="#00FF00FF"/><m:color color="#000000FF"/></m:colorgroup>"##;
        let object =
            |of_first| format!(r#"{resources}<object id="3" pid="1" pindex="0">{}</object>"#, tetrahedron(of_first));
        let read = read_model(&object(r#"pid="1" p1="1""#), r#"<item objectid="3"/>"#).unwrap();
        let names: Vec<_> = read.extra.groups.iter().filter_map(|group| group.material.as_deref()).collect();
        assert_eq!(
            (names.as_slice(), read.mesh.attributes.groups.as_slice()),
            (&["blue", "red"][..], &[0, 1, 1, 1][..])
        );
        assert!(!read.extra.looks[0].1.finish.is_opaque && read.extra.looks[1].1.colour == [1.0, 0.0, 0.0]);
        let read = read_model(&object(r#"pid="2" p1="0" p2="1" p3="1""#), r#"<item objectid="3"/>"#).unwrap();
        let attributes = &read.mesh.attributes;
        let colours = attributes.wedges[0].map(|wedge| attributes.channels[0].value(wedge).to_vec());
        assert_eq!(colours, [vec![0.0, 1.0, 0.0], vec![0.0; 3], vec![0.0; 3]]);
        assert_eq!(attributes.channels[0].value(attributes.wedges[1][0]), [1.0; 3]);
    }

    #[test]
    fn objects_of_equal_name_stay_two() {
        let object = |id: u32| format!(r#"<object id="{id}" name="Object">{}</object>"#, tetrahedron(""));
        let build = r#"<item objectid="3"/><item objectid="4" transform="1 0 0 0 1 0 0 0 1 5 0 0"/>"#;
        let read = read_model(&(object(3) + &object(4)), build).unwrap();
        let names = |read: &ReadMesh| read.extra.groups.iter().map(|it| it.object.clone().unwrap()).collect::<Vec<_>>();
        assert_eq!(names(&read), ["Object", "Object 2"]);
        assert_eq!(names(&crate::io::read_attributed(&write_again(read), None).unwrap()), ["Object", "Object 2"]);
    }

    fn write_again(read: ReadMesh) -> Vec<u8> {
        let cleaned = clean(read.mesh, &CleanOptions::default()).unwrap();
        let (mesh, attributes) = (&cleaned.mesh, &cleaned.attributes);
        let model = Model { mesh, frame: cleaned.frame, exact: None, attributes, extra: &read.extra };
        let options = WriteOptions::new(Format::ThreeMf, "a");
        write_attributed(&model, &options).unwrap().bytes
    }

    #[test]
    fn what_is_written_is_read_as_it_was() {
        let resources = format!(
            r##"<basematerials id="9"><base name="a &lt; b" displaycolor="#FF0000"/><base name="c" displaycolor="#00FF00"/></basematerials>
            <m:colorgroup id="8"><m:color color="#804020FF"/><m:color color="#000000FF"/></m:colorgroup>
            <object id="3" name="one">{}</object><object id="4" name="two" pid="9" pindex="1">{}</object>"##,
            tetrahedron(r#"pid="8" p1="0" p2="1" p3="1""#),
            tetrahedron(r#"pid="9" p1="0""#),
        );
        let build = r#"<item objectid="3"/><item objectid="4" transform="1 0 0 0 1 0 0 0 1 5 0.1 0"/>"#;
        let first = read_model(&resources, build).unwrap();
        let bytes = write_again(first.clone());
        let second = crate::io::read_attributed(&bytes, None).unwrap();
        assert_eq!((second.format, second.extra.unit.as_deref()), (Some(Format::ThreeMf), Some("inch")));
        let objects: Vec<_> = second
            .extra
            .groups
            .iter()
            .map(|group| (group.object.as_deref().unwrap(), group.material.as_deref()))
            .collect();
        assert_eq!(objects, [("one", None), ("two", Some("a < b")), ("two", Some("c"))]);
        assert_eq!(second.mesh.positions.len(), 8);
        assert_eq!(second.mesh.positions[5], [6.0, 0.1, 0.0]);
        let corner = |read: &ReadMesh| {
            let attributes = &read.mesh.attributes;
            attributes.wedges[0].map(|wedge| attributes.channels[0].value(wedge).to_vec())
        };
        assert_eq!(corner(&first), corner(&second));
        assert_eq!(bytes, write_again(second));
    }

    #[test]
    fn positions_come_back_bit_for_bit_and_objects_that_share_vertices_stay_one() {
        let mesh = shapes::wavy_sphere(3, 1.0);
        let bytes = crate::io::write(&mesh, &crate::mesh::Frame::default(), Format::ThreeMf).unwrap();
        let back = crate::io::read(&bytes, None).unwrap();
        let singles: Vec<[f32; 3]> = back.positions.iter().map(|p| p.map(|x| x as f32)).collect();
        assert!(singles == mesh.positions() && back.faces == mesh.faces() && !back.double);
        let object = |name: &str| crate::io::Group { object: Some(name.into()), ..Default::default() };
        let extra = Extra { groups: vec![object("a"), object("b")], ..Extra::default() };
        let groups = (0..mesh.faces().len() as u32).map(|face| face % 2).collect();
        let attributes = Attributes { groups, ..Attributes::default() };
        let model =
            Model { mesh: &mesh, frame: Default::default(), exact: None, attributes: &attributes, extra: &extra };
        let options = WriteOptions::new(Format::ThreeMf, "a");
        let written = write_attributed(&model, &options).unwrap();
        assert_eq!(written.notes, ["2 objects share vertices: written as one"]);
        assert_eq!(crate::io::read(&written.bytes, None).unwrap(), back);
    }

    #[test]
    fn flawed_packages_are_refused_in_one_line() {
        let item = r#"<item objectid="3"/>"#;
        let whole = format!(r#"<object id="3">{}</object>"#, tetrahedron(""));
        let cases = [
            (whole.replace("x=\"1\"", "x=\"1mm\""), item, "a vertex needs numbers x, y and z"),
            (whole.replace("v3=\"1\"", ""), item, "a triangle needs indices"),
            (whole.clone(), r#"<item objectid="4"/>"#, "there is no object 4"),
            (whole.clone(), r#"<item objectid="3" transform="1 0 0"/>"#, "a transform needs twelve numbers"),
            (whole.clone(), r#"<item objectid="3" p:path="/a.model"/>"#, "there is no part \"a.model\""),
            (whole.replace("</mesh>", ""), item, "no valid XML"),
            (format!("{whole}{whole}"), item, "object 3 is defined twice"),
        ];
        for (resources, build, expected) in cases {
            let error = read_model(&resources, build).unwrap_err().to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
        let sliced = model(&whole, item).replace("3dmanufacturing/production", "3dmanufacturing/slice");
        let error = read(&package(&[("3D/m.model", &sliced)])).unwrap_err().to_string();
        assert!(
            error.contains("needs the extension \"http://schemas.microsoft.com/3dmanufacturing/slice/2015/06\""),
            "{error}"
        );
        assert!(read(&package(&[])).unwrap_err().what.contains("contains no 3D model"));
    }

    #[test]
    fn bombs_and_circles_do_not_fill_the_memory() {
        let blanks = " ".repeat(20 << 20);
        let bomb = package(&[("3D/m.model", &model(&blanks, ""))]);
        let error = read(&bomb).unwrap_err();
        assert!(error.what.contains("unpacks to more than"), "{error}");
        let mut resources = format!(r#"<object id="0">{}</object>"#, tetrahedron(""));
        for id in 1..40 {
            let component = format!(r#"<component objectid="{}"/>"#, id - 1);
            resources += &format!(r#"<object id="{id}"><components>{}</components></object>"#, component.repeat(2));
        }
        let error = read_model(&resources, r#"<item objectid="39"/>"#).unwrap_err();
        assert!(error.what.contains("repeats its objects too often"), "{error}");
        let circle = r#"<object id="1"><components><component objectid="1"/></components></object>"#;
        let error = read_model(circle, r#"<item objectid="1"/>"#).unwrap_err();
        assert!(error.what.contains("object 1 contains itself"), "{error}");
    }
}
