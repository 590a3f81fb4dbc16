//! Attributes of XML elements.

use std::borrow::Cow;

use quick_xml::XmlVersion;
use quick_xml::events::BytesStart;

/// Returns the value of an attribute by its name, with or without prefix.
pub fn attribute<'a>(element: &'a BytesStart, name: &str) -> Option<Cow<'a, str>> {
    let mut attributes = element.attributes();
    let named = attributes
        .with_checks(false)
        .flatten()
        .find(|it| it.key.into_inner() == name || it.key.local_name().into_inner() == name)?;
    named.normalized_value(XmlVersion::Implicit1_0).ok().or(Some(named.value))
}
