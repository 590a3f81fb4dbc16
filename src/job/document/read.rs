//! Reading of documents: cleaning, repair, selection of attributes.

use glam::DMat4;

use crate::io::{self, Asset, Folder, Format, ReadError, ReadMesh};
use crate::mesh::cleanup::{CleanCounts, CleanError, CleanOptions, Cleaned, clean};
use crate::mesh::{Attributes, Frame, RawMesh, Role, ScenePiece, UnitedMesh, snap};
use crate::repair::{fill_holes, printable};
use crate::simplify::Purpose;

use crate::job::choices::Ignored;
use crate::job::error::JobError;
use crate::job::request::{Job, Repair};
use crate::job::size::Bound;
use crate::job::textures::Textures;

use super::far_parts::{ScenePart, move_to_origins};
use super::{Document, Kind, PartPiece};

impl Document {
    /// Cleans a mesh, and repairs it if the job says so.
    ///
    /// # Errors
    /// [`JobError`] if no face is left or the job does not suit the mesh.
    pub fn from_mesh(read: ReadMesh, job: &Job) -> Result<Self, JobError> {
        let ReadMesh { mesh: mut raw, extra, notes, .. } = read;
        if job.arguments.bake.is_some() && extra.is_bent {
            let what =
                "--bake: a mesh with a skin or morph targets has more than one shape: simplify it without --bake";
            return Err(JobError::Options(what.into()));
        }
        weld_near(&mut raw, job, 1.0);
        let exact = (raw.double || job.keeps_positions() && has_decimals(&raw)).then(|| raw.positions.clone());
        let refused = |error: CleanError| match error {
            CleanError::NoFaces { .. } => refuse_faceless(job, &error.to_string()),
            other => JobError::Document(other.to_string()),
        };
        let cleaned = clean(raw, &clean_options(job)).map_err(refused)?;
        let (frame, counts) = (cleaned.frame, cleaned.counts);
        let kind = Kind::Mesh { cleaned: Box::new(cleaned), exact, extra };
        Self::from_kind(kind, (frame, counts), notes, job).check_images(job)?.repair_mesh(job)?.select_attributes(job)
    }

    /// Cleans each mesh of a glTF scene.
    ///
    /// # Errors
    /// As [`from_mesh`](Self::from_mesh).
    pub fn from_asset(asset: Asset, job: &Job) -> Result<Self, JobError> {
        Self::clean_asset(asset, job)?.repair_mesh(job)?.select_attributes(job)
    }

    /// Reads a document from the bytes of a file, which must not need companion files.
    ///
    /// `format` is needed if the bytes do not reveal it. A glTF that is written as glTF stays a scene.
    ///
    /// # Errors
    /// As [`from_mesh`](Self::from_mesh), and if the bytes are no mesh.
    pub fn from_bytes(bytes: &[u8], format: Option<Format>, job: &Job) -> Result<Self, JobError> {
        let refused = |error: ReadError| JobError::Document(error.to_string());
        if job.takes_scenes() && io::is_gltf(bytes) {
            return Self::from_asset(Asset::from_stream(bytes).map_err(refused)?, job);
        }
        Self::from_mesh(io::read_attributed(bytes, format).map_err(refused)?, job)
    }

    /// Reads a document from the bytes of the file `name`; its companion files are in `folder`.
    ///
    /// # Errors
    /// As [`from_bytes`](Self::from_bytes).
    pub fn from_bytes_in(bytes: &[u8], name: &str, folder: &Folder, job: &Job) -> Result<Self, JobError> {
        let refused = |error: ReadError| JobError::Document(error.to_string());
        if job.takes_scenes() && io::is_gltf(bytes) {
            return Self::from_asset(Asset::from_bytes_in(bytes, folder).map_err(refused)?, job);
        }
        Self::from_mesh(io::read_attributed_in(bytes, name, folder).map_err(refused)?, job)
    }

    fn clean_asset(mut asset: Asset, job: &Job) -> Result<Self, JobError> {
        let options = clean_options(job);
        let poses = if job.closed_options().purpose == Purpose::Poses { asset.poses() } else { Ok(Vec::new()) };
        let poses = poses.map_err(|error| JobError::Document(error.to_string()))?;
        let cleaned = |(i, part): (usize, &io::AssetPart)| {
            let mut raw = part.mesh.clone();
            raw.attributes.channels.extend(poses.get(i).into_iter().flatten().cloned());
            weld_near(&mut raw, job, part.scale);
            clean(raw, &options)
        };
        let mut parts: Vec<_> = asset.parts().iter().enumerate().map(cleaned).collect();
        let n_double_sided = show_lost_backs(&mut asset, &parts);
        let mut places = asset.part_transforms().map_err(|error| JobError::Document(error.to_string()))?;
        // Poses are in the parts' own coordinates.
        let pieces = list_pieces(&mut parts, &asset, &mut places, poses.is_empty());
        let mut counts = parts.iter().flatten().fold(CleanCounts::default(), |mut sum, part| {
            sum += part.counts;
            sum
        });
        let scaled = parts.iter().zip(asset.parts()).zip(&places).filter_map(|((cleaned, part), places)| {
            let cleaned = cleaned.as_ref().ok()?;
            Some(ScenePiece { mesh: &cleaned.mesh, attributes: &cleaned.attributes, scale: part.scale, places })
        });
        let scaled: Vec<ScenePiece> = scaled.collect();
        if scaled.is_empty() {
            return Err(refuse_faceless(job, "no triangles: a scene needs a mesh of triangles"));
        }
        let mut united = UnitedMesh::new(&scaled).ok_or_else(|| {
            JobError::Document(
                "has too many vertices, or a mesh scaled beyond single precision: split the scene, or scale it down"
                    .into(),
            )
        })?;
        counts.welded_vertices += if job.arguments.no_weld { 0 } else { united.join_touching_pieces() };
        let of_backs = (n_double_sided > 0).then(|| {
            format!("{n_double_sided} materials become double-sided, in place of faces for the back of others")
        });
        let notes = asset.notes().iter().cloned().chain(of_backs).collect();
        let kind = Kind::Scene { asset: Box::new(asset), united, pieces };
        Ok(Self::from_kind(kind, (Frame::default(), counts), notes, job))
    }

    fn from_kind(kind: Kind, (frame, counts): (Frame, CleanCounts), notes: Vec<String>, job: &Job) -> Self {
        let textures = job.arguments.textures.map(Textures::new);
        Self { frame, counts, notes, repaired: None, kind, progression: None, wanted: None, factors: None, textures }
    }

    // Only attributes that the job needs and the format can store are kept.
    fn select_attributes(mut self, job: &Job) -> Result<Self, JobError> {
        if job.format.is_bare() || job.arguments.bake.is_some() {
            self.wanted = Some(Attributes::default());
            return Ok(self);
        }
        let ignores = |what| job.arguments.ignore.contains(&what);
        if matches!(self.kind, Kind::Scene { .. }) && ignores(Ignored::Materials) {
            let what = "--ignore materials: the primitives of a scene cannot be merged: leave materials out, or write obj or ply";
            return Err(JobError::Options(what.into()));
        }
        let keeps = |role| match role {
            Role::Uv => !ignores(Ignored::Uv),
            Role::Normal => !ignores(Ignored::Normals),
            Role::Tangent => !ignores(Ignored::Uv) && !ignores(Ignored::Normals),
            Role::Colour => !ignores(Ignored::Colors),
            _ => true,
        };
        let is_scene = matches!(self.kind, Kind::Scene { .. });
        let held = |role| is_scene || job.format.holds(role);
        if !job.arguments.ignore.is_empty() || self.attributes().channels.iter().any(|channel| !held(channel.role)) {
            let keeps = |role| keeps(role) && held(role);
            self.wanted = Some(self.attributes().clone().keep_roles(keeps, !ignores(Ignored::Materials)));
        }
        Ok(self)
    }

    fn repair_mesh(mut self, job: &Job) -> Result<Self, JobError> {
        let repaired = match job.arguments.repair() {
            None => return Ok(self),
            Some(Repair::FillHoles(most_edges)) => fill_holes(self.mesh(), self.attributes(), most_edges),
            Some(Repair::Printable(size)) => {
                self.check_printable(job)?;
                let least_size = size.to_absolute(self.mesh().diagonal());
                printable(self.mesh(), self.attributes(), least_size)
                    .map_err(|error| JobError::Document(format!("--printable: {error}")))?
            }
        };
        self.repaired = Some(repaired.counts);
        match &mut self.kind {
            Kind::Mesh { cleaned, .. } => {
                cleaned.source = repaired.sources.iter().map(|&vertex| cleaned.source[vertex as usize]).collect();
                (cleaned.mesh, cleaned.attributes) = (repaired.mesh, repaired.attributes);
            }
            Kind::Scene { united, .. } => (united.mesh, united.attributes) = (repaired.mesh, repaired.attributes),
        }
        Ok(self)
    }

    // `--printable` makes one solid: scenes of several meshes, skins and morph targets have more than one shape.
    fn check_printable(&self, job: &Job) -> Result<(), JobError> {
        let of_scene = |kind: &Kind| matches!(kind, Kind::Scene { pieces, .. } if pieces.iter().flatten().count() > 1);
        if of_scene(&self.kind) {
            let what = "--printable: a scene of several meshes is not one solid: write stl, ply or obj";
            return Err(JobError::Options(what.into()));
        }
        let bends = |role| matches!(role, Role::Skin | Role::MorphPosition);
        let is_bent = self.attributes().channels.iter().any(|channel| bends(channel.role));
        if is_bent && !job.format.is_bare() {
            let what = "--printable: a mesh with a skin or morph targets has more than one shape: write stl";
            return Err(JobError::Options(what.into()));
        }
        Ok(())
    }
}

/// Numbers the parts that have faces, after those far from their origin were moved to it, if `may_move`.
fn list_pieces(
    parts: &mut [Result<Cleaned, CleanError>],
    asset: &Asset,
    places: &mut [Vec<DMat4>],
    may_move: bool,
) -> Vec<Option<PartPiece>> {
    let is_piece: Vec<bool> = parts.iter().map(Result::is_ok).collect();
    let of_scene = parts.iter_mut().zip(asset.parts()).zip(places).filter_map(|((cleaned, part), places)| {
        Some(ScenePart { cleaned: cleaned.as_mut().ok()?, scale: part.scale, places })
    });
    let mut of_scene: Vec<ScenePart> = of_scene.collect();
    let origins = if may_move { move_to_origins(&mut of_scene) } else { vec![[0.0; 3]; of_scene.len()] };
    let mut pieces = origins.into_iter().enumerate().map(|(number, origin)| PartPiece { number, origin });
    is_piece.into_iter().map(|is_piece| if is_piece { pieces.next() } else { None }).collect()
}

/// Makes materials double-sided whose faces lost their backs; returns their number.
fn show_lost_backs(asset: &mut Asset, parts: &[Result<Cleaned, CleanError>]) -> usize {
    let cleaned = parts.iter().enumerate().filter_map(|(part, cleaned)| Some((part, cleaned.as_ref().ok()?)));
    cleaned.map(|(part, cleaned)| asset.show_both_sides(part, &cleaned.lost_backs)).sum()
}

fn clean_options(job: &Job) -> CleanOptions {
    let mut options = CleanOptions::default();
    options.weld = !job.arguments.no_weld;
    options
}

/// Refuses a document without faces; names `--weld` if it is given.
fn refuse_faceless(job: &Job, what: &str) -> JobError {
    let of_weld = |bound| format!("--weld {bound}: no face is left: give a smaller distance");
    JobError::Document(job.arguments.weld.map_or_else(|| what.into(), of_weld))
}

/// Snaps vertices closer than [`Job::weld_near`]; `scale` is the mesh's scale in its scene.
fn weld_near(raw: &mut RawMesh, job: &Job, scale: f64) {
    if let Some(bound) = job.arguments.weld {
        let distance = match bound {
            Bound::Absolute(distance) => distance / scale,
            Bound::Percent(_) => bound.to_absolute(raw.diagonal()),
        };
        snap(&mut raw.positions, distance);
    }
}

/// Returns whether single precision would change a coordinate.
fn has_decimals(raw: &RawMesh) -> bool {
    raw.positions.iter().flatten().any(|&x| f64::from(x as f32) != x)
}
