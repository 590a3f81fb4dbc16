//! Places in the caller's buffers for the vertices of a result that have moved.

use std::collections::hash_map::Entry;

use rustc_hash::FxHashMap;

/// A corner of a result.
#[derive(Clone, Copy)]
pub struct Corner {
    /// Its vertex.
    pub vertex: u32,
    /// Its wedge.
    pub wedge: u32,
    /// The group of its face.
    pub group: u32,
    /// The caller's vertex, of a face of its group, that it came from; none where that is not known.
    pub near: Option<u32>,
}

/// Returns a place for each corner: one for each wedge of a group, where it comes from as far as that is free, else where its group has one. Each vertex
/// of a group has a place before any has two; wedges that get none share that of their vertex.
///
/// # Shapes
/// - `of_groups`: the group and the number of each of the caller's vertices, at least once
/// - returns a place below `n_places` for each of `corners`
pub fn assign_places(corners: &[Corner], of_groups: impl Iterator<Item = (u32, u32)>, n_places: usize) -> Vec<u32> {
    let mut free = Free { of_groups: FxHashMap::default(), is_taken: vec![false; n_places] };
    of_groups.for_each(|(group, place)| free.of_groups.entry(group).or_default().push(place));
    let mut heads: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for corner in corners {
        if let (Entry::Vacant(head), Some(near)) = (heads.entry([corner.vertex, corner.group]), corner.near)
            && free.take(near)
        {
            head.insert(near);
        }
    }
    for corner in corners {
        let head = heads.entry([corner.vertex, corner.group]);
        head.or_insert_with(|| free.of_group(corner.group).or_else(|| free.of_any()).unwrap_or(0));
    }
    let (mut first, mut of_wedges) = (FxHashMap::default(), FxHashMap::default());
    let of_corner = |corner: &Corner| {
        let head = heads[&[corner.vertex, corner.group]];
        let wedge = [corner.wedge, corner.group];
        if *first.entry([corner.vertex, corner.group]).or_insert(wedge) == wedge {
            return head;
        }
        *of_wedges.entry(wedge).or_insert_with(|| {
            let near = corner.near.filter(|&near| free.take(near));
            near.or_else(|| free.of_group(corner.group)).unwrap_or(head)
        })
    };
    corners.iter().map(of_corner).collect()
}

/// Places that nobody has yet.
struct Free {
    of_groups: FxHashMap<u32, Vec<u32>>,
    is_taken: Vec<bool>,
}

impl Free {
    /// Takes a place; whether it was free.
    fn take(&mut self, place: u32) -> bool {
        !std::mem::replace(&mut self.is_taken[place as usize], true)
    }

    /// Takes some place of a group.
    fn of_group(&mut self, group: u32) -> Option<u32> {
        while let Some(place) = self.of_groups.get_mut(&group).and_then(Vec::pop) {
            if self.take(place) {
                return Some(place);
            }
        }
        None
    }

    /// Takes any place.
    fn of_any(&mut self) -> Option<u32> {
        let place = self.is_taken.iter().position(|taken| !taken)? as u32;
        self.take(place).then_some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_come_before_further_wedges_and_groups_keep_to_their_own() {
        let corner = |vertex, wedge, group, near| Corner { vertex, wedge, group, near: Some(near) };
        let corners =
            [corner(0, 0, 7, 5), corner(0, 1, 7, 6), corner(1, 2, 7, 6), corner(0, 3, 8, 9), corner(1, 2, 7, 5)];
        let of_groups = || [(7, 5), (7, 6), (8, 9), (8, 2)].into_iter();
        // Group 7 has two places for two vertices; the second wedge shares.
        assert_eq!(assign_places(&corners, of_groups(), 10), [5, 5, 6, 9, 6]);
        let of_more = || of_groups().chain([(7, 4)]);
        assert_eq!(assign_places(&corners, of_more(), 10), [5, 4, 6, 9, 6]);
    }
}
