//! Writing of `.nmc` files.

use crate::clusters::{Cluster, ClusterGroup, Clusters};
use crate::mesh::value_bytes::{Stored, write_rows};
use crate::spatial::Bounds;

use super::{
    ALIGNMENT, ArrayPlace, CONTAINER_VERSION, ChannelHead, ClusterRow, GroupRow, Header, MAGIC, NONE, PAGE_SIZE,
    PREAMBLE, PagePlace, ROLES, cluster_bytes,
};

/// Fills pages with clusters, one after the other.
#[derive(Debug)]
pub(super) struct PageFiller {
    page_size: usize,
    n_pages: usize,
    /// Bytes used of the last page.
    end: usize,
}

impl PageFiller {
    /// Makes pages of 64 KiB, or of the next power of two that holds the largest cluster.
    pub fn new(largest_cluster: usize) -> Self {
        Self { page_size: largest_cluster.next_power_of_two().max(PAGE_SIZE), n_pages: 0, end: 0 }
    }

    pub fn place(&mut self, n_bytes: usize) -> PagePlace {
        let mut offset = self.end.next_multiple_of(4);
        if self.n_pages == 0 || offset + n_bytes > self.page_size {
            self.n_pages += 1;
            offset = 0;
        }
        self.end = offset + n_bytes;
        PagePlace { page: self.n_pages as u32 - 1, offset: offset as u32 }
    }

    /// Returns the first byte of a place after the begin of all pages.
    pub fn byte(&self, place: PagePlace) -> usize {
        place.page as usize * self.page_size + place.offset as usize
    }

    /// Returns the bytes of all pages.
    pub fn n_bytes(&self) -> usize {
        self.n_pages * self.page_size
    }
}

pub(super) fn write(clusters: &Clusters) -> Vec<u8> {
    let size = |cluster: &Cluster| content_bytes(clusters, cluster);
    let mut filler = PageFiller::new(clusters.clusters.iter().map(size).max().unwrap_or(0));
    let places: Vec<PagePlace> = clusters.clusters.iter().map(|cluster| filler.place(size(cluster))).collect();
    let mut bytes = write_head(clusters, &places, &filler);
    let begin = bytes.len();
    bytes.reserve(filler.n_bytes());
    for (cluster, place) in clusters.clusters.iter().zip(&places) {
        bytes.resize(begin + filler.byte(*place), 0);
        write_content(&mut bytes, clusters, cluster);
    }
    bytes.resize(begin + filler.n_bytes(), 0);
    bytes
}

/// Returns all bytes before the pages.
pub(super) fn write_head(clusters: &Clusters, places: &[PagePlace], filler: &PageFiller) -> Vec<u8> {
    let (header, json) = lay_out(clusters, filler);
    let mut bytes = Vec::with_capacity(header.pages.offset);
    bytes.extend(MAGIC);
    CONTAINER_VERSION.write(&mut bytes);
    json.len().write(&mut bytes);
    bytes.extend(json);
    bytes.resize(header.clusters.offset, 0);
    clusters.clusters.iter().zip(places).for_each(|(cluster, place)| cluster_row(cluster, *place).write(&mut bytes));
    bytes.resize(header.groups.offset, 0);
    clusters.groups.iter().for_each(|group| group_row(group).write(&mut bytes));
    bytes.resize(header.attribute_errors.offset, 0);
    clusters.groups.iter().for_each(|group| write_rows(&group.attribute_errors, &mut bytes));
    bytes.resize(header.pages.offset, 0);
    bytes
}

/// Returns the bytes of a cluster in its page.
pub(super) fn content_bytes(clusters: &Clusters, cluster: &Cluster) -> usize {
    let width = clusters.channels.iter().map(|channel| channel.width).sum();
    cluster_bytes(cluster.n_vertices as usize, cluster.n_faces as usize, width, !clusters.face_groups.is_empty())
}

/// Returns the header and its JSON; its length decides the offsets in it.
fn lay_out(clusters: &Clusters, &PageFiller { page_size, n_pages, .. }: &PageFiller) -> (Header, Vec<u8>) {
    let head = |channel: &crate::mesh::Channel| ChannelHead {
        name: channel.name.clone(),
        role: ROLES.iter().find(|(role, _)| *role == channel.role).map_or("other", |(_, name)| name).into(),
        width: channel.width,
    };
    let n_errors = clusters.groups.iter().map(|group| group.attribute_errors.len()).sum();
    let bounds = finest_bounds(clusters);
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
            bounds,
            clusters: array(clusters.clusters.len(), ClusterRow::LEAST, ALIGNMENT),
            groups: array(clusters.groups.len(), GroupRow::LEAST, ALIGNMENT),
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

/// Returns the lowest and highest coordinates of the finest level; `None` without positions.
fn finest_bounds(clusters: &Clusters) -> Option<[[f32; 3]; 2]> {
    let finest = clusters.clusters.iter().filter(|cluster| cluster.level == 0);
    let vertices =
        finest.filter_map(|it| clusters.vertices.get(it.first_vertex as usize..)?.get(..it.n_vertices as usize));
    let positions: Vec<[f32; 3]> = vertices.flatten().map(|&v| clusters.positions[v as usize]).collect();
    let Bounds { low, high } = Bounds::from_points(&positions);
    (!positions.is_empty()).then_some([low, high])
}

fn json_of(header: &Header) -> Vec<u8> {
    // Numbers and strings always have a JSON.
    serde_json::to_vec(header).unwrap_or_default()
}

fn cluster_row(cluster: &Cluster, place: PagePlace) -> ClusterRow {
    let &Cluster { sphere, source, group, level, n_vertices, n_faces, .. } = cluster;
    let [source, group] = [source, group].map(|group| group.unwrap_or(NONE));
    ClusterRow { sphere, source, group, level, place, n_vertices, n_faces, unused: 0 }
}

fn group_row(&ClusterGroup { sphere, error, level, .. }: &ClusterGroup) -> GroupRow {
    GroupRow { sphere, error, level, unused: [0; 2] }
}

pub(super) fn write_content(bytes: &mut Vec<u8>, clusters: &Clusters, cluster: &Cluster) {
    let vertices = &clusters.vertices[cluster.first_vertex as usize..][..cluster.n_vertices as usize];
    vertices.iter().for_each(|&v| clusters.positions[v as usize].write(bytes));
    for channel in &clusters.channels {
        vertices.iter().for_each(|&v| write_rows(channel.value(v), bytes));
    }
    let faces = cluster.first_face as usize..(cluster.first_face + cluster.n_faces) as usize;
    if let Some(groups) = clusters.face_groups.get(faces.clone()) {
        write_rows(groups, bytes);
    }
    bytes.extend(clusters.faces[faces].as_flattened());
}
