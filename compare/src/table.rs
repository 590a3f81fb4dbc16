//! Tables of rows as CSV files.

use std::path::Path;

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// All rows of a table; none where the file does not exist.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let mut reader = csv::Reader::from_path(path)?;
    reader.deserialize().map(|row| row.with_context(|| format!("a row of {}", path.display()))).collect()
}

/// Writes the table, whole or not at all.
pub fn write<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    let temporary = path.with_extension("partial");
    let mut writer = csv::Writer::from_path(&temporary)?;
    for row in rows {
        writer.serialize(row)?;
    }
    writer.flush()?;
    Ok(std::fs::rename(&temporary, path)?)
}
