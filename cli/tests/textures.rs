//! `--textures`: images are scaled down when needed.

use std::path::Path;

use crate::common::*;
use neural_mesh::picture::{Image, decode_image, encode_png, encode_webp, image_size};
use tempfile::TempDir;

fn png(side: usize) -> Vec<u8> {
    let colour = |at: usize| [(at % side * 255 / side) as u8, (at / side * 255 / side) as u8, 90, 255];
    encode_png(&Image { width: side, height: side, rgba: (0..side * side).flat_map(colour).collect() })
}

fn textured_plate() -> TempDir {
    let folder = folder();
    let n = 8;
    let mut text = String::from("mtllib skin.mtl\nusemtl skin\n");
    for (i, j) in (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))) {
        text += &format!("v {i} {j} {}\nvt {} {}\n", (i * i + j) % 3, i as f64 / 8.0, j as f64 / 8.0);
    }
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let vertex = |i, j| 1 + j * (n + 1) + i;
        let [a, b, c, d] =
            [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)].map(|v| format!("{v}/{v}"));
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    std::fs::write(folder.path().join("plate.obj"), text).unwrap();
    let library = "newmtl skin\nmap_Kd maps/skin.png\nnorm maps/relief.png\nmap_Ns maps/small.png\n";
    std::fs::write(folder.path().join("skin.mtl"), library).unwrap();
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    for (name, side) in [("skin", 64), ("relief", 48), ("small", 16)] {
        std::fs::write(folder.path().join(format!("maps/{name}.png")), png(side)).unwrap();
    }
    folder
}

fn simplify_with_textures(folder: &Path, input: &str, output: &str, more: &[&str]) -> Run {
    let words = ["simplify", input, "-o", output, "--textures", "32"];
    let more = if more.is_empty() { &["--ratio", "50%"] } else { more };
    succeed(folder, &[&words[..], more].concat())
}

fn images(glb: &Path) -> (Vec<[usize; 2]>, serde_json::Value) {
    let bytes = std::fs::read(glb).unwrap();
    let length = u32::from_le_bytes(*bytes[12..].first_chunk().unwrap()) as usize;
    let document: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let buffer = &bytes[28 + length..];
    let size = |image: &serde_json::Value| {
        let view = &document["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
        let view_number = |name: &str| view[name].as_u64().unwrap_or(0) as usize;
        image_size(&buffer[view_number("byteOffset")..][..view_number("byteLength")]).unwrap()
    };
    (document["images"].as_array().unwrap().iter().map(size).collect(), document)
}

#[test]
fn images_beside_an_obj_keep_their_names_and_those_that_fit_their_bytes() {
    let folder = textured_plate();
    std::fs::create_dir(folder.path().join("out")).unwrap();
    simplify_with_textures(folder.path(), "plate.obj", "out/plate.obj", &[]);
    let maps = folder.path().join("out/maps");
    let size = |name: &str| image_size(&std::fs::read(maps.join(name)).unwrap()).unwrap();
    assert_eq!([size("skin.png"), size("relief.png"), size("small.png")], [[32, 32], [32, 32], [16, 16]]);
    assert_eq!(std::fs::read(maps.join("small.png")).unwrap(), png(16));
    let skin = decode_image(&std::fs::read(maps.join("skin.png")).unwrap()).unwrap();
    let before = decode_image(&png(64)).unwrap();
    let (small, large) = (&skin.rgba[4 * (16 * 32 + 8)..][..3], &before.rgba[4 * (33 * 64 + 17)..][..3]);
    assert!(small.iter().zip(large).all(|(a, b)| a.abs_diff(*b) < 6), "{small:?} {large:?}");
}

#[test]
fn images_within_a_glb_shrink_on_the_way_in_and_again_in_a_scene() {
    let folder = textured_plate();
    simplify_with_textures(folder.path(), "plate.obj", "plate.glb", &[]);
    let in_folder = |name: &str| folder.path().join(name);
    assert_eq!(images(&in_folder("plate.glb")).0, [[32, 32], [32, 32]]);
    succeed(folder.path(), &["simplify", "plate.glb", "-o", "less.glb", "--ratio", "50%", "--textures", "20"]);
    let (sizes, document) = images(&in_folder("less.glb"));
    assert_eq!(sizes, [[20, 20], [20, 20]]);
    assert_eq!(document["images"][0]["mimeType"], "image/png");
}

#[test]
fn levels_share_their_textures_in_every_format() {
    let folder = textured_plate();
    simplify_with_textures(folder.path(), "plate.obj", "plate.glb", &["--ratio", "1"]);
    for (output, beside) in [
        ("tree-{level}.gltf", vec!["tree-0.gltf", "tree-1.gltf", "tree.bin", "tree_0.png", "tree_1.png"]),
        ("{level}.gltf", vec!["0.gltf", "1.gltf", "levels.bin", "levels_0.png", "levels_1.png"]),
        ("{level}.obj", vec!["0.obj", "1.obj", "levels.mtl", "levels_0.png", "levels_1.png"]),
        ("tree-{level}.obj", vec!["tree-0.obj", "tree-1.obj", "tree.mtl", "tree_0.png", "tree_1.png"]),
    ] {
        let out = folder.path().join("out");
        std::fs::create_dir(&out).unwrap();
        simplify_with_textures(folder.path(), "plate.glb", &format!("out/{output}"), &["--lods", "50%,20%"]);
        assert_eq!(files(&out), beside);
        std::fs::remove_dir_all(out).unwrap();
    }
    // A GLB holds its own images, in one file or several.
    simplify_with_textures(folder.path(), "plate.glb", "own-{level}.glb", &["--lods", "50%,20%"]);
    assert!(["own-0.glb", "own-1.glb"].iter().all(|name| images(&folder.path().join(name)).0.len() == 2));
    simplify_with_textures(folder.path(), "plate.glb", "levels.glb", &["--lods", "50%,20%"]);
    assert_eq!(images(&folder.path().join("levels.glb")).0.len(), 2);
}

#[test]
fn levels_as_json_name_one_set_of_images_and_hold_none() {
    let folder = textured_plate();
    simplify_with_textures(folder.path(), "plate.obj", "plate.glb", &["--ratio", "1"]);
    // From a scene with images in its buffer, and from an OBJ as glTF in one file.
    for (input, output, more) in
        [("plate.glb", "scene-{level}.gltf", 0), ("plate.obj", "mesh-{level}.gltf", 0), ("plate.glb", "one.gltf", 1)]
    {
        let out = folder.path().join("out");
        std::fs::create_dir(&out).unwrap();
        let sizes = if more == 0 { ["--lods", "50%,20%"] } else { ["--ratio", "50%"] };
        simplify_with_textures(folder.path(), input, &format!("out/{output}"), &sizes);
        for name in files(&out).into_iter().filter(|name| name.ends_with(".gltf")) {
            let document = json(&out.join(&name));
            let uris: Vec<Option<&str>> =
                document["images"].as_array().unwrap().iter().map(|image| image["uri"].as_str()).collect();
            let shared = output.split('-').next().unwrap();
            match more {
                0 => assert_eq!(uris, [0, 1].map(|at| format!("{shared}_{at}.png")).each_ref().map(|uri| Some(&**uri))),
                _ => assert_eq!(uris, [None, None]),
            }
            // A reader of any level finds its images.
            let asset = neural_mesh::io::Asset::read_path(&out.join(&name)).unwrap();
            let sizes = [0, 1].map(|at| image_size(&asset.image(at).unwrap()).unwrap());
            assert_eq!((sizes, asset.notes()), ([[32, 32]; 2], &[][..]), "{name}");
        }
        std::fs::remove_dir_all(out).unwrap();
    }
}

#[test]
fn a_size_in_bytes_counts_the_small_images() {
    let folder = textured_plate();
    simplify_with_textures(folder.path(), "plate.obj", "plate.glb", &["--size", "8kB"]);
    assert!(std::fs::metadata(folder.path().join("plate.glb")).unwrap().len() <= 8000);
    assert_eq!(images(&folder.path().join("plate.glb")).0, [[32, 32], [32, 32]]);
}

#[test]
fn a_size_in_bytes_counts_the_images_beside_a_gltf() {
    let folder = textured_plate();
    for name in ["scene", "out"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    // A scene whose images are files of their own, which its result copies.
    simplify_with_textures(folder.path(), "plate.obj", "plate.glb", &[]);
    let (_, mut document) = images(&folder.path().join("plate.glb"));
    let bytes = std::fs::read(folder.path().join("plate.glb")).unwrap();
    let length = u32::from_le_bytes(*bytes[12..].first_chunk().unwrap()) as usize;
    std::fs::write(folder.path().join("scene/plate.bin"), &bytes[28 + length..]).unwrap();
    document["buffers"][0]["uri"] = "plate.bin".into();
    // Bytes behind an image are copied with it.
    let image = [png(64), vec![0; 5000]].concat();
    for (at, name) in ["skin", "relief"].into_iter().enumerate() {
        std::fs::write(folder.path().join(format!("scene/{name}.png")), &image).unwrap();
        document["images"][at] = serde_json::json!({"uri": format!("{name}.png")});
    }
    std::fs::write(folder.path().join("scene/plate.gltf"), document.to_string()).unwrap();
    let all = |more: &[&str]| {
        let words = ["simplify", "scene/plate.gltf", "-o", "out/plate.gltf", "--force", "--size"];
        run(folder.path(), &[&words[..], more].concat())
    };
    let (n_images, n_others) = (2 * image.len(), 4000);
    let size = (n_images + n_others).to_string();
    assert_eq!(all(&[&size]).code, Some(0));
    let n_bytes = |name: &String| std::fs::metadata(folder.path().join("out").join(name)).unwrap().len() as usize;
    let written = files(&folder.path().join("out"));
    let sum: usize = written.iter().map(n_bytes).sum();
    assert!(written.len() == 4 && sum > n_images && sum <= n_images + n_others, "{written:?}: {sum}");
    let refused = error_line(&all(&["1kB"]));
    assert!(refused.contains(&format!("--size 1000: images alone take {n_images} bytes")), "{refused}");
}

#[test]
fn unreadable_images_stay_with_a_note_and_formats_without_textures_are_refused() {
    let folder = textured_plate();
    std::fs::write(folder.path().join("maps/skin.png"), b"not looked into").unwrap();
    std::fs::create_dir(folder.path().join("out")).unwrap();
    let run = simplify_with_textures(folder.path(), "plate.obj", "out/plate.obj", &[]);
    let note = "an image keeps its size: it is not PNG, JPEG or WebP";
    assert!(String::from_utf8(run.stdout).unwrap().contains(note));
    assert_eq!(std::fs::read(folder.path().join("out/maps/skin.png")).unwrap(), b"not looked into");
    for (output, more, why) in [
        ("a.stl", &["--textures", "64"][..], "--textures: stl cannot store textures: write glb, gltf, obj or ply"),
        ("a.glb", &["--textures", "64", "--bake", "64"], "cannot be used with"),
        ("a.glb", &["--textures", "9000"], "give a whole number from 16 to 8192"),
    ] {
        let refused = crate::common::run(
            folder.path(),
            &[&["simplify", "plate.obj", "-o", output, "--ratio", "0.5"][..], more].concat(),
        );
        assert!(refused.code == Some(2) && refused.stderr.contains(why), "{}", refused.stderr);
    }
}

const KTX2: &[u8] = include_bytes!("../../tests/images/etc1s.ktx2");

#[test]
fn a_ktx2_stays_such_where_it_fits_and_becomes_a_png_where_not() {
    let folder = textured_plate();
    std::fs::write(folder.path().join("maps/skin.png"), KTX2).unwrap();
    simplify_with_textures(folder.path(), "plate.obj", "plate.glb", &[]);
    let (sizes, document) = images(&folder.path().join("plate.glb"));
    assert_eq!((sizes[0], &document["images"][0]["mimeType"]), ([24, 20], &"image/ktx2".into()));
    assert_eq!(document["textures"][0]["extensions"]["KHR_texture_basisu"]["source"], 0);
    assert_eq!(document["extensionsRequired"], serde_json::json!(["KHR_texture_basisu"]));

    let smaller = |output: &str| {
        let words = format!("simplify plate.glb -o {output} --ratio 50% --textures 16 --picture a.png --force");
        let words: Vec<&str> = words.split(' ').collect();
        let run = succeed(folder.path(), &words);
        let said = String::from_utf8(run.stdout).unwrap();
        assert!(!said.contains("left out") && !said.contains("keeps its size"), "{said}");
    };
    smaller("less.glb");
    let (sizes, document) = images(&folder.path().join("less.glb"));
    assert_eq!((sizes[0], &document["images"][0]["mimeType"]), ([16, 13], &"image/png".into()));
    assert_eq!((&document["textures"][0]["source"], document["textures"][0].get("extensions")), (&0.into(), None));
    let lists = ["extensionsUsed", "extensionsRequired"].map(|list| document.get(list).map(ToString::to_string));
    assert!(lists.iter().flatten().all(|list| !list.contains("basisu")), "{lists:?}");

    smaller("less.obj");
    let skin = decode_image(&std::fs::read(folder.path().join("less_0.png")).unwrap()).unwrap();
    let [first, last] = [0, 16 * 13 - 1].map(|at| &skin.rgba[4 * at..][..2]);
    assert!(first.iter().all(|&it| it < 60) && last.iter().all(|&it| it > 190), "{first:?} {last:?}");
    let picture = decode_image(&std::fs::read(folder.path().join("a.png")).unwrap()).unwrap();
    assert!(picture.rgba.as_chunks::<4>().0.iter().any(|&[r, g, ..]| r > 100 && g < r / 2), "no red in the picture");
}

#[test]
fn a_webp_goes_into_a_glb_as_such() {
    let folder = textured_plate();
    let image = decode_image(&png(64)).unwrap();
    std::fs::write(folder.path().join("maps/skin.png"), encode_webp(&image).unwrap()).unwrap();
    simplify_with_textures(folder.path(), "plate.obj", "plate.glb", &[]);
    let (sizes, document) = images(&folder.path().join("plate.glb"));
    assert_eq!((sizes[0], &document["images"][0]["mimeType"]), ([32, 32], &"image/webp".into()));
    assert_eq!(document["textures"][0]["extensions"]["EXT_texture_webp"]["source"], 0);
    assert_eq!(document["extensionsRequired"], serde_json::json!(["EXT_texture_webp"]));
    let words = ["simplify", "plate.glb", "-o", "less.obj", "--ratio", "50%"];
    assert_eq!(run(folder.path(), &words).code, Some(0));
    assert!(files(folder.path()).contains(&"less_0.webp".to_string()));
}
