//! Measures cuts of hierarchies beside `simplify` at equal triangles and at an equal error, one row of CSV each.
//!
//! `cargo run --release -p neural-mesh-bench --example hierarchy_cuts -- MESH...`, with meshes in any format.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use neural_mesh::appearance::appearance;
use neural_mesh::clusters::{ClusterOptions, Clusters, build_clusters};
use neural_mesh::io::{Format, read_attributed_path};
use neural_mesh::job::{Arguments, Document, RatioOf};
use neural_mesh::mesh::topology;
use neural_mesh::metrics::quick_distance;
use neural_mesh::search::simplify_to_error;
use neural_mesh::simplify::{ClosedOptions, Options, Size, simplify};

/// Triangles of the mesh over the most of a cut.
const SHARES: [usize; 4] = [4, 16, 64, 256];
/// Height of the pictures in pixels.
const HEIGHT: usize = 256;
const N_SAMPLES: usize = 200_000;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "mesh,components,share,triangles,iou,iou_simplify,flip_over_simplify,proved_over_sampled,over_simplify_error"
    );
    for path in std::env::args().skip(1) {
        measure_cuts(Path::new(&path))?;
    }
    Ok(())
}

fn measure_cuts(path: &Path) -> Result<(), Box<dyn Error>> {
    // A document cleans the mesh and keeps what it carries, as for every program.
    let arguments = Arguments { ratio: vec![RatioOf { name: None, share: 0.5 }], ..Arguments::default() };
    let job = arguments.job_as(Format::Glb)?;
    let document = Document::from_mesh(read_attributed_path(path, None)?, &job)?;
    let (input, mesh) = (document.input(), document.mesh());
    let closed = ClosedOptions { frame: document.frame, ..job.closed_options() };
    let go_on = &mut |_| ControlFlow::Continue(());
    let options = ClusterOptions { simplify: closed.clone(), ..ClusterOptions::default() };
    let clusters = build_clusters(&input, &options, &mut |_| ControlFlow::Continue(()))?;
    for share in SHARES {
        let Some((error, cut)) = cut_of_size(&clusters, mesh.faces().len() / share) else { continue };
        let (cut, _) = clusters.mesh_of(&cut);
        let n = cut.faces().len();
        let alike = simplify(input, &Options::with_closed(Size::Faces(n), closed.clone()), go_on)?.mesh;
        let [own, other] = [&cut, &alike].map(|made| appearance(mesh, made, HEIGHT).ok_or("no faces"));
        let (own, other) = (own?, other?);
        let sampled = quick_distance(mesh, &cut, N_SAMPLES, 0).ok_or("no faces")?.max;
        let bounded = simplify_to_error(&input, &closed, error.into(), go_on)?.simplified.mesh;
        println!(
            "{},{},1/{share},{n},{:.3},{:.3},{:.2},{:.2},{:.2}",
            path.display(),
            topology(mesh).components,
            own.silhouette_iou,
            other.silhouette_iou,
            own.flip / other.flip,
            f64::from(error) / sampled,
            n as f64 / bounded.faces().len() as f64
        );
    }
    Ok(())
}

/// Returns the finest cut of at most `n_faces` faces, and its error.
fn cut_of_size(clusters: &Clusters, n_faces: usize) -> Option<(f32, Vec<u32>)> {
    let mut errors: Vec<f32> = clusters.groups.iter().map(|group| group.error).collect();
    errors.sort_by(f32::total_cmp);
    let n_faces_of = |&cluster: &u32| clusters.clusters[cluster as usize].n_faces as usize;
    let count = |error: f32| clusters.cut_at_error(error.into()).iter().map(n_faces_of).sum::<usize>();
    let error = *errors.get(errors.partition_point(|&error| count(error) > n_faces))?;
    Some((error, clusters.cut_at_error(error.into())))
}
