//! The objective "shape", by `loss::log_errors`.

use super::{ErrorShares, JudgedErrors, Objective};
use crate::loss::{error_shares, error_sums, log_errors, point_errors};
use crate::mesh::TriMesh;
use crate::simplify::WeightedResult;

/// Objective of distance, normals and largest distance, the default of the closed assembly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShapeObjective;

impl Objective for ShapeObjective {
    fn judge(&self, original: &TriMesh, results: [&WeightedResult; 2]) -> Result<JudgedErrors, String> {
        let corners_of_original = corners(original);
        let errors = results.map(|result| point_errors(&corners_of_original, &corners(&result.mesh)));
        let sums = error_sums([&errors[0], &errors[1]]);
        let [first, second] = errors.map(|errors| error_shares(&errors, &sums));
        Ok(JudgedErrors {
            terms: ["distance", "normals", "peak"].into_iter().zip(log_errors(&sums)).collect(),
            error_shares: ErrorShares::Faces(first.iter().zip(second).map(|(a, b)| a - b).collect()),
        })
    }
}

fn corners(mesh: &TriMesh) -> Vec<[[f32; 3]; 3]> {
    mesh.faces().iter().map(|face| face.map(|v| mesh.positions()[v as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_result_lifted_over_one_half_is_blamed_there() {
        let original = shapes::grid(4, 4);
        let lifted = |by: f32| {
            let lift = |p: &[f32; 3]| [p[0], p[1], if p[0] > 2.0 { by } else { 0.01 }];
            let mesh =
                TriMesh::new(original.positions().iter().map(lift).collect(), original.faces().to_vec()).unwrap();
            WeightedResult { mesh, vertex_of: (0..25).collect() }
        };
        let JudgedErrors { terms, error_shares } =
            ShapeObjective.judge(&original, [&lifted(0.02), &lifted(0.01)]).unwrap();
        assert_eq!(terms.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["distance", "normals", "peak"]);
        let ErrorShares::Faces(of_faces) = error_shares else { panic!("{error_shares:?}") };
        for (face, share) in original.faces().iter().zip(of_faces) {
            let is_lifted = face.iter().any(|&v| original.positions()[v as usize][0] > 2.0);
            assert_eq!(share > 1e-9, is_lifted, "{face:?} {share}");
        }
    }
}
