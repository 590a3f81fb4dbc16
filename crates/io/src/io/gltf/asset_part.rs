//! Meshes of an asset, in their own coordinates.

use std::collections::BTreeMap;

use super::accessor::{Data, FLOAT};
use super::refusals::spend;
use super::schema::{GltfMesh, Primitive, Root};
use super::semantics::{SKIN, is_own_channel, n_skin_sets, role, target_channel, target_of, target_role};
use super::triangles;
use crate::io::ReadError;
use crate::io::extra::replace_non_finite;
use crate::mesh::{Attributes, Channel, RawMesh, Role};

/// Mesh of a glTF asset that has triangles.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AssetPart {
    /// Name in the file, or `mesh N`.
    pub name: String,
    /// Triangles; wedges are the file's vertices, groups its primitives.
    pub mesh: RawMesh,
    /// Material name of each primitive, or `primitive N`.
    pub materials: Vec<String>,
    /// Largest scale at which nodes show the mesh; 1 for skinned and unplaced meshes.
    pub scale: f64,
}

pub(super) fn read(
    data: &Data,
    mesh: &GltfMesh,
    budget: &mut usize,
    n_not_finite: &mut usize,
) -> Result<Option<RawMesh>, ReadError> {
    // All primitives share the channels, so these are collected first.
    let channels = channels(data, mesh.primitives.iter().filter(|it| it.triangle_positions().is_some()))?;
    let (mesh, n) = read_primitives(data, mesh, channels, budget)?;
    *n_not_finite += n;
    Ok(Some(mesh).filter(|mesh| !mesh.faces.is_empty()))
}

pub(super) fn read_geometry(data: &Data, mesh: &GltfMesh, budget: &mut usize) -> Result<RawMesh, ReadError> {
    Ok(read_primitives(data, mesh, Vec::new(), budget)?.0)
}

/// Reads a mesh; also returns the number of attribute values that are not finite and become 0.
fn read_primitives(
    data: &Data,
    mesh: &GltfMesh,
    channels: Vec<Channel>,
    budget: &mut usize,
) -> Result<(RawMesh, usize), ReadError> {
    let mut builder = PartBuilder::new(data, channels);
    for (index, primitive) in mesh.primitives.iter().enumerate() {
        builder.add(index as u32, primitive, budget)?;
    }
    Ok((builder.mesh, builder.n_not_finite))
}

pub(super) fn materials(root: &Root, mesh: &GltfMesh) -> Vec<String> {
    let name = |primitive: &Primitive| root.materials.get(primitive.material?)?.name.clone();
    let named = |(index, primitive)| name(primitive).unwrap_or_else(|| format!("primitive {index}"));
    mesh.primitives.iter().enumerate().map(named).collect()
}

fn channels<'a>(data: &Data, primitives: impl Iterator<Item = &'a Primitive>) -> Result<Vec<Channel>, ReadError> {
    let (mut own, mut n_sets, mut targets) = (BTreeMap::new(), 0, BTreeMap::new());
    for primitive in primitives {
        n_sets = n_sets.max(n_skin_sets(primitive));
        for (name, &accessor) in primitive.attributes.iter().filter(|(name, _)| is_own_channel(name)) {
            let (role, width) = role(name);
            // Labels must not be blended, so they have a role of their own.
            let role = if role == Role::Other && is_label(data, name, accessor)? { Role::Label } else { role };
            widen(own.entry(name.clone()).or_insert((role, 0)), width, data, accessor)?;
        }
        for (target, attributes) in primitive.targets.iter().enumerate() {
            for (name, &accessor) in attributes {
                let (role, width) = target_role(name);
                widen(targets.entry((target, name.clone())).or_insert((role, 0)), width, data, accessor)?;
            }
        }
    }
    let channel = |(name, (role, width))| Channel { name, role, width, values: Vec::new() };
    let skin = (n_sets > 0).then(|| (SKIN.to_string(), (Role::Skin, 8 * n_sets)));
    let targets = targets.into_iter().map(|((target, name), held)| (target_channel(target, &name), held));
    Ok(own.into_iter().chain(skin).chain(targets).map(channel).collect())
}

fn is_label(data: &Data, name: &str, accessor: usize) -> Result<bool, ReadError> {
    let accessor = data.accessor(accessor)?;
    // Labels are recognised by name or by an integer type.
    let named = name.starts_with("_FEATURE_ID_") || name == "_BATCHID";
    Ok(named || accessor.component_type != FLOAT && !accessor.normalized)
}

fn widen((_, held): &mut (Role, usize), width: Option<usize>, data: &Data, accessor: usize) -> Result<(), ReadError> {
    let width = match width {
        Some(width) => width,
        None => data.width(accessor)?,
    };
    *held = width.max(*held);
    Ok(())
}

// Primitives with equal accessors share positions and wedges.
struct PartBuilder<'a> {
    data: &'a Data<'a>,
    mesh: RawMesh,
    n_wedges: usize,
    positions: BTreeMap<usize, PositionRun>,
    wedges: BTreeMap<Vec<usize>, usize>,
    n_not_finite: usize,
}

#[derive(Clone, Copy)]
struct PositionRun {
    first: usize,
    count: usize,
}

impl<'a> PartBuilder<'a> {
    fn new(data: &'a Data<'a>, channels: Vec<Channel>) -> Self {
        let attributes = Attributes { channels, ..Attributes::default() };
        let mesh = RawMesh { attributes, ..RawMesh::default() };
        Self { data, mesh, n_wedges: 0, positions: BTreeMap::new(), wedges: BTreeMap::new(), n_not_finite: 0 }
    }

    fn add(&mut self, index: u32, primitive: &Primitive, budget: &mut usize) -> Result<(), ReadError> {
        let Some(accessor) = primitive.triangle_positions() else { return Ok(()) };
        let run = self.positions_of(accessor, budget)?;
        // Positions and wedges are shared independently: seams split only wedges.
        let first_wedge = self.wedges_of(primitive, run.count, budget)?;
        let triangles = triangles::read_triangles(self.data, primitive, run.count, budget)?;
        // Corners out of range stay invalid, for cleanup to drop.
        let shift_vertices = |first: usize| move |v: u32| if v == u32::MAX { v } else { (first + v as usize) as u32 };
        self.mesh.faces.extend(triangles.iter().map(|triangle| triangle.map(shift_vertices(run.first))));
        if !self.mesh.attributes.channels.is_empty() {
            self.mesh
                .attributes
                .wedges
                .extend(triangles.iter().map(|triangle| triangle.map(shift_vertices(first_wedge))));
        }
        self.mesh.attributes.groups.extend(std::iter::repeat_n(index, triangles.len()));
        Ok(())
    }

    fn positions_of(&mut self, accessor: usize, budget: &mut usize) -> Result<PositionRun, ReadError> {
        if let Some(&run) = self.positions.get(&accessor) {
            return Ok(run);
        }
        let positions = self.data.positions(accessor, *budget)?;
        spend(budget, positions.len())?;
        let run = PositionRun { first: self.mesh.positions.len(), count: positions.len() };
        self.mesh.positions.extend(positions);
        self.positions.insert(accessor, run);
        Ok(run)
    }

    fn wedges_of(&mut self, primitive: &Primitive, count: usize, budget: &mut usize) -> Result<usize, ReadError> {
        if let Some(&first) = self.wedges.get(&accessors(primitive)) {
            return Ok(first);
        }
        let first = self.n_wedges;
        for channel in &mut self.mesh.attributes.channels {
            // Channels of other primitives are filled with zeros here, so their width counts too.
            spend(budget, count * channel.width)?;
            channel.values.resize((first + count) * channel.width, 0.0);
            let values = &mut channel.values[first * channel.width..];
            fill_channel(self.data, primitive, &channel.name, channel.role, channel.width, values)?;
            self.n_not_finite += replace_non_finite(values);
        }
        self.n_wedges += count;
        self.wedges.insert(accessors(primitive), first);
        Ok(first)
    }
}

// The key includes the attributes' names, since two attributes may use one accessor.
fn accessors(primitive: &Primitive) -> Vec<usize> {
    let maps = std::iter::once(&primitive.attributes).chain(&primitive.targets);
    let row = |(name, &accessor): (&String, &usize)| {
        std::iter::once(name.len()).chain(name.bytes().map(usize::from)).chain([accessor]).collect::<Vec<_>>()
    };
    maps.flat_map(|map| std::iter::once(map.len()).chain(map.iter().flat_map(row))).collect()
}

fn fill_channel(
    data: &Data,
    primitive: &Primitive,
    name: &str,
    role: Role,
    width: usize,
    values: &mut [f32],
) -> Result<(), ReadError> {
    let of_target = || target_of(name).and_then(|(target, name)| primitive.targets.get(target)?.get(name).copied());
    if role == Role::Skin {
        for set in 0..n_skin_sets(primitive) {
            for (first, name) in [(4 * set, "JOINTS"), (width / 2 + 4 * set, "WEIGHTS")] {
                let accessor = primitive.attributes.get(&format!("{name}_{set}"));
                accessor.map_or(Ok(()), |&accessor| write_columns(data, accessor, values, width, first..first + 4))?;
            }
        }
        return Ok(());
    }
    let Some(accessor) = primitive.attributes.get(name).copied().or_else(of_target) else { return Ok(()) };
    // Colours without alpha are opaque if others of the mesh have alpha.
    if role == Role::Colour && width == 4 {
        values.iter_mut().skip(3).step_by(4).for_each(|alpha| *alpha = 1.0);
    }
    write_columns(data, accessor, values, width, 0..width)
}

fn write_columns(
    data: &Data,
    accessor: usize,
    values: &mut [f32],
    width: usize,
    columns: std::ops::Range<usize>,
) -> Result<(), ReadError> {
    // There is at most one element per row, each of up to 4 x 4 numbers.
    let (found, elements) = data.floats(accessor, 16 * values.len() / width)?;
    // Broken files may have fewer components than the attribute needs.
    let n = found.min(columns.len());
    for (row, element) in values.chunks_exact_mut(width).zip(elements.chunks_exact(found)) {
        row[columns.start..][..n].copy_from_slice(&element[..n]);
    }
    Ok(())
}
