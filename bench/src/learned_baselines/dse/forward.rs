//! Forward pass of a network over patches.

use super::{JoinedLayers, PointNetwork};
use neural_mesh::autodiff::{Tape, Value};

/// Applies a network to patches of equal size.
///
/// # Shapes
/// - `places`: (n_patches * group) x 3, each patch's own point first and at the origin
/// - returns (n_patches * group) x n_out
///
/// ```
/// use neural_mesh::{autodiff::{Tape, Value}, linalg::Matrix};
/// use neural_mesh_bench::learned_baselines::dse::{Dse, initial_tensors, forward};
/// let net = Dse::from_tensors(&initial_tensors(0.125, 1).constants()).unwrap();
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
    let coarse = apply_joined(tape, &net.coarse, [places, &distances], &pooled, group);
    let distances = tape.group_distances(&coarse, group);
    apply_joined(tape, &net.fine, [&coarse, &distances], &pooled, group)
}

fn apply_joined(
    tape: &mut Tape,
    net: &JoinedLayers<Value>,
    [places, distances]: [&Value; 2],
    pooled: &Value,
    group: usize,
) -> Value {
    let patch_of: Vec<u32> = (0..places.matrix().n_rows()).map(|row| (row / group) as u32).collect();
    // Pooled features are multiplied once per patch instead of once per point.
    let of_points = tape.concat_product(places, distances, &net.of_point);
    let of_patches = tape.affine(pooled, &net.of_patch[0], &net.of_patch[1]);
    let of_patches = tape.gather(&of_patches, &patch_of);
    let both = tape.plus(&of_points, &of_patches);
    let active = tape.relu(&both);
    tape.layers(&active, &[net.hidden.each_ref(), net.out.each_ref()])
}
