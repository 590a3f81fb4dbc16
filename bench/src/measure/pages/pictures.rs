//! Pictures of meshes before and after.

use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;

use crate::baselines::{Baseline, Size, simplify_by};
use anyhow::{Context, Result, ensure};
use neural_mesh::io::write_path;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::picture::{PictureOptions, encode_png, render};
use neural_mesh::simplify::{Options, Target, simplify};

use super::{build_program, paper};
use crate::measure::markdown::count;
use crate::measure::meshes::{load, name};
use crate::measure::root;
use crate::measure::workbench::Bench;

// All licences allow pictures of these meshes.
const MESHES: [(&str, &str, f64); 6] = [
    ("test", "spot", 0.2),
    ("test", "nefertiti", 0.05),
    ("test", "suzanne", 0.5),
    ("train", "obj_deer", 0.1),
    ("train", "csg_engine_block", 0.1),
    ("train", "proc_gyroid_ball", 0.05),
];
const README: &str = "docs/pictures/spot.png";
const HEIGHT: usize = 440;
const SAMPLES: usize = 100_000;

pub fn page(bench: &Bench) -> Result<String> {
    let mut page = String::from(
        "From left to right: the input, neural-mesh, and meshoptimizer's `simplify` at the same number of faces. Distances are two-sided \
         means as fractions of the bounding box's diagonal; the normal error is the mean of 1 - n.n'.\n",
    );
    for (set, mesh, ratio) in MESHES {
        let path = bench.set_folder(set).join(mesh).with_extension("ply");
        page += &bench.measure_once(&format!("pictures/{mesh}"), || draw_mesh(&path, ratio))?;
    }
    bench.measure_once("pictures/readme", || draw_readme_picture(&bench.scratch("readme")?))?;
    page += &figure_6(bench)?;
    Ok(page
        + "\n## Sources of the meshes\n\nSpot by Keenan Crane (CC0), the bust of Nefertiti by Nora Al-Badri and Jan Nikolai Nelles \
             (public domain), Suzanne of Blender (MIT, from the trimesh repository), the deer by Sizzler (CC0); the engine block and the \
             gyroid are procedural (CC0).\n")
}

fn figure_6(bench: &Bench) -> Result<String> {
    let picture = "docs/measured/figure6.png";
    let printed: String = bench.measure_once("figure6", || {
        let mut cargo = Command::new("cargo");
        cargo.args(["run", "--quiet", "--release", "-p", "neural-mesh-bench", "--example", "figure6", "--"]);
        let mesh = std::path::absolute(bench.set_folder("tosca").join("cat0.ply"))?;
        let done = cargo.arg(mesh).arg(paper::weights()).arg(picture).current_dir(root()).output().context("cargo")?;
        ensure!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        Ok(String::from_utf8(done.stdout)?)
    })?;
    Ok(format!(
        "\n## The paper's Figure 6: distances along the surface\n\nThe table has the errors of geodesic and \
         biharmonic distances from one point of a cat at ratio 0.1; the picture shows lines of equal distance.\n\n{printed}\n![Distances on a cat and on three simplified versions](figure6.png)\n"
    ))
}

fn draw_readme_picture(folder: &Path) -> Result<()> {
    let mut program = Command::new(build_program()?);
    program.args(["simplify", "tests/meshes/spot.ply", "--ratio", "0.1", "--picture", README, "--force", "--quiet"]);
    let status = program.arg("-o").arg(std::path::absolute(folder)?.join("spot.ply")).current_dir(root()).status()?;
    ensure!(status.success(), "{README} cannot be made");
    Ok(())
}

fn draw_mesh(path: &Path, ratio: f64) -> Result<String> {
    let mesh = load(path)?;
    let ours = simplify(&mesh, None, &Options::new(Target::Ratio(ratio)), &mut |_| ControlFlow::Continue(()))?.mesh;
    let size = Size { vertices: ours.positions().len(), faces: ours.faces().len() };
    let theirs = simplify_by(Baseline::Meshoptimizer, &mesh, size, 0)?;
    let original = Surface::new(&mesh, SAMPLES, 0);
    let caption = |method: &str, lighter: &TriMesh| {
        let found = surface_distance(&original, &Surface::new(lighter, SAMPLES, 1)).context("no faces")?;
        let (mean, normals) = (1e4 * found.both.mean / found.diagonal, found.both.normal_error);
        let n_faces = lighter.faces().len();
        Ok::<_, anyhow::Error>(format!("{method}: {n_faces} faces\ndistance {mean:.2}e-4, normals {normals:.4}"))
    };
    let captions = vec![
        format!("{} faces", mesh.faces().len()),
        caption("neural-mesh", &ours)?,
        caption("meshoptimizer", &theirs)?,
    ];
    let mut options = PictureOptions::default();
    (options.height, options.captions) = (HEIGHT, captions);
    let image = render(&[&mesh, &ours, &theirs], &options);
    let (name, folder) = (name(path), root().join("docs/measured"));
    std::fs::create_dir_all(&folder)?;
    write_path(&folder.join(format!("{name}.png")), &encode_png(&image), true)?;
    let (before, after) = (count(mesh.faces().len()), count(ours.faces().len()));
    Ok(format!("\n## {name}, {after} faces of {before}\n\n![{name}]({name}.png)\n"))
}
