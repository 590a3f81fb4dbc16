//! Snaps nearly coincident vertices together.

use std::collections::HashMap;

/// Moves each vertex onto the nearest fixed vertex closer than `distance`; returns the number moved.
///
/// Vertices are visited in order; a vertex without a fixed vertex near it becomes fixed. Vertices that are not finite
/// are skipped.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// let mut positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.001, 0.0, 0.0]];
/// assert_eq!(neural_mesh::mesh::snap(&mut positions, 0.01), 1);
/// assert_eq!(positions[2], [0.0; 3]);
/// ```
pub fn snap(positions: &mut [[f64; 3]], distance: f64) -> usize {
    if !(distance > 0.0 && distance.is_finite()) {
        return 0;
    }
    let mut staying: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
    let mut n_moved = 0;
    for vertex in 0..positions.len() {
        let position = positions[vertex];
        if !position.iter().all(|x| x.is_finite()) {
            continue;
        }
        let near = cells_around(position, distance).into_iter().filter_map(|cell| staying.get(&cell)).flatten();
        let apart = near.map(|&other| (squared_distance(position, positions[other as usize]), other));
        let nearest = apart.min_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        match nearest.filter(|&(squared, _)| squared < distance * distance) {
            Some((_, other)) => {
                n_moved += usize::from(positions[other as usize] != position);
                positions[vertex] = positions[other as usize];
            }
            None => staying.entry(position.map(|x| cell(x, distance))).or_default().push(vertex as u32),
        }
    }
    n_moved
}

/// Returns the grid cell of a coordinate as a float's bits, since far cells exceed integers.
fn cell(x: f64, distance: f64) -> u64 {
    // Adding zero turns -0 into 0.
    ((x / (2.0 * distance)).floor() + 0.0).to_bits()
}

fn cells_around(position: [f64; 3], distance: f64) -> Vec<[u64; 3]> {
    let along = |x: f64| {
        let mut cells = [x - distance, x, x + distance].map(|x| cell(x, distance)).to_vec();
        cells.dedup();
        cells
    };
    let [xs, ys, zs] = position.map(along);
    let rows = xs.iter().flat_map(|&x| ys.iter().map(move |&y| (x, y)));
    rows.flat_map(|(x, y)| zs.iter().map(move |&z| [x, y, z])).collect()
}

fn squared_distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn naive(positions: &[[f64; 3]], distance: f64) -> Vec<[f64; 3]> {
        let mut staying: Vec<[f64; 3]> = Vec::new();
        let place = |&position: &[f64; 3]| {
            let apart = |other: &[f64; 3]| squared_distance(position, *other);
            let nearest = staying.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)));
            let found = nearest.filter(|other| apart(other) < distance * distance);
            staying.extend(found.is_none().then_some(position));
            found.unwrap_or(position)
        };
        positions.iter().map(place).collect()
    }

    proptest! {
        #[test]
        fn agrees_with_a_search(
            positions in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 0..80),
            distance in 0.01f64..0.9,
        ) {
            let mut moved = positions.clone();
            let n_moved = snap(&mut moved, distance);
            prop_assert_eq!(&moved, &naive(&positions, distance));
            prop_assert_eq!(n_moved, moved.iter().zip(&positions).filter(|(a, b)| a != b).count());
        }
    }

    #[test]
    fn chains_do_not_run_together() {
        let mut positions: Vec<[f64; 3]> = (0..7).map(|i| [f64::from(i) * 0.75, 0.0, -0.0]).collect();
        assert_eq!(snap(&mut positions, 1.0), 3);
        assert_eq!(positions.iter().map(|p| p[0]).collect::<Vec<_>>(), [0.0, 0.0, 1.5, 1.5, 3.0, 3.0, 4.5]);
    }

    #[test]
    fn tiny_distances_and_odd_coordinates_do_no_harm() {
        let original =
            [[1e300, 0.0, 0.0], [f64::NAN, 0.0, 0.0], [-1e300, 0.0, 0.0], [3.0, 4.0, 5.0], [f64::INFINITY; 3]];
        for distance in [1e-300, 1e-9, 0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut positions = original;
            assert_eq!(snap(&mut positions, distance), 0, "{distance}");
        }
        // Neighbouring numbers of this size are farther apart than the cells.
        let mut far: Vec<[f64; 3]> = (0..100).map(|i| [1e17 + 16.0 * f64::from(i), 0.0, 0.0]).collect();
        assert_eq!(snap(&mut far, 17.0), 50);
    }
}
