//! Stub of `ktx2` for builds without it: decodes nothing.

use super::Image;

pub(super) const PROBLEM: &str = "is KTX2: build with `--features ktx2`, or give it as PNG, JPEG or WebP";

pub(super) fn decode(_: &[u8]) -> Option<Image> {
    None
}
