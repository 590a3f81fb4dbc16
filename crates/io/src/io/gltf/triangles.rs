//! Triangles of a primitive: lists, strips, fans.

use super::accessor::Data;
use super::refusals::spend;
use super::schema::Primitive;
use crate::io::ReadError;

/// Returns the triangles over vertices `0..n_vertices`, n_faces x 3; corners out of range become `u32::MAX`.
pub(super) fn read_triangles(
    data: &Data,
    primitive: &Primitive,
    n_vertices: usize,
    budget: &mut usize,
) -> Result<Vec<[u32; 3]>, ReadError> {
    let n_corners = primitive.indices.map_or(Ok(n_vertices), |accessor| data.count(accessor))?;
    // The count is a claim of the file.
    spend(budget, n_corners)?;
    let mut indices = match primitive.indices {
        Some(accessor) => data.indices(accessor, n_corners)?,
        None => (0..n_vertices as u32).collect(),
    };
    // An index out of range could reach vertices of another primitive.
    for index in indices.iter_mut().filter(|index| **index as usize >= n_vertices) {
        *index = u32::MAX;
    }
    Ok(triangles(&indices, primitive.mode))
}

fn triangles(indices: &[u32], mode: u32) -> Vec<[u32; 3]> {
    match mode {
        4 => indices.as_chunks::<3>().0.to_vec(),
        5 => {
            let turn = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
            indices.windows(3).enumerate().map(turn).collect()
        }
        _ => indices.get(1..).unwrap_or_default().windows(2).map(|edge| [edge[0], edge[1], indices[0]]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        assert_eq!(triangles(&[0, 1, 2, 3, 4], 5), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(triangles(&[0, 1, 2, 3], 6), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(triangles(&[0, 1, 2, 3], 4), [[0, 1, 2]]);
        for mode in 4..=6 {
            assert!(triangles(&[], mode).is_empty() && triangles(&[0], mode).is_empty());
        }
    }
}
