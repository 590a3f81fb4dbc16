//! neural-mesh simplifies triangle meshes: sample vertices, connect them, keep what lies on the surface.
//!
//! The method is that of "Neural Mesh Simplification" (Potamias, Ploumpis, Zafeiriou, CVPR 2022), with a
//! closed assembly of our own beside the paper's. Modules stand in strict layers; `ARCHITECTURE.md` has the
//! table, and a test holds it.

#[cfg(feature = "picture")]
pub mod appearance;
pub mod autodiff;
#[cfg(feature = "bake")]
pub mod bake;
#[cfg(feature = "baselines")]
pub mod baselines;
#[cfg(feature = "evaluate")]
pub mod evaluate;
pub mod geometry;
#[cfg(feature = "io")]
pub mod io;
pub mod linalg;
#[cfg(feature = "loss")]
pub mod loss;
pub mod mesh;
pub mod metrics;
pub mod model;
#[cfg(feature = "picture")]
pub mod picture;
pub mod repair;
pub mod search;
pub mod simplify;
pub mod spatial;
#[cfg(feature = "train")]
pub mod train;

// The examples of the README are tested like all others.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
