//! The arrays of a glTF asset: positions and indices, dense or sparse, every access checked.

use super::schema::{Accessor, BufferView, Root};
use super::{REMEDY, missing};
use crate::io::ReadError;

/// The document with its buffers.
pub(super) struct Data<'a> {
    pub root: &'a Root,
    pub buffers: &'a [std::borrow::Cow<'a, [u8]>],
}

impl<'a> Data<'a> {
    /// The number of elements of an accessor, as claimed.
    pub fn count(&self, index: usize) -> Result<usize, ReadError> {
        Ok(self.accessor(index)?.count)
    }

    /// The positions of accessor `index`, count x 3; refused where there are more than `limit`.
    pub fn positions(&self, index: usize, limit: usize) -> Result<Vec<[f64; 3]>, ReadError> {
        self.elements::<3>(index, "VEC3", limit)
    }

    /// The vertex indices of accessor `index`, count; refused where there are more than `limit`.
    pub fn indices(&self, index: usize, limit: usize) -> Result<Vec<u32>, ReadError> {
        let values = self.elements::<1>(index, "SCALAR", limit)?;
        Ok(values.into_iter().map(|[value]| value as u32).collect())
    }

    fn accessor(&self, index: usize) -> Result<&'a Accessor, ReadError> {
        self.root.accessors.get(index).ok_or_else(|| missing("accessor", index))
    }

    /// All elements of an accessor, with its sparse ones put in.
    fn elements<const N: usize>(&self, index: usize, shape: &str, limit: usize) -> Result<Vec<[f64; N]>, ReadError> {
        let accessor = self.accessor(index)?;
        let kind = Kind { component: accessor.component_type, normalized: accessor.normalized };
        if accessor.shape != shape || kind.size() == 0 || accessor.count > limit {
            let Accessor { count, component_type, shape, .. } = accessor;
            let what = format!("accessor {index} with {count} {shape} of type {component_type} cannot be used here");
            return Err(ReadError::file(what, REMEDY));
        }
        let mut elements = match accessor.buffer_view {
            Some(view) => self.run(view, accessor.byte_offset, accessor.count, kind)?,
            None => vec![[0.0; N]; accessor.count],
        };
        if let Some(sparse) = &accessor.sparse {
            let index_kind = Kind { component: sparse.indices.component_type, normalized: false };
            let places =
                self.run::<1>(sparse.indices.buffer_view, sparse.indices.byte_offset, sparse.count, index_kind)?;
            let values = self.run(sparse.values.buffer_view, sparse.values.byte_offset, sparse.count, kind)?;
            for ([place], value) in places.into_iter().zip(values) {
                let element = elements.get_mut(place as usize);
                *element.ok_or_else(|| missing("element", place as usize))? = value;
            }
        }
        Ok(elements)
    }

    /// `count` elements of N components from `offset` on in a buffer view.
    fn run<const N: usize>(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        kind: Kind,
    ) -> Result<Vec<[f64; N]>, ReadError> {
        let view_index = view;
        let view = self.root.buffer_views.get(view).ok_or_else(|| missing("buffer view", view))?;
        let size = N * kind.size();
        let stride = view.byte_stride.unwrap_or(size);
        let too_short =
            || ReadError::file(format!("buffer view {view_index} has no room for {count} elements"), REMEDY);
        if size == 0 || stride < size {
            return Err(too_short());
        }
        let bytes = self.bytes(view).and_then(|bytes| bytes.get(offset..)).ok_or_else(too_short)?;
        // The last element need not fill its stride.
        if count > 0 && (count - 1).checked_mul(stride).is_none_or(|start| start.saturating_add(size) > bytes.len()) {
            return Err(too_short());
        }
        let decode = |element: &[u8]| std::array::from_fn(|i| kind.decode(&element[i * kind.size()..]));
        Ok(bytes.chunks(stride).take(count).map(decode).collect())
    }

    fn bytes(&self, view: &BufferView) -> Option<&'a [u8]> {
        self.buffers.get(view.buffer)?.get(view.byte_offset..)?.get(..view.byte_length)
    }
}

/// How a component is stored.
#[derive(Clone, Copy)]
struct Kind {
    /// 5120 to 5126, the numbers of OpenGL.
    component: u32,
    /// Whether integers stand for fractions of their range.
    normalized: bool,
}

impl Kind {
    /// Bytes of a component, 0 for an unknown kind.
    fn size(self) -> usize {
        match self.component {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            5125 | 5126 => 4,
            _ => 0,
        }
    }

    /// The component at the start of `bytes`, which hold it.
    fn decode(self, bytes: &[u8]) -> f64 {
        let mut raw = [0; 4];
        raw[..self.size()].copy_from_slice(&bytes[..self.size()]);
        let bits = u32::from_le_bytes(raw);
        let (value, range) = match self.component {
            5120 => (f64::from(bits as i8), f64::from(i8::MAX)),
            5121 => (f64::from(bits as u8), f64::from(u8::MAX)),
            5122 => (f64::from(bits as i16), f64::from(i16::MAX)),
            5123 => (f64::from(bits as u16), f64::from(u16::MAX)),
            5125 => (f64::from(bits), f64::from(u32::MAX)),
            _ => (f64::from(f32::from_bits(bits)), 1.0),
        };
        if self.normalized { (value / range).max(-1.0) } else { value }
    }
}
