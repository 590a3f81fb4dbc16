//! Files of a request: a mesh and the files it refers to.

use std::collections::BTreeMap;
use std::sync::Arc;

use neural_mesh::io::Folder;
use serde::Deserialize;

use crate::message::Message;
use crate::refusal::Refusal;

/// A file as parts of the request.
#[derive(Deserialize)]
pub struct File {
    /// File name.
    pub name: String,
    /// Part of its bytes.
    bytes: usize,
    /// Parts of the files it may refer to, by relative path.
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

    /// Creates an error for this file.
    pub fn refusal(&self, why: impl std::fmt::Display) -> Refusal {
        Refusal::new(format!("{}: {why}", self.name))
    }
}
