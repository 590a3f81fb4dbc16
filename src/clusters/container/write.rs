//! Writing of `.nmc` files.

use crate::clusters::{Cluster, ClusterGroup, Clusters, Sphere};

use super::{
    ALIGNMENT, ArrayPlace, CLUSTER_STRIDE, CONTAINER_VERSION, ChannelHead, GROUP_STRIDE, Header, MAGIC, NONE,
    PAGE_SIZE, PREAMBLE, ROLES, cluster_bytes,
};

/// Place of a cluster's bytes.
#[derive(Clone, Copy)]
struct PagePlace {
    page: u32,
    offset: usize,
}

pub(super) fn write(clusters: &Clusters) -> Vec<u8> {
    let (places, page_size, n_pages) = place_clusters(clusters);
    let (header, json) = lay_out(clusters, page_size, n_pages);
    let mut bytes = Vec::with_capacity(header.pages.offset + n_pages * page_size);
    bytes.extend(MAGIC);
    bytes.extend(CONTAINER_VERSION.to_le_bytes());
    bytes.extend((json.len() as u64).to_le_bytes());
    bytes.extend(json);
    bytes.resize(header.clusters.offset, 0);
    clusters.clusters.iter().zip(&places).for_each(|(cluster, place)| write_cluster(&mut bytes, cluster, *place));
    bytes.resize(header.groups.offset, 0);
    clusters.groups.iter().for_each(|group| write_group(&mut bytes, group));
    bytes.resize(header.attribute_errors.offset, 0);
    clusters.groups.iter().flat_map(|group| &group.attribute_errors).for_each(|&x| write_f32(&mut bytes, x));
    for (cluster, place) in clusters.clusters.iter().zip(&places) {
        bytes.resize(header.pages.offset + place.page as usize * page_size + place.offset, 0);
        write_content(&mut bytes, clusters, cluster);
    }
    bytes.resize(header.pages.offset + n_pages * page_size, 0);
    bytes
}

fn width(clusters: &Clusters) -> usize {
    clusters.channels.iter().map(|channel| channel.width).sum()
}

/// Fills pages with clusters in their order; a page is as large as the largest cluster needs, at least 64 KiB.
fn place_clusters(clusters: &Clusters) -> (Vec<PagePlace>, usize, usize) {
    let (width, has_groups) = (width(clusters), !clusters.face_groups.is_empty());
    let size = |cluster: &Cluster| {
        let n = cluster_bytes(cluster.n_vertices as usize, cluster.n_faces as usize, width, has_groups);
        n.next_multiple_of(4)
    };
    let largest = clusters.clusters.iter().map(size).max().unwrap_or(0);
    let page_size = largest.next_power_of_two().max(PAGE_SIZE);
    let (mut page, mut end) = (0, 0);
    let place = |cluster: &Cluster| {
        if end + size(cluster) > page_size {
            (page, end) = (page + 1, 0);
        }
        let offset = end;
        end += size(cluster);
        PagePlace { page, offset }
    };
    let places: Vec<PagePlace> = clusters.clusters.iter().map(place).collect();
    let n_pages = places.last().map_or(0, |place| place.page as usize + 1);
    (places, page_size, n_pages)
}

/// Returns the header and its JSON; its length decides the offsets in it.
fn lay_out(clusters: &Clusters, page_size: usize, n_pages: usize) -> (Header, Vec<u8>) {
    let head = |channel: &crate::mesh::Channel| ChannelHead {
        name: channel.name.clone(),
        role: ROLES.iter().find(|(role, _)| *role == channel.role).map_or("other", |(_, name)| name).into(),
        width: channel.width,
    };
    let n_errors = clusters.groups.iter().map(|group| group.attribute_errors.len()).sum();
    let header_at = |begin: usize| {
        let mut end = begin;
        let mut array = |count: usize, stride: usize, alignment: usize| {
            let offset = end.next_multiple_of(alignment);
            end = offset + count * stride;
            ArrayPlace { offset, count }
        };
        Header {
            page_size,
            origin: clusters.origin,
            clusters: array(clusters.clusters.len(), CLUSTER_STRIDE, ALIGNMENT),
            groups: array(clusters.groups.len(), GROUP_STRIDE, ALIGNMENT),
            attribute_errors: array(n_errors, 4, ALIGNMENT),
            pages: array(n_pages, page_size, page_size),
            has_face_groups: !clusters.face_groups.is_empty(),
            channels: clusters.channels.iter().map(head).collect(),
        }
    };
    // The header has room for offsets of any length.
    let longest = json_of(&header_at(usize::MAX / 4)).len();
    let room = (PREAMBLE + longest).next_multiple_of(ALIGNMENT) - PREAMBLE;
    let header = header_at(PREAMBLE + room);
    let mut json = json_of(&header);
    json.resize(room, b' ');
    (header, json)
}

fn json_of(header: &Header) -> Vec<u8> {
    // Numbers and strings always have a JSON.
    serde_json::to_vec(header).unwrap_or_default()
}

fn write_cluster(bytes: &mut Vec<u8>, cluster: &Cluster, place: PagePlace) {
    write_sphere(bytes, &cluster.sphere);
    let group = |group: Option<u32>| group.unwrap_or(NONE);
    let numbers = [
        group(cluster.source),
        group(cluster.group),
        cluster.level,
        place.page,
        place.offset as u32,
        cluster.n_vertices,
        cluster.n_faces,
        0,
    ];
    numbers.into_iter().for_each(|number| bytes.extend(number.to_le_bytes()));
}

fn write_group(bytes: &mut Vec<u8>, group: &ClusterGroup) {
    write_sphere(bytes, &group.sphere);
    write_f32(bytes, group.error);
    [group.level, 0, 0].into_iter().for_each(|number| bytes.extend(number.to_le_bytes()));
}

fn write_sphere(bytes: &mut Vec<u8>, sphere: &Sphere) {
    sphere.center.into_iter().chain([sphere.radius]).for_each(|x| write_f32(bytes, x));
}

fn write_f32(bytes: &mut Vec<u8>, x: f32) {
    bytes.extend(x.to_le_bytes());
}

fn write_content(bytes: &mut Vec<u8>, clusters: &Clusters, cluster: &Cluster) {
    let vertices = &clusters.vertices[cluster.first_vertex as usize..][..cluster.n_vertices as usize];
    for &v in vertices {
        clusters.positions[v as usize].into_iter().for_each(|x| write_f32(bytes, x));
    }
    for channel in &clusters.channels {
        vertices.iter().flat_map(|&v| channel.value(v)).for_each(|&x| write_f32(bytes, x));
    }
    let faces = cluster.first_face as usize..(cluster.first_face + cluster.n_faces) as usize;
    if let Some(groups) = clusters.face_groups.get(faces.clone()) {
        groups.iter().for_each(|group| bytes.extend(group.to_le_bytes()));
    }
    bytes.extend(clusters.faces[faces].as_flattened());
}
