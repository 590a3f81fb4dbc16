//! Reading of a request's input.

use neural_mesh::io::{self, Format};
use neural_mesh::job::{Document, format_of_progression};
use neural_mesh::simplify::Progression;

use crate::failure::Failure;
use crate::files;
use crate::names::{is_progression_name, is_vrm, single_file_format};
use crate::read::{parse_source, read_asset};
use crate::request::Request;

/// Reads and cleans the input of a request; a glTF written as glTF stays a scene.
///
/// An output format not yet known becomes that of the input.
pub fn open(request: &mut Request) -> Result<Document, Failure> {
    if is_progression_name(&request.source.path) {
        return open_progression(request);
    }
    if request.takes_input_format && request.source.is_gltf() {
        // A glTF scene becomes a GLB, since standard output takes a single file.
        set_input_format(request, Some(Format::Gltf))?;
    }
    // A glTF written as glTF stays a scene; all else becomes one mesh.
    let document = if !request.takes_input_format && request.source.is_scene(request.job.format) {
        Document::from_asset(read_asset(&request.source)?, &request.job)
    } else {
        let read = parse_source(&request.source, io::read_attributed, io::read_attributed_path)?;
        if request.takes_input_format {
            set_input_format(request, read.format)?;
        }
        Document::from_mesh(read, &request.job)
    };
    let document = document.map_err(|error| request.failure(error))?;
    check_vrm(&document, request)?;
    Ok(document)
}

pub fn set_input_format(request: &mut Request, format: Option<Format>) -> Result<(), Failure> {
    (request.job.format, request.takes_input_format) = (single_file_format(format), false);
    request.name_files();
    request.job.check_format().map_err(|error| request.failure(error))
}

/// Rejects an output name in .vrm for other meshes, since readers of VRM need its bones.
fn check_vrm(document: &Document, request: &Request) -> Result<(), Failure> {
    match request.output.as_deref().filter(|path| is_vrm(path)) {
        Some(path) if !document.has_extension("VRM") && !document.has_extension("VRMC_vrm") => {
            Err(Failure::Usage(format!("{}: the mesh is not a VRM scene: end the name in .glb", path.display())))
        }
        _ => Ok(()),
    }
}

/// Opens the document of the progression that a request names as input.
fn open_progression(request: &mut Request) -> Result<Document, Failure> {
    let path = request.source.path.clone();
    let progression = Progression::from_bytes(&files::read(&path)?).map_err(|error| Failure::in_file(&path, error))?;
    if request.takes_input_format {
        set_input_format(request, format_of_progression(&progression))?;
    }
    Document::from_progression(progression, &request.job).map_err(|error| request.failure(error))
}
