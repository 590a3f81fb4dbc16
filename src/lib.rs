//! Simplifies triangle meshes by edge collapse: if the input is closed and manifold, so is the result.
//!
//! A formula or the Point Sampler of "Neural Mesh Simplification" (Potamias, Ploumpis, Zafeiriou, CVPR 2022) weights
//! the vertices. The paper's own pipeline, without that guarantee, is [`simplify::Assembly::Paper`].
//!
//! ```
//! use std::ops::ControlFlow;
//! use neural_mesh::mesh::{RawMesh, cleanup::{CleanOptions, clean}, shapes};
//! use neural_mesh::simplify::{ClosedOptions, Options, Size, simplify};
//!
//! // Positions and triangles from any source; `io::read` reads them from a file.
//! let (positions, faces) = shapes::torus(64, 32, 1.0, 0.4).into_parts();
//! let positions = positions.into_iter().map(|position| position.map(f64::from)).collect();
//! let input = clean(RawMesh::new(positions, faces), &CleanOptions::default())?;
//!
//! // The frame says how coordinates are rounded when written.
//! let closed = ClosedOptions { frame: input.frame, ..ClosedOptions::default() };
//! let options = Options::with_closed(Size::Ratio(0.1), closed);
//! let result = simplify(&input.mesh, &options, &mut |_| ControlFlow::Continue(()))?;
//! assert_eq!(result.mesh.positions().len(), 204); // of 2048
//! assert!(neural_mesh::mesh::topology(&result.mesh).is_closed_manifold());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Start here
//!
//! | to get | call |
//! |---|---|
//! | a file or scene simplified with its attributes, as in the program | [`job::Document`], [`job::Job`], [`job::run`] |
//! | files in and out | [`io::read`], [`io::read_attributed`], [`io::write`], [`io::write_attributed`]; glTF scenes: [`io::Asset`] |
//! | a valid mesh from a file's contents | [`mesh::cleanup::clean`], which returns a [`mesh::TriMesh`] and its [`mesh::Frame`] |
//! | a broken mesh repaired | [`repair::fill_holes`], [`repair::printable`] |
//! | a number of vertices or faces | [`simplify::simplify`], of a mesh, or of a [`simplify::Input`] with textures, normals, materials |
//! | a distance, a file size, levels | [`search::simplify_to_error`], [`search::simplify_to_size`], [`simplify::simplify_levels_of_detail`] |
//! | levels of detail that vary over the surface | [`clusters::build_clusters`] |
//! | files that do not fit into memory | [`blocks::simplify_pieces`]; among workers [`blocks::cut`], [`blocks::simplify_block`], [`blocks::join`] |
//! | a mesh of points without faces | [`simplify::mesh_points`] |
//! | gradients to the input | [`simplify::simplify_recorded`] |
//! | figures that judge a result | [`metrics::compare`], [`metrics::certified_distance`]; as pictures [`picture::render`], [`appearance::appearance`] |
//! | textures baked from the original | `bake::bake` |
//! | your own weights | `train::open`, `train::train`; [`model::Weights`] |
//!
//! # Behaviour
//!
//! - **Threads**: work runs on the current rayon pool.
//! - **Stopping**: a [`simplify::Listener`] receives progress and may end the run.
//! - **Determinism**: input, options and seed decide the result, on any number of threads of one instruction set.
//!   Results change only with a version such as [`simplify::CLOSED_VERSION`].
//! - **Errors** say in one line what is wrong, where and what to do. Invalid files and meshes are errors, not panics.
//!   If a target cannot be reached, [`simplify::Outcome`] names the obstacle.
//! - **Growth**: options, inputs, reports and errors are `#[non_exhaustive]`: make them by `new` or `default`, then set
//!   fields.
//!
//! # Features
//!
//! | feature | on by default | adds |
//! |---|---|---|
//! | `io` | yes | mesh files: OBJ, PLY, STL, OFF |
//! | `gltf` | yes | glTF and GLB, single meshes and scenes |
//! | `gzip` | yes | files that are compressed (`.gz`) |
//! | `paper` | yes | weights of the paper's network for its assembly and for clouds of points |
//! | `picture` | yes | [`picture`] and [`appearance`] |
//! | `weights` | yes | reading and writing of weights; those that ship need no feature but `paper` |
//! | `job` | yes | [`job`]: documents with attributes, requests, reports |
//! | `bake` | no | textures and a normal map of the original; needs a C++ compiler |
//! | `meshopt` | no | writing of glTF that meshoptimizer compresses; needs a C++ compiler |
//! | `3mf`, `fbx`, `draco`, `ktx2` | no | more formats; `fbx` needs a C compiler |
//! | `loss`, `train` | no | the terms that training minimises; training |
//!
//! # Machinery
//!
//! Simplification needs none of these modules, which are public for research: [`model`] (the paper's network),
//! [`autodiff`] and [`linalg`] (matrices and their derivatives), `loss` (the terms of training), [`geometry`] and
//! [`spatial`] (triangles, quadrics, closest points). `ARCHITECTURE.md` lists the layers of modules.

#[doc(inline)]
#[cfg(feature = "io")]
pub use neural_mesh_io::io;
#[doc(inline)]
pub use neural_mesh_measure::metrics;
#[doc(hidden)]
pub use neural_mesh_mesh::parallel;
#[doc(inline)]
pub use neural_mesh_mesh::{geometry, linalg, mesh, spatial};
#[doc(inline)]
#[cfg(feature = "loss")]
pub use neural_mesh_network::loss;
#[doc(inline)]
pub use neural_mesh_network::{autodiff, model};
#[doc(inline)]
#[cfg(feature = "bake")]
pub use neural_mesh_picture::bake;
#[doc(inline)]
#[cfg(feature = "picture")]
pub use neural_mesh_picture::{appearance, picture};
#[doc(inline)]
pub use neural_mesh_repair::repair;
#[doc(inline)]
pub use neural_mesh_simplify::simplify;

pub mod blocks;
pub mod clusters;
#[cfg(feature = "job")]
pub mod job;
pub mod search;
#[cfg(feature = "train")]
pub mod train;

// The examples of the README and of the guide are tested like all others.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
#[cfg(doctest)]
#[doc = include_str!("../docs/guide/rust.md")]
struct Guide;
