//! Kept faces, which the result contains unchanged with their corner values.

use std::collections::hash_map::Entry;

use rustc_hash::FxHashMap;

use crate::mesh::Attributes;
use crate::simplify::closed::faces_around::smallest_first;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::output::Output;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeptFace {
    pub face: u32,
    pub source: u32,
    pub corners: [u8; 3],
}

/// Finds the kept faces in the output; `is_kept` marks input faces, or is empty.
pub fn find_kept(original: &Original, output: &Output, is_kept: &[bool]) -> Vec<KeptFace> {
    let surface = &original.surface;
    let output_corners = |face: u32| surface.faces[face as usize].map(|v| output.vertex_of[v as usize]);
    let kept = (0u32..).zip(is_kept).filter(|(_, is_kept)| **is_kept);
    let source_of: FxHashMap<[u32; 3], u32> =
        kept.map(|(source, _)| (smallest_first(output_corners(source)), source)).collect();
    if source_of.is_empty() {
        return Vec::new();
    }
    let found = |(face, &corners): (u32, &[u32; 3])| {
        // On a one-sided surface, such as a Möbius strip, the output may wind the face the other way.
        let [a, b, c] = corners;
        let source = source_of.get(&smallest_first([a, b, c])).or_else(|| source_of.get(&smallest_first([a, c, b])))?;
        let of_mesh = original.mesh.faces()[*source as usize];
        let now = output_corners(*source);
        let corner = |v: u32| {
            let copy = now.iter().position(|&w| w == v).unwrap_or(0);
            let vertex = surface.source(surface.faces[*source as usize][copy]);
            of_mesh.iter().position(|&w| w == vertex).unwrap_or(0) as u8
        };
        Some(KeptFace { face, source: *source, corners: corners.map(corner) })
    };
    (0u32..).zip(output.faces()).filter_map(found).collect()
}

/// Gives corners of kept faces their input values, `own`; splits wedges where these differ.
pub fn restore_values(carried: &mut Attributes, own: &Attributes, kept: &[KeptFace]) {
    if own.channels.is_empty() || carried.channels.is_empty() {
        return;
    }
    let n_before = carried.n_wedges() as u32;
    let mut source_of: FxHashMap<u32, u32> = FxHashMap::default();
    let mut split: FxHashMap<(u32, u32), u32> = FxHashMap::default();
    for &KeptFace { face, source, corners } in kept {
        for (wedge, corner) in carried.wedges[face as usize].iter_mut().zip(corners) {
            let own_wedge = own.wedges[source as usize][usize::from(corner)];
            // The first value takes the wedge, equal values share it, others get a new wedge.
            match source_of.entry(*wedge) {
                Entry::Vacant(free) => _ = free.insert(own_wedge),
                Entry::Occupied(taken) if are_alike(own, *taken.get(), own_wedge) => {}
                Entry::Occupied(_) => {
                    let next = n_before + split.len() as u32;
                    *wedge = *split.entry((*wedge, own_wedge)).or_insert(next);
                }
            }
        }
    }
    let n_wedges = n_before as usize + split.len();
    source_of.extend(split.into_iter().map(|((_, own_wedge), wedge)| (wedge, own_wedge)));
    for (near, channel) in carried.channels.iter_mut().enumerate() {
        channel.values.resize(n_wedges * channel.width, 0.0);
        let Some(own) = own.find_channel(&channel.name, near).map(|at| &own.channels[at]) else { continue };
        for (&wedge, &own_wedge) in &source_of {
            channel.values[wedge as usize * channel.width..][..channel.width].copy_from_slice(own.value(own_wedge));
        }
    }
}

fn are_alike(attributes: &Attributes, a: u32, b: u32) -> bool {
    a == b || attributes.channels.iter().all(|channel| channel.value(a) == channel.value(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Channel, Role};

    fn single_channel(wedges: Vec<[u32; 3]>, values: Vec<f32>) -> Attributes {
        let channel = Channel { name: "a".into(), role: Role::Other, width: 1, values };
        Attributes { wedges, channels: vec![channel], groups: Vec::new() }
    }

    #[test]
    fn kept_corners_take_their_values_and_wedges_of_two_values_are_split() {
        let own = single_channel(vec![[0, 1, 2], [3, 2, 1]], vec![10.0, 11.0, 12.0, 13.0]);
        // Wedge 0 is shared by corners of values 10 and 13, wedge 3 by a face that is not kept.
        let mut carried = single_channel(vec![[0, 1, 3], [0, 3, 1], [0, 3, 4]], vec![1.0, 2.0, 3.0, 4.0, 5.0]);
        let kept = [(0, 0, [0, 1, 2]), (1, 1, [0, 1, 2])];
        let kept = kept.map(|(face, source, corners)| KeptFace { face, source, corners });
        restore_values(&mut carried, &own, &kept);
        let values = |face: usize| carried.wedges[face].map(|wedge| carried.channels[0].value(wedge)[0]);
        assert_eq!([values(0), values(1), values(2)], [[10.0, 11.0, 12.0], [13.0, 12.0, 11.0], [10.0, 12.0, 5.0]]);
        assert!(carried.is_valid_for(3));
    }

    #[test]
    fn attributes_without_channels_stay_empty() {
        let mut carried = Attributes::default();
        restore_values(&mut carried, &Attributes::default(), &[KeptFace { face: 0, source: 0, corners: [0, 1, 2] }]);
        assert_eq!(carried, Attributes::default());
    }
}
