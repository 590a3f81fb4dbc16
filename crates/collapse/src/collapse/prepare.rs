//! From the input to rings: checks, the unit frame, the order along the curve, and cuts at vertices that are no disk.

use crate::collapse::attributes::WedgeAttributes;
use crate::collapse::build::{Built, build_rings, is_face};
use crate::collapse::curve::order_along_curve;
use crate::collapse::cut::Cuts;
use crate::collapse::frame::UnitFrame;
use crate::collapse::merges::PassMerge;
use crate::collapse::options::{CollapseError, CollapseOptions};
use crate::collapse::record::{CollapseRecord, compose_passes};
use crate::collapse::rings::{NONE, Rings, Vertex, state};
use crate::collapse::sides::SideArrays;
use crate::collapse::team::Team;
use crate::collapse::vector::Point;
use crate::collapse::wedges::{SidesInput, Wedges};

/// A mesh ready for its first pass.
#[derive(Clone)]
pub(crate) struct Prepared {
    pub rings: Rings,
    pub frame: UnitFrame,
    /// The place along the curve of each vertex, copies last.
    ranks: Vec<u32>,
    cuts: Option<Cuts>,
}

/// Checks the input and builds its rings; vertices without a face are dropped.
pub(crate) fn prepare(
    positions: &[Point],
    faces: &[[u32; 3]],
    options: &CollapseOptions,
    team: Team,
) -> Result<Prepared, CollapseError> {
    check_sizes(positions.len(), faces, options)?;
    let frame = UnitFrame::new(positions)?;
    let order = order_along_curve(positions, frame);
    let mut ranks = vec![0; positions.len()];
    let mut vertices = Vec::with_capacity(positions.len());
    for (rank, &v) in order.iter().enumerate() {
        ranks[v as usize] = rank as u32;
        vertices.push(Vertex::new(frame.to_unit(positions[v as usize]), rank as u32));
    }
    let mut cuts: Option<Cuts> = None;
    let mut rings = loop {
        let present = cuts.as_ref().map_or(faces, |cuts| &cuts.faces);
        match build_rings(vertices, present, &ranks, team) {
            Built::Rings(rings) => break rings,
            Built::NoDisks(..) if !options.cuts => return Err(CollapseError::NotManifold),
            Built::NoDisks(no_disks, given_back) => {
                vertices = given_back;
                let cuts = cuts.get_or_insert_with(|| Cuts::new(faces, positions.len()));
                cut(cuts, &no_disks, &mut vertices, &mut ranks, positions);
            }
        }
    };
    if options.locks_boundaries {
        for state in rings.states.iter_mut().filter(|state| **state & state::BOUNDARY != 0) {
            *state |= state::LOCKED;
        }
    }
    let locked = options.locked.iter().enumerate().filter(|(_, is_locked)| **is_locked).map(|(v, _)| v as u32);
    for v in locked.chain(cuts.iter().flat_map(|cuts| cuts.touched.iter().copied())) {
        rings.states[ranks[v as usize] as usize] |= state::LOCKED;
    }
    Ok(Prepared { rings, frame, ranks, cuts })
}

fn check_sizes(n_vertices: usize, faces: &[[u32; 3]], options: &CollapseOptions) -> Result<(), CollapseError> {
    // Rings have one neighbour per face, and one more at a boundary.
    if n_vertices > 1 << 31 || faces.len() > (1 << 30) {
        return Err(CollapseError::TooLarge);
    }
    if !options.locked.is_empty() && options.locked.len() != n_vertices {
        return Err(CollapseError::WrongLength { what: "locks" });
    }
    match faces.iter().position(|face| face.iter().any(|&v| v as usize >= n_vertices)) {
        Some(face) => Err(CollapseError::IndexOutOfRange { face }),
        None => Ok(()),
    }
}

// Copies come last, at the place of what they are copies of.
fn cut(cuts: &mut Cuts, no_disks: &[u32], vertices: &mut Vec<Vertex>, ranks: &mut Vec<u32>, positions: &[Point]) {
    let mut at_rank = vec![NONE; vertices.len()];
    for (v, &rank) in ranks.iter().enumerate() {
        at_rank[rank as usize] = v as u32;
    }
    let no_disks: Vec<u32> = no_disks.iter().map(|&rank| at_rank[rank as usize]).collect();
    cuts.cut(&no_disks, positions);
    for &original in &cuts.originals[vertices.len()..] {
        let rank = vertices.len() as u32;
        vertices.push(Vertex::new(vertices[ranks[original as usize] as usize].position, rank));
        ranks.push(rank);
    }
}

impl Prepared {
    /// Returns the wedges of the input's faces, and their attributes.
    pub(crate) fn make_sides(&self, faces: &[[u32; 3]], sides: SidesInput) -> SideArrays {
        let cut_faces = self.cut_faces().unwrap_or(faces).iter();
        let by_rank = cut_faces.map(|face| face.map(|v| self.ranks[v as usize]));
        let wedges = Wedges::new(by_rank, &sides);
        let attributes = (sides.width > 0).then(|| WedgeAttributes::new(sides.values, sides.width, sides.n_counted));
        SideArrays { wedges, attributes }
    }

    /// Returns the input vertex at each place along the curve.
    pub(crate) fn list_origins(&self) -> Vec<u32> {
        let mut at_rank = vec![NONE; self.ranks.len()];
        for (v, &rank) in self.ranks.iter().enumerate() {
            at_rank[rank as usize] = self.original(v as u32) as u32;
        }
        at_rank
    }

    /// Returns the input's faces by vertices after cutting, if there were cuts.
    pub(crate) fn cut_faces(&self) -> Option<&[[u32; 3]]> {
        self.cuts.as_ref().map(|cuts| &cuts.faces[..])
    }

    fn original(&self, v: u32) -> usize {
        self.cuts.as_ref().map_or(v, |cuts| cuts.originals[v as usize]) as usize
    }

    /// Returns the position of an input vertex or copy in the unit frame.
    pub(crate) fn unit_position(&self, v: u32, positions: &[Point]) -> Point {
        self.frame.to_unit(positions[self.original(v)])
    }

    /// Returns what each vertex is after the given passes, copies included.
    pub(crate) fn compose(&self, passes: &[Vec<u32>]) -> Vec<u32> {
        compose_passes(&self.ranks, passes)
    }

    /// Returns the record of the given passes; the ranks go with it.
    pub(crate) fn take_record(
        &mut self,
        passes: Vec<Vec<u32>>,
        merges: Vec<Vec<PassMerge>>,
        n_input: usize,
    ) -> CollapseRecord {
        CollapseRecord { ranks: std::mem::take(&mut self.ranks), passes, n_input, merges }
    }

    /// Makes one vertex of copies that could not be made disks, as in the input, and adds that as a pass to the record.
    pub(crate) fn join_copies(
        &self,
        faces: &mut Vec<[u32; 3]>,
        (out, origins, errors): (&mut Vec<Point>, &mut Vec<u32>, &mut Vec<f32>),
        record: &mut CollapseRecord,
    ) {
        let Some(cuts) = &self.cuts else { return };
        let numbers = record.compose(record.n_passes());
        let mut joined: Vec<u32> = (0..out.len() as u32).collect();
        let mut is_used = vec![false; out.len()];
        faces.iter().flatten().for_each(|&v| is_used[v as usize] = true);
        let mut is_any_joined = false;
        for (v, &other) in cuts.joined.iter().enumerate().filter(|&(v, &other)| v as u32 != other) {
            let (copy, first) = (numbers[v] as usize, numbers[other as usize]);
            // Only copies that still have faces.
            if is_used.get(copy) == Some(&true) && is_used.get(first as usize) == Some(&true) {
                joined[copy] = first;
                is_any_joined = true;
            }
        }
        if !is_any_joined {
            return;
        }
        // New numbers without the joined ones.
        let mut n = 0;
        let mut new = vec![0; out.len()];
        for v in 0..out.len() {
            if joined[v] as usize == v {
                new[v] = n;
                out[n as usize] = out[v];
                origins[n as usize] = origins[v];
                errors[n as usize] = errors[v];
                n += 1;
            }
        }
        out.truncate(n as usize);
        origins.truncate(n as usize);
        errors.truncate(n as usize);
        let new: Vec<u32> = joined.iter().map(|&v| new[v as usize]).collect();
        for face in faces.iter_mut() {
            *face = face.map(|v| new[v as usize]);
        }
        faces.retain(is_face);
        record.passes.push(new);
    }
}
