//! Numbers of images by their content.

use std::collections::BTreeMap;
use std::sync::Arc;

use rustc_hash::FxHashMap;

/// Numbers of different images, in the order in which they came.
#[derive(Default)]
pub(super) struct DistinctImages<'a> {
    by_content: BTreeMap<&'a [u8], usize>,
    // Content is compared once for each address, as many materials may share a large image.
    by_address: FxHashMap<*const [u8], usize>,
}

impl<'a> DistinctImages<'a> {
    /// Returns the number of an image, which is that of an equal image that came before, if there is one.
    pub fn number(&mut self, image: &'a Arc<[u8]>) -> usize {
        let next = self.by_content.len();
        let find_equal = || *self.by_content.entry(image).or_insert(next);
        *self.by_address.entry(Arc::as_ptr(image)).or_insert_with(find_equal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_images_have_one_number() {
        let images: [Arc<[u8]>; 4] = [&b"a"[..], b"b", b"a", b"c"].map(Arc::from);
        let mut numbers = DistinctImages::default();
        assert_eq!([0, 1, 2, 0, 3].map(|at: usize| numbers.number(&images[at])), [0, 1, 0, 0, 2]);
    }
}
