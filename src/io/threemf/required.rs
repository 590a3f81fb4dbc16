//! The extensions without which a 3MF is not what it shows: those that change no triangle are passed, others are refused by name.

use quick_xml::events::BytesStart;

use super::field;
use crate::io::ReadError;

/// What the names of known extensions hold; the rest of a name is a year. Production has parts beside the first; materials and
/// sets of triangles change no shape.
const KNOWN: [&str; 3] =
    ["/3dmanufacturing/production/", "/3dmanufacturing/material/", "/3dmanufacturing/trianglesets/"];

/// Refuses a model that needs an extension of which no triangle may be read without it.
pub(super) fn refuse_unknown(model: &BytesStart) -> Result<(), ReadError> {
    for prefix in field(model, "requiredextensions").unwrap_or_default().split_whitespace() {
        let namespace = field(model, &format!("xmlns:{prefix}")).unwrap_or_else(|| prefix.to_string().into());
        if !KNOWN.iter().any(|known| namespace.contains(known)) {
            let what = format!("needs the extension {namespace:?}");
            return Err(ReadError::file(what, "export the file without it"));
        }
    }
    Ok(())
}
