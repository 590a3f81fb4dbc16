//! Requests to the closed assembly.

use crate::mesh::{Attributes, FeatureEdge, Frame, Role, UnitedMesh};
use crate::model::Weights;
use crate::simplify::hidden::visible_shares;
use crate::simplify::input::{Half, Input, kept_edges, locked_vertices};
use crate::simplify::options::{ClosedOptions, Purpose, ScoreSource};

use super::stage_settings::StageSettings;

/// Added to the visible share of a surface, for surfaces that no view shows.
const LEAST_SHARE: f32 = 0.05;
/// Power of the visible share in the importance of a vertex.
// At a ratio of 0.1, FLIP errors of twelve bare meshes are 1 % smaller with 2, those of eleven textured ones 3 % larger,
// and distances 6 % larger on both; with 1, FLIP errors of the bare meshes are 1 % larger.
const SHARE_EXPONENT: f32 = 1.5;

/// Options and weights of a run, and settings that callers outside of the crate cannot make.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    pub options: &'a ClosedOptions,
    pub weights: Option<&'a Weights>,
    pub differentiable: bool,
    /// True to reach the size even where too few vertices are free to keep the shape.
    pub forces_size: bool,
}

impl<'a> Task<'a> {
    pub fn new(options: &'a ClosedOptions, weights: Option<&'a Weights>) -> Self {
        Self { options, weights, differentiable: false, forces_size: false }
    }

    /// Chooses the source of vertex scores: none if without effect, the network if the caller gives weights.
    fn score_source(&self, settings: &StageSettings) -> ScoreSource {
        match self.options.scores {
            // The purpose Poses distributes the vertices by a term of its own, so scores need given weights there.
            _ if settings.strength == 0.0 || self.options.purpose != Purpose::Shape && self.weights.is_none() => {
                ScoreSource::Geometry
            }
            ScoreSource::Bending if self.weights.is_some() => ScoreSource::Network,
            scores => scores,
        }
    }
}

pub struct ClosedRequest<'a> {
    pub importance: Importance<'a>,
    pub scores: ScoreSource,
    /// Factor on the importance of each vertex by how much of it is visible; empty for none.
    pub visibility: Vec<f32>,
    pub settings: StageSettings,
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
    /// True if only components that no viewer would miss may be dropped.
    pub is_guarded: bool,
}

impl<'a> ClosedRequest<'a> {
    /// Plans a run: options, constraints and weights become one request.
    pub fn new(input: &Input<'a>, task: &Task<'a>) -> Self {
        let request = Self::without_visibility(input, task);
        Self { visibility: visibility(input, &request.settings), ..request }
    }

    /// Plans a run in which nothing is collapsed, so that vertices need no importance.
    pub fn without_visibility(input: &Input<'a>, task: &Task<'a>) -> Self {
        let Task { options, weights, differentiable, forces_size } = *task;
        let settings = StageSettings::new(options.optimize, options.effort);
        let scores = task.score_source(&settings);
        let importance = match scores {
            // The caller's importance overrules any score.
            _ if !input.importance.is_empty() => Importance::Given(input.importance),
            ScoreSource::Network => Importance::Network(weights.unwrap_or_else(|| Weights::shipped_default())),
            ScoreSource::Bending => Importance::Bending,
            ScoreSource::Geometry => Importance::Even,
        };
        Self {
            importance,
            scores,
            visibility: Vec::new(),
            settings,
            frame: options.frame,
            differentiable,
            requirements: Requirements::new(input, options),
            forces_size,
            price: None,
        }
    }

    /// Returns whether components go by what viewers see of them where a size is out of reach.
    pub fn drops_by_views(&self) -> bool {
        self.requirements.hold_shape.is_none() && self.visual_properties().is_guarded
    }

    pub fn runs_flips(&self) -> bool {
        self.settings.steps > 0
    }

    pub fn runs_fit(&self) -> bool {
        self.settings.steps > 0 && !self.requirements.subset
    }

    pub fn visual_properties(&self) -> VisualProperties<'a> {
        // Scores of a formula or network are not the caller's judgement of what matters.
        let is_weighed = matches!(self.importance, Importance::Given(_)) || !self.visibility.is_empty();
        let is_guarded = self.requirements.is_asset() || self.settings.by_looks;
        let Requirements { attributes, scene, .. } = self.requirements;
        VisualProperties { attributes, scene, is_weighed, is_guarded }
    }
}

fn visibility(input: &Input, settings: &StageSettings) -> Vec<f32> {
    if !settings.by_looks {
        return Vec::new();
    }
    visible_shares(input).into_iter().map(|share| (share + LEAST_SHARE).powf(SHARE_EXPONENT)).collect()
}

#[derive(Debug, Default)]
pub struct Requirements<'a> {
    pub edges: Vec<FeatureEdge>,
    pub locked: Vec<bool>,
    pub kept: &'a [bool],
    pub subset: bool,
    pub purpose: Purpose,
    pub attributes: Option<&'a Attributes>,
    pub map: bool,
    pub scene: Option<&'a UnitedMesh>,
    pub allowed_distance: f64,
    /// Deformation of a component, over the scene's diagonal, that no size may exceed; `None` for no such limit.
    pub hold_shape: Option<f64>,
    /// Largest distance from the rest at which components may be dropped; `None` if all must stay.
    pub drops_within: Option<f64>,
    pub half: Option<Half<'a>>,
}

impl<'a> Requirements<'a> {
    fn new(input: &Input<'a>, options: &ClosedOptions) -> Self {
        let ClosedOptions { subset, purpose, map, prune_within, hold_shape, .. } = *options;
        // Constraints of the caller name vertices or faces that must remain.
        let is_constrained = subset || options.lock_boundaries || !input.locked.is_empty() || input.half.is_some();
        Self {
            edges: kept_edges(input.mesh, input.attributes, options),
            locked: locked_vertices(input, options),
            kept: input.kept,
            subset,
            purpose,
            attributes: Some(input.attributes).filter(|attributes| !attributes.is_empty()),
            map,
            scene: input.scene,
            // An infinite limit allows components to be dropped, but deformed only within the usual limits.
            allowed_distance: if prune_within.is_finite() { prune_within } else { 0.0 },
            hold_shape,
            drops_within: (options.prune && !is_constrained).then_some(prune_within),
            half: input.half,
        }
    }

    pub fn is_asset(&self) -> bool {
        self.scene.is_some() || self.attributes.is_some()
    }

    pub fn has_normals(&self) -> bool {
        let channels = self.attributes.iter().flat_map(|attributes| &attributes.channels);
        channels.into_iter().any(|channel| channel.role == Role::Normal && channel.width == 3)
    }

    pub fn piece_of_face(&self, face: u32) -> usize {
        let find_piece =
            |scene: &UnitedMesh| scene.piece_of_group(self.attributes.unwrap_or(Attributes::NONE).group(face));
        self.scene.map_or(0, find_piece)
    }

    /// Returns the scene piece of a face, or the first piece with the same instances.
    pub fn pieces_placed_alike(&self) -> impl Fn(u32) -> usize {
        let alike = self.scene.map_or_else(|| vec![0], UnitedMesh::pieces_placed_alike);
        move |face| alike[self.piece_of_face(face)]
    }

    pub fn pose_attributes(&self) -> Option<&'a Attributes> {
        let has_targets = |of: &&Attributes| of.channels.iter().any(|channel| channel.role == Role::MorphPosition);
        self.attributes.filter(|_| self.purpose == Purpose::Poses).filter(has_targets)
    }
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
