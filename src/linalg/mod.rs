//! Matrices, sparse rows and the kernels over them; knows no geometry.
