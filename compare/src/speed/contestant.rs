//! Who takes turns: meshoptimizer's three simplifiers and ours, each timed from its arguments to its result.

use std::ops::ControlFlow;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::ValueEnum;
use meshopt::{SimplifyOptions, VertexDataAdapter, typed_to_bytes};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{RawMesh, TriMesh};
use neural_mesh::simplify::{Options, ScoreSource, Target, simplify};
use nix::time::ClockId;

use crate::methods::compact;

/// An error that no result of meshoptimizer reaches.
const NO_LIMIT: f32 = 1e10;

/// The kinds of contestants.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Who {
    /// meshoptimizer's `simplify`.
    Plain,
    /// meshoptimizer's `simplifyWithUpdate`.
    Update,
    /// meshoptimizer's `simplifySloppy`.
    Sloppy,
    /// `simplify` of neural-mesh with its defaults.
    Ours,
    /// The same with scores from the geometry.
    Geometry,
    /// Weld and cleanup, then `simplify` with its defaults.
    Cleanup,
}

/// A mesh as read and as cleaned.
pub struct Input {
    pub raw: RawMesh,
    pub mesh: TriMesh,
}

impl Input {
    pub fn new(raw: RawMesh) -> Result<Self> {
        Ok(Self { mesh: clean(raw.clone(), &CleanOptions::default())?.mesh, raw })
    }
}

/// One of them on a number of threads.
pub struct Contestant {
    pub name: String,
    who: Who,
    pool: rayon::ThreadPool,
}

/// What came of a turn: a mesh, or indices into the positions of the input or into others.
pub enum Made {
    Mesh(TriMesh),
    Faces(Vec<u32>),
    Moved(Vec<[f32; 3]>, Vec<u32>),
}

/// How long a turn took, in seconds.
#[derive(Clone, Copy)]
pub struct Time {
    /// On the wall.
    pub wall: f64,
    /// Of the processor, by the one thread that does or begins the work.
    pub thread: f64,
}

/// A turn.
pub struct Turn {
    pub time: Time,
    made: Made,
}

impl Turn {
    /// The result as a mesh.
    pub fn mesh(self, input: &Input) -> Result<TriMesh> {
        let (positions, indices) = match self.made {
            Made::Mesh(mesh) => return Ok(mesh),
            Made::Faces(indices) => (input.mesh.positions().to_vec(), indices),
            Made::Moved(positions, indices) => (positions, indices),
        };
        let faces: Vec<[u32; 3]> = indices.as_chunks().0.to_vec();
        compact(&TriMesh::new(positions, Vec::new())?, &faces)
    }
}

/// Those wanted, `plain` first; ours once for each number of threads.
pub fn lined_up(threads: &[usize], only: &[Who]) -> Result<Vec<Contestant>> {
    let mut contestants = vec![Contestant::new(Who::Plain, 1)?];
    for &who in &Who::value_variants()[1..] {
        let wanted = only.is_empty() || only.contains(&who);
        let threads = if who.is_ours() { threads } else { &[1] };
        for &n_threads in threads.iter().filter(|_| wanted) {
            contestants.push(Contestant::new(who, n_threads)?);
        }
    }
    Ok(contestants)
}

impl Who {
    fn is_ours(self) -> bool {
        matches!(self, Self::Ours | Self::Geometry | Self::Cleanup)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Update => "update",
            Self::Sloppy => "sloppy",
            Self::Ours => "ours",
            Self::Geometry => "ours, geometry",
            Self::Cleanup => "cleanup + ours",
        }
    }
}

impl Contestant {
    /// A contestant on so many threads, 0 for all.
    pub fn new(who: Who, n_threads: usize) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build()?;
        let threads = pool.current_num_threads();
        let name = if who.is_ours() { format!("{}, {threads} thr.", who.name()) } else { who.name().to_owned() };
        Ok(Self { name, who, pool })
    }

    /// The seconds of a turn that count: on one thread the processor's, which others that are busy on the machine hardly
    /// change; on several, those on the wall.
    pub fn seconds(&self, time: Time) -> f64 {
        if self.pool.current_num_threads() == 1 { time.thread } else { time.wall }
    }

    /// Simplifies to a number of faces.
    pub fn turn(&self, input: &Input, n_faces: usize) -> Result<Turn> {
        self.pool.install(|| match self.who {
            Who::Plain => plain(&input.mesh, n_faces),
            Who::Update => update(&input.mesh, n_faces),
            Who::Sloppy => sloppy(&input.mesh, n_faces),
            Who::Ours => ours(&input.mesh, &Options::new(Target::Faces(n_faces))),
            Who::Geometry => {
                let options = Options::new(Target::Faces(n_faces));
                ours(&input.mesh, &Options { scores: ScoreSource::Geometry, ..options })
            }
            Who::Cleanup => cleanup(input, n_faces),
        })
    }
}

/// What some work makes, and how long it takes.
pub fn timed<T>(work: impl FnOnce() -> Result<T>) -> Result<(T, Time)> {
    let now = |clock: ClockId| Ok::<_, anyhow::Error>(Duration::from(clock.now()?));
    let (wall, thread) = (ClockId::CLOCK_MONOTONIC, ClockId::CLOCK_THREAD_CPUTIME_ID);
    let start = (now(wall)?, now(thread)?);
    let made = work()?;
    let time = Time { wall: (now(wall)? - start.0).as_secs_f64(), thread: (now(thread)? - start.1).as_secs_f64() };
    Ok((made, time))
}

fn vertices(mesh: &TriMesh) -> Result<VertexDataAdapter<'_>> {
    VertexDataAdapter::new(typed_to_bytes(mesh.positions()), size_of::<[f32; 3]>(), 0).context("the positions")
}

fn plain(mesh: &TriMesh, n_faces: usize) -> Result<Turn> {
    let (vertices, indices) = (vertices(mesh)?, mesh.faces().as_flattened());
    let none = SimplifyOptions::None;
    let (left, time) = timed(|| Ok(meshopt::simplify(indices, &vertices, 3 * n_faces, NO_LIMIT, none, None)))?;
    Ok(Turn { time, made: Made::Faces(left) })
}

fn update(mesh: &TriMesh, n_faces: usize) -> Result<Turn> {
    // It works in place: the copies are no part of the time.
    let (mut positions, mut indices) = (mesh.positions().to_vec(), mesh.faces().as_flattened().to_vec());
    let (n_asked, none) = (3 * n_faces, SimplifyOptions::None);
    let (n_left, time) = timed(|| {
        let (faces, points) = (&mut indices, &mut positions);
        Ok(meshopt::simplify_with_update(faces, points, &mut [], &[], 0, None, n_asked, NO_LIMIT, none, None))
    })?;
    indices.truncate(n_left);
    Ok(Turn { time, made: Made::Moved(positions, indices) })
}

fn sloppy(mesh: &TriMesh, n_faces: usize) -> Result<Turn> {
    let (vertices, indices) = (vertices(mesh)?, mesh.faces().as_flattened());
    let (left, time) = timed(|| Ok(meshopt::simplify_sloppy(indices, &vertices, 3 * n_faces, NO_LIMIT, None)))?;
    Ok(Turn { time, made: Made::Faces(left) })
}

fn ours(mesh: &TriMesh, options: &Options) -> Result<Turn> {
    let (made, time) = timed(|| simplified(mesh, options))?;
    Ok(Turn { time, made: Made::Mesh(made) })
}

fn cleanup(input: &Input, n_faces: usize) -> Result<Turn> {
    let raw = input.raw.clone();
    let (made, time) = timed(|| {
        let cleaned = clean(raw, &CleanOptions::default())?;
        simplified(&cleaned.mesh, &Options { frame: cleaned.frame, ..Options::new(Target::Faces(n_faces)) })
    })?;
    Ok(Turn { time, made: Made::Mesh(made) })
}

fn simplified(mesh: &TriMesh, options: &Options) -> Result<TriMesh> {
    Ok(simplify(mesh, None, options, &mut |_| ControlFlow::Continue(()))?.mesh)
}
