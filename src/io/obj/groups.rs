//! The groups of an OBJ: faces under the same object, group, material and smoothing are of one.

use rustc_hash::FxHashMap;

use crate::io::extra::{Group, decoded, latin1};

/// The words that name what following faces belong to, in the order of [`State`].
const WORDS: [&[u8]; 4] = [b"o", b"g", b"usemtl", b"s"];

/// What faces belong to: object, group, material, smoothing, where they were named.
type State<'a> = [Option<&'a [u8]>; 4];

/// The groups met so far.
#[derive(Debug, Default)]
pub(super) struct Groups<'a> {
    state: State<'a>,
    changed: bool,
    current: u32,
    numbers: FxHashMap<State<'a>, u32>,
    states: Vec<State<'a>>,
    /// The group of each triangle; empty while all are of the first.
    pub of_faces: Vec<u32>,
}

impl<'a> Groups<'a> {
    /// Takes a statement; false where it is none about groups.
    pub fn take(&mut self, word: &[u8], rest: &'a [u8]) -> bool {
        let Some(kind) = WORDS.iter().position(|known| *known == word) else { return false };
        self.changed |= self.state[kind] != Some(rest);
        self.state[kind] = Some(rest);
        true
    }

    /// Counts the triangles up to `n_faces` to the current group; `n_before` of them are counted already.
    pub fn cover(&mut self, n_before: usize, n_faces: usize) {
        if std::mem::take(&mut self.changed) || self.states.is_empty() {
            self.current = *self.numbers.entry(self.state).or_insert_with(|| {
                self.states.push(self.state);
                self.states.len() as u32 - 1
            });
        }
        if self.states.len() > 1 {
            self.of_faces.resize(n_before, 0);
            self.of_faces.resize(n_faces, self.current);
        }
    }

    /// All names, as bytes.
    pub fn names(&self) -> impl Iterator<Item = &'a [u8]> {
        self.states.iter().flatten().copied().flatten()
    }

    /// The groups by name, none where the one group has none.
    pub fn named(&self, in_latin1: bool) -> Vec<Group> {
        if self.states.len() == 1 && self.states[0] == State::default() {
            return Vec::new();
        }
        let text = |name: Option<&[u8]>| name.map(|name| if in_latin1 { latin1(name) } else { decoded(name) });
        let named = |&[object, name, material, smoothing]: &State| Group {
            object: text(object),
            name: text(name),
            material: text(material),
            smoothing: text(smoothing),
            values: Vec::new(),
        };
        self.states.iter().map(named).collect()
    }
}
