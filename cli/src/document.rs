//! The document that a request names, from its file or from standard input.

use neural_mesh::io::{self, Format};
use neural_mesh::job::Document;

use crate::failure::Failure;
use crate::names::{alone, is_vrm};
use crate::read::{asset, parsed};
use crate::request::Request;

/// Reads and cleans what a request names. A glTF that is written as glTF is taken as the scene that it is; where the request leaves the
/// format open, it is that of the input from now on.
pub fn open(request: &mut Request) -> Result<Document, Failure> {
    if request.follows_input && request.source.is_gltf() {
        follow(request, Some(Format::Gltf))?;
    }
    let document = if !request.follows_input && request.source.is_scene(request.job.format) {
        Document::from_asset(asset(&request.source)?, &request.job)
    } else {
        let read = parsed(&request.source, io::read_attributed, io::read_attributed_path)?;
        if request.follows_input {
            follow(request, read.format)?;
        }
        Document::from_mesh(read, &request.job)
    };
    let document = document.map_err(|error| request.failure(error))?;
    check_vrm(&document, request)?;
    Ok(document)
}

/// The result has the format of the input.
pub fn follow(request: &mut Request, format: Option<Format>) -> Result<(), Failure> {
    (request.job.format, request.follows_input) = (alone(format), false);
    request.name_files();
    request.job.check_format().map_err(|error| request.failure(error))
}

/// Refuses the name of a VRM for what is none: programs that read it need to know the bones.
fn check_vrm(document: &Document, request: &Request) -> Result<(), Failure> {
    match request.output.as_deref().filter(|path| is_vrm(path)) {
        Some(path) if !document.has_extension("VRM") && !document.has_extension("VRMC_vrm") => {
            Err(Failure::Usage(format!("{}: the mesh is no VRM: end the name in .glb", path.display())))
        }
        _ => Ok(()),
    }
}
