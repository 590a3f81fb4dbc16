//! Records of runs: the result as a differentiable function of the input vertices.

use std::ops::ControlFlow;

use neural_mesh::mesh::{TriMesh, shapes};
use neural_mesh::simplify::{ClosedOptions, Options, Purpose, Record, Simplified, Size, simplify, simplify_recorded};

fn simplify_and_record(mesh: &TriMesh, options: &Options) -> (Simplified, Record) {
    simplify_recorded(mesh, options, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn directions(n: usize, seed: usize) -> Vec<[f32; 3]> {
    let number = |i: usize| ((i * 7919 + seed * 104_729) % 2003) as f32 / 1001.5 - 1.0;
    (0..n).map(|i| [0, 1, 2].map(|k| number(3 * i + k))).collect()
}

fn dot(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

fn move_points(points: &[[f32; 3]], along: &[[f32; 3]], step: f32) -> Vec<[f32; 3]> {
    points.iter().zip(along).map(|(p, d)| [0, 1, 2].map(|k| p[k] + step * d[k])).collect()
}

// Expects that recording changes nothing, that the record reproduces the result, and that its gradients are right.
fn check(mesh: &TriMesh, options: &Options) -> Record {
    let (result, record) = simplify_and_record(mesh, options);
    assert_eq!(result, simplify(mesh, options, &mut |_| ControlFlow::Continue(())).unwrap());
    let output = record.positions(mesh.positions());
    assert!(output.iter().flatten().zip(result.mesh.positions().iter().flatten()).all(|(p, q)| (p - q).abs() < 1e-6));
    let (along, g) = (directions(mesh.positions().len(), 1), directions(output.len(), 2));
    let loss = |step: f32| dot(&record.positions(&move_points(mesh.positions(), &along, step)), &g);
    let gradient = record.backward(mesh.positions(), &g);
    let (numeric, analytic) = ((loss(5e-5) - loss(-5e-5)) / 1e-4, dot(&gradient, &along));
    let scale = dot(&gradient, &gradient).sqrt();
    assert!((numeric - analytic).abs() < 0.02 * scale, "{numeric} {analytic} {scale}");
    record
}

#[test]
fn results_are_functions_of_the_input() {
    for target in [Size::Ratio(0.05), Size::Ratio(0.3), Size::Ratio(0.7), Size::Faces(300)] {
        check(&shapes::wavy_sphere(3, 5.0), &Options::new(target));
        check(&shapes::torus(32, 14, 1.0, 0.3), &Options::new(target));
    }
    check(&shapes::icosphere(2), &Options::new(Size::Ratio(1.0)));
    check(
        &shapes::wavy_sphere(3, 5.0),
        &Options::with_closed(Size::Ratio(0.2), ClosedOptions { purpose: Purpose::Poses, ..ClosedOptions::default() }),
    );
}

#[test]
fn moving_and_scaling_the_input_moves_and_scales_the_result() {
    for mesh in [shapes::wavy_sphere(3, 5.0), shapes::open_cylinder(24, 12), shapes::bolt(24)] {
        let (result, record) = simplify_and_record(&mesh, &Options::new(Size::Ratio(0.2)));
        let g = directions(result.mesh.positions().len(), 3);
        let gradient = record.backward(mesh.positions(), &g);
        for axis in 0..3 {
            let unit = |n: usize| vec![std::array::from_fn(|k| f32::from(u8::from(k == axis))); n];
            let (before, after) = (dot(&gradient, &unit(gradient.len())), dot(&g, &unit(g.len())));
            assert!((before - after).abs() < 1e-3 * g.len() as f64, "{before} {after}");
        }
        let (before, after) = (dot(&gradient, mesh.positions()), dot(&g, result.mesh.positions()));
        assert!((before - after).abs() < 1e-3 * g.len() as f64, "{before} {after}");
    }
}

#[test]
fn vertices_that_took_no_part_have_no_gradient() {
    let boxes = shapes::many_boxes(20);
    let unused = vec![[9.0; 3]];
    let faces = boxes.faces().iter().map(|face| face.map(|v| v + 1)).collect();
    let mesh = TriMesh::new([&unused, boxes.positions()].concat(), faces).unwrap();
    let (result, record) = simplify_and_record(&mesh, &Options::new(Size::Vertices(40)));
    assert!(result.report.components_pruned > 0);
    let outputs = record.output_vertices();
    let gradient = record.backward(mesh.positions(), &directions(result.mesh.positions().len(), 4));
    assert_eq!(outputs[0], None);
    assert!(outputs.iter().zip(&gradient).all(|(output, g)| output.is_some() || *g == [0.0; 3]));
    let n_gone = outputs.iter().filter(|output| output.is_none()).count();
    assert!(n_gone > 1 && n_gone < mesh.positions().len());
    assert!((0..result.mesh.positions().len() as u32).all(|x| outputs.contains(&Some(x))));
}
