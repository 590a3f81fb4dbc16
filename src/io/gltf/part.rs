//! One mesh of an asset with all that its vertices carry, in its own coordinates.

use std::collections::BTreeMap;

use super::accessor::Data;
use super::draft::FLOAT;
use super::schema::{Mesh, Primitive, Root};
use super::semantics::{SKIN, is_own_channel, n_skin_sets, role, target_channel, target_of, target_role};
use super::{spend, triangles};
use crate::io::ReadError;
use crate::mesh::{Attributes, Channel, RawMesh, Role};

/// A mesh of a glTF asset, once, however often nodes place it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Part {
    /// Its name in the file, or `mesh N`.
    pub name: String,
    /// Its triangles in its own coordinates. Wedges are the vertices of the file; groups are indices of its primitives.
    pub mesh: RawMesh,
    /// What each primitive is made of: the name of its material, or `primitive N`.
    pub materials: Vec<String>,
    /// The largest scale at which a node of the default scene places it: the cube root of the determinant. 1 where a skin
    /// moves it or no node places it.
    pub scale: f64,
}

/// The triangles of a mesh, or `None` where it has none; `notes` takes what was mended.
pub(super) fn read(
    data: &Data,
    mesh: &Mesh,
    budget: &mut usize,
    notes: &mut Notes,
) -> Result<Option<RawMesh>, ReadError> {
    let primitives = || mesh.primitives.iter().enumerate().filter(|(_, it)| it.triangle_positions().is_some());
    let mut builder = Builder::new(data, channels(data, primitives().map(|(_, it)| it))?);
    for (index, primitive) in primitives() {
        builder.add(index as u32, primitive, budget, notes)?;
    }
    let mut mesh = builder.mesh;
    if mesh.attributes.channels.is_empty() {
        mesh.attributes.wedges.clear();
    }
    Ok(Some(mesh).filter(|mesh| !mesh.faces.is_empty()))
}

/// What was mended while reading.
#[derive(Default)]
pub(super) struct Notes {
    /// Attribute values that were no finite numbers.
    pub n_not_finite: usize,
}

/// The name of the material of each primitive of a mesh, or the number of the primitive.
pub(super) fn materials(root: &Root, mesh: &Mesh) -> Vec<String> {
    let name = |primitive: &Primitive| root.materials.get(primitive.material?)?.name.clone();
    let named = |(index, primitive)| name(primitive).unwrap_or_else(|| format!("primitive {index}"));
    mesh.primitives.iter().enumerate().map(named).collect()
}

/// The channels of all these primitives, without values.
fn channels<'a>(data: &Data, primitives: impl Iterator<Item = &'a Primitive>) -> Result<Vec<Channel>, ReadError> {
    let (mut own, mut n_sets, mut targets) = (BTreeMap::new(), 0, BTreeMap::new());
    for primitive in primitives {
        n_sets = n_sets.max(n_skin_sets(primitive));
        for (name, &accessor) in primitive.attributes.iter().filter(|(name, _)| is_own_channel(name)) {
            let (role, width) = role(name);
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

/// Whether values that only the file has a name for are numbers of things: whole ones, or by a name that says so.
fn is_label(data: &Data, name: &str, accessor: usize) -> Result<bool, ReadError> {
    let accessor = data.accessor(accessor)?;
    let named = name.starts_with("_FEATURE_ID_") || name == "_BATCHID";
    Ok(named || accessor.component_type != FLOAT && !accessor.normalized)
}

/// Makes a channel as wide as this accessor asks for.
fn widen((_, held): &mut (Role, usize), width: Option<usize>, data: &Data, accessor: usize) -> Result<(), ReadError> {
    let width = match width {
        Some(width) => width,
        None => data.width(accessor)?,
    };
    *held = width.max(*held);
    Ok(())
}

/// Vertices with the same positions accessor share positions, those with all accessors the same share wedges.
struct Builder<'a> {
    data: &'a Data<'a>,
    mesh: RawMesh,
    n_wedges: usize,
    positions: BTreeMap<usize, Run>,
    wedges: BTreeMap<Vec<usize>, usize>,
}

/// Where the positions of an accessor begin, and how many they are.
#[derive(Clone, Copy)]
struct Run {
    first: usize,
    count: usize,
}

impl<'a> Builder<'a> {
    fn new(data: &'a Data<'a>, channels: Vec<Channel>) -> Self {
        let attributes = Attributes { channels, ..Attributes::default() };
        let mesh = RawMesh { attributes, ..RawMesh::default() };
        Self { data, mesh, n_wedges: 0, positions: BTreeMap::new(), wedges: BTreeMap::new() }
    }

    /// Adds the triangles of a primitive.
    fn add(
        &mut self,
        index: u32,
        primitive: &Primitive,
        budget: &mut usize,
        notes: &mut Notes,
    ) -> Result<(), ReadError> {
        let Some(accessor) = primitive.triangle_positions() else { return Ok(()) };
        let run = self.positions_of(accessor, budget)?;
        let first_wedge = self.wedges_of(primitive, run.count, budget, notes)?;
        let triangles = triangles::of_primitive(self.data, primitive, run.count, budget)?;
        // Corners out of range stay so.
        let at = |first: usize| move |v: u32| if v == u32::MAX { v } else { (first + v as usize) as u32 };
        self.mesh.faces.extend(triangles.iter().map(|triangle| triangle.map(at(run.first))));
        self.mesh.attributes.wedges.extend(triangles.iter().map(|triangle| triangle.map(at(first_wedge))));
        self.mesh.attributes.groups.extend(std::iter::repeat_n(index, triangles.len()));
        Ok(())
    }

    fn positions_of(&mut self, accessor: usize, budget: &mut usize) -> Result<Run, ReadError> {
        if let Some(&run) = self.positions.get(&accessor) {
            return Ok(run);
        }
        let positions = self.data.positions(accessor, *budget)?;
        spend(budget, positions.len())?;
        let run = Run { first: self.mesh.positions.len(), count: positions.len() };
        self.mesh.positions.extend(positions);
        self.positions.insert(accessor, run);
        Ok(run)
    }

    /// The first of `count` wedges that carry what the vertices of the primitive do.
    fn wedges_of(
        &mut self,
        primitive: &Primitive,
        count: usize,
        budget: &mut usize,
        notes: &mut Notes,
    ) -> Result<usize, ReadError> {
        if let Some(&first) = self.wedges.get(&accessors(primitive)) {
            return Ok(first);
        }
        let first = self.n_wedges;
        for channel in &mut self.mesh.attributes.channels {
            spend(budget, count * channel.width)?;
            channel.values.resize((first + count) * channel.width, 0.0);
            let values = &mut channel.values[first * channel.width..];
            fill(self.data, primitive, &channel.name, channel.role, channel.width, values)?;
            for value in values.iter_mut().filter(|value| !value.is_finite()) {
                *value = 0.0;
                notes.n_not_finite += 1;
            }
        }
        self.n_wedges += count;
        self.wedges.insert(accessors(primitive), first);
        Ok(first)
    }
}

/// All accessors that the vertices of a primitive are made of, each after the length of its name and the name.
fn accessors(primitive: &Primitive) -> Vec<usize> {
    let maps = std::iter::once(&primitive.attributes).chain(&primitive.targets);
    let row = |(name, &accessor): (&String, &usize)| {
        std::iter::once(name.len()).chain(name.bytes().map(usize::from)).chain([accessor]).collect::<Vec<_>>()
    };
    maps.flat_map(|map| std::iter::once(map.len()).chain(map.iter().flat_map(row))).collect()
}

/// Writes what a primitive's vertices carry in a channel, n x width; it stays zero where they carry nothing.
fn fill(
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
                accessor.map_or(Ok(()), |&accessor| put(data, accessor, values, width, first..first + 4))?;
            }
        }
        return Ok(());
    }
    let Some(accessor) = primitive.attributes.get(name).copied().or_else(of_target) else { return Ok(()) };
    if role == Role::Colour && width == 4 {
        values.iter_mut().skip(3).step_by(4).for_each(|alpha| *alpha = 1.0);
    }
    put(data, accessor, values, width, 0..width)
}

/// Writes the values of an accessor into these columns of rows of `width`, as far as it has columns and rows.
fn put(
    data: &Data,
    accessor: usize,
    values: &mut [f32],
    width: usize,
    columns: std::ops::Range<usize>,
) -> Result<(), ReadError> {
    // No more elements than there are rows, four by four numbers at most.
    let (found, elements) = data.floats(accessor, 16 * values.len() / width)?;
    let n = found.min(columns.len());
    for (row, element) in values.chunks_exact_mut(width).zip(elements.chunks_exact(found)) {
        row[columns.start..][..n].copy_from_slice(&element[..n]);
    }
    Ok(())
}
