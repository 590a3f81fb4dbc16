//! What the names of vertex attributes mean, and which channels a set of primitives has.

use super::schema::Primitive;
use crate::mesh::Role;

/// The name of the channel that holds all joints and weights of a vertex.
pub(super) const SKIN: &str = "SKIN";

/// How the names of the channels of morph targets begin.
pub(super) const TARGET: &str = "TARGET_";

/// The role of a vertex attribute, and how many numbers it has by the specification, if it fixes that.
pub(super) fn role(name: &str) -> (Role, Option<usize>) {
    match name {
        "NORMAL" => (Role::Normal, Some(3)),
        "TANGENT" => (Role::Tangent, Some(4)),
        _ if name.starts_with("TEXCOORD_") => (Role::Uv, Some(2)),
        _ if name.starts_with("COLOR_") => (Role::Colour, None),
        _ => (Role::Other, None),
    }
}

/// The role of what a morph target adds to an attribute.
pub(super) fn target_role(name: &str) -> (Role, Option<usize>) {
    match name {
        "POSITION" => (Role::MorphPosition, Some(3)),
        "NORMAL" | "TANGENT" => (Role::MorphDirection, Some(3)),
        _ => (Role::Other, role(name).1),
    }
}

/// The channel of what morph target `target` adds to the attribute `name`.
pub(super) fn target_channel(target: usize, name: &str) -> String {
    format!("{TARGET}{target}/{name}")
}

/// The number and the attribute of a channel of a morph target.
pub(super) fn target_of(channel: &str) -> Option<(usize, &str)> {
    let (target, name) = channel.strip_prefix(TARGET)?.split_once('/')?;
    Some((target.parse().ok()?, name))
}

/// Whether an attribute is held by a channel of its own name: not positions, and not what [`SKIN`] holds.
pub(super) fn is_own_channel(name: &str) -> bool {
    name != "POSITION" && !name.starts_with("JOINTS_") && !name.starts_with("WEIGHTS_")
}

/// How many sets of four joints and weights the vertices of a primitive have.
pub(super) fn n_skin_sets(primitive: &Primitive) -> usize {
    let has = |name: &str, set: usize| primitive.attributes.contains_key(&format!("{name}_{set}"));
    (0..).take_while(|&set| has("JOINTS", set) && has("WEIGHTS", set)).count()
}
