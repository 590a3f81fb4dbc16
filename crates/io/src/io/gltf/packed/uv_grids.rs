//! Grids to which texture coordinates are rounded; texture transforms convert grid steps back.
//!
//! Materials on the same faces share a grid.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use crate::io::gltf::extensions::name_extension;
use crate::io::gltf::references::{index, list};
use crate::io::gltf::schema::Root;
use crate::io::gltf::simplified_part::SimplifiedPart;
use crate::io::gltf::vrm::is_vrm;
use crate::mesh::Role;
use crate::mesh::union_find::UnionFind;

pub(in crate::io::gltf) const TRANSFORM: &str = "KHR_texture_transform";
const BITS: u32 = 12;
const WHOLE: f64 = 65_535.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::io::gltf) struct UvGrid {
    origin: [f64; 2],
    step: [f64; 2],
}

impl UvGrid {
    fn for_box([low, high]: [[f32; 2]; 2]) -> Option<Self> {
        let step = |axis: usize| {
            let side = f64::from(high[axis]) - f64::from(low[axis]);
            // A side of one texture has 12 bits; long sides get more, so that a texel keeps its precision.
            let is_fine = |bits: &u32| side <= 1.01 * f64::from((1u32 << bits) - 1) / f64::from((1u32 << BITS) - 1);
            let bits = (BITS..16).find(is_fine).unwrap_or(16);
            f64::from((side / f64::from((1u32 << bits) - 1)) as f32).max(f64::EPSILON)
        };
        let is_finite = low.iter().chain(&high).all(|x| x.is_finite());
        is_finite.then(|| Self { origin: low.map(f64::from), step: [step(0), step(1)] })
    }

    pub fn share(&self, uv: [f32; 2]) -> [f32; 2] {
        let number = |axis: usize| ((f64::from(uv[axis]) - self.origin[axis]) / self.step[axis]).round();
        std::array::from_fn(|axis| (number(axis).clamp(0.0, WHOLE) / WHOLE) as f32)
    }

    fn undo(&self, used: &mut Value) {
        let UvTransform { offset, scale, .. } = UvTransform::from_use(used);
        let held = used["extensions"][TRANSFORM].take();
        let mut transform = if held.is_object() { held.clone() } else { json!({}) };
        // Readers store a single, so the shortest text of a single suffices.
        let number = |x: f64| json!((x as f32).to_string().parse::<f64>().unwrap_or(x));
        transform["offset"] = [0, 1].map(|axis| number(offset[axis] + scale[axis] * self.origin[axis])).to_vec().into();
        transform["scale"] = [0, 1].map(|axis| number(scale[axis] * self.step[axis] * WHOLE)).to_vec().into();
        used["extensions"][TRANSFORM] = transform;
    }
}

#[derive(Debug, Default)]
pub(in crate::io::gltf) struct UvGrids {
    grids: BTreeMap<(usize, String), UvGrid>,
}

impl UvGrids {
    pub fn grid(&self, surface: usize, name: &str) -> Option<&UvGrid> {
        self.grids.get(&(surface, name.to_string()))
    }

    pub fn of_groups(part: &SimplifiedPart, is_textured: impl Fn(u32) -> bool) -> Self {
        let mut boxes = Boxes::default();
        boxes.add(part, |group| is_textured(group).then_some(group as usize));
        Self { grids: boxes.grids(|_, name| name == "TEXCOORD_0") }
    }

    pub fn of_asset(document: &Value, root: &Root, meshes: &[usize], levels: &[&[SimplifiedPart]]) -> Self {
        // Transforms of the document would overwrite these.
        if forbids_transforms(document) {
            return Self::default();
        }
        let uses: Vec<BTreeSet<String>> = materials(document).map(coordinates_used).collect();
        let (mut sharing, closed) = shared_and_closed(document, root, meshes, uses.len());
        let mut set_of = |surface: usize| sharing.find(surface as u32) as usize;
        let mut is_closed: BTreeSet<(usize, String)> = closed.into_iter().map(|(s, name)| (set_of(s), name)).collect();
        let all: BTreeSet<String> = uses.iter().flatten().cloned().collect();
        for (surface, used) in uses.iter().enumerate() {
            // All materials of a set must undo the grid, so coordinates that one of them does not use get no grid.
            is_closed.extend(all.difference(used).map(|name| (set_of(surface), name.clone())));
        }
        let mut boxes = Boxes::default();
        for (part, &mesh) in levels.iter().flat_map(|level| level.iter().zip(meshes)) {
            let primitives = &document["meshes"][mesh]["primitives"];
            let first = |group: u32| surfaces(&primitives[group as usize], uses.len()).first().copied();
            boxes.add(part, |group| first(group).map(&mut set_of));
        }
        let of_sets = boxes.grids(|set, name| all.contains(name) && !is_closed.contains(&(set, name.to_string())));
        let of_surface = |surface: usize| {
            let set = set_of(surface);
            let own = of_sets.iter().filter(move |((of, _), _)| *of == set);
            own.map(move |((_, name), grid)| ((surface, name.clone()), *grid)).collect::<Vec<_>>()
        };
        Self { grids: (0..uses.len()).flat_map(of_surface).collect() }
    }

    /// Gives the materials texture transforms that undo the grids; `surface` maps a material to its key in `grids`.
    pub fn undo(&self, document: &mut Value, surface: impl Fn(usize) -> usize) {
        let Some(Value::Array(materials)) = document.get_mut("materials") else { return };
        let mut is_undone = false;
        for (at, material) in materials.iter_mut().enumerate() {
            for_each_texture_use(material, &mut |used| {
                if let Some(grid) = self.grid(surface(at), &coordinates(used)) {
                    grid.undo(used);
                    is_undone = true;
                }
            });
        }
        if is_undone {
            name_extension(document, TRANSFORM);
        }
    }
}

#[derive(Default)]
struct Boxes {
    boxes: BTreeMap<(usize, String), [[f32; 2]; 2]>,
}

impl Boxes {
    fn add(&mut self, part: &SimplifiedPart, mut surface: impl FnMut(u32) -> Option<usize>) {
        const EMPTY: [[f32; 2]; 2] = [[f32::INFINITY; 2], [f32::NEG_INFINITY; 2]];
        for channel in part.attributes.channels.iter().filter(|it| it.role == Role::Uv && it.width == 2) {
            let mut of_groups: BTreeMap<u32, [[f32; 2]; 2]> = BTreeMap::new();
            for face in 0..part.faces.len() {
                let held = of_groups.entry(part.attributes.group(face as u32)).or_insert(EMPTY);
                part.wedges(face).iter().for_each(|&wedge| *held = widen(*held, channel.value(wedge)));
            }
            for (group, [low, high]) in of_groups {
                let Some(surface) = surface(group) else { continue };
                let held = self.boxes.entry((surface, channel.name.clone())).or_insert(EMPTY);
                *held = widen(widen(*held, &low), &high);
            }
        }
    }

    fn grids(self, is_wanted: impl Fn(usize, &str) -> bool) -> BTreeMap<(usize, String), UvGrid> {
        let grid = |((surface, name), range): ((usize, String), _)| {
            let grid = UvGrid::for_box(range).filter(|_| is_wanted(surface, &name))?;
            Some(((surface, name), grid))
        };
        self.boxes.into_iter().filter_map(grid).collect()
    }
}

fn widen([low, high]: [[f32; 2]; 2], uv: &[f32]) -> [[f32; 2]; 2] {
    // Coordinates that are not finite are written as 0.
    let finite = |axis: usize| if uv[axis].is_finite() { uv[axis] } else { 0.0 };
    [[0, 1].map(|axis| low[axis].min(finite(axis))), [0, 1].map(|axis| high[axis].max(finite(axis)))]
}

fn shared_and_closed(
    document: &Value,
    root: &Root,
    meshes: &[usize],
    n_materials: usize,
) -> (UnionFind, BTreeSet<(usize, String)>) {
    let (mut sharing, mut closed) = (UnionFind::new(n_materials), BTreeSet::new());
    for (mesh, described) in root.meshes.iter().enumerate() {
        for (at, primitive) in described.primitives.iter().enumerate() {
            let surfaces = surfaces(&document["meshes"][mesh]["primitives"][at], n_materials);
            for pair in surfaces.windows(2) {
                sharing.union(pair[0] as u32, pair[1] as u32);
            }
            // Coordinates of primitives that are copied unchanged, or that morph targets move, cannot have a grid.
            let is_ours = meshes.contains(&mesh) && primitive.triangle_positions().is_some();
            let moved = primitive.targets.iter().flat_map(|target| target.keys());
            let kept = primitive.attributes.keys().filter(|_| !is_ours);
            closed.extend(kept.chain(moved).flat_map(|name| surfaces.iter().map(|&s| (s, name.clone()))));
        }
    }
    (sharing, closed)
}

fn materials(document: &Value) -> impl Iterator<Item = &Value> {
    list(document, "materials").iter()
}

fn forbids_transforms(document: &Value) -> bool {
    let channels = list(document, "animations").iter();
    let mut channels = channels.flat_map(|animation| list(animation, "channels").iter());
    let has_pointers = channels.any(|channel| channel["target"]["path"] == "pointer");
    has_pointers || is_vrm(document)
}

fn surfaces(primitive: &Value, n_materials: usize) -> Vec<usize> {
    let mappings = list(&primitive["extensions"]["KHR_materials_variants"], "mappings").iter();
    let all = std::iter::once(&primitive["material"]).chain(mappings.map(|mapping| &mapping["material"]));
    all.filter_map(index).filter(|&material| material < n_materials).collect()
}

fn coordinates_used(material: &Value) -> BTreeSet<String> {
    let (mut names, mut is_turned) = (BTreeSet::new(), false);
    for_each_texture_use(&mut material.clone(), &mut |used| {
        is_turned |= UvTransform::from_use(used).is_turned;
        is_turned |= used.get("extensions").is_some_and(|extensions| !extensions.is_object());
        names.insert(coordinates(used));
    });
    // A rotation forbids grids on all coordinates of the material.
    if is_turned { BTreeSet::new() } else { names }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::io::gltf) struct UvTransform {
    pub offset: [f64; 2],
    pub scale: [f64; 2],
    pub is_turned: bool,
}

impl UvTransform {
    pub fn from_use(used: &Value) -> Self {
        let transform = used.get("extensions").and_then(|all| all.get(TRANSFORM));
        let pair = |name: &str, default: f64| {
            [0, 1]
                .map(|axis| transform.and_then(|transform| transform.get(name)?.get(axis)?.as_f64()).unwrap_or(default))
        };
        let turn = transform.and_then(|transform| transform.get("rotation")?.as_f64());
        let is_turned = turn.is_some_and(|angle| angle != 0.0);
        Self { offset: pair("offset", 0.0), scale: pair("scale", 1.0), is_turned }
    }
}

pub(in crate::io::gltf) fn coordinates(used: &Value) -> String {
    let of_transform = used.get("extensions").and_then(|all| all.get(TRANSFORM)?.get("texCoord"));
    let set = of_transform.or(used.get("texCoord")).and_then(index).unwrap_or(0);
    format!("TEXCOORD_{set}")
}

/// Calls `show` with every JSON object of a material that refers to a texture.
pub(in crate::io::gltf) fn for_each_texture_use(value: &mut Value, show: &mut dyn FnMut(&mut Value)) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(|value| for_each_texture_use(value, show)),
        Value::Object(members) => {
            members
                .iter_mut()
                .filter(|(name, _)| *name != "extras")
                .for_each(|(_, value)| for_each_texture_use(value, show));
            if members.get("index").and_then(index).is_some() {
                show(value);
            }
        }
        _ => {}
    }
}
