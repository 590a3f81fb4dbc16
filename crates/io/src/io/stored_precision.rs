//! Precision of stored coordinates: rounding must keep vertices distinct and faces their area.

use rustc_hash::FxHashMap;

use super::write::Content;
use super::{Format, WriteError};
use crate::mesh::has_area;

/// Fewest steps of single precision in an edge of mean length; with fewer, surfaces turn into stairs.
const STEPS: f64 = 4.0;
const WORTH_A_NOTE: f64 = 1e-6;

/// Precision of the coordinates that a format stores.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Precision {
    Single,
    // Single, relative to an origin in doubles.
    Local,
    // Single or double, as the file states.
    Stated,
    Double,
}

/// Gives the content the digits that the format needs.
///
/// # Errors
/// [`WriteError`] if rounding damages the mesh.
pub(super) fn prepare(content: Content, format: Format) -> Result<Content, WriteError> {
    // Readers of texts without number types may take short singles as doubles, which moves vertices.
    let is_for_doubles = format.row().precision == Precision::Double;
    let content = if is_for_doubles { content.with_needed_digits() } else { content };
    check_precision(&content, format)?;
    Ok(content)
}

fn check_precision(content: &Content, format: Format) -> Result<(), WriteError> {
    // Single-precision positions without an origin are written exactly.
    if !content.is_rounded() {
        return Ok(());
    }
    let stored = stored_positions(content, format);
    // The writer of the format rejects numbers beyond its range.
    if !stored.iter().flatten().all(|x| x.is_finite()) {
        return Ok(());
    }
    // Merged vertices and lost areas are counted for the message.
    let (n_together, n_flat) = (count_merged_vertices(content, &stored), count_flattened_faces(content, &stored));
    let what = match (n_together, n_flat) {
        (0, 0) if format.is_single_precision() && is_coarse(content, &stored) => {
            "edges are shorter than the rounding".into()
        }
        (0, 0) => return Ok(()),
        (n, 0) => format!("{n} vertices become equal"),
        (0, n) => format!("{n} faces lose their area"),
        (n, m) => format!("{n} vertices become equal and {m} faces lose their area"),
    };
    let name = format.name();
    let what = match format.row().precision {
        Precision::Single => format!(
            "{what} in single precision, the only precision of {name}: write ply, obj or glb, or move the mesh to the origin"
        ),
        Precision::Local => format!(
            "{what} in single precision, which {name} uses around an origin: write ply or obj, or move the mesh to the origin"
        ),
        Precision::Stated | Precision::Double => format!(
            "{what} even in double precision, as the mesh is too far from the origin: move the mesh to the origin"
        ),
    };
    Err(WriteError::new(what))
}

fn stored_positions(content: &Content, format: Format) -> Vec<[f64; 3]> {
    let positions = (0..content.n_vertices()).map(|vertex| content.position(vertex));
    match format.row().precision {
        Precision::Single => positions.map(|p| p.map(|x| f64::from(x as f32))).collect(),
        Precision::Local => {
            let (origin, local) = content.local_positions();
            local.iter().map(|p| std::array::from_fn(|axis| origin[axis] + f64::from(p[axis]))).collect()
        }
        Precision::Stated | Precision::Double => positions.collect(),
    }
}

pub(super) fn describe_rounding(content: &Content, format: Format) -> Option<String> {
    if !format.is_single_precision() || !content.is_rounded() {
        return None;
    }
    let stored = stored_positions(content, format);
    let error = |(vertex, p): (usize, &[f64; 3])| distance(content.position(vertex), *p);
    let most = stored.iter().enumerate().map(error).fold(0.0, f64::max);
    let name = format.name();
    (most > WORTH_A_NOTE * content.diagonal()).then(|| {
        format!("{name} stores single precision: vertices are rounded by up to {most:.1e}, in units of the mesh")
    })
}

fn is_coarse(content: &Content, stored: &[[f64; 3]]) -> bool {
    // Steps of single precision grow with the distance from the origin.
    let reach = stored.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let ends = |face: &[u32; 3]| [[face[0], face[1]], [face[1], face[2]], [face[2], face[0]]];
    let length = |[a, b]: [u32; 2]| distance(content.position(a as usize), content.position(b as usize));
    let total: f64 = content.faces.iter().flat_map(ends).map(length).sum();
    total < STEPS * f64::from(f32::EPSILON) * reach * (3 * content.faces.len()) as f64
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

fn count_merged_vertices(content: &Content, stored: &[[f64; 3]]) -> usize {
    let mut first: FxHashMap<[u64; 3], [u64; 3]> = FxHashMap::default();
    let mut is_merged = |(vertex, position): (usize, &[f64; 3])| {
        let identity = content.identity(vertex);
        // Adding zero makes -0 equal to 0.
        *first.entry(position.map(|x| (x + 0.0).to_bits())).or_insert(identity) != identity
    };
    stored.iter().enumerate().filter(|&it| is_merged(it)).count()
}

fn count_flattened_faces(content: &Content, stored: &[[f64; 3]]) -> usize {
    let is_flat = |face: &&[u32; 3]| !has_area(face.map(|vertex| stored[vertex as usize])) && content.has_area(**face);
    content.faces.iter().filter(is_flat).count()
}
