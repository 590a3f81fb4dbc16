//! The list of options of a simplification: names, types, ranges, defaults and help.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::choices::{AssemblyName, Compression, Engine, Ignored, LodsBy};
use super::option_json;
#[cfg(feature = "clap")]
use super::parse;
use super::parse::RatioOf;
use super::size::Bound;
use crate::simplify::Size;
use crate::simplify::{Draw, Effort, Hidden, Optimize, Purpose, ScoreSource};

/// Headings of the option groups in the program's help.
#[cfg(feature = "clap")]
mod headings {
    pub const KEEP: &str = "What to keep";
    pub const REPAIR: &str = "Repair before simplifying";
    pub const TEXTURES: &str = "glTF and textures";
    pub const QUALITY: &str = "Quality";
}

#[cfg(all(feature = "clap", feature = "meshopt"))]
const COMPRESS_HELP: [&str; 2] = [
    "Write a compressed glTF, as gltfpack does; =quantize only quantises it",
    "Write a glTF as gltfpack does: quantised (KHR_mesh_quantization) and compressed (EXT_meshopt_compression); \
    =quantize only quantises it",
];
#[cfg(all(feature = "clap", not(feature = "meshopt")))]
const COMPRESS_HELP: [&str; 2] = [
    "Write a quantised glTF: --compress=quantize",
    "Write a quantised glTF (KHR_mesh_quantization): --compress=quantize",
];

/// Options of a simplification by name: arguments of the program, or JSON with `_` for `-`, where unknown names are errors.
///
/// The docs of an option are its help. Numbers in JSON may be text, such as `"10%"`, as sizes and distances are written.
///
/// ```
/// use neural_mesh::job::{Arguments, Bound, Goal};
///
/// let arguments: Arguments = serde_json::from_str(r#"{"error": "0.5%", "format": "glb", "effort": "best"}"#).unwrap();
/// assert_eq!(arguments.job().unwrap().goal, Goal::Error(Bound::Percent(0.5)));
/// assert!(serde_json::from_str::<Arguments>(r#"{"rato": 0.1}"#).is_err());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "clap", derive(clap::Args), group(skip))]
#[serde(default, deny_unknown_fields)]
pub struct Arguments {
    /// Share of the vertices to keep: 0.1 or 10%. NAME=R sets the share of one named object or material
    #[serde(deserialize_with = "option_json::ratio")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "[NAME=]R", value_parser = parse::ratio_of,
        allow_hyphen_values = true,
        long_help = "Share of the vertices to keep: 0.1 or 10%. NAME=R sets the share of a node, mesh, object, group or \
        material; repeat it for several names. The rest gets the target of the whole mesh; without one, it keeps \
        its vertices"))]
    pub ratio: Vec<RatioOf>,
    /// Number of faces to keep: 5000, 10k, 1.5M or 10%
    #[serde(deserialize_with = "option_json::faces", serialize_with = "option_json::write_size")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = parse::faces, allow_hyphen_values = true))]
    pub faces: Option<Size>,
    /// Number of vertices to keep: 5000, 10k, 1.5M or 10%
    #[serde(deserialize_with = "option_json::vertices", serialize_with = "option_json::write_size")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = parse::vertices, allow_hyphen_values = true))]
    pub vertices: Option<Size>,
    /// Largest distance to the original, in units of the mesh or with % of its diagonal; finds the smallest mesh
    #[serde(deserialize_with = "option_json::bound")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "E", value_parser = parse::bound,
        allow_hyphen_values = true,
        long_help = "Largest distance to the original, in both directions and proved, in units of the mesh or with % of its \
        bounding-box diagonal; finds the smallest mesh within it"))]
    pub error: Option<Bound>,
    /// Largest file size, such as 500kB or 2MB; finds the largest mesh that fits
    #[serde(deserialize_with = "option_json::n_bytes")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "BYTES", value_parser = parse::n_bytes))]
    pub size: Option<usize>,
    /// Levels of detail as falling shares of the vertices, such as 50%,25%,10%
    #[serde(deserialize_with = "option_json::texts")]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "R,R",
            value_delimiter = ',',
            allow_hyphen_values = true,
            long_help = "Levels of detail as falling shares of the vertices, such as 50%,25%,10%. The number of the level \
        replaces {level} in OUT; otherwise the file names end in -lod0, -lod1 and so on. A glTF scene becomes \
        one file with all levels (MSFT_lod)"
        )
    )]
    pub lods: Vec<String>,
    /// Unit of --lods: vertices or faces, as shares or as numbers such as 20k,5k, or proved largest distances such as
    /// 0.1%,0.5% [default: vertices]
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "UNIT", hide_short_help = true))]
    pub lods_by: Option<LodsBy>,
    /// Convention for names and files of --lods: NAME_LOD0 nodes in one glTF (unity, godot), a file per level (unreal), or
    /// MSFT_lod (gltf)
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "ENGINE", hide_short_help = true))]
    pub engine: Option<Engine>,
    /// Vertical field of view for the distances from which levels of --lods are drawn, above 0 and below 180 degrees
    /// [default: 60]
    #[serde(deserialize_with = "option_json::field_of_view")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEGREES", value_parser = parse::field_of_view,
        allow_negative_numbers = true, hide_short_help = true))]
    pub field_of_view: Option<f64>,
    /// Format of the result if the name of OUT has no known ending: obj, ply, ply-ascii, stl, stl-ascii, off, gltf, glb
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "FORMAT",
            long_help = "Format of the result: obj, ply, ply-ascii, stl, stl-ascii, off, gltf, glb. If the name of OUT has a \
        known ending, the ending wins: then ply-ascii and stl-ascii write a .ply or .stl as text, and other \
        formats name that of an IN without a known ending. Standard output has the format of the input by \
        default"
        )
    )]
    pub format: Option<String>,
    /// Property that the result must preserve best
    #[serde(rename = "for")]
    #[cfg_attr(
        feature = "clap",
        arg(
            long = "for",
            value_enum,
            value_name = "PURPOSE",
            default_value_t,
            display_order = 90,
            hide_short_help = true
        )
    )]
    pub purpose: Purpose,
    /// Keep edges where the surface bends by more than 30 degrees
    #[cfg_attr(feature = "clap", arg(long, help_heading = headings::KEEP))]
    pub keep_features: bool,
    /// Keep edges where the surface bends by more than DEGREES
    #[serde(deserialize_with = "option_json::degrees")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEGREES", value_parser = parse::degrees,
        allow_negative_numbers = true, help_heading = headings::KEEP, hide_short_help = true))]
    pub crease_angle: Option<f64>,
    /// Keep the boundary exactly, so that neighbouring tiles still fit
    #[cfg_attr(feature = "clap", arg(long, alias = "lock-borders", help_heading = headings::KEEP))]
    pub lock_boundaries: bool,
    /// Keep all components, even if their vertices would reduce the distance more elsewhere
    #[cfg_attr(feature = "clap", arg(long, help_heading = headings::KEEP))]
    pub keep_components: bool,
    /// Keep a node, mesh, object, group or material unchanged; may be repeated
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", help_heading = headings::KEEP))]
    pub keep: Vec<String>,
    /// Do not move vertices: the result uses vertices of the input
    #[cfg_attr(feature = "clap", arg(long, help_heading = headings::KEEP))]
    pub subset: bool,
    /// Discard attributes (uv, normals, colors, materials), so that their seams and borders do not limit the result
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "WHAT", value_delimiter = ',',
        help_heading = headings::KEEP, hide_short_help = true))]
    pub ignore: Vec<Ignored>,
    /// Distance that texture seams may move, in texels of the largest colour texture [default: 1/64 of its side]
    #[serde(deserialize_with = "option_json::seam_texels")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "TEXELS", value_parser = parse::seam_texels,
        allow_negative_numbers = true, help_heading = headings::KEEP, hide_short_help = true,
        long_help = "Distance that texture seams may move almost freely, in texels of the largest colour texture (of one with \
        1024 texels a side if there is none); 0 keeps seams as strictly as creases [default: 1/64 of the side]"))]
    pub seam_error: Option<f64>,
    /// Weights of vertices: the name of a numeric vertex attribute, or NAME=FACTOR for the faces of a node, mesh, material,
    /// group or object. Larger weights keep more vertices; all other faces have weight 1
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", help_heading = headings::KEEP, hide_short_help = true))]
    pub importance: Option<String>,
    /// Drop components smaller than SIZE, in units of the mesh or with % of its diagonal; without SIZE, smaller than the bound of
    /// --error. Dropped components do not count for the bound
    #[serde(deserialize_with = "option_json::optional_bound", serialize_with = "option_json::write_optional")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SIZE", value_parser = parse::bound, num_args = 0..=1,
        require_equals = true, help_heading = headings::KEEP, hide_short_help = true))]
    pub prune: Option<Option<Bound>>,
    /// Keep the shape of components, within DISTANCE in units of the mesh or with % of its diagonal [default: 1%]. Sizes that
    /// need more are then not reached
    #[serde(deserialize_with = "option_json::optional_bound", serialize_with = "option_json::write_optional")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DISTANCE", value_parser = parse::bound, num_args = 0..=1,
        require_equals = true, help_heading = headings::KEEP, hide_short_help = true))]
    pub hold_shape: Option<Option<Bound>>,
    /// Treatment of surfaces that are invisible from outside
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t, help_heading = headings::KEEP,
        hide_short_help = true))]
    pub hidden: Hidden,
    /// Close holes with at most EDGES boundary edges [default: all holes]
    #[serde(deserialize_with = "option_json::optional_n_edges", serialize_with = "option_json::write_optional")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "EDGES", value_parser = parse::n_edges,
        num_args = 0..=1, require_equals = true, help_heading = headings::REPAIR))]
    pub fill_holes: Option<Option<usize>>,
    /// Make a printable solid; drops components smaller than SIZE [default: 1%]
    #[serde(deserialize_with = "option_json::optional_bound", serialize_with = "option_json::write_optional")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SIZE", value_parser = parse::bound, num_args = 0..=1,
        require_equals = true, help_heading = headings::REPAIR,
        long_help = "Make a printable solid: closes holes, turns faces outward, and removes fins, inner walls, inner shells \
        and components smaller than SIZE, in units of the mesh or with % of its diagonal [default: 1%]"))]
    pub printable: Option<Option<Bound>>,
    /// Merge vertices closer than DISTANCE, in units of the mesh or with % of its diagonal
    #[serde(deserialize_with = "option_json::weld_distance")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "DISTANCE", value_parser = parse::bound,
        allow_hyphen_values = true, help_heading = headings::REPAIR))]
    pub weld: Option<Bound>,
    /// Do not merge vertices at equal positions
    #[cfg_attr(feature = "clap", arg(long, help_heading = headings::REPAIR, hide_short_help = true))]
    pub no_weld: bool,
    /// Bake the look of the original into new textures of SIZE x SIZE texels; for glb, gltf, obj
    #[serde(deserialize_with = "option_json::texture_side")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SIZE", value_parser = parse::texture_side,
        hide = cfg!(not(feature = "bake")), allow_negative_numbers = true, help_heading = headings::TEXTURES,
        long_help = "Simplify the shape alone, unwrap the result, and bake the look of the original into textures of SIZE x \
        SIZE texels, with a normal map; writes glb, gltf or obj"))]
    pub bake: Option<usize>,
    /// Compression of a written glTF
    #[serde(deserialize_with = "option_json::compression")]
    #[cfg_attr(feature = "clap", arg(long, value_enum, value_name = "HOW", num_args = 0..=1, require_equals = true,
        default_missing_value = "meshopt", hide_possible_values = true, help = COMPRESS_HELP[0],
        long_help = COMPRESS_HELP[1], help_heading = headings::TEXTURES))]
    pub compress: Option<Compression>,
    /// Shrink textures whose longer side exceeds SIZE texels; others stay unchanged
    #[serde(deserialize_with = "option_json::texture_side")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "SIZE", value_parser = parse::texture_side,
        allow_negative_numbers = true, help_heading = headings::TEXTURES))]
    pub textures: Option<usize>,
    /// Also read materials and textures that lie outside the folder of the mesh
    #[cfg_attr(feature = "clap", arg(long, help_heading = headings::TEXTURES, hide_short_help = true))]
    pub allow_outside: bool,
    /// Measure to favour: mean distance, largest distance, normals (shading), or appearance
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t, help_heading = headings::QUALITY))]
    pub optimize: Optimize,
    /// Time to spend: more time, smaller distance to the original
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t, help_heading = headings::QUALITY))]
    pub effort: Effort,
    /// Source of the scores, which say where vertices are needed [default: bending]
    #[cfg_attr(feature = "clap", arg(long, value_enum, help_heading = headings::QUALITY,
        long_help = "Source of the scores, which say where vertices are needed [default: bending; network if --weights is \
        given]"))]
    pub scores: Option<ScoreSource>,
    /// Weights of a trained network (safetensors), for --scores network and --assembly paper [default: those of the program]
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE", help_heading = headings::QUALITY,
        hide_short_help = true))]
    pub weights: Option<PathBuf>,
    /// Method that builds the surface
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t, help_heading = headings::QUALITY,
        hide_short_help = true))]
    pub assembly: AssemblyName,
    /// With --assembly paper: way of drawing the vertices by their scores
    #[cfg_attr(feature = "clap", arg(long, value_enum, default_value_t, help_heading = headings::QUALITY,
        hide_short_help = true))]
    pub draw: Draw,
    /// With --assembly paper: close the holes of the result
    #[cfg_attr(feature = "clap", arg(long, help_heading = headings::QUALITY, hide_short_help = true))]
    pub close: bool,
    /// With --assembly paper: sample again, denser where the error is large, and move vertices to reduce the error
    #[cfg_attr(feature = "clap", arg(long, help_heading = headings::QUALITY, hide_short_help = true))]
    pub place: bool,
    /// Seed of the sampling of --assembly paper; equal seeds give equal meshes
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t, value_parser = parse::seed,
        allow_negative_numbers = true, help_heading = headings::QUALITY, hide_short_help = true))]
    pub seed: u64,
    /// Do not measure the distance of the result to the original
    #[cfg_attr(feature = "clap", arg(long, help_heading = headings::QUALITY, hide_short_help = true))]
    pub no_check: bool,
    /// Shares by name, which the program has in `ratio`.
    #[serde(deserialize_with = "option_json::named_shares")]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub ratio_of: BTreeMap<String, f64>,
    /// True to map input vertices to output vertices; for the program the name of a file.
    #[cfg_attr(feature = "clap", arg(skip))]
    pub map: bool,
}
