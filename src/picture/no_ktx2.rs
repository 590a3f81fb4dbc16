//! Stub of `ktx2` for builds without that feature: decodes nothing, and names the feature.

use super::Image;

/// Why a KTX2 file has no pixels, and what to do.
pub(super) const PROBLEM: &str = "is KTX2: build with `--features ktx2`, or give it as PNG, JPEG or WebP";

/// Decodes nothing.
pub(super) fn decode(_: &[u8]) -> Option<Image> {
    None
}
