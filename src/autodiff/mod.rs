//! Reverse-mode differentiation over rank-2 matrices: a small tape, forward and backward side by side.
