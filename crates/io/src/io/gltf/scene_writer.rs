//! Writing of an asset with simplified parts.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde_json::Value;

use super::Asset;
use super::accessor::{FLOAT, UNSIGNED_BYTE, UNSIGNED_SHORT};
use super::asset_part::AssetPart;
use super::draft::{Draft, NumberStorage, vector_shape};
use super::empty_nodes::{drop_meshes, remove_meshes};
use super::extensions::{drop_compression_extensions, drop_face_extensions, drop_unused_names, name_extension};
use super::files::{BufferPlace, files};
use super::levels;
use super::packed::{PrimitivePacking, QUANTIZATION, UvGrids, pack_as, undo_position_grids};
use super::primitive::{AttributeStorage, PrimitiveVertices, PrimitiveWriter};
use super::references::index;
use super::repack::{PackedBuffer, drop_unused};
use super::schema::{Primitive, Root};
use super::semantics::{role, target_role};
use super::simplified_part::SimplifiedPart;
use crate::io::{Format, ImageConverter, OutputFile, OutputFolder, Packing, WriteError};
use crate::mesh::{Attributes, Channel, PositionGrid, Role};

/// Largest number of bytes in unchanged views: the first times the bytes read, plus the second.
const REPEATS: (usize, usize) = (16, 1 << 26);

/// Options for writing a scene.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct SceneOptions<'a> {
    /// glTF or GLB.
    pub format: Format,
    /// Name of the glTF file.
    pub name: &'a str,
    /// Share of the screen's area down to which each level is drawn, or empty.
    pub coverage: &'a [f64],
    /// True to write levels as nodes `NAME_LOD0`, `NAME_LOD1` and so on under one node, without `MSFT_lod`.
    pub has_sibling_levels: bool,
    /// Packing, from [`Asset::packing`] for these levels.
    pub packing: Option<&'a Packing>,
    /// Converter of images.
    pub images: Option<&'a dyn ImageConverter>,
    /// Name of what several `.gltf` share: prefix of files for embedded images (`NAME_0.png`), and for levels by
    /// [`Asset::write_apart`] the buffer (`NAME.bin`).
    pub shared: Option<&'a str>,
    /// Folder of the results, if they are written to disk.
    pub folder: Option<&'a OutputFolder>,
}

impl<'a> SceneOptions<'a> {
    /// Makes options with a format and a name only.
    pub fn new(format: Format, name: &'a str) -> Self {
        Self {
            format,
            name,
            coverage: &[],
            has_sibling_levels: false,
            packing: None,
            images: None,
            shared: None,
            folder: None,
        }
    }
}

impl Asset {
    /// Writes the asset with a simplified part for each of [`parts`](Self::parts), in order; the file `name` comes
    /// first.
    ///
    /// JSON has its buffer in a separate file, unless the asset was a single JSON file.
    ///
    /// # Errors
    /// [`WriteError`] if parts are missing or do not fit, or the format cannot store the result.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Asset, Format, SimplifiedPart};
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let parts: Vec<SimplifiedPart> = asset.parts().iter().map(SimplifiedPart::from_part).collect();
    /// let files = asset.write(&parts, Format::Glb, "same.glb").unwrap();
    /// assert_eq!((files.len(), files[0].path.to_str()), (1, Some("same.glb")));
    /// ```
    pub fn write(
        &self,
        simplified: &[SimplifiedPart],
        format: Format,
        name: &str,
    ) -> Result<Vec<OutputFile>, WriteError> {
        self.write_levels(&[simplified], &[], format, name)
    }

    /// Writes levels of detail, the finest first (`MSFT_lod`); otherwise like [`write`](Self::write).
    ///
    /// `coverage` is that of [`SceneOptions`].
    ///
    /// # Errors
    /// As [`write`](Self::write), and without a level, or with another number of coverages.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Asset, Format, SimplifiedPart};
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let fine: Vec<SimplifiedPart> = asset.parts().iter().map(SimplifiedPart::from_part).collect();
    /// let mut coarse = fine.clone();
    /// coarse[0].faces.truncate(1);
    /// coarse[0].attributes.groups.truncate(1);
    /// let files = asset.write_levels(&[&fine, &coarse], &[0.5, 0.1], Format::Glb, "levels.glb").unwrap();
    /// assert!(String::from_utf8_lossy(&files[0].bytes).contains("MSFT_lod"));
    /// ```
    pub fn write_levels(
        &self,
        levels: &[&[SimplifiedPart]],
        coverage: &[f64],
        format: Format,
        name: &str,
    ) -> Result<Vec<OutputFile>, WriteError> {
        self.write_scene(levels, &SceneOptions { coverage, ..SceneOptions::new(format, name) })
    }

    /// Writes levels with all options; otherwise like [`write_levels`](Self::write_levels).
    ///
    /// # Errors
    /// As [`write_levels`](Self::write_levels).
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Asset, Format, SimplifiedPart, PackOptions, SceneOptions};
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let parts: Vec<SimplifiedPart> = asset.parts().iter().map(SimplifiedPart::from_part).collect();
    /// let (packing, _) = asset.packing(&[&parts], &PackOptions { bits: 14, compress: false });
    /// let mut options = SceneOptions::new(Format::Glb, "small.glb");
    /// options.packing = Some(&packing);
    /// let files = asset.write_scene(&[&parts], &options).unwrap();
    /// assert!(String::from_utf8_lossy(&files[0].bytes).contains("KHR_mesh_quantization"));
    /// ```
    pub fn write_scene(
        &self,
        levels: &[&[SimplifiedPart]],
        options: &SceneOptions,
    ) -> Result<Vec<OutputFile>, WriteError> {
        let layout = self.layout(options.format)?;
        let mut buffer = PackedBuffer::default();
        let (document, images) = self.write_document(levels, options, &mut buffer)?;
        files(document, &buffer.bytes, layout, (options.name, None, options.folder), &images)
    }

    /// Writes levels as separate scenes, each with its files as from [`write_scene`](Self::write_scene).
    ///
    /// With a `shared` name, JSON files with a buffer in a separate file have one buffer, in which equal bytes are once.
    ///
    /// # Errors
    /// As [`write_scene`](Self::write_scene), and with another number of names.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Asset, Format, SceneOptions, SimplifiedPart};
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let fine: Vec<SimplifiedPart> = asset.parts().iter().map(SimplifiedPart::from_part).collect();
    /// let mut options = SceneOptions::new(Format::Gltf, "");
    /// options.shared = Some("a");
    /// let written = asset.write_apart(&[&fine, &fine], &["a-0.gltf", "a-1.gltf"], &options).unwrap();
    /// assert_eq!(written[0][1], written[1][1]);
    /// assert_eq!(written[0][1].path.to_str(), Some("a.bin"));
    /// ```
    pub fn write_apart(
        &self,
        levels: &[&[SimplifiedPart]],
        names: &[&str],
        options: &SceneOptions,
    ) -> Result<Vec<Vec<OutputFile>>, WriteError> {
        let (n, expected) = (names.len(), levels.len());
        if n != expected {
            return Err(WriteError::new(format!("{n} names for {expected} levels: give one for each")));
        }
        let layout = self.layout(options.format)?;
        let Some(shared) = options.shared.filter(|_| layout == BufferPlace::Beside) else {
            let alone = |(level, name): (&&[SimplifiedPart], &&str)| {
                self.write_scene(&[*level], &SceneOptions { name, ..*options })
            };
            return levels.iter().zip(names).map(alone).collect();
        };
        let mut buffer = PackedBuffer::default();
        let documents = levels.iter().map(|level| self.write_document(&[*level], options, &mut buffer));
        // The buffer is complete only when all documents are.
        let documents: Vec<(Value, Vec<OutputFile>)> = documents.collect::<Result<_, _>>()?;
        let named = documents.into_iter().zip(names);
        let with_files = |((document, images), name): ((Value, Vec<OutputFile>), &&str)| {
            files(document, &buffer.bytes, layout, (name, Some(shared), options.folder), &images)
        };
        named.map(with_files).collect()
    }

    /// Makes the document of the levels and its images; adds what it needs to the buffer.
    fn write_document(
        &self,
        levels: &[&[SimplifiedPart]],
        options: &SceneOptions,
        buffer: &mut PackedBuffer,
    ) -> Result<(Value, Vec<OutputFile>), WriteError> {
        // All checks come before the first change of the draft.
        check_levels(levels, options.coverage)?;
        levels.iter().try_for_each(|simplified| self.check(simplified))?;
        let mut draft = self.draft();
        drop_compression_extensions(&mut draft.document);
        let root = &self.container.root;
        let of_uvs = |_: &Packing| UvGrids::of_asset(&self.document, root, &self.meshes, levels);
        let pack_with = ScenePacking { packing: options.packing, uvs: options.packing.map(of_uvs).unwrap_or_default() };
        let (mut coarser, mut grids) = (Vec::new(), BTreeMap::new());
        for (level, simplified) in levels.iter().enumerate() {
            let mut replaced = Vec::new();
            for (part, (simplified, &mesh)) in simplified.iter().zip(&self.meshes).enumerate() {
                let written = self.rewrite_mesh(&mut draft, part, simplified, &pack_with)?;
                // The finest level replaces the mesh; others are added.
                let place = if level == 0 {
                    draft.document["meshes"][mesh] = written;
                    mesh.into()
                } else {
                    draft.push("meshes", written)
                };
                grids.extend(index(&place).zip(pack_with.grid(part).copied()));
                replaced.push((mesh, place));
            }
            coarser.extend((level > 0).then_some(replaced));
        }
        let finest = levels.first().copied().unwrap_or_default();
        let emptied = self.emptied_meshes(finest);
        remove_meshes(&mut draft.document, &emptied);
        // Levels are added before grids are undone, so that their nodes get transforms as well.
        let coverage = (!options.has_sibling_levels).then_some(options.coverage);
        levels::add_levels(&mut draft, &coarser, coverage);
        self.undo_grids(&mut draft, &pack_with, &grids);
        drop_meshes(&mut draft.document, &emptied);
        let images = self.put_images(&mut draft, options);
        // Accessors are dropped last, when no more are added.
        drop_unused(&mut draft);
        drop_unused_names(&mut draft.document);
        let limit = buffer.bytes.len() + levels.iter().map(|simplified| self.limit(simplified)).sum::<usize>();
        pack_as(&mut draft, buffer, limit, options.packing)?;
        Ok((draft.document, images))
    }

    fn emptied_meshes(&self, simplified: &[SimplifiedPart]) -> Vec<usize> {
        // Lines and points of the mesh would still be drawn.
        let is_emptied = |(part, &mesh): (&SimplifiedPart, &usize)| {
            let described = self.container.root.meshes.get(mesh)?;
            let has_triangles = |it: &Primitive| it.triangle_positions().is_some();
            (part.faces.is_empty() && described.primitives.iter().all(has_triangles)).then_some(mesh)
        };
        simplified.iter().zip(&self.meshes).filter_map(is_emptied).collect()
    }

    fn undo_grids(&self, draft: &mut Draft, pack_with: &ScenePacking, grids: &BTreeMap<usize, PositionGrid>) {
        if pack_with.packing.is_some() {
            undo_position_grids(self, draft, grids);
            pack_with.uvs.undo(&mut draft.document, |material| material);
            name_extension(&mut draft.document, QUANTIZATION);
        }
    }

    fn layout(&self, format: Format) -> Result<BufferPlace, WriteError> {
        match format {
            Format::Glb => Ok(BufferPlace::Glb),
            Format::Gltf if self.is_embedded => Ok(BufferPlace::Embedded),
            Format::Gltf => Ok(BufferPlace::Beside),
            _ => Err(WriteError::new(format!("{} cannot store a scene: choose gltf or glb", format.name()))),
        }
    }

    fn check(&self, simplified: &[SimplifiedPart]) -> Result<(), WriteError> {
        let (n, expected) = (simplified.len(), self.parts().len());
        if n != expected {
            let what = format!("{n} meshes for {expected} meshes of the scene: give one for each");
            return Err(WriteError::new(what));
        }
        self.parts().iter().zip(simplified).try_for_each(|(part, simplified)| simplified.check(part))
    }

    fn draft(&self) -> Draft<'_> {
        let data = self.container.data();
        let views =
            (0..self.container.root.buffer_views.len()).map(|view| data.bytes(view).map(Cow::Borrowed)).collect();
        Draft { document: self.document.clone(), views }
    }

    fn limit(&self, simplified: &[SimplifiedPart]) -> usize {
        let n_read = self.container.buffers.n_bytes() + self.container.n_decompressed();
        // Each corner becomes at most a vertex, with four bytes per number, and an index.
        let of_part = |part: &SimplifiedPart| {
            let width: usize = part.attributes.channels.iter().map(|channel| channel.width).sum();
            3 * part.faces.len() * 4 * (width + 4)
        };
        REPEATS.0 * n_read + REPEATS.1 + simplified.iter().map(of_part).sum::<usize>()
    }

    fn rewrite_mesh(
        &self,
        draft: &mut Draft,
        part: usize,
        simplified: &SimplifiedPart,
        pack_with: &ScenePacking,
    ) -> Result<Value, WriteError> {
        let (root, mesh) = (&self.container.root, self.meshes[part]);
        let (part, grid) = (&self.parts()[part], pack_with.grid(part));
        let mut written = self.document["meshes"][mesh].clone();
        let Some(described) = root.meshes.get(mesh) else { return Ok(written) };
        let is_rewritten =
            |index: usize| described.primitives.get(index).is_some_and(|it| it.triangle_positions().is_some());
        // Groups are the primitives that the faces came from.
        let groups = faces_by_group(simplified);
        // A face cannot join a primitive of lines or points.
        if let Some(group) = groups.keys().find(|&&group| !is_rewritten(group as usize)) {
            let what =
                format!("{}: primitive {group} has no triangles: give each face the group of its original", part.name);
            return Err(WriteError::new(what));
        }
        let Some(Value::Array(old)) = written.get_mut("primitives").map(Value::take) else { return Ok(written) };
        let mut primitives = Vec::new();
        // A mesh must have a primitive: without faces it gets one degenerate triangle.
        let needs_stub = groups.is_empty() && (0..described.primitives.len()).all(is_rewritten);
        let stub = needs_stub.then(|| part.mesh.attributes.group(0));
        for (index, mut primitive) in old.into_iter().enumerate() {
            let old = &described.primitives[index];
            let packing = pack_with.primitive_packing(old, grid);
            if let Some(faces) = groups.get(&(index as u32)) {
                rewrite_primitive(draft, root, old, &mut primitive, (simplified, faces), packing);
            } else if stub == Some(index as u32) {
                rewrite_primitive(draft, root, old, &mut primitive, (&degenerate_part(part), &[0]), packing);
            } else if is_rewritten(index) {
                continue;
            }
            primitives.push(primitive);
        }
        written["primitives"] = Value::Array(primitives);
        drop_face_extensions(&mut written);
        Ok(written)
    }
}

impl SimplifiedPart {
    /// Returns the number of vertices in an uncompressed glTF: one per primitive and pair of vertex and wedge.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Asset, SimplifiedPart};
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// assert!(SimplifiedPart::from_part(&asset.parts()[0]).n_written_vertices() >= 4);
    /// ```
    pub fn n_written_vertices(&self) -> usize {
        faces_by_group(self).values().map(|faces| PrimitiveVertices::collect(self, faces).len()).sum()
    }

    /// Returns the number of vertices in a compressed glTF, which merges vertices with equal values.
    pub fn n_merged_vertices(&self) -> usize {
        faces_by_group(self)
            .values()
            .map(|faces| PrimitiveVertices::collect(self, faces).merge(self).reorder().len())
            .sum()
    }
}

struct ScenePacking<'a> {
    packing: Option<&'a Packing>,
    uvs: UvGrids,
}

impl ScenePacking<'_> {
    fn grid(&self, part: usize) -> Option<&PositionGrid> {
        self.packing?.grid(part)
    }

    fn primitive_packing<'a>(
        &'a self,
        primitive: &Primitive,
        grid: Option<&'a PositionGrid>,
    ) -> Option<PrimitivePacking<'a>> {
        let compress = self.packing?.is_compressed();
        Some(PrimitivePacking { grid, uvs: &self.uvs, surface: primitive.material, compress })
    }
}

fn check_levels(levels: &[&[SimplifiedPart]], coverage: &[f64]) -> Result<(), WriteError> {
    let is_share = |share: &f64| (0.0..=1.0).contains(share);
    let fits = coverage.is_empty() || coverage.len() == levels.len() && coverage.iter().all(is_share);
    if levels.is_empty() || !fits {
        return Err(WriteError::new("give at least one level, and for each a share of the screen from 0 to 1"));
    }
    Ok(())
}

pub(super) fn faces_by_group(part: &SimplifiedPart) -> BTreeMap<u32, Vec<u32>> {
    let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for face in 0..part.faces.len() as u32 {
        groups.entry(part.attributes.group(face)).or_default().push(face);
    }
    groups
}

fn degenerate_part(part: &AssetPart) -> SimplifiedPart {
    // A mesh needs a face to be valid, so it gets a degenerate one.
    let whole = SimplifiedPart::from_part(part);
    let position = whole.faces.first().map_or([0.0; 3], |face| whole.positions[face[0] as usize]);
    let row = |channel: Channel| {
        let wedge = whole.faces.first().map(|_| whole.wedges(0)[0]);
        let values = wedge.map_or(vec![0.0; channel.width], |wedge| channel.value(wedge).to_vec());
        Channel { values, ..channel }
    };
    let channels = part.mesh.attributes.channels.iter().cloned().map(row).collect();
    let groups = vec![part.mesh.attributes.group(0)];
    let attributes = Attributes { wedges: vec![[0; 3]], channels, groups };
    SimplifiedPart { positions: vec![position], faces: vec![[0; 3]], attributes }
}

fn rewrite_primitive(
    draft: &mut Draft,
    root: &Root,
    described: &Primitive,
    primitive: &mut Value,
    (part, faces): (&SimplifiedPart, &[u32]),
    packed: Option<PrimitivePacking>,
) {
    let vertices = PrimitiveVertices::for_packing(part, faces, packed);
    let mut writer = PrimitiveWriter { draft, part, vertices: &vertices, packed };
    primitive["attributes"] = writer.attributes(&attribute_storage(root, &described.attributes, role));
    if !described.targets.is_empty() {
        let targets: Vec<AttributeStorage> =
            described.targets.iter().map(|target| attribute_storage(root, target, target_role)).collect();
        primitive["targets"] = writer.targets(&targets);
    }
    primitive["indices"] = writer.indices();
    // Strips and fans become lists.
    if described.mode != 4 {
        primitive["mode"] = 4.into();
    }
    drop_face_extensions(primitive);
}

fn attribute_storage(
    root: &Root,
    attributes: &BTreeMap<String, usize>,
    role: fn(&str) -> (Role, Option<usize>),
) -> AttributeStorage {
    let stored = |(name, &accessor): (&String, &usize)| {
        let accessor = root.accessors.get(accessor)?;
        let shape = role(name).1.map_or(accessor.shape.as_str(), |width| vector_shape(width));
        // Morph targets often move few vertices, so sparse ones stay sparse.
        let floats = NumberStorage { sparse: accessor.sparse.is_some(), ..NumberStorage::floats(shape) };
        let original =
            NumberStorage { component: accessor.component_type, normalized: accessor.normalized, ..floats.clone() };
        // Byte and short colours are allowed by the specification, other types are not.
        let is_fraction = original.normalized && [UNSIGNED_BYTE, UNSIGNED_SHORT].contains(&original.component);
        // Standard attributes are single precision; integer colours and custom attributes keep their type.
        let stored = match role(name) {
            (Role::Colour, _) if !is_fraction => floats,
            (_, Some(_)) => floats,
            _ if accessor.shape.starts_with("MAT") || accessor.component_type == FLOAT => floats,
            _ => original,
        };
        Some((name.clone(), stored))
    };
    attributes.iter().filter_map(stored).collect()
}
