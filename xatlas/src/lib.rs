//! Bindings to xatlas (`vendor/`, MIT), which cuts a surface into charts with little distortion and packs the charts.
//!
//! This file holds all unsafe code: input is checked before the calls, output is copied and checked after them.

use std::ptr::NonNull;

/// Largest number of layouts to try until one fills the square.
const TRIES: usize = 6;
/// Share of the side that counts as full.
const FULL: f32 = 0.98;
/// Smallest resolution to try, relative to the first try; charts that are still too large do not fit at all.
const LEAST: f32 = 0.05;

/// Surface laid out on a square of texels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Input vertex of each vertex, n_vertices.
    pub vertices: Vec<u32>,
    /// Position of each vertex in texels, 0 to the side of the square, n_vertices x 2.
    pub texels: Vec<[f32; 2]>,
    /// Chart of each vertex; `None` in faces without area, where the position is 0.
    pub charts: Vec<Option<u32>>,
    /// Faces of the input, in order, over the new vertices.
    pub faces: Vec<[u32; 3]>,
    /// Number of charts.
    pub n_charts: usize,
}

/// Cuts a surface into charts and packs them on a square of `size` x `size` texels.
///
/// At least `padding` texels stay free around each chart. Returns `None` if the charts do not fit, no face has an area, or a
/// position is not finite. The layout does not depend on the number of threads.
///
/// ```
/// let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
/// let layout = neural_mesh_xatlas::unwrap(&positions, &[[0, 1, 2], [2, 1, 3]], 64, 1).unwrap();
/// assert_eq!((layout.n_charts, layout.faces.len(), layout.vertices.len()), (1, 2, 4));
/// assert!(layout.texels.iter().flatten().all(|x| (0.0..=64.0).contains(x)));
/// ```
pub fn unwrap(positions: &[[f32; 3]], faces: &[[u32; 3]], size: u32, padding: u32) -> Option<Layout> {
    let atlas = Atlas::new(positions, faces)?;
    let first = atlas.pack(size, padding, 0.0);
    if first.charts == 0 || !first.texels_per_unit.is_finite() {
        return None;
    }
    let (mut best, mut tried) = (None, first);
    for _ in 0..TRIES {
        let side = tried.width.max(tried.height);
        if side == 0 || tried.texels_per_unit < first.texels_per_unit * LEAST {
            break;
        }
        let share = side as f32 / size as f32;
        if side <= size {
            best = best.filter(|best: &Packed| best.texels_per_unit > tried.texels_per_unit).or(Some(tried));
            if share > FULL {
                break;
            }
        }
        // The resolution is slightly below the one that would fill the square, so that the next try fits.
        tried = atlas.pack(size, padding, tried.texels_per_unit / share * 0.995);
    }
    let best = best?;
    if tried != best {
        tried = atlas.pack(size, padding, best.texels_per_unit);
    }
    atlas.layout(&tried, positions.len(), faces)
}

/// Counterpart of `NeuralMeshLayout` in `shim.cpp`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Packed {
    width: u32,
    height: u32,
    charts: u32,
    vertices: u32,
    atlases: u32,
    texels_per_unit: f32,
}

#[repr(C)]
struct Opaque {
    _private: [u8; 0],
}

unsafe extern "C" {
    fn neural_mesh_charts(positions: *const f32, n_vertices: u32, faces: *const u32, n_faces: u32) -> *mut Opaque;
    fn neural_mesh_pack(atlas: *mut Opaque, resolution: u32, padding: u32, texels_per_unit: f32, packed: *mut Packed);
    fn neural_mesh_copy(atlas: *const Opaque, charts: *mut i32, texels: *mut f32, vertices: *mut u32, faces: *mut u32);
    fn neural_mesh_free(atlas: *mut Opaque);
}

struct Atlas(NonNull<Opaque>);

impl Atlas {
    fn new(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Option<Self> {
        let is_vertex = |&vertex: &u32| (vertex as usize) < positions.len();
        let fits = positions.len() < u32::MAX as usize && faces.len() < (u32::MAX / 3) as usize;
        let is_finite = positions.iter().flatten().all(|x| x.is_finite());
        if faces.is_empty() || !fits || !is_finite || !faces.iter().flatten().all(is_vertex) {
            return None;
        }
        let (n_vertices, n_faces) = (positions.len() as u32, faces.len() as u32);
        // SAFETY: both arrays have the stated lengths, all indices are valid vertices, and xatlas copies its input.
        let atlas =
            unsafe { neural_mesh_charts(positions.as_ptr().cast(), n_vertices, faces.as_ptr().cast(), n_faces) };
        NonNull::new(atlas).map(Self)
    }

    fn pack(&self, resolution: u32, padding: u32, texels_per_unit: f32) -> Packed {
        let mut packed = Packed::default();
        // SAFETY: the atlas lives as long as `self` and belongs to this thread, and `packed` has the layout of the C++ struct.
        unsafe { neural_mesh_pack(self.0.as_ptr(), resolution, padding, texels_per_unit, &mut packed) };
        packed
    }

    /// Returns the layout if it covers these faces on a single square.
    fn layout(&self, packed: &Packed, n_positions: usize, faces: &[[u32; 3]]) -> Option<Layout> {
        let n = packed.vertices as usize;
        let (mut charts, mut texels) = (vec![-1i32; n], vec![[0.0f32; 2]; n]);
        let (mut vertices, mut corners) = (vec![0u32; n], vec![[0u32; 3]; faces.len()]);
        // SAFETY: the arrays have room for the number of vertices that the last packing stated, and for all corners of the faces, which
        // xatlas keeps.
        unsafe {
            neural_mesh_copy(
                self.0.as_ptr(),
                charts.as_mut_ptr(),
                texels.as_mut_ptr().cast(),
                vertices.as_mut_ptr(),
                corners.as_mut_ptr().cast(),
            );
        }
        let came_from = |(&new, &old): (&u32, &u32)| vertices.get(new as usize) == Some(&old);
        let is_same = corners.iter().flatten().zip(faces.iter().flatten()).all(came_from);
        let is_known = vertices.iter().all(|&vertex| (vertex as usize) < n_positions);
        let is_finite = texels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0);
        let charts = charts.into_iter().map(|chart| u32::try_from(chart).ok()).collect();
        let n_charts = packed.charts as usize;
        let is_whole = packed.atlases == 1 && is_same && is_known && is_finite;
        is_whole.then_some(Layout { vertices, texels, charts, faces: corners, n_charts })
    }
}

impl Drop for Atlas {
    fn drop(&mut self) {
        // SAFETY: the pointer came from `neural_mesh_charts` and is freed once.
        unsafe { neural_mesh_free(self.0.as_ptr()) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|x| x as f32)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        (positions, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    fn area(layout: &Layout, face: &[u32; 3]) -> f32 {
        let [a, b, c] = face.map(|vertex| layout.texels[vertex as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    }

    #[test]
    fn a_cube_is_laid_out_without_distortion_and_fills_the_square() {
        let (positions, faces) = cube();
        let layout = unwrap(&positions, &faces, 256, 2).unwrap();
        let areas: Vec<f32> = layout.faces.iter().map(|face| area(&layout, face)).collect();
        assert!(areas.iter().all(|area| (area.abs() / areas[0].abs() - 1.0).abs() < 0.1), "{areas:?}");
        assert!(areas.iter().map(|area| area.abs()).sum::<f32>() * 0.5 > 0.3 * 256.0 * 256.0, "{areas:?}");
        assert!(layout.texels.iter().flatten().all(|x| (0.0..=256.0).contains(x)));
        assert_eq!(layout, unwrap(&positions, &faces, 256, 2).unwrap());
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        let (positions, faces) = cube();
        assert_eq!(unwrap(&positions, &[[0, 1, 8]], 64, 1), None);
        assert_eq!(unwrap(&positions, &[], 64, 1), None);
        assert_eq!(unwrap(&[[f32::NAN; 3]; 8], &faces, 64, 1), None);
        assert_eq!(unwrap(&[[1.0; 3]; 8], &faces, 64, 1), None);
    }

    #[test]
    fn faces_without_area_lie_nowhere() {
        let (mut positions, mut faces) = cube();
        positions.push([0.5, 0.0, 0.0]);
        faces.push([0, 1, 8]);
        let layout = unwrap(&positions, &faces, 64, 1).unwrap();
        assert_eq!(layout.faces.len(), 13);
        assert!(layout.faces[12].iter().any(|&vertex| layout.charts[vertex as usize].is_none()), "{layout:?}");
    }

    #[test]
    fn more_charts_than_texels_do_not_fit() {
        let (positions, faces) = cube();
        let shifted = (0..400).flat_map(|i| positions.iter().map(move |p| [p[0] + 3.0 * i as f32, p[1], p[2]]));
        let all: Vec<[f32; 3]> = shifted.collect();
        let faces: Vec<[u32; 3]> =
            (0..400).flat_map(|i| faces.iter().map(move |face| face.map(|v| v + 8 * i))).collect();
        assert_eq!(unwrap(&all, &faces, 16, 2), None);
        assert!(unwrap(&all, &faces, 1024, 2).is_some());
    }
}
