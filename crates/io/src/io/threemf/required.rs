//! Required extensions of a 3MF.

use quick_xml::events::BytesStart;

use super::xml_attribute::attribute;
use crate::io::{ReadError, shorten_name};

// Parts of the namespaces of accepted extensions, without the year. Production adds parts; materials and triangle sets
// add attributes.
const KNOWN: [&str; 3] =
    ["/3dmanufacturing/production/", "/3dmanufacturing/material/", "/3dmanufacturing/trianglesets/"];

pub(super) fn refuse_unknown(model: &BytesStart) -> Result<(), ReadError> {
    for prefix in attribute(model, "requiredextensions").unwrap_or_default().split_whitespace() {
        // The list has prefixes; namespaces declare what they mean.
        let namespace = attribute(model, &format!("xmlns:{prefix}")).unwrap_or_else(|| prefix.to_string().into());
        if !KNOWN.iter().any(|known| namespace.contains(known)) {
            let what = format!("needs the extension {:?}", shorten_name(&namespace));
            return Err(ReadError::file(what, "export the file without it"));
        }
    }
    Ok(())
}
