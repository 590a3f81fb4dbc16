//! What is simplified and written again: a mesh with all that its file says, or the meshes of a glTF scene, as one.

mod images;
mod least;
mod named;

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use neural_mesh::io::{
    self, Asset, Extra, Format, ImageMaker, LighterPart, Model, OutputFile, PackOptions, Packing, ReadError, ReadMesh,
    SceneOptions, WriteError, WriteOptions,
};
use neural_mesh::mesh::cleanup::{CleanCounts, CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{
    Attributes, Channel, Frame, Grid, Looks, Piece, RawMesh, Role, TriMesh, United, longest_side, snap,
};
use neural_mesh::metrics::{QuickDistance, quick_distance};
use neural_mesh::picture::image_size;
use neural_mesh::repair::{RepairCounts, fill_holes, printable};
use neural_mesh::simplify::{self, Input, MirrorPlane, Purpose, Simplified, Symmetry, importance_of_channel};

use crate::args::IgnoreArg;
use crate::bound::Bound;
use crate::dress::Dress;
use crate::failure::Failure;
use crate::level_files::{level_files, shared_name};
use crate::names::{alone, is_vrm};
use crate::read::{asset, cleaned, parsed};
use crate::report::Dropped;
use crate::request::{Repair, Request, Source, check_packed};
use crate::textures::{self, Textures};

pub use named::listed;

/// A mesh, or the meshes of a scene side by side in one.
pub struct Subject {
    /// How coordinates lie in the file.
    pub frame: Frame,
    /// What was cleaned.
    pub counts: CleanCounts,
    /// What could not be kept, in one line each.
    pub notes: Vec<String>,
    /// What a repair did, where one was asked for.
    pub repaired: Option<RepairCounts>,
    kind: Kind,
    /// What of the attributes the result is to have, where that is not all.
    wanted: Option<Attributes>,
    /// How much each vertex counts as it was read, where the caller says so.
    factors: Option<Vec<f32>>,
    /// Who makes its textures smaller, where that is asked for.
    textures: Option<Textures>,
}

enum Kind {
    Mesh {
        cleaned: Box<Cleaned>,
        /// Positions in double precision, n_raw x 3, where the file has such, or decimals that are to stay.
        exact: Option<Vec<[f64; 3]>>,
        extra: Extra,
    },
    Scene {
        asset: Box<Asset>,
        united: United,
        /// For each part of the asset its piece of the united mesh; none where the part has no face that can be drawn.
        pieces: Vec<Option<usize>>,
    },
}

/// A mesh as people see it.
pub struct Seen<'a> {
    /// Its surface.
    pub mesh: Cow<'a, TriMesh>,
    /// What its corners and faces carry.
    pub attributes: Cow<'a, Attributes>,
}

/// Results that are to be written.
#[derive(Default)]
pub struct Meshes<'a> {
    /// One, or the levels of detail of a scene.
    pub results: Vec<&'a Simplified>,
    /// Shares of the screen down to which these are meant to be drawn.
    pub coverage: Vec<f64>,
    /// What the result wears in place of what it has of the original.
    pub dress: Option<&'a Dress>,
    /// How the numbers of a glTF are packed, where they are.
    pub packing: Option<&'a Packing>,
}

/// A result as files.
#[derive(Default)]
pub struct Files {
    /// The mesh.
    pub bytes: Vec<u8>,
    /// What belongs beside it.
    pub beside: Vec<OutputFile>,
    /// What the format does not hold, in one line each.
    pub notes: Vec<String>,
    /// Vertices of each result as the file has them, where it has such.
    pub n_vertices: Vec<Option<usize>>,
}

impl Files {
    /// Bytes of the mesh, with those of the buffer that a JSON has beside it.
    pub fn n_bytes(&self) -> usize {
        let buffers = self.beside.iter().filter(|file| file.path.extension().is_some_and(|ending| ending == "bin"));
        self.bytes.len() + buffers.map(|file| file.bytes.len()).sum::<usize>()
    }
}

impl Subject {
    /// Reads and cleans what the request names. A glTF that is written as glTF is taken as the scene that it is.
    pub fn open(request: &Request) -> Result<Self, Failure> {
        let source = &request.source;
        if source.is_scene(request.output_format) {
            return Self::scene(asset(source)?, request)?.repaired(request)?.wanting(request);
        }
        Self::of(parsed(source, io::read_attributed, io::read_attributed_path)?, request)
    }

    /// As [`open`](Self::open); where the request leaves the format open, it is that of the input from now on.
    pub fn follow(request: &mut Request) -> Result<Self, Failure> {
        if request.follows_input && request.source.is_gltf() {
            (request.output_format, request.follows_input) = (alone(Some(Format::Gltf)), false);
        }
        if !request.follows_input {
            return Self::open(request);
        }
        let read = parsed(&request.source, io::read_attributed, io::read_attributed_path)?;
        request.output_format = alone(read.format);
        request.compress.map_or(Ok(()), |_| check_packed(request.output_format))?;
        request.textures.map_or(Ok(()), |_| textures::check(request.output_format))?;
        Self::of(read, request)
    }

    /// Cleans a mesh that is read.
    pub fn of(read: ReadMesh, request: &Request) -> Result<Self, Failure> {
        let source = &request.source;
        let ReadMesh { mesh: mut raw, extra, notes, .. } = read;
        if request.bake.is_some() && extra.is_bent {
            let what =
                "--bake: a mesh with a skin or morph targets has more than one shape: simplify it without --bake";
            return Err(Failure::Usage(what.into()));
        }
        weld_near(&mut raw, source, 1.0);
        let exact = (raw.double || keeps_positions(request) && has_decimals(&raw)).then(|| raw.positions.clone());
        let cleaned = cleaned(raw, source)?;
        let (frame, counts) = (cleaned.frame, cleaned.counts);
        let kind = Kind::Mesh { cleaned: Box::new(cleaned), exact, extra };
        let textures = request.textures.map(Textures::new);
        Self { frame, counts, notes, repaired: None, kind, wanted: None, factors: None, textures }
            .decoded(request)?
            .repaired(request)?
            .wanting(request)
    }

    /// The same, held back by nothing that the result does not need or its format does not hold.
    fn wanting(mut self, request: &Request) -> Result<Self, Failure> {
        self.check_vrm(request)?;
        if request.output_format.is_bare() || request.bake.is_some() {
            self.wanted = Some(Attributes::default());
            return Ok(self);
        }
        let ignores = |what| request.ignore.contains(&what);
        if matches!(self.kind, Kind::Scene { .. }) && ignores(IgnoreArg::Materials) {
            let what =
                "--ignore materials: the primitives of a scene stay apart: leave materials out, or write obj or ply";
            return Err(Failure::Usage(what.into()));
        }
        let keeps = |role| match role {
            Role::Uv => !ignores(IgnoreArg::Uv),
            Role::Normal => !ignores(IgnoreArg::Normals),
            Role::Tangent => !ignores(IgnoreArg::Uv) && !ignores(IgnoreArg::Normals),
            Role::Colour => !ignores(IgnoreArg::Colors),
            _ => true,
        };
        let is_scene = matches!(self.kind, Kind::Scene { .. });
        let held = |role| is_scene || request.output_format.holds(role);
        if !request.ignore.is_empty() || self.attributes().channels.iter().any(|channel| !held(channel.role)) {
            let keeps = |role| keeps(role) && held(role);
            self.wanted = Some(self.attributes().clone().only(keeps, !ignores(IgnoreArg::Materials)));
        }
        Ok(self)
    }

    /// Refuses the name of a VRM for what is none: programs that read it need to know the bones.
    fn check_vrm(&self, request: &Request) -> Result<(), Failure> {
        let has = |name| matches!(&self.kind, Kind::Scene { asset, .. } if asset.has_extension(name));
        match request.output.as_deref().filter(|path| is_vrm(path)) {
            Some(path) if !has("VRM") && !has("VRMC_vrm") => {
                Err(Failure::Usage(format!("{}: the mesh is no VRM: end the name in .glb", path.display())))
            }
            _ => Ok(()),
        }
    }

    /// The same, with its holes filled, or made a solid, where the request asks for that.
    fn repaired(mut self, request: &Request) -> Result<Self, Failure> {
        let repaired = match request.repair {
            None => return Ok(self),
            Some(Repair::FillHoles(most_edges)) => fill_holes(self.mesh(), self.attributes(), most_edges),
            Some(Repair::Printable(size)) => {
                self.check_printable(request)?;
                let least_size = size.over(self.mesh().diagonal());
                printable(self.mesh(), self.attributes(), least_size)
                    .map_err(|error| Failure::of(&request.source.path, format!("--printable: {error}")))?
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

    /// Refuses what has more than one shape: the meshes of a scene, which its nodes place, and what a skin or targets bend.
    fn check_printable(&self, request: &Request) -> Result<(), Failure> {
        let of_scene = |kind: &Kind| matches!(kind, Kind::Scene { pieces, .. } if pieces.iter().flatten().count() > 1);
        if of_scene(&self.kind) {
            let what = "--printable: a scene of several meshes is no one solid: write stl, ply or obj";
            return Err(Failure::Usage(what.into()));
        }
        let bends = |role| matches!(role, Role::Skin | Role::MorphPosition);
        let is_bent = self.attributes().channels.iter().any(|channel| bends(channel.role));
        if is_bent && !request.output_format.is_bare() {
            let what = "--printable: a mesh with a skin or morph targets has more than one shape: write stl";
            return Err(Failure::Usage(what.into()));
        }
        Ok(())
    }

    fn scene(asset: Asset, request: &Request) -> Result<Self, Failure> {
        let source = &request.source;
        let mut options = CleanOptions::default();
        options.weld = source.weld;
        let poses = if request.options.purpose == Purpose::Poses { asset.poses() } else { Ok(Vec::new()) };
        let poses = poses.map_err(|error| Failure::of(&source.path, error))?;
        let cleaned = |(i, part): (usize, &io::Part)| {
            let mut raw = part.mesh.clone();
            raw.attributes.channels.extend(poses.get(i).into_iter().flatten().cloned());
            weld_near(&mut raw, source, part.scale);
            clean(raw, &options)
        };
        let parts: Vec<_> = asset.parts().iter().enumerate().map(cleaned).collect();
        let (mut n_pieces, mut counts) = (0, CleanCounts::default());
        let mut pieces = Vec::new();
        for part in &parts {
            pieces.push(part.is_ok().then_some(n_pieces));
            n_pieces += usize::from(part.is_ok());
            part.iter().for_each(|part| counts += part.counts);
        }
        let places = asset.places().map_err(|error| Failure::of(&source.path, error))?;
        let scaled = parts.iter().zip(asset.parts()).zip(&places).filter_map(|((cleaned, part), places)| {
            let cleaned = cleaned.as_ref().ok()?;
            Some(Piece { mesh: &cleaned.mesh, attributes: &cleaned.attributes, scale: part.scale, places })
        });
        let scaled: Vec<Piece> = scaled.collect();
        if scaled.is_empty() {
            return Err(Failure::of(&source.path, "no triangles: a scene needs a mesh of triangles"));
        }
        let united = United::new(&scaled).ok_or_else(|| {
            Failure::of(&source.path, "its meshes are too many or too far apart in size: split the scene")
        })?;
        let (notes, kind) = (asset.notes().to_vec(), Kind::Scene { asset: Box::new(asset), united, pieces });
        let (frame, textures) = (Frame::default(), request.textures.map(Textures::new));
        Ok(Self { frame, counts, notes, repaired: None, kind, wanted: None, factors: None, textures })
    }

    /// How coordinates lie in the file that is written, in its own numbers: an STL holds singles.
    pub fn written_frame(&self, request: &Request) -> Frame {
        Frame { double: self.frame.double && !request.output_format.is_single(), ..self.frame }
    }

    /// How far the file that is written may round a vertex: an STL far from the origin does.
    pub fn rounding(&self, request: &Request) -> f64 {
        let frame = self.written_frame(request);
        if frame.double || frame.origin == [0.0; 3] {
            return 0.0;
        }
        let reach = |p: &[f32; 3]| frame.to_file(*p).into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let reach = self.mesh().positions().iter().map(reach).fold(0.0, f64::max);
        0.5 * 3f64.sqrt() * f64::from(f32::EPSILON) * reach
    }

    /// The diagonal of the box of the mesh, of a scene where a viewer sees it.
    pub fn diagonal(&self) -> f64 {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => cleaned.mesh.diagonal(),
            Kind::Scene { united, .. } => united.diagonal(),
        }
    }

    /// Puts the mesh, or what became of it, where a viewer sees it.
    fn view_of<'a>(&self, mesh: &'a TriMesh, attributes: &Attributes) -> Cow<'a, TriMesh> {
        match &self.kind {
            Kind::Mesh { .. } => Cow::Borrowed(mesh),
            Kind::Scene { united, .. } => Cow::Owned(united.view(mesh, attributes).mesh),
        }
    }

    /// Whether it is a glTF scene that stays one.
    pub fn is_scene(&self) -> bool {
        matches!(self.kind, Kind::Scene { .. })
    }

    /// The mesh, or all of them.
    pub fn mesh(&self) -> &TriMesh {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => &cleaned.mesh,
            Kind::Scene { united, .. } => &united.mesh,
        }
    }

    /// What its corners and faces carry.
    pub fn attributes(&self) -> &Attributes {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => &cleaned.attributes,
            Kind::Scene { united, .. } => &united.attributes,
        }
    }

    /// The names of materials, groups and objects that the file has for groups of faces, and which groups these are.
    pub fn group_names(&self) -> Vec<(String, u32)> {
        match &self.kind {
            Kind::Mesh { extra, .. } => {
                let names = |group: &io::Group| [&group.material, &group.name, &group.object].map(Option::clone);
                let named = extra.groups.iter().zip(0..).flat_map(|(group, i)| names(group).map(|name| (name, i)));
                named.filter_map(|(name, i)| Some((name?, i))).collect()
            }
            Kind::Scene { asset, united, pieces } => {
                let parts = asset.parts().iter().zip(pieces).filter_map(|(part, piece)| Some((part, (*piece)?)));
                let named = parts.flat_map(|(part, piece)| part.materials.iter().zip(united.first_group(piece)..));
                named.map(|(name, group)| (name.clone(), group)).collect()
            }
        }
    }

    /// Names the components that a result lacks: by the mesh of a scene, or the object, and the material.
    pub fn dropped(&self, report: &simplify::Report) -> Vec<Dropped> {
        let name = |face: u32| {
            let group = self.attributes().group(face);
            match &self.kind {
                Kind::Mesh { extra, .. } => extra.groups.get(group as usize).map_or_else(String::new, |group| {
                    named(group.object.as_ref().or(group.name.as_ref()), group.material.as_ref())
                }),
                Kind::Scene { asset, united, pieces } => {
                    let piece = united.piece_of(group);
                    let part = pieces.iter().position(|of_part| *of_part == Some(piece));
                    part.map_or_else(String::new, |part| {
                        let part = &asset.parts()[part];
                        named(Some(&part.name), part.materials.get((group - united.first_group(piece)) as usize))
                    })
                }
            }
        };
        let dropped = |component: &simplify::DroppedComponent| {
            let name = Some(name(component.face)).filter(|name| !name.is_empty());
            let name = name.unwrap_or_else(|| format!("the one of face {}", component.face));
            Dropped { name, faces: component.n_faces }
        };
        report.dropped.iter().map(dropped).collect()
    }

    /// What the groups of its faces look like; beside it what could not be had of that, in one line each.
    pub fn looks(&self, allow_outside: bool) -> (Looks, Vec<String>) {
        match &self.kind {
            Kind::Mesh { extra, .. } => io::looks(extra, allow_outside),
            Kind::Scene { asset, .. } => asset.scene_looks(),
        }
    }

    /// So many texels as a share of the side of its largest texture of colours, or of 1024 texels where it has none.
    pub fn share_of_texture(&self, texels: f64, request: &Request) -> f64 {
        let (looks, _) = self.looks(request.allow_outside);
        let textures = looks.of_groups.iter().filter_map(|look| look.texture.as_ref());
        let side = textures.filter_map(|texture| image_size(&texture.image)).flatten().max();
        (texels / side.map_or(1024.0, |side| side as f64)).min(1.0)
    }

    /// The original and a result as people see them: the meshes of a scene where its nodes place them, around an origin that
    /// both share.
    pub fn seen(&self, result: &Simplified) -> Result<[Seen<'_>; 2], ReadError> {
        let Kind::Scene { asset, united, pieces } = &self.kind else {
            let result =
                Seen { mesh: Cow::Owned(result.mesh.clone()), attributes: Cow::Owned(result.attributes.clone()) };
            return Ok([
                Seen { mesh: Cow::Borrowed(self.mesh()), attributes: Cow::Borrowed(self.attributes()) },
                result,
            ]);
        };
        let before = (&united.mesh, &united.attributes);
        let mut origin = None;
        let mut seen = |(mesh, attributes): (&TriMesh, &Attributes)| {
            let parts = lighter_parts(asset, united, pieces, mesh, attributes);
            let meshes: Vec<RawMesh> = parts.into_iter().map(as_raw).collect();
            let mut scene = asset.placed(&meshes)?;
            if scene.faces.is_empty() {
                // No node places a mesh: they are seen as they are.
                return Ok(Seen { mesh: Cow::Owned(mesh.clone()), attributes: Cow::Owned(Attributes::default()) });
            }
            let origin = *origin.get_or_insert(scene.positions.first().copied().unwrap_or_default());
            scene.positions.iter_mut().flatten().zip(origin.into_iter().cycle()).for_each(|(x, from)| *x -= from);
            scene.double = false;
            let cleaned = clean(scene, &CleanOptions::default());
            let (mesh, attributes) = cleaned.map_or_else(|_| Default::default(), |it| (it.mesh, it.attributes));
            Ok(Seen { mesh: Cow::Owned(mesh), attributes: Cow::Owned(attributes) })
        };
        Ok([seen(before)?, seen((&result.mesh, &result.attributes))?])
    }

    /// What the simplifier is given.
    pub fn input<'a>(&'a self, importance: &'a [f32], kept: &'a [bool]) -> Input<'a> {
        let mut input = Input::bare(self.mesh());
        input.attributes = self.wanted.as_ref().unwrap_or(self.attributes());
        (input.importance, input.kept) = (importance, kept);
        input.scene = self.united();
        input
    }

    /// Returns what the simplifier is given of what corners and faces carry, with the groups of the faces.
    pub fn attributes_with_groups(&self) -> Attributes {
        let all = self.attributes();
        let wanted = self.wanted.as_ref().unwrap_or(all).clone();
        Attributes { groups: all.groups.clone(), ..wanted }
    }

    /// The meshes of the scene, where it is one.
    pub fn united(&self) -> Option<&United> {
        match &self.kind {
            Kind::Mesh { .. } => None,
            Kind::Scene { united, .. } => Some(united),
        }
    }

    /// The plane of a symmetry, as it lies in the mesh: that of a scene's only mesh is in the coordinates of that mesh.
    pub fn symmetry(&self, symmetry: Symmetry) -> Result<Symmetry, Failure> {
        let Kind::Scene { united, pieces, .. } = &self.kind else { return Ok(symmetry) };
        if pieces.iter().flatten().count() > 1 {
            let what = "--symmetric: a scene of several meshes has no single plane: give a file for each";
            return Err(Failure::Usage(what.into()));
        }
        Ok(match symmetry {
            Symmetry::Plane(MirrorPlane { axis, at }) => {
                Symmetry::Plane(MirrorPlane { axis, at: at * united.scale(0) })
            }
            other => other,
        })
    }

    /// The plane of a result, as it lies in the file.
    pub fn plane_of_file(&self, plane: MirrorPlane) -> MirrorPlane {
        match &self.kind {
            Kind::Mesh { .. } => plane,
            Kind::Scene { united, .. } => MirrorPlane { at: plane.at / united.scale(0), ..plane },
        }
    }

    /// The same, with how much each vertex counts as it was read.
    pub fn weighed(self, factors: Option<Vec<f32>>) -> Self {
        Self { factors, ..self }
    }

    /// How much the vertices count, n_vertices, where the caller says so; nothing within where that is no importance.
    pub fn importance(&self) -> Option<Option<Vec<f32>>> {
        let (factors, sources) = (self.factors.as_ref()?, self.file_vertices()?);
        let values: Option<Vec<f32>> = sources.iter().map(|&vertex| factors.get(vertex as usize).copied()).collect();
        Some(values.and_then(|values| {
            let channel = Channel { name: String::new(), role: Role::Other, width: 1, values };
            let attributes = Attributes { wedges: self.mesh().faces().to_vec(), ..Attributes::default() };
            importance_of_channel(self.mesh(), &attributes, &channel)
        }))
    }

    /// Where the vertices of a result lie in the file, in double precision, where that has such.
    pub fn exact_positions(&self, result: &Simplified, request: &Request) -> Option<Vec<[f64; 3]>> {
        if !self.frame.double {
            return None;
        }
        let framed = |local: &[f32; 3]| self.frame.to_file(*local);
        let Kind::Mesh { cleaned, exact: Some(positions), .. } = &self.kind else {
            return Some(result.mesh.positions().iter().map(framed).collect());
        };
        let kept = in_place(positions, cleaned, result, request).unwrap_or_default();
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

    /// The vertex of the file that each vertex was read from; for a scene, whose vertices are those of its primitives, none.
    pub fn file_vertices(&self) -> Option<&[u32]> {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => Some(&cleaned.source),
            Kind::Scene { .. } => None,
        }
    }

    /// Results as the files of a format; `file_name` is what the mesh file will be called.
    pub fn written(
        &self,
        Meshes { results, coverage, dress, packing }: &Meshes,
        request: &Request,
        file_name: &str,
    ) -> Result<Files, WriteError> {
        match &self.kind {
            Kind::Mesh { cleaned, exact, extra } => {
                let Some(result) = results.first() else { return Ok(Files::default()) };
                let exact = exact.as_ref().and_then(|positions| in_place(positions, cleaned, result, request));
                let attributes = dress.map_or(&result.attributes, |dress| &dress.attributes);
                let mut model = Model::new(&result.mesh, self.frame, attributes, extra);
                model.exact = exact;
                let mut options = WriteOptions::new(request.output_format, library_name(request, file_name));
                (options.allow_outside, options.packing) = (request.allow_outside, packing.cloned());
                (options.images, options.shares_images) = (self.textures(), shared_name(request).is_some());
                self.mesh_files(model, *dress, &options, request)
            }
            Kind::Scene { asset, united, pieces } => {
                let lighter =
                    |result: &&Simplified| lighter_parts(asset, united, pieces, &result.mesh, &result.attributes);
                let levels: Vec<Vec<LighterPart>> = results.iter().map(lighter).collect();
                let mut options = SceneOptions::new(request.output_format, file_name);
                (options.coverage, options.packing, options.images) = (coverage, *packing, self.textures());
                let are_files = level_files(request).is_some_and(|paths| paths.len() > 1);
                let shared = shared_name(request).filter(|_| are_files);
                options.shared_images = shared.as_deref();
                let files = scene_files(asset, &levels, &options)?;
                Ok(Files { notes: self.textures.iter().filter_map(Textures::note).collect(), ..files })
            }
        }
    }

    /// A mesh that is no scene as files, under the names that it is to have.
    fn mesh_files(
        &self,
        model: Model,
        dress: Option<&Dress>,
        options: &WriteOptions,
        request: &Request,
    ) -> Result<Files, WriteError> {
        let (extra, mut model): (&Extra, Model) = (model.extra, model);
        let dropped = io::geometry_only(options.format, self.attributes(), extra);
        let mut nameless = Extra::default();
        nameless.unit.clone_from(&extra.unit);
        let is_nameless = request.ignore.contains(&IgnoreArg::Materials) || options.format.is_bare();
        model.extra = dress.map_or(if is_nameless { &nameless } else { extra }, |dress| &dress.extra);
        let said = dropped.as_ref().and_then(|_| io::geometry_only(options.format, model.attributes, model.extra));
        let written = io::write_attributed(&model, options)?;
        let others = written.notes.into_iter().filter(|note| said.as_ref() != Some(note));
        let kept = self.textures.as_ref().and_then(Textures::note);
        let notes = dropped.into_iter().chain(others).chain(kept).collect();
        Ok(Files { bytes: written.bytes, beside: written.beside, notes, n_vertices: vec![written.n_vertices] })
    }

    fn textures(&self) -> Option<&dyn ImageMaker> {
        self.textures.as_ref().map(|textures| textures as &dyn ImageMaker)
    }

    /// How the numbers of results, the levels of one, are packed in a glTF; beside it what cannot be, in one line each.
    pub fn packing(
        &self,
        results: &[&Simplified],
        request: &Request,
        options: &PackOptions,
    ) -> Result<(Packing, Vec<String>), WriteError> {
        match &self.kind {
            Kind::Mesh { cleaned, exact, .. } => {
                let (frame, attributes, extra) = (self.frame, Attributes::NONE, &Extra::default());
                let mut models = Vec::new();
                for result in results {
                    let exact = exact.as_ref().and_then(|positions| in_place(positions, cleaned, result, request));
                    let mut model = Model::new(&result.mesh, frame, attributes, extra);
                    model.exact = exact;
                    models.push(model);
                }
                let (packing, note) = io::packing(&models, options)?;
                Ok((packing, note.into_iter().collect()))
            }
            Kind::Scene { asset, united, pieces } => {
                let lighter =
                    |result: &&Simplified| lighter_parts(asset, united, pieces, &result.mesh, &result.attributes);
                let levels: Vec<Vec<LighterPart>> = results.iter().map(lighter).collect();
                let levels: Vec<&[LighterPart]> = levels.iter().map(Vec::as_slice).collect();
                Ok(asset.packing(&levels, options))
            }
        }
    }

    /// How far a packing of so many bits may move vertices of results no farther than `error` from the original.
    pub fn packed_rounding(&self, bits: u32, error: f64) -> f64 {
        let longest = match &self.kind {
            Kind::Mesh { cleaned, .. } => longest_side(cleaned.mesh.positions().iter().map(|p| p.map(f64::from))),
            Kind::Scene { asset, united, pieces } => {
                let sides = asset.packing_sides().into_iter().zip(pieces);
                let scaled = sides.filter_map(|(side, piece)| {
                    let piece = (*piece)?;
                    Some(side * united.scale(piece) * united.stretch(piece))
                });
                scaled.fold(0.0, f64::max)
            }
        };
        // Steps are in single precision.
        let step = (longest + 2.0 * error) / f64::from((1u32 << bits) - 1) * (1.0 + 1e-6);
        Grid { origin: [0.0; 3], step }.rounding()
    }

    /// Measures how far a result, as it is packed, is from the original; of a scene all of it, where a viewer sees it. `None` where
    /// nothing is seen of one of the two.
    pub fn distance(&self, result: &Simplified, packing: Option<&Packing>, n_samples: usize) -> Option<QuickDistance> {
        let packed = match &self.kind {
            Kind::Mesh { .. } => {
                let around = if self.frame.double { [0.0; 3] } else { self.frame.origin };
                on_grid(&result.mesh, packing.and_then(|packing| packing.grid(0)), around)
            }
            Kind::Scene { united, pieces, .. } => on_grids(result, united, pieces, packing),
        };
        let original = self.view_of(self.mesh(), self.attributes());
        quick_distance(&original, &self.view_of(&packed, &result.attributes), n_samples, 0)
    }
}

/// A result with the vertices of each piece on the grid of its part, where it has one.
fn on_grids<'a>(
    result: &'a Simplified,
    united: &United,
    pieces: &[Option<usize>],
    packing: Option<&Packing>,
) -> Cow<'a, TriMesh> {
    let Some(packing) = packing else { return Cow::Borrowed(&result.mesh) };
    let mut positions = result.mesh.positions().to_vec();
    let mut grid_of = vec![None; pieces.iter().flatten().count()];
    for (part, piece) in pieces.iter().enumerate().filter_map(|(part, piece)| Some((part, (*piece)?))) {
        grid_of[piece] = packing.grid(part);
    }
    for (face, f) in result.mesh.faces().iter().zip(0..) {
        let piece = united.piece_of(result.attributes.group(f));
        let (Some(grid), scale) = (grid_of[piece], united.scale(piece)) else { continue };
        for &v in face {
            let own = result.mesh.positions()[v as usize].map(|x| f64::from(x) / scale);
            positions[v as usize] = grid.point(grid.round(own)).map(|x| (x * scale) as f32);
        }
    }
    TriMesh::new(positions, result.mesh.faces().to_vec()).map_or(Cow::Borrowed(&result.mesh), Cow::Owned)
}

/// `door (oak)`, as far as there are names.
fn named(object: Option<&String>, material: Option<&String>) -> String {
    match (object, material) {
        (Some(object), Some(material)) => format!("{object} ({material})"),
        (object, material) => object.or(material).cloned().unwrap_or_default(),
    }
}

/// What a library of materials is called: as the file, or as all levels of detail, which share it.
fn library_name(request: &Request, file_name: &str) -> String {
    shared_name(request)
        .unwrap_or_else(|| Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy().into_owned())
}

/// An asset with lighter parts, level by level, as files.
fn scene_files(asset: &Asset, levels: &[Vec<LighterPart>], options: &SceneOptions) -> Result<Files, WriteError> {
    let parts: Vec<&[LighterPart]> = levels.iter().map(Vec::as_slice).collect();
    let mut files = asset.write_scene(&parts, options)?;
    let beside = files.split_off(1.min(files.len()));
    let bytes = files.pop().map(|file| file.bytes).unwrap_or_default();
    let is_merged = options.packing.is_some_and(Packing::is_compressed);
    let n_of = if is_merged { LighterPart::n_merged_vertices } else { LighterPart::n_written_vertices };
    let n_written = |parts: &Vec<LighterPart>| parts.iter().map(n_of).sum();
    let n_vertices = levels.iter().map(|parts| Some(n_written(parts))).collect();
    Ok(Files { bytes, beside, notes: Vec::new(), n_vertices })
}

/// What became of each part of an asset when all of them became one mesh with these attributes.
fn lighter_parts(
    asset: &Asset,
    united: &United,
    pieces: &[Option<usize>],
    mesh: &TriMesh,
    attributes: &Attributes,
) -> Vec<LighterPart> {
    let split = united.split(mesh, attributes);
    let lighter = |(part, piece): (_, &Option<usize>)| match piece.and_then(|piece| split.get(piece)) {
        Some((mesh, attributes)) => {
            LighterPart::new(mesh.positions().to_vec(), mesh.faces().to_vec(), attributes.clone())
        }
        None => LighterPart::of(part),
    };
    asset.parts().iter().zip(pieces).map(lighter).collect()
}

/// A mesh with its vertices on a grid that counts from `around`, where there is one.
fn on_grid<'a>(mesh: &'a TriMesh, grid: Option<&Grid>, around: [f64; 3]) -> Cow<'a, TriMesh> {
    let Some(grid) = grid else { return Cow::Borrowed(mesh) };
    let rounded = |p: &[f32; 3]| {
        let place = grid.point(grid.round(std::array::from_fn(|axis| f64::from(p[axis]) + around[axis])));
        std::array::from_fn(|axis| (place[axis] - around[axis]) as f32)
    };
    let moved = TriMesh::new(mesh.positions().iter().map(rounded).collect(), mesh.faces().to_vec());
    moved.map_or(Cow::Borrowed(mesh), Cow::Owned)
}

/// A part as a mesh in its own coordinates.
fn as_raw(part: LighterPart) -> RawMesh {
    let LighterPart { positions, faces, attributes, .. } = part;
    let positions = positions.into_iter().map(|position| position.map(f64::from)).collect();
    let mut raw = RawMesh::new(positions, faces);
    raw.attributes = attributes;
    raw
}

/// Moves vertices onto others where the source says that they become one; `scale` is how large the mesh is drawn.
fn weld_near(raw: &mut RawMesh, source: &Source, scale: f64) {
    if let Some(bound) = source.weld_near {
        let distance = match bound {
            Bound::Absolute(distance) => distance / scale,
            Bound::Percent(_) => bound.over(raw.diagonal()),
        };
        snap(&mut raw.positions, distance);
    }
}

/// Whether positions of the input are promised to stay as they are.
fn keeps_positions(request: &Request) -> bool {
    request.options.subset || holds_places(request)
}

/// Whether some vertices of the input are held in their places: those of boundaries or of what is kept.
fn holds_places(request: &Request) -> bool {
    request.options.lock_boundaries || !request.keep.is_empty() || !request.shares.is_empty()
}

/// Whether a coordinate is no single one: decimals that stand for one are another number to a reader in doubles.
fn has_decimals(raw: &RawMesh) -> bool {
    raw.positions.iter().flatten().any(|&x| f64::from(x as f32) != x)
}

/// The input's own positions of the result's vertices: where each is one of the input's, or of those that lie where one of
/// the input does if some are held there. A mirrored result has images of its own and keeps none.
fn in_place(
    positions: &[[f64; 3]],
    cleaned: &Cleaned,
    result: &Simplified,
    request: &Request,
) -> Option<Vec<Option<[f64; 3]>>> {
    let origin = cleaned.frame.origin;
    let is_at = |p: &[f64; 3], place: &[f32; 3]| (0..3).all(|axis| (p[axis] - origin[axis]) as f32 == place[axis]);
    // What a repair has moved stays where it is now.
    let position = |vertex: u32, place: &[f32; 3]| {
        let own = positions.get(*cleaned.source.get(vertex as usize)? as usize).copied();
        own.filter(|own| is_at(own, place))
    };
    if let Some(sources) = &result.source_vertices {
        return Some(
            sources.iter().zip(result.mesh.positions()).map(|(&vertex, place)| position(vertex, place)).collect(),
        );
    }
    if !holds_places(request) || request.options.symmetric.is_some() {
        return None;
    }
    let mut vertex_at: HashMap<[u32; 3], u32> = HashMap::new();
    let key = |position: &[f32; 3]| position.map(|x| (x + 0.0).to_bits());
    for (position, vertex) in cleaned.mesh.positions().iter().zip(0..) {
        vertex_at.entry(key(position)).or_insert(vertex);
    }
    let here = |place: &[f32; 3]| vertex_at.get(&key(place)).and_then(|&vertex| position(vertex, place));
    Some(result.mesh.positions().iter().map(here).collect())
}
