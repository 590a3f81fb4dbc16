//! Files of a request: a mesh, and what it names beside it.

use std::collections::BTreeMap;
use std::sync::Arc;

use neural_mesh::io::Folder;
use serde::Deserialize;

use crate::message::Message;
use crate::refusal::Refusal;

/// A file by the parts of the request.
#[derive(Deserialize)]
pub struct File {
    /// File name.
    pub name: String,
    /// Part of its bytes.
    bytes: usize,
    /// Parts of the files that it may name, by their paths from it on.
    #[serde(default)]
    beside: BTreeMap<String, usize>,
}

impl File {
    /// Returns its bytes and the folder that it lies in.
    ///
    /// # Errors
    /// [`Refusal`] where the request lacks a part.
    pub fn open<'a>(&self, message: &Message<'a>) -> Result<(&'a [u8], Folder), Refusal> {
        let placed = |(name, &part): (&String, &usize)| Ok((name.clone(), Arc::from(message.part(part)?)));
        let beside: Vec<(String, Arc<[u8]>)> = self.beside.iter().map(placed).collect::<Result<_, Refusal>>()?;
        Ok((message.part(self.bytes)?, Folder::in_memory(beside)))
    }

    /// A refusal of this file, by its name.
    pub fn refusal(&self, why: impl std::fmt::Display) -> Refusal {
        Refusal::new(format!("{}: {why}", self.name))
    }
}
