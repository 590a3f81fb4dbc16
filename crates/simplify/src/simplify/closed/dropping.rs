//! Choice of components to drop because their vertices are better spent elsewhere.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use glam::{DMat4, DVec3};

use crate::geometry::triangle::area_normal_f64;
use crate::linalg::Rows;
use crate::mesh::pulse::Pulse;
use crate::mesh::union_find::join_vertices;
use crate::mesh::{Attributes, Role, UnitedMesh};
use crate::simplify::limits::Limit;
use crate::spatial::{Exposure, FaceTree, Labels, exposures};

use super::collapse::{Collapse, CollapseEnd};
use super::original::Original;
use super::output::Output;
use super::request::VisualProperties;

const POINTS_PER_COMPONENT: usize = 64;
const POINTS_OF_WHOLE: usize = 4096;
/// Largest distance of a dropped component to the rest, over the result's mean error.
const MOST_DISTANCE: f64 = 8.0;
/// Largest share of a view's pixels that one dropped component, and all, may change.
const MOST_CHANGED: [f32; 2] = [1e-3, 1e-2];
/// Largest share of a view's pixels that may change their material by all drops together.
// Lettering is small, and conspicuous if it is missing.
const MOST_RECOLOURED: f32 = 1e-3;
/// Largest share of a view's pixels in which one drop may show a back side.
// Holes are conspicuous.
const MOST_OPENED: f32 = 2.5e-4;

/// Factor on bounds of squared distances, for rounding.
const SLACK: f64 = 1.0 + 1e-9;

pub struct VertexCost<'a> {
    pub pass_prices: &'a [(usize, f32)],
    pub limit: Limit,
    pub must_fit: bool,
}

impl<'a> VertexCost<'a> {
    pub fn new(collapse: &'a Collapse, limit: Limit, end: CollapseEnd) -> Self {
        Self {
            pass_prices: collapse.pass_prices(),
            limit,
            must_fit: matches!(end, CollapseEnd::Smallest | CollapseEnd::LosesShape),
        }
    }

    /// Estimates the highest price of the merges down to this many vertices.
    fn price_at(&self, vertices: usize) -> f64 {
        // Prices rise from pass to pass, with exceptions: the largest one counts. Above the recorded sizes, prices fall
        // with the number of vertices n as n^-3.
        let seen =
            self.pass_prices.iter().take_while(|(left, _)| *left >= vertices).map(|(_, price)| f64::from(*price));
        let first =
            self.pass_prices.first().map(|&(left, price)| f64::from(price) * (left as f64 / vertices as f64).powi(3));
        seen.reduce(f64::max).or(first).unwrap_or_default()
    }
}

pub struct DroppedFaces {
    pub faces: Vec<bool>,
    pub n_components: usize,
}

/// Chooses components to drop so that the others get their vertices; `None` if all stay.
pub fn choose_dropped(
    original: &Original,
    output: &Output,
    cost: &VertexCost,
    within: f64,
    visual: &VisualProperties,
) -> Option<DroppedFaces> {
    let (component_of_vertex, n) = output_components(output);
    if n < 2 {
        return None;
    }
    // Components of the output are those of the original: no earlier step joins or splits any.
    let component = |v: u32| component_of_vertex[output.vertex_of[v as usize] as usize];
    let component_of_face: Vec<u32> = original.surface.faces.iter().map(|face| component(face[0])).collect();
    let placed = PlacedComponents::new(original, visual.scene, visual.attributes, &component_of_face, n);
    let seen = PlacedOutput::new(&placed, output, &component_of_vertex);
    let mut components = Components::new(&placed, &seen, visual);
    component_of_vertex.iter().for_each(|&component| components.all[component as usize].n_vertices += 1);
    // The price per freed vertex, area times squared distance to the rest, must be below that of the last merges, and a
    // viewer must not miss the component.
    components.find_losses(cost);
    let is_dropped = components.choose(cost, within);
    let n_components = is_dropped.iter().filter(|dropped| **dropped).count();
    let faces = || component_of_face.iter().map(|&component| is_dropped[component as usize]).collect();
    (n_components > 0).then(|| DroppedFaces { faces: faces(), n_components })
}

pub fn output_components(output: &Output) -> (Vec<u32>, usize) {
    vertex_components(output.positions.len(), output.faces())
}

/// Returns each vertex's component number (empty for a single component) and the number of components.
pub fn vertex_components(n_vertices: usize, faces: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let mut sets = join_vertices(n_vertices, faces.iter().copied());
    if sets.n_sets() == 1 {
        return (Vec::new(), 1);
    }
    sets.number_sets(Pulse::NONE)
}

pub struct PlacedComponents<'a> {
    original: &'a Original<'a>,
    attributes: Option<&'a Attributes>,
    faces: Rows<u32>,
    /// Transforms of each component from unit size to the scene, largest first.
    transforms: Vec<Vec<DMat4>>,
    component_of_face: &'a [u32],
}

impl<'a> PlacedComponents<'a> {
    pub fn new(
        original: &'a Original,
        scene: Option<&UnitedMesh>,
        attributes: Option<&'a Attributes>,
        component_of_face: &'a [u32],
        n: usize,
    ) -> Self {
        // Faces are grouped once, since every component is sampled several times.
        let faces = Rows::new(n, component_of_face.iter().copied().zip(0..));
        let to_mesh = original.surface.scale.to_local();
        let transforms = |component: usize| {
            let first = faces.row(component)[0];
            let (Some(scene), Some(attributes)) = (scene, attributes) else { return vec![to_mesh] };
            let transforms = scene
                .places(scene.piece_of_group(attributes.group(first)))
                .iter()
                .map(|transform| *transform * to_mesh);
            let mut transforms: Vec<DMat4> = transforms.collect();
            // Losses are judged at the largest placement, where they show most.
            transforms.sort_by(|a, b| b.determinant().abs().total_cmp(&a.determinant().abs()));
            transforms
        };
        let transforms = (0..n).map(transforms).collect();
        Self { original, attributes, faces, transforms, component_of_face }
    }

    fn faces(&self, component: usize) -> &[u32] {
        self.faces.row(component)
    }

    /// Counts vertices and faces of each component of the input.
    fn count_input(&self) -> Vec<[usize; 2]> {
        let surface = &self.original.surface;
        let mut sizes = vec![[0; 2]; self.transforms.len()];
        let mut is_counted = vec![false; surface.n_vertices()];
        for (face, &component) in surface.faces.iter().zip(self.component_of_face) {
            let [n_vertices, n_faces] = &mut sizes[component as usize];
            *n_faces += 1;
            for &v in face {
                *n_vertices += usize::from(!std::mem::replace(&mut is_counted[v as usize], true));
            }
        }
        sizes
    }

    pub fn is_locked(&self, component: usize) -> bool {
        let Original { surface, pins, .. } = self.original;
        self.faces(component).iter().any(|&face| surface.faces[face as usize].iter().any(|&v| pins.is_locked(v)))
    }

    /// Returns the corners of a face at the largest placement of its component.
    fn corners(&self, face: u32) -> Option<[DVec3; 3]> {
        let transform = self.transforms[self.component_of_face[face as usize] as usize].first()?;
        Some(self.place_corners(face, transform))
    }

    fn place_corners(&self, face: u32, transform: &DMat4) -> [DVec3; 3] {
        let surface = &self.original.surface;
        surface.faces[face as usize].map(|v| transform.transform_point3(surface.positions[v as usize].as_dvec3()))
    }

    /// Calls `visit` with each component, its faces and their corners, at all placements.
    pub fn visit_faces(&self, mut visit: impl FnMut(u32, u32, [DVec3; 3])) {
        for (component, transforms) in self.transforms.iter().enumerate() {
            for transform in transforms {
                let faces = self.faces(component).iter();
                faces.for_each(|&face| visit(component as u32, face, self.place_corners(face, transform)));
            }
        }
    }

    fn group(&self, face: u32) -> u32 {
        self.attributes.map_or(0, |attributes| attributes.group(face))
    }

    /// Measures in rendered views what a viewer would miss of each component; surfaces within `tolerance` look alike.
    pub fn exposures(&self, tolerance: f64) -> Vec<Exposure> {
        let (mut positions, mut components, mut materials) = (Vec::new(), Vec::new(), Vec::new());
        // All placements are rendered: a component may be hidden in one and visible in another.
        self.visit_faces(|component, face, corners| {
            positions.extend(corners.map(|corner| corner.as_vec3().to_array()));
            components.push(component);
            materials.push(self.group(face));
        });
        let faces: Vec<[u32; 3]> = (0..components.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let labels = Labels { components: &components, materials: &materials, n_components: self.transforms.len() };
        exposures(&positions, &faces, labels, tolerance)
    }
}

pub struct PlacedOutput {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    components: Vec<u32>,
    n_faces: Vec<usize>,
}

impl PlacedOutput {
    pub fn new(placed: &PlacedComponents, output: &Output, component_of_vertex: &[u32]) -> Self {
        let (mut positions, mut components) = (Vec::new(), Vec::new());
        let mut n_faces = vec![0; placed.transforms.len()];
        for face in output.faces() {
            let component = component_of_vertex[face[0] as usize];
            n_faces[component as usize] += 1;
            for transform in &placed.transforms[component as usize] {
                let corner = |v: u32| transform.transform_point3(output.positions[v as usize].as_dvec3());
                positions.extend(face.map(|v| corner(v).as_vec3().to_array()));
                components.push(component);
            }
        }
        let faces = (0..components.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        Self { positions, faces, components, n_faces }
    }
}

#[derive(Clone)]
struct Component {
    n_vertices: usize,
    n_faces: usize,
    /// Numbers of vertices and faces in the input.
    n_input: [usize; 2],
    /// Area weighted by importance, including the components that this one replaces.
    area: f64,
    size2: f64,
    groups: Vec<u32>,
    loss: f64,
    /// Nearest larger component, which would replace this one; else itself.
    replacement: usize,
}

pub struct Components<'a> {
    all: Vec<Component>,
    rank: Vec<usize>,
    placed: &'a PlacedComponents<'a>,
    tree: FaceTree<'a>,
    component_of_output_face: &'a [u32],
    /// Factor from prices of the collapse to prices in the scene.
    unit_of_prices: f64,
    is_painted: bool,
    is_guarded: bool,
}

impl Component {
    fn take_over(&mut self, other: &Self) {
        // A component without area has no visible loss.
        if self.area > 0.0 {
            self.loss *= (self.area + other.area) / self.area;
        }
        self.area += other.area;
    }
}

impl<'a> Components<'a> {
    pub fn new(placed: &'a PlacedComponents<'a>, seen: &'a PlacedOutput, visual: &VisualProperties) -> Self {
        let mut all = measure_components(placed, visual);
        all.iter_mut().zip(&seen.n_faces).for_each(|(component, n_faces)| component.n_faces = *n_faces);
        // Only larger components replace smaller ones, so replacements form no cycle.
        let mut by_area: Vec<usize> = (0..all.len()).collect();
        by_area.sort_by(|&x, &y| all[x].area.total_cmp(&all[y].area).then(x.cmp(&y)));
        let mut rank = vec![0; all.len()];
        by_area.iter().enumerate().for_each(|(transform, &component)| rank[component] = transform);
        let is_paint = |role: Role| matches!(role, Role::Uv | Role::Colour);
        let is_painted = visual
            .attributes
            .is_some_and(|attributes| attributes.channels.iter().any(|channel| is_paint(channel.role)));
        let tree = FaceTree::new(&seen.positions, &seen.faces);
        // Prices are squared distances times area, so the unit is the fourth power of a length.
        let unit_of_prices = placed.original.surface.scale.to_local().determinant().abs().cbrt().powi(4);
        Self {
            all,
            rank,
            placed,
            tree,
            component_of_output_face: &seen.components,
            unit_of_prices,
            is_painted,
            is_guarded: visual.is_guarded,
        }
    }

    fn find_losses(&mut self, cost: &VertexCost) {
        // Most components cost more than any could be worth; their sampling stops early.
        let most = self.most_price(cost);
        for component in 0..self.all.len() {
            (self.all[component].loss, self.all[component].replacement) = self.estimate_loss(component, most);
        }
    }

    fn most_price(&self, cost: &VertexCost) -> f64 {
        if cost.must_fit {
            f64::INFINITY
        } else {
            self.unit_of_prices * cost.price_at(self.n_target_vertices(cost.limit))
        }
    }

    fn n_target_vertices(&self, limit: Limit) -> usize {
        let n_whole: usize = self.all.iter().map(|it| it.n_vertices).sum();
        let component_of_face = n_whole as f64 * limit.faces as f64 / self.n_output_faces().max(1) as f64;
        n_whole.min(limit.vertices).min(component_of_face as usize)
    }

    /// Returns the closest output face of a larger component within `reach`, and its squared distance.
    fn nearest(&self, component: usize, point: DVec3, guess: Option<u32>, reach: f64) -> Option<(u32, f64)> {
        let rank = self.rank[component];
        self.tree.nearest_of(point, guess, reach, |face| self.rank[self.output_component(face)] > rank)
    }

    fn output_component(&self, face: u32) -> usize {
        self.component_of_output_face[face as usize] as usize
    }

    /// Estimates a component's loss, area times squared distance to the rest, and the larger component nearest to most
    /// samples.
    ///
    /// The loss is infinite for a component that is locked, not shown, the largest, or loses `most` per vertex.
    fn estimate_loss(&self, component: usize, most: f64) -> (f64, usize) {
        // Locked vertices must stay, so their component does.
        if self.placed.is_locked(component) {
            return (f64::INFINITY, component);
        }
        let faces = self.placed.faces(component);
        let own = &self.all[component];
        let some = faces.iter().step_by(faces.len().div_ceil(POINTS_PER_COMPONENT).max(1));
        let Some(points) = some.map(|&face| self.placed.corners(face)).collect::<Option<Vec<_>>>() else {
            return (f64::INFINITY, component);
        };
        let area = |corners: [DVec3; 3]| area_normal_f64(corners).length();
        let areas: f64 = points.iter().map(|&corners| area(corners)).sum();
        // The sum of areas times squared distances at which the loss per vertex is `most`.
        let most_sum = most * own.n_vertices.max(1) as f64 * areas / own.area;
        // A component that looks different is no replacement: its distance is at least half the diagonal.
        let may_look_same = !self.is_painted && own.groups.len() == 1;
        let least_of_others = 0.25 * own.size2;
        if !may_look_same && areas > 0.0 && least_of_others * areas >= SLACK * most_sum {
            return (f64::INFINITY, component);
        }
        let (mut sum, mut nearest, mut guess) = (0.0, Vec::new(), None);
        for corners in points {
            // Most components are so far from others that the search around the first point finds none.
            let reach2 = SLACK * (most_sum - sum) / area(corners);
            let reach = if reach2 >= 0.0 { reach2.sqrt() } else { f64::INFINITY };
            let found = self.nearest(component, corners.iter().sum::<DVec3>() / 3.0, guess, reach);
            let Some((face, distance2)) = found else { return (f64::INFINITY, component) };
            let other = self.output_component(face);
            let looks_same = may_look_same && own.groups == self.all[other].groups;
            let least = if looks_same { 0.0 } else { least_of_others };
            sum += area(corners) * distance2.max(least);
            nearest.push(other);
            guess = Some(face);
            if areas > 0.0 && own.area * sum / areas / own.n_vertices.max(1) as f64 >= most {
                return (f64::INFINITY, component);
            }
        }
        // The most frequent nearest component replaces this one.
        nearest.sort_unstable();
        let most = nearest.chunk_by(|a, b| a == b).max_by_key(|same| same.len()).map_or(component, |same| same[0]);
        (if areas > 0.0 { own.area * sum / areas } else { 0.0 }, most)
    }

    fn mean_error(&self) -> f64 {
        let n_faces = self.placed.component_of_face.len() as u32;
        // A sample of the faces suffices for a mean.
        let faces = (0..n_faces).step_by((n_faces as usize).div_ceil(POINTS_OF_WHOLE).max(1));
        let (mut sum, mut areas) = (0.0, 0.0);
        for corners in faces.filter_map(|face| self.placed.corners(face)) {
            let area = area_normal_f64(corners).length();
            let centre = corners.iter().sum::<DVec3>() / 3.0;
            sum += area * self.tree.nearest(centre).map_or(0.0, |(_, distance2)| distance2.sqrt());
            areas += area;
        }
        if areas > 0.0 { sum / areas } else { 0.0 }
    }

    pub fn groups(&self, component: usize) -> &[u32] {
        &self.all[component].groups
    }

    /// Returns the numbers of vertices and faces of a component of the input.
    pub fn input_size(&self, component: usize) -> [usize; 2] {
        self.all[component].n_input
    }

    pub fn is_within(&self, component: usize, within: f64) -> bool {
        // On flat faces the corners are farthest.
        let corners = || self.placed.faces(component).iter().filter_map(|&face| self.placed.corners(face)).flatten();
        let mut near = None;
        let is_near = |point: DVec3| {
            near = self.nearest(component, point, near, within).map(|(face, _)| face);
            near.is_some()
        };
        within.is_infinite() || corners().all(is_near)
    }

    fn choose(mut self, cost: &VertexCost, within: f64) -> Vec<bool> {
        let unit = self.unit_of_prices;
        let price = |it: &Component| (it.loss / it.n_vertices.max(1) as f64).to_bits();
        let mut is_dropped = vec![false; self.all.len()];
        let n_whole: usize = self.all.iter().map(|it| it.n_vertices).sum();
        let (mut n_vertices, mut n_faces) = (n_whole, self.n_output_faces());
        let asked = self.n_target_vertices(cost.limit);
        let mut rest = self.all.iter().fold([0; 2], |sum, it| [sum[0] + it.n_input[0], sum[1] + it.n_input[1]]);
        let mut guard: Option<DropGuard> = None;
        // A heap by price: the bits of a positive number are in its order.
        let mut queue: BinaryHeap<Reverse<(u64, usize)>> =
            self.all.iter().enumerate().map(|(i, it)| Reverse((price(it), i))).collect();
        while let Some(Reverse((bits, i))) = queue.pop() {
            let it = self.all[i].clone();
            let is_largest = it.replacement == i;
            // Entries go out of date when their component takes over the area of another.
            if is_dropped[i] || bits != price(&it) || is_largest {
                continue;
            }
            // Where components must go to reach the size, price is no obstacle.
            let share = |n: usize, limit: usize| n as f64 / limit as f64;
            let size = share(n_vertices, cost.limit.vertices).max(share(n_faces, cost.limit.faces));
            // Each dropped component frees vertices for the others, so the price to beat falls.
            let n_of_others = asked + (n_whole - n_vertices);
            let is_worth_its_vertices = f64::from_bits(bits) >= unit * cost.price_at(n_of_others);
            if is_worth_its_vertices && (size <= 1.0 || !cost.must_fit) {
                break;
            }
            // The vertices of dropped components go to the rest, which must have as many to give.
            let rest_without = [rest[0] - it.n_input[0], rest[1] - it.n_input[1]];
            if cost.limit.needs_more_than(rest_without, rest) {
                continue;
            }
            // Views are rendered at most once, and only if some component is cheap enough.
            if !guard.get_or_insert_with(|| DropGuard::new(&self, within)).try_drop(&self, i) {
                continue;
            }
            is_dropped[i] = true;
            rest = rest_without;
            (n_vertices, n_faces) = (n_vertices - it.n_vertices, n_faces - it.n_faces);
            // The loss of the replacement grows by the area that it takes over, so that chains of similar components
            // end.
            self.all[it.replacement].take_over(&it);
            queue.push(Reverse((price(&self.all[it.replacement]), it.replacement)));
        }
        is_dropped
    }

    fn n_output_faces(&self) -> usize {
        self.all.iter().map(|it| it.n_faces).sum()
    }
}

/// Conditions under which a component stays whatever its price.
struct DropGuard {
    within: f64,
    exposures: Option<Vec<Exposure>>,
    changed: [f32; 2],
    is_replacement: Vec<bool>,
    in_groups: BTreeMap<u32, usize>,
}

impl DropGuard {
    fn new(components: &Components, within: f64) -> Self {
        let mut guard =
            Self { within, exposures: None, changed: [0.0; 2], is_replacement: Vec::new(), in_groups: BTreeMap::new() };
        if components.is_guarded {
            // A component farther away than a multiple of the error would be missed.
            guard.within = within.min(MOST_DISTANCE * components.mean_error());
            guard.is_replacement = vec![false; components.all.len()];
            for &group in components.all.iter().flat_map(|it| &it.groups) {
                *guard.in_groups.entry(group).or_default() += 1;
            }
        }
        guard
    }

    fn try_drop(&mut self, components: &Components, i: usize) -> bool {
        // The last faces of a material must stay.
        let is_last = |group: &u32| self.in_groups.get(group).is_some_and(|n| *n < 2);
        if components.all[i].groups.iter().any(is_last) || !components.is_within(i, self.within) {
            return false;
        }
        if !components.is_guarded {
            return true;
        }
        // Views are rendered last, since they take longest.
        let exposures = self.exposures.get_or_insert_with(|| components.placed.exposures(self.within));
        let Exposure { changed, opened, recoloured, replacements, .. } = &mut exposures[i];
        // Many small losses add up, so their sum is bounded as well.
        let all = [self.changed[0] + *changed, self.changed[1] + *recoloured];
        let is_missed =
            *changed > MOST_CHANGED[0] || *opened > MOST_OPENED || all[0] > MOST_CHANGED[1] || all[1] > MOST_RECOLOURED;
        if is_missed || self.is_replacement[i] {
            return false;
        }
        self.changed = all;
        // Components that appear in place of this one must stay from now on.
        std::mem::take(replacements)
            .into_iter()
            .for_each(|replacement| self.is_replacement[replacement as usize] = true);
        for group in &components.all[i].groups {
            self.in_groups.entry(*group).and_modify(|n| *n -= 1);
        }
        true
    }
}

fn measure_components(placed: &PlacedComponents, visual: &VisualProperties) -> Vec<Component> {
    let surface = &placed.original.surface;
    // Importance weights the areas only if the caller or visibility set it.
    let factor = |v: &u32| surface.importance.get(*v as usize).copied().unwrap_or(1.0);
    let face_weight =
        |face: &[u32; 3]| if visual.is_weighed { face.iter().map(factor).sum::<f32>() / 3.0 } else { 1.0 };
    let n_input = placed.count_input();
    let of_component = |component: usize| {
        let n_input = n_input[component];
        let (mut area, mut low, mut high) = (0.0, DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut groups = Vec::new();
        for &face in placed.faces(component) {
            let group = placed.group(face);
            groups.extend((groups.last() != Some(&group)).then_some(group));
            let Some(corners) = placed.corners(face) else { continue };
            let weight = face_weight(&surface.faces[face as usize]);
            area += 0.5 * area_normal_f64(corners).length() * f64::from(weight);
            low = corners.into_iter().fold(low, DVec3::min);
            high = corners.into_iter().fold(high, DVec3::max);
        }
        groups.sort_unstable();
        groups.dedup();
        let size2 = low.distance_squared(high);
        Component { n_vertices: 0, n_faces: 0, n_input, area, size2, groups, loss: 0.0, replacement: component }
    };
    (0..placed.transforms.len()).map(of_component).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::pins::Pins;

    const SHRUNK: f32 = 0.4;

    fn spheres(transforms: &[f32], r: f32) -> TriMesh {
        let (large, small) = (shapes::icosphere(3), shapes::icosphere(0));
        let small = |x: &f32| shapes::place(&small, |p| [r * p[0] + x, r * p[1], r * p[2]]);
        shapes::unite([large].into_iter().chain(transforms.iter().map(small)))
    }

    fn drop_from(
        mesh: &TriMesh,
        pass_prices: f64,
        within: f64,
        attributes: Option<&Attributes>,
    ) -> Option<DroppedFaces> {
        let original = Original::bare(mesh);
        let surface = &original.surface;
        let n_large = shapes::icosphere(3).positions().len();
        let centre = surface.positions[..n_large].iter().sum::<glam::Vec3>() / n_large as f32;
        let moved = |(v, p): (usize, &glam::Vec3)| if v < n_large { centre + SHRUNK * (*p - centre) } else { *p };
        let positions = surface.positions.iter().enumerate().map(moved).collect();
        let vertex_of = (0..surface.n_vertices() as u32).collect();
        let output = Output::new(Pulse::NONE, positions, surface.faces.to_vec(), Pins::default(), vertex_of);
        let n = mesh.positions().len();
        let pass_prices = [(n + 50, pass_prices as f32)];
        let cost = VertexCost { pass_prices: &pass_prices, limit: Limit::from_vertices(n_large), must_fit: false };
        let alike = Attributes { groups: vec![0; surface.faces.len()], ..Attributes::default() };
        let attributes = Some(attributes.unwrap_or(&alike));
        choose_dropped(
            &original,
            &output,
            &cost,
            within,
            &VisualProperties { attributes, scene: None, is_weighed: false, is_guarded: true },
        )
    }

    fn price(mesh: &TriMesh, attributes: Option<&Attributes>) -> f64 {
        let goes = |pass_prices: f64| drop_from(mesh, pass_prices, f64::INFINITY, attributes).is_some();
        let (mut low, mut high) = (1e-30f64, 1e3f64);
        assert!(!goes(low) && goes(high));
        while high / low > 1.001 {
            let middle = (low * high).sqrt();
            *(if goes(middle) { &mut high } else { &mut low }) = middle;
        }
        high / f64::from(Original::bare(mesh).surface.length(1.0)).powi(4)
    }

    #[test]
    fn a_component_is_dropped_at_its_area_times_squared_distance() {
        // Twice the radius means four times the area at about the same distance.
        let [one, two] = [0.01, 0.02].map(|r| price(&spheres(&[3.0], r), None));
        assert!((3.9..4.1).contains(&(two / one)), "{}", two / one);
        // At distances of 2 and 4 from the shrunken sphere.
        let [near, far] = [2.4, 4.4].map(|x| price(&spheres(&[x], 0.01), None));
        assert!((3.8..4.2).contains(&(far / near)), "{}", far / near);
    }

    #[test]
    fn the_last_component_of_a_material_stays_and_others_cost_their_size() {
        let n = shapes::icosphere(3).faces().len();
        let groups = |mesh: &TriMesh, other| {
            let groups = (0..mesh.faces().len()).map(|f| if f < n { 1 } else { other }).collect();
            Attributes { groups, ..Attributes::default() }
        };
        let [one, two] = [&[0.41][..], &[0.41, -0.41]].map(|transforms| spheres(transforms, 0.02));
        assert!(drop_from(&one, 1e3, f64::INFINITY, Some(&groups(&one, 1))).is_some());
        assert!(drop_from(&one, 1e3, f64::INFINITY, Some(&groups(&one, 2))).is_none());
        let [same, other] = [1, 2].map(|group| price(&two, Some(&groups(&two, group))));
        assert!(other > 2.0 * same, "{other} {same}");
    }

    #[test]
    fn distant_components_stay() {
        let mesh = spheres(&[3.0], 0.01);
        assert!(drop_from(&mesh, 1e3, 2.5, None).is_none());
        let dropped = drop_from(&mesh, 1e3, 2.7, None).unwrap();
        let large = shapes::icosphere(3).faces().len();
        assert!(dropped.n_components == 1 && dropped.faces.iter().enumerate().all(|(f, gone)| *gone == (f >= large)));
        // More than eight times the distance between result and original.
        assert!(drop_from(&spheres(&[6.0], 0.01), 1e3, f64::INFINITY, None).is_none());
    }

    #[test]
    fn visible_components_stay_at_any_price() {
        assert!(drop_from(&spheres(&[2.0], 0.1), 1e30, f64::INFINITY, None).is_none());
        assert!(drop_from(&spheres(&[2.0], 0.01), 1e30, f64::INFINITY, None).is_some());
        assert!(drop_from(&spheres(&[], 0.0), 1e30, f64::INFINITY, None).is_none());
        // Each changes a few pixels; all together may change at most a hundredth.
        let many: Vec<f32> = (0..120).map(|i| 1.2 + 0.03 * i as f32).collect();
        let n_dropped = drop_from(&spheres(&many, 0.012), 1e30, f64::INFINITY, None).map_or(0, |it| it.n_components);
        assert!((10..110).contains(&n_dropped), "{n_dropped}");
    }
}
