//! Meshes as arrays of a request or an answer, with one row per vertex.

use neural_mesh::io::ReadMesh;
use neural_mesh::job::Document;
use neural_mesh::mesh::{Attributes, Channel, RawMesh, Role, TriMesh};
use neural_mesh::simplify::Simplified;
use rustc_hash::FxHashMap;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use crate::message::{Answer, Message};
use crate::refusal::Refusal;

/// Names of vertex arrays, their roles, and their largest widths.
const NAMES: [(&str, Role, usize); 3] =
    [("uv", Role::Uv, 2), ("normals", Role::Normal, 3), ("colors", Role::Colour, 4)];

/// Arrays of a mesh, each by the number of its part in the message.
#[derive(Deserialize)]
pub struct Arrays {
    /// Positions, n_vertices x 3.
    positions: usize,
    /// True if the positions have double precision.
    #[serde(default)]
    doubles: bool,
    /// Faces, n_faces x 3.
    faces: usize,
    uv: Option<usize>,
    normals: Option<usize>,
    colors: Option<usize>,
    /// Group of each face, n_faces.
    groups: Option<usize>,
    /// Weight of each vertex, n_vertices.
    importance: Option<usize>,
}

impl Arrays {
    /// Returns the mesh, and the weights of its vertices if given.
    ///
    /// # Errors
    /// [`Refusal`] if an array is missing or has the wrong length.
    pub fn read(&self, message: &Message) -> Result<(ReadMesh, Option<Vec<f32>>), Refusal> {
        let positions = match self.doubles {
            true => message.rows(self.positions, f64::from_le_bytes)?,
            false => {
                let rows: Vec<[f32; 3]> = message.rows(self.positions, f32::from_le_bytes)?;
                rows.into_iter().map(|p| p.map(f64::from)).collect()
            }
        };
        let (n_vertices, faces) = (positions.len(), message.rows(self.faces, u32::from_le_bytes)?);
        let groups: Vec<u32> =
            read_optional(self.groups, |part| message.numbers(part, u32::from_le_bytes))?.unwrap_or_default();
        check_length("groups", groups.len(), faces.len())?;
        let importance = read_optional(self.importance, |part| message.numbers(part, f32::from_le_bytes))?;
        check_length("importance", importance.as_ref().map_or(0, Vec::len), n_vertices)?;
        let mut channels = Vec::new();
        for ((name, role, width), part) in NAMES.into_iter().zip([self.uv, self.normals, self.colors]) {
            let Some(values) = read_optional(part, |part| message.numbers(part, f32::from_le_bytes))? else { continue };
            check_length(name, values.len(), width * n_vertices)?;
            channels.push(Channel { name: name.into(), role, width, values });
        }
        let wedges = if channels.is_empty() { Vec::new() } else { faces.clone() };
        let mut read = ReadMesh::default();
        read.mesh = RawMesh::new(positions, faces);
        read.mesh.double = self.doubles;
        read.mesh.attributes = Attributes { wedges, channels, groups };
        let n = u32::try_from(n_vertices).unwrap_or(u32::MAX);
        if let Some(bad) = read.mesh.faces.as_flattened().iter().find(|&&v| v >= n) {
            return Err(Refusal::new(format!("faces name vertex {bad}, but there are only {n_vertices} vertices")));
        }
        Ok((read, importance))
    }
}

fn read_optional<T>(part: Option<usize>, read: impl Fn(usize) -> Result<T, Refusal>) -> Result<Option<T>, Refusal> {
    part.map(read).transpose()
}

fn check_length(name: &str, n: usize, wanted: usize) -> Result<(), Refusal> {
    if n == 0 || n == wanted { Ok(()) } else { Err(Refusal::new(format!("{name}: {n} numbers: give {wanted}"))) }
}

/// Vertices of a mesh, split where their corners carry different values.
pub struct SplitVertices {
    vertices: Vec<[u32; 2]>,
    /// Split vertices of each face, n_faces x 3.
    pub faces: Vec<[u32; 3]>,
}

impl SplitVertices {
    /// Creates a vertex for each pair of vertex and wedge, in order of first use.
    pub fn new(mesh: &TriMesh, attributes: &Attributes) -> Self {
        if attributes.wedges.is_empty() {
            let vertices = (0..mesh.positions().len() as u32).map(|v| [v, v]).collect();
            return Self { vertices, faces: mesh.faces().to_vec() };
        }
        let (mut vertices, mut number) = (Vec::new(), FxHashMap::default());
        let mut number_pair = |pair: [u32; 2]| {
            *number.entry(pair).or_insert_with(|| {
                vertices.push(pair);
                vertices.len() as u32 - 1
            })
        };
        let pairs = mesh.faces().iter().zip(&attributes.wedges);
        let faces = pairs.map(|(face, wedges)| [0, 1, 2].map(|k| number_pair([face[k], wedges[k]]))).collect();
        Self { vertices, faces }
    }

    pub fn of_vertices<'a, T>(&'a self, rows: &'a [T]) -> impl Iterator<Item = &'a T> {
        self.vertices.iter().map(|[v, _]| &rows[*v as usize])
    }

    pub fn of_wedges<'a>(&'a self, channel: &'a Channel) -> impl Iterator<Item = f32> + 'a {
        self.vertices.iter().flat_map(|[_, wedge]| channel.value(*wedge).iter().copied())
    }
}

/// Adds a result to an answer; returns the numbers of its arrays by name.
pub fn add_result(
    document: &Document,
    result: &Simplified,
    exact: Option<Vec<[f64; 3]>>,
    answer: &mut Answer,
) -> Value {
    let split = SplitVertices::new(&result.mesh, &result.attributes);
    let framed = |p: &[f32; 3]| document.frame.to_file(*p).map(|x| x as f32);
    let positions = match &exact {
        Some(exact) => answer.add_numbers(split.of_vertices(exact).copied().flatten(), f64::to_le_bytes),
        None => answer.add_numbers(split.of_vertices(result.mesh.positions()).flat_map(framed), f32::to_le_bytes),
    };
    let faces = answer.add_numbers(split.faces.iter().copied().flatten(), u32::to_le_bytes);
    let mut arrays = Map::new();
    arrays.extend([("positions".to_string(), json!(positions)), ("doubles".into(), json!(exact.is_some()))]);
    arrays.insert("faces".into(), json!(faces));
    for (name, role, _) in NAMES {
        let Some(channel) = result.attributes.channel(role) else { continue };
        arrays.insert(name.into(), json!(answer.add_numbers(split.of_wedges(channel), f32::to_le_bytes)));
        arrays.insert(format!("{name}_width"), json!(channel.width));
    }
    if !result.attributes.groups.is_empty() {
        let groups = answer.add_numbers(result.attributes.groups.iter().copied(), u32::to_le_bytes);
        arrays.insert("groups".into(), json!(groups));
    }
    if let Some(map) = &result.map {
        let file = document.file_vertices();
        let source = |&v: &u32| file.and_then(|file| file.get(v as usize)).copied().unwrap_or(v);
        let sources = answer.add_numbers(split.of_vertices(&map.input_vertices).map(source), u32::to_le_bytes);
        arrays.insert("map".into(), json!(sources));
    }
    arrays.into()
}
