//! What the closed assembly is asked: plain data, resolved by the driver before anything runs.

use crate::mesh::{Attributes, Frame, KeptEdge, Role, United};
use crate::model::Weights;
use crate::simplify::options::{Options, Parts, Purpose};

use super::aim::Aim;

/// What the closed assembly is asked.
pub struct Request<'a> {
    /// How much more than its area each vertex of the mesh counts.
    pub importance: Importance<'a>,
    /// Whether each vertex of the mesh is one that does not show, and counts little; empty where all show.
    pub hidden: &'a [bool],
    /// What the result is to be near in.
    pub aim: Aim,
    /// What is done beside the collapse.
    pub parts: Parts,
    /// How the result will be written.
    pub frame: Frame,
    /// Whether the result is to be known as a function of the positions.
    pub differentiable: bool,
    /// What has to stay.
    pub keep: Keep<'a>,
    /// Whether the collapse goes on to the size although held vertices leave few to the rest.
    pub insists_on_size: bool,
    /// Where no merge may cost more, squared distance times area in the unit of the mesh: then that alone ends the collapse.
    pub price: Option<f64>,
}

/// What counts of a component beside its shape.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown<'a> {
    /// What corners and faces carry.
    pub attributes: Option<&'a Attributes>,
    /// Where a viewer sees the mesh, if it unites those of a scene.
    pub scene: Option<&'a United>,
    /// Whether areas count by the importance of the vertices: where it was asked for, and not told by the network.
    pub is_weighed: bool,
}

impl<'a> Request<'a> {
    /// Whether edges are flipped after the collapse.
    pub fn flips(&self) -> bool {
        self.parts.flips && self.aim.steps > 0
    }

    /// Whether vertices move toward the original after that.
    pub fn fits(&self) -> bool {
        self.parts.fit && self.aim.steps > 0 && !self.keep.subset
    }

    /// By what components count.
    pub fn shown(&self) -> Shown<'a> {
        let is_weighed = matches!(self.importance, Importance::Given(_)) || !self.hidden.is_empty();
        Shown { attributes: self.keep.attributes, scene: self.keep.scene, is_weighed }
    }
}

/// What has to stay of a mesh beside its shape.
#[derive(Clone, Copy, Debug, Default)]
pub struct Keep<'a> {
    /// Edges that stay edges, over vertices of the mesh: seams and creases, ascending.
    pub edges: &'a [KeptEdge],
    /// Whether each vertex stays where it is; empty where all may go.
    pub locked: &'a [bool],
    /// Whether each face comes back as it is; empty where none has to. Their vertices are locked.
    pub kept: &'a [bool],
    /// Whether the vertices of the result have to be vertices of the mesh.
    pub subset: bool,
    /// What the result is for.
    pub purpose: Purpose,
    /// What corners and faces carry.
    pub attributes: Option<&'a Attributes>,
    /// Whether it is to be known where on the mesh the result's corners stand.
    pub map: bool,
    /// Where a viewer sees the mesh, if it unites those of a scene.
    pub scene: Option<&'a United>,
    /// Distance from the mesh that was asked for, in the unit of the scene; 0 where none was.
    pub allowed_distance: f64,
    /// Where components may be dropped that cost more than a viewer would miss.
    pub drop: Option<DropRules>,
    /// Where the mesh is one half of a mirrored one; then sizes are those of the whole.
    pub half: Option<Half<'a>>,
}

impl<'a> Keep<'a> {
    /// What options and kept faces say by themselves.
    pub fn of(options: &Options, kept: &'a [bool]) -> Self {
        let allowed_distance = if options.prune_within.is_finite() { options.prune_within } else { 0.0 };
        let Options { subset, purpose, map, .. } = *options;
        Self { kept, subset, purpose, map, allowed_distance, ..Self::default() }
    }

    /// Whether the mesh is one that people look at, part of a scene or with something at its corners and faces, and no bare shape.
    pub fn is_asset(&self) -> bool {
        self.scene.is_some() || self.attributes.is_some()
    }

    /// The piece of the scene that a face of the mesh belongs to; 0 of a mesh that is none.
    pub fn piece_of(&self, face: u32) -> usize {
        let of = |scene: &United| scene.piece_of(self.attributes.unwrap_or(Attributes::NONE).group(face));
        self.scene.map_or(0, of)
    }

    /// The attributes whose morph targets are poses that count.
    pub fn posed(&self) -> Option<&'a Attributes> {
        let has_targets = |of: &&Attributes| of.channels.iter().any(|channel| channel.role == Role::MorphPosition);
        self.attributes.filter(|_| self.purpose == Purpose::Poses).filter(has_targets)
    }
}

/// Which components of a mesh may be dropped.
#[derive(Clone, Copy, Debug)]
pub struct DropRules {
    /// Largest distance from what stays, in the unit of the scene.
    pub within: f64,
    /// First level of detail at which it is decided; at those before it was decided already.
    pub from_level: usize,
}

/// Which vertices of a mesh lie on the plane across an axis along which the mesh is one half.
#[derive(Clone, Copy, Debug)]
pub struct Half<'a> {
    /// The axis: 0, 1 or 2.
    pub axis: usize,
    /// Whether each vertex lies on the cut, n_vertices; such a vertex has an edge of the cut.
    pub on_plane: &'a [bool],
}

/// How much more than its area each vertex counts.
#[derive(Clone, Copy, Debug)]
pub enum Importance<'a> {
    /// All count alike.
    Even,
    /// More where the surface bends.
    Bending,
    /// From the Point Sampler of this network.
    Network(&'a Weights),
    /// One positive factor per vertex of the mesh.
    Given(&'a [f32]),
}
