//! Processor of glTF files.

use std::marker::PhantomData;
use std::ops::ControlFlow;

use bevy_app::{App, Plugin};
use bevy_asset::io::Writer;
use bevy_asset::processor::{Process, ProcessContext, ProcessError};
use bevy_asset::{AssetApp, AssetLoader, AsyncWriteExt};
use bevy_reflect::TypePath;
use neural_mesh::io::{self, Format};
use neural_mesh::job::{Bound, Document, Goal, Job, JobError, run};
use neural_mesh::simplify::Options;
use serde::{Deserialize, Serialize};

use super::gltf_source::{GltfSource, GltfSourceLoader};
use super::settings::SimplifySettings;

/// Processor that writes a glTF file as a smaller one, with its scenes, names, materials, skins and animations.
///
/// `L` is the loader of the result: Bevy's `GltfLoader`. The result is a GLB; images in files of their own stay there, and
/// the scene shares the size among its meshes.
#[derive(TypePath)]
pub struct GltfSimplifier<L: AssetLoader> {
    marker: PhantomData<fn() -> L>,
}

impl<L: AssetLoader> Default for GltfSimplifier<L> {
    fn default() -> Self {
        Self { marker: PhantomData }
    }
}

/// Settings of [`GltfSimplifier`] in a `.meta` file; `S` are those of the loader.
#[derive(Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GltfSettings<S: Default> {
    /// Settings of the simplification.
    pub simplify: SimplifySettings,
    /// Settings with which the result is loaded.
    pub loader: S,
}

/// Plugin that registers [`GltfSimplifier`], which `.meta` files then name; add it after `AssetPlugin`.
///
/// ```
/// # use bevy_app::{App, TaskPoolPlugin};
/// # use bevy_asset::{AssetLoader, AssetMode, AssetPlugin};
/// use neural_mesh_bevy::GltfSimplifierPlugin;
///
/// fn add_processor<GltfLoader: AssetLoader>(app: &mut App) {
///     app.add_plugins(GltfSimplifierPlugin::<GltfLoader>::default());
/// }
/// ```
pub struct GltfSimplifierPlugin<L: AssetLoader> {
    marker: PhantomData<fn() -> L>,
}

impl<L: AssetLoader> Default for GltfSimplifierPlugin<L> {
    fn default() -> Self {
        Self { marker: PhantomData }
    }
}

impl<L: AssetLoader> Plugin for GltfSimplifierPlugin<L> {
    fn build(&self, app: &mut App) {
        app.init_asset::<GltfSource>();
        app.register_asset_loader(GltfSourceLoader);
        app.register_asset_processor(GltfSimplifier::<L>::default());
    }
}

impl<L: AssetLoader> Process for GltfSimplifier<L> {
    type Settings = GltfSettings<L::Settings>;
    type OutputLoader = L;

    async fn process(
        &self,
        context: &mut ProcessContext<'_>,
        settings: &Self::Settings,
        writer: &mut Writer,
    ) -> Result<L::Settings, ProcessError> {
        let loader_settings = copy_settings(&settings.loader)?;
        let loaded = context.load_source_asset::<GltfSourceLoader>(&()).await?;
        let source = loaded.downcast::<GltfSource>().map_err(|_| ProcessError::WrongMetaType)?.take();
        let bytes = simplify_asset(source.asset, &settings.simplify)
            .map_err(|error| ProcessError::AssetTransformError(Box::new(error)))?;
        writer.write_all(&bytes).await.map_err(|error| ProcessError::AssetSaveError(error.into()))?;
        Ok(loader_settings)
    }
}

/// Returns the bytes of a smaller GLB.
fn simplify_asset(asset: io::Asset, settings: &SimplifySettings) -> Result<Vec<u8>, JobError> {
    let mut job = Job::new(Options::with_closed(settings.size, settings.options.clone()), Format::Glb);
    job.arguments.no_check = true;
    if let Some(error) = settings.error {
        job.goal = Goal::Error(Bound::Absolute(error));
    }
    job.names.files = vec!["scene.glb".into()];
    let document = Document::from_asset(asset, &job)?;
    let mut outcome = run(&document, &job, &mut |_| ControlFlow::Continue(()))?;
    let files = outcome.write(&document, &job)?;
    files.into_iter().next().map(|file| file.bytes).ok_or_else(|| JobError::Output("no file was made".into()))
}

/// Copies the loader's settings, which need not be `Clone`, by way of a text as in a `.meta` file.
fn copy_settings<S: Serialize + for<'a> Deserialize<'a>>(settings: &S) -> Result<S, ProcessError> {
    let failed = |error: Box<dyn std::error::Error + Send + Sync>| ProcessError::AssetTransformError(error);
    let text = ron::to_string(settings).map_err(|error| failed(error.into()))?;
    ron::from_str(&text).map_err(|error| failed(error.into()))
}
