//! `neural-mesh clusters`: hierarchies of clusters.

use crate::common::avatar::Avatar;
use crate::common::{error_line, folder, refuse, run, succeed, test_mesh_path};
use neural_mesh::clusters::Clusters;
use neural_mesh::io::{Format, write};
use neural_mesh::mesh::{Frame, edges, shapes, topology};
use serde_json::Value;

#[test]
fn a_hierarchy_is_written_and_read_back() {
    let folder = folder();
    let mesh = test_mesh_path("spot.ply");
    let report = ["clusters", mesh.to_str().unwrap(), "-o", "spot.nmc", "--report", "report.json"];
    succeed(folder.path(), &report);
    let report: Value = serde_json::from_slice(&std::fs::read(folder.path().join("report.json")).unwrap()).unwrap();
    assert_eq!((&report["roots"], &report["faces"]), (&1.into(), &5856.into()));
    let bytes = std::fs::read(folder.path().join("spot.nmc")).unwrap();
    let clusters = Clusters::from_bytes(&bytes).unwrap();
    assert_eq!(clusters.clusters.len(), report["clusters"].as_u64().unwrap() as usize);
    let error = f64::from(clusters.groups.iter().map(|group| group.error).fold(0.0, f32::max));
    let (coarse, _) = clusters.mesh_of(&clusters.cut_at_error(error));
    assert!((1..=128).contains(&coarse.faces().len()));
    let line = refuse(folder.path(), &["clusters", mesh.to_str().unwrap(), "-o", "spot.nmc"], 1);
    assert!(line.contains("--force"), "{line}");
}

#[test]
fn a_scene_keeps_its_materials_and_texture_coordinates() {
    let folder = folder();
    std::fs::write(folder.path().join("scene.glb"), Avatar::new(12).glb()).unwrap();
    let made = succeed(folder.path(), &["clusters", "scene.glb", "-o", "-", "--max-faces", "64"]);
    let clusters = Clusters::from_bytes(&made.stdout).unwrap();
    assert!(clusters.face_groups.iter().any(|group| *group > 0));
    assert!(clusters.channels.iter().any(|channel| channel.width == 2));
    assert!(clusters.clusters.iter().all(|cluster| cluster.n_faces <= 64));
}

#[test]
fn a_page_has_the_textures_of_its_materials() {
    let folder = folder();
    std::fs::write(folder.path().join("scene.glb"), Avatar::new(12).glb()).unwrap();
    succeed(folder.path(), &["clusters", "scene.glb", "-o", "a.nmc", "--html", "a.html"]);
    let page = std::fs::read_to_string(folder.path().join("a.html")).unwrap();
    let facts = page.split_once("id=\"embedded\">").unwrap().1.split_once("</script>").unwrap().0;
    let facts: Value = serde_json::from_str(facts).unwrap();
    let (paints, groups) = (facts["paints"].as_array().unwrap(), facts["groups"].as_array().unwrap());
    let clusters = Clusters::from_bytes(&std::fs::read(folder.path().join("a.nmc")).unwrap()).unwrap();
    assert!(
        clusters.face_groups.iter().all(|group| (groups[*group as usize].as_u64().unwrap() as usize) < paints.len())
    );
    let textured: Vec<&Value> = paints.iter().filter(|paint| !paint["image"].is_null()).collect();
    assert!(!textured.is_empty() && textured.len() < paints.len() + 1, "{facts}");
    for paint in textured {
        assert!(page.contains(&format!("data-of=\"image-{}\"", paint["image"])), "{facts}");
        assert_eq!(facts["images"][paint["image"].as_u64().unwrap() as usize], "image/png");
    }
}

#[test]
fn bevy_gets_its_own_format_and_wrong_sizes_are_refused() {
    let folder = folder();
    let mesh = test_mesh_path("spot.ply");
    let mesh = mesh.to_str().unwrap();
    let made = run(folder.path(), &["clusters", mesh, "-o", "spot.meshlet_mesh", "--quiet"]);
    assert_eq!((made.code, made.stdout.len()), (Some(0), 0), "{}", made.stderr);
    let bytes = std::fs::read(folder.path().join("spot.meshlet_mesh")).unwrap();
    assert_eq!(bytes[8..16], 3u64.to_le_bytes());
    let large = run(folder.path(), &["clusters", mesh, "-o", "large.meshlet_mesh", "--max-faces", "200"]);
    assert!(large.code == Some(1) && error_line(&large).contains("128"), "{}", large.stderr);
    assert!(!folder.path().join("large.meshlet_mesh").exists());
    let wrong = run(folder.path(), &["clusters", mesh, "-o", "a.nmc", "--max-faces", "3"]);
    assert_eq!(wrong.code, Some(2), "{}", wrong.stderr);
}

#[test]
fn a_page_is_written_beside_the_hierarchy() {
    let folder = folder();
    let mesh = test_mesh_path("spot.ply");
    let arguments = ["clusters", mesh.to_str().unwrap(), "-o", "spot.nmc", "--quiet", "--html"];
    let with_page = |page: &str| run(folder.path(), &[&arguments[..], &[page]].concat());
    for wrong in ["-", "./spot.nmc"] {
        let refused = with_page(wrong);
        assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    }
    assert!(!folder.path().join("spot.nmc").exists());
    let made = with_page("spot.html");
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let page = std::fs::read_to_string(folder.path().join("spot.html")).unwrap();
    assert!(page.contains("<title>spot.ply - ") && page.contains("data-of=\"embedded\""));
    assert!(folder.path().join("spot.nmc").exists());
}

#[test]
fn a_mesh_larger_than_the_memory_gets_its_hierarchy_in_blocks() {
    let folder = folder();
    let mesh = shapes::icosphere(8);
    std::fs::write(folder.path().join("large.ply"), write(&mesh, &Frame::default(), Format::Ply).unwrap()).unwrap();
    let clusters = |output: &str, more: &[&str]| {
        let words = ["clusters", "large.ply", "-o", output, "--effort", "fast", "--memory", "0.25"];
        run(folder.path(), &[&words[..], more].concat())
    };
    for (output, more) in [("a.meshlet_mesh", &[][..]), ("-", &[]), ("a.nmc", &["--html", "a.html"])] {
        let refused = clusters(output, more);
        assert_eq!(refused.code, Some(1), "{}", refused.stderr);
        assert!(error_line(&refused).contains("in blocks"), "{}", refused.stderr);
    }
    let made = clusters("a.nmc", &["--report", "r.json"]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let report: Value = serde_json::from_slice(&std::fs::read(folder.path().join("r.json")).unwrap()).unwrap();
    assert_eq!((&report["roots"], &report["faces"]), (&1.into(), &1_310_720.into()));
    let clusters = Clusters::from_bytes(&std::fs::read(folder.path().join("a.nmc")).unwrap()).unwrap();
    let (whole, _) = clusters.mesh_of(&clusters.cut_at_error(-1.0));
    assert_eq!(topology(&whole), topology(&mesh));
    let (light, _) = clusters.mesh_of(&clusters.cut_at_error(1e-3));
    assert!(light.faces().len() < 20_000 && edges(&light).iter().all(|edge| edge.n_faces() == 2));
}
