//! Reading of `.nmc` files; no byte is trusted.

use crate::clusters::{Cluster, ClusterGroup, Clusters, LARGEST_CLUSTER, Sphere};
use crate::mesh::Channel;
use crate::mesh::value_bytes::{ByteReader, Stored};

use super::{
    ArrayPlace, CONTAINER_VERSION, ClusterRow, ContainerError, GroupRow, Header, MAGIC, NONE, PagePlace, ROLES,
    cluster_bytes,
};

type Read<T> = Result<T, ContainerError>;

pub(super) fn read(bytes: &[u8]) -> Read<Clusters> {
    let header = read_header(bytes)?;
    let (rows, group_rows) = (array(bytes, header.clusters)?, array(bytes, header.groups)?);
    let mut errors = array_bytes(bytes, header.attribute_errors, f32::LEAST)?;
    let pages = array_bytes(bytes, header.pages, header.page_size)?.rest;
    let n_channels = header.channels.len();
    if n_channels.checked_mul(header.groups.count) != Some(header.attribute_errors.count) {
        return Err(damage_error("errors of attributes and groups differ in number"));
    }
    let mut made = Clusters { origin: header.origin, channels: channels(&header)?, ..Clusters::default() };
    for row in group_rows {
        made.groups.push(group_of_row(row, take(&mut errors, n_channels)?)?);
    }
    // Clusters may not overlap, so their bytes are bounded by those of the file.
    let mut left = pages.len();
    for row in rows {
        let cluster = cluster_of_row(&row, &made)?;
        let content = content(pages, &header, &cluster, row.place)?;
        left = left.checked_sub(content.len()).ok_or_else(|| damage_error("clusters overlap"))?;
        read_content(&mut made, &header, &cluster, content)?;
        made.clusters.push(cluster);
    }
    Ok(made)
}

pub(super) fn read_header(bytes: &[u8]) -> Read<Header> {
    let mut reader = ByteReader { rest: bytes.strip_prefix(&MAGIC).ok_or(ContainerError::NotAContainer)? };
    let (version, length) = <(u32, usize)>::read(&mut reader).ok_or(ContainerError::NotAContainer)?;
    if version != CONTAINER_VERSION {
        return Err(ContainerError::Version(version));
    }
    let json = reader.rest.get(..length).ok_or_else(|| damage_error("the header is longer than the file"))?;
    serde_json::from_slice(json).map_err(|error| ContainerError::Damaged(format!("header: {error}")))
}

fn damage_error(what: &str) -> ContainerError {
    ContainerError::Damaged(what.into())
}

fn array_bytes(bytes: &[u8], place: ArrayPlace, stride: usize) -> Read<ByteReader<'_>> {
    let length = place.count.checked_mul(stride);
    let end = length.and_then(|length| place.offset.checked_add(length));
    let found = end.and_then(|end| bytes.get(place.offset..end));
    Ok(ByteReader { rest: found.ok_or_else(|| damage_error("an array ends beyond the file"))? })
}

fn array<T: Stored>(bytes: &[u8], place: ArrayPlace) -> Read<Vec<T>> {
    take(&mut array_bytes(bytes, place, T::LEAST)?, place.count)
}

fn take<T: Stored>(from: &mut ByteReader, n: usize) -> Read<Vec<T>> {
    from.read_rows(n).ok_or_else(|| damage_error("an array is too short"))
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

fn check_sphere(sphere: Sphere) -> Read<Sphere> {
    match sphere.center.iter().chain([&sphere.radius]).all(|x| x.is_finite()) && sphere.radius >= 0.0 {
        true => Ok(sphere),
        false => Err(damage_error("a sphere without a finite center and radius")),
    }
}

fn group_of_row(GroupRow { sphere, error, level, .. }: GroupRow, attribute_errors: Vec<f32>) -> Read<ClusterGroup> {
    let sphere = check_sphere(sphere)?;
    if error.is_nan() || error < 0.0 {
        return Err(damage_error("a group with a negative error"));
    }
    Ok(ClusterGroup { level, error, attribute_errors, sphere })
}

fn cluster_of_row(row: &ClusterRow, made: &Clusters) -> Read<Cluster> {
    let known_group = |group: u32| match group {
        NONE => Ok(None),
        group if (group as usize) < made.groups.len() => Ok(Some(group)),
        _ => Err(damage_error("a cluster of an unknown group")),
    };
    let &ClusterRow { sphere, source, group, level, n_vertices, n_faces, .. } = row;
    if n_vertices.max(n_faces) as usize > LARGEST_CLUSTER {
        return Err(damage_error("a cluster of too many vertices or faces"));
    }
    let (source, group, sphere) = (known_group(source)?, known_group(group)?, check_sphere(sphere)?);
    let (first_vertex, first_face) = (made.vertices.len() as u32, made.faces.len() as u32);
    Ok(Cluster { level, first_vertex, n_vertices, first_face, n_faces, source, group, sphere })
}

fn content<'a>(pages: &'a [u8], header: &Header, cluster: &Cluster, place: PagePlace) -> Read<&'a [u8]> {
    let width = header.channels.iter().map(|channel| channel.width).sum();
    let [n_vertices, n_faces] = [cluster.n_vertices, cluster.n_faces].map(|n| n as usize);
    let length = cluster_bytes(n_vertices, n_faces, width, header.has_face_groups);
    let begin = (place.page as usize).checked_mul(header.page_size);
    let page = begin.and_then(|begin| pages.get(begin..)?.get(..header.page_size));
    let found = page.and_then(|page| page.get(place.offset as usize..)?.get(..length));
    found.ok_or_else(|| damage_error("a cluster ends beyond its page"))
}

fn read_content(made: &mut Clusters, header: &Header, cluster: &Cluster, content: &[u8]) -> Read<()> {
    let [n_vertices, n_faces] = [cluster.n_vertices, cluster.n_faces].map(|n| n as usize);
    let mut from = ByteReader { rest: content };
    let first = made.positions.len() as u32;
    let positions: Vec<[f32; 3]> = take(&mut from, n_vertices)?;
    if positions.as_flattened().iter().any(|x| !x.is_finite()) {
        return Err(damage_error("a position that is not finite"));
    }
    made.positions.extend(positions);
    made.vertices.extend(first..first + cluster.n_vertices);
    for channel in &mut made.channels {
        channel.values.extend(take::<f32>(&mut from, n_vertices * channel.width)?);
    }
    if header.has_face_groups {
        made.face_groups.extend(take::<u32>(&mut from, n_faces)?);
    }
    let faces: Vec<[u8; 3]> = take(&mut from, n_faces)?;
    if faces.as_flattened().iter().any(|&corner| u32::from(corner) >= cluster.n_vertices) {
        return Err(damage_error("a face with a corner beyond its cluster"));
    }
    made.faces.extend(faces);
    Ok(())
}
