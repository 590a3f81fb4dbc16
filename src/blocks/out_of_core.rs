//! A mesh file that does not fit into memory, simplified in blocks that wait on the disk.

use std::ops::ControlFlow;
use std::path::Path;

use rayon::prelude::*;

use super::block::{Block, simplify_block};
use super::join::join;
use super::plan::Census;
use super::price::{price_for, sample_block};
use super::spooled::{Read, Spooled};
use super::{FACES, TIMES};
use crate::io::{Pieces, ReadError};
use crate::mesh::Frame;
use crate::mesh::cleanup::{CleanCounts, CleanError, origin_within};
use crate::metrics::{BlockDistances, QuickDistance, StreamedDistance};
use crate::model::Weights;
use crate::simplify::{Options, Simplified, SimplifyError, Target, simplify};
use crate::spatial::Bounds;

/// Bytes that a face takes while it is simplified, about, from above.
const PER_FACE: u64 = 260;
/// Bytes of a run that is not yet on the disk, for each block.
const PER_BLOCK: u64 = 100 << 10;
/// Blocks that tell the price, at most, and of so many one.
const SAMPLES: usize = 8;
const ONE_OF: usize = 8;
/// Positions of which one is counted, to know where blocks begin.
const EVERY: u64 = 8;
/// Faces that the borders of a block keep, of those that it has: vertices on them stay until the blocks are joined.
const BORDER: f64 = 0.02;

/// Shares of the time after which a mesh is cut into blocks, and these are joined.
const CUT: f64 = 0.25;
const JOINED: f64 = 0.9;

/// Who hears what share of a run is done, and stops it by `ControlFlow::Break`.
pub type Heard<'a> = dyn FnMut(f64) -> ControlFlow<()> + Send + 'a;

/// What may be taken for it.
#[derive(Clone, Copy, Debug)]
pub struct Room<'a> {
    /// Bytes of memory.
    pub n_bytes: u64,
    /// A folder on whose disk blocks wait.
    pub folder: &'a Path,
}

/// What came of a file, whose blocks wait on the disk until it is dropped.
#[derive(Debug)]
#[non_exhaustive]
pub struct OutOfCore {
    /// The lighter mesh.
    pub simplified: Simplified,
    /// How its coordinates lie in the file.
    pub frame: Frame,
    /// What was cleaned; vertices in one place, which each block counts for itself, are not told.
    pub counts: CleanCounts,
    /// Vertices of the file that faces use, those in one place as one.
    pub n_vertices: usize,
    /// Its faces.
    pub n_faces: usize,
    /// Blocks it was cut into.
    pub n_blocks: usize,
    /// Vertices of the joined blocks.
    pub n_joined: usize,
    spooled: Spooled,
    /// Blocks that fit into memory side by side.
    n_at_once: usize,
}

impl OutOfCore {
    /// How far the result and the file are apart, by [`StreamedDistance`]; blocks are read from the disk once more.
    ///
    /// # Errors
    /// [`OutOfCoreError`] where the disk fails, or by `listener`.
    pub fn distance(
        &self,
        n_samples: usize,
        seed: u64,
        listener: &mut Heard,
    ) -> Result<Option<QuickDistance>, OutOfCoreError> {
        let n = self.spooled.n_blocks();
        let Some(mut distance) = StreamedDistance::new(&self.simplified.mesh, [n_samples, n], seed) else {
            return Ok(None);
        };
        let mut boxes = vec![Bounds::EMPTY; n];
        for again in [false, true] {
            let shown: Vec<usize> =
                (0..n).filter(|&number| !again || distance.may_hold_nearer(&boxes[number])).collect();
            for some in shown.chunks(self.n_at_once) {
                heard(listener, if again { 1.0 } else { some[0] as f64 / n as f64 })?;
                let look = |&number: &usize| self.look(&distance, number, again);
                for (look, number) in some.par_iter().map(look).collect::<Vec<_>>().into_iter().zip(some) {
                    let Some(look) = look? else { continue };
                    boxes[*number] = look.bounds();
                    distance.add(look);
                }
            }
        }
        Ok(Some(distance.finish()))
    }

    fn look(
        &self,
        distance: &StreamedDistance,
        number: usize,
        again: bool,
    ) -> Result<Option<BlockDistances>, OutOfCoreError> {
        let piece = self.spooled.surface(number)?;
        let measure = if again { StreamedDistance::measure_again } else { StreamedDistance::measure };
        Ok((!piece.faces().is_empty()).then(|| measure(distance, &piece)))
    }
}

/// Why there is no result.
#[derive(Debug)]
#[non_exhaustive]
pub enum OutOfCoreError {
    /// The file cannot be read.
    Read(ReadError),
    /// The disk failed or is full.
    Disk(std::io::Error),
    /// It is no mesh.
    Clean(CleanError),
    /// It cannot be simplified.
    Simplify(SimplifyError),
    /// It takes so many bytes of memory.
    TooLittle(u64),
}

impl std::fmt::Display for OutOfCoreError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Read(error) => error.fmt(f),
            Self::Disk(error) => write!(f, "temporary files next to the output failed: {error}"),
            Self::Clean(error) => error.fmt(f),
            Self::Simplify(error) => error.fmt(f),
            Self::TooLittle(n_bytes) => {
                let gib = (*n_bytes as f64 / f64::from(1 << 30) * 10.0).ceil() / 10.0;
                write!(f, "this target needs about {gib} GiB of memory: allow more or choose a smaller target")
            }
        }
    }
}

impl std::error::Error for OutOfCoreError {}

impl From<ReadError> for OutOfCoreError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

impl From<std::io::Error> for OutOfCoreError {
    fn from(error: std::io::Error) -> Self {
        Self::Disk(error)
    }
}

impl From<SimplifyError> for OutOfCoreError {
    fn from(error: SimplifyError) -> Self {
        Self::Simplify(error)
    }
}

/// Simplifies the geometry of a file in blocks. Of `options` count the target, scores, seed, creases and the figure to be near in.
///
/// # Errors
/// [`OutOfCoreError`]: before any work where the size asked for takes more memory than there is.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::blocks::{Room, simplify_pieces};
/// use neural_mesh::{io::Pieces, simplify::{Options, Target}};
/// let pieces = Pieces::open("tests/meshes/spot.ply".as_ref()).unwrap();
/// let room = Room { n_bytes: 1 << 30, folder: "".as_ref() };
/// let options = Options::new(Target::Ratio(0.1));
/// let found = simplify_pieces(&pieces, None, &options, &room, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!((found.n_vertices, found.simplified.mesh.positions().len()), (2930, 293));
/// ```
pub fn simplify_pieces(
    pieces: &Pieces,
    weights: Option<&Weights>,
    options: &Options,
    room: &Room,
    listener: &mut Heard,
) -> Result<OutOfCore, OutOfCoreError> {
    in_blocks_of(FACES, pieces, (weights, options), room, listener)
}

/// The same, with blocks of about so many faces.
fn in_blocks_of(
    faces_of_block: usize,
    pieces: &Pieces,
    (weights, options): (Option<&Weights>, &Options),
    room: &Room,
    listener: &mut Heard,
) -> Result<OutOfCore, OutOfCoreError> {
    let n_faces = usize::try_from(pieces.n_faces()).unwrap_or(usize::MAX);
    let share = (TIMES * asked(options.target, n_faces)).min(1.0);
    check_room(pieces, share, room)?;
    let mut hear = |done: f64| heard(listener, done);
    hear(0.0)?;
    let (frame, spooled, n_broken) = cut(pieces, n_faces.div_ceil(faces_of_block).max(1), room)?;
    hear(CUT)?;
    let options = &Options { frame, ..options.clone() };
    let n_at_once = at_once(room);
    let blocks = Blocks { spooled: &spooled, weights, options, share };
    let (lighter, mut told) = blocks.all(n_at_once, &mut hear)?;
    told.counts.dropped_faces += n_broken as usize;
    let n_blocks = lighter.len();
    let joined = join(lighter).map_err(|_| SimplifyError::Overflow)?;
    if joined.faces().is_empty() {
        return Err(SimplifyError::Empty.into());
    }
    hear(JOINED)?;
    let target = match options.target {
        Target::Ratio(ratio) => Target::Vertices(((ratio * told.n_vertices as f64) as usize).max(1)),
        target => target,
    };
    let simplified = simplify(&joined, weights, &Options { target, ..options.clone() }, &mut |event| {
        hear(JOINED + (1.0 - JOINED) * f64::from(event.total)).map_or(ControlFlow::Break(()), ControlFlow::Continue)
    })?;
    let Told { counts, n_vertices, n_faces } = told;
    let n_joined = joined.positions().len();
    Ok(OutOfCore { simplified, frame, counts, n_vertices, n_faces, n_blocks, n_joined, spooled, n_at_once })
}

/// Says how far it is; stops where that is wished.
pub(super) fn heard(listener: &mut Heard, done: f64) -> Result<(), SimplifyError> {
    match listener(done) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(SimplifyError::Interrupted),
    }
}

/// What is known of all blocks.
#[derive(Default)]
struct Told {
    counts: CleanCounts,
    n_vertices: usize,
    n_faces: usize,
}

impl Told {
    fn add(&mut self, other: Self) {
        self.counts += other.counts;
        self.n_vertices += other.n_vertices;
        self.n_faces += other.n_faces;
    }
}

/// Blocks on the disk and what is asked of them.
struct Blocks<'a> {
    spooled: &'a Spooled,
    weights: Option<&'a Weights>,
    options: &'a Options,
    /// Of the vertices, how many the blocks leave.
    share: f64,
}

impl Blocks<'_> {
    /// All of them at one price, so many at once.
    fn all(
        &self,
        n_at_once: usize,
        hear: &mut dyn FnMut(f64) -> Result<(), SimplifyError>,
    ) -> Result<(Vec<Block>, Told), OutOfCoreError> {
        let (price, n_blocks) = (self.price()?, self.spooled.n_blocks());
        let (mut lighter, mut told) = (Vec::new(), Told::default());
        for start in (0..n_blocks).step_by(n_at_once) {
            hear(CUT + (JOINED - CUT) * start as f64 / n_blocks as f64)?;
            let numbers = start..(start + n_at_once).min(n_blocks);
            let made: Vec<_> = numbers.into_par_iter().map(|number| self.simplified(number, price)).collect();
            for made in made {
                let (block, of_block) = made?;
                told.add(of_block);
                lighter.extend(block);
            }
        }
        Ok((lighter, told))
    }

    fn read(&self, number: usize) -> Result<Read, OutOfCoreError> {
        self.spooled.read(number)?.map_err(OutOfCoreError::Clean)
    }

    /// The price for all, by what a few blocks along the curve pay.
    fn price(&self) -> Result<f64, OutOfCoreError> {
        let n = self.spooled.n_blocks();
        let n_samples = n.div_ceil(ONE_OF).min(SAMPLES);
        let chosen = (0..n_samples).map(|i| (2 * i + 1) * n / (2 * n_samples));
        let mut samples = Vec::new();
        for number in chosen {
            let Some(block) = self.read(number)?.block else { continue };
            samples.push(sample_block(&block, self.share / TIMES, self.weights, self.options)?);
        }
        Ok(price_for(&samples, self.share))
    }

    fn simplified(&self, number: usize, price: f64) -> Result<(Option<Block>, Told), OutOfCoreError> {
        let Read { block, n_own_vertices, counts } = self.read(number)?;
        let n_faces = block.as_ref().map_or(0, |block: &Block| block.mesh.faces().len());
        let told = Told { counts, n_vertices: n_own_vertices, n_faces };
        let lighter =
            block.map(|block| simplify_block(&block, self.share, price, self.weights, self.options)).transpose()?;
        Ok((lighter, told))
    }
}

/// The share of the vertices that is asked for.
fn asked(target: Target, n_faces: usize) -> f64 {
    let of = |n: usize, n_all: usize| n as f64 / n_all.max(1) as f64;
    match target {
        Target::Ratio(ratio) => ratio,
        Target::Vertices(n) => of(n, n_faces / 2),
        Target::Faces(n) => of(n, n_faces),
    }
}

/// Refuses what takes more memory than there is: the vertices of the file, or what the blocks leave.
pub(super) fn check_room(pieces: &Pieces, share: f64, room: &Room) -> Result<(), OutOfCoreError> {
    let n_faces = pieces.n_faces();
    let n_blocks = n_faces.div_ceil(FACES as u64);
    let cutting = pieces.n_memory_bytes().saturating_add(n_blocks.saturating_mul(PER_BLOCK));
    let rest = (((share + BORDER).min(1.0) * n_faces as f64) as u64).saturating_mul(PER_FACE);
    let block = (FACES as u64).min(n_faces) * PER_FACE;
    let most = cutting.max(rest).max(block.saturating_add(rest / 8)).saturating_add(32 << 20);
    if most > room.n_bytes { Err(OutOfCoreError::TooLittle(most)) } else { Ok(()) }
}

/// How many blocks are simplified side by side: as many as there are threads, in half of the memory.
pub(super) fn at_once(room: &Room) -> usize {
    let fit = room.n_bytes / 2 / (FACES as u64 * PER_FACE);
    rayon::current_num_threads().min(usize::try_from(fit).unwrap_or(usize::MAX)).max(1)
}

/// Sorts the triangles of a file into blocks on the disk; beside them how many faces were broken.
pub(super) fn cut(pieces: &Pieces, n_blocks: usize, room: &Room) -> Result<(Frame, Spooled, u64), OutOfCoreError> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    pieces.each_position(&mut |p| {
        if p.iter().all(|x| x.is_finite()) {
            (0..3).for_each(|axis| (low[axis], high[axis]) = (low[axis].min(p[axis]), high[axis].max(p[axis])));
        }
    })?;
    let double = pieces.is_double();
    let frame = Frame { origin: if double { origin_within(low, high) } else { [0.0; 3] }, double };
    let mut census = Census::new(frame.to_local(low), frame.to_local(high));
    let mut n_before = 0u64;
    pieces.each_position(&mut |p| {
        if n_before.is_multiple_of(EVERY) {
            census.count(frame.to_local(p));
        }
        n_before += 1;
    })?;
    let mut spooled = Spooled::new(room.folder, census.plan(n_blocks))?;
    let mut written = Ok(());
    let n_broken = pieces.each_triangle(&frame, &mut |triangle| {
        if written.is_ok() {
            written = spooled.push(triangle);
        }
    })?;
    written?;
    spooled.close()?;
    Ok((frame, spooled, n_broken))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Format, write};
    use crate::mesh::{TriMesh, shapes, topology};
    use crate::metrics::quick_distance;

    fn found(mesh: &TriMesh, format: Format, n_bytes: u64, target: Target) -> Result<OutOfCore, OutOfCoreError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("a.{}", format.name()));
        std::fs::write(&path, write(mesh, &Frame::default(), format).unwrap()).unwrap();
        let room = Room { n_bytes, folder: folder.path() };
        let pieces = Pieces::open(&path).unwrap();
        let mut heard = 0.0;
        let found = in_blocks_of(1500, &pieces, (None, &Options::new(target)), &room, &mut |done| {
            assert!((heard..=1.0).contains(&done), "{heard} {done}");
            heard = done;
            ControlFlow::Continue(())
        });
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        found
    }

    #[test]
    fn closed_stays_closed_at_the_size_asked_for_and_as_near_as_in_memory() {
        let mesh = shapes::wavy_sphere(5, 9.0);
        let options = Options::new(Target::Ratio(0.1));
        let whole = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap().mesh;
        let distance = |result: &TriMesh| quick_distance(&mesh, result, 20_000, 0).unwrap();
        let mut first = None;
        for format in [Format::Ply, Format::Stl, Format::Obj] {
            let found = found(&mesh, format, 1 << 30, options.target).unwrap();
            let measured = found.distance(20_000, 0, &mut |_| ControlFlow::Continue(())).unwrap().unwrap();
            let result = found.simplified.mesh;
            assert!(topology(&result).is_closed_manifold() && found.n_blocks > 10, "{format:?}");
            assert_eq!((found.n_vertices, found.n_faces), (mesh.positions().len(), mesh.faces().len()));
            assert_eq!(result.positions().len(), whole.positions().len());
            let [distance, of_whole] = [&result, &whole].map(distance);
            assert!(distance.mean < 1.05 * of_whole.mean, "{distance:?} {of_whole:?}");
            assert!((measured.mean / distance.mean - 1.0).abs() < 1e-2, "{measured:?} {distance:?}");
            assert!((0.98..1.0 + 1e-6).contains(&(measured.max / distance.max)), "{measured:?} {distance:?}");
            // The order of faces and vertices is that of the file in each.
            let first: &TriMesh = first.get_or_insert(result.clone());
            assert!(format == Format::Stl || result.positions().len() == first.positions().len());
        }
    }

    #[test]
    fn neither_memory_nor_threads_change_a_bit() {
        let mesh = shapes::torus(120, 60, 1.0, 0.4);
        let result = |n_bytes| found(&mesh, Format::Ply, n_bytes, Target::Faces(1000)).unwrap().simplified.mesh;
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let first = pool(1).install(|| result(200 << 20));
        assert_eq!(first.faces().len(), 1000);
        for n_bytes in [200 << 20, 4 << 30] {
            assert_eq!(first, pool(3).install(|| result(n_bytes)));
        }
    }

    #[test]
    fn what_does_not_fit_is_refused_before_any_work() {
        let mesh = shapes::icosphere(5);
        let refused = found(&mesh, Format::Ply, 1 << 20, Target::Ratio(0.5)).unwrap_err();
        assert!(matches!(refused, OutOfCoreError::TooLittle(n) if n > 1 << 20), "{refused}");
        assert!(refused.to_string().contains("GiB of memory: allow them or ask for less"), "{refused}");
    }
}
