//! Input from Python: meshes as arrays, and options.

use neural_mesh::io::ReadMesh;
use neural_mesh::job::read_options;
use neural_mesh::mesh::{Attributes, Channel, RawMesh, Role};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde::de::DeserializeOwned;

use crate::arrays::{numbers, rows};
use crate::failure::{invalid_array, option_error};
use crate::values;

#[derive(FromPyObject)]
pub enum Positions<'py> {
    Single(PyReadonlyArray2<'py, f32>),
    Double(PyReadonlyArray2<'py, f64>),
}

impl Positions<'_> {
    pub fn raw(&self) -> PyResult<RawMesh> {
        let (positions, double) = match self {
            Self::Single(array) => {
                (rows(array, "vertices")?.iter().map(|p: &[f32; 3]| p.map(f64::from)).collect(), false)
            }
            Self::Double(array) => (rows(array, "vertices")?.to_vec(), true),
        };
        let mut raw = RawMesh::new(positions, Vec::new());
        raw.double = double;
        Ok(raw)
    }
}

/// Vertices, faces (n x 3), wedges (n_faces x 3, or `None`), channels (name, role, values at wedges), groups of faces.
#[derive(FromPyObject)]
pub struct MeshArrays<'py>(
    Positions<'py>,
    PyReadonlyArray2<'py, u32>,
    Option<PyReadonlyArray2<'py, u32>>,
    Vec<(String, String, PyReadonlyArray2<'py, f32>)>,
    Option<PyReadonlyArray1<'py, u32>>,
);

impl MeshArrays<'_> {
    /// Converts the arrays to a mesh; only shapes are checked.
    pub fn read(&self) -> PyResult<ReadMesh> {
        let Self(positions, faces, wedges, channels, groups) = self;
        let attributes = Attributes {
            wedges: wedges
                .as_ref()
                .map_or(Ok(Vec::new()), |wedges| Ok::<_, PyErr>(rows(wedges, "wedges")?.to_vec()))?,
            channels: channels.iter().map(channel).collect::<PyResult<_>>()?,
            groups: groups
                .as_ref()
                .map_or(Ok(Vec::new()), |groups| Ok::<_, PyErr>(numbers(groups, "groups")?.to_vec()))?,
        };
        let faces = rows(faces, "faces")?.to_vec();
        let mut read = ReadMesh::default();
        read.mesh = positions.raw()?;
        (read.mesh.faces, read.mesh.attributes) = (faces, attributes);
        Ok(read)
    }
}

fn channel((name, role, values): &(String, String, PyReadonlyArray2<f32>)) -> PyResult<Channel> {
    let width = values.as_array().ncols();
    let values = values.as_slice().map_err(|_| invalid_array(format!("{name}: the array is not contiguous")))?.to_vec();
    let role = ROLES.iter().find(|(known, _)| known == role).map(|(_, role)| *role);
    Ok(Channel { name: name.clone(), role: role.unwrap_or(Role::Other), width, values })
}

/// Parses options; rejects unknown ones and values of the wrong type.
pub fn parse_options<T: DeserializeOwned>(options: &Bound<PyAny>) -> PyResult<T> {
    read_options(values::read(options)?).map_err(option_error)
}

const ROLES: [(&str, Role); 7] = [
    ("normal", Role::Normal),
    ("tangent", Role::Tangent),
    ("uv", Role::Uv),
    ("colour", Role::Colour),
    ("label", Role::Label),
    ("morph", Role::MorphPosition),
    ("other", Role::Other),
];

pub fn role_name(role: Role) -> &'static str {
    ROLES.iter().find(|(_, known)| *known == role).map_or("other", |(name, _)| name)
}
