//! Small glTF assets made in code.

use std::path::PathBuf;

use neural_mesh::io::{Asset, AssetPart, Format, OutputFile, ReadError, SimplifiedPart};
use serde_json::{Value, json};

pub const BYTE: u32 = 5120;
pub const UNSIGNED_BYTE: u32 = 5121;
pub const SHORT: u32 = 5122;
pub const UNSIGNED_SHORT: u32 = 5123;
pub const UNSIGNED_INT: u32 = 5125;
pub const FLOAT: u32 = 5126;

pub struct Builder {
    pub document: Value,
    pub buffer: Vec<u8>,
}

impl Builder {
    pub fn new() -> Self {
        let document = json!({
            "asset": {"version": "2.0", "copyright": "nobody", "extras": {"kept": [1, 2.5, "three"]}},
            "scene": 0, "scenes": [{"nodes": [0], "name": "all"}], "nodes": [{"mesh": 0, "name": "node"}],
            "accessors": [], "bufferViews": [], "meshes": [],
        });
        Self { document, buffer: Vec::new() }
    }

    pub fn push(&mut self, array: &str, value: Value) -> usize {
        if self.document.get(array).is_none() {
            self.document[array] = json!([]);
        }
        let held = self.document[array].as_array_mut().unwrap();
        held.push(value);
        held.len() - 1
    }

    // Adds a view of these bytes, at a multiple of four.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let offset = self.buffer.len();
        self.buffer.extend(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    pub fn accessor(&mut self, bytes: &[u8], component: u32, shape: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": component, "count": count, "type": shape}))
    }

    pub fn floats<const N: usize>(&mut self, rows: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, FLOAT, ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1], rows.len())
    }

    // Adds an accessor of positions, with the range that the specification requires.
    pub fn positions(&mut self, rows: &[[f32; 3]]) -> usize {
        let accessor = self.floats(rows);
        self.bound(accessor, &rows.iter().map(|row| row.map(f64::from)).collect::<Vec<_>>());
        accessor
    }

    pub fn bound<const N: usize>(&mut self, accessor: usize, rows: &[[f64; N]]) {
        for (name, fold) in [("min", f64::min as fn(f64, f64) -> f64), ("max", f64::max)] {
            let extremes = (0..N).map(|axis| rows.iter().map(|row| row[axis]).reduce(fold).unwrap());
            self.document["accessors"][accessor][name] = extremes.collect::<Vec<_>>().into();
        }
    }

    pub fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor(&bytes, UNSIGNED_SHORT, "SCALAR", indices.len())
    }

    pub fn mesh(&mut self, primitives: Value) -> usize {
        self.push("meshes", json!({"name": "shape", "primitives": primitives}))
    }

    // Returns the document with the length of its buffer.
    pub fn to_document(&self) -> Value {
        let mut document = self.document.clone();
        if !self.buffer.is_empty() {
            document["buffers"] = json!([{"byteLength": self.buffer.len(), "name": "all bytes"}]);
        }
        let members = document.as_object_mut().unwrap();
        members.retain(|_, value| value.as_array().is_none_or(|elements| !elements.is_empty()));
        document
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut json = serde_json::to_vec(&self.to_document()).unwrap();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut buffer = self.buffer.clone();
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((28 + json.len() as u32 + buffer.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &buffer)] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        bytes
    }
}

// A square of two triangles with a vertex in each corner, counterclockwise.
pub const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
pub const SQUARE_FACES: [u16; 6] = [0, 1, 2, 0, 2, 3];

// Fails for every file that an asset requests.
pub fn refuse_uri(uri: &str) -> Result<Vec<u8>, ReadError> {
    Err(ReadError::file(format!("asked for {uri}"), ""))
}

pub fn open(bytes: &[u8]) -> Asset {
    Asset::from_bytes(bytes, &refuse_uri).unwrap()
}

// Returns the components as they are.
pub fn unchanged_parts(asset: &Asset) -> Vec<SimplifiedPart> {
    asset.parts().iter().map(SimplifiedPart::from_part).collect()
}

// Returns the primitive of each face of a mesh, with the position and values of each corner.
pub fn corners_by_primitive(part: &AssetPart) -> Vec<(u32, Vec<Vec<f32>>)> {
    let mesh = &part.mesh;
    let corner = |face: usize, corner: usize| {
        let mut values = mesh.positions[mesh.faces[face][corner] as usize].map(|x| x as f32).to_vec();
        for channel in &mesh.attributes.channels {
            values.extend(channel.value(mesh.attributes.wedges[face][corner]));
        }
        values
    };
    let face = |face: usize| (mesh.attributes.group(face as u32), (0..3).map(|at| corner(face, at)).collect());
    (0..mesh.faces.len()).map(face).collect()
}

// Returns the JSON of a file.
pub fn document(bytes: &[u8]) -> Value {
    let json = match bytes.starts_with(b"glTF") {
        true => &bytes[20..20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize],
        false => bytes,
    };
    serde_json::from_slice(json).unwrap()
}

// Opens files that belong together; the first one is the asset.
pub fn reopen(files: &[OutputFile]) -> Asset {
    let fetch = |uri: &str| {
        let name = uri.replace("%20", " ");
        let file = files.iter().find(|file| file.path.to_str() == Some(&name));
        file.map(|file| file.bytes.clone()).ok_or_else(|| refuse_uri(uri).unwrap_err())
    };
    Asset::from_bytes(&files[0].bytes, &fetch).unwrap()
}

// Keeps files for `scripts/validate_gltf`.
pub fn keep(name: &str, files: &[OutputFile]) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("gltf_assets").join(name);
    std::fs::create_dir_all(&folder).unwrap();
    neural_mesh::io::write_files(&folder, files, true).unwrap();
}

// Writes an unchanged asset in both formats and expects the same contents; returns the document of the GLB.
pub fn round_trip(name: &str, bytes: &[u8]) -> Value {
    let asset = open(bytes);
    keep(name, &[OutputFile { path: "input.glb".into(), bytes: bytes.to_vec() }]);
    for (format, file) in [(Format::Gltf, "same.gltf"), (Format::Glb, "same.glb")] {
        let files = asset.write(&unchanged_parts(&asset), format, file).unwrap();
        keep(name, &files);
        let again = reopen(&files);
        assert_eq!(again.parts().len(), asset.parts().len());
        for (found, expected) in again.parts().iter().zip(asset.parts()) {
            assert_eq!((&found.name, found.scale), (&expected.name, expected.scale));
            assert_eq!(corners_by_primitive(found), corners_by_primitive(expected), "{name}");
        }
        let (mut before, mut after) = (document(bytes), document(&files[0].bytes));
        forget_geometry(&mut before);
        forget_geometry(&mut after);
        assert_eq!(after, before, "{name}");
    }
    document(&asset.write(&unchanged_parts(&asset), Format::Glb, "same.glb").unwrap()[0].bytes)
}

// Removes the geometry, and the numbers of accessors and views.
fn forget_geometry(document: &mut Value) {
    let members = document.as_object_mut().unwrap();
    for name in ["accessors", "bufferViews", "buffers", "extensionsUsed", "extensionsRequired"] {
        members.remove(name);
    }
    for name in ["meshes", "animations", "skins", "images", "nodes"] {
        members.get_mut(name).into_iter().for_each(forget_numbers);
    }
}

fn forget_numbers(value: &mut Value) {
    let names = [
        "attributes",
        "extensions",
        "indices",
        "targets",
        "mode",
        "input",
        "output",
        "inverseBindMatrices",
        "bufferView",
    ];
    match value {
        Value::Array(values) => values.iter_mut().for_each(forget_numbers),
        Value::Object(members) => {
            members.retain(|name, _| !names.contains(&name.as_str()));
            members.values_mut().for_each(forget_numbers);
        }
        _ => {}
    }
}
