//! Mesh file of a request, with companion files.

use std::collections::BTreeMap;
use std::sync::Arc;

use neural_mesh::io::Folder;
use serde::Deserialize;

use crate::message::Message;
use crate::refusal::Refusal;

#[derive(Deserialize)]
pub struct File {
    pub name: String,
    bytes: usize,
    /// Number of the part that holds each companion file, by relative path.
    #[serde(default)]
    beside: BTreeMap<String, usize>,
}

impl File {
    /// Returns the bytes of the file and the folder of its companions.
    ///
    /// # Errors
    /// [`Refusal`] if the request lacks a part.
    pub fn open<'a>(&self, message: &Message<'a>) -> Result<(&'a [u8], Folder), Refusal> {
        let placed = |(name, &part): (&String, &usize)| Ok((name.clone(), Arc::from(message.part(part)?)));
        let beside: Vec<(String, Arc<[u8]>)> = self.beside.iter().map(placed).collect::<Result<_, Refusal>>()?;
        Ok((message.part(self.bytes)?, Folder::in_memory(beside)))
    }

    pub fn refusal(&self, why: impl std::fmt::Display) -> Refusal {
        Refusal::new(format!("{}: {why}", self.name))
    }
}
