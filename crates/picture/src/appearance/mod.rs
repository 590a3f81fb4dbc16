//! Comparison of pictures of a mesh and its original, from six fixed directions.

mod figures;

use crate::metrics::{flip, psnr, silhouette_iou, ssim};
use crate::parallel;
use crate::picture::{Image, ShadedMesh, view_shaded};

pub use figures::figures;

/// Height of pictures in pixels that distinguishes meshes of ten thousand faces.
pub const USUAL_HEIGHT: usize = 256;

/// Distances of the eye, over that from which the original fits the picture.
pub const DISTANCES: [usize; 2] = [1, 2];

/// Directions of view, azimuth and elevation in degrees.
pub const VIEWS: [[f32; 2]; 6] =
    [[30.0, 15.0], [120.0, 15.0], [210.0, 15.0], [300.0, 15.0], [75.0, 70.0], [255.0, -70.0]];

/// Similarity of pictures; all but `psnr` are means over [`VIEWS`] and [`DISTANCES`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Appearance {
    /// FLIP error of the shaded pictures over the pixels that show either mesh, 0 for equal ones, at most 1.
    pub flip: f64,
    /// Structural similarity of the shaded pictures in grey, 1 for equal ones.
    pub ssim: f64,
    /// Structural similarity of pictures of normals, mean over three components.
    pub normals_ssim: f64,
    /// Peak signal-to-noise ratio of all shaded pictures, in decibels; infinite for equal ones.
    pub psnr: f64,
    /// Intersection over union of the silhouettes, by the covered part of each pixel, 1 for equal ones.
    pub silhouette_iou: f64,
}

/// Compares pictures of two meshes, with a height of 64 to 4096 pixels; `None` if the original has no faces.
///
/// ```
/// # use neural_mesh_picture as neural_mesh;
/// use neural_mesh::{appearance::appearance, mesh::shapes};
/// let sphere = shapes::icosphere(3);
/// let same = appearance(&sphere, &sphere, 64).unwrap();
/// assert_eq!((same.flip, same.ssim, same.silhouette_iou, same.psnr), (0.0, 1.0, 1.0, f64::INFINITY));
/// let coarse = appearance(&sphere, &shapes::icosphere(1), 64).unwrap();
/// assert!(coarse.ssim < 1.0 && coarse.silhouette_iou < 1.0 && coarse.psnr < 60.0);
/// ```
pub fn appearance<'a>(
    original: impl Into<ShadedMesh<'a>>,
    simplified: impl Into<ShadedMesh<'a>>,
    height: usize,
) -> Option<Appearance> {
    let meshes = [original.into(), simplified.into()];
    if meshes[0].mesh.faces().is_empty() {
        return None;
    }
    let views = VIEWS.into_iter().flat_map(|view| DISTANCES.map(|distance| (view, height / distance)));
    let compared = parallel::each(views, |(view, height)| compare_views(&meshes, view, height));
    let compared = compared.into_iter().collect::<Option<Vec<_>>>()?;
    let mean = |of: fn(&Appearance) -> f64| {
        compared.iter().map(|(of_view, _)| of(of_view)).sum::<f64>() / compared.len() as f64
    };
    let pixels = |mesh: usize| -> Vec<u8> { compared.iter().flat_map(|(_, pixels)| pixels[mesh].clone()).collect() };
    Some(Appearance {
        flip: mean(|it| it.flip),
        ssim: mean(|it| it.ssim),
        normals_ssim: mean(|it| it.normals_ssim),
        psnr: psnr(&pixels(0), &pixels(1))?,
        silhouette_iou: mean(|it| it.silhouette_iou),
    })
}

/// Compares two meshes in one view, without `psnr`; also returns the pixels of both pictures.
fn compare_views(meshes: &[ShadedMesh; 2], view: [f32; 2], height: usize) -> Option<(Appearance, [Vec<u8>; 2])> {
    // The camera fits the original, so that equal pixels show equal places.
    let views = view_shaded(meshes, view, height);
    let [first, second] = views.as_slice() else { return None };
    let [a, b] = [&first.shaded, &second.shaded].map(Image::colours);
    let errors = flip(first.shaded.width, &a, &b)?;
    let shown = errors.iter().zip(first.covered.iter().zip(&second.covered)).filter(|(_, (p, q))| **p + **q > 0);
    let (error, n_shown) = shown.fold((0.0, 0), |(sum, n), (error, _)| (sum + error, n + 1));
    let of_view = Appearance {
        flip: error / f64::from(n_shown.max(1)),
        ssim: channels_ssim(&first.shaded, &second.shaded, &[luma])?,
        normals_ssim: channels_ssim(&first.normals, &second.normals, &[|p| p[0], |p| p[1], |p| p[2]])?,
        psnr: 0.0,
        silhouette_iou: silhouette_iou(&first.covered, &second.covered)?,
    };
    Some((of_view, [a, b].map(Vec::into_flattened)))
}

/// FLIP error of each pixel of two pictures, 0 to 1, row by row.
#[doc(hidden)]
pub struct FlipMap {
    pub width: usize,
    pub errors: Vec<f32>,
}

/// Maps the FLIP error of pictures of two meshes in a view; `None` if there are no pictures.
#[doc(hidden)]
pub fn flip_map(original: ShadedMesh, simplified: ShadedMesh, view: [f32; 2], height: usize) -> Option<FlipMap> {
    let views = view_shaded(&[original, simplified], view, height);
    let [first, second] = views.as_slice() else { return None };
    let errors = flip(first.shaded.width, &first.shaded.colours(), &second.shaded.colours())?;
    Some(FlipMap { width: first.shaded.width, errors: errors.into_iter().map(|error| error as f32).collect() })
}

fn channels_ssim(a: &Image, b: &Image, channels: &[fn([u8; 4]) -> u8]) -> Option<f64> {
    let take_channel = |image: &Image, channel: fn([u8; 4]) -> u8| -> Vec<u8> {
        image.rgba.chunks_exact(4).map(|p| channel([p[0], p[1], p[2], p[3]])).collect()
    };
    let each: Option<Vec<f64>> =
        channels.iter().map(|&c| ssim(a.width, &take_channel(a, c), &take_channel(b, c))).collect();
    each.map(|each| each.iter().sum::<f64>() / each.len() as f64)
}

fn luma([red, green, blue, _]: [u8; 4]) -> u8 {
    // These are the weights of Rec. 601.
    ((299 * u32::from(red) + 587 * u32::from(green) + 114 * u32::from(blue) + 500) / 1000) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, Channel, Role, TriMesh, shapes};
    use crate::picture::CornerNormals;

    #[test]
    fn coarser_meshes_look_less_like_the_original() {
        let sphere = shapes::wavy_sphere(4, 20.0);
        let compare_level = |level| appearance(&sphere, &shapes::wavy_sphere(level, 20.0), 96).unwrap();
        let [fine, middle, coarse] = [3, 2, 1].map(compare_level);
        let ordered = |value: fn(&Appearance) -> f64| value(&fine) > value(&middle) && value(&middle) > value(&coarse);
        assert!(
            ordered(|a| a.ssim) && ordered(|a| -a.flip) && ordered(|a| a.normals_ssim) && ordered(|a| a.psnr),
            "{fine:?} {middle:?} {coarse:?}"
        );
        assert!(ordered(|a| a.silhouette_iou), "{fine:?} {middle:?} {coarse:?}");
    }

    #[test]
    fn stored_normals_are_what_is_compared() {
        let [fine, coarse] = [5, 2].map(shapes::icosphere);
        let normals = [&fine, &coarse].map(|mesh| {
            let values = mesh.positions().as_flattened().to_vec();
            let channel = Channel { name: "normal".into(), role: Role::Normal, width: 3, values };
            let attributes = Attributes { wedges: mesh.faces().to_vec(), channels: vec![channel], groups: Vec::new() };
            CornerNormals::new(&attributes)
        });
        let shaded = |mesh, k: usize| ShadedMesh { normals: normals[k].as_ref(), ..ShadedMesh::bare(mesh) };
        let stored = appearance(shaded(&fine, 0), shaded(&coarse, 1), 96).unwrap();
        let by_faces = appearance(shaded(&fine, 0), &coarse, 96).unwrap();
        assert!(stored.normals_ssim > by_faces.normals_ssim + 0.02, "{stored:?} {by_faces:?}");
        assert!(stored.psnr > by_faces.psnr + 0.5, "{stored:?} {by_faces:?}");
        assert_eq!(stored.silhouette_iou, by_faces.silhouette_iou);
    }

    #[test]
    fn nothing_looks_like_nothing() {
        let sphere = shapes::icosphere(1);
        assert!(appearance(&TriMesh::default(), &sphere, 64).is_none());
        assert_eq!(appearance(&sphere, &TriMesh::default(), 64).unwrap().silhouette_iou, 0.0);
    }
}
