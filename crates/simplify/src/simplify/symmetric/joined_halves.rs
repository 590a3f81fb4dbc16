//! Joining a half and its image.

use crate::mesh::{Attributes, Channel, Frame, TriMesh};
use crate::simplify::SimplifyError;
use crate::simplify::closed::{blend, separate_mirrored};

use super::doubled_attributes::GroupPairs;
use super::image_plane::ImagePlane;

pub(super) struct SimplifiedHalf<'a> {
    pub mesh: &'a TriMesh,
    pub attributes: Attributes,
    pub on_plane: &'a [bool],
}

/// Joins a half and its image; also returns the number of vertices moved off duplicates.
pub(super) fn join_half(
    half: SimplifiedHalf,
    plane: &ImagePlane,
    groups: &GroupPairs,
    frame: &Frame,
) -> Result<(TriMesh, Attributes, usize), SimplifyError> {
    let SimplifiedHalf { mesh, attributes, on_plane } = half;
    let placed = |v: usize, p: [f32; 3]| plane.snap(p, on_plane[v]);
    let mut positions: Vec<[f32; 3]> = mesh.positions().iter().enumerate().map(|(v, &p)| placed(v, p)).collect();
    // Duplicates are separated in half and image together, before the image is made.
    let n_moved = separate_mirrored(&mut positions, &|p| plane.image(p), &placed, frame);
    let mut next = positions.len() as u32;
    // Vertices on the plane are their own images.
    let images: Vec<u32> = (0..next).map(|v| if on_plane[v as usize] { v } else { take_number(&mut next) }).collect();
    let twins: Vec<[f32; 3]> =
        positions.iter().zip(on_plane).filter(|(_, on)| !**on).map(|(&p, _)| plane.image(p)).collect();
    positions.extend(twins);
    let mut faces = mesh.faces().to_vec();
    faces.extend(mesh.faces().iter().map(|face| reverse_winding(face.map(|v| images[v as usize]))));
    let attributes = split_attributes(attributes, mesh, on_plane, groups);
    let mesh = TriMesh::new(positions, faces).map_err(|_| SimplifyError::Overflow)?;
    Ok((mesh, attributes, n_moved))
}

fn take_number(next: &mut u32) -> u32 {
    *next += 1;
    *next - 1
}

fn reverse_winding([a, b, c]: [u32; 3]) -> [u32; 3] {
    [a, c, b]
}

/// Splits doubled attributes between the halves; shared wedges on the plane take the mean of both.
fn split_attributes(attributes: Attributes, mesh: &TriMesh, on_plane: &[bool], pairs: &GroupPairs) -> Attributes {
    let of_side = |side: usize| attributes.groups.iter().map(move |&pair| pairs[pair as usize][side]);
    let groups = of_side(0).chain(of_side(1)).collect();
    let Some((joints, twofold)) = attributes.channels.split_last() else {
        return Attributes { groups, ..Attributes::default() };
    };
    // The last channel marks where own and image wedges are one.
    let (own, images) = twofold.split_at(twofold.len() / 2);
    let n_wedges = attributes.n_wedges() as u32;
    let mut is_one = vec![false; n_wedges as usize];
    for (face, wedges) in mesh.faces().iter().zip(&attributes.wedges) {
        for (_, &wedge) in face.iter().zip(wedges).filter(|(v, _)| on_plane[**v as usize]) {
            is_one[wedge as usize] = joints.value(wedge)[0] > 0.5;
        }
    }
    let mut next = n_wedges;
    let image_of: Vec<u32> =
        (0..n_wedges).map(|wedge| if is_one[wedge as usize] { wedge } else { take_number(&mut next) }).collect();
    let image_rows =
        attributes.wedges.iter().map(|wedges| reverse_winding(wedges.map(|wedge| image_of[wedge as usize])));
    let wedges = attributes.wedges.iter().copied().chain(image_rows).collect();
    let channels = own.iter().zip(images).map(|(own, image)| join_channel(own, image, &is_one)).collect();
    Attributes { wedges, channels, groups }
}

fn join_channel(own: &Channel, image: &Channel, is_one: &[bool]) -> Channel {
    let mut values = Vec::with_capacity(2 * own.values.len());
    for (wedge, &is_one) in (0u32..).zip(is_one) {
        let [x, y] = [own.value(wedge), image.value(wedge)];
        let start = values.len();
        values.extend_from_slice(x);
        if is_one {
            blend(own.role, [x, y, y], [0.5, 0.5, 0.0], &mut values[start..]);
        }
    }
    let apart = (0u32..).zip(is_one).filter(|(_, is_one)| !**is_one);
    values.extend(apart.flat_map(|(wedge, _)| image.value(wedge)));
    Channel { values, name: own.name.clone(), ..*own }
}
