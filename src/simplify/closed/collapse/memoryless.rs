//! Memoryless quadrics (Lindstrom and Turk 1999, "Evaluation of memoryless simplification"): a merged vertex forgets what it
//! was merged from.
//!
//! Its quadric is summed anew over its present faces. Quadrics that remember the original keep the planes of faces long gone:
//! they choose worse which edge goes next. Kept curves alone remember (`constraints`): where they drift, it shows. On the last
//! stretch the neighbours of a merged vertex are summed and priced anew, too, so that every price is that of the present surface.

use crate::simplify::closed::cluster::placement::{drawn, pulled};
use crate::simplify::closed::prepare::surface::{Neighbour, planes_around};

use super::complex::Collapse;
use super::history::{Event, GHOST, Renewal};

impl Collapse<'_> {
    /// Begins the last stretch: sums all quadrics anew; no price is known then.
    pub(super) fn begin_last_stretch(&mut self) {
        self.renew_all();
        (self.unpriced, self.is_last_stretch) = (None, true);
    }

    /// Sums all quadrics anew.
    pub fn renew_all(&mut self) {
        let vertices: Vec<u32> = self.living().collect();
        let pulse = self.pulse.counting_if(false);
        pulse.over(&vertices).for_each(|vertices| vertices.iter().for_each(|&v| self.renew(v)));
    }

    /// Sums the quadric of a vertex anew over its present faces; not where some of them are another block's.
    #[inline(always)]
    pub(super) fn renew(&mut self, u: u32) {
        if self.is_frozen(u) {
            return;
        }
        let planes = self.planes_of(u);
        let node = &mut self.nodes[u as usize];
        node.planes = drawn(planes.map(|entry| entry * node.importance), self.poses.bend());
        let importance = node.importance;
        if !self.poses.is_empty() {
            self.renew_poses(u);
        }
        if self.history.is_some() {
            self.write_down(u, importance);
        }
    }

    /// The same in all other poses.
    #[inline(never)]
    pub(super) fn renew_poses(&mut self, u: u32) {
        let (span, importance) = (self.nodes[u as usize].ring, self.nodes[u as usize].importance);
        for k in 0..self.poses.n_poses() {
            let neighbour = |i: usize| match self.links.at(span, i) {
                w if self.is_ghost(w) => Neighbour::Ghost,
                w => Neighbour::At(self.poses.of(w)[k].position),
            };
            let planes = planes_around(self.poses.of(u)[k].position, (0..span.len()).map(neighbour));
            self.poses.of_mut(u)[k].planes = pulled(planes.map(|entry| entry * importance));
        }
    }

    /// Writes down that the quadric of a vertex was summed anew.
    fn write_down(&mut self, u: u32, importance: f32) {
        let ring = self.ring(u).map(|w| if self.is_ghost(w) { GHOST } else { w }).collect();
        let renewal = Renewal::new(u, ring, |w| self.positions[w as usize], [importance, self.poses.bend()]);
        self.history.get_or_insert_default().push(Event::Renewal(renewal));
    }

    /// The planes around a vertex.
    #[inline(always)]
    fn planes_of(&self, u: u32) -> [f32; 6] {
        let span = self.nodes[u as usize].ring;
        let centre = self.positions[u as usize];
        let place = |i: usize| self.positions.get(self.links.at(span, i) as usize);
        let Some(constraints) = &self.constraints else {
            let neighbour = |i: usize| place(i).map_or(Neighbour::Ghost, |p| Neighbour::At(*p));
            return planes_around(centre, (0..span.len()).map(neighbour));
        };
        let pins = &constraints.pins;
        let neighbour = |i: usize| match place(i) {
            None => Neighbour::Ghost,
            Some(p) if pins.are_on_cut(u, self.links.at(span, i)) => Neighbour::AlongCut(*p),
            Some(p) => Neighbour::At(*p),
        };
        let planes = planes_around(centre, (0..span.len()).map(neighbour));
        match pins.plane().filter(|plane| plane.has(u)) {
            Some(plane) => plane.with_image(planes),
            None => planes,
        }
    }
}
