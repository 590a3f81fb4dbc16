//! Image in memory.

/// Image, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Red, green, blue and opacity, height x width x 4, sRGB.
    pub rgba: Vec<u8>,
}

impl Image {
    /// Returns red, green and blue of each pixel, without opacity, height x width.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// let image = neural_mesh::picture::Image { width: 1, height: 1, rgba: vec![1, 2, 3, 255] };
    /// assert_eq!(image.colours(), [[1, 2, 3]]);
    /// ```
    pub fn colours(&self) -> Vec<[u8; 3]> {
        self.rgba.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect()
    }
}
