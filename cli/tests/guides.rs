//! Runs the commands of the guides in order.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use crate::common::folder;

fn blocks(page: &str, language: &str) -> Vec<String> {
    let opening = format!("```{language}\n");
    let after = page.split(&opening).skip(1);
    after.map(|rest| rest.split("```").next().unwrap_or_default().to_string()).collect()
}

fn run_guide(page: &str) -> tempfile::TempDir {
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let text = fs::read_to_string(checkout.join("docs/guide").join(page)).unwrap();
    let (home, work) = (folder(), folder());
    symlink(checkout, home.path().join("neural-mesh")).unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_neural-mesh")).parent().unwrap().to_path_buf();
    let others = std::env::var_os("PATH").unwrap();
    let path = std::env::join_paths(std::iter::once(program).chain(std::env::split_paths(&others))).unwrap();
    let commands = blocks(&text, "sh");
    assert!(!commands.is_empty());
    for block in commands {
        let mut shell = Command::new("bash");
        shell.args(["-euc", &block]).current_dir(work.path()).env("HOME", home.path()).env("PATH", &path);
        let run = shell.output().unwrap();
        assert!(run.status.success(), "{page}: {block}\n{}", String::from_utf8_lossy(&run.stderr));
    }
    work
}

fn check_files(work: &tempfile::TempDir, names: &[&str]) {
    names.iter().for_each(|name| assert!(work.path().join(name).is_file(), "{name}"));
}

#[cfg(all(feature = "bake", feature = "meshopt"))]
#[test]
fn for_artists() {
    let work = run_guide("artist.md");
    check_files(
        &work,
        &["bust-light.png", "bust-0.glb", "bust-2.glb", "bust-small.glb", "bust.html", "light/manifest.csv"],
    );
    let bytes = |name: &str| fs::metadata(work.path().join(name)).unwrap().len();
    assert!(bytes("bust-small.glb") < bytes("bust-light.glb"));
    check_files(&work, &["light/bust.glb", "pictures/bust.glb.png"]);
}

#[test]
fn for_people_with_a_scan_or_something_to_print() {
    let work = run_guide("scan.md");
    check_files(&work, &["filled.ply", "exact.json", "five.ply", "scan.html", "reports/holes.ply.json", "surface.ply"]);
    check_files(&work, &["solid.stl", "part.3mf", "edges.stl", "part.html", "front.png"]);
    assert!(fs::metadata(work.path().join("small.ply")).unwrap().len() <= 200_000);
}

#[test]
fn for_researchers() {
    check_files(&run_guide("researcher.md"), &["mine.ply"]);
}
