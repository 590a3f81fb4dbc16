//! PLY headers: encoding, elements, properties.

use crate::io::extra::decode_text;
use crate::io::{ReadError, Scalar};

const REMEDY: &str = "export the mesh again";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::io) struct PlyProperty {
    pub name: String,
    pub scalar: Scalar,
    // Type of the length, for a list.
    pub length: Option<Scalar>,
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::io) struct Element {
    pub name: String,
    // Claimed number of rows; the file may have fewer.
    pub count: usize,
    pub properties: Vec<PlyProperty>,
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::io) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    // Lines that begin with `comment` or `obj_info`.
    pub comments: Vec<String>,
    // Offset of the values in bytes.
    pub body: usize,
}

impl Element {
    pub fn scalar(&self, name: &str) -> Result<usize, ReadError> {
        let found = self.properties.iter().position(|property| property.length.is_none() && property.name == name);
        found.ok_or_else(|| self.missing_error(&format!("property {name}")))
    }

    pub fn list(&self, names: &[&str]) -> Option<usize> {
        let named = |property: &PlyProperty| property.length.is_some() && names.contains(&property.name.as_str());
        self.properties.iter().position(named)
    }

    pub fn missing_error(&self, what: &str) -> ReadError {
        ReadError::file(format!("the element {} has no {what}", self.name), REMEDY)
    }

    /// Returns property offsets and row length in bytes; `None` with lists.
    pub fn layout(&self) -> Option<(Vec<usize>, usize)> {
        let mut stride = 0;
        let mut offsets = Vec::with_capacity(self.properties.len());
        for property in &self.properties {
            if property.length.is_some() {
                return None;
            }
            offsets.push(stride);
            stride += property.scalar.size();
        }
        Some((offsets, stride))
    }
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Self, ReadError> {
        // Some editors put a byte order mark in front.
        let mut at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let first = line_end(bytes, at, true);
        if bytes[at..first.0].trim_ascii() != b"ply" {
            return Err(ReadError::line(bytes, at, "the file does not start with ply", "name the right format"));
        }
        // After a header with bare carriage returns, a line feed already belongs to the values.
        let pairs = bytes.get(first.0..first.1) != Some(b"\r");
        let mut lines = HeaderLines::default();
        at = first.1;
        while at < bytes.len() {
            let (end, next) = line_end(bytes, at, pairs);
            let problem = |what: &str| ReadError::line(bytes, at, what, REMEDY);
            if lines.take(&bytes[at..end]).map_err(problem)? {
                let encoding = lines.encoding.ok_or_else(|| problem("the header does not name its encoding"))?;
                return Ok(Self { encoding, elements: lines.elements, comments: lines.comments, body: next });
            }
            at = next;
        }
        Err(ReadError::byte(bytes.len(), "the header has no end", "the file is cut, export the mesh again"))
    }
}

#[derive(Default)]
struct HeaderLines {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    comments: Vec<String>,
}

impl HeaderLines {
    fn take(&mut self, line: &[u8]) -> Result<bool, &'static str> {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("format") => self.encoding = Some(parse_encoding(words.next()).ok_or("unknown encoding")?),
            Some("element") => self.elements.push(parse_element(words).ok_or("an element needs a name and a count")?),
            Some("property") => {
                let property =
                    parse_property(words).ok_or("a property needs a known type, like float or uchar, and a name")?;
                let element = self.elements.last_mut().ok_or("a property before the first element")?;
                element.properties.push(property);
            }
            Some("end_header") => return Ok(true),
            Some("comment" | "obj_info") => self.comments.push(decode_text(line.trim_ascii())),
            None => {}
            // An unknown statement may change the layout of the values, so it cannot be skipped.
            Some(_) => return Err("unknown word in the header"),
        }
        Ok(false)
    }
}

fn line_end(bytes: &[u8], at: usize, pairs: bool) -> (usize, usize) {
    let end = memchr::memchr2(b'\n', b'\r', &bytes[at..]).map_or(bytes.len(), |n| at + n);
    // The second byte may belong to the values if the header uses bare carriage returns.
    let pair = pairs && bytes[end..].starts_with(b"\r\n");
    (end, (end + if pair { 2 } else { 1 }).min(bytes.len()))
}

fn parse_encoding(name: Option<&str>) -> Option<Encoding> {
    match name? {
        "ascii" => Some(Encoding::Text),
        "binary_little_endian" => Some(Encoding::LittleEndian),
        "binary_big_endian" => Some(Encoding::BigEndian),
        _ => None,
    }
}

fn parse_element<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Element> {
    let name = words.next()?.to_owned();
    Some(Element { name, count: words.next()?.parse().ok()?, properties: Vec::new() })
}

fn parse_property<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<PlyProperty> {
    let kind = words.next()?;
    let length = if kind == "list" { Some(Scalar::from_name(words.next()?)?) } else { None };
    let scalar = Scalar::from_name(if length.is_some() { words.next()? } else { kind })?;
    Some(PlyProperty { name: words.next()?.to_owned(), scalar, length })
}
