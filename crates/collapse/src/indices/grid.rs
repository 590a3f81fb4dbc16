//! Vertices of one cell of a grid become one: any size can be reached, and components join.
//!
//! Rossignac and Borrel, Multi-Resolution 3D Approximations for Rendering Complex Scenes, 1993.

use std::collections::HashMap;

use crate::collapse::{CollapseError, bounding_box};

use super::buffers::IndexBuffers;

/// Most cells along a side.
const MOST_CELLS: u32 = 1 << 10;

/// Simplifies to at most `n_faces` faces by cells of a grid, whatever the topology; vertices do not move.
///
/// The finest grid is taken whose result is not too large. Each cell keeps the vertex that is nearest to the mean of its
/// corners; locked vertices stay. Returns the faces and the longest way of a vertex, over the extent; above `max_error`, all.
/// No face is left if the coarsest grid with a face has more than `n_faces`.
///
/// # Errors
/// As [`simplify_indices`](super::simplify_indices).
pub fn simplify_sloppily(
    buffers: &IndexBuffers,
    n_faces: usize,
    max_error: f32,
) -> Result<(Vec<[u32; 3]>, f32), CollapseError> {
    buffers.check()?;
    let mut weights = vec![0.0; buffers.positions.len()];
    buffers.indices.as_flattened().iter().for_each(|&v| weights[v as usize] += 1.0);
    let points = Points::new(buffers.positions, weights);
    let join = |n_cells| join_faces(buffers, points.find_cells(n_cells, buffers.locks));
    // Locked vertices may leave more in one cell, too.
    let (cells, faces) = search(join, |(_, faces)| faces.len() <= n_faces).map_or_else(|| join(1), |found| found.1);
    let ways = cells.iter().enumerate().map(|(v, &cell)| points.squared_distance(v, points.rows[cell as usize]));
    let error = ways.fold(0.0, f32::max).sqrt();
    Ok(if error <= max_error { (faces, error) } else { (buffers.indices.to_vec(), 0.0) })
}

// The faces that are left where each vertex is that of its cell, each once, from its lowest corner on.
fn join_faces(buffers: &IndexBuffers, cells: Vec<u32>) -> (Vec<u32>, Vec<[u32; 3]>) {
    let mut faces: Vec<[u32; 3]> = buffers.indices.iter().map(|face| face.map(|v| cells[v as usize])).collect();
    faces.retain(|face| face[0] != face[1] && face[1] != face[2] && face[2] != face[0]);
    for face in &mut faces {
        let lowest = (0..3).min_by_key(|&i| face[i]).unwrap_or(0);
        face.rotate_left(lowest);
    }
    faces.sort_unstable();
    faces.dedup();
    (cells, faces)
}

/// Selects `n_points` points, spread over the cloud: of each cell of a grid the one nearest to the cell's mean.
///
/// `colors` count for the mean: n_points x 3 or empty, a difference of 1 as a distance of `color_weight` times the extent.
///
/// # Errors
/// Refuses coordinates that are not finite and lengths that do not fit.
pub fn select_points(
    positions: &[[f32; 3]],
    colors: &[[f32; 3]],
    color_weight: f32,
    n_points: usize,
) -> Result<Vec<u32>, CollapseError> {
    let weights: &[f32] = if colors.is_empty() { &[] } else { &[1.0; 3] };
    let (indices, attributes) = (&[][..], colors.as_flattened());
    IndexBuffers { indices, positions, attributes, weights, ..IndexBuffers::default() }.check()?;
    if n_points >= positions.len() {
        return Ok((0..positions.len() as u32).collect());
    }
    let mut points = Points::new(positions, vec![1.0; positions.len()]);
    for (row, color) in points.rows.iter_mut().zip(colors) {
        (0..3).for_each(|k| row[3 + k] = color[k] * color_weight);
    }
    let select = |n_cells: u32| {
        let mut kept = points.find_cells(n_cells, &[]);
        kept.sort_unstable();
        kept.dedup();
        kept
    };
    let Some((n_cells, mut kept)) = search(select, |kept| kept.len() <= n_points) else { return Ok(Vec::new()) };
    // The rest from the next finer grid, in even steps.
    let mut more = select(n_cells + 1);
    more.retain(|point| kept.binary_search(point).is_err());
    let n_left = (n_points - kept.len()).min(more.len());
    kept.extend((0..n_left).map(|i| more[i * more.len() / n_left]));
    kept.sort_unstable();
    Ok(kept)
}

// What fits of the finest grid found by bisection, and its number of cells along a side.
fn search<T>(make: impl Fn(u32) -> T, fits: impl Fn(&T) -> bool) -> Option<(u32, T)> {
    let (mut found, mut low, mut high) = (None, 0, MOST_CELLS + 1);
    while high - low > 1 {
        let middle = low.midpoint(high);
        let made = make(middle);
        if fits(&made) {
            (found, low) = (Some((middle, made)), middle);
        } else {
            high = middle;
        }
    }
    found
}

/// Points in the unit cube, with three further coordinates that count for distances.
struct Points {
    rows: Vec<[f32; 6]>,
    /// Weight of each in the mean of its cell; points of weight 0 are in no cell.
    weights: Vec<f32>,
}

impl Points {
    fn new(positions: &[[f32; 3]], weights: Vec<f32>) -> Points {
        let [low, high] = bounding_box(positions);
        let extent = (0..3).map(|k| high[k] - low[k]).fold(0.0, f32::max);
        let scale = if extent > 0.0 { 1.0 / extent } else { 0.0 };
        let row = |p: &[f32; 3]| [0, 1, 2, 3, 4, 5].map(|k| if k < 3 { (p[k] - low[k]) * scale } else { 0.0 });
        Points { rows: positions.iter().map(row).collect(), weights }
    }

    fn squared_distance(&self, point: usize, other: [f32; 6]) -> f32 {
        self.rows[point].iter().zip(other).map(|(x, y)| (x - y) * (x - y)).sum()
    }

    // For each point the one that its cell keeps; itself if it is locked or in no cell.
    fn find_cells(&self, n_cells: u32, locks: &[bool]) -> Vec<u32> {
        let mut numbers: HashMap<[u32; 3], usize> = HashMap::new();
        let (mut sums, mut nearest) = (Vec::new(), Vec::new());
        let mut cell_of = vec![usize::MAX; self.rows.len()];
        for (point, row) in self.rows.iter().enumerate() {
            if self.weights[point] == 0.0 || locks.get(point) == Some(&true) {
                continue;
            }
            let key = [0, 1, 2].map(|k| ((row[k] * n_cells as f32) as u32).min(n_cells - 1));
            let n = numbers.len();
            let cell = *numbers.entry(key).or_insert(n);
            if cell == sums.len() {
                sums.push(([0.0; 6], 0.0));
                nearest.push((f32::INFINITY, 0));
            }
            cell_of[point] = cell;
            let (sum, weight) = &mut sums[cell];
            sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += x * self.weights[point]);
            *weight += self.weights[point];
        }
        for (point, &cell) in cell_of.iter().enumerate().filter(|(_, cell)| **cell != usize::MAX) {
            let (sum, weight) = sums[cell];
            let distance = self.squared_distance(point, sum.map(|x| x / weight));
            if distance < nearest[cell].0 {
                nearest[cell] = (distance, point as u32);
            }
        }
        let kept = |(point, cell): (u32, &usize)| nearest.get(*cell).map_or(point, |nearest| nearest.1);
        (0..).zip(&cell_of).map(kept).collect()
    }
}
