//! Requests to the closed assembly.

use crate::mesh::{Attributes, FeatureEdge, Frame, Role, UnitedMesh};
use crate::model::Weights;
use crate::simplify::options::{ClosedOptions, Purpose, Refinements};

use super::stage_settings::StageSettings;

pub struct ClosedRequest<'a> {
    pub importance: Importance<'a>,
    pub hidden: &'a [bool],
    pub settings: StageSettings,
    pub refinements: Refinements,
    pub frame: Frame,
    pub differentiable: bool,
    pub requirements: Requirements<'a>,
    pub forces_size: bool,
    /// Largest price of a merge, in mesh units to the fourth power; replaces the size limit.
    pub price: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct VisualProperties<'a> {
    pub attributes: Option<&'a Attributes>,
    pub scene: Option<&'a UnitedMesh>,
    /// True if areas are weighted by the caller or by visibility.
    pub is_weighed: bool,
}

impl<'a> ClosedRequest<'a> {
    pub fn runs_flips(&self) -> bool {
        self.refinements.flips && self.settings.steps > 0
    }

    pub fn runs_fit(&self) -> bool {
        self.refinements.fit && self.settings.steps > 0 && !self.requirements.subset
    }

    pub fn visual_properties(&self) -> VisualProperties<'a> {
        // Scores of a formula or network are not the caller's judgement of what matters.
        let is_weighed = matches!(self.importance, Importance::Given(_)) || !self.hidden.is_empty();
        VisualProperties { attributes: self.requirements.attributes, scene: self.requirements.scene, is_weighed }
    }
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Requirements<'a> {
    pub edges: &'a [FeatureEdge],
    pub locked: &'a [bool],
    pub kept: &'a [bool],
    pub subset: bool,
    pub purpose: Purpose,
    pub attributes: Option<&'a Attributes>,
    pub map: bool,
    pub scene: Option<&'a UnitedMesh>,
    pub allowed_distance: f64,
    pub drop: Option<DropRules>,
    pub half: Option<Half<'a>>,
}

impl<'a> Requirements<'a> {
    pub fn from_options(options: &ClosedOptions, kept: &'a [bool]) -> Self {
        // An infinite limit allows components to be dropped, but deformed only within the usual limits.
        let allowed_distance = if options.prune_within.is_finite() { options.prune_within } else { 0.0 };
        let ClosedOptions { subset, purpose, map, .. } = *options;
        Self { kept, subset, purpose, map, allowed_distance, ..Self::default() }
    }

    pub fn is_asset(&self) -> bool {
        self.scene.is_some() || self.attributes.is_some()
    }

    pub fn piece_of_face(&self, face: u32) -> usize {
        let of = |scene: &UnitedMesh| scene.piece_of_group(self.attributes.unwrap_or(Attributes::NONE).group(face));
        self.scene.map_or(0, of)
    }

    pub fn pose_attributes(&self) -> Option<&'a Attributes> {
        let has_targets = |of: &&Attributes| of.channels.iter().any(|channel| channel.role == Role::MorphPosition);
        self.attributes.filter(|_| self.purpose == Purpose::Poses).filter(has_targets)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct DropRules {
    pub within: f64,
    pub from_level: usize,
}

#[derive(Clone, Copy, Debug)]
pub struct Half<'a> {
    pub axis: usize,
    /// Marks vertices on the cut, n_vertices; each is on a cut edge.
    pub on_plane: &'a [bool],
}

/// Source of vertex importance, a factor on each vertex's area.
#[derive(Clone, Copy, Debug)]
pub enum Importance<'a> {
    /// 1 for every vertex.
    Even,
    /// More where the surface bends.
    Bending,
    /// Scores of this network's Point Sampler.
    Network(&'a Weights),
    /// One positive factor per mesh vertex.
    Given(&'a [f32]),
}
