//! Textures of a page: each once, at most 2048 pixels a side, 16 MiB in total.

use std::sync::Arc;

use neural_mesh::parallel;
use neural_mesh::picture::{ImageFormat, decode_image, encode_jpeg, encode_png, image_problem, shrink};

/// Largest sides of images in pixels, tried in turn while the total is too large.
const ALLOWED_SIDES: [usize; 5] = [2048, 1024, 512, 256, 128];
/// Bound on the total size of all images in bytes, before base64.
const MAX_BYTES: usize = 16 << 20;

#[derive(Default)]
pub struct Gallery {
    images: Vec<Arc<[u8]>>,
}

#[derive(Debug, PartialEq)]
pub struct FittedImage {
    /// PNG, JPEG or WebP file.
    pub bytes: Vec<u8>,
    pub kind: &'static str,
    pub width: usize,
    pub height: usize,
}

impl Gallery {
    pub fn index_of(&mut self, image: &Arc<[u8]>) -> usize {
        let is_same = |known: &Arc<[u8]>| Arc::ptr_eq(known, image) || known == image;
        self.images.iter().position(is_same).unwrap_or_else(|| {
            self.images.push(image.clone());
            self.images.len() - 1
        })
    }

    /// Returns the images as large as fits (`None` if unreadable), and notes on changes.
    pub fn fit_images(&self) -> (Vec<Option<FittedImage>>, Vec<String>) {
        fit_images_within(&self.images, MAX_BYTES)
    }
}

fn fit_images_within(images: &[Arc<[u8]>], most_bytes: usize) -> (Vec<Option<FittedImage>>, Vec<String>) {
    let each = most_bytes / images.len().max(1);
    // First all images unchanged, then each within an equal share of the bytes.
    let attempts = std::iter::once((ALLOWED_SIDES[0], usize::MAX)).chain(ALLOWED_SIDES.map(|side| (side, each)));
    let (mut fitted, mut smallest) = (Vec::new(), ALLOWED_SIDES[0]);
    for (side, most) in attempts {
        fitted = parallel::each(images, |image| fit_image(image, side, most));
        smallest = side;
        if total_bytes(&fitted) <= most_bytes {
            break;
        }
    }
    let mut notes = Vec::new();
    if let Some((image, _)) = images.iter().zip(&fitted).find(|(_, fitted)| fitted.is_none()) {
        notes.push(format!("the page leaves out a texture: it {}", image_problem(image)));
    }
    let is_changed = |(image, fitted): (&Arc<[u8]>, &Option<FittedImage>)| {
        fitted.as_ref().is_some_and(|fitted| fitted.kind == "image/jpeg" && fitted.bytes[..] != image[..])
    };
    if images.iter().zip(&fitted).any(is_changed) {
        notes.push(format!("textures are scaled down for the page: at most {smallest} pixels a side"));
    }
    if total_bytes(&fitted) > most_bytes {
        fitted = vec![(); images.len()].into_iter().map(|()| None).collect();
        notes.push(format!(
            "{} textures are too large for the page, even scaled down: it shows no textures",
            images.len()
        ));
    }
    (fitted, notes)
}

fn total_bytes(images: &[Option<FittedImage>]) -> usize {
    images.iter().flatten().map(|image| image.bytes.len()).sum()
}

/// Returns the image unchanged if it fits `side` and `most` bytes, else as a JPEG.
fn fit_image(bytes: &[u8], side: usize, most: usize) -> Option<FittedImage> {
    let image = decode_image(bytes)?;
    let smaller = || {
        let image = shrink(&image, side);
        let (bytes, kind) = (encode_jpeg(&image)?, "image/jpeg");
        Some(FittedImage { bytes, kind, width: image.width, height: image.height })
    };
    // Images that decoding halves are larger than any side of a page.
    if image.width.max(image.height) > side {
        return smaller();
    }
    let (kind, bytes) = match ImageFormat::from_signature(bytes)? {
        ImageFormat::Png => ("image/png", bytes.to_vec()),
        ImageFormat::WebP => ("image/webp", bytes.to_vec()),
        // Browsers cannot show KTX2.
        ImageFormat::Ktx2 => ("image/png", encode_png(&image)),
        _ => ("image/jpeg", bytes.to_vec()),
    };
    if bytes.len() > most {
        return smaller();
    }
    Some(FittedImage { bytes, kind, width: image.width, height: image.height })
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::picture::{Image, encode_png};

    fn noise(width: usize, height: usize) -> Arc<[u8]> {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let rgba = (0..width * height).flat_map(|_| [next(), next(), next(), 255]).collect();
        Arc::from(encode_png(&Image { width, height, rgba }))
    }

    #[test]
    fn an_image_that_fits_is_embedded_unchanged_and_once() {
        let mut gallery = Gallery::default();
        let image = noise(8, 4);
        assert_eq!(
            [gallery.index_of(&image), gallery.index_of(&Arc::from(&image[..])), gallery.index_of(&noise(4, 4))],
            [0, 0, 1]
        );
        let (fitted, notes) = gallery.fit_images();
        let first = fitted[0].as_ref().unwrap();
        assert_eq!((&first.bytes[..], first.kind, first.width, first.height), (&image[..], "image/png", 8, 4));
        assert!(notes.is_empty());
    }

    #[test]
    fn a_long_image_is_halved() {
        let (fitted, notes) = fit_images_within(&[noise(4100, 10)], MAX_BYTES);
        let image = fitted[0].as_ref().unwrap();
        assert_eq!((image.width, image.height, image.kind), (1025, 2, "image/jpeg"));
        let decoded = decode_image(&image.bytes).unwrap();
        assert_eq!((decoded.width, decoded.height), (1025, 2));
        assert_eq!(notes, ["textures are scaled down for the page: at most 2048 pixels a side"]);
    }

    #[test]
    fn all_images_together_stay_within_their_bound() {
        let images = [noise(600, 600), noise(500, 500), noise(16, 16)];
        let (within, notes) = fit_images_within(&images, 100_000);
        assert!(total_bytes(&within) <= 100_000 && within.iter().all(Option::is_some), "{}", total_bytes(&within));
        assert_eq!(within[2].as_ref().unwrap().bytes[..], images[2][..]);
        assert!(notes[0].contains("pixels a side"), "{notes:?}");
        let (none, notes) = fit_images_within(&images, 100);
        assert!(none.iter().all(Option::is_none) && notes.last().unwrap().contains("too large"));
    }

    #[test]
    fn an_unreadable_image_is_noted() {
        let (fitted, notes) = fit_images_within(&[Arc::from(&b"no image"[..])], MAX_BYTES);
        assert_eq!((fitted[0].is_none(), notes.len()), (true, 1));
    }
}
