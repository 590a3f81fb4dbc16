//! Results as the bytes of files.

use std::collections::HashMap;
use std::path::Path;

use crate::io::{
    self, Asset, Extra, FilesRead, Folder, ImageConverter, Model, OutputFile, OutputFolder, PackOptions, Packing,
    SceneOptions, SimplifiedPart, WriteError, WriteOptions,
};
use crate::mesh::cleanup::Cleaned;
use crate::mesh::{Attributes, Frame, PositionGrid, PositionKey, TriMesh, UnitedMesh, longest_side, position_key};
use crate::simplify::Simplified;

use crate::job::baked_material::BakedMaterial;
use crate::job::files::{Files, Meshes};
use crate::job::request::Job;
use crate::job::textures::Textures;

use super::flat_level::flat_files;
use super::godot::godot_script;
use super::mesh_levels::{MeshLevels, kept_extra};
use super::{Document, Kind, PartPiece};

impl Document {
    /// Returns the frame of the written file, with `double` unset for single-precision formats.
    pub fn written_frame(&self, job: &Job) -> Frame {
        Frame { double: self.frame.double && !job.format.is_single_precision(), ..self.frame }
    }

    /// Returns the largest distance by which writing moves a vertex; 0 for doubles or without a local origin.
    pub fn rounding(&self, job: &Job) -> f64 {
        let frame = self.written_frame(job);
        if frame.double || frame.origin == [0.0; 3] {
            return 0.0;
        }
        let reach = |p: &[f32; 3]| frame.to_file(*p).into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let reach = self.mesh().positions().iter().map(reach).fold(0.0, f64::max);
        0.5 * 3f64.sqrt() * f64::from(f32::EPSILON) * reach
    }

    /// Returns the result's positions in double precision, or `None` if the file stores no doubles.
    pub fn exact_positions(&self, result: &Simplified, job: &Job) -> Option<Vec<[f64; 3]>> {
        if !self.frame.double {
            return None;
        }
        let framed = |local: &[f32; 3]| self.frame.to_file(*local);
        let Kind::Mesh { cleaned, exact: Some(positions), .. } = &self.kind else {
            return Some(result.mesh.positions().iter().map(framed).collect());
        };
        let kept = unmoved_positions(positions, cleaned, result, job).unwrap_or_default();
        let kept = kept.into_iter().chain(std::iter::repeat(None));
        Some(
            result
                .mesh
                .positions()
                .iter()
                .zip(kept)
                .map(|(local, kept)| kept.unwrap_or_else(|| framed(local)))
                .collect(),
        )
    }

    /// Returns the files on disk that were read for this document so far.
    pub fn files_read(&self) -> FilesRead {
        match &self.kind {
            Kind::Mesh { extra, .. } => extra.folder.as_ref().map(Folder::files_read).unwrap_or_default(),
            Kind::Scene { asset, .. } => asset.files_read().clone(),
        }
    }

    fn output_folder(&self, job: &Job) -> Option<OutputFolder> {
        // The files inside a progression may also be in the folder, unread.
        let keeps_all = job.names.keeps_all || self.progression.is_some();
        Some(OutputFolder { path: job.names.folder.clone()?, read: self.files_read(), keeps_all })
    }

    /// Writes results in the job's format; `file_name` is the name of the mesh file.
    pub fn to_files(&self, meshes: &Meshes, job: &Job, file_name: &str) -> Result<Files, WriteError> {
        let Meshes { results, baked, packing, .. } = meshes;
        match &self.kind {
            Kind::Mesh { cleaned, exact, extra } => {
                if let Some(MeshLevels { asset, levels, notes }) = self.mesh_levels(results, job)? {
                    let mut files = self.scene_of_levels(&asset, &levels, meshes, (job, file_name))?;
                    files.notes.splice(0..0, notes);
                    return Ok(files);
                }
                let Some(result) = results.first() else { return Ok(Files::default()) };
                let exact = exact.as_ref().and_then(|positions| unmoved_positions(positions, cleaned, result, job));
                let attributes = baked.map_or(&result.attributes, |baked| &baked.attributes);
                let mut model = Model::new(&result.mesh, self.frame, attributes, extra);
                model.exact = exact;
                let mut options = WriteOptions::new(job.format, library_name(job, file_name));
                (options.allow_outside, options.packing) = (job.arguments.allow_outside, packing.cloned());
                (options.images, options.shares_images) = (self.textures(), job.names.shared.is_some());
                options.folder = self.output_folder(job);
                self.mesh_files(model, *baked, &options, job)
            }
            Kind::Scene { asset, united, pieces } => {
                let split_parts =
                    |result: &&Simplified| simplified_parts(asset, united, pieces, &result.mesh, &result.attributes);
                // Only progressions of scenes have levels in other formats.
                if let Some(result) = results.first().filter(|_| self.progression.is_some() && !job.takes_scenes()) {
                    return flat_files(asset, (split_parts(result), result), job, file_name);
                }
                let levels: Vec<Vec<SimplifiedPart>> = results.iter().map(split_parts).collect();
                self.scene_of_levels(asset, &levels, meshes, (job, file_name))
            }
        }
    }

    fn scene_of_levels(
        &self,
        asset: &Asset,
        levels: &[Vec<SimplifiedPart>],
        meshes: &Meshes,
        (job, file_name): (&Job, &str),
    ) -> Result<Files, WriteError> {
        let folder = self.output_folder(job);
        let options = self.scene_options(meshes, job, (file_name, folder.as_ref()));
        let mut files = scene_files(asset, levels, &options)?;
        files.notes.extend(self.textures.iter().filter_map(Textures::note));
        files.companion_files.extend(godot_script(meshes, job, (file_name, folder.as_ref())));
        Ok(files)
    }

    /// Writes results as one file each, named by the job; scenes share a separate buffer.
    pub fn to_files_apart(&self, meshes: &Meshes, job: &Job) -> Result<Vec<Files>, WriteError> {
        let Kind::Scene { asset, united, pieces } = &self.kind else { return self.to_single_files(meshes, job) };
        if !job.takes_scenes() {
            return self.to_single_files(meshes, job);
        }
        let split_parts =
            |result: &&Simplified| simplified_parts(asset, united, pieces, &result.mesh, &result.attributes);
        let levels: Vec<Vec<SimplifiedPart>> = meshes.results.iter().map(split_parts).collect();
        let parts: Vec<&[SimplifiedPart]> = levels.iter().map(Vec::as_slice).collect();
        let names: Vec<&str> = (0..levels.len()).map(|number| job.names.file(number)).collect();
        let folder = self.output_folder(job);
        let options = self.scene_options(meshes, job, ("", folder.as_ref()));
        let written = asset.write_apart(&parts, &names, &options)?.into_iter().zip(&levels);
        let notes: Vec<String> = self.textures.iter().filter_map(Textures::note).collect();
        Ok(written
            .map(|(files, level)| Files {
                notes: notes.clone(),
                ..to_files_of_scene(files, std::slice::from_ref(level), options.packing)
            })
            .collect())
    }

    fn to_single_files(&self, meshes: &Meshes, job: &Job) -> Result<Vec<Files>, WriteError> {
        let alone = |(number, result): (usize, &&Simplified)| {
            let (baked, packing) = (meshes.baked, meshes.packing);
            self.to_files(
                &Meshes { results: vec![result], baked, packing, ..Meshes::default() },
                job,
                job.names.file(number),
            )
        };
        meshes.results.iter().enumerate().map(alone).collect()
    }

    fn scene_options<'a>(
        &'a self,
        meshes: &'a Meshes,
        job: &'a Job,
        (name, folder): (&'a str, Option<&'a OutputFolder>),
    ) -> SceneOptions<'a> {
        let mut options = SceneOptions::new(job.format, name);
        (options.coverage, options.packing, options.images) = (&meshes.coverage, meshes.packing, self.textures());
        options.has_sibling_levels = job.has_sibling_levels();
        options.shared = job.names.shared.as_deref().filter(|_| job.names.are_several());
        options.folder = folder;
        options
    }

    fn mesh_files(
        &self,
        model: Model,
        baked: Option<&BakedMaterial>,
        options: &WriteOptions,
        job: &Job,
    ) -> Result<Files, WriteError> {
        let (extra, mut model): (&Extra, Model) = (model.extra, model);
        let dropped = io::describe_losses(options.format, self.attributes(), extra);
        let kept = kept_extra(extra, job);
        model.extra = baked.map_or(&kept, |baked| &baked.extra);
        let said = dropped.as_ref().and_then(|_| io::describe_losses(options.format, model.attributes, model.extra));
        let written = io::write_attributed(&model, options)?;
        let others = written.notes.into_iter().filter(|note| said.as_ref() != Some(note));
        let kept = self.textures.as_ref().and_then(Textures::note);
        let notes = dropped.into_iter().chain(others).chain(kept).collect();
        Ok(Files {
            bytes: written.bytes,
            companion_files: written.companion_files,
            notes,
            n_vertices: vec![written.n_vertices],
        })
    }

    pub(super) fn textures(&self) -> Option<&dyn ImageConverter> {
        self.textures.as_ref().map(|textures| textures as &dyn ImageConverter)
    }

    /// Chooses one packing for all results; notes name unpacked meshes.
    pub fn packing(
        &self,
        results: &[&Simplified],
        job: &Job,
        options: &PackOptions,
    ) -> Result<(Packing, Vec<String>), WriteError> {
        match &self.kind {
            Kind::Mesh { cleaned, exact, .. } => {
                if let Some(MeshLevels { asset, levels, .. }) = self.mesh_levels(results, job)? {
                    let levels: Vec<&[SimplifiedPart]> = levels.iter().map(Vec::as_slice).collect();
                    return Ok(asset.packing(&levels, options));
                }
                let (frame, attributes, extra) = (self.frame, Attributes::NONE, &Extra::default());
                let mut models = Vec::new();
                for result in results {
                    let exact = exact.as_ref().and_then(|positions| unmoved_positions(positions, cleaned, result, job));
                    let mut model = Model::new(&result.mesh, frame, attributes, extra);
                    model.exact = exact;
                    models.push(model);
                }
                let (packing, note) = io::packing(&models, options)?;
                Ok((packing, note.into_iter().collect()))
            }
            Kind::Scene { asset, united, pieces } => {
                let split_parts =
                    |result: &&Simplified| simplified_parts(asset, united, pieces, &result.mesh, &result.attributes);
                let levels: Vec<Vec<SimplifiedPart>> = results.iter().map(split_parts).collect();
                let levels: Vec<&[SimplifiedPart]> = levels.iter().map(Vec::as_slice).collect();
                Ok(asset.packing(&levels, options))
            }
        }
    }

    /// Returns the largest distance by which packing with `bits` moves a vertex of a result within `error` of the
    /// original.
    pub fn packed_rounding(&self, bits: u32, error: f64) -> f64 {
        let longest = match &self.kind {
            Kind::Mesh { cleaned, .. } => longest_side(cleaned.mesh.positions().iter().map(|p| p.map(f64::from))),
            Kind::Scene { asset, united, pieces } => {
                let sides = asset.packing_sides().into_iter().zip(pieces);
                let scaled = sides.filter_map(|(side, piece)| {
                    let piece = (*piece)?.number;
                    Some(side * united.scale(piece) * united.stretch(piece))
                });
                scaled.fold(0.0, f64::max)
            }
        };
        // Steps are stored in single precision, so the last factor rounds up.
        let step = (longest + 2.0 * error) / f64::from((1u32 << bits) - 1) * (1.0 + 1e-6);
        PositionGrid { origin: [0.0; 3], step }.rounding()
    }
}

/// Returns the name of the material library: the file's, or the one that all levels share.
pub(super) fn library_name(job: &Job, file_name: &str) -> String {
    let shared = job.names.shared.clone();
    shared.unwrap_or_else(|| Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy().into_owned())
}

pub(super) fn scene_files(
    asset: &Asset,
    levels: &[Vec<SimplifiedPart>],
    options: &SceneOptions,
) -> Result<Files, WriteError> {
    let parts: Vec<&[SimplifiedPart]> = levels.iter().map(Vec::as_slice).collect();
    Ok(to_files_of_scene(asset.write_scene(&parts, options)?, levels, options.packing))
}

fn to_files_of_scene(mut files: Vec<OutputFile>, levels: &[Vec<SimplifiedPart>], packing: Option<&Packing>) -> Files {
    let companion_files = files.split_off(1.min(files.len()));
    let bytes = files.pop().map(|file| file.bytes).unwrap_or_default();
    let is_merged = packing.is_some_and(Packing::is_compressed);
    let n_of = if is_merged { SimplifiedPart::n_merged_vertices } else { SimplifiedPart::n_written_vertices };
    let n_written = |parts: &Vec<SimplifiedPart>| parts.iter().map(n_of).sum();
    let n_vertices = levels.iter().map(|parts| Some(n_written(parts))).collect();
    Files { bytes, companion_files, notes: Vec::new(), n_vertices }
}

/// Splits a version of the united mesh into the parts of the asset.
pub(super) fn simplified_parts(
    asset: &Asset,
    united: &UnitedMesh,
    pieces: &[Option<PartPiece>],
    mesh: &TriMesh,
    attributes: &Attributes,
) -> Vec<SimplifiedPart> {
    let split = united.split(mesh, attributes);
    let split_parts = |(part, piece): (_, &Option<PartPiece>)| {
        let Some(PartPiece { number, origin }) = *piece else { return SimplifiedPart::from_part(part) };
        let Some((mesh, attributes)) = split.get(number) else { return SimplifiedPart::from_part(part) };
        let own = |p: &[f32; 3]| std::array::from_fn(|axis| p[axis] + origin[axis]);
        // Adding zero would turn -0 into 0.
        let is_moved = origin != [0.0; 3];
        let positions = mesh.positions().iter().map(|p| if is_moved { own(p) } else { *p }).collect();
        SimplifiedPart::new(positions, mesh.faces().to_vec(), attributes.clone())
    };
    asset.parts().iter().zip(pieces).map(split_parts).collect()
}

/// Returns for each output vertex its exact input position, or `None` if it moved.
///
/// The whole list is `None` if it is unknown which vertices moved.
fn unmoved_positions(
    positions: &[[f64; 3]],
    cleaned: &Cleaned,
    result: &Simplified,
    job: &Job,
) -> Option<Vec<Option<[f64; 3]>>> {
    let origin = cleaned.frame.origin;
    let is_at = |p: &[f64; 3], place: &[f32; 3]| (0..3).all(|axis| (p[axis] - origin[axis]) as f32 == place[axis]);
    // Vertices moved by a repair keep their new position.
    let position = |vertex: u32, place: &[f32; 3]| {
        let own = positions.get(*cleaned.source.get(vertex as usize)? as usize).copied();
        own.filter(|own| is_at(own, place))
    };
    if let Some(sources) = &result.source_vertices {
        return Some(
            sources.iter().zip(result.mesh.positions()).map(|(&vertex, place)| position(vertex, place)).collect(),
        );
    }
    if !job.keeps_unmoved_positions() {
        return None;
    }
    let mut vertex_at: HashMap<PositionKey, u32> = HashMap::new();
    for (&position, vertex) in cleaned.mesh.positions().iter().zip(0..) {
        vertex_at.entry(position_key(position)).or_insert(vertex);
    }
    let here = |place: &[f32; 3]| vertex_at.get(&position_key(*place)).and_then(|&vertex| position(vertex, place));
    Some(result.mesh.positions().iter().map(here).collect())
}
