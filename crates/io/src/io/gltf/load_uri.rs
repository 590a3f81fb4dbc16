//! URIs: loading of the bytes that one names, and names as URIs.

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::refusals::REMEDY;
use crate::io::{FileFetcher, ReadError};

pub(super) fn load_uri(uri: &str, fetch: &FileFetcher) -> Result<Vec<u8>, ReadError> {
    let Some(data) = uri.strip_prefix("data:") else { return fetch(uri) };
    let lenient = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    let engine = GeneralPurpose::new(&base64::alphabet::STANDARD, lenient);
    let text = data.split_once(";base64,").map(|(_, text)| text.trim_ascii());
    let bytes = text.and_then(|text| engine.decode(text).ok());
    bytes.ok_or_else(|| ReadError::file("a buffer whose data URI is not base64", REMEDY))
}

pub(super) fn encode_percent(name: &str) -> String {
    let mut uri = String::new();
    for byte in name.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => uri.push(char::from(byte)),
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}
