//! The tree that Bevy's shaders walk: nodes of up to eight children, leaves of up to 254 meshlets.

use crate::clusters::Sphere;
use crate::mesh::value_bytes::Stored;
use crate::spatial::Bounds;

use super::numbers::center_and_half;

const WIDTH: usize = 8;
/// Stored count of a child that is a node.
const IS_NODE: u8 = u8::MAX;

/// Clusters of one group.
#[derive(Clone)]
pub struct Leaf {
    pub level: u32,
    pub bounds: Bounds,
    pub sphere: Sphere,
    /// Error of what takes the place of these clusters.
    pub error: f32,
    /// Number of the first meshlet.
    pub first: u32,
    pub n_meshlets: u8,
}

#[derive(Clone)]
struct Child {
    bounds: Bounds,
    sphere: Sphere,
    error: f32,
    offset: u32,
    count: u8,
    /// Levels of nodes below this one.
    depth: u32,
}

pub struct BoundsTree {
    nodes: Vec<Vec<Child>>,
    depth: u32,
}

impl BoundsTree {
    /// Builds a tree for each level of the hierarchy, and one over these.
    ///
    /// The shaders leave a subtree if its largest error is small, so levels of similar error belong together.
    pub fn new(mut leaves: Vec<Leaf>) -> Self {
        leaves.sort_by_key(|leaf| leaf.level);
        // Node 0 is the root, which is known last.
        let mut tree = Self { nodes: vec![Vec::new()], depth: 1 };
        let mut roots = Vec::new();
        for leaves in leaves.chunk_by(|x, y| x.level == y.level) {
            let children: Vec<Child> = leaves.iter().map(Child::from_leaf).collect();
            roots.push(tree.join(children));
        }
        let root = if roots.len() > WIDTH { tree.group(roots) } else { roots };
        tree.depth = 1 + root.iter().map(|child| child.depth).max().unwrap_or(0);
        tree.nodes[0] = root;
        tree
    }

    /// Joins children under one.
    fn join(&mut self, children: Vec<Child>) -> Child {
        let mut children = self.group(children);
        if children.len() == 1 { children.remove(0) } else { self.add_node(children) }
    }

    /// Joins children under at most eight.
    fn group(&mut self, mut children: Vec<Child>) -> Vec<Child> {
        if children.len() <= WIDTH {
            return children;
        }
        sort_along_longest_axis(&mut children);
        let n = children.len();
        (0..WIDTH)
            .map(|part| {
                let part = children[n * part / WIDTH..n * (part + 1) / WIDTH].to_vec();
                self.join(part)
            })
            .collect()
    }

    fn add_node(&mut self, children: Vec<Child>) -> Child {
        let bounds = children.iter().fold(Bounds::EMPTY, |all, child| all.union(&child.bounds));
        let child = Child {
            bounds,
            sphere: Sphere::enclose(children.iter().map(|child| child.sphere)),
            error: children.iter().map(|child| child.error).fold(0.0, f32::max),
            offset: self.nodes.len() as u32,
            count: IS_NODE,
            depth: 1 + children.iter().map(|child| child.depth).max().unwrap_or(0),
        };
        self.nodes.push(children);
        child
    }

    pub fn bounds(&self) -> Bounds {
        self.nodes[0].iter().fold(Bounds::EMPTY, |all, child| all.union(&child.bounds))
    }

    /// Returns the number of levels of nodes.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    pub fn write(&self, content: &mut Vec<u8>) {
        self.nodes.len().write(content);
        self.nodes.iter().for_each(|children| write_node(children, content));
    }
}

impl Child {
    fn from_leaf(leaf: &Leaf) -> Self {
        let &Leaf { bounds, sphere, error, first, n_meshlets, .. } = leaf;
        Self { bounds, sphere, error, offset: first, count: n_meshlets, depth: 0 }
    }
}

fn sort_along_longest_axis(children: &mut [Child]) {
    let center = |child: &Child, axis: usize| 0.5 * child.bounds.low[axis] + 0.5 * child.bounds.high[axis];
    let extent = |axis: usize| {
        let centers = children.iter().map(|child| center(child, axis));
        centers.clone().fold(f32::MIN, f32::max) - centers.fold(f32::MAX, f32::min)
    };
    let axis = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    children.sort_by(|a, b| center(a, axis).total_cmp(&center(b, axis)));
}

fn write_node(children: &[Child], content: &mut Vec<u8>) {
    let begin = content.len();
    for child in children {
        let (center, half) = center_and_half(&child.bounds);
        ((center, child.error), (half, child.offset)).write(content);
    }
    content.resize(begin + 32 * WIDTH, 0);
    children.iter().for_each(|child| child.sphere.write(content));
    content.resize(begin + 48 * WIDTH, 0);
    content.extend(children.iter().map(|child| child.count));
    content.resize(begin + 50 * WIDTH, 0);
}
