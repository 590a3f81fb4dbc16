//! Wedges: vertices at one position with equal attributes.

use neural_mesh::mesh::{Channel, first_equal};

/// Returns for each vertex the first vertex with an equal position and equal values in all channels.
///
/// Channels have one row per vertex. A mesh without indices has a vertex of its own at each corner: without this step
/// every edge would be a seam.
pub fn find_wedges(positions: &[[f32; 3]], channels: &[Channel]) -> Vec<u32> {
    // Adding 0 turns -0 into 0, so that both are equal bits.
    let bits = |x: f32| (x + 0.0).to_bits();
    let (mut wedges, _) = first_equal(positions.len(), |v| positions[v].map(bits));
    // Vertices stay together as long as two further values at a time are equal, too.
    for channel in channels {
        for start in (0..channel.width).step_by(2) {
            let value =
                |v: usize, k: usize| if k < channel.width { channel.values[v * channel.width + k] } else { 0.0 };
            let key = |v: usize| [wedges[v], bits(value(v, start)), bits(value(v, start + 1))];
            wedges = first_equal(positions.len(), key).0;
        }
    }
    wedges
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::Role;

    #[test]
    fn equal_vertices_share_a_wedge_and_others_do_not() {
        let positions = [[0.0, 0.0, 0.0], [-0.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]];
        let values = vec![1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 4.0, 1.0, 2.0, 3.0, 1.0, 2.0, 4.0];
        let channel = Channel { name: "0".into(), role: Role::Other, width: 3, values };
        assert_eq!(find_wedges(&positions, &[channel]), [0, 0, 2, 3, 2]);
        assert_eq!(find_wedges(&positions, &[]), [0, 0, 0, 3, 0]);
    }
}
