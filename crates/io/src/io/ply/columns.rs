//! Vertex columns that form channels, by their names.

use std::collections::BTreeSet;

use super::header::{Element, PlyProperty};
use crate::io::Scalar;
use crate::io::extra::{Column, ColumnLayout};
use crate::mesh::{Channel, Role};

// Columns of one channel, by their names in files of various programs.
const FAMILIES: [(&str, Role, &[&str]); 11] = [
    ("colour", Role::Colour, &["red", "green", "blue", "alpha"]),
    ("colour", Role::Colour, &["red", "green", "blue"]),
    ("colour", Role::Colour, &["r", "g", "b", "a"]),
    ("colour", Role::Colour, &["r", "g", "b"]),
    ("colour", Role::Colour, &["diffuse_red", "diffuse_green", "diffuse_blue"]),
    ("normal", Role::Normal, &["nx", "ny", "nz"]),
    ("normal", Role::Normal, &["normal_x", "normal_y", "normal_z"]),
    ("uv", Role::Uv, &["s", "t"]),
    ("uv", Role::Uv, &["u", "v"]),
    ("uv", Role::Uv, &["texture_u", "texture_v"]),
    ("uv", Role::Uv, &["texture_s", "texture_t"]),
];

#[derive(Clone, Debug, PartialEq)]
pub(super) struct ChannelPlan {
    pub name: String,
    pub role: Role,
    pub properties: Vec<usize>,
}

impl ChannelPlan {
    pub fn for_element(element: &Element, taken: &[usize]) -> Vec<Self> {
        let is_free = |i: usize| element.properties[i].length.is_none() && !taken.contains(&i);
        let find =
            |name: &str| (0..element.properties.len()).find(|&i| is_free(i) && element.properties[i].name == name);
        let mut plans: Vec<Self> = Vec::new();
        // Known families come first, the longest before the others: alpha belongs to its colour.
        for (name, role, columns) in FAMILIES {
            let properties: Option<Vec<usize>> = columns.iter().map(|column| find(column)).collect();
            if let Some(properties) = properties.filter(|_| plans.iter().all(|plan| plan.name != name)) {
                plans.push(Self { name: name.into(), role, properties });
            }
        }
        let of_families: BTreeSet<usize> = plans.iter().flat_map(|plan| plan.properties.iter().copied()).collect();
        for (i, property) in element.properties.iter().enumerate().filter(|&(i, _)| is_free(i)) {
            if !of_families.contains(&i) {
                let role = if property.scalar.is_whole() { Role::Label } else { Role::Other };
                plans.push(Self { name: property.name.clone(), role, properties: vec![i] });
            }
        }
        // File order makes the writer repeat the same columns.
        plans.sort_by_key(|plan| plan.properties[0]);
        plans
    }

    pub fn layout(&self, properties: &[PlyProperty]) -> ColumnLayout {
        let column = |&i: &usize| Column { name: properties[i].name.clone(), scalar: properties[i].scalar };
        let columns = self.properties.iter().map(column).collect();
        ColumnLayout { channel: self.name.clone(), columns, per_corner: false }
    }
}

/// Returns the number that means 1.0 in a column of this type, such as 255.
pub(super) fn unit(role: Role, scalar: Scalar) -> f64 {
    match (role, scalar) {
        (Role::Colour, Scalar::U16) => 65_535.0,
        (Role::Colour, _) if scalar.is_whole() => 255.0,
        _ => 1.0,
    }
}

/// Returns the input's columns of a channel, `known`, if they fit, else the usual columns.
pub(super) fn layout_of(channel: &Channel, known: Option<&ColumnLayout>, n_before: usize) -> ColumnLayout {
    // The original layout fits only if the channel kept its width.
    let known = known.filter(|layout| layout.columns.len() == channel.width);
    known.cloned().unwrap_or_else(|| ColumnLayout {
        channel: channel.name.clone(),
        columns: usual_columns(channel, n_before),
        per_corner: false,
    })
}

fn usual_columns(channel: &Channel, n_before: usize) -> Vec<Column> {
    let all_in_unit_range = || channel.values.iter().all(|value| (0.0..=1.0).contains(value));
    // Colours become bytes only if they are within range.
    let scalar = match channel.role {
        Role::Colour if all_in_unit_range() => Scalar::U8,
        Role::Label => Scalar::I32,
        _ => Scalar::F32,
    };
    let usual: &[&str] = match channel.role {
        Role::Colour => &["red", "green", "blue", "alpha"],
        Role::Normal => &["nx", "ny", "nz"],
        Role::Tangent => &["tx", "ty", "tz", "tw"],
        Role::Uv => &["s", "t"],
        _ => &[],
    };
    let plain = |text: &str| text.replace(|letter: char| !letter.is_ascii_graphic(), "_");
    let name = |i: usize| match usual.get(i) {
        Some(name) if n_before == 0 => (*name).to_string(),
        Some(name) => format!("{name}{n_before}"),
        None if channel.width == 1 => plain(&channel.name),
        None => format!("{}_{i}", plain(&channel.name)),
    };
    (0..channel.width).map(|i| Column { name: name(i), scalar }).collect()
}
