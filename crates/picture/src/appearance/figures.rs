//! Picture similarity as figures.

use super::Appearance;
use crate::metrics::Figure;

/// Returns the figures in fixed order; values are missing if nothing was drawn, and `psnr` also if infinite.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::{appearance::{appearance, figures}, mesh::shapes};
/// let sphere = shapes::icosphere(2);
/// let values = figures(appearance(&sphere, &sphere, 64).as_ref()).map(|figure| figure.value);
/// assert_eq!(values, [Some(0.0), Some(1.0), Some(1.0), None, Some(1.0)]);
/// assert!(figures(None).iter().all(|figure| figure.value.is_none()));
/// ```
pub fn figures(appearance: Option<&Appearance>) -> [Figure; 5] {
    let figure = |name, unit, about, value: fn(&Appearance) -> f64| {
        let value = appearance.map(value).filter(|value| value.is_finite());
        Figure { name, unit, about, value }
    };
    [
        figure(
            "flip",
            "",
            "FLIP error: visible difference between shaded pictures where either shows a mesh, 0 for equal pictures",
            |a| a.flip,
        ),
        figure("ssim", "", "structural similarity of shaded pictures, 1 for equal pictures", |a| a.ssim),
        figure("normals_ssim", "", "structural similarity of pictures of the normals", |a| a.normals_ssim),
        figure("psnr", "dB", "peak signal-to-noise ratio of shaded pictures", |a| a.psnr),
        figure("silhouette_iou", "", "intersection over union of the silhouettes", |a| a.silhouette_iou),
    ]
}
