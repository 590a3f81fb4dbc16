//! Reading of `.nmc` files; no byte is trusted.

use crate::clusters::{Cluster, ClusterGroup, Clusters, LARGEST_CLUSTER, Sphere};
use crate::mesh::Channel;

use super::{
    ArrayPlace, CLUSTER_STRIDE, CONTAINER_VERSION, ContainerError, GROUP_STRIDE, Header, MAGIC, NONE, PREAMBLE, ROLES,
    cluster_bytes,
};

type Read<T> = Result<T, ContainerError>;

pub(super) fn read(bytes: &[u8]) -> Read<Clusters> {
    let header = read_header(bytes)?;
    let (rows, group_rows) =
        (array(bytes, header.clusters, CLUSTER_STRIDE)?, array(bytes, header.groups, GROUP_STRIDE)?);
    let errors = array(bytes, header.attribute_errors, 4)?;
    let pages = array(bytes, header.pages, header.page_size)?;
    let n_channels = header.channels.len();
    if n_channels.checked_mul(header.groups.count) != Some(header.attribute_errors.count) {
        return Err(damage_error("errors of attributes and groups differ in number"));
    }
    let mut made = Clusters { origin: header.origin, channels: channels(&header)?, ..Clusters::default() };
    for (group, row) in group_rows.chunks_exact(GROUP_STRIDE).enumerate() {
        let attribute_errors = errors[4 * group * n_channels..][..4 * n_channels].chunks_exact(4).map(f32_of).collect();
        made.groups.push(read_group(row, attribute_errors)?);
    }
    // Clusters may not overlap, so their bytes are bounded by those of the file.
    let mut left = pages.len();
    for row in rows.chunks_exact(CLUSTER_STRIDE) {
        let (cluster, place) = read_cluster(row, &made)?;
        let content = content(pages, &header, &cluster, place)?;
        left = left.checked_sub(content.len()).ok_or_else(|| damage_error("clusters overlap"))?;
        read_content(&mut made, &header, &cluster, content)?;
        made.clusters.push(cluster);
    }
    Ok(made)
}

pub(super) fn read_header(bytes: &[u8]) -> Read<Header> {
    let preamble = bytes.get(..PREAMBLE).filter(|bytes| bytes.starts_with(&MAGIC));
    let preamble = preamble.ok_or(ContainerError::NotAContainer)?;
    let version = u32_at(preamble, 4);
    if version != CONTAINER_VERSION {
        return Err(ContainerError::Version(version));
    }
    let length = u64::from(u32_at(preamble, 8)) | u64::from(u32_at(preamble, 12)) << 32;
    let json = usize::try_from(length).ok().and_then(|length| bytes[PREAMBLE..].get(..length));
    let json = json.ok_or_else(|| damage_error("the header is longer than the file"))?;
    serde_json::from_slice(json).map_err(|error| ContainerError::Damaged(format!("header: {error}")))
}

fn damage_error(what: &str) -> ContainerError {
    ContainerError::Damaged(what.into())
}

fn array(bytes: &[u8], place: ArrayPlace, stride: usize) -> Read<&[u8]> {
    let length = place.count.checked_mul(stride);
    let end = length.and_then(|length| place.offset.checked_add(length));
    let found = end.and_then(|end| bytes.get(place.offset..end));
    found.ok_or_else(|| damage_error("an array ends beyond the file"))
}

fn channels(header: &Header) -> Read<Vec<Channel>> {
    let channel = |head: &super::ChannelHead| {
        let role = ROLES.iter().find(|(_, name)| *name == head.role);
        let (role, _) = role.ok_or_else(|| ContainerError::Damaged(format!("unknown role {:?}", head.role)))?;
        if head.width == 0 || head.width > header.page_size {
            return Err(damage_error("a channel of impossible width"));
        }
        Ok(Channel { name: head.name.clone(), role: *role, width: head.width, values: Vec::new() })
    };
    header.channels.iter().map(channel).collect()
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..at + 4).and_then(|bytes| bytes.try_into().ok()).map_or(0, u32::from_le_bytes)
}

fn f32_of(bytes: &[u8]) -> f32 {
    f32::from_bits(u32_at(bytes, 0))
}

fn read_sphere(row: &[u8]) -> Read<Sphere> {
    let [x, y, z, radius] = [0, 4, 8, 12].map(|at| f32_of(&row[at..]));
    match [x, y, z, radius].iter().all(|x| x.is_finite()) && radius >= 0.0 {
        true => Ok(Sphere { center: [x, y, z], radius }),
        false => Err(damage_error("a sphere without a finite center and radius")),
    }
}

fn read_group(row: &[u8], attribute_errors: Vec<f32>) -> Read<ClusterGroup> {
    let (sphere, error) = (read_sphere(row)?, f32_of(&row[16..]));
    if error.is_nan() || error < 0.0 {
        return Err(damage_error("a group with a negative error"));
    }
    Ok(ClusterGroup { level: u32_at(row, 20), error, attribute_errors, sphere })
}

/// Reads a row of the array of clusters; also returns the page and the offset in it.
fn read_cluster(row: &[u8], made: &Clusters) -> Read<(Cluster, [u32; 2])> {
    let group = |at: usize| match u32_at(row, at) {
        NONE => Ok(None),
        group if (group as usize) < made.groups.len() => Ok(Some(group)),
        _ => Err(damage_error("a cluster of an unknown group")),
    };
    let [n_vertices, n_faces] = [36, 40].map(|at| u32_at(row, at));
    if n_vertices.max(n_faces) as usize > LARGEST_CLUSTER {
        return Err(damage_error("a cluster of too many vertices or faces"));
    }
    let cluster = Cluster {
        level: u32_at(row, 24),
        first_vertex: made.vertices.len() as u32,
        n_vertices,
        first_face: made.faces.len() as u32,
        n_faces,
        source: group(16)?,
        group: group(20)?,
        sphere: read_sphere(row)?,
    };
    Ok((cluster, [28, 32].map(|at| u32_at(row, at))))
}

fn content<'a>(pages: &'a [u8], header: &Header, cluster: &Cluster, [page, offset]: [u32; 2]) -> Read<&'a [u8]> {
    let width = header.channels.iter().map(|channel| channel.width).sum();
    let [n_vertices, n_faces] = [cluster.n_vertices, cluster.n_faces].map(|n| n as usize);
    let length = cluster_bytes(n_vertices, n_faces, width, header.has_face_groups);
    let page =
        (page as usize).checked_mul(header.page_size).and_then(|begin| pages.get(begin..)?.get(..header.page_size));
    let found = page.and_then(|page| page.get(offset as usize..)?.get(..length));
    found.ok_or_else(|| damage_error("a cluster ends beyond its page"))
}

fn read_content(made: &mut Clusters, header: &Header, cluster: &Cluster, mut content: &[u8]) -> Read<()> {
    let [n_vertices, n_faces] = [cluster.n_vertices, cluster.n_faces].map(|n| n as usize);
    let mut take = |n: usize| {
        let (front, rest) = content.split_at(n);
        content = rest;
        front
    };
    let floats = |bytes: &[u8]| -> Vec<f32> { bytes.chunks_exact(4).map(f32_of).collect() };
    let first = made.positions.len() as u32;
    let positions = floats(take(12 * n_vertices));
    if positions.iter().any(|x| !x.is_finite()) {
        return Err(damage_error("a position that is not finite"));
    }
    made.positions.extend(positions.as_chunks().0);
    made.vertices.extend(first..first + cluster.n_vertices);
    for channel in &mut made.channels {
        channel.values.extend(floats(take(4 * n_vertices * channel.width)));
    }
    if header.has_face_groups {
        made.face_groups.extend(take(4 * n_faces).chunks_exact(4).map(|bytes| u32_at(bytes, 0)));
    }
    let faces = take(3 * n_faces).as_chunks().0;
    if faces.iter().flatten().any(|&corner| u32::from(corner) >= cluster.n_vertices) {
        return Err(damage_error("a face with a corner beyond its cluster"));
    }
    made.faces.extend(faces);
    Ok(())
}
