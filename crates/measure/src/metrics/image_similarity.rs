//! Similarity of images.

/// Side of an SSIM window in pixels.
const WINDOW: usize = 8;

/// Returns the structural similarity of two grey images, 1 if equal.
///
/// Mean of Eq. (13) in Wang et al. 2004, "Image quality assessment: from error visibility to structural similarity",
/// over windows of 8 x 8 pixels, four apart. `None` if the sizes differ or hold no window.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::metrics::ssim;
/// let ramp: Vec<u8> = (0..=255).collect();
/// let turned: Vec<u8> = ramp.iter().rev().copied().collect();
/// assert_eq!(ssim(16, &ramp, &ramp), Some(1.0));
/// assert!(ssim(16, &ramp, &turned).unwrap() < 0.0);
/// ```
pub fn ssim(width: usize, a: &[u8], b: &[u8]) -> Option<f64> {
    if a.len() != b.len() || width < WINDOW || !a.len().is_multiple_of(width) || a.len() < WINDOW * width {
        return None;
    }
    let rows = (0..=a.len() / width - WINDOW).step_by(WINDOW / 2);
    let starts = rows.flat_map(|row| (0..=width - WINDOW).step_by(WINDOW / 2).map(move |column| row * width + column));
    let likeness: Vec<f64> = starts.map(|start| window_ssim(width, &a[start..], &b[start..])).collect();
    Some(likeness.iter().sum::<f64>() / likeness.len() as f64)
}

fn window_ssim(width: usize, a: &[u8], b: &[u8]) -> f64 {
    let [mut x, mut y, mut xx, mut yy, mut xy] = [0u32; 5];
    for row in 0..WINDOW {
        let pixels = row * width..row * width + WINDOW;
        for (&p, &q) in a[pixels.clone()].iter().zip(&b[pixels]) {
            let (p, q) = (u32::from(p), u32::from(q));
            (x, y, xx, yy, xy) = (x + p, y + q, xx + p * p, yy + q * q, xy + p * q);
        }
    }
    let n = (WINDOW * WINDOW) as f64;
    let [x, y, xx, yy, xy] = [x, y, xx, yy, xy].map(|sum| f64::from(sum) / n);
    let (c1, c2) = ((0.01f64 * 255.0).powi(2), (0.03f64 * 255.0).powi(2));
    let mean = (2.0 * x * y + c1) / (x * x + y * y + c1);
    mean * (2.0 * (xy - x * y) + c2) / (xx - x * x + yy - y * y + c2)
}

/// Returns the peak signal-to-noise ratio of two byte buffers in decibels, infinite if equal.
///
/// `None` if the lengths differ or are 0.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::metrics::psnr;
/// assert_eq!(psnr(&[0, 255], &[0, 255]), Some(f64::INFINITY));
/// assert_eq!(psnr(&[0, 0], &[255, 255]), Some(0.0));
/// ```
pub fn psnr(a: &[u8], b: &[u8]) -> Option<f64> {
    let squares = a.iter().zip(b).map(|(p, q)| u64::from(p.abs_diff(*q)).pow(2)).sum::<u64>() as f64;
    let mean = squares / a.len() as f64;
    (a.len() == b.len() && !a.is_empty()).then(|| 10.0 * (255.0f64.powi(2) / mean).log10())
}

/// Returns the intersection over union of two silhouettes, 1 if both are empty; `None` if the sizes differ.
///
/// A silhouette is the covered part of each pixel, in any unit.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::metrics::silhouette_iou;
/// assert_eq!(silhouette_iou(&[9, 9, 0], &[9, 3, 6]), Some(0.5));
/// ```
pub fn silhouette_iou(a: &[u8], b: &[u8]) -> Option<f64> {
    let sum = |of_pixel: fn(u8, u8) -> u8| a.iter().zip(b).map(|(p, q)| u64::from(of_pixel(*p, *q))).sum::<u64>();
    let (shared, together) = (sum(u8::min), sum(u8::max));
    (a.len() == b.len()).then_some(if together > 0 { shared as f64 / together as f64 } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_are_alike_and_noise_is_less_so() {
        let picture: Vec<u8> = (0..32 * 24).map(|i| (i % 32 * 7 + i / 32 * 3) as u8).collect();
        let with_noise = |strength: usize| -> Vec<u8> {
            picture
                .iter()
                .enumerate()
                .map(|(i, &p)| p.saturating_add((i * 2_654_435_761 % 17 * strength) as u8))
                .collect()
        };
        let likeness = [0, 1, 3].map(|strength| ssim(32, &picture, &with_noise(strength)).unwrap());
        assert!(likeness[0] == 1.0 && likeness[1] < 1.0 && likeness[2] < likeness[1], "{likeness:?}");
        let decibels = [0, 1, 3].map(|strength| psnr(&picture, &with_noise(strength)).unwrap());
        assert!(decibels[0].is_infinite() && decibels[2] < decibels[1], "{decibels:?}");
    }

    #[test]
    fn flat_greys_by_hand() {
        let [dark, light] = [100u8, 120].map(|grey| vec![grey; 64]);
        let c1 = (0.01f64 * 255.0).powi(2);
        let wanted = (2.0 * 12000.0 + c1) / (10000.0 + 14400.0 + c1);
        assert!((ssim(8, &dark, &light).unwrap() - wanted).abs() < 1e-12);
        assert!((psnr(&dark, &light).unwrap() - 10.0 * (65025.0f64 / 400.0).log10()).abs() < 1e-12);
    }

    #[test]
    fn sizes_that_do_not_fit_have_no_likeness() {
        assert!(ssim(8, &[0; 64], &[0; 72]).is_none() && ssim(4, &[0; 64], &[0; 64]).is_none());
        assert!(ssim(9, &[0; 64], &[0; 64]).is_none() && ssim(8, &[], &[]).is_none());
        assert!(psnr(&[], &[]).is_none() && psnr(&[1], &[]).is_none());
        assert!(silhouette_iou(&[1], &[]).is_none());
        assert_eq!(silhouette_iou(&[0], &[0]), Some(1.0));
    }
}
