//! Forward pass of a network over patches.

use crate::learned_baselines::{layer, layers, tensor};
use neural_mesh::autodiff::{Tape, Tensors, Value};

/// Applies the network of this name, `classifier` or `map`, to patches of equal size.
///
/// # Shapes
/// - `places`: (n_patches * group) x 3, each patch's own point first and at the origin
/// - returns (n_patches * group) x n_out
pub fn forward(tape: &mut Tape, tensors: &Tensors<Value>, network: &str, places: &Value, group: usize) -> Value {
    let of_network = |name: &str| format!("{network}.{name}");
    let distances = tape.group_distances(places, group);
    let pointwise = layers(tensors, &of_network("pointwise"), 5);
    let [first, first_bias] = pointwise[0];
    let seen = tape.concat_product(places, &distances, first);
    let seen = tape.plus_row(&seen, first_bias);
    let seen = tape.relu(&seen);
    let pooled = tape.layers_group_max(&seen, &pointwise[1..], group);
    let mut pooled = tape.relu(&pooled);
    for [weights, bias] in layers(tensors, &of_network("pooled"), 2) {
        let mapped = tape.affine(&pooled, weights, bias);
        pooled = tape.relu(&mapped);
    }
    let coarse = apply_joined(tape, tensors, &of_network("coarse"), [places, &distances], &pooled, group);
    let distances = tape.group_distances(&coarse, group);
    apply_joined(tape, tensors, &of_network("fine"), [&coarse, &distances], &pooled, group)
}

fn apply_joined(
    tape: &mut Tape,
    tensors: &Tensors<Value>,
    stage: &str,
    [places, distances]: [&Value; 2],
    pooled: &Value,
    group: usize,
) -> Value {
    let of_stage = |name: &str| layer(tensors, &format!("{stage}.{name}"));
    let patch_of: Vec<u32> = (0..places.matrix().n_rows()).map(|row| (row / group) as u32).collect();
    // Pooled features are multiplied once per patch instead of once per point.
    let of_points = tape.concat_product(places, distances, tensor(tensors, &format!("{stage}.of_point")));
    let [weights, bias] = of_stage("of_patch");
    let of_patches = tape.affine(pooled, weights, bias);
    let of_patches = tape.gather(&of_patches, &patch_of);
    let both = tape.plus(&of_points, &of_patches);
    let active = tape.relu(&both);
    tape.layers(&active, &[of_stage("hidden"), of_stage("out")])
}
