//! Rules of prices and merges beyond planes: constraints, attributes and poses.

use super::attribute_quadrics::AttributeQuadrics;
use super::constraints::Constraints;
use super::pair::{CollapseVertex, MergedVertex, Pair};
use super::poses::Poses;

#[derive(Clone, Default)]
pub(super) struct Rules {
    pub constraints: Option<Constraints>,
    pub attributes: AttributeQuadrics,
    pub poses: Poses,
}

impl Rules {
    #[inline(always)]
    pub fn pair(&self, [u, v]: [&CollapseVertex; 2]) -> Pair {
        let mut pair = Pair::new(u, v);
        // Each contribution is a quadric of the merged position, so one minimum serves all.
        let ids = [u.id, v.id];
        if !self.poses.is_empty() {
            pair.sum = self.poses.mean_price(ids, pair.other(), pair.sum);
        }
        if !self.attributes.is_empty() {
            pair.sum += self.attributes.price(ids, pair.other());
        }
        if let Some(constraints) = &self.constraints {
            pair.sum += constraints.planes_on_held_curves(ids, u.position.as_dvec3());
        }
        pair
    }

    #[inline(always)]
    pub fn placement(&self, [u, v]: [&CollapseVertex; 2], pair: &Pair) -> Option<MergedVertex> {
        match &self.constraints {
            None => Some(pair.placement()),
            Some(constraints) => constraints.placement([u.id, v.id], u.position.as_dvec3(), pair),
        }
    }

    pub fn price(&self, nodes: [&CollapseVertex; 2]) -> f32 {
        let merged = self.placement(nodes, &self.pair(nodes));
        merged.map_or(f32::INFINITY, |merged| merged.price as f32)
    }
}
