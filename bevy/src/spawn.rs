//! Entities that show levels of detail.

use bevy_asset::Assets;
use bevy_camera::visibility::Visibility;
use bevy_ecs::bundle::Bundle;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::system::EntityCommands;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_transform::components::Transform;

use crate::Level;

/// Spawns a child for each level, which Bevy shows or hides by its `VisibilityRange`.
///
/// `bundle` goes to each child: a material, usually. The parent gets a `Transform` and a `Visibility` if it has none; it
/// must not show a mesh itself. Cross-fades need a material that dithers, as Bevy's standard material does.
///
/// ```
/// use bevy_asset::Assets;
/// use bevy_ecs::prelude::*;
/// use bevy_mesh::{Indices, Mesh, PrimitiveTopology};
/// use neural_mesh_bevy::{LevelOptions, LevelSizes, make_levels, spawn_levels};
/// # let (positions, faces) = neural_mesh::mesh::shapes::icosphere(3).into_parts();
/// # let sphere = Mesh::new(PrimitiveTopology::TriangleList, Default::default())
/// #     .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
/// #     .with_inserted_indices(Indices::U32(faces.into_flattened()));
/// let levels = make_levels(&sphere, &LevelSizes::Ratios(vec![0.5, 0.1]), &LevelOptions::default())?;
///
/// fn show(commands: &mut Commands, meshes: &mut Assets<Mesh>, levels: Vec<neural_mesh_bevy::Level>) {
///     // With `MeshMaterial3d(material)` in place of the name.
///     spawn_levels(&mut commands.spawn_empty(), levels, meshes, Name::new("sphere"));
/// }
/// # let (mut world, mut meshes) = (World::new(), Assets::<Mesh>::default());
/// # show(&mut world.commands(), &mut meshes, levels);
/// # world.flush();
/// # assert_eq!(world.query::<&bevy_mesh::Mesh3d>().iter(&world).count(), 3);
/// # Ok::<(), neural_mesh_bevy::MeshError>(())
/// ```
pub fn spawn_levels(
    parent: &mut EntityCommands,
    levels: impl IntoIterator<Item = Level>,
    meshes: &mut Assets<Mesh>,
    bundle: impl Bundle + Clone,
) {
    parent.insert_if_new((Transform::default(), Visibility::default()));
    let parent_entity = parent.id();
    for level in levels {
        let shown = (Mesh3d(meshes.add(level.mesh)), level.range, Visibility::default(), ChildOf(parent_entity));
        parent.commands_mut().spawn((shown, bundle.clone()));
    }
}
