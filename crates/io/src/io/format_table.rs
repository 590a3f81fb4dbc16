//! Table of the file formats: names, stored content, readers and writers.

use super::attributed_writer::{WriteTask, WrittenModel};
use super::companion_files::FileFinder;
use super::extra::ReadMesh;
#[cfg(feature = "fbx")]
use super::fbx;
use super::format::StoredAttributes;
#[cfg(feature = "gltf")]
use super::gltf;
use super::stored_precision::Precision;
#[cfg(feature = "3mf")]
use super::threemf;
use super::{FileFetcher, Format, ReadError, WriteError, obj, off, ply, stl};
use crate::mesh::{Attributes, RawMesh, Role};

type Reader<T> = fn(&[u8], &FileFetcher) -> Result<T, ReadError>;
type Writer = fn(&WriteTask, &mut FileFinder) -> Result<WrittenModel, WriteError>;

pub(super) struct FormatRow {
    pub format: Format,
    // The name and further extensions of files.
    names: &'static [&'static str],
    pub attributes: StoredAttributes,
    pub precision: Precision,
    // `None` if this build does not read the format.
    read: Option<Reader<ReadMesh>>,
    // Faster reader of positions and faces alone.
    read_geometry: Option<Reader<RawMesh>>,
    // `None` if this build does not write the format.
    write: Option<Writer>,
    // Problem and remedy of a build without the reader, and without the writer.
    no_reader: [&'static str; 2],
    no_writer: &'static str,
}

const BASE: FormatRow = FormatRow {
    format: Format::Obj,
    names: &["obj"],
    attributes: StoredAttributes::All,
    precision: Precision::Double,
    read: None,
    read_geometry: None,
    write: None,
    no_reader: ["", ""],
    no_writer: "",
};

const PLY: FormatRow = FormatRow {
    format: Format::Ply,
    names: &["ply"],
    precision: Precision::Stated,
    read: Some(|bytes, _| ply::read_attributed(bytes)),
    read_geometry: Some(|bytes, _| ply::read(bytes)),
    write: Some(ply::write),
    ..BASE
};

const STL: FormatRow = FormatRow {
    format: Format::Stl,
    names: &["stl"],
    attributes: StoredAttributes::None,
    precision: Precision::Single,
    read: Some(|bytes, _| Ok(ReadMesh { mesh: stl::read(bytes)?, notes: stl::notes(bytes), ..ReadMesh::default() })),
    read_geometry: Some(|bytes, _| stl::read(bytes)),
    write: Some(|task, _| Ok(task.geometry_file(stl::write_binary(&task.content)?))),
    ..BASE
};

const GLTF: FormatRow = FormatRow {
    format: Format::Gltf,
    names: &["gltf"],
    precision: Precision::Local,
    #[cfg(feature = "gltf")]
    read: Some(gltf::read_attributed),
    #[cfg(feature = "gltf")]
    read_geometry: Some(gltf::read),
    #[cfg(feature = "gltf")]
    write: Some(gltf::write),
    no_reader: ["this build reads no glTF", "build with the feature gltf or convert the file"],
    no_writer: "this build writes no glTF: build with the feature gltf or choose another format",
    ..BASE
};

/// Rows in the order of [`Format`].
static TABLE: [FormatRow; 10] = [
    FormatRow {
        read: Some(|bytes, _| obj::read_attributed(bytes)),
        read_geometry: Some(|bytes, _| obj::read(bytes)),
        write: Some(obj::write),
        ..BASE
    },
    PLY,
    FormatRow { format: Format::PlyAscii, names: &["ply-ascii"], ..PLY },
    STL,
    FormatRow {
        format: Format::StlAscii,
        names: &["stl-ascii"],
        write: Some(|task, _| Ok(task.geometry_file(stl::write_text(&task.content)?))),
        ..STL
    },
    FormatRow {
        format: Format::Off,
        names: &["off"],
        attributes: StoredAttributes::None,
        read: Some(|bytes, _| off::read(bytes)),
        write: Some(|task, _| Ok(task.geometry_file(off::write(&task.content)))),
        ..BASE
    },
    GLTF,
    // A VRM is a GLB with extensions.
    FormatRow { format: Format::Glb, names: &["glb", "vrm"], ..GLTF },
    FormatRow {
        format: Format::ThreeMf,
        names: &["3mf"],
        attributes: StoredAttributes::Colours,
        #[cfg(feature = "3mf")]
        read: Some(|bytes, _| threemf::read(bytes)),
        #[cfg(feature = "3mf")]
        write: Some(threemf::write),
        no_reader: ["this build reads no 3MF", "build with the feature 3mf or convert the file"],
        no_writer: "this build writes no 3MF: build with the feature 3mf or choose another format",
        ..BASE
    },
    FormatRow {
        format: Format::Fbx,
        names: &["fbx"],
        #[cfg(feature = "fbx")]
        read: Some(|bytes, _| fbx::read(bytes)),
        no_reader: ["this build reads no FBX", "build with the feature fbx or convert the file"],
        no_writer: "fbx is not written: choose glb, which stores the same content",
        ..BASE
    },
];

impl FormatRow {
    pub fn read(&self, bytes: &[u8], fetch: &FileFetcher) -> Result<ReadMesh, ReadError> {
        let [problem, remedy] = self.no_reader;
        let read = self.read.ok_or_else(|| ReadError::file(problem, remedy))?;
        Ok(ReadMesh { format: Some(self.format), ..read(bytes, fetch)? })
    }

    pub fn read_geometry(&self, bytes: &[u8], fetch: &FileFetcher) -> Result<RawMesh, ReadError> {
        match self.read_geometry {
            Some(read) => read(bytes, fetch),
            None => Ok(RawMesh { attributes: Attributes::default(), ..self.read(bytes, fetch)?.mesh }),
        }
    }

    pub fn writer(&self) -> Result<Writer, WriteError> {
        self.write.ok_or_else(|| WriteError::new(self.no_writer))
    }
}

impl Format {
    /// Names that [`from_name`](Self::from_name) accepts, besides `vrm`.
    pub const NAMES: [&str; 10] = {
        let (mut names, mut i) = ([""; 10], 0);
        while i < names.len() {
            names[i] = TABLE[i].names[0];
            i += 1;
        }
        names
    };

    pub(super) fn row(self) -> &'static FormatRow {
        &TABLE[self as usize]
    }

    /// Returns whether the format stores single-precision coordinates without a local origin.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Format;
    /// assert!(Format::StlAscii.is_single_precision() && !Format::Ply.is_single_precision() && !Format::Glb.is_single_precision());
    /// ```
    pub fn is_single_precision(self) -> bool {
        self.row().precision == Precision::Single
    }

    /// Returns whether the format stores positions and faces only.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Format;
    /// assert!(Format::Off.is_bare() && Format::Stl.is_bare() && !Format::Obj.is_bare());
    /// ```
    pub fn is_bare(self) -> bool {
        self.row().attributes == StoredAttributes::None
    }

    /// Returns whether the format stores attributes of this role.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::{io::Format, mesh::Role};
    /// assert!(Format::Ply.holds(Role::Uv) && !Format::ThreeMf.holds(Role::Uv) && Format::ThreeMf.holds(Role::Colour));
    /// ```
    pub fn holds(self, role: Role) -> bool {
        match self.row().attributes {
            StoredAttributes::None => false,
            StoredAttributes::Colours => role == Role::Colour,
            StoredAttributes::All => true,
        }
    }

    /// Returns the format called `name`, in any case.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Format;
    /// assert_eq!(Format::from_name("PLY"), Some(Format::Ply));
    /// assert_eq!(Format::from_name("vrm"), Some(Format::Glb));
    /// assert_eq!(Format::from_name("doc"), None);
    /// ```
    pub fn from_name(name: &str) -> Option<Self> {
        let is_named = |row: &&FormatRow| row.names.iter().any(|other| other.eq_ignore_ascii_case(name));
        TABLE.iter().find(is_named).map(|row| row.format)
    }

    /// Returns the name that [`from_name`](Self::from_name) accepts.
    pub fn name(self) -> &'static str {
        self.row().names[0]
    }
}

/// Returns whether this build reads files of `format`.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::{Format, can_read};
/// assert!(can_read(Format::Ply));
/// ```
pub fn can_read(format: Format) -> bool {
    format.row().read.is_some()
}

/// Returns why this build cannot write `format`, or `None` if it can.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::{Format, write_obstacle};
/// assert_eq!(write_obstacle(Format::Ply), None);
/// ```
pub fn write_obstacle(format: Format) -> Option<&'static str> {
    let row = format.row();
    row.write.is_none().then_some(row.no_writer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back() {
        for row in &TABLE {
            assert_eq!(row.format.row().names, row.names);
            assert!(row.names.iter().all(|name| Format::from_name(name) == Some(row.format)));
        }
    }
}
