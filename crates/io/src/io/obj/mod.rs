//! Wavefront OBJ, without curves, lines and points.

mod groups;
mod pieces;
mod write;

use super::ReadError;
use super::corner_wedges::{CornerWedges, NOWHERE};
use super::extra::{self, Extra, ReadMesh, replace_non_finite};
use super::memory::reserve;
use super::runs::PieceContent;
use super::text::Text;
use crate::mesh::{Attributes, Channel, Fans, RawMesh, Role};
use groups::ObjGroups;
pub(super) use pieces::{each_piece, outline};
pub(super) use write::write;

const REMEDY: &str = "fix the line or export the mesh again";

/// Component of the colour of a vertex without one, until all are known.
const MISSING: f32 = f32::MAX;

/// Reads the geometry of an OBJ text.
pub(super) fn read(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    let mut reader = ObjReader::default();
    reader.read(bytes)?;
    reader.fans.triangulate(&reader.mesh.positions, &mut reader.mesh.faces);
    Ok(reader.mesh)
}

/// Reads an OBJ text with all its attributes; missing values are zeros, missing colours white.
pub(super) fn read_attributed(bytes: &[u8]) -> Result<ReadMesh, ReadError> {
    let mut reader = ObjReader { reads_attributes: true, ..ObjReader::default() };
    reader.read(bytes)?;
    Ok(reader.finish())
}

#[derive(Default)]
struct ObjReader<'a> {
    reads_attributes: bool,
    content: PieceContent,
    // Vertices before the text, if that is a piece of a file.
    n_before: usize,
    // The faces index wedges if `wedges` exists.
    mesh: RawMesh,
    fans: Fans,
    corners: Vec<[u32; 3]>,
    numbers: Vec<u32>,
    // Vertices, texture coordinates and normals, from the first corner with more than a vertex.
    wedges: Option<CornerWedges>,
    // Values of the `vt` lines, n x 2, and of the `vn` lines, n x 3.
    uvs: Vec<f32>,
    normals: Vec<f32>,
    // Colours of the vertices, n_vertices x 3; empty until a vertex has one.
    colours: Vec<f32>,
    groups: ObjGroups<'a>,
    libraries: Vec<&'a [u8]>,
    ignored: IgnoredStatements,
}

#[derive(Default)]
struct IgnoredStatements {
    third_coordinates: usize,
    lines: usize,
    points: usize,
    curves: usize,
}

impl<'a> ObjReader<'a> {
    fn read(&mut self, bytes: &'a [u8]) -> Result<(), ReadError> {
        // Unknown statements are skipped, since exporters add their own.
        let mut text = Text::new(bytes).with_continuation();
        while !text.is_at_end() {
            text.skip_blanks();
            match text.rest() {
                [b'v', b' ' | b'\t' | b'\\', ..] if self.content == PieceContent::Faces => self.n_before += 1,
                [b'v', b' ' | b'\t' | b'\\', ..] => {
                    text.advance(1);
                    self.read_vertex(&mut text)?;
                }
                [b'f', b' ' | b'\t' | b'\\' | b'\r' | b'\n', ..] | [b'f']
                    if self.content != PieceContent::Positions =>
                {
                    text.advance(1);
                    self.read_face(&mut text)?;
                }
                _ if self.reads_attributes => self.read_statement(&mut text),
                _ => {}
            }
            text.skip_line();
        }
        self.mesh.double = text.double;
        Ok(())
    }

    fn read_vertex(&mut self, text: &mut Text) -> Result<(), ReadError> {
        // Coordinates that are not finite are left to cleanup.
        let position = text.read_position(Text::skip_blanks);
        let position = position.ok_or_else(|| text.error("a vertex needs three numbers", REMEDY))?;
        reserve(&mut self.mesh.positions, 1)?;
        self.mesh.positions.push(position);
        // A single number after the position is a weight; three numbers are a colour.
        if self.reads_attributes && (!self.colours.is_empty() || !text.is_line_done()) {
            let colour = parse_values::<3>(text);
            if let Some(colour) = colour.filter(|&(_, n)| n == 3).map(|(colour, _)| colour) {
                self.colours.resize(3 * (self.mesh.positions.len() - 1), MISSING);
                self.colours.extend(colour);
            }
        }
        Ok(())
    }

    fn read_face(&mut self, text: &mut Text) -> Result<(), ReadError> {
        self.read_corners(text)?;
        self.numbers.clear();
        reserve(&mut self.numbers, self.corners.len())?;
        // Wedges begin with the first corner that has more than a vertex: most files have no such corner, or begin with
        // one.
        if self.wedges.is_none() && self.corners.iter().any(|corner| corner[1..] != [NOWHERE; 2]) {
            self.wedges = Some(CornerWedges::from_vertices(&mut self.mesh.faces));
        }
        match &mut self.wedges {
            Some(wedges) => self.numbers.extend(self.corners.iter().map(|&corner| wedges.number(corner))),
            None => self.numbers.extend(self.corners.iter().map(|corner| corner[0])),
        }
        let n_before = self.mesh.faces.len();
        reserve(&mut self.mesh.faces, self.numbers.len())?;
        // Faces with fewer than three corners are counted and dropped.
        if !self.fans.push(&self.numbers, &mut self.mesh.faces) {
            self.mesh.dropped_faces += 1;
        } else if self.reads_attributes {
            self.groups.assign(n_before, self.mesh.faces.len());
        }
        Ok(())
    }

    /// Reads corners `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn read_corners(&mut self, text: &mut Text) -> Result<(), ReadError> {
        let counts = [self.n_before + self.mesh.positions.len(), self.uvs.len() / 2, self.normals.len() / 3];
        self.corners.clear();
        while !text.is_line_done() {
            let problem = "a corner of a face needs a vertex number";
            // A bad vertex number is an error; a bad texture coordinate or normal is only missing.
            let vertex = text.integer().ok_or_else(|| text.error(problem, REMEDY))?;
            let mut corner = [to_zero_based(vertex, counts[0]), NOWHERE, NOWHERE];
            for (part, &count) in corner.iter_mut().zip(&counts).skip(1) {
                // For geometry alone, the rest of a corner is skipped below.
                if !self.reads_attributes || text.rest().first() != Some(&b'/') {
                    break;
                }
                text.advance(1);
                *part = text.integer().map_or(NOWHERE, |index| to_zero_based(index, count));
            }
            reserve(&mut self.corners, 1)?;
            self.corners.push(corner);
            // The rest of the corner is skipped, whatever it contains.
            while !text.is_between_words() {
                text.advance(1);
            }
        }
        Ok(())
    }

    fn read_statement(&mut self, text: &mut Text<'a>) {
        match text.word() {
            // A third coordinate is noted unless it is zero.
            b"vt" => {
                let (values, _) = parse_values::<3>(text).unwrap_or_default();
                self.uvs.extend(&values[..2]);
                self.ignored.third_coordinates += usize::from(values[2] != 0.0);
            }
            b"vn" => self.normals.extend(parse_values::<3>(text).unwrap_or_default().0),
            b"mtllib" => self.libraries.push(text.rest_of_line()),
            b"l" => self.ignored.lines += 1,
            b"p" => self.ignored.points += 1,
            b"vp" | b"curv" | b"curv2" | b"surf" => self.ignored.curves += 1,
            // The longest group statement, `usemtl`, has six letters; other statements need no copy.
            word if word.len() <= 6 => {
                self.groups.take(word, text.rest_of_line());
            }
            _ => {}
        }
    }

    fn finish(mut self) -> ReadMesh {
        let mut notes = self.ignored.notes();
        // Attributes must be finite for the later fits; cleanup judges positions.
        let not_finite: usize = [&mut self.uvs, &mut self.normals, &mut self.colours]
            .into_iter()
            .map(|values| replace_non_finite(values))
            .sum();
        if not_finite > 0 {
            notes.push(format!(
                "{not_finite} numbers of texture coordinates, normals or colours are not finite: they become 0"
            ));
        }
        finish_colours(&mut self.colours, self.mesh.positions.len());
        notes.extend(self.groups.drop_varied_names());
        // All names have one encoding: a single invalid name makes the file Latin-1, so that it can be written back.
        let latin1 =
            self.groups.names().chain(self.libraries.iter().copied()).any(|name| std::str::from_utf8(name).is_err());
        let text = |name: &&[u8]| if latin1 { extra::decode_latin1(name) } else { extra::decode_text(name) };
        let material_libraries = self.libraries.iter().map(text).collect();
        let extra = Extra { groups: self.groups.to_groups(latin1), material_libraries, latin1, ..Extra::default() };
        let groups = std::mem::take(&mut self.groups.of_faces);
        let (wedges, channels) = self.finish_faces();
        let mut mesh = self.mesh;
        mesh.attributes = Attributes { wedges, channels, groups };
        ReadMesh { mesh, extra, notes, format: None }
    }

    fn finish_faces(&mut self) -> (Vec<[u32; 3]>, Vec<Channel>) {
        let RawMesh { positions, faces, .. } = &mut self.mesh;
        let fans = std::mem::take(&mut self.fans);
        // Without wedges, corners with colours use their vertices as wedges.
        let Some(wedges) = self.wedges.take() else {
            fans.triangulate(positions, faces);
            let colours = std::mem::take(&mut self.colours);
            let coloured = !colours.is_empty();
            let channels = if coloured { vec![channel("colour", Role::Colour, 3, colours)] } else { Vec::new() };
            return (if coloured { faces.clone() } else { Vec::new() }, channels);
        };
        let of_faces = wedges.finish_faces(fans, positions, faces);
        let uvs = wedges.values(1, &self.uvs, 2).map(|values| channel("uv", Role::Uv, 2, values));
        let normals = wedges.values(2, &self.normals, 3).map(|values| channel("normal", Role::Normal, 3, values));
        let colours = wedges.values(0, &self.colours, 3).map(|values| channel("colour", Role::Colour, 3, values));
        let channels: Vec<Channel> = [uvs, normals, colours].into_iter().flatten().collect();
        (if channels.is_empty() { Vec::new() } else { of_faces }, channels)
    }
}

impl IgnoredStatements {
    fn notes(&self) -> Vec<String> {
        let named = [
            (self.third_coordinates, "third texture coordinates"),
            (self.lines, "polylines"),
            (self.points, "statements of points"),
            (self.curves, "statements of free-form curves and surfaces"),
        ];
        named.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what} dropped")).collect()
    }
}

/// Makes bytes shares of one, as some exporters write colours, and missing colours of `n_vertices` white.
fn finish_colours(colours: &mut Vec<f32>, n_vertices: usize) {
    let is_byte = |&x: &f32| x == MISSING || x.fract() == 0.0 && (0.0..=255.0).contains(&x);
    // Colours of zeros and ones alone are none.
    let are_bytes = colours.iter().all(is_byte) && colours.iter().any(|&x| x > 1.0 && x != MISSING);
    let white = if are_bytes { 255.0 } else { 1.0 };
    if !colours.is_empty() {
        colours.resize(3 * n_vertices, MISSING);
    }
    colours.iter_mut().for_each(|x| *x = if *x == MISSING { 1.0 } else { *x / white });
}

fn channel(name: &str, role: Role, width: usize, values: Vec<f32>) -> Channel {
    Channel { name: name.into(), role, width, values }
}

// OBJ counts from one, or back from the last with negative numbers.
fn to_zero_based(index: i64, count: usize) -> u32 {
    u32::try_from(if index < 0 { count as i64 + index } else { index - 1 }).unwrap_or(NOWHERE)
}

fn parse_values<const N: usize>(text: &mut Text) -> Option<([f32; N], usize)> {
    // Attributes are singles: their digits must not make the positions doubles.
    let double = text.double;
    let (mut values, mut n) = ([0.0; N], 0);
    while n < N {
        text.skip_blanks();
        let Some(value) = text.number() else { break };
        values[n] = value as f32;
        n += 1;
    }
    text.double = double;
    (n > 0).then_some((values, n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn faces(text: &str) -> Vec<[u32; 3]> {
        read(format!("{SQUARE}{text}").as_bytes()).unwrap().faces
    }

    #[test]
    fn corners_of_every_spelling() {
        for face in [
            "f 1 2 3",
            "f 1/1 2/2/2 3//3",
            "f 1// 2/ 3/7/",
            "f -4 -3 -2",
            "f\t1  2 \t3\r",
            "f 1 2 3 # words",
            "f +1 2 3",
        ] {
            assert_eq!(faces(face), [[0, 1, 2]], "{face}");
            assert_eq!(faces(&format!("{face}\n")), [[0, 1, 2]], "{face}");
        }
    }

    type NaiveCorner = (u32, [f32; 2], [f32; 3]);

    fn naive(text: &str) -> Vec<[NaiveCorner; 3]> {
        let rows = |word: &str| {
            let numbers = |line: &str| line.split(' ').skip(1).map(|x| x.parse::<f32>().unwrap()).collect::<Vec<_>>();
            text.lines().filter(|line| line.split(' ').next() == Some(word)).map(numbers).collect::<Vec<_>>()
        };
        let tables = [rows("v"), rows("vt"), rows("vn")];
        let mut counts = [0; 3];
        let mut faces = Vec::new();
        for line in text.lines() {
            let mut words = line.split(' ');
            match words.next().unwrap() {
                "v" => counts[0] += 1,
                "vt" => counts[1] += 1,
                "vn" => counts[2] += 1,
                _ => faces.push(words.map(|word| naive_corner(word, &counts, &tables)).collect::<Vec<_>>()),
            }
        }
        faces.into_iter().map(|face| face.try_into().unwrap()).collect()
    }

    fn naive_corner(word: &str, counts: &[i64; 3], tables: &[Vec<Vec<f32>>; 3]) -> NaiveCorner {
        let mut parts = word.split('/').map(|part| part.parse::<i64>().ok()).zip(counts);
        let mut next = || parts.next().and_then(|(index, n)| Some(if index? < 0 { n + index? } else { index? - 1 }));
        let vertex = next().unwrap() as u32;
        let mut value = |table: &Vec<Vec<f32>>| {
            let row = next().and_then(|index| table.get(usize::try_from(index).ok()?).cloned());
            row.unwrap_or(vec![0.0; 3])
        };
        let (uv, normal) = (value(&tables[1]), value(&tables[2]));
        (vertex, [uv[0], uv[1]], [normal[0], normal[1], normal[2]])
    }

    fn any_face() -> impl Strategy<Value = String> {
        let corner = (1i64..5, -6i64..7, -6i64..7, 0..5).prop_map(|(vertex, uv, normal, form)| match form {
            0 => format!(" {vertex}"),
            1 => format!(" {vertex}/{uv}"),
            2 => format!(" {vertex}//{normal}"),
            3 => format!(" {vertex}/{uv}/"),
            _ => format!(" {}/{uv}/{normal}", vertex - 5),
        });
        prop::array::uniform3(corner).prop_map(|corners| format!("f{}", corners.concat()))
    }

    proptest! {
        #[test]
        fn agrees_with_splitting_lines(
            lines in prop::collection::vec(prop_oneof![any_face(), Just("vt 0.5 1".into()), Just("vt 2 3".into()), Just("vn 0 0 1".into()), Just("vn 1 0 0".into())], 0..40),
        ) {
            let text = format!("{SQUARE}{}\n", lines.join("\n")).trim_end().to_string();
            let ReadMesh { mesh, .. } = read_attributed(text.as_bytes()).unwrap();
            let channel = |role| mesh.attributes.channel(role);
            let value = |role, face: usize, corner: usize| match channel(role) {
                Some(channel) => channel.value(mesh.attributes.wedges[face][corner]).to_vec(),
                None => vec![0.0; 3],
            };
            for (face, corners) in naive(&text).iter().enumerate() {
                for (corner, (vertex, uv, normal)) in corners.iter().enumerate() {
                    prop_assert_eq!(mesh.faces[face][corner], *vertex);
                    prop_assert_eq!(&value(Role::Uv, face, corner)[..2], uv);
                    prop_assert_eq!(&value(Role::Normal, face, corner)[..], normal);
                }
            }
            prop_assert_eq!(mesh.faces, read(text.as_bytes()).unwrap().faces);
        }
    }

    #[test]
    fn wedges_follow_the_corners_of_a_turned_quad() {
        let text = b"v 0 0 0\nv 2 -1 0\nv 0.5 0 0\nv 2 1 0\nvt 0 0\nvt 1 1\nvt 2 2\nvt 3 3\nf 2/2 3/3 4/4 1/1\n";
        let mesh = read_attributed(text).unwrap().mesh;
        assert_eq!(mesh.faces, read(text).unwrap().faces);
        for (face, wedges) in mesh.faces.iter().zip(&mesh.attributes.wedges) {
            for (vertex, &wedge) in face.iter().zip(wedges) {
                assert_eq!(mesh.attributes.channels[0].value(wedge), [*vertex as f32; 2]);
            }
        }
    }

    #[test]
    fn colours_up_to_255_are_bytes_and_missing_ones_white() {
        let colours = |text: &str| read_attributed(text.as_bytes()).unwrap().mesh.attributes.channels[0].values.clone();
        let mesh = |red: &str, blue: &str| format!("v 0 0 0\nv 1 0 0 {red}\nv 0 1 0 {blue}\nv 1 1 1\nf 1 2 3\n");
        let expected = [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.2, 1.0, 1.0, 1.0, 1.0];
        assert_eq!(colours(&mesh("255 0 0", "0 51 255")), expected);
        assert_eq!(colours(&mesh("1 0 0", "0 0.2 1")), expected);
        // Rounding above one makes no bytes.
        assert_eq!(colours(&mesh("1.0001 0 0", "0 1 1"))[3..6], [1.0001, 0.0, 0.0]);
        assert_eq!(colours(&mesh("300 0 0", "0 1 1"))[3..6], [300.0, 0.0, 0.0]);
    }

    #[test]
    fn continued_lines() {
        assert_eq!(faces("f 1 \\\n 2 \\\r\n3\n"), [[0, 1, 2]]);
        assert_eq!(read(b"v 1 \\\n2 3\nv\\\n 4 5 6").unwrap().positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    }

    #[test]
    fn indices_that_lead_nowhere_are_left_to_cleanup() {
        for face in ["f 0 1 2", "f 9 1 2", "f -5 1 2", "f 99999999999999999999 1 2", "f -99999999999999999999 1 2"] {
            assert!(faces(face)[0][0] as usize >= 4, "{face}");
        }
    }

    #[test]
    fn faces_before_their_vertices() {
        let text = "f 1 2 3 4\nv 0 0 0\nv 2 -1 0\nv 0.5 0 0\nv 2 1 0\n";
        assert_eq!(read(text.as_bytes()).unwrap().faces.len(), 2);
    }

    #[test]
    fn what_is_no_geometry_is_passed_over() {
        let text = b"\xef\xbb\xbf# caf\xe9 \xff\r\nmtllib a b\ng f 1 2 3\nvn 0 0 1\nvt 0 0\nvp 1\nl 1 2\np 1\nusemtl v\nfoo\n\nv 1 2 3 0.5 nan 0\n";
        assert_eq!(read(text).unwrap(), RawMesh { positions: vec![[1.0, 2.0, 3.0]], ..RawMesh::default() });
    }

    #[test]
    fn faces_of_two_corners_are_counted() {
        let mesh = read(format!("{SQUARE}f 1 2\nf\nf 1 2 3\nf").as_bytes()).unwrap();
        assert_eq!((mesh.faces.len(), mesh.dropped_faces), (1, 3));
    }

    #[test]
    fn errors_name_the_line() {
        for (text, line) in [("v 0 0\n", 1), ("v 0 0 0\nv 1 x 0", 2), ("\n\nv 1 2 3.1+e2\n", 3), ("# a\r\nf 1 a 2", 2)]
        {
            let error = read(text.as_bytes()).unwrap_err();
            assert_eq!(error.location, crate::io::FileLocation::Line(line), "{error}");
        }
    }
}
