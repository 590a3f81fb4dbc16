//! Picture of a mesh before and after simplification.

use std::path::Path;

use neural_mesh::job::{Document, JobOutcome, JobReport, PlacedSurface};
use neural_mesh::metrics::farthest_point;
use neural_mesh::picture::{
    CornerNormals, DecodedMaterials, Image, PictureOptions, ShadedMesh, encode_jpeg, encode_png, encode_webp,
    render_shaded,
};

use crate::failure::{Failure, display_path};
use crate::files::{self, PendingFile};
use crate::messages;
use crate::request::Request;

const SAMPLES: usize = 20_000;
/// Largest distance that counts as rounding, in percent of the diagonal; it gets no ring in the picture.
const ROUNDING_PERCENT: f64 = 1e-4;

/// Encoder of an image; `None` if its format does not hold it.
type Encoder = fn(&Image) -> Option<Vec<u8>>;

/// Returns the encoder of the format that the name of a picture shows.
pub fn picture_encoder(path: &Path) -> Result<Encoder, Failure> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    match ending.to_str() {
        Some("png") => Ok(|image| Some(encode_png(image))),
        Some("jpg" | "jpeg") => Ok(encode_jpeg),
        Some("webp") => Ok(encode_webp),
        _ => Err(Failure::Usage(format!("--picture {}: end the name in .png, .jpg or .webp", path.display()))),
    }
}

pub struct PicturedMesh<'a> {
    surface: PlacedSurface<'a>,
    materials: Option<DecodedMaterials>,
    normals: Option<CornerNormals>,
}

impl PicturedMesh<'_> {
    fn to_shaded(&self) -> ShadedMesh<'_> {
        ShadedMesh {
            materials: self.materials.as_ref(),
            normals: self.normals.as_ref(),
            ..ShadedMesh::bare(&self.surface.mesh)
        }
    }
}

/// Collects original and result for a requested picture; adds to the report's notes what cannot be drawn.
pub fn prepare_picture<'a>(
    request: &Request,
    document: &'a Document,
    outcome: &mut JobOutcome,
) -> Result<Option<[PicturedMesh<'a>; 2]>, Failure> {
    let Some(result) = outcome.results.first().filter(|_| request.picture.is_some()) else { return Ok(None) };
    let (baked, notes) = (outcome.baked.as_ref(), &mut outcome.report.notes);
    let (looks, missing) = document.looks(request.job.arguments.allow_outside);
    let [before, after] =
        document.place_surfaces(result).map_err(|error| Failure::in_file(&request.source.path, error))?;
    let (materials, not_drawn) = DecodedMaterials::new(&before.attributes, &looks);
    let new_notes: Vec<String> = missing.into_iter().chain(not_drawn).filter(|note| !notes.contains(note)).collect();
    notes.extend(new_notes);
    let (attributes, looks_after) =
        baked.map_or((&*after.attributes, &looks), |baked| (&baked.attributes, &baked.looks));
    let (materials_after, normals_after) = (
        DecodedMaterials::with_textures_of(materials.as_ref(), attributes, looks_after).0,
        CornerNormals::new(attributes),
    );
    let normals = CornerNormals::new(&before.attributes);
    let after = PicturedMesh { surface: after, materials: materials_after, normals: normals_after };
    Ok(Some([PicturedMesh { surface: before, materials, normals }, after]))
}

/// Draws the requested picture into a temporary file, with a ring at the largest distance.
///
/// Edges are drawn if requested, or if neither mesh has colours.
pub fn draw_picture(
    request: &Request,
    pictured: Option<&[PicturedMesh; 2]>,
    report: &JobReport,
) -> Result<Option<PendingFile>, Failure> {
    let (Some(path), Some(pictured)) = (&request.picture, pictured) else { return Ok(None) };
    let meshes = pictured.each_ref().map(PicturedMesh::to_shaded);
    let [before, after] = meshes.map(|shaded| shaded.mesh);
    let largest = report.distance.filter(|distance| distance.max_percent > ROUNDING_PERCENT);
    let farthest = largest.and_then(|distance| Some((distance, farthest_point(before, after, SAMPLES)?)));
    let ringed = farthest.map_or(String::new(), |(distance, _)| format!("\n{}", messages::ring_caption(&distance)));
    let captions = vec![
        format!(
            "{}\n{}",
            messages::shorten_path(&display_path(&request.source.path)),
            messages::format_size(&report.input)
        ),
        format!("simplified\n{}{ringed}", messages::format_size(&report.output.size)),
    ];
    let edges = request.wires || meshes.iter().all(|shaded| shaded.materials.is_none());
    let marks = farthest.map(|(_, place)| place).into_iter().collect();
    let mut options = PictureOptions::default();
    (options.captions, options.edges) = (captions, edges);
    (options.marks, options.view) = (marks, request.view);
    let bytes = picture_encoder(path)?(&render_shaded(&meshes, &options));
    let bytes = bytes.ok_or_else(|| Failure::in_file(path, "cannot be encoded: end the name in .png"))?;
    files::prepare_file(path, &bytes, request.force).map(Some)
}
