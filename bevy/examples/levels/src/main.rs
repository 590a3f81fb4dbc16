//! Shows rows of a shape with levels of detail in different colours; W and S move the camera, space toggles the colours.

use bevy::light::light_consts::lux::FULL_DAYLIGHT;
use bevy::prelude::*;
use neural_mesh::mesh::shapes;
use neural_mesh_bevy::{Level, LevelOptions, LevelSizes, make_levels, spawn_levels};

/// Number of shapes along each side of the field.
const SIDE: i32 = 12;
/// Distance of neighbouring shapes.
const STEP: f32 = 6.0;
/// Colours of the levels, the original first.
const COLOURS: [Color; 4] =
    [Color::srgb(0.9, 0.9, 0.9), Color::srgb(0.9, 0.7, 0.2), Color::srgb(0.3, 0.7, 0.4), Color::srgb(0.3, 0.5, 0.9)];

/// Material of a level, and whether it shows its colour.
#[derive(Resource)]
struct LevelMaterials {
    handles: Vec<Handle<StandardMaterial>>,
    is_coloured: bool,
}

fn main() -> AppExit {
    App::new()
        .add_plugins(DefaultPlugins)
        .add_systems(Startup, set_up)
        .add_systems(Update, (move_camera, toggle_colours))
        .run()
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) -> Result {
    // A game would make levels when it builds its assets, or in a task.
    let levels = make_levels(&shape(), &LevelSizes::Ratios(vec![0.25, 0.06, 0.015]), &LevelOptions::default())?;
    for level in &levels {
        let (n, from, range) = (level.mesh.count_vertices(), level.range.start_margin.start, level.error);
        info!("{n} vertices from a distance of {from:.1} on, error {range:.4}");
    }
    let handles: Vec<_> = COLOURS.iter().map(|&colour| materials.add(colour)).collect();
    // The handles of a level's mesh are shared, so that Bevy draws its instances together.
    let shared: Vec<(Handle<Mesh>, &Level)> =
        levels.iter().map(|level| (meshes.add(level.mesh.clone()), level)).collect();
    for i in 0..SIDE * SIDE {
        let place = Vec3::new((i % SIDE - SIDE / 2) as f32, 0.0, -(i / SIDE) as f32) * STEP;
        if i == 0 {
            // One shape by the helper, the others by hand, as their meshes are known already.
            let mut parent = commands.spawn(Transform::from_translation(place));
            for (level, handle) in levels.clone().into_iter().zip(&handles) {
                spawn_levels(&mut parent, [level], &mut meshes, MeshMaterial3d(handle.clone()));
            }
            continue;
        }
        commands.spawn((Transform::from_translation(place), Visibility::default())).with_children(|parent| {
            for ((mesh, level), material) in shared.iter().zip(&handles) {
                parent.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), level.range.clone()));
            }
        });
    }
    commands.insert_resource(LevelMaterials { handles, is_coloured: true });
    let sun = DirectionalLight { illuminance: FULL_DAYLIGHT, ..default() };
    commands.spawn((sun, Transform::from_xyz(1.0, 2.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 2.5, 5.0).looking_to(Vec3::NEG_Z, Vec3::Y)));
    Ok(())
}

/// Returns a wavy sphere of 41 thousand vertices.
fn shape() -> Mesh {
    let (positions, faces) = shapes::wavy_sphere(6, 4.0).into_parts();
    let indices = bevy::mesh::Indices::U32(faces.into_flattened());
    Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(indices)
        .with_computed_smooth_normals()
}

fn move_camera(keys: Res<ButtonInput<KeyCode>>, time: Res<Time>, mut cameras: Query<&mut Transform, With<Camera3d>>) {
    let speed = f32::from(keys.pressed(KeyCode::KeyS)) - f32::from(keys.pressed(KeyCode::KeyW));
    for mut camera in &mut cameras {
        camera.translation.z += 15.0 * speed * time.delta_secs();
    }
}

fn toggle_colours(
    keys: Res<ButtonInput<KeyCode>>,
    mut shown: ResMut<LevelMaterials>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    if !keys.just_pressed(KeyCode::Space) {
        return;
    }
    shown.is_coloured = !shown.is_coloured;
    for (handle, colour) in shown.handles.iter().zip(COLOURS) {
        if let Some(mut material) = materials.get_mut(handle) {
            material.base_color = if shown.is_coloured { colour } else { COLOURS[0] };
        }
    }
}
