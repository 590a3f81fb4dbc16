//! Attributes of both halves, stored on the corners of one half.

use crate::mesh::{Attributes, Channel, DistinctKeys, Role, same_values};

use super::mirror_pairs::MirrorPairs;

pub(super) type GroupPairs = Vec<[u32; 2]>;

/// Doubles all channels: one has a corner's own values, one its image's. Groups become numbers of (own, image) pairs.
pub(super) fn double_attributes(attributes: &Attributes, pairs: &MirrorPairs) -> (Attributes, GroupPairs) {
    // The face at the image of a face's first corner.
    let image_face = |f: usize| pairs.corners[3 * f] / 3;
    let mut group_pairs = DistinctKeys::default();
    let groups = (0u32..).zip(&attributes.groups);
    let groups = groups.map(|(f, &own)| group_pairs.number([own, attributes.group(image_face(f as usize))])).collect();
    let mut wedge_pairs = DistinctKeys::default();
    let corner = |wedges: &[[u32; 3]], c: u32| wedges[c as usize / 3][c as usize % 3];
    let images = pairs.corners.chunks_exact(3);
    // Wedges become pairs of own and image wedge, so a seam on either side splits them.
    let wedges = attributes.wedges.iter().zip(images).map(|(own, images)| {
        std::array::from_fn(|k| wedge_pairs.number([own[k], corner(&attributes.wedges, images[k])]))
    });
    let wedges = wedges.collect();
    let channels = [0, 1].into_iter().flat_map(|side| {
        attributes.channels.iter().map({
            let wedge_pairs = &wedge_pairs.keys;
            move |channel| Channel {
                values: wedge_pairs.iter().flat_map(|pair| channel.value(pair[side])).copied().collect(),
                name: channel.name.clone(),
                ..*channel
            }
        })
    });
    (Attributes { wedges, channels: channels.collect(), groups }, group_pairs.keys)
}

/// Adds a channel that is 0 if a wedge on the plane differs from its image, else 1.
pub(super) fn add_joints(attributes: &mut Attributes, faces: &[[u32; 3]], on_plane: &[bool]) {
    if attributes.channels.is_empty() {
        return;
    }
    // Own and image values are the two halves of the channels.
    let (own, images) = attributes.channels.split_at(attributes.channels.len() / 2);
    let is_one = |wedge: u32| own.iter().zip(images).all(|(x, y)| same_values(x.role, x.value(wedge), y.value(wedge)));
    let mut values = vec![1.0; attributes.n_wedges()];
    for (face, wedges) in faces.iter().zip(&attributes.wedges) {
        for (_, &wedge) in face.iter().zip(wedges).filter(|(v, _)| on_plane[**v as usize]) {
            values[wedge as usize] = f32::from(u8::from(is_one(wedge)));
        }
    }
    attributes.channels.push(Channel { name: "joints".into(), role: Role::Other, width: 1, values });
}
