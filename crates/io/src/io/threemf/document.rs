//! Model part of a 3MF.

use std::borrow::Cow;

use glam::{DMat4, DVec3};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use rustc_hash::FxHashMap;

use super::required::refuse_unknown;
use super::xml_attribute::attribute;
use crate::io::corner_wedges::NOWHERE;
use crate::io::memory::reserve;
use crate::io::one_line::one_line;
use crate::io::{ReadError, number, shorten_name};

pub(super) const REMEDY: &str = "export the file again";

#[derive(Default)]
pub(super) struct ModelDocument {
    pub unit: Option<String>,
    pub objects: FxHashMap<u32, Object>,
    pub properties: FxHashMap<u32, FaceProperty>,
    pub items: Vec<Reference>,
    pub double: bool,
    pub has_beams: bool,
    is_whole: bool,
}

#[derive(Default)]
pub(super) struct Object {
    pub id: u32,
    pub name: Option<String>,
    // Property for faces without their own: its identifier, and the index of an entry in its list.
    pub property: Option<(u32, u32)>,
    pub positions: Vec<[f64; 3]>,
    pub faces: Vec<[u32; 3]>,
    // Identifier of each face's property and the entry's index at each corner; shorter if the last faces have none.
    pub of_faces: Vec<Option<(u32, [u32; 3])>>,
    pub components: Vec<Reference>,
    // True while the object is being placed.
    pub is_open: bool,
}

pub(super) struct Reference {
    // Part of the package that has the object, if it is another part.
    pub path: Option<String>,
    pub object: u32,
    pub transform: DMat4,
}

pub(super) enum FaceProperty {
    Materials(Vec<(String, [f32; 4])>),
    Colours(Vec<[f32; 4]>),
    // Textures and mixtures, which are not read.
    Other,
}

pub(super) fn parse(text: &str, part: &str) -> Result<ModelDocument, ReadError> {
    let mut reader = Reader::from_str(text);
    let mut parser = Parser::default();
    loop {
        let at = reader.buffer_position() as usize;
        let fail =
            |error: String| ReadError::line(text.as_bytes(), at, format!("{part}: {}", one_line(&error)), REMEDY);
        match reader.read_event().map_err(|error| fail(format!("no valid XML ({error})")))? {
            Event::Start(element) | Event::Empty(element) => {
                // Errors of elements get a line here; other remedies already say what to do.
                parser.open(&element).map_err(|error| match error.what.as_str() {
                    _ if error.remedy != REMEDY => error,
                    what => fail(what.into()),
                })?
            }
            Event::End(element) => parser.document.is_whole |= element.local_name().into_inner() == "model",
            Event::Eof if parser.document.is_whole => return Ok(parser.document),
            Event::Eof => return Err(fail("the model ends before it is complete".into())),
            _ => {}
        }
    }
}

#[derive(Default)]
struct Parser {
    document: ModelDocument,
    prefix: Option<String>,
    object: u32,
    property: u32,
}

impl Parser {
    fn open(&mut self, element: &BytesStart) -> Result<(), ReadError> {
        // Names are compared without prefixes, which differ between writers.
        let (name, prefix) = element.name().decompose();
        let (name, prefix) = (name.into_inner(), prefix.map(|prefix| prefix.into_inner()).unwrap_or_default());
        // Extensions are checked at once, before triangles that need one are read.
        if name == "model" && self.prefix.is_none() {
            self.prefix = Some(prefix.into());
            self.document.unit = attribute(element, "unit").map(Cow::into_owned);
            return refuse_unknown(element);
        }
        // Elements of unknown extensions share names with core elements, so the prefix decides.
        match (self.prefix.as_deref() == Some(prefix), name) {
            (true, "vertex") => self.vertex(element),
            (true, "triangle") => self.triangle(element),
            (true, "object") => self.object(element),
            (true, "component") => {
                let component = parse_reference(element)?;
                self.document.objects.entry(self.object).or_default().components.push(component);
                Ok(())
            }
            (true, "item") => {
                self.document.items.push(parse_reference(element)?);
                Ok(())
            }
            (true, "basematerials") => self.property(element, FaceProperty::Materials(Vec::new())),
            (true, "base") => self.material(element),
            (_, "colorgroup") => self.property(element, FaceProperty::Colours(Vec::new())),
            (_, "color") => self.colour(element),
            (_, "texture2dgroup" | "compositematerials" | "multiproperties") => {
                self.property(element, FaceProperty::Other)
            }
            (_, "beamlattice") => {
                self.document.has_beams = true;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn object(&mut self, element: &BytesStart) -> Result<(), ReadError> {
        let id = parse_index(element, "id")?.ok_or_else(|| element_error("an object without id"))?;
        // Both attributes are needed: a property without an index means nothing.
        let property = parse_index(element, "pid")?.zip(parse_index(element, "pindex")?);
        let name = attribute(element, "name").map(Cow::into_owned).filter(|name| !name.trim().is_empty());
        self.object = id;
        let before = self.document.objects.insert(id, Object { id, name, property, ..Object::default() });
        if before.is_some() { Err(element_error(&format!("object {id} is defined twice"))) } else { Ok(()) }
    }

    fn vertex(&mut self, element: &BytesStart) -> Result<(), ReadError> {
        let mut position = [None; 3];
        // This runs for every vertex, so it makes one pass over the attributes.
        for attribute in element.attributes().with_checks(false).flatten() {
            let axis = match attribute.key.into_inner() {
                "x" => 0,
                "y" => 1,
                "z" => 2,
                _ => continue,
            };
            let number = parse_number(&attribute.value).filter(|number| number.value.is_finite());
            self.document.double |= number.is_some_and(|number| number.double);
            position[axis] = number.map(|number| number.value);
        }
        // A missing coordinate is an error: zero would distort the mesh unnoticed.
        let [Some(x), Some(y), Some(z)] = position else {
            return Err(element_error("a vertex needs numbers x, y and z"));
        };
        let positions = &mut self.document.objects.entry(self.object).or_default().positions;
        reserve(positions, 1)?;
        positions.push([x, y, z]);
        Ok(())
    }

    fn triangle(&mut self, element: &BytesStart) -> Result<(), ReadError> {
        let (mut corners, mut property, mut entries) = ([None; 3], None, [None; 3]);
        // This runs for every triangle, so it makes one pass over the attributes.
        for attribute in element.attributes().with_checks(false).flatten() {
            let target = match attribute.key.into_inner() {
                "v1" => &mut corners[0],
                "v2" => &mut corners[1],
                "v3" => &mut corners[2],
                "pid" => &mut property,
                "p1" => &mut entries[0],
                "p2" => &mut entries[1],
                "p3" => &mut entries[2],
                _ => continue,
            };
            *target = attribute.value.trim().parse::<u32>().ok();
        }
        let [Some(a), Some(b), Some(c)] = corners else {
            return Err(element_error("a triangle needs indices v1, v2 and v3"));
        };
        let object = self.document.objects.entry(self.object).or_default();
        reserve(&mut object.faces, 1)?;
        let n_before = object.faces.len();
        // Cleanup drops faces with an index beyond the vertices so far.
        object.faces.push([a, b, c].map(|v| if (v as usize) < object.positions.len() { v } else { NOWHERE }));
        // A triangle may name only the entry and inherit the property.
        let property = property.or(object.property.map(|(property, _)| property));
        if let (Some(property), Some(first)) = (property, entries[0]) {
            // Faces before without their own properties get empty entries.
            let n_silent = n_before - object.of_faces.len();
            reserve(&mut object.of_faces, n_silent + 1)?;
            object.of_faces.resize(n_before, None);
            object.of_faces.push(Some((property, entries.map(|entry| entry.unwrap_or(first)))));
        }
        Ok(())
    }

    fn property(&mut self, element: &BytesStart, property: FaceProperty) -> Result<(), ReadError> {
        self.property = parse_index(element, "id")?.ok_or_else(|| element_error("a resource without id"))?;
        self.document.properties.insert(self.property, property);
        Ok(())
    }

    fn material(&mut self, element: &BytesStart) -> Result<(), ReadError> {
        let name = attribute(element, "name").unwrap_or_default().into_owned();
        let colour = attribute(element, "displaycolor").and_then(|text| parse_colour(&text)).unwrap_or([1.0; 4]);
        if let Some(FaceProperty::Materials(materials)) = self.document.properties.get_mut(&self.property) {
            materials.push((name, colour));
        }
        Ok(())
    }

    fn colour(&mut self, element: &BytesStart) -> Result<(), ReadError> {
        let colour = attribute(element, "color").and_then(|text| parse_colour(&text)).unwrap_or([1.0; 4]);
        if let Some(FaceProperty::Colours(colours)) = self.document.properties.get_mut(&self.property) {
            colours.push(colour);
        }
        Ok(())
    }
}

fn element_error(what: &str) -> ReadError {
    ReadError::file(what, REMEDY)
}

fn parse_reference(element: &BytesStart) -> Result<Reference, ReadError> {
    let object =
        parse_index(element, "objectid")?.ok_or_else(|| element_error("an item or component without objectid"))?;
    let transform = attribute(element, "transform").map_or(Ok(DMat4::IDENTITY), |text| parse_matrix(&text))?;
    Ok(Reference { path: attribute(element, "path").map(Cow::into_owned), object, transform })
}

fn parse_matrix(text: &str) -> Result<DMat4, ReadError> {
    let numbers: Option<Vec<f64>> =
        text.split_whitespace().map(|word| parse_number(word).map(|number| number.value)).collect();
    let numbers = numbers.filter(|numbers| numbers.len() == 12 && numbers.iter().all(|x| x.is_finite()));
    let numbers = numbers.ok_or_else(|| element_error("a transform needs twelve numbers"))?;
    // The first nine numbers are the images of the axes, the last three that of the origin.
    let [x, y, z, origin] = [0, 3, 6, 9].map(|at| DVec3::from_slice(&numbers[at..]));
    Ok(DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), origin.extend(1.0)))
}

fn parse_index(element: &BytesStart, name: &str) -> Result<Option<u32>, ReadError> {
    let parsed = |text: Cow<str>| {
        text.trim().parse().map_err(|_| element_error(&format!("{name} {:?} is not an index", shorten_name(&text))))
    };
    attribute(element, name).map(parsed).transpose()
}

fn parse_number(text: &str) -> Option<number::Number> {
    let text = text.trim();
    number::parse(text.as_bytes()).filter(|number| number.length == text.len())
}

fn parse_colour(text: &str) -> Option<[f32; 4]> {
    let digits = text.trim().strip_prefix('#').filter(|digits| digits.is_ascii())?;
    let channel = |at: usize| u8::from_str_radix(digits.get(at..at + 2)?, 16).ok().map(|byte| f32::from(byte) / 255.0);
    let alpha = if digits.len() == 6 { Some(1.0) } else { channel(6) };
    Some([channel(0)?, channel(2)?, channel(4)?, alpha?])
}
