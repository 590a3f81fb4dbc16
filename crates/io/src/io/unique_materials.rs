//! Unique names for materials and other things.

use rustc_hash::{FxHashMap, FxHashSet};

use super::one_line::one_line;
use crate::mesh::Look;

#[derive(Default)]
pub(super) struct UniqueNames {
    taken: FxHashSet<String>,
    counts: FxHashMap<String, usize>,
}

impl UniqueNames {
    /// Returns the name, with a number behind it if it is taken.
    pub fn add(&mut self, plain: &str) -> String {
        let count = self.counts.entry(plain.into()).or_default();
        let mut name = plain.to_string();
        // The file may already use the name with the appended number.
        while !self.taken.insert(name.clone()) {
            *count += 1;
            name = format!("{plain} {}", *count + 1);
        }
        name
    }
}

#[derive(Default)]
pub(super) struct UniqueMaterials {
    pub looks: Vec<(String, Look)>,
    names: UniqueNames,
    // Unique names, by name in the file, colour and opacity.
    known: FxHashMap<(String, [u32; 3], bool), String>,
}

impl UniqueMaterials {
    pub fn add(&mut self, name: &str, look: Look) -> String {
        // Other formats put a name on one line, so it must have no line breaks.
        let words = one_line(name);
        let plain = if words.is_empty() { "material".to_string() } else { words };
        let key = (plain, look.colour.map(f32::to_bits), look.finish.is_opaque);
        // Equal names with equal colour and opacity are one material.
        if let Some(name) = self.known.get(&key) {
            return name.clone();
        }
        let name = self.names.add(&key.0);
        self.known.insert(key, name.clone());
        self.looks.push((name.clone(), look));
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_is_of_one_look() {
        let mut names = UniqueMaterials::default();
        let grey = || Look { colour: [0.5; 3], ..Look::default() };
        assert_eq!(names.add("a\n b", Look::default()), "a b");
        assert_eq!(names.add("a b", grey()), "a b 2");
        assert_eq!(names.add("a b 2", Look::default()), "a b 2 2");
        assert_eq!((names.add(" a b", grey()), names.add("", grey())), ("a b 2".into(), "material".into()));
        assert_eq!(names.looks.len(), 4);
    }
}
