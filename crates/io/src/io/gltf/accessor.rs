//! Accessors of a glTF, dense or sparse.

use super::buffers::AssetBuffers;
use super::refusals::{REMEDY, missing_error};
use super::schema::{Accessor, BufferView, Root};
use crate::io::memory::{allocate_zeros, reserve};
use crate::io::{ReadError, Scalar};

pub(super) struct Data<'a> {
    pub root: &'a Root,
    pub buffers: &'a AssetBuffers<'a>,
    // Bytes of each compressed buffer view.
    pub decompressed: &'a [Option<Vec<u8>>],
}

impl<'a> Data<'a> {
    pub fn count(&self, index: usize) -> Result<usize, ReadError> {
        Ok(self.accessor(index)?.count)
    }

    /// Reads positions, count x 3; rejects more than `limit`.
    pub fn positions(&self, index: usize, limit: usize) -> Result<Vec<[f64; 3]>, ReadError> {
        self.elements::<3>(index, "VEC3", limit)
    }

    /// Reads vertex indices; rejects more than `limit`.
    pub fn indices(&self, index: usize, limit: usize) -> Result<Vec<u32>, ReadError> {
        let values = self.elements::<1>(index, "SCALAR", limit)?;
        Ok(values.into_iter().map(|[value]| value as u32).collect())
    }

    /// Reads the width and values of an accessor, count x width; rejects more than `limit` values.
    pub fn floats(&self, index: usize, limit: usize) -> Result<(usize, Vec<f32>), ReadError> {
        let accessor = self.accessor(index)?;
        let shape = ElementShape::from_name(&accessor.shape).ok_or_else(|| unusable(index, accessor))?;
        let width = shape.width();
        // The file may claim any count: an accessor without bytes means zeros.
        if accessor.count.saturating_mul(width) > limit {
            return Err(unusable(index, accessor));
        }
        let mut values = allocate_zeros(accessor.count * width)?;
        let kind = ComponentKind::from_accessor(accessor).ok_or_else(|| unusable(index, accessor))?;
        self.for_each_element(accessor, shape.size(kind.size()), &mut |element, bytes| {
            for (at, value) in values[element * width..][..width].iter_mut().enumerate() {
                *value = kind.decode(&bytes[shape.offset(at, kind.size())..]) as f32;
            }
        })?;
        Ok((width, values))
    }

    pub fn width(&self, index: usize) -> Result<usize, ReadError> {
        let accessor = self.accessor(index)?;
        ElementShape::from_name(&accessor.shape).map(ElementShape::width).ok_or_else(|| unusable(index, accessor))
    }

    pub fn accessor(&self, index: usize) -> Result<&'a Accessor, ReadError> {
        self.root.accessors.get(index).ok_or_else(|| missing_error("accessor", index))
    }

    fn elements<const N: usize>(&self, index: usize, shape: &str, limit: usize) -> Result<Vec<[f64; N]>, ReadError> {
        let accessor = self.accessor(index)?;
        let kind = ComponentKind::from_accessor(accessor).ok_or_else(|| unusable(index, accessor))?;
        // The file may claim any count: an accessor without bytes means zeros.
        if accessor.shape != shape || accessor.count > limit {
            return Err(unusable(index, accessor));
        }
        let mut elements: Vec<[f64; N]> = Vec::new();
        reserve(&mut elements, accessor.count)?;
        elements.resize(accessor.count, [0.0; N]);
        self.for_each_element(accessor, N * kind.size(), &mut |element, bytes| {
            elements[element] = std::array::from_fn(|i| kind.decode(&bytes[i * kind.size()..]));
        })?;
        Ok(elements)
    }

    // Sparse replacements follow the dense elements.
    fn for_each_element(
        &self,
        accessor: &Accessor,
        size: usize,
        show: &mut dyn FnMut(usize, &[u8]),
    ) -> Result<(), ReadError> {
        // Draco gives elements directly; others come from a buffer view or are zeros.
        if let Some(bytes) = &accessor.decoded {
            bytes.chunks_exact(size).take(accessor.count).enumerate().for_each(|(element, bytes)| show(element, bytes));
        } else if let Some(view) = accessor.buffer_view {
            let run = self.run(view, accessor.byte_offset, accessor.count, size)?;
            run.enumerate().for_each(|(element, bytes)| show(element, bytes));
        }
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let kind = component(sparse.indices.component_type);
        let size_of_place = kind.map_or(0, Scalar::size);
        let places = self.run(sparse.indices.buffer_view, sparse.indices.byte_offset, sparse.count, size_of_place)?;
        let values = self.run(sparse.values.buffer_view, sparse.values.byte_offset, sparse.count, size)?;
        for (place, value) in places.zip(values) {
            let place = kind.and_then(|kind| kind.decode(place, false)).unwrap_or_default() as usize;
            // Sparse indices are data of the file and may be out of range.
            if place >= accessor.count {
                return Err(missing_error("element", place));
            }
            show(place, value);
        }
        Ok(())
    }

    fn run(
        &self,
        index: usize,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = &'a [u8]>, ReadError> {
        let view = self.root.buffer_views.get(index).ok_or_else(|| missing_error("buffer view", index))?;
        let stride = view.byte_stride.unwrap_or(size);
        let too_short = || ReadError::file(format!("buffer view {index} has no room for {count} elements"), REMEDY);
        // A stride shorter than an element would make elements overlap.
        if size == 0 || stride < size {
            return Err(too_short());
        }
        let bytes = self.bytes(index).and_then(|bytes| bytes.get(offset..)).ok_or_else(too_short)?;
        // The last element may be shorter than the stride.
        if count > 0 && (count - 1).checked_mul(stride).is_none_or(|start| start.saturating_add(size) > bytes.len()) {
            return Err(too_short());
        }
        Ok(bytes.chunks(stride).take(count))
    }

    pub fn bytes(&self, index: usize) -> Option<&'a [u8]> {
        if let Some(Some(bytes)) = self.decompressed.get(index) {
            return Some(bytes);
        }
        let view: &BufferView = self.root.buffer_views.get(index)?;
        self.buffers.part(view.buffer, view.byte_offset, view.byte_length)
    }
}

fn unusable(index: usize, accessor: &Accessor) -> ReadError {
    let Accessor { count, component_type, shape, .. } = accessor;
    let what = format!("accessor {index} with {count} {shape} of type {component_type} cannot be used here");
    ReadError::file(what, REMEDY)
}

// Size of an element in components; matrices are stored by columns.
#[derive(Clone, Copy)]
struct ElementShape {
    rows: usize,
    columns: usize,
}

impl ElementShape {
    fn from_name(name: &str) -> Option<Self> {
        let (rows, columns) = match name {
            "SCALAR" => (1, 1),
            "VEC2" => (2, 1),
            "VEC3" => (3, 1),
            "VEC4" => (4, 1),
            "MAT2" => (2, 2),
            "MAT3" => (3, 3),
            "MAT4" => (4, 4),
            _ => return None,
        };
        Some(Self { rows, columns })
    }

    fn width(self) -> usize {
        self.rows * self.columns
    }

    // Matrix columns are aligned to four bytes.
    fn column(self, component: usize) -> usize {
        if self.columns == 1 { self.rows * component } else { (self.rows * component).next_multiple_of(4) }
    }

    fn size(self, component: usize) -> usize {
        self.columns * self.column(component)
    }

    fn offset(self, at: usize, component: usize) -> usize {
        (at / self.rows) * self.column(component) + (at % self.rows) * component
    }
}

pub(super) fn shape_width(shape: &str) -> usize {
    ElementShape::from_name(shape).map_or(0, ElementShape::width)
}

pub(super) fn element_size(shape: &str, component_type: u32) -> usize {
    let shape = ElementShape::from_name(shape).zip(component(component_type));
    shape.map_or(0, |(shape, scalar)| shape.size(scalar.size()))
}

/// Returns the type with an OpenGL number.
pub(super) fn component(number: u32) -> Option<Scalar> {
    match number {
        BYTE => Some(Scalar::I8),
        UNSIGNED_BYTE => Some(Scalar::U8),
        SHORT => Some(Scalar::I16),
        UNSIGNED_SHORT => Some(Scalar::U16),
        UNSIGNED_INT => Some(Scalar::U32),
        FLOAT => Some(Scalar::F32),
        _ => None,
    }
}

pub(super) const BYTE: u32 = 5120;
pub(super) const UNSIGNED_BYTE: u32 = 5121;
pub(super) const SHORT: u32 = 5122;
pub(super) const UNSIGNED_SHORT: u32 = 5123;
pub(super) const UNSIGNED_INT: u32 = 5125;
pub(super) const FLOAT: u32 = 5126;

#[derive(Clone, Copy)]
struct ComponentKind {
    scalar: Scalar,
    // True if integers mean fractions of their range.
    normalized: bool,
}

impl ComponentKind {
    fn from_accessor(accessor: &Accessor) -> Option<Self> {
        Some(Self { scalar: component(accessor.component_type)?, normalized: accessor.normalized })
    }

    fn size(self) -> usize {
        self.scalar.size()
    }

    fn decode(self, bytes: &[u8]) -> f64 {
        let value = self.scalar.decode(bytes, false).unwrap_or_default();
        // -1 is clamped, as signed types reach one further below.
        if self.normalized { (value / self.scalar.largest()).max(-1.0) } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_matrices_start_at_multiples_of_four() {
        for (shape, component, size) in [
            ("SCALAR", 5121, 1),
            ("VEC3", 5123, 6),
            ("VEC4", 5126, 16),
            ("MAT2", 5121, 8),
            ("MAT3", 5121, 12),
            ("MAT3", 5123, 24),
            ("MAT4", 5126, 64),
            ("VEC5", 5126, 0),
        ] {
            assert_eq!(element_size(shape, component), size, "{shape} {component}");
        }
        let shape = ElementShape::from_name("MAT3").unwrap();
        assert_eq!([0, 1, 2, 3, 8].map(|at| shape.offset(at, 1)), [0, 1, 2, 4, 10]);
        assert_eq!([0, 3, 4].map(|at| shape.offset(at, 4)), [0, 12, 16]);
    }

    #[test]
    fn integers_are_decoded_as_fractions_of_their_range() {
        let decode = |number, normalized, bytes: &[u8]| {
            let scalar = component(number).unwrap();
            ComponentKind { scalar, normalized }.decode(bytes)
        };
        assert_eq!(decode(5121, true, &[255]), 1.0);
        assert_eq!(decode(5120, true, &[0x80]), -1.0);
        assert_eq!(decode(5122, true, &32767i16.to_le_bytes()), 1.0);
        assert_eq!(decode(5122, false, &(-7i16).to_le_bytes()), -7.0);
        assert_eq!(decode(5126, false, &0.5f32.to_le_bytes()), 0.5);
    }
}
