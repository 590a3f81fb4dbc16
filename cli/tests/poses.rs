//! `--for poses`: morph targets and skins are respected.

use std::path::Path;

use crate::common::{folder, run, succeed};
use neural_mesh::io::{Asset, read_path};
use neural_mesh::mesh::Role;

const N: usize = 40;

fn flat_and_rolled(i: usize) -> [[f32; 3]; 2] {
    let (x, y) = ((i / (N + 1)) as f32 * 4.0 / N as f32, (i % (N + 1)) as f32 / N as f32);
    [[x, y, 0.0], [x.sin(), y, 1.0 - x.cos()]]
}

fn write_sheet(folder: &Path, has_skin: bool) {
    let n = (N + 1) * (N + 1);
    let flat = (0..n).flat_map(|i| flat_and_rolled(i)[0]);
    let steps =
        (0..n).flat_map(|i| std::array::from_fn::<f32, 3, _>(|k| flat_and_rolled(i)[1][k] - flat_and_rolled(i)[0][k]));
    let joints = (0..n).flat_map(|i| [(flat_and_rolled(i)[0][0] as u8).min(2), 0, 0, 0]);
    let weights = std::iter::repeat_n([1f32, 0.0, 0.0, 0.0], n).flatten();
    let corners = (0..N * N).flat_map(|square| {
        let a = square / N * (N + 1) + square % N;
        [a, a + N + 1, a + N + 2, a, a + N + 2, a + 1].map(|v| v as u16)
    });
    let float = |x: f32| x.to_le_bytes();
    let mut buffer: Vec<u8> = flat.flat_map(float).chain(steps.flat_map(float)).collect();
    buffer.extend(weights.flat_map(float).chain(joints).chain(corners.flat_map(u16::to_le_bytes)));
    let [points, all, indices] = [12 * n, 16 * n, 12 * N * N];
    let views = [
        (0, points),
        (points, points),
        (2 * points, all),
        (2 * points + all, 4 * n),
        (2 * points + all + 4 * n, indices),
    ];
    let views = views.map(|(at, len)| format!(r#"{{"buffer":0,"byteOffset":{at},"byteLength":{len}}}"#)).join(",");
    let accessors =
        [(5126, n, "VEC3"), (5126, n, "VEC3"), (5126, n, "VEC4"), (5121, n, "VEC4"), (5123, 6 * N * N, "SCALAR")];
    let accessors = accessors.iter().enumerate().map(|(i, (component, count, shape))| {
        format!(r#"{{"bufferView":{i},"componentType":{component},"count":{count},"type":"{shape}"}}"#)
    });
    let accessors = accessors.collect::<Vec<_>>().join(",");
    let (attributes, targets, node, skins) = if has_skin {
        let skins = r#""skins":[{"joints":[1,2,3]}],"#;
        (r#","WEIGHTS_0":2,"JOINTS_0":3"#, "", r#","skin":0"#, skins)
    } else {
        ("", r#","targets":[{"POSITION":1}]"#, "", "")
    };
    let bones = r#"{"children":[2]},{"translation":[1,0,0],"children":[3]},{"translation":[1,0,0]}"#;
    let document = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0{node}}},{bones}],{skins}
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{attributes}}},"indices":4{targets}}}]}}],
        "accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{{"uri":"sheet.bin","byteLength":{}}}]}}"#,
        buffer.len()
    );
    std::fs::write(folder.join("sheet.bin"), buffer).unwrap();
    std::fs::write(folder.join("sheet.gltf"), document).unwrap();
}

fn light(folder: &Path, more: &[&str]) -> Asset {
    let run =
        run(folder, &[&["simplify", "sheet.gltf", "-o", "light.glb", "--ratio", "0.05", "--force"], more].concat());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    Asset::read_path(&folder.join("light.glb")).unwrap()
}

fn mean_distance_to_roll(asset: &Asset) -> f64 {
    let mesh = &asset.parts()[0].mesh;
    let targets: Vec<_> = mesh.attributes.channels.iter().filter(|it| it.role == Role::MorphPosition).collect();
    assert_eq!(targets.len(), 1);
    let off = mesh.faces.iter().zip(&mesh.attributes.wedges).map(|(face, wedges)| {
        let rolled = |axis: usize| {
            let rolled_coordinate =
                |k: usize| mesh.positions[face[k] as usize][axis] + f64::from(targets[0].value(wedges[k])[axis]);
            (rolled_coordinate(0) + rolled_coordinate(1) + rolled_coordinate(2)) / 3.0
        };
        (rolled(0).hypot(rolled(2) - 1.0) - 1.0).abs()
    });
    off.sum::<f64>() / mesh.faces.len() as f64
}

#[test]
fn a_flat_sheet_keeps_the_vertices_along_which_its_target_rolls_it_up() {
    let folder = folder();
    write_sheet(folder.path(), false);
    let [plain, posed] = [&[][..], &["--for", "poses"]].map(|more| mean_distance_to_roll(&light(folder.path(), more)));
    assert!(posed < 0.5 * plain, "{posed} {plain}");
}

#[test]
fn a_skin_without_an_animation_is_bent() {
    let folder = folder();
    write_sheet(folder.path(), true);
    let [plain, posed] = [&[][..], &["--for", "poses"]].map(|more| light(folder.path(), more));
    let [plain, posed] = [&plain, &posed].map(|asset| &asset.parts()[0].mesh);
    let names: Vec<&str> = posed.attributes.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["SKIN"]);
    // Joints meet at 1 and 2, where the sheet bends.
    let near_joints = |positions: &[[f64; 3]]| {
        positions.iter().filter(|p| (p[0] - 1.0).abs() < 0.2 || (p[0] - 2.0).abs() < 0.2).count()
    };
    assert!(near_joints(&posed.positions) > 2 * near_joints(&plain.positions));
}

#[test]
fn where_nothing_says_how_it_moves_every_place_may_bend() {
    let folder = folder();
    write_sheet(folder.path(), false);
    let ply = |more: &[&str]| {
        let words = [&["simplify", "sheet.gltf", "-o", "light.ply", "--ratio", "0.05", "--force"], more].concat();
        let run = succeed(folder.path(), &words);
        (String::from_utf8(run.stdout).unwrap(), read_path(&folder.path().join("light.ply"), None).unwrap())
    };
    let [(_, plain), (words, bending)] = [ply(&[]), ply(&["--for", "poses"])];
    assert!(words.contains("every region is assumed to bend alike"), "{words}");
    assert!(bending.positions.len() == plain.positions.len() && bending.positions != plain.positions);
}
