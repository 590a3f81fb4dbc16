//! The input as the assembly works on it: a surface of unit size, the edges that count, and whether it is even.

pub(super) mod features;
pub(super) mod surface;
pub(super) mod uneven;
