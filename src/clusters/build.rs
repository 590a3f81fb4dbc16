//! Building of a hierarchy, level by level.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use crate::mesh::sides;
use crate::parallel;
use crate::simplify::{ClosedOptions, Event, Input, Listener, SimplifyError};

use super::ancestors::{AncestorLists, Ancestors, GroupAncestors};
use super::error::{GroupErrors, measure};
use super::face_split::{ClusterLimit, split_faces};
use super::grouping::group_clusters;
use super::reduction::{options_for_groups, reduce};
use super::vertices::{Patch, PoolFace, ReducedPatch, VertexPool};
use super::{Cluster, ClusterError, ClusterGroup, ClusterOptions, Clusters, Sphere};

/// Share of a group's faces above which its result is not used: its clusters go to the next level as they are.
const MOST_LEFT: f64 = 0.85;
/// Share of the clusters above which a level has made too little progress: the next one forms groups of twice the size.
const SLOW: f64 = 0.9;
/// Size of groups, over the number of all clusters, at which a level without progress is the last.
const MOST_WANTED: usize = 4;
/// Number of groups between two events.
const GROUPS_PER_EVENT: usize = 64;
/// Levels that are proved against the same faces.
// Of 20 components, the median of proved over sampled errors is 1.75 with two, and 1.38 with four.
const LEVELS_PER_ANCESTOR: usize = 4;
const NO_GROUP: u32 = u32::MAX;
const SHARED: u32 = u32::MAX - 1;

/// Builds the hierarchy of a mesh with its attributes.
///
/// The result is the same on any number of threads. `importance` of the input is not used, and locked vertices and kept
/// faces are free in groups: level 0 has them all.
///
/// # Errors
/// [`ClusterError::BadSize`] for an option out of range; otherwise as [`simplify`](crate::simplify::simplify).
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::clusters::{ClusterOptions, build_clusters};
/// use neural_mesh::{mesh::shapes, simplify::Input};
/// let mesh = shapes::icosphere(5);
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let clusters = build_clusters(&Input::bare(&mesh), &ClusterOptions::default(), go_on).unwrap();
/// assert_eq!(clusters.roots().len(), 1);
/// // All faces within the distance 0; fewer within 0.01.
/// let [whole, light] = [0.0, 0.01].map(|error| clusters.mesh_of(&clusters.cut_at_error(error)).0);
/// assert_eq!(whole.faces().len(), mesh.faces().len());
/// assert!(light.faces().len() < mesh.faces().len() / 4);
/// ```
pub fn build_clusters(
    input: &Input,
    options: &ClusterOptions,
    listener: &mut Listener,
) -> Result<Clusters, ClusterError> {
    options.check()?;
    input.check()?;
    let (pool, faces) = VertexPool::new(input);
    if faces.is_empty() {
        return Err(SimplifyError::Empty.into());
    }
    let mut build = Build::new(options, pool);
    build.begin(faces);
    build.add_levels(usize::MAX, listener)?;
    Ok(build.finish())
}

/// Cluster without a group so far.
pub struct LiveCluster {
    pub number: u32,
    pub faces: Vec<PoolFace>,
    /// Ancestors of each face.
    pub ancestors: AncestorLists,
}

/// Hierarchy that grows level by level.
pub struct Build {
    pub pool: VertexPool,
    pub made: Clusters,
    pub live: Vec<LiveCluster>,
    /// Marks places that faces outside of this hierarchy use; those after its end are not used outside.
    pub held: Vec<bool>,
    ancestors: Ancestors,
    limit: ClusterLimit,
    options: ClosedOptions,
    clusters_per_group: usize,
    /// Faces simplified so far, and about how many there will be.
    work: (usize, usize),
}

struct GroupResult {
    patch: Patch,
    reduced: ReducedPatch,
    parts: Vec<Vec<u32>>,
    errors: GroupErrors,
}

impl Build {
    pub fn new(options: &ClusterOptions, pool: VertexPool) -> Self {
        Self {
            pool,
            made: Clusters { origin: options.simplify.frame.origin, ..Clusters::default() },
            live: Vec::new(),
            held: Vec::new(),
            ancestors: Ancestors::default(),
            limit: ClusterLimit { n_faces: options.max_faces, n_vertices: options.max_vertices },
            options: options_for_groups(&options.simplify),
            clusters_per_group: options.clusters_per_group,
            work: (0, 0),
        }
    }

    /// Splits faces of the input into the clusters of level 0.
    pub fn begin(&mut self, faces: Vec<PoolFace>) {
        let (centroid, corners) =
            (|face: u32| self.pool.centroid(&faces[face as usize]), |face: u32| faces[face as usize].corners);
        let parts = split_faces((0..faces.len() as u32).collect(), self.limit, &centroid, &corners);
        for part in parts {
            let faces = part.into_iter().map(|face| (faces[face as usize], face)).collect();
            self.add_cluster(faces, &AncestorLists::default(), 0, None);
        }
    }

    /// Adds at most `n` levels, until one cluster is left, or nothing makes the clusters fewer.
    ///
    /// # Errors
    /// [`SimplifyError::Interrupted`] if `listener` stops the run.
    pub fn add_levels(&mut self, n: usize, listener: &mut Listener) -> Result<(), SimplifyError> {
        self.work = (0, 2 * self.live.iter().map(|cluster| cluster.faces.len()).sum::<usize>());
        let mut wanted = self.clusters_per_group;
        for level in 0..n {
            if level % LEVELS_PER_ANCESTOR == 0 {
                self.renew_ancestors();
            }
            self.ancestors.is_last = (level + 1) % LEVELS_PER_ANCESTOR == 0;
            let n_before = self.live.len();
            if n_before <= 1 {
                break;
            }
            self.add_level(wanted, listener)?;
            self.ancestors.age += 1;
            if self.live.len() as f64 > SLOW * n_before as f64 {
                // A group of all clusters has no shared vertices: if it stays, nothing makes it smaller.
                if self.live.len() == n_before && wanted > MOST_WANTED * n_before {
                    break;
                }
                wanted *= 2;
            }
        }
        Ok(())
    }

    /// Makes all live faces their own ancestors.
    fn renew_ancestors(&mut self) {
        self.ancestors = Ancestors::default();
        for cluster in &mut self.live {
            cluster.ancestors = AncestorLists::default();
            for face in &cluster.faces {
                cluster.ancestors.push([self.ancestors.add(*face)]);
            }
        }
    }

    /// Replaces groups of live clusters by the clusters of their simplified faces.
    fn add_level(&mut self, wanted: usize, listener: &mut Listener) -> Result<(), SimplifyError> {
        let edges = parallel::each(&self.live, |it| boundary_edges(&self.pool, &it.faces));
        let center = |i: u32| self.made.clusters[self.live[i as usize].number as usize].sphere.center;
        let groups = group_clusters(&edges, center, wanted);
        let users = self.find_users(&groups);
        self.ancestors.count_users(self.live.iter().map(|cluster| &cluster.ancestors));
        let mut live: Vec<Option<LiveCluster>> = std::mem::take(&mut self.live).into_iter().map(Some).collect();
        let stops = AtomicBool::new(false);
        for groups in groups.chunks(GROUPS_PER_EVENT) {
            let members: Vec<Vec<LiveCluster>> = groups
                .iter()
                .map(|group| group.iter().filter_map(|&member| live[member as usize].take()).collect())
                .collect();
            let n_faces = members.iter().flatten().map(|cluster| cluster.faces.len()).sum::<usize>();
            self.report(n_faces, &stops, listener)?;
            let results = parallel::each(&members, |members| self.simplify_group(members, &users, &stops));
            let results: Vec<_> = results.into_iter().collect::<Result<_, _>>()?;
            for (members, result) in members.into_iter().zip(results) {
                self.replace(members, result);
            }
        }
        Ok(())
    }

    fn report(&mut self, n_faces: usize, stops: &AtomicBool, listener: &mut Listener) -> Result<(), SimplifyError> {
        let share = self.work.0 as f32 / self.work.1.max(1) as f32;
        self.work.0 += n_faces;
        let event = Event { stage: "clusters", done: share.min(1.0), total: share.min(1.0) };
        if listener(event) == ControlFlow::Continue(()) {
            return Ok(());
        }
        stops.store(true, Relaxed);
        Err(SimplifyError::Interrupted)
    }

    /// Returns the group that uses each place, or [`SHARED`].
    fn find_users(&self, groups: &[Vec<u32>]) -> Vec<u32> {
        let mut users: Vec<u32> = self.held.iter().map(|held| if *held { SHARED } else { NO_GROUP }).collect();
        users.resize(self.pool.n_places as usize, NO_GROUP);
        for (number, group) in (0u32..).zip(groups) {
            let faces = group.iter().flat_map(|&member| &self.live[member as usize].faces);
            for vertex in faces.flat_map(|face| face.corners) {
                let user = &mut users[self.pool.place(vertex) as usize];
                *user = if *user == NO_GROUP || *user == number { number } else { SHARED };
            }
        }
        users
    }

    /// Simplifies a group to half; `None` if too many of its vertices are shared.
    fn simplify_group(
        &self,
        members: &[LiveCluster],
        users: &[u32],
        stops: &AtomicBool,
    ) -> Result<Option<GroupResult>, SimplifyError> {
        let faces: Vec<PoolFace> = members.iter().flat_map(|member| member.faces.iter().copied()).collect();
        let patch = self.pool.patch(&faces, |place| users[place as usize] == SHARED)?;
        let reduced = reduce(&patch, &self.options, self.target(faces.len()), stops)?;
        if reduced.mesh.faces().len() as f64 > MOST_LEFT * faces.len() as f64 {
            return Ok(None);
        }
        let before: Vec<f32> = faces.iter().map(|face| face.error).collect();
        let mut lists = AncestorLists::default();
        members.iter().for_each(|member| lists.extend(&member.ancestors));
        let group = GroupAncestors { pool: &self.pool, ancestors: &self.ancestors, lists };
        let errors = measure(&patch, &reduced, &before, &group);
        let parts = self.split(&reduced);
        Ok(Some(GroupResult { patch, reduced, parts, errors }))
    }

    /// Returns about half of the faces, in full clusters.
    fn target(&self, n_faces: usize) -> usize {
        let (half, full) = (n_faces / 2, self.limit.n_faces);
        match (half + full / 4) / full {
            0 => half.max(1),
            n_clusters => n_clusters * full,
        }
    }

    fn split(&self, reduced: &ReducedPatch) -> Vec<Vec<u32>> {
        let faces = reduced.mesh.faces();
        let wedges = if reduced.attributes.wedges.is_empty() { faces } else { &reduced.attributes.wedges };
        let centroid = |face: u32| {
            let [a, b, c] = faces[face as usize].map(|v| reduced.mesh.positions()[v as usize]);
            std::array::from_fn(|k| a[k] / 3.0 + b[k] / 3.0 + c[k] / 3.0)
        };
        split_faces((0..faces.len() as u32).collect(), self.limit, &centroid, &|face| wedges[face as usize])
    }

    fn sources<'a>(&'a self, members: &'a [LiveCluster]) -> impl Iterator<Item = &'a ClusterGroup> + Clone {
        let source = |member: &LiveCluster| self.made.clusters[member.number as usize].source;
        members.iter().filter_map(source).map(|group| &self.made.groups[group as usize])
    }

    /// Adds a group and the clusters of its result; without a result, the clusters stay live.
    fn replace(&mut self, members: Vec<LiveCluster>, result: Option<GroupResult>) {
        let Some(result) = result else {
            self.live.extend(members);
            return;
        };
        let faces = self.pool.append(&result.patch, &result.reduced, &result.errors.of_faces);
        let parts = result.parts.into_iter().map(|part| -> Vec<(PoolFace, u32)> {
            part.into_iter().filter_map(|face| faces[face as usize].map(|made| (made, face))).collect()
        });
        let parts: Vec<_> = parts.filter(|part| !part.is_empty()).collect();
        if parts.is_empty() {
            self.live.extend(members);
            return;
        }
        let level = members.iter().map(|it| self.made.clusters[it.number as usize].level).max().unwrap_or(0);
        let group = self.add_group(&members, level, &result.errors);
        for member in members {
            self.made.clusters[member.number as usize].group = Some(group);
        }
        for part in parts {
            self.add_cluster(part, &result.errors.ancestors, level + 1, Some(group));
        }
    }

    fn add_group(&mut self, members: &[LiveCluster], level: u32, errors: &GroupErrors) -> u32 {
        let spheres = members.iter().map(|it| self.made.clusters[it.number as usize].sphere);
        let sphere = Sphere::enclose(spheres.chain(self.sources(members).map(|group| group.sphere)));
        let mut attribute_errors = errors.of_channels.clone();
        for (k, error) in attribute_errors.iter_mut().enumerate() {
            *error += self.sources(members).map(|group| group.attribute_errors[k]).fold(0.0, f32::max);
        }
        let before = self.sources(members).map(|group| group.error).fold(0.0, f32::max);
        let error = errors.of_faces.iter().copied().fold(before, f32::max);
        self.made.groups.push(ClusterGroup { level, error, attribute_errors, sphere });
        (self.made.groups.len() - 1) as u32
    }

    /// Adds a cluster of some faces with their numbers in `lists`.
    fn add_cluster(
        &mut self,
        mut numbered: Vec<(PoolFace, u32)>,
        lists: &AncestorLists,
        level: u32,
        source: Option<u32>,
    ) {
        numbered.sort_by_key(|(face, _)| face.group);
        let mut ancestors = AncestorLists::default();
        if !lists.is_empty() {
            numbered.iter().for_each(|&(_, number)| ancestors.push(lists.get(number).iter().copied()));
        }
        let faces: Vec<PoolFace> = numbered.into_iter().map(|(face, _)| face).collect();
        let mut vertices: Vec<u32> = faces.iter().flat_map(|face| face.corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let points = vertices.iter().map(|&v| Sphere { center: self.pool.positions[v as usize], radius: 0.0 });
        let made = &mut self.made;
        made.clusters.push(Cluster {
            level,
            first_vertex: made.vertices.len() as u32,
            n_vertices: vertices.len() as u32,
            first_face: made.faces.len() as u32,
            n_faces: faces.len() as u32,
            source,
            group: None,
            sphere: Sphere::enclose(points),
        });
        let local = |vertex: u32| vertices.partition_point(|&v| v < vertex) as u8;
        made.faces.extend(faces.iter().map(|face| face.corners.map(local)));
        made.face_groups.extend(faces.iter().map(|face| face.group));
        made.vertices.extend(vertices);
        self.live.push(LiveCluster { number: (made.clusters.len() - 1) as u32, faces, ancestors });
    }

    pub fn finish(self) -> Clusters {
        let mut made = Clusters { positions: self.pool.positions, channels: self.pool.channels, ..self.made };
        if made.face_groups.iter().all(|group| *group == 0) {
            made.face_groups.clear();
        }
        made
    }
}

/// Returns the edges with one face in a cluster, as sorted places.
fn boundary_edges(pool: &VertexPool, faces: &[PoolFace]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = faces.iter().flat_map(|face| sides(face.corners.map(|v| pool.place(v)))).collect();
    edges.sort_unstable();
    edges.chunk_by(|x, y| x == y).filter(|same| same.len() % 2 == 1).map(|same| same[0]).collect()
}
