//! Measures hierarchies of clusters beside those of meshoptimizer's `clusterlod.h`, on one thread, as rows of CSV.
//!
//! `cargo run --release -p neural-mesh-bench --example clusters -- MESH...`

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use meshopt::clusterlod::{ClodMesh, clod_build, clod_default_config};
use meshopt::{VertexDataAdapter, typed_to_bytes};
use neural_mesh::clusters::{ClusterOptions, Clusters, ViewPoint, build_clusters};
use neural_mesh::io::read_path;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{TriMesh, compact, edges, topology};
use neural_mesh::metrics::{DistanceTolerance, certified_distance, quick_distance};
use neural_mesh::simplify::{ClosedOptions, Effort, Input};
use nix::sys::time::TimeValLike;
use nix::time::ClockId;

const HEADER: &str = "mesh,effort,faces,seconds_per_million,clusterlod_seconds_per_million,roots,root_faces,clusterlod_roots,\
fill,clusterlod_fill,share,clusterlod_faces,cut_faces,mean_over_clusterlod,max_over_clusterlod,proved_over_measured,open_edges";
/// Shares of the faces at which cuts are compared.
const SHARES: [usize; 3] = [4, 16, 64];
const SAMPLES: usize = 100_000;
const N_CUTS: u32 = 1000;
const MAX_FACES: usize = 128;

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    println!("{HEADER}");
    for path in std::env::args().skip(1) {
        let mesh = clean(read_path(Path::new(&path), None)?, &CleanOptions::default())?.mesh;
        let (other, other_seconds) = timed(|| OtherHierarchy::new(&mesh));
        for effort in [Effort::Fast, Effort::Standard] {
            let (own, seconds) = timed(|| build(&mesh, effort));
            let own = own?;
            let n_open = open_edges_of_random_cuts(&mesh, &own);
            let per_million = 1e6 / mesh.faces().len() as f64;
            for share in SHARES {
                let name = Path::new(&path).file_stem().unwrap_or_default().to_string_lossy();
                let roots = own.roots();
                let root_faces: u32 = roots.iter().map(|&root| own.clusters[root as usize].n_faces).sum();
                println!(
                    "{name},{effort:?},{},{:.2},{:.2},{},{root_faces},{},{:.3},{:.3},1/{share},{},{n_open}",
                    mesh.faces().len(),
                    seconds * per_million,
                    other_seconds * per_million,
                    roots.len(),
                    other.n_roots(),
                    own.faces.len() as f64 / (own.clusters.len() * MAX_FACES) as f64,
                    other.fill(),
                    compare(&mesh, &own, &other, mesh.faces().len() / share)?,
                );
            }
        }
    }
    Ok(())
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    // The pool's thread works while this one waits.
    let now = || ClockId::CLOCK_PROCESS_CPUTIME_ID.now().map_or(0, |time| time.num_nanoseconds());
    let begin = now();
    let made = work();
    (made, (now() - begin) as f64 * 1e-9)
}

fn build(mesh: &TriMesh, effort: Effort) -> Result<Clusters, Box<dyn Error>> {
    let simplify = ClosedOptions { effort, ..ClosedOptions::default() };
    let options = ClusterOptions { max_faces: MAX_FACES, simplify, ..ClusterOptions::default() };
    Ok(build_clusters(&Input::bare(mesh), &options, &mut |_| ControlFlow::Continue(()))?)
}

/// Clusters of meshoptimizer with the errors of the groups between which each is drawn.
struct OtherHierarchy<'a> {
    mesh: &'a TriMesh,
    clusters: Vec<OtherCluster>,
    errors: Vec<f32>,
}

struct OtherCluster {
    faces: Vec<[u32; 3]>,
    source: Option<usize>,
    group: usize,
}

impl<'a> OtherHierarchy<'a> {
    fn new(mesh: &'a TriMesh) -> Self {
        let indices = mesh.faces().as_flattened();
        let mut made = Self { mesh, clusters: Vec::new(), errors: Vec::new() };
        let Ok(vertices) = VertexDataAdapter::new(typed_to_bytes(mesh.positions()), 12, 0) else { return made };
        clod_build(clod_default_config(MAX_FACES), &ClodMesh::new(indices, &vertices), |group, clusters| {
            made.errors.push(group.simplified.error);
            let number = made.errors.len() - 1;
            made.clusters.extend(clusters.iter().map(|cluster| OtherCluster {
                faces: cluster.indices.as_chunks().0.to_vec(),
                source: usize::try_from(cluster.refined).ok(),
                group: number,
            }));
            number as i32
        });
        made
    }

    fn n_roots(&self) -> usize {
        self.clusters.iter().filter(|cluster| self.errors[cluster.group] == f32::MAX).count()
    }

    fn fill(&self) -> f64 {
        let n_faces: usize = self.clusters.iter().map(|cluster| cluster.faces.len()).sum();
        n_faces as f64 / (self.clusters.len() * MAX_FACES) as f64
    }

    fn cut(&self, error: f32) -> impl Iterator<Item = &OtherCluster> {
        let is_drawn = move |cluster: &&OtherCluster| {
            self.errors[cluster.group] > error && cluster.source.is_none_or(|source| self.errors[source] <= error)
        };
        self.clusters.iter().filter(is_drawn)
    }

    /// Returns the finest cut of at most `n_faces` faces; the coarsest if there is none.
    fn cut_of_size(&self, n_faces: usize) -> Option<TriMesh> {
        let count = |error: f32| self.cut(error).map(|cluster| cluster.faces.len()).sum();
        let error = least_error(self.errors.iter().copied().filter(|error| *error < f32::MAX), n_faces, count)?;
        let faces = self.cut(error).flat_map(|cluster| cluster.faces.iter().copied()).collect();
        compact(self.mesh.positions(), faces).ok().map(|(mesh, _)| mesh)
    }
}

/// Returns the least error whose cut has at most `n_faces` faces, or else the largest one.
fn least_error(errors: impl Iterator<Item = f32>, n_faces: usize, count: impl Fn(f32) -> usize) -> Option<f32> {
    let mut errors: Vec<f32> = errors.collect();
    errors.sort_by(f32::total_cmp);
    let at = errors.partition_point(|&error| count(error) > n_faces);
    errors.get(at).or(errors.last()).copied()
}

fn compare(mesh: &TriMesh, own: &Clusters, other: &OtherHierarchy, n_faces: usize) -> Result<String, Box<dyn Error>> {
    let other = other.cut_of_size(n_faces).ok_or("clusterlod made nothing")?;
    let count = |error: f32| {
        let cut = own.cut_at_error(error.into());
        cut.into_iter().map(|cluster| own.clusters[cluster as usize].n_faces as usize).sum()
    };
    let errors = own.groups.iter().map(|group| group.error);
    let error = least_error(errors, other.faces().len(), count).ok_or("no group")?;
    let (cut, _) = own.mesh_of(&own.cut_at_error(error.into()));
    let distance = |cut: &TriMesh| quick_distance(mesh, cut, SAMPLES, 0).ok_or("no faces");
    let (ours, theirs) = (distance(&cut)?, distance(&other)?);
    let proved = certified_distance(mesh, &cut, &DistanceTolerance::default()).ok_or("no faces")?;
    Ok(format!(
        "{},{},{:.3},{:.3},{:.2}",
        other.faces().len(),
        cut.faces().len(),
        ours.mean / theirs.mean,
        ours.max / theirs.max,
        f64::from(error) / proved.lower
    ))
}

/// Counts edges with an odd number of faces in cuts of random views, beyond those of the mesh.
fn open_edges_of_random_cuts(mesh: &TriMesh, clusters: &Clusters) -> usize {
    let n_of_mesh = topology(mesh).boundary_edges;
    let diagonal = mesh.diagonal();
    let middle = mesh.positions().iter().fold([0.0; 3], |sum: [f64; 3], p| {
        std::array::from_fn(|k| sum[k] + f64::from(p[k]) / mesh.positions().len() as f64)
    });
    let cut = |number: u32| {
        // Directions of a spiral over the sphere, distances and errors of a low-discrepancy sequence.
        let (share, golden) = (f64::from(number) / f64::from(N_CUTS), f64::from(number) * 2.399_963_229_728_653);
        let (z, reach) = (1.0 - 2.0 * share, diagonal * (0.3 + (golden * 0.7).fract()));
        let ring = (1.0 - z * z).sqrt();
        let direction = [ring * golden.cos(), ring * golden.sin(), z];
        let eye = std::array::from_fn(|k| (middle[k] + reach * direction[k]) as f32);
        let view = ViewPoint { eye, pixels: 1000.0, near: 1e-3 * diagonal };
        clusters.cut_for_view(&view, 0.1 * 1000f64.powf((golden * 1.3).fract()))
    };
    let n_open = |number: u32| {
        let (cut, _) = clusters.mesh_of(&cut(number));
        edges(&cut).iter().filter(|edge| edge.n_faces() % 2 == 1).count().saturating_sub(n_of_mesh)
    };
    (0..N_CUTS).map(n_open).sum()
}
