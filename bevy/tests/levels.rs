//! Levels of detail and the entities that show them.

use bevy_asset::Assets;
use bevy_camera::visibility::{Visibility, VisibilityRange};
use bevy_ecs::prelude::*;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_transform::components::Transform;
use neural_mesh_bevy::{
    Level, LevelOptions, LevelSizes, MeshError, Outcome, Screen, Size, make_levels, simplify_mesh, spawn_levels,
};

use crate::helpers::{is_closed, long, n_points, torus};

/// Farthest point of the torus from its origin.
const RADIUS: f32 = 1.4;

fn check_ranges(levels: &[Level], options: &LevelOptions) {
    assert!(levels[0].error == 0.0 && levels[0].range.start_margin == (0.0..0.0));
    for pair in levels.windows(2) {
        // No gap, no overlap but for the fade, and levels that begin farther and farther away.
        assert_eq!(pair[0].range.end_margin, pair[1].range.start_margin);
        assert!(pair[0].range.start_margin.end <= pair[0].range.end_margin.start);
        assert!(pair[0].range.start_margin.start < pair[1].range.start_margin.start);
    }
    for level in &levels[1..] {
        assert!(is_closed(&level.mesh));
        // The nearest point of the mesh is nearer than its origin by the radius.
        let nearest = level.range.start_margin.start - RADIUS * options.scale;
        let screen = options.screen;
        let pixels =
            level.error as f32 * options.scale * screen.height / (2.0 * nearest * (0.5 * screen.field_of_view).tan());
        assert!(pixels <= screen.error * 1.001, "{pixels} pixels");
    }
}

#[test]
fn levels_by_ratio_grow_in_error_and_distance() {
    let mesh = torus(long);
    let sizes = LevelSizes::Ratios(vec![0.5, 0.2, 0.05]);
    let options = LevelOptions { scale: 2.0, fade: 0.2, ..LevelOptions::default() };
    let levels = make_levels(&mesh, &sizes, &options).unwrap();
    let counts: Vec<usize> = levels.iter().map(|level| n_points(&level.mesh)).collect();
    assert_eq!(counts, [2048, 1024, 409, 102]);
    assert!(levels.windows(2).all(|pair| pair[0].error < pair[1].error));
    check_ranges(&levels, &options);
    // The first level is what it would be alone.
    let alone = simplify_mesh(&mesh, Size::Ratio(0.5), &options.simplify).unwrap();
    assert_eq!((&levels[0].mesh, &levels[1].mesh), (&mesh, &alone.mesh));
}

#[test]
fn levels_by_screen_error_begin_where_they_should() {
    let mesh = torus(long);
    let mut screen = Screen::default();
    screen.error = 2.0;
    let distances = [10.0, 30.0, 100.0];
    let errors = distances.map(|distance| screen.error_at(distance - RADIUS)).to_vec();
    let options = LevelOptions { screen, end: Some(500.0), ..LevelOptions::default() };
    let levels = make_levels(&mesh, &LevelSizes::Errors(errors.clone()), &options).unwrap();
    check_ranges(&levels, &options);
    for ((level, error), distance) in levels[1..].iter().zip(errors).zip(distances) {
        assert!(level.error <= error && level.report.as_ref().unwrap().outcome == Outcome::Reached);
        let start = level.range.start_margin.start;
        assert!(start <= distance * 1.001 && start > 0.3 * distance, "{start} for {distance}");
    }
    assert!(levels.windows(2).all(|pair| n_points(&pair[0].mesh) > n_points(&pair[1].mesh)));
    let last = &levels[3].range;
    assert_eq!((last.is_visible_at_all(499.0), last.is_visible_at_all(600.0)), (true, false));
}

#[test]
fn sizes_in_the_wrong_order_are_refused() {
    let mesh = torus(long);
    let make = |sizes| make_levels(&mesh, &sizes, &LevelOptions::default()).err();
    assert!(matches!(make(LevelSizes::Errors(vec![0.1, 0.01])), Some(MeshError::LevelErrors)));
    assert!(matches!(make(LevelSizes::Errors(vec![f64::NAN])), Some(MeshError::LevelErrors)));
    assert!(matches!(make(LevelSizes::Ratios(vec![0.1, 0.5])), Some(MeshError::Simplify(_))));
}

#[test]
fn children_show_the_levels() {
    #[derive(Component, Clone, PartialEq, Debug)]
    struct Material(u32);

    let levels = make_levels(&torus(long), &LevelSizes::Ratios(vec![0.3, 0.1]), &LevelOptions::default()).unwrap();
    let ranges: Vec<VisibilityRange> = levels.iter().map(|level| level.range.clone()).collect();
    let (mut world, mut meshes) = (World::new(), Assets::<Mesh>::default());
    let parent = world.spawn(Transform::from_xyz(1.0, 2.0, 3.0)).id();
    spawn_levels(&mut world.commands().entity(parent), levels, &mut meshes, Material(5));
    world.flush();
    assert_eq!(world.get::<Transform>(parent), Some(&Transform::from_xyz(1.0, 2.0, 3.0)));
    assert!(world.get::<Visibility>(parent).is_some());
    let children: Vec<Entity> = world.get::<Children>(parent).unwrap().iter().collect();
    assert_eq!(children.len(), 3);
    for (child, range) in children.into_iter().zip(ranges) {
        assert!(world.get::<VisibilityRange>(child) == Some(&range));
        assert_eq!(world.get::<Transform>(child), Some(&Transform::IDENTITY));
        assert_eq!(world.get::<Material>(child), Some(&Material(5)));
        assert!(meshes.get(&world.get::<Mesh3d>(child).unwrap().0).is_some());
    }
}
