//! Simplification of a mesh file larger than memory, in blocks stored on disk.

use std::ops::ControlFlow;
use std::path::Path;

use super::block::{Block, simplify_block};
use super::join::join;
use super::plan::Census;
use super::price::{price_for, sample_block};
use super::spooled_blocks::{SpooledBlocks, StoredBlock};
use super::{FACES_PER_BLOCK, VERTEX_SURPLUS};
use crate::io::{Pieces, ReadError};
use crate::mesh::Frame;
use crate::mesh::cleanup::{CleanCounts, CleanError, origin_within};
use crate::metrics::{BlockDistances, QuickDistance, StreamedDistance};
use crate::model::Weights;
use crate::parallel;
use crate::simplify::{Assembly, ClosedOptions, Input, Options, Simplified, SimplifyError, asked_scores, simplify};
use crate::spatial::Bounds;

/// Upper estimate of the memory in bytes per face of a mesh during simplification.
const BYTES_PER_FACE: u64 = 260;
/// Bytes buffered per block while the file is cut.
const BYTES_PER_BLOCK: u64 = 100 << 10;
/// Blocks simplified in advance to estimate the highest price of a merge: one in `SAMPLE_EVERY`, at most `MAX_SAMPLES`.
const MAX_SAMPLES: usize = 8;
const SAMPLE_EVERY: usize = 8;
/// Step between positions counted to plan the blocks: one in `COUNT_EVERY`.
const COUNT_EVERY: u64 = 8;
/// Share of a block's faces kept by its borders, whose vertices stay until the blocks are joined.
const BORDER_SHARE: f64 = 0.02;

/// Progress, of 1, at the end of cutting and of joining the blocks.
const CUT_PROGRESS: f64 = 0.25;
const JOINED_PROGRESS: f64 = 0.9;

/// Callback with the progress, 0 to 1, that may stop the run by `ControlFlow::Break`.
pub type ProgressCallback<'a> = dyn FnMut(f64) -> ControlFlow<()> + Send + 'a;

/// Memory and disk available to a run.
#[derive(Clone, Copy, Debug)]
pub struct WorkingSpace<'a> {
    /// Bytes of memory that the run may use.
    pub n_bytes: u64,
    /// Folder for the temporary file with the blocks.
    pub folder: &'a Path,
}

/// Simplified mesh of a file, with the file's blocks on disk.
#[derive(Debug)]
#[non_exhaustive]
pub struct OutOfCoreResult {
    /// Simplified mesh.
    pub simplified: Simplified,
    /// Local origin of the file's coordinates, and whether the file stores doubles.
    pub frame: Frame,
    /// Changes made by cleaning, without welded vertices.
    pub counts: CleanCounts,
    /// Number of distinct positions of the file that faces use.
    pub n_vertices: usize,
    /// Number of faces in the file after cleaning.
    pub n_faces: usize,
    /// Number of blocks.
    pub n_blocks: usize,
    /// Number of vertices after joining the simplified blocks.
    pub n_joined: usize,
    spooled: SpooledBlocks,
    n_at_once: usize,
}

impl OutOfCoreResult {
    /// Measures the distance between result and file by [`StreamedDistance`].
    ///
    /// # Errors
    /// [`OutOfCoreError`] for a disk error or a stop by `listener`.
    pub fn distance(
        &self,
        n_samples: usize,
        seed: u64,
        listener: &mut ProgressCallback,
    ) -> Result<Option<QuickDistance>, OutOfCoreError> {
        let n = self.spooled.n_blocks();
        let Some(mut distance) = StreamedDistance::new(&self.simplified.mesh, [n_samples, n], seed) else {
            return Ok(None);
        };
        let mut boxes = vec![Bounds::EMPTY; n];
        // The second reading visits only blocks that may be nearer to a sample than those of the first.
        for again in [false, true] {
            let shown: Vec<usize> =
                (0..n).filter(|&number| !again || distance.may_hold_nearer(&boxes[number])).collect();
            for some in shown.chunks(self.n_at_once) {
                report_progress(listener, if again { 1.0 } else { some[0] as f64 / n as f64 })?;
                let look = |&number: &usize| self.measure_block(&distance, number, again);
                for (look, number) in parallel::each(some, look).into_iter().zip(some) {
                    let Some(look) = look? else { continue };
                    boxes[*number] = look.bounds();
                    distance.add(look);
                }
            }
        }
        Ok(Some(distance.finish()))
    }

    fn measure_block(
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

/// Reason for a failed run.
#[derive(Debug)]
#[non_exhaustive]
pub enum OutOfCoreError {
    /// File that cannot be read.
    Read(ReadError),
    /// Disk that failed or is full.
    Disk(std::io::Error),
    /// File without a valid mesh.
    Clean(CleanError),
    /// Mesh that cannot be simplified.
    Simplify(SimplifyError),
    /// Too little memory; the run needs this many bytes.
    TooLittle(u64),
}

impl std::fmt::Display for OutOfCoreError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Read(error) => error.fmt(f),
            Self::Disk(error) => {
                write!(f, "temporary files next to the output failed: {error}: check the folder and the disk")
            }
            Self::Clean(error) => error.fmt(f),
            Self::Simplify(error) => error.fmt(f),
            Self::TooLittle(n_bytes) => {
                let gib = (*n_bytes as f64 / f64::from(1 << 30) * 10.0).ceil() / 10.0;
                write!(f, "this target needs about {gib} GiB of memory: allow more memory or choose a smaller target")
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

/// Simplifies the geometry of a file in blocks.
///
/// Blocks are simplified by the closed assembly with the `options` that [`simplify_block`](super::simplify_block) uses.
///
/// # Errors
/// [`OutOfCoreError`]; too little memory is reported before any work.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::blocks::{WorkingSpace, simplify_pieces};
/// use neural_mesh::{io::Pieces, simplify::{Options, Size}};
/// let pieces = Pieces::open("tests/meshes/spot.ply".as_ref()).unwrap();
/// let room = WorkingSpace { n_bytes: 1 << 30, folder: "".as_ref() };
/// let options = Options::new(Size::Ratio(0.1));
/// let found = simplify_pieces(&pieces, None, &options, &room, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!((found.n_vertices, found.simplified.mesh.positions().len()), (2930, 293));
/// ```
pub fn simplify_pieces(
    pieces: &Pieces,
    weights: Option<&Weights>,
    options: &Options,
    room: &WorkingSpace,
    listener: &mut ProgressCallback,
) -> Result<OutOfCoreResult, OutOfCoreError> {
    simplify_with_block_size(FACES_PER_BLOCK, pieces, (weights, options), room, listener)
}

fn simplify_with_block_size(
    faces_per_block: usize,
    pieces: &Pieces,
    (weights, options): (Option<&Weights>, &Options),
    room: &WorkingSpace,
    listener: &mut ProgressCallback,
) -> Result<OutOfCoreResult, OutOfCoreError> {
    let n_faces = usize::try_from(pieces.n_faces()).unwrap_or(usize::MAX);
    let share = (VERTEX_SURPLUS * options.target.share_of(n_faces / 2, n_faces)).min(1.0);
    check_room(pieces, share, room)?;
    let mut hear = |done: f64| report_progress(listener, done);
    hear(0.0)?;
    let (frame, spooled, n_broken) = cut_file(pieces, faces_per_block, room)?;
    hear(CUT_PROGRESS)?;
    let (mut options, in_blocks) = with_frame(options, frame);
    let n_at_once = parallel_blocks(room);
    let blocks = Blocks { spooled: &spooled, weights, options: &in_blocks, share };
    let (simplified_blocks, mut totals) = blocks.simplify_all(n_at_once, &mut hear)?;
    totals.counts.dropped_faces += n_broken as usize;
    let n_blocks = simplified_blocks.len();
    let joined = join(simplified_blocks).map_err(|_| SimplifyError::Overflow)?;
    if joined.faces().is_empty() {
        return Err(SimplifyError::Empty.into());
    }
    hear(JOINED_PROGRESS)?;
    // Shares are those of the file, which the joined blocks are not.
    options.target = options.target.to_number(totals.n_vertices, totals.n_faces);
    let mut input = Input::bare(&joined);
    let scores = asked_scores(in_blocks.scores, &joined, weights);
    input.scores = &scores;
    let simplified = simplify(input, &options, &mut |event| {
        hear(JOINED_PROGRESS + (1.0 - JOINED_PROGRESS) * f64::from(event.total))
            .map_or(ControlFlow::Break(()), ControlFlow::Continue)
    })?;
    let BlockTotals { counts, n_vertices, n_faces } = totals;
    let n_joined = joined.positions().len();
    Ok(OutOfCoreResult { simplified, frame, counts, n_vertices, n_faces, n_blocks, n_joined, spooled, n_at_once })
}

/// Returns the options for a file of this frame, and those of its blocks, which only the closed assembly simplifies.
fn with_frame(options: &Options, frame: Frame) -> (Options, ClosedOptions) {
    let in_blocks = ClosedOptions { frame, ..options.assembly.as_closed().cloned().unwrap_or_default() };
    let assembly = match &options.assembly {
        Assembly::Closed(_) => Assembly::Closed(in_blocks.clone()),
        paper => paper.clone(),
    };
    (Options::with_assembly(options.target, assembly), in_blocks)
}

/// Reports progress; returns an error if the listener stops the run.
pub(crate) fn report_progress(listener: &mut ProgressCallback, done: f64) -> Result<(), SimplifyError> {
    match listener(done) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(SimplifyError::Interrupted),
    }
}

#[derive(Default)]
struct BlockTotals {
    counts: CleanCounts,
    n_vertices: usize,
    n_faces: usize,
}

impl BlockTotals {
    fn add(&mut self, other: Self) {
        self.counts += other.counts;
        self.n_vertices += other.n_vertices;
        self.n_faces += other.n_faces;
    }
}

struct Blocks<'a> {
    spooled: &'a SpooledBlocks,
    weights: Option<&'a Weights>,
    options: &'a ClosedOptions,
    // Share of all vertices that the blocks keep.
    share: f64,
}

impl Blocks<'_> {
    fn simplify_all(
        &self,
        n_at_once: usize,
        hear: &mut dyn FnMut(f64) -> Result<(), SimplifyError>,
    ) -> Result<(Vec<Block>, BlockTotals), OutOfCoreError> {
        let (price, n_blocks) = (self.price()?, self.spooled.n_blocks());
        let (mut simplified_blocks, mut totals) = (Vec::new(), BlockTotals::default());
        for start in (0..n_blocks).step_by(n_at_once) {
            hear(CUT_PROGRESS + (JOINED_PROGRESS - CUT_PROGRESS) * start as f64 / n_blocks as f64)?;
            let numbers = start..(start + n_at_once).min(n_blocks);
            for made in parallel::each(numbers, |number| self.simplify_stored(number, price)) {
                let (block, block_totals) = made?;
                totals.add(block_totals);
                simplified_blocks.extend(block);
            }
        }
        Ok((simplified_blocks, totals))
    }

    fn read(&self, number: usize) -> Result<StoredBlock, OutOfCoreError> {
        self.spooled.read(number)?.map_err(OutOfCoreError::Clean)
    }

    fn price(&self) -> Result<f64, OutOfCoreError> {
        let n = self.spooled.n_blocks();
        let n_samples = n.div_ceil(SAMPLE_EVERY).min(MAX_SAMPLES);
        // The sampled blocks are spread over the order of blocks.
        let chosen = (0..n_samples).map(|i| (2 * i + 1) * n / (2 * n_samples));
        let mut samples = Vec::new();
        for number in chosen {
            let Some(block) = self.read(number)?.block else { continue };
            samples.push(sample_block(&block, self.share / VERTEX_SURPLUS, self.weights, self.options)?);
        }
        Ok(price_for(&samples, self.share))
    }

    fn simplify_stored(&self, number: usize, price: f64) -> Result<(Option<Block>, BlockTotals), OutOfCoreError> {
        let StoredBlock { block, n_own_vertices, counts } = self.read(number)?;
        let n_faces = block.as_ref().map_or(0, |block: &Block| block.mesh.faces().len());
        let totals = BlockTotals { counts, n_vertices: n_own_vertices, n_faces };
        let simplified_blocks =
            block.map(|block| simplify_block(&block, self.share, price, self.weights, self.options)).transpose()?;
        Ok((simplified_blocks, totals))
    }
}

/// Returns an error if the run needs more memory than allowed.
pub(crate) fn check_room(pieces: &Pieces, share: f64, room: &WorkingSpace) -> Result<(), OutOfCoreError> {
    let n_faces = pieces.n_faces();
    let n_blocks = n_faces.div_ceil(FACES_PER_BLOCK as u64);
    let cutting = pieces.n_memory_bytes().saturating_add(n_blocks.saturating_mul(BYTES_PER_BLOCK));
    let rest = (((share + BORDER_SHARE).min(1.0) * n_faces as f64) as u64).saturating_mul(BYTES_PER_FACE);
    let block = (FACES_PER_BLOCK as u64).min(n_faces) * BYTES_PER_FACE;
    let most = cutting.max(rest).max(block.saturating_add(rest / 8)).saturating_add(32 << 20);
    if most > room.n_bytes { Err(OutOfCoreError::TooLittle(most)) } else { Ok(()) }
}

pub(super) fn parallel_blocks(room: &WorkingSpace) -> usize {
    // Half of the memory is for the blocks that are simplified in parallel.
    let fit = room.n_bytes / 2 / (FACES_PER_BLOCK as u64 * BYTES_PER_FACE);
    rayon::current_num_threads().min(usize::try_from(fit).unwrap_or(usize::MAX)).max(1)
}

/// Sorts the triangles of a file into blocks on disk, and counts the broken faces.
pub(crate) fn cut_file(
    pieces: &Pieces,
    faces_per_block: usize,
    room: &WorkingSpace,
) -> Result<(Frame, SpooledBlocks, u64), OutOfCoreError> {
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
        if n_before.is_multiple_of(COUNT_EVERY) {
            census.count(frame.to_local(p));
        }
        n_before += 1;
    })?;
    let n_faces = usize::try_from(pieces.n_faces()).unwrap_or(usize::MAX);
    let plan = census.plan(n_faces.div_ceil(faces_per_block).max(1));
    let mut spooled = SpooledBlocks::new(room.folder, plan)?;
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
    use crate::simplify::Size;

    fn simplify_file(
        mesh: &TriMesh,
        format: Format,
        n_bytes: u64,
        target: Size,
    ) -> Result<OutOfCoreResult, OutOfCoreError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("a.{}", format.name()));
        std::fs::write(&path, write(mesh, &Frame::default(), format).unwrap()).unwrap();
        let room = WorkingSpace { n_bytes, folder: folder.path() };
        let pieces = Pieces::open(&path).unwrap();
        let mut heard = 0.0;
        let found = simplify_with_block_size(1500, &pieces, (None, &Options::new(target)), &room, &mut |done| {
            assert!((heard..=1.0).contains(&done), "{heard} {done}");
            heard = done;
            ControlFlow::Continue(())
        });
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        found
    }

    #[test]
    fn closed_stays_closed_at_the_requested_size_and_as_near_as_in_memory() {
        let mesh = shapes::wavy_sphere(5, 9.0);
        let options = Options::new(Size::Ratio(0.1));
        let whole = simplify(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap().mesh;
        let distance = |result: &TriMesh| quick_distance(&mesh, result, 20_000, 0).unwrap();
        let mut first = None;
        for format in [Format::Ply, Format::Stl, Format::Obj] {
            let found = simplify_file(&mesh, format, 1 << 30, options.target).unwrap();
            let measured = found.distance(20_000, 0, &mut |_| ControlFlow::Continue(())).unwrap().unwrap();
            let result = found.simplified.mesh;
            assert!(topology(&result).is_closed_manifold() && found.n_blocks > 10, "{format:?}");
            assert_eq!((found.n_vertices, found.n_faces), (mesh.positions().len(), mesh.faces().len()));
            assert_eq!(result.positions().len(), whole.positions().len());
            let [distance, of_whole] = [&result, &whole].map(distance);
            assert!(distance.mean < 1.05 * of_whole.mean, "{distance:?} {of_whole:?}");
            assert!((measured.mean / distance.mean - 1.0).abs() < 1e-2, "{measured:?} {distance:?}");
            assert!((0.98..1.0 + 1e-6).contains(&(measured.max / distance.max)), "{measured:?} {distance:?}");
            // Faces and vertices keep the file's order within each block.
            let first: &TriMesh = first.get_or_insert(result.clone());
            assert!(format == Format::Stl || result.positions().len() == first.positions().len());
        }
    }

    #[test]
    fn neither_memory_nor_threads_change_a_bit() {
        let mesh = shapes::torus(120, 60, 1.0, 0.4);
        let result = |n_bytes| simplify_file(&mesh, Format::Ply, n_bytes, Size::Faces(1000)).unwrap().simplified.mesh;
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
        let refused = simplify_file(&mesh, Format::Ply, 1 << 20, Size::Ratio(0.5)).unwrap_err();
        assert!(matches!(refused, OutOfCoreError::TooLittle(n) if n > 1 << 20), "{refused}");
        assert!(
            refused.to_string().contains("GiB of memory: allow more memory or choose a smaller target"),
            "{refused}"
        );
    }
}
