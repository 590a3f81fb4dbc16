//! The asset processor at work on files in a folder.

use std::path::Path;
use std::time::{Duration, Instant};

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::io::Reader;
use bevy_asset::processor::{AssetProcessor, FileTransactionLogFactory};
use bevy_asset::{
    Asset, AssetApp, AssetLoader, AssetMode, AssetPlugin, AssetServer, Assets, Handle, LoadContext, LoadState,
};
use bevy_reflect::TypePath;
use neural_mesh::io::{self, Format};
use neural_mesh::mesh::{Frame, TriMesh, shapes};
use neural_mesh_bevy::GltfSimplifierPlugin;

/// Bytes of a processed file, in place of what Bevy's loader makes of them.
#[derive(Asset, TypePath)]
struct Bytes {
    bytes: Vec<u8>,
    label: String,
}

#[derive(Default, TypePath)]
struct BytesLoader;

#[derive(Default, serde::Serialize, serde::Deserialize)]
#[serde(default)]
struct BytesSettings {
    label: String,
}

impl AssetLoader for BytesLoader {
    type Asset = Bytes;
    type Settings = BytesSettings;
    type Error = std::io::Error;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &BytesSettings,
        _context: &mut LoadContext<'_>,
    ) -> Result<Bytes, std::io::Error> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(Bytes { bytes, label: settings.label.clone() })
    }

    fn extensions(&self) -> &[&str] {
        &["glb", "gltf"]
    }
}

/// Processes a folder of assets and loads one of them.
///
/// # Errors
/// Message of the asset server.
fn process(folder: &Path, name: &'static str) -> Result<(TriMesh, String), String> {
    let path = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        AssetPlugin {
            mode: AssetMode::Processed,
            file_path: path("assets"),
            processed_file_path: path("imported"),
            use_asset_processor_override: Some(true),
            watch_for_changes_override: Some(false),
            ..AssetPlugin::default()
        },
    ));
    // The default log is one file in the working folder, which tests that run side by side would share.
    let log = FileTransactionLogFactory { file_path: folder.join("imported/log") };
    app.world().resource::<AssetProcessor>().data().set_log_factory(Box::new(log)).unwrap();
    app.init_asset::<Bytes>().register_asset_loader(BytesLoader);
    app.add_plugins(GltfSimplifierPlugin::<BytesLoader>::default());
    let handle: Handle<Bytes> = app.world().resource::<AssetServer>().load(name);
    let start = Instant::now();
    loop {
        app.update();
        match app.world().resource::<AssetServer>().load_state(&handle) {
            LoadState::Loaded => break,
            LoadState::Failed(error) => return Err(error.to_string()),
            _ => assert!(start.elapsed() < Duration::from_secs(60), "the processor does not finish"),
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let loaded = app.world().resource::<Assets<Bytes>>().get(&handle).unwrap();
    let read = io::Asset::from_stream(&loaded.bytes).unwrap();
    let mesh = &read.parts()[0].mesh;
    let positions = mesh.positions.iter().map(|position| position.map(|x| x as f32)).collect();
    Ok((TriMesh::new(positions, mesh.faces.clone()).unwrap(), loaded.label.clone()))
}

/// Returns a folder with an asset `ball.glb` and its `.meta` file.
fn folder_with(settings: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("assets")).unwrap();
    let bytes = io::write(&shapes::icosphere(3), &Frame::default(), Format::Glb).unwrap();
    std::fs::write(folder.path().join("assets/ball.glb"), bytes).unwrap();
    write_meta(folder.path(), "ball.glb", settings);
    folder
}

fn write_meta(folder: &Path, name: &str, settings: &str) {
    let text = format!(
        "(meta_format_version: \"1.0\", asset: Process(processor: \"GltfSimplifier<BytesLoader>\", settings: {settings}))"
    );
    std::fs::write(folder.join(format!("assets/{name}.meta")), text).unwrap();
}

#[test]
fn a_meta_file_makes_a_glb_smaller() {
    let folder = folder_with("(simplify: (size: Faces(200)), loader: (label: \"small\"))");
    let (mesh, label) = process(folder.path(), "ball.glb").unwrap();
    assert_eq!((mesh.faces().len(), label.as_str()), (200, "small"));
    assert!(neural_mesh::mesh::topology(&mesh).is_closed_manifold());
}

#[test]
fn an_error_bounds_the_size() {
    let folder = folder_with("(simplify: (error: Some(0.05), options: (effort: fast)))");
    let (mesh, _) = process(folder.path(), "ball.glb").unwrap();
    assert!((20..600).contains(&mesh.faces().len()), "{} faces", mesh.faces().len());
    let distance = neural_mesh::metrics::largest_distance(&shapes::icosphere(3), &mesh).unwrap();
    assert!(distance <= 0.05, "{distance}");
}

#[test]
fn the_default_leaves_the_mesh_as_it_is() {
    let folder = folder_with("()");
    let (mesh, _) = process(folder.path(), "ball.glb").unwrap();
    assert_eq!(mesh.faces().len(), 1280);
}

#[test]
fn a_gltf_finds_its_buffer() {
    let folder = folder_with("()");
    let sphere = shapes::icosphere(3);
    let positions = sphere.positions().as_flattened().iter().flat_map(|x| x.to_le_bytes());
    let indices = sphere.faces().as_flattened().iter().flat_map(|v| v.to_le_bytes());
    let buffer: Vec<u8> = positions.chain(indices).collect();
    let (n, n_corners) = (sphere.positions().len(), 3 * sphere.faces().len());
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
        "buffers": [{{"byteLength": {length}, "uri": "data/ball%20mesh.bin"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": {split}}}, {{"buffer": 0, "byteOffset": {split}, "byteLength": {rest}}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": {n}, "min": [-1, -1, -1], "max": [1, 1, 1]}},
                      {{"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": {n_corners}}}]}}"#,
        length = buffer.len(),
        split = 12 * n,
        rest = 4 * n_corners,
    );
    std::fs::create_dir(folder.path().join("assets/data")).unwrap();
    std::fs::write(folder.path().join("assets/data/ball mesh.bin"), buffer).unwrap();
    std::fs::write(folder.path().join("assets/ball.gltf"), text).unwrap();
    write_meta(folder.path(), "ball.gltf", "(simplify: (size: Ratio(0.1)))");
    let (mesh, _) = process(folder.path(), "ball.gltf").unwrap();
    assert_eq!(mesh.positions().len(), 64);
}

#[test]
fn a_file_that_is_no_gltf_fails_to_load() {
    let folder = folder_with("()");
    std::fs::write(folder.path().join("assets/ball.glb"), b"glTF and nothing more").unwrap();
    assert!(process(folder.path(), "ball.glb").is_err());
}
