//! Point clouds without repeated points.

use super::cleanup::{CleanError, local_origin, to_local};
use super::first_equal::join_positions;
use super::{Channel, Frame, RawMesh, Role};

/// Distinct finite points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointCloud {
    /// Points in the local frame, n x 3.
    pub points: Vec<[f32; 3]>,
    /// Conversion of the coordinates to the file's.
    pub frame: Frame,
    /// Index in the file of each point, n.
    pub source: Vec<u32>,
    /// Normal of each point, n x 3, if the file has normals.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Number of repeated points dropped.
    pub repeated: usize,
    /// Number of points dropped because they are not finite.
    pub non_finite: usize,
}

/// Takes the vertices of a mesh as a cloud, which may be empty.
///
/// # Errors
/// [`CleanError::TooLarge`] and [`CleanError::TooFar`].
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{RawMesh, point_cloud};
/// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [f64::NAN; 3], [-0.0, 0.0, 0.0]];
/// let cloud = point_cloud(RawMesh::new(positions, Vec::new())).unwrap();
/// assert_eq!((cloud.source, cloud.repeated, cloud.non_finite), (vec![0, 1], 1, 1));
/// ```
pub fn point_cloud(raw: RawMesh) -> Result<PointCloud, CleanError> {
    let RawMesh { positions, double, attributes, .. } = raw;
    if positions.len() > (u32::MAX / 4) as usize {
        return Err(CleanError::TooLarge);
    }
    let is_finite: Vec<bool> = positions.iter().map(|p| p.iter().all(|x| x.is_finite())).collect();
    let frame = Frame { origin: if double { local_origin(&positions, &is_finite) } else { [0.0; 3] }, double };
    let (local, _) = to_local(&positions, &is_finite, &frame)?;
    let (first, _) = join_positions(&local);
    let n_finite = is_finite.iter().filter(|finite| **finite).count();
    let is_kept = |&at: &u32| is_finite[at as usize] && first[at as usize] == at;
    let source: Vec<u32> = (0..local.len() as u32).filter(is_kept).collect();
    // Only a file with a normal per vertex has as many.
    let is_normal = |channel: &&Channel| channel.role == Role::Normal && channel.values.len() == 3 * local.len();
    let normals = attributes.channels.iter().find(is_normal).map(|channel| channel.values.as_chunks().0);
    Ok(PointCloud {
        normals: normals.map(|normals| source.iter().map(|&at| normals[at as usize]).collect()),
        points: source.iter().map(|&at| local[at as usize]).collect(),
        frame,
        repeated: n_finite - source.len(),
        non_finite: local.len() - n_finite,
        source,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(positions: &[[f64; 3]], double: bool) -> Result<PointCloud, CleanError> {
        point_cloud(RawMesh { positions: positions.to_vec(), double, ..RawMesh::default() })
    }

    #[test]
    fn points_far_from_the_origin_keep_their_precision() {
        let far = [[5e6, 1.0, 2.0], [5e6 + 0.25, 1.0, 2.0], [5e6 + 0.5, 1.5, 2.0]];
        let cloud = cloud(&far, true).unwrap();
        let back: Vec<[f64; 3]> = cloud.points.iter().map(|&p| cloud.frame.to_file(p)).collect();
        assert_eq!(back, far);
    }

    #[test]
    fn normals_stay_with_their_points() {
        let values = vec![0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0];
        let channel = Channel { name: "n".into(), role: Role::Normal, width: 3, values };
        let mut raw = RawMesh::new(vec![[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]], Vec::new());
        raw.attributes.channels.push(channel);
        assert_eq!(point_cloud(raw.clone()).unwrap().normals, Some(vec![[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]));
        raw.attributes.channels[0].values.pop();
        assert_eq!(point_cloud(raw).unwrap().normals, None);
    }

    #[test]
    fn what_single_precision_cannot_hold_is_named() {
        assert_eq!(cloud(&[[0.0; 3], [1e300, 0.0, 0.0]], false), Err(CleanError::TooFar { vertex: 1 }));
        assert_eq!(cloud(&[], false), Ok(PointCloud::default()));
    }
}
