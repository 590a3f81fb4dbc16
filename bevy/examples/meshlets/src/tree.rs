//! The tree of boxes and spheres, with the checks that Bevy's own processor makes of its trees.

use crate::content::{Array, Content, f32_at, u32_at};

const WIDTH: usize = 8;
/// Stored count of a child that is a node.
const IS_NODE: u8 = u8::MAX;
/// Largest rounding of spheres and boxes, as a fraction of the size of the mesh; Bevy allows 0.0001 of a unit.
const ROUNDING: f32 = 1e-5;

/// Box, sphere and error of a node, a leaf or a meshlet.
#[derive(Clone, Copy)]
pub struct Bounds {
    center: [f32; 3],
    half: [f32; 3],
    sphere: [f32; 4],
    pub error: f32,
}

/// A child of a node: another node, or the meshlets of a leaf.
pub struct Child {
    bounds: Bounds,
    first: usize,
    /// Number of meshlets; `None` for a node.
    n_meshlets: Option<u8>,
}

/// The nodes, the root first.
pub struct Tree {
    nodes: Vec<Vec<Child>>,
    meshlets: Vec<Bounds>,
    /// Largest coordinate of the mesh.
    reach: f32,
}

impl Bounds {
    fn new(boxed: &[u8], sphere: &[u8]) -> Self {
        Self {
            center: std::array::from_fn(|k| f32_at(boxed, 4 * k)),
            half: std::array::from_fn(|k| f32_at(boxed, 16 + 4 * k)),
            sphere: std::array::from_fn(|k| f32_at(sphere, 4 * k)),
            error: f32_at(boxed, 12),
        }
    }

    /// Returns whether a box, a sphere and an error are within these.
    fn contain(&self, inner: &Self, rounding: f32) -> bool {
        let is_inside = |k: usize| (self.center[k] - inner.center[k]).abs() + inner.half[k] <= self.half[k] + rounding;
        let distance = (0..3).map(|k| (self.sphere[k] - inner.sphere[k]).powi(2)).sum::<f32>().sqrt();
        (0..3).all(is_inside) && distance + inner.sphere[3] <= self.sphere[3] + rounding && inner.error <= self.error
    }

    /// Returns whether a point is in the box.
    pub fn has_point(&self, point: [f32; 3], rounding: f32) -> bool {
        (0..3).all(|k| (point[k] - self.center[k]).abs() <= self.half[k] + rounding)
    }
}

impl Tree {
    /// Reads nodes and bounds of meshlets.
    ///
    /// # Errors
    /// Message about a child that does not exist.
    pub fn new(content: &Content) -> Result<Self, String> {
        let nodes: Vec<_> = (0..content.count(Array::Nodes)).map(|k| read_node(content.row(Array::Nodes, k))).collect();
        let meshlets: Vec<_> = (0..content.count(Array::CullData))
            .map(|k| content.row(Array::CullData, k))
            .map(|row| Bounds::new(row, &row[32..]))
            .collect();
        let bounds = content.bounds();
        let reach = (0..3).map(|k| bounds[k].abs() + bounds[k + 3]).fold(0.0, f32::max);
        let tree = Self { nodes, meshlets, reach };
        tree.check_children()?;
        let n_levels = tree.count_levels().ok_or("the root does not lead to all nodes")?;
        if n_levels != content.depth() {
            return Err(format!("{n_levels} levels of nodes, {} stored", content.depth()));
        }
        let is_inside = |child: &Child| {
            let (center, half) = (child.bounds.center, child.bounds.half);
            (0..3).all(|k| (center[k] - bounds[k]).abs() + half[k] <= bounds[k + 3] + tree.rounding())
        };
        let is_valid = tree.nodes[0].iter().all(is_inside);
        is_valid.then_some(tree).ok_or_else(|| "the root is outside the box of the mesh".to_string())
    }

    pub fn meshlets(&self) -> &[Bounds] {
        &self.meshlets
    }

    /// Returns the largest rounding of a coordinate.
    pub fn rounding(&self) -> f32 {
        ROUNDING * self.reach
    }

    /// Checks that each node but the root is the child of one node, and each meshlet of one leaf.
    fn check_children(&self) -> Result<(), String> {
        let (mut n_parents, mut n_leaves) = (vec![0; self.nodes.len()], vec![0; self.meshlets.len()]);
        for child in self.nodes.iter().flatten() {
            let (counts, n) = match child.n_meshlets {
                Some(n) => (&mut n_leaves, usize::from(n)),
                None => (&mut n_parents, 1),
            };
            let range = counts.get_mut(child.first..child.first + n).ok_or("a child does not exist")?;
            range.iter_mut().for_each(|count| *count += 1);
        }
        let is_tree = n_parents.first() == Some(&0) && n_parents[1..].iter().all(|&n| n == 1);
        (is_tree && n_leaves.iter().all(|&n| n == 1))
            .then_some(())
            .ok_or_else(|| "not every node and meshlet has one parent".to_string())
    }

    /// Returns the number of levels of nodes; `None` if the root does not lead to all nodes.
    fn count_levels(&self) -> Option<u32> {
        let (mut level, mut n_levels, mut n_reached) = (vec![0], 0, 0);
        while !level.is_empty() {
            (n_levels, n_reached) = (n_levels + 1, n_reached + level.len());
            let children = level.iter().flat_map(|&node| &self.nodes[node]);
            level = children.filter(|child| child.n_meshlets.is_none()).map(|child| child.first).collect();
        }
        (n_reached == self.nodes.len()).then_some(n_levels)
    }

    /// Checks that boxes, spheres and errors contain those below them.
    ///
    /// # Errors
    /// Message about the first that do not.
    pub fn check_bounds(&self) -> Result<(), String> {
        for child in self.nodes.iter().flatten() {
            let inner: Vec<Bounds> = match child.n_meshlets {
                Some(n) => self.meshlets[child.first..][..usize::from(n)].to_vec(),
                None => self.nodes[child.first].iter().map(|child| child.bounds).collect(),
            };
            if !inner.iter().all(|inner| child.bounds.contain(inner, self.rounding())) {
                return Err(format!("bounds of a child of {} do not contain those below", child.first));
            }
        }
        Ok(())
    }

    /// Walks the tree as Bevy's shaders do for a camera without perspective; returns the meshlets they draw.
    pub fn list_drawn(&self, smallest_visible: f32) -> Vec<usize> {
        let is_small = |error: f32| error < smallest_visible;
        let (mut pending, mut drawn) = (vec![0], Vec::new());
        while let Some(node) = pending.pop() {
            for child in self.nodes[node].iter().filter(|child| !is_small(child.bounds.error)) {
                match child.n_meshlets {
                    Some(n) => drawn.extend(child.first..child.first + usize::from(n)),
                    None => pending.push(child.first),
                }
            }
        }
        drawn.retain(|&meshlet| is_small(self.meshlets[meshlet].error));
        drawn
    }
}

fn read_node(row: &[u8]) -> Vec<Child> {
    let children = (0..WIDTH).filter(|child| row[384 + child] > 0);
    children
        .map(|child| {
            let boxed = &row[32 * child..];
            Child {
                bounds: Bounds::new(boxed, &row[256 + 16 * child..]),
                first: u32_at(boxed, 28) as usize,
                n_meshlets: Some(row[384 + child]).filter(|&count| count != IS_NODE),
            }
        })
        .collect()
}
