//! Samples by dart throwing along the mesh, Sec. 3.1 in blue noise, and the assignment that falls out of it.
//!
//! A vertex that no dart has reached yet becomes a sample and claims every vertex within its radius to which it
//! is nearer than the samples before it. When all vertices are reached, each belongs to its nearest sample.
//! Distances are those of [`EdgeLengths`], so that samples lie where the surface bends. On large meshes darts are thrown in
//! runs of vertices side by side; runs depend on the mesh alone.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::assignment::Assignment;
use super::edge_lengths::EdgeLengths;
use crate::mesh::pulse::Pulse;
use crate::simplify::closed::prepare::surface::Surface;

/// Area per dart in squares of its radius. Discs of diameter r thrown at random jam at 0.547 of the area, which leaves
/// each `(pi / 4) / 0.547` = 1.44 squares.
const AREA_PER_DART: f64 = 1.45;
/// Vertices that are shuffled among each other: few enough to stay in the cache while darts are thrown at them. The
/// order hardly matters. Twelve large training meshes at ratios 0.03 to 0.15: the mean distance is the same at 512 and
/// 0.5 % nearer at 65,536.
const BLOCK: usize = 4096;
/// Vertices that darts are thrown at side by side, as many as fit into a few megabytes with all that is known of them.
/// Samples of two runs may lie close together. Twelve large training meshes at ratios 0.03 to 0.15: at 16,384 the mean
/// distance is 1.6 % farther.
const RUN: usize = 16 * BLOCK;
/// How often the radius may change until there is room for all darts: a bound, after which every vertex is a sample. At
/// `SHRINK` alone the radius has halved by then.
const MOST_TRIES: usize = 40;
/// A radius, in a box of unit size, at which every component holds one dart: where more than those asked for are left
/// there, a larger one changes nothing.
const MOST_RADIUS: f64 = 1e3;
/// Darts over those asked for from which on they are thrown anew with a larger radius. Of 48 results of twelve large
/// training meshes five differ at 1.1 and three at 1.5, by 0.1 % in the mean distance.
const TOO_MANY: f64 = 1.2;
/// What the radius shrinks by beyond what the missing darts ask for, so that the next try has enough. Twelve large
/// training meshes: at 0.9 the mean distance is 0.8 % farther, at 0.999 the same.
const SHRINK: f64 = 0.98;

/// Throws at least `n_samples` darts, and not many more.
pub fn throw_darts(surface: &Surface, lengths: &EdgeLengths, n_samples: usize, seed: u64) -> Assignment {
    let order = shuffled(surface, seed);
    let mut radius = radius_for(surface, lengths, n_samples);
    surface.pulse.beat(0);
    let mut field = Field::new(surface, lengths);
    field.cover(&order, radius as f32);
    let mut n_before = 0;
    for _ in 0..MOST_TRIES {
        let share = field.samples.len() as f64 / n_samples as f64;
        let one_each = radius > MOST_RADIUS && field.samples.len() == n_before;
        if (1.0..TOO_MANY).contains(&share) || one_each {
            break;
        }
        n_before = field.samples.len();
        surface.pulse.beat(0);
        if share >= TOO_MANY {
            radius *= share.sqrt();
            field = Field::new(surface, lengths);
        } else {
            radius *= SHRINK * share.sqrt();
            field.uncover(radius as f32);
        }
        field.cover(&order, radius as f32);
    }
    if field.samples.len() < n_samples {
        return Assignment::identity(surface.n_vertices());
    }
    field.assignment()
}

/// The assignment to given samples (distinct vertices); what none of them reaches becomes samples of its own.
#[cfg(test)]
pub fn assign_to(surface: &Surface, lengths: &EdgeLengths, samples: &[u32]) -> Assignment {
    let mut field = Field::new(surface, lengths);
    field.plant(samples);
    let all: Vec<u32> = (0..surface.n_vertices() as u32).collect();
    field.cover(&all, f32::MAX);
    field.assignment()
}

/// The vertex indices, block after block, each block in random order: neighbours in memory are mostly neighbours on
/// the surface, and a block's worth of them stays in cache.
fn shuffled(surface: &Surface, seed: u64) -> Vec<u32> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut order: Vec<u32> = (0..surface.n_vertices() as u32).collect();
    for block in order.chunks_mut(BLOCK) {
        surface.pulse.beat(block.len());
        for i in (1..block.len()).rev() {
            let j = ((random.next_u64() >> 32) * (i as u64 + 1)) >> 32;
            block.swap(i, j as usize);
        }
    }
    order
}

/// The radius at which about `n_samples` darts find room: no vertex can hold more than one.
fn radius_for(surface: &Surface, lengths: &EdgeLengths, n_samples: usize) -> f64 {
    let cells = histogram(surface.pulse, &lengths.areas);
    let expected = |radius: f64| {
        let disc = AREA_PER_DART * radius * radius;
        cells.iter().map(|&(area, count)| count * chance(area / disc)).sum::<f64>()
    };
    let (mut low, mut high) = (1e-9, MOST_RADIUS);
    for _ in 0..32 {
        let middle = f64::sqrt(low * high);
        if expected(middle) > n_samples as f64 {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// How many areas there are of each size, sizes within three percent as one: (mean area, count).
fn histogram(pulse: Pulse, areas: &[f32]) -> Vec<(f64, f64)> {
    /// Five bits of the mantissa are left: 32 sizes between a number and twice that, 3 % apart.
    const SHIFT: u32 = 18;
    let mut bins = vec![(0.0f64, 0u32); (u32::MAX >> (SHIFT + 1)) as usize + 1];
    for areas in pulse.counting_if(false).over(areas) {
        for &area in areas {
            let bin = &mut bins[(area.max(0.0).to_bits() >> SHIFT) as usize];
            bin.0 += f64::from(area);
            bin.1 += 1;
        }
    }
    let used = bins.into_iter().filter(|bin| bin.1 > 0);
    used.map(|(sum, count)| (sum / f64::from(count), f64::from(count))).collect()
}

/// Chance of a vertex to become a sample when its cell holds `demand` darts' worth of area (fitted to counts).
fn chance(demand: f64) -> f64 {
    demand / (1.0 + demand * demand).sqrt()
}

/// The nearest sample of every vertex so far.
struct Field<'a> {
    surface: &'a Surface<'a>,
    lengths: &'a EdgeLengths,
    distance: Vec<f32>,
    /// For each vertex that was reached its sample.
    owner: Vec<u32>,
    samples: Vec<u32>,
    /// The vertices with neighbours in another run, some of them more than once.
    boundaries: Vec<u32>,
}

impl<'a> Field<'a> {
    fn new(surface: &'a Surface<'a>, lengths: &'a EdgeLengths) -> Self {
        let n = surface.n_vertices();
        Self {
            surface,
            lengths,
            distance: vec![f32::INFINITY; n],
            owner: vec![0; n],
            samples: Vec::new(),
            boundaries: Vec::new(),
        }
    }

    /// Throws darts at the vertices in `order` until all are reached: in runs of vertices side by side, and then lets the
    /// samples of each claim what is nearer to them in the others.
    fn cover(&mut self, order: &[u32], radius: f32) {
        let (surface, lengths) = (self.surface, self.lengths);
        let runs = self.distance.par_chunks_mut(RUN).zip(self.owner.par_chunks_mut(RUN)).zip(order.par_chunks(RUN));
        let covered = runs.enumerate().map(|(i, ((distance, owner), order))| {
            let mut run = Run::new(surface, lengths, (i * RUN) as u32, distance, owner);
            run.cover(order, radius);
            (run.samples, run.boundaries)
        });
        let covered: Vec<_> = covered.collect();
        for (samples, boundaries) in covered {
            self.samples.extend(samples);
            self.boundaries.extend(boundaries);
        }
        surface.pulse.beat(0);
        let mut whole = Run::new(surface, lengths, 0, &mut self.distance, &mut self.owner);
        whole.front = self.boundaries.iter().map(|&v| (v, whole.distance[v as usize])).collect();
        whole.grow(radius);
        surface.pulse.beat(0);
    }

    /// Frees the vertices that a smaller radius no longer reaches.
    fn uncover(&mut self, radius: f32) {
        self.distance.iter_mut().filter(|d| **d > radius).for_each(|d| *d = f32::INFINITY);
    }

    /// Lets each of these samples claim what is nearest to it.
    #[cfg(test)]
    fn plant(&mut self, samples: &[u32]) {
        let mut whole = Run::new(self.surface, self.lengths, 0, &mut self.distance, &mut self.owner);
        samples.iter().for_each(|&v| whole.plant(v));
        whole.grow(f32::MAX);
        self.samples.extend(whole.samples);
    }

    /// The regions of the samples, numbered like them.
    fn assignment(self) -> Assignment {
        self.surface.pulse.beat(0);
        let mut number = vec![0; self.owner.len()];
        self.samples.iter().zip(0u32..).for_each(|(&v, i)| number[v as usize] = i);
        let region = self.surface.pulse.map(&self.owner, |&sample| number[sample as usize]);
        Assignment { region, n_regions: self.samples.len(), samples: self.samples }
    }
}

/// A run of vertices that samples claim from each other; what lies outside of it is not there.
struct Run<'a> {
    surface: &'a Surface<'a>,
    lengths: &'a EdgeLengths,
    /// The first vertex.
    first: u32,
    distance: &'a mut [f32],
    owner: &'a mut [u32],
    /// Samples that were planted here.
    samples: Vec<u32>,
    /// Vertices with neighbours elsewhere that something grew from.
    boundaries: Vec<u32>,
    /// Vertices with the distance at which they were reached; those before `next` are done.
    front: Vec<(u32, f32)>,
    next: usize,
}

impl<'a> Run<'a> {
    fn new(
        surface: &'a Surface<'a>,
        lengths: &'a EdgeLengths,
        first: u32,
        distance: &'a mut [f32],
        owner: &'a mut [u32],
    ) -> Self {
        Self {
            surface,
            lengths,
            first,
            distance,
            owner,
            samples: Vec::new(),
            boundaries: Vec::new(),
            front: Vec::new(),
            next: 0,
        }
    }

    /// Throws darts at these vertices, in this order, until all are reached.
    fn cover(&mut self, order: &[u32], radius: f32) {
        for numbers in self.surface.pulse.by(BLOCK, 0..order.len()) {
            for &v in &order[numbers] {
                if self.distance[(v - self.first) as usize] == f32::INFINITY {
                    self.plant(v);
                    self.grow(radius);
                }
            }
        }
    }

    fn plant(&mut self, v: u32) {
        let place = (v - self.first) as usize;
        self.distance[place] = 0.0;
        self.owner[place] = v;
        self.samples.push(v);
        self.front.push((v, 0.0));
    }

    /// Lets the samples in front claim what is nearer to them, free vertices up to `radius` away.
    ///
    /// First come, first served: a vertex that is reached again by a shorter way goes on again. Within the few rings of
    /// a dart that is rare, and costs less than keeping the front in order.
    fn grow(&mut self, radius: f32) {
        while self.next < self.front.len() {
            let begin = self.next;
            self.next = self.front.len().min(begin + BLOCK);
            for at in begin..self.next {
                self.grow_from(at, radius);
            }
            if self.next == begin + BLOCK {
                self.surface.pulse.beat(0);
            }
        }
        self.front.clear();
        self.next = 0;
    }

    /// Lets a vertex of the front claim its neighbours for its sample.
    #[inline(always)]
    fn grow_from(&mut self, at: usize, radius: f32) {
        let (v, distance) = self.front[at];
        let place = (v - self.first) as usize;
        if distance > self.distance[place] {
            return;
        }
        let owner = self.owner[place];
        let neighbors = self.surface.neighbors(v);
        let mut is_boundary = false;
        for (&w, &length) in neighbors.iter().zip(self.lengths.of(self.surface, v)) {
            let place = w.wrapping_sub(self.first) as usize;
            let Some(reached) = self.distance.get_mut(place) else {
                is_boundary = true;
                continue;
            };
            let there = distance + length;
            if there < *reached && (there <= radius || *reached < f32::INFINITY) {
                *reached = there;
                self.owner[place] = owner;
                self.front.push((w, there));
            }
        }
        if is_boundary {
            self.boundaries.push(v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// Distances from one vertex by relaxing all edges until nothing changes.
    fn naive_distances(surface: &Surface, lengths: &EdgeLengths, from: u32) -> Vec<f32> {
        let mut distance = vec![f32::INFINITY; surface.n_vertices()];
        distance[from as usize] = 0.0;
        let mut changed = true;
        while std::mem::take(&mut changed) {
            for v in 0..surface.n_vertices() as u32 {
                for (&w, &length) in surface.neighbors(v).iter().zip(lengths.of(surface, v)) {
                    let there = distance[v as usize] + length;
                    if there < distance[w as usize] {
                        distance[w as usize] = there;
                        changed = true;
                    }
                }
            }
        }
        distance
    }

    fn assert_nearest(surface: &Surface, lengths: &EdgeLengths, samples: &[u32], owner: &[u32]) {
        let tables: Vec<Vec<f32>> = samples.iter().map(|&s| naive_distances(surface, lengths, s)).collect();
        for (v, &own) in owner.iter().enumerate() {
            let least = tables.iter().map(|table| table[v]).fold(f32::INFINITY, f32::min);
            assert!(tables[own as usize][v] <= least * (1.0 + 1e-5), "vertex {v}");
        }
    }

    #[test]
    fn every_vertex_belongs_to_its_nearest_sample() {
        for mesh in [shapes::wavy_sphere(3, 10.0), shapes::grid(20, 9), shapes::thin_sheet(12, 0.01)] {
            let surface = Surface::new(&mesh, Pulse::NONE);
            let lengths = EdgeLengths::new(&surface);
            let mut field = Field::new(&surface, &lengths);
            let order = shuffled(&surface, 5);
            field.cover(&order, radius_for(&surface, &lengths, 30) as f32);
            field.uncover(radius_for(&surface, &lengths, 50) as f32);
            field.cover(&order, radius_for(&surface, &lengths, 50) as f32);
            let assignment = field.assignment();
            assert_nearest(&surface, &lengths, &assignment.samples, &assignment.region);
            let given = [0, 7, 33, 101];
            assert_nearest(&surface, &lengths, &given, &assign_to(&surface, &lengths, &given).region);
        }
    }

    #[test]
    fn there_are_as_many_darts_as_asked_for_and_few_more() {
        for mesh in [shapes::wavy_sphere(4, 50.0), shapes::bolt(32)] {
            let surface = Surface::new(&mesh, Pulse::NONE);
            let lengths = EdgeLengths::new(&surface);
            for n in [20, 100, 700] {
                let darts = throw_darts(&surface, &lengths, n, 3);
                assert!((n..=n + n / 5 + 2).contains(&darts.n_regions), "{n}: {}", darts.n_regions);
                assert_eq!(darts.region, throw_darts(&surface, &lengths, n, 3).region);
                assert!(darts.region.iter().all(|&r| (r as usize) < darts.n_regions));
            }
        }
    }

    #[test]
    fn fewer_darts_than_components_end_at_one_for_each() {
        let mesh = shapes::many_boxes(30);
        let surface = Surface::new(&mesh, Pulse::NONE);
        let lengths = EdgeLengths::new(&surface);
        assert_eq!(throw_darts(&surface, &lengths, 10, 1).n_regions, 30);
    }

    #[test]
    fn runs_side_by_side_give_nearest_samples_and_hardly_more_of_them() {
        let mesh = shapes::torus(420, 200, 1.0, 0.4);
        let surface = Surface::new(&mesh, Pulse::NONE);
        assert!(surface.n_vertices() > RUN);
        let lengths = EdgeLengths::new(&surface);
        let darts = throw_darts(&surface, &lengths, 4000, 1);
        assert!((4000..4400).contains(&darts.n_regions), "{}", darts.n_regions);
        // Where no edge leads to a nearer sample, every vertex has its nearest one.
        let from_samples = assign_to(&surface, &lengths, &darts.samples);
        assert_eq!(from_samples.n_regions, darts.n_regions);
        let n_other = from_samples.region.iter().zip(&darts.region).filter(|(x, y)| x != y).count();
        assert!(n_other * 1000 < surface.n_vertices(), "{n_other}");
    }
}
