//! What a network says of the points of patches.

use super::{JoinedLayers, PointNetwork};
use neural_mesh::autodiff::{Tape, Value};

/// Applies a network to patches of equally many points, whose own points come first.
///
/// Places beside their distances from the own point go through layers point by point, are pooled over the patch, and
/// go with what was pooled through two stages, the first of which gives new places. The activation is a ReLU; the paper's
/// program trains the map with another than it runs it with.
///
/// # Shapes
/// - `places`: (n_patches * group) x 3, the own point of each patch at the origin
/// - returns (n_patches * group) x n_out
///
/// ```
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::Matrix};
/// use neural_mesh_bench::learned_baselines::dse::{Dse, drawn, forward};
/// let net = Dse::of(&drawn(0.125, 1).constants()).unwrap();
/// let places = Value::constant(Matrix::zeros(2 * 25, 3));
/// assert_eq!(forward(&mut Tape::default(), &net.map, &places, 25).matrix().shape(), [50, 2]);
/// ```
pub fn forward(tape: &mut Tape, net: &PointNetwork<Value>, places: &Value, group: usize) -> Value {
    let distances = tape.group_distances(places, group);
    let ([first, first_bias], others) = (&net.pointwise[0], &net.pointwise[1..]);
    let seen = tape.concat_product(places, &distances, first);
    let seen = tape.plus_row(&seen, first_bias);
    let seen = tape.relu(&seen);
    let layers: Vec<[&Value; 2]> = others.iter().map(|layer| layer.each_ref()).collect();
    let pooled = tape.layers_group_max(&seen, &layers, group);
    let mut pooled = tape.relu(&pooled);
    for [weights, bias] in &net.pooled {
        let mapped = tape.affine(&pooled, weights, bias);
        pooled = tape.relu(&mapped);
    }
    let coarse = joined(tape, &net.coarse, [places, &distances], &pooled, group);
    let distances = tape.group_distances(&coarse, group);
    joined(tape, &net.fine, [&coarse, &distances], &pooled, group)
}

/// What was pooled is multiplied once per patch, not once per point.
fn joined(
    tape: &mut Tape,
    net: &JoinedLayers<Value>,
    [places, distances]: [&Value; 2],
    pooled: &Value,
    group: usize,
) -> Value {
    let patch_of: Vec<u32> = (0..places.matrix().n_rows()).map(|row| (row / group) as u32).collect();
    let of_points = tape.concat_product(places, distances, &net.of_point);
    let of_patches = tape.affine(pooled, &net.of_patch[0], &net.of_patch[1]);
    let of_patches = tape.gather(&of_patches, &patch_of);
    let both = tape.plus(&of_points, &of_patches);
    let active = tape.relu(&both);
    tape.layers(&active, &[net.hidden.each_ref(), net.out.each_ref()])
}
