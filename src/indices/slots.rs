//! Slots in the caller's vertex buffers for the vertices of a result that have moved.

use std::collections::hash_map::Entry;

use rustc_hash::FxHashMap;

/// Corner of a face in a result.
#[derive(Clone, Copy)]
pub struct ResultCorner {
    pub vertex: u32,
    pub wedge: u32,
    // Group of the corner's face.
    pub group: u32,
    // Nearest of the caller's vertices in the same group, if known.
    pub nearest: Option<u32>,
}

/// Assigns a slot to each corner: one per wedge of a group, at the nearest of the caller's vertices if that is free.
///
/// Each vertex of a group gets a slot before any gets a second one. Wedges without a slot of their own share that of
/// their vertex.
///
/// # Shapes
/// - `group_slots`: the groups and numbers of the caller's vertices, each at least once
/// - returns a slot below `n_slots` for each of `corners`
pub fn assign_slots(
    corners: &[ResultCorner],
    group_slots: impl Iterator<Item = (u32, u32)>,
    n_slots: usize,
) -> Vec<u32> {
    let mut free = FreeSlots { of_groups: FxHashMap::default(), is_taken: vec![false; n_slots] };
    group_slots.for_each(|(group, slot)| free.of_groups.entry(group).or_default().push(slot));
    // Vertices take the slots they came from first, so that as few as possible move in the buffers.
    let mut vertex_slots: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for corner in corners {
        if let (Entry::Vacant(entry), Some(nearest)) =
            (vertex_slots.entry([corner.vertex, corner.group]), corner.nearest)
            && free.take(nearest)
        {
            entry.insert(nearest);
        }
    }
    for corner in corners {
        let entry = vertex_slots.entry([corner.vertex, corner.group]);
        entry.or_insert_with(|| free.take_of_group(corner.group).or_else(|| free.take_any()).unwrap_or(0));
    }
    // The first wedge of a vertex has the vertex's slot; further wedges get the remaining slots.
    let (mut first_wedges, mut wedge_slots) = (FxHashMap::default(), FxHashMap::default());
    let slot_of_corner = |corner: &ResultCorner| {
        let vertex_slot = vertex_slots[&[corner.vertex, corner.group]];
        let wedge = [corner.wedge, corner.group];
        if *first_wedges.entry([corner.vertex, corner.group]).or_insert(wedge) == wedge {
            return vertex_slot;
        }
        *wedge_slots.entry(wedge).or_insert_with(|| {
            let nearest = corner.nearest.filter(|&nearest| free.take(nearest));
            nearest.or_else(|| free.take_of_group(corner.group)).unwrap_or(vertex_slot)
        })
    };
    corners.iter().map(slot_of_corner).collect()
}

struct FreeSlots {
    of_groups: FxHashMap<u32, Vec<u32>>,
    is_taken: Vec<bool>,
}

impl FreeSlots {
    fn take(&mut self, slot: u32) -> bool {
        !std::mem::replace(&mut self.is_taken[slot as usize], true)
    }

    fn take_of_group(&mut self, group: u32) -> Option<u32> {
        while let Some(slot) = self.of_groups.get_mut(&group).and_then(Vec::pop) {
            if self.take(slot) {
                return Some(slot);
            }
        }
        None
    }

    fn take_any(&mut self) -> Option<u32> {
        let slot = self.is_taken.iter().position(|taken| !taken)? as u32;
        self.take(slot).then_some(slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_come_before_further_wedges_and_groups_keep_to_their_own() {
        let corner = |vertex, wedge, group, nearest| ResultCorner { vertex, wedge, group, nearest: Some(nearest) };
        let corners =
            [corner(0, 0, 7, 5), corner(0, 1, 7, 6), corner(1, 2, 7, 6), corner(0, 3, 8, 9), corner(1, 2, 7, 5)];
        let group_slots = || [(7, 5), (7, 6), (8, 9), (8, 2)].into_iter();
        // Group 7 has two slots for two vertices; the second wedge shares.
        assert_eq!(assign_slots(&corners, group_slots(), 10), [5, 5, 6, 9, 6]);
        let more_slots = || group_slots().chain([(7, 4)]);
        assert_eq!(assign_slots(&corners, more_slots(), 10), [5, 4, 6, 9, 6]);
    }
}
