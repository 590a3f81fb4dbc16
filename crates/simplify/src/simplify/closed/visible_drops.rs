//! Choice of components to drop where a size is out of reach otherwise: those that a viewer misses least.
//!
//! A viewer loses pixels, and sees where space is empty. Each step of a coarsening bends all components a little more, and
//! so needs fewer drops. The step is taken at which bending and drops together cost least.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use crate::simplify::limits::Limit;
use crate::spatial::Exposure;

use super::dropping::{Components, DroppedFaces, PlacedComponents, PlacedOutput};
use super::occupied_cells::OccupiedCells;
use super::original::Original;
use super::output::Output;
use super::request::VisualProperties;

/// Distance over the scene's diagonal within which surfaces look the same.
const LOOKS_SAME: f64 = 0.0025;
/// Pixels lost by bending a component, over the root of its pixels times the bend.
// Bending moves outlines, whose length is about the root of the pixels, on both sides.
const BEND: f64 = 2.0;
/// Share of the pixels that free curves cost.
const FREE_CURVES: f64 = 0.01;
/// Share of the pixels that the last component of a material costs beyond its own.
const LAST_OF_GROUP: f64 = 0.002;
/// Share of the pixels that emptied space costs where components are chosen, over the squared sides of its cells.
// Lattices show few pixels, and leave a gap.
const EMPTIED: f64 = 2.0;
/// Share of the pixels that emptied space costs where steps are chosen, over the squared sides of its cells.
const EMPTIED_AT_STEPS: f64 = 0.5;

/// The collapse after some limits were lifted.
pub struct Step {
    /// Ceiling in the scene, over its diagonal; 0 if none was raised.
    pub ceiling: f64,
    /// True if curves or turns were set free.
    pub has_free_curves: bool,
    /// Numbers of vertices and faces of each component.
    pub sizes: Vec<[usize; 2]>,
}

/// Components of a surface, some of which may go.
pub struct DropChoice<'a> {
    pub component_of_face: &'a [u32],
    pub n: usize,
    pub output: &'a Output,
    /// Largest distance of a dropped component from the rest.
    pub within: f64,
}

/// Chooses the components that a viewer misses least so that the others reach the limit; `None` if all stay.
pub fn choose_by_views(
    original: &Original,
    choice: &DropChoice,
    steps: &[Step],
    limit: Limit,
    visual: &VisualProperties,
) -> Option<DroppedFaces> {
    let views = Views::new(original, choice, visual);
    let candidates = steps.iter().map(|step| views.drop_at(step, &steps[0], limit));
    // Where no step fits, the smallest comes next; of equal costs the first step bends least.
    let best = candidates.min_by(|x, y| x.excess.cmp(&y.excess).then(x.cost.total_cmp(&y.cost)))?;
    let mut is_dropped = vec![false; choice.n];
    best.order.iter().for_each(|&component| is_dropped[component] = true);
    let faces = || choice.component_of_face.iter().map(|&component| is_dropped[component as usize]).collect();
    (!best.order.is_empty()).then(|| DroppedFaces { faces: faces(), n_components: best.order.len() })
}

/// Lists components of a given size by what a viewer loses with each per vertex, least first; the last one stays.
pub fn order_by_views(
    original: &Original,
    choice: &DropChoice,
    sizes: Vec<[usize; 2]>,
    visual: &VisualProperties,
) -> Vec<usize> {
    let step = Step { ceiling: 0.0, has_free_curves: false, sizes };
    Views::new(original, choice, visual).drop_at(&step, &step, Limit::from_vertices(1)).order
}

impl DropChoice<'_> {
    fn components_of_output(&self, original: &Original) -> Vec<u32> {
        let mut of_output = vec![0; self.output.positions.len()];
        for (face, &component) in original.surface.faces.iter().zip(self.component_of_face) {
            face.iter().for_each(|&v| of_output[self.output.vertex_of[v as usize] as usize] = component);
        }
        of_output
    }
}

struct Views {
    exposures: Vec<Exposure>,
    cells: OccupiedCells,
    groups: Vec<Vec<u32>>,
    may_go: Vec<bool>,
    /// Numbers of vertices and faces in the original.
    whole: Vec<[usize; 2]>,
}

/// Components dropped so far at one step.
struct DropState<'a> {
    views: &'a Views,
    step: &'a Step,
    /// Dropped components, in their order.
    order: Vec<usize>,
    n_left: usize,
    /// Vertices and faces of the remaining components, at the step and in the original.
    left: [usize; 2],
    whole: [usize; 2],
    /// Share of the pixels lost with each component.
    lost: Vec<f64>,
    in_groups: BTreeMap<u32, usize>,
    in_cells: Vec<u32>,
}

fn sum_sizes(sizes: &[[usize; 2]]) -> [usize; 2] {
    sizes.iter().fold([0; 2], |sum, size| [sum[0] + size[0], sum[1] + size[1]])
}

fn subtract_sizes(all: [usize; 2], some: [usize; 2]) -> [usize; 2] {
    [all[0] - some[0], all[1] - some[1]]
}

impl<'a> DropState<'a> {
    fn new(views: &'a Views, step: &'a Step) -> Self {
        let mut in_groups = BTreeMap::new();
        views.groups.iter().flatten().for_each(|&group| *in_groups.entry(group).or_default() += 1);
        Self {
            views,
            step,
            order: Vec::new(),
            n_left: step.sizes.len(),
            left: sum_sizes(&step.sizes),
            whole: sum_sizes(&views.whole),
            lost: views.exposures.iter().map(|exposure| f64::from(exposure.changed)).collect(),
            in_groups,
            in_cells: views.cells.counts.clone(),
        }
    }

    fn excess(&self, limit: Limit) -> usize {
        self.left[0].saturating_sub(limit.vertices) + self.left[1].saturating_sub(limit.faces)
    }

    /// Returns what is lost with a component, with a factor on the space that it empties.
    fn loss(&self, component: usize, emptied: f64) -> f64 {
        let is_last = self.views.groups[component].iter().any(|group| self.in_groups[group] < 2);
        let emptied = emptied * self.views.cells.emptied_without(component, &self.in_cells);
        self.lost[component] + emptied + if is_last { LAST_OF_GROUP } else { 0.0 }
    }

    fn price(&self, component: usize) -> u64 {
        (self.loss(component, EMPTIED) / self.step.sizes[component][0].max(1) as f64).to_bits()
    }

    fn drop(&mut self, component: usize) {
        self.order.push(component);
        self.n_left -= 1;
        self.left = subtract_sizes(self.left, self.step.sizes[component]);
        for group in &self.views.groups[component] {
            self.in_groups.entry(*group).and_modify(|n| *n -= 1);
        }
        self.views.cells.of_component(component).iter().for_each(|&cell| self.in_cells[cell as usize] -= 1);
        // A component that shows in its place must not go as well: it inherits the pixels.
        let exposure = &self.views.exposures[component];
        let covered = f64::from(exposure.shown - exposure.changed).max(0.0);
        exposure.replacements.iter().for_each(|&other| self.lost[other as usize] += covered);
    }
}

struct Drops {
    /// Dropped components, in their order.
    order: Vec<usize>,
    /// Share of the pixels lost by drops and bending.
    cost: f64,
    /// Vertices and faces above the limit.
    excess: usize,
}

impl Views {
    fn new(original: &Original, choice: &DropChoice, visual: &VisualProperties) -> Self {
        let DropChoice { component_of_face, n, within, .. } = *choice;
        let placed = PlacedComponents::new(original, visual.scene, visual.attributes, component_of_face, n);
        let component_of_output = choice.components_of_output(original);
        let seen = PlacedOutput::new(&placed, choice.output, &component_of_output);
        let components = Components::new(&placed, &seen, visual);
        let diagonal = visual.scene.map_or_else(|| original.mesh.diagonal(), |scene| scene.diagonal());
        let may_go = |component: usize| !placed.is_locked(component) && components.is_within(component, within);
        Self {
            exposures: placed.exposures(LOOKS_SAME * diagonal),
            cells: OccupiedCells::new(&placed, choice.n, diagonal),
            groups: (0..n).map(|component| components.groups(component).to_vec()).collect(),
            may_go: (0..n).map(may_go).collect(),
            whole: (0..n).map(|component| components.input_size(component)).collect(),
        }
    }

    /// Drops the components that cost least per freed vertex until a step is within the limit.
    fn drop_at(&self, step: &Step, first: &Step, limit: Limit) -> Drops {
        let mut state = DropState::new(self, step);
        let mut cost = self.bending_cost(step, first);
        // A heap by price: the bits of a positive number are in its order.
        let start = (0..step.sizes.len()).filter(|&component| self.may_go[component]);
        let mut queue: BinaryHeap<Reverse<(u64, usize)>> =
            start.map(|component| Reverse((state.price(component), component))).collect();
        while state.excess(limit) > 0 && state.n_left > 1 {
            let Some(Reverse((bits, component))) = queue.pop() else { break };
            let now = state.price(component);
            // Prices rise when a component shows in the place of another, or becomes the last of its material or cell.
            if now != bits {
                queue.push(Reverse((now, component)));
                continue;
            }
            // The rest of the original must fill the requested size.
            let rest = subtract_sizes(state.whole, self.whole[component]);
            if !limit.needs_more_than(rest, state.whole) {
                cost += state.loss(component, EMPTIED_AT_STEPS) - self.bending_of(component, step, first);
                state.whole = rest;
                state.drop(component);
            }
        }
        Drops { excess: state.excess(limit), order: state.order, cost }
    }

    fn bending_cost(&self, step: &Step, first: &Step) -> f64 {
        let bends: f64 = (0..step.sizes.len()).map(|component| self.bending_of(component, step, first)).sum();
        bends + if step.has_free_curves { FREE_CURVES } else { 0.0 }
    }

    fn bending_of(&self, component: usize, step: &Step, first: &Step) -> f64 {
        if step.sizes[component] == first.sizes[component] {
            return 0.0;
        }
        // A component cannot lose more than its pixels.
        let shown = f64::from(self.exposures[component].shown);
        (BEND * shown.sqrt() * step.ceiling).min(shown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::shapes;
    use crate::simplify::closed::dropping::vertex_components;
    use crate::simplify::closed::pins::Pins;

    #[test]
    fn a_lattice_thins_out_and_leaves_no_gap() {
        const N: usize = 16;
        let ball = |at: [f32; 3], r: f32| {
            shapes::place(&shapes::icosphere(0), |p| [r * p[0] + at[0], r * p[1] + at[1], r * p[2] + at[2]])
        };
        let floor = (0..N).map(|i| ball([(i % 4) as f32, (i / 4) as f32, 0.0], 0.06));
        let mast = (0..N).map(|i| ball([1.5, 1.5, 1.0 + 0.2 * i as f32], 0.05));
        let mesh = shapes::unite(floor.chain(mast));
        let original = Original::bare(&mesh);
        let surface = &original.surface;
        let positions = surface.positions.to_vec();
        let vertex_of = (0..surface.n_vertices() as u32).collect();
        let output = Output::new(Pulse::NONE, positions, surface.faces.to_vec(), Pins::default(), vertex_of);
        let (of_vertex, n) = vertex_components(surface.n_vertices(), &surface.faces);
        let component_of_face: Vec<u32> = surface.faces.iter().map(|face| of_vertex[face[0] as usize]).collect();
        let choice = DropChoice { component_of_face: &component_of_face, n, output: &output, within: f64::INFINITY };
        let visual = VisualProperties { attributes: None, scene: None, is_weighed: false, is_guarded: true };
        let step = Step { ceiling: 0.0, has_free_curves: false, sizes: vec![[12, 20]; n] };
        let dropped = choose_by_views(&original, &choice, &[step], Limit::from_vertices(12 * N), &visual).unwrap();
        assert_eq!(dropped.n_components, N);
        let stays: Vec<bool> = (N..2 * N).map(|component| !dropped.faces[20 * component]).collect();
        let longest_gap = stays.split(|stays| *stays).map(<[bool]>::len).max().unwrap();
        assert!(longest_gap <= 6 && stays.iter().filter(|stays| **stays).count() <= N / 2, "{stays:?}");
    }
}
