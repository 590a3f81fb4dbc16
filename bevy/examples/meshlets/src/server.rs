//! Bevy's asset server over files in memory, and its saver.

use std::path::Path;
use std::time::{Duration, Instant};

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::io::memory::{Dir, MemoryAssetReader};
use bevy_asset::io::{AssetSourceBuilder, AssetSourceId};
use bevy_asset::saver::{AssetSaver, SavedAsset};
use bevy_asset::{AssetApp, AssetPath, AssetPlugin, AssetServer, Assets, Handle, LoadState};
use bevy_pbr::experimental::meshlet::{MeshletMesh, MeshletMeshLoader, MeshletMeshSaver};
use bevy_tasks::block_on;

/// Longest time for one file.
const LONGEST: Duration = Duration::from_secs(60);

/// An app without window and renderer that loads meshlets.
pub struct Server {
    app: App,
    folder: Dir,
    n_files: usize,
}

impl Server {
    pub fn new() -> Self {
        let folder = Dir::default();
        let root = folder.clone();
        let source = AssetSourceBuilder::new(move || Box::new(MemoryAssetReader { root: root.clone() }));
        let mut app = App::new();
        app.register_asset_source(AssetSourceId::Default, source)
            .add_plugins((TaskPoolPlugin::default(), AssetPlugin::default()))
            .init_asset::<MeshletMesh>()
            .register_asset_loader(MeshletMeshLoader);
        Self { app, folder, n_files: 0 }
    }

    /// Loads the bytes of a file.
    ///
    /// # Errors
    /// Message of Bevy's asset server.
    pub fn load(&mut self, bytes: &[u8]) -> Result<MeshletMesh, String> {
        // The server keeps what it has loaded, so each file has a name of its own.
        let name = format!("{}.meshlet_mesh", self.n_files);
        self.n_files += 1;
        self.folder.insert_asset(Path::new(&name), bytes.to_vec());
        let handle: Handle<MeshletMesh> = self.app.world().resource::<AssetServer>().load(name);
        let start = Instant::now();
        loop {
            self.app.update();
            match self.app.world().resource::<AssetServer>().load_state(&handle) {
                LoadState::Loaded => break,
                // Bevy adds a backtrace.
                LoadState::Failed(error) => return Err(error.to_string().lines().take(1).collect()),
                _ if start.elapsed() > LONGEST => return Err("Bevy does not finish loading".to_string()),
                _ => std::thread::sleep(Duration::from_millis(1)),
            }
        }
        let meshes = self.app.world().resource::<Assets<MeshletMesh>>();
        meshes.get(&handle).cloned().ok_or_else(|| "Bevy has no data for the loaded file".to_string())
    }
}

/// Returns the bytes that Bevy's saver writes.
///
/// # Errors
/// Message of the saver.
pub fn save(mesh: &MeshletMesh) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let saved =
        MeshletMeshSaver.save(&mut bytes, SavedAsset::from_asset(mesh), &(), AssetPath::parse("saved.meshlet_mesh"));
    block_on(saved).map_err(|error| error.to_string())?;
    Ok(bytes)
}
