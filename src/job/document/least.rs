//! Smallest possible size of a glTF file.

use std::collections::BTreeSet;

use crate::io::{
    self, Asset, Extra, Format, ImageConverter, ImageUse, Model, SceneOptions, SimplifiedPart, WriteError, WriteOptions,
};
use crate::mesh::{Attributes, TriMesh};

use super::write::{library_name, scene_files};
use super::{Document, Kind};
use crate::job::error::JobError;
use crate::job::request::Job;
use crate::job::textures::Textures;

// Texture sides that the advice may name, largest first.
const SIDES: [usize; 7] = [2048, 1024, 512, 256, 128, 64, 32];

// Converter to empty images, by which the bytes besides images are measured.
#[derive(Debug)]
struct NoImages;

impl ImageConverter for NoImages {
    fn convert(&self, _: &[u8], _: ImageUse) -> Option<Vec<u8>> {
        Some(Vec::new())
    }
}

impl Document {
    /// Rejects a glTF of `n_bytes` whose images alone take more, with advice.
    pub fn check_bytes(&self, n_bytes: usize, job: &Job, file_name: &str) -> Result<(), JobError> {
        if !matches!(job.format, Format::Gltf | Format::Glb) {
            return Ok(());
        }
        let refused = |error: WriteError| JobError::Document(error.to_string());
        let least = |images: Option<&dyn ImageConverter>| self.least_bytes(images, job, file_name).map_err(refused);
        let n_least = least(self.textures())?;
        if n_least <= n_bytes {
            return Ok(());
        }
        // What is not of images may go with its materials.
        let n_images = n_least.saturating_sub(least(Some(&NoImages))?);
        if n_images <= n_bytes {
            return Ok(());
        }
        let mut smaller = SIDES.into_iter().filter(|side| job.arguments.textures.is_none_or(|now| *side < now));
        // Half of the bytes are left for the shape.
        let fits = |side: &usize| least(Some(&Textures::new(*side))).is_ok_and(|n| 2 * n <= n_bytes);
        let advice = match smaller.find(fits) {
            Some(side) => format!("make images smaller with --textures {side}, or allow more bytes"),
            None => "allow more bytes".into(),
        };
        let what = format!("--size {n_bytes}: images alone take {n_images} bytes: {advice}");
        Err(JobError::Document(what))
    }

    /// Returns the bytes of the file with one face per material.
    fn least_bytes(
        &self,
        images: Option<&dyn ImageConverter>,
        job: &Job,
        file_name: &str,
    ) -> Result<usize, WriteError> {
        match &self.kind {
            Kind::Mesh { extra, .. } => {
                let (mesh, attributes) = self.least_mesh();
                self.least_of_mesh(&mesh, &attributes, extra, (images, job, file_name))
            }
            Kind::Scene { asset, .. } => least_of_scene(asset, images, job, file_name),
        }
    }

    /// Returns a face of each group of a mesh, with its attributes.
    pub(super) fn least_mesh(&self) -> (TriMesh, Attributes) {
        let (mesh, attributes) = (self.mesh(), self.wanted_attributes());
        let first = first_faces(&attributes.groups, mesh.faces().len());
        let faces = first.iter().map(|&face| mesh.faces()[face as usize]).collect();
        let least = TriMesh::new(mesh.positions().to_vec(), faces).unwrap_or_default();
        (least, attributes.clone().select_faces(&first).unwrap_or_default())
    }

    fn wanted_attributes(&self) -> &Attributes {
        self.wanted.as_ref().unwrap_or(self.attributes())
    }

    fn least_of_mesh(
        &self,
        mesh: &TriMesh,
        attributes: &Attributes,
        extra: &Extra,
        (images, job, file_name): (Option<&dyn ImageConverter>, &Job, &str),
    ) -> Result<usize, WriteError> {
        let model = Model::new(mesh, self.frame, attributes, extra);
        let mut options = WriteOptions::new(job.format, library_name(job, file_name));
        (options.allow_outside, options.images) = (job.arguments.allow_outside, images);
        io::write_attributed(&model, &options).map(|written| written.bytes.len())
    }
}

fn least_of_scene(
    asset: &Asset,
    images: Option<&dyn ImageConverter>,
    job: &Job,
    file_name: &str,
) -> Result<usize, WriteError> {
    let least = |part| {
        let SimplifiedPart { positions, faces, attributes, .. } = SimplifiedPart::from_part(part);
        let first = first_faces(&attributes.groups, faces.len());
        let faces = first.iter().map(|&face| faces[face as usize]).collect();
        SimplifiedPart::new(positions, faces, attributes.select_faces(&first).unwrap_or_default())
    };
    let parts: Vec<SimplifiedPart> = asset.parts().iter().map(least).collect();
    let packing = job.arguments.packing().map(|options| asset.packing(&[&parts], &options).0);
    let mut options = SceneOptions::new(job.format, file_name);
    (options.packing, options.images) = (packing.as_ref(), images);
    scene_files(asset, &[parts], &options).map(|files| files.n_bytes(job.format))
}

fn first_faces(groups: &[u32], n_faces: usize) -> Vec<u32> {
    let mut seen = BTreeSet::new();
    let group = |face: u32| groups.get(face as usize).copied().unwrap_or_default();
    (0..n_faces as u32).filter(|&face| seen.insert(group(face))).collect()
}
