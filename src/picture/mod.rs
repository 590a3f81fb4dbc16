//! A mesh as a shaded image, drawn without a GPU.
