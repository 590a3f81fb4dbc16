//! Groups of an OBJ.

use rustc_hash::FxHashSet;

use crate::io::extra::{Group, decode_latin1, decode_text, has_too_many_groups};
use crate::mesh::DistinctKeys;

// Statements that set the group of the faces after them, in the order of `GroupState`.
const WORDS: [&[u8]; 4] = [b"o", b"g", b"usemtl", b"s"];

const KINDS: [&str; 4] = ["objects", "groups", "materials", "smoothing groups"];

// Object, group, material and smoothing group, if set.
type GroupState<'a> = [Option<&'a [u8]>; 4];

#[derive(Debug, Default)]
pub(super) struct ObjGroups<'a> {
    state: GroupState<'a>,
    changed: bool,
    current: u32,
    states: DistinctKeys<GroupState<'a>>,
    // Group of each triangle; empty while all triangles are in the first group.
    pub of_faces: Vec<u32>,
}

impl<'a> ObjGroups<'a> {
    /// Records the name that a group statement sets; returns false for other statements.
    pub fn take(&mut self, word: &[u8], rest: &'a [u8]) -> bool {
        let Some(kind) = WORDS.iter().position(|known| *known == word) else { return false };
        self.changed |= self.state[kind] != Some(rest);
        self.state[kind] = Some(rest);
        true
    }

    pub fn assign(&mut self, n_before: usize, n_faces: usize) {
        // Statements between two faces may cancel out, so the state is looked up only when a face follows.
        if std::mem::take(&mut self.changed) || self.states.keys.is_empty() {
            self.current = self.states.number(self.state);
        }
        // With one group there are no numbers to store.
        if self.states.keys.len() > 1 {
            self.of_faces.resize(n_before, 0);
            self.of_faces.resize(n_faces, self.current);
        }
    }

    /// Drops kinds of names that differ on nearly every face; returns one note per kind.
    pub fn drop_varied_names(&mut self) -> Vec<String> {
        let mut notes = Vec::new();
        // Such groups would forbid every collapse. One kind of name goes at a time: the others may still group faces
        // well.
        while has_too_many_groups(self.states.keys.len(), self.of_faces.len()) {
            let n_names =
                |kind: &usize| self.states.keys.iter().map(|state| state[*kind]).collect::<FxHashSet<_>>().len();
            let Some(kind) = (0..KINDS.len()).max_by_key(n_names) else { break };
            self.drop_names(kind);
            notes.push(format!("nearly every face has its own name of {}: these names are dropped", KINDS[kind]));
        }
        notes
    }

    fn drop_names(&mut self, kind: usize) {
        let states = std::mem::take(&mut self.states).keys;
        let mut number = |mut state: GroupState<'a>| {
            state[kind] = None;
            self.states.number(state)
        };
        let new_numbers: Vec<u32> = states.into_iter().map(&mut number).collect();
        if self.states.keys.len() > 1 {
            self.of_faces.iter_mut().for_each(|group| *group = new_numbers[*group as usize]);
        } else {
            self.of_faces.clear();
        }
    }

    pub fn names(&self) -> impl Iterator<Item = &'a [u8]> {
        self.states.keys.iter().flatten().copied().flatten()
    }

    pub fn to_groups(&self, in_latin1: bool) -> Vec<Group> {
        // A file without group statements has one unnamed state.
        if self.states.keys == [GroupState::default()] {
            return Vec::new();
        }
        let text =
            |name: Option<&[u8]>| name.map(|name| if in_latin1 { decode_latin1(name) } else { decode_text(name) });
        let named = |&[object, name, material, smoothing]: &GroupState| Group {
            object: text(object),
            name: text(name),
            material: text(material),
            smoothing: text(smoothing),
            values: Vec::new(),
        };
        self.states.keys.iter().map(named).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn make_groups(names: &[String]) -> ObjGroups<'_> {
        let mut groups = ObjGroups::default();
        for (face, name) in names.iter().enumerate() {
            groups.take(b"g", name.as_bytes());
            groups.take(b"usemtl", names[face - face % 100].as_bytes());
            groups.assign(face, face + 1);
        }
        groups
    }

    #[test]
    fn names_of_every_face_are_forgotten_and_others_stay() {
        let names: Vec<String> = (0..1000).map(|i| format!("n{i}")).collect();
        let mut groups = make_groups(&names);
        assert_eq!(
            groups.drop_varied_names(),
            ["nearly every face has its own name of groups: these names are dropped"]
        );
        let named = groups.to_groups(false);
        assert_eq!((named.len(), named[3].name.as_deref(), named[3].material.as_deref()), (10, None, Some("n300")));
        assert_eq!((groups.of_faces.len(), groups.of_faces[399], groups.of_faces[400]), (1000, 3, 4));
        assert!(make_groups(&names[..256]).drop_varied_names().is_empty());
    }

    #[test]
    fn where_all_names_are_forgotten_there_are_no_groups() {
        let names: Vec<String> = (0..400).map(|i| format!("n{i}")).collect();
        let mut groups = ObjGroups::default();
        for (face, name) in names.iter().enumerate() {
            groups.take(b"o", name.as_bytes());
            groups.assign(face, face + 1);
        }
        assert_eq!(groups.drop_varied_names().len(), 1);
        assert!(groups.to_groups(false).is_empty() && groups.of_faces.is_empty());
    }
}
