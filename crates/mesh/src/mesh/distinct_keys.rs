//! Numbers of different keys.

use std::hash::Hash;

use rustc_hash::FxHashMap;

/// Different keys, numbered in the order in which they come.
#[derive(Debug)]
pub struct DistinctKeys<K> {
    numbers: FxHashMap<K, u32>,
    /// Keys in the order of their numbers.
    pub keys: Vec<K>,
}

impl<K> Default for DistinctKeys<K> {
    fn default() -> Self {
        Self { numbers: FxHashMap::default(), keys: Vec::new() }
    }
}

impl<K: Clone + Eq + Hash> DistinctKeys<K> {
    /// Returns the number of a key, which is that of an equal key before.
    pub fn number(&mut self, key: K) -> u32 {
        *self.numbers.entry(key).or_insert_with_key(|key| {
            self.keys.push(key.clone());
            self.keys.len() as u32 - 1
        })
    }
}
