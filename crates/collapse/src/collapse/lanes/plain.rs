//! Lanes in plain arrays, for any machine; the compiler makes vectors of them where it can.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

use super::eight::{EightIndices, EightLanes, VertexQuadric};
use crate::collapse::rings::Vertex;

#[derive(Clone, Copy)]
pub(super) struct PlainLanes([f32; 8]);

macro_rules! implement {
    ($($operator:ident $name:ident $sign:tt),*) => {$(
        impl $operator for PlainLanes {
            type Output = PlainLanes;

            #[inline(always)]
            fn $name(self, other: PlainLanes) -> PlainLanes {
                PlainLanes(from_fn(|i| self.0[i] $sign other.0[i]))
            }
        }
    )*};
}
implement!(Add add +, Sub sub -, Mul mul *, Div div /);

// All bits set or clear, as one lane of a mask.
#[inline(always)]
fn to_mask(is_set: bool) -> f32 {
    f32::from_bits(0u32.wrapping_sub(u32::from(is_set)))
}

#[inline(always)]
fn sum(x: [f32; 8]) -> f32 {
    ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]))
}

impl EightLanes for PlainLanes {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; 8])
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        self.0
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(from_fn(|i| self.0[i].sqrt()))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(from_fn(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(from_fn(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        Self(from_fn(|i| to_mask(self.0[i] > other.0[i])))
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(from_fn(|i| f32::from_bits(self.0[i].to_bits() & other.0[i].to_bits())))
    }

    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        Self(from_fn(|i| {
            let mask = self.0[i].to_bits();
            f32::from_bits(yes.0[i].to_bits() & mask | no.0[i].to_bits() & !mask)
        }))
    }

    #[inline(always)]
    fn to_bits(self) -> u32 {
        (0..8).map(|i| (self.0[i].to_bits() >> 31) << i).sum()
    }

    #[inline(always)]
    fn mask_first(n: usize) -> Self {
        Self(from_fn(|i| to_mask(i < n)))
    }

    #[inline(always)]
    fn permute(self, from: &EightIndices) -> Self {
        Self(from_fn(|i| self.0[from[i] as usize & 7]))
    }

    #[inline(always)]
    fn sum_rows(rows: [Self; 8]) -> [f32; 8] {
        from_fn(|i| sum(rows[i].0))
    }

    #[inline(always)]
    fn sum_four_rows(rows: [Self; 4]) -> [f32; 4] {
        from_fn(|i| sum(rows[i].0))
    }

    #[inline(always)]
    fn load_points(vertices: &[Vertex], at: &EightIndices) -> [Self; 3] {
        let points: [[f32; 3]; 8] = from_fn(|i| vertices[at[i] as usize].position);
        from_fn(|axis| Self(from_fn(|i| points[i][axis])))
    }

    #[inline(always)]
    fn load_quadrics(quadrics: &[VertexQuadric], at: &EightIndices) -> [Self; 8] {
        let rows: [[f32; 8]; 8] = from_fn(|i| quadrics[at[i] as usize].0);
        from_fn(|number| Self(from_fn(|i| rows[i][number])))
    }
}
