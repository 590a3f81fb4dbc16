//! Pictures: near faces hide others, backs are red, lines follow edges.

use crate::common::with_changes;
use neural_mesh::linalg::test_values::run_on_threads;
use neural_mesh::mesh::TriMesh;
use neural_mesh::picture::{Image, PictureOptions, encode_png, render};

// Builds two triangles that fill a square of side 2 at height z, facing +z, or -z if `turned`.
fn square(z: f32, turned: bool) -> TriMesh {
    let positions = vec![[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
    let faces = if turned { vec![[2, 1, 0], [3, 2, 0]] } else { vec![[0, 1, 2], [0, 2, 3]] };
    TriMesh::new(positions, faces).unwrap()
}

fn small(edges: bool) -> PictureOptions {
    with_changes(PictureOptions::default(), |options| {
        options.height = 128;
        options.edges = edges;
    })
}

fn middle(image: &Image) -> [u8; 4] {
    let at = ((image.height / 2 + 12) * image.width + image.width / 2) * 4;
    image.rgba[at..at + 4].try_into().unwrap()
}

fn is_red([r, g, b, _]: [u8; 4]) -> bool {
    r > g.saturating_add(40) && r > b.saturating_add(40)
}

#[test]
fn fronts_are_blue_and_backs_red() {
    let [front, back] = [false, true].map(|turned| middle(&render(&[&square(0.0, turned)], &small(false))));
    assert!(!is_red(front), "{front:?}");
    assert!(is_red(back), "{back:?}");
}

#[test]
fn nearer_faces_hide_farther_ones_in_any_order() {
    let [near, far] = [square(0.1, false), square(-0.1, true)];
    let joined = |first: &TriMesh, second: &TriMesh| {
        let positions = [first.positions(), second.positions()].concat();
        let shifted: Vec<[u32; 3]> = second.faces().iter().map(|face| face.map(|v| v + 4)).collect();
        TriMesh::new(positions, [first.faces(), &shifted].concat()).unwrap()
    };
    for mesh in [joined(&near, &far), joined(&far, &near)] {
        assert!(!is_red(middle(&render(&[&mesh], &small(false)))));
    }
}

#[test]
fn edges_darken_the_picture() {
    let brightness = |edges| -> u64 {
        render(&[&square(0.0, false)], &small(edges)).rgba.iter().map(|&value| u64::from(value)).sum()
    };
    assert!(brightness(true) < brightness(false));
}

#[test]
fn panels_share_one_view() {
    let [whole, half] =
        [square(0.0, false), TriMesh::new(square(0.0, false).positions().to_vec(), vec![[0, 1, 2]]).unwrap()];
    let image = render(&[&whole, &half, &whole], &small(true));
    let width = image.width / 3;
    let panel = |number: usize| -> Vec<u8> {
        let rows = image.rgba.chunks(image.width * 4);
        rows.flat_map(|row| row[number * width * 4..(number + 1) * width * 4].to_vec()).collect()
    };
    assert_eq!(panel(0), panel(2));
    assert_ne!(panel(0), panel(1));
}

#[test]
fn pixels_do_not_depend_on_threads() {
    let mesh = square(0.0, false);
    let with = |n| run_on_threads(n, || render(&[&mesh], &small(true)));
    assert_eq!(with(1), with(3));
}

#[test]
fn odd_meshes_and_requests_give_pictures() {
    let point = TriMesh::new(vec![[3.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    let line = TriMesh::new(vec![[0.0; 3], [1.0; 3], [2.0; 3]], vec![[0, 1, 2]]).unwrap();
    let huge = TriMesh::new(vec![[-3e38; 3], [3e38, -3e38, 0.0], [0.0, 3e38, 3e38]], vec![[0, 1, 2]]).unwrap();
    let tiny = TriMesh::new(vec![[0.0; 3], [1e-38, 0.0, 0.0], [0.0, 1e-38, 0.0]], vec![[0, 1, 2]]).unwrap();
    for mesh in [TriMesh::default(), point, line, huge, tiny] {
        let image = render(&[&mesh], &small(true));
        assert_eq!(image.rgba.len(), image.width * image.height * 4);
        assert!(!encode_png(&image).is_empty());
    }
    assert_eq!(render(&[], &small(true)).rgba, Vec::<u8>::new());
}

#[test]
fn flat_meshes_are_not_seen_on_edge() {
    for axes in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        let turned = square(0.0, false).positions().iter().map(|p| axes.map(|axis| p[axis])).collect();
        let image = render(&[&TriMesh::new(turned, vec![[0, 1, 2], [0, 2, 3]]).unwrap()], &small(false));
        let sky = image.rgba[..4].to_vec();
        let covered = image.rgba.chunks(4).filter(|pixel| pixel[0].abs_diff(sky[0]) > 30).count();
        assert!(covered * 4 > image.width * image.height, "{axes:?}: {covered}");
    }
}

#[test]
fn captions_are_written_below() {
    let captions = vec!["before\n5,856 faces".to_string(), String::new()];
    let mesh = square(0.0, false);
    let image = render(&[&mesh, &mesh], &with_changes(small(true), |options| options.captions = captions));
    assert!(image.height > 128);
    let below = &image.rgba[128 * image.width * 4..];
    assert!(below.chunks(4).any(|pixel| pixel[0] < 90));
}

#[test]
fn png_holds_the_same_pixels() {
    let image = render(&[&square(0.0, false)], &small(true));
    let file = encode_png(&image);
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    assert_eq!(pixels, image.rgba);
    assert_eq!(encode_png(&Image { width: 5, height: 5, rgba: vec![0; 3] }), Vec::<u8>::new());
}
