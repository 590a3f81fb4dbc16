//! Results optimised for the spectrum keep it better.

use std::ops::ControlFlow;

use crate::common::{read_welded, test_mesh_path};
use neural_mesh::metrics::CompareOptions;
use neural_mesh::simplify::{ClosedOptions, Options, Purpose, Target, simplify};
use neural_mesh_bench::along_surface::{IntrinsicOptions, Judge};

#[test]
fn the_spectrum_stays() {
    let mesh = read_welded(&test_mesh_path("spot.ply"));
    let along = IntrinsicOptions { eigenpairs: 60, ..IntrinsicOptions::NONE };
    let judge = Judge::new(&mesh, &CompareOptions::default(), &along);
    let [shape, spectrum] = [Purpose::Shape, Purpose::Spectrum].map(|purpose| {
        let options = ClosedOptions { purpose, ..ClosedOptions::default() };
        let options = Options::with_closed(Target::Vertices(290), options);
        let result = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap().mesh;
        let figures = judge.figures(&result, 290);
        figures.iter().find(|figure| figure.name == "laplacian_functions").unwrap().value.unwrap()
    });
    assert!(spectrum < 0.9 * shape, "{spectrum} {shape}");
}
