//! Requests to the closed assembly.

use crate::mesh::{Attributes, FeatureEdge, Role, UnitedMesh};
use crate::simplify::hidden::visible_shares;
use crate::simplify::input::{Input, kept_edges, locked_vertices};
use crate::simplify::options::{ClosedOptions, Purpose, ScoreSource};

use super::stage_settings::StageSettings;

/// Added to the visible share of a surface, for surfaces that no view shows.
const LEAST_SHARE: f32 = 0.05;
/// Power of the visible share in the importance of a vertex.
// At a ratio of 0.1, FLIP errors of twelve bare meshes are 1 % smaller with 2, those of eleven textured ones 3 % larger,
// and distances 6 % larger on both; with 1, FLIP errors of the bare meshes are 1 % larger.
const SHARE_EXPONENT: f32 = 1.5;

/// A mesh to simplify and how, with settings that callers outside of the crate cannot make.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    pub input: Input<'a>,
    pub options: &'a ClosedOptions,
    pub differentiable: bool,
    /// True to reach the size even where too few vertices are free to keep the shape.
    pub forces_size: bool,
}

impl<'a> Task<'a> {
    pub fn new(input: Input<'a>, options: &'a ClosedOptions) -> Self {
        Self { input, options, differentiable: false, forces_size: false }
    }

    /// Returns the task with these scores of the vertices; they may be empty.
    pub fn with_scores(self, scores: &'a [f32]) -> Self {
        Self { input: Input { scores, ..self.input }, ..self }
    }

    /// Chooses the source of vertex scores: none if without effect, the network if the caller gives its scores.
    fn score_source(&self, settings: &StageSettings) -> ScoreSource {
        match self.options.scores {
            _ if settings.strength == 0.0 => ScoreSource::Geometry,
            _ if !self.input.scores.is_empty() => ScoreSource::Network,
            // The purpose Poses distributes the vertices by a term of its own, so no formula does.
            _ if self.options.purpose != Purpose::Shape => ScoreSource::Geometry,
            scores => scores,
        }
    }

    /// Returns the attributes; `None` if there are none.
    pub fn attributes(&self) -> Option<&'a Attributes> {
        Some(self.input.attributes).filter(|attributes| !attributes.is_empty())
    }

    pub fn is_asset(&self) -> bool {
        self.input.scene.is_some() || !self.input.attributes.is_empty()
    }

    /// Returns the largest distance from the rest at which components may be dropped; `None` if all must stay.
    pub fn drops_within(&self) -> Option<f64> {
        let (options, input) = (self.options, &self.input);
        // Constraints of the caller name vertices or faces that must remain; where the size is forced, their components.
        let is_locked = !input.locked.is_empty() && !self.forces_size;
        let is_constrained = options.subset || options.lock_boundaries || is_locked;
        (options.prune && !is_constrained).then_some(options.prune_within)
    }

    pub fn piece_of_face(&self, face: u32) -> usize {
        self.input.scene.map_or(0, |scene| scene.piece_of_group(self.input.attributes.group(face)))
    }

    /// Returns the scene piece of a face, or the first piece with the same instances.
    pub fn pieces_placed_alike(&self) -> impl Fn(u32) -> usize {
        let alike = self.input.scene.map_or_else(|| vec![0], UnitedMesh::pieces_placed_alike);
        move |face| alike[self.piece_of_face(face)]
    }

    pub fn pose_attributes(&self) -> Option<&'a Attributes> {
        let has_targets = self.input.attributes.channel(Role::MorphPosition).is_some();
        (has_targets && self.options.purpose == Purpose::Poses).then_some(self.input.attributes)
    }
}

/// Input of the stages of a run: the task, and all that follows from it.
pub struct ClosedRequest<'a> {
    pub task: Task<'a>,
    pub importance: Importance<'a>,
    pub scores: ScoreSource,
    /// Factor on the importance of each vertex by how much of it is visible; empty for none.
    pub visibility: Vec<f32>,
    pub settings: StageSettings,
    pub edges: Vec<FeatureEdge>,
    /// Marks locked vertices; empty for none.
    pub locked: Vec<bool>,
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
    /// Plans a run: options, constraints and scores become one request.
    pub fn new(task: Task<'a>) -> Self {
        let request = Self::without_visibility(task);
        Self { visibility: visibility(&task.input, &request.settings), ..request }
    }

    /// Plans a run in which nothing is collapsed, so that vertices need no importance.
    pub fn without_visibility(task: Task<'a>) -> Self {
        let Task { input, options, .. } = task;
        let settings = StageSettings::new(options.optimize, options.effort);
        let scores = task.score_source(&settings);
        let importance = match scores {
            // The caller's importance overrules any score.
            _ if !input.importance.is_empty() => Importance::Given(input.importance),
            ScoreSource::Network => Importance::Scores(input.scores),
            ScoreSource::Bending => Importance::Bending,
            ScoreSource::Geometry => Importance::Even,
        };
        let (edges, locked) = (kept_edges(&input, options), locked_vertices(&input, options));
        Self { task, importance, scores, visibility: Vec::new(), settings, edges, locked, price: None }
    }

    /// Returns whether components go by what viewers see of them where a size is out of reach.
    pub fn drops_by_views(&self) -> bool {
        let is_judged_by_views = self.task.forces_size || self.visual_properties().is_guarded;
        self.task.options.hold_shape.is_none() && is_judged_by_views
    }

    pub fn runs_flips(&self) -> bool {
        self.settings.steps > 0
    }

    pub fn runs_fit(&self) -> bool {
        self.settings.steps > 0 && !self.task.options.subset
    }

    pub fn visual_properties(&self) -> VisualProperties<'a> {
        // Scores of a formula or network are not the caller's judgement of what matters.
        let is_weighed = matches!(self.importance, Importance::Given(_)) || !self.visibility.is_empty();
        let is_guarded = self.task.is_asset() || self.settings.by_looks;
        VisualProperties { attributes: self.task.attributes(), scene: self.task.input.scene, is_weighed, is_guarded }
    }
}

fn visibility(input: &Input, settings: &StageSettings) -> Vec<f32> {
    if !settings.by_looks {
        return Vec::new();
    }
    visible_shares(input).into_iter().map(|share| (share + LEAST_SHARE).powf(SHARE_EXPONENT)).collect()
}

/// Source of vertex importance, a factor on each vertex's area.
#[derive(Clone, Copy, Debug)]
pub enum Importance<'a> {
    /// 1 for every vertex.
    Even,
    /// More where the surface bends.
    Bending,
    /// One score per mesh vertex, as of a network.
    Scores(&'a [f32]),
    /// One positive factor per mesh vertex.
    Given(&'a [f32]),
}
