//! Roles and channels of vertex attributes, by name.

use super::schema::Primitive;
use crate::mesh::Role;

pub(super) const SKIN: &str = "SKIN";

pub(super) const TARGET: &str = "TARGET_";

/// Returns the role of an attribute, and its width if the specification fixes that.
pub(super) fn role(name: &str) -> (Role, Option<usize>) {
    match name {
        "NORMAL" => (Role::Normal, Some(3)),
        "TANGENT" => (Role::Tangent, Some(4)),
        _ if name.starts_with("TEXCOORD_") => (Role::Uv, Some(2)),
        _ if name.starts_with("COLOR_") => (Role::Colour, None),
        _ => (Role::Other, None),
    }
}

pub(super) fn target_role(name: &str) -> (Role, Option<usize>) {
    match name {
        "POSITION" => (Role::MorphPosition, Some(3)),
        "NORMAL" | "TANGENT" => (Role::MorphDirection, Some(3)),
        _ => (Role::Other, role(name).1),
    }
}

pub(super) fn target_channel(target: usize, name: &str) -> String {
    format!("{TARGET}{target}/{name}")
}

pub(super) fn target_of(channel: &str) -> Option<(usize, &str)> {
    let (target, name) = channel.strip_prefix(TARGET)?.split_once('/')?;
    Some((target.parse().ok()?, name))
}

// Positions, joints and weights have no channel of their own.
pub(super) fn is_own_channel(name: &str) -> bool {
    name != "POSITION" && !name.starts_with("JOINTS_") && !name.starts_with("WEIGHTS_")
}

pub(super) fn n_skin_sets(primitive: &Primitive) -> usize {
    let has = |name: &str, set: usize| primitive.attributes.contains_key(&format!("{name}_{set}"));
    (0..).take_while(|&set| has("JOINTS", set) && has("WEIGHTS", set)).count()
}
