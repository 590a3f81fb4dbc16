//! What is asked of a document.

use crate::io::{Format, PackOptions};
use crate::simplify::{Options, Target};

use super::size::{Bound, Count, Goal};

/// All that is asked, whatever the document: how it is read, simplified and written.
///
/// ```
/// use neural_mesh::job::{Bound, Goal, Job};
/// use neural_mesh::io::Format;
/// use neural_mesh::simplify::{Options, Target};
///
/// let mut job = Job::new(Options::new(Target::Ratio(1.0)), Format::Glb);
/// job.goal = Goal::Error(Bound::Percent(1.0));
/// assert!(job.check().is_ok());
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Job {
    /// What is asked of the simplifier.
    pub options: Options,
    /// How its target is meant.
    pub goal: Goal,
    /// The format that results are written in.
    pub format: Format,
    /// What their files will be called.
    pub names: Names,
    /// Whether vertices at equal positions become one.
    pub weld: bool,
    /// Vertices nearer than that become one.
    pub weld_near: Option<Bound>,
    /// How far seams may leave their places, in texels; `None` for the share of the texture that is the default.
    pub seam_texels: Option<f64>,
    /// Components smaller than that are dropped.
    pub prune_below: Option<Bound>,
    /// What is done to the mesh before.
    pub repair: Option<Repair>,
    /// Texels a side of the textures that are baked, where such are asked for.
    pub bake: Option<usize>,
    /// How the numbers of a glTF are packed, where they are.
    pub compress: Option<PackOptions>,
    /// Texels a side of its textures at most, where that is bounded.
    pub textures: Option<usize>,
    /// What the result does not need of what the mesh carries.
    pub ignore: Vec<Ignored>,
    /// Name of the attribute that says how much vertices count, or `NAME=FACTOR`.
    pub importance: Option<String>,
    /// Names of what comes back as it is.
    pub keep: Vec<String>,
    /// Names with shares of their own, above 0 and at most 1.
    pub shares: Vec<(String, f64)>,
    /// Whether what the mesh names may be read from outside its folder.
    pub allow_outside: bool,
    /// Whether the distance from the original is measured.
    pub check: bool,
    /// Whether the report says what meshes are as surfaces: that takes longer than to write them.
    pub shapes: bool,
}

impl Job {
    /// With these options, results of this format, and nothing else asked for.
    pub fn new(options: Options, format: Format) -> Self {
        Self {
            options,
            goal: Goal::Target,
            format,
            names: Names::default(),
            weld: true,
            weld_near: None,
            seam_texels: None,
            prune_below: None,
            repair: None,
            bake: None,
            compress: None,
            textures: None,
            ignore: Vec::new(),
            importance: None,
            keep: Vec::new(),
            shares: Vec::new(),
            allow_outside: false,
            check: true,
            shapes: false,
        }
    }

    /// The size that is asked for, of a mesh of so many faces.
    pub fn target(&self, n_faces: usize) -> Target {
        match &self.goal {
            Goal::ShareOfFaces(share) => Target::Faces(Count::Share(*share).of(n_faces)),
            Goal::Levels(sizes) => sizes.first().map_or(self.options.target, |size| size.target(n_faces)),
            _ => self.options.target,
        }
    }

    /// Whether a glTF is taken as the scene that it is.
    pub(super) fn takes_scenes(&self) -> bool {
        matches!(self.format, Format::Gltf | Format::Glb) && self.bake.is_none()
    }

    /// Whether some vertices of the input are held in their places: those of boundaries or of what is kept.
    pub(super) fn holds_places(&self) -> bool {
        self.options.lock_boundaries || !self.keep.is_empty() || !self.shares.is_empty()
    }

    /// Whether positions of the input are promised to stay as they are.
    pub(super) fn keeps_positions(&self) -> bool {
        self.options.subset || self.holds_places()
    }
}

/// What the files of results will be called: what stands beside them is named after that.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// One file for all results, or one for each; none where nobody says.
    pub files: Vec<String>,
    /// What is shared by levels of detail is named after it.
    pub shared: Option<String>,
}

impl Names {
    /// What the file of a result will be called.
    pub fn file(&self, number: usize) -> &str {
        self.files.get(number).map_or("mesh", String::as_str)
    }

    /// Whether each result has a file of its own.
    pub fn are_several(&self) -> bool {
        self.files.len() > 1
    }
}

/// What is done to a mesh before it is simplified.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Repair {
    /// Holes of at most so many edges are closed.
    FillHoles(usize),
    /// It becomes a solid; pieces smaller than that go.
    Printable(Bound),
}

/// What a result does not need of what a mesh carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ignored {
    /// Texture coordinates, and the tangents that follow them.
    Uv,
    /// Normals.
    Normals,
    /// Colours of vertices.
    Colors,
    /// Materials and groups of faces.
    Materials,
}

impl Ignored {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uv => "uv",
            Self::Normals => "normals",
            Self::Colors => "colors",
            Self::Materials => "materials",
        }
    }
}
