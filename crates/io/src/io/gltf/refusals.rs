//! Errors and limits that the readers of glTF share.

use crate::io::ReadError;

pub const REMEDY: &str = "export the asset again";

/// Extension that repeats meshes and that this reader rejects.
const REFUSED: &str = "EXT_mesh_gpu_instancing";

/// Rejects assets that need the extension which repeats meshes.
pub fn refuse_instancing(extensions_required: &[String]) -> Result<(), ReadError> {
    match extensions_required.iter().any(|needed| needed == REFUSED) {
        true => Err(ReadError::file(format!("needs the extension {REFUSED}"), "export the asset without it")),
        false => Ok(()),
    }
}

/// Takes `n` vertices or faces from the budget, which keeps a small file from claiming all memory.
pub fn spend(budget: &mut usize, n: usize) -> Result<(), ReadError> {
    *budget = budget
        .checked_sub(n)
        .ok_or_else(|| ReadError::file("the asset repeats its meshes too often", "export fewer instances"))?;
    Ok(())
}

/// Makes the error for an index beyond its array.
pub fn missing_error(what: &str, index: usize) -> ReadError {
    ReadError::file(format!("there is no {what} {index}"), REMEDY)
}
