//! The tests of the library, in a single executable, since linking each file separately is slow.

#[cfg(all(feature = "gzip", feature = "io"))]
mod attributed;
mod attributes;
#[cfg(feature = "gltf")]
mod bad_files;
mod common;
#[cfg(all(feature = "gltf", feature = "picture"))]
mod conversions;
#[cfg(feature = "weights")]
mod equations;
#[cfg(feature = "gltf")]
mod files;
mod fit_to_points;
mod found_by_fuzzing;
#[cfg(feature = "gltf")]
mod gltf_assets;
#[cfg(feature = "io")]
mod invariants;
mod judge;
mod kept;
mod layers;
#[cfg(all(feature = "io", feature = "weights"))]
mod optimize;
mod parts;
#[cfg(feature = "weights")]
mod passes;
#[cfg(feature = "picture")]
mod picture;
mod poses;
mod recorded;
#[cfg(feature = "train")]
mod train;
mod words;
