//! Stub of `gzip` for builds without it.

use std::borrow::Cow;

use super::ReadError;

pub(super) fn decompress(bytes: &[u8]) -> Result<Cow<'_, [u8]>, ReadError> {
    match bytes {
        [0x1f, 0x8b, ..] => {
            Err(ReadError::file("this build reads no gzip", "build with the feature gzip or unpack the file"))
        }
        _ => Ok(Cow::Borrowed(bytes)),
    }
}

pub(super) fn compress(_: &[u8]) -> std::io::Result<Vec<u8>> {
    Err(std::io::Error::other("this build writes no gzip"))
}
