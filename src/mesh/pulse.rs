//! A pulse: the beats that long loops give while they run, by which whoever listens hears how far they are, and can end them.
//!
//! A loop over millions of items, deep in a kernel and on any thread, has nowhere to return "stop" to: every function on the way,
//! and every iterator of rayon, would carry a `Result` for the sake of the one run in thousands that is stopped. A beat that ends
//! the work unwinds instead, as cancellation does in salsa; what that takes, and where it is caught, stands with who listens
//! (`simplify::progress`). Here nothing is known of it: a beat calls a function, which may not return.
//!
//! A beat costs a call and comes once for thousands of items.

use std::ops::Range;

use rayon::prelude::*;

/// Rows that a thread takes at once: enough that handing them out costs nothing beside the work on them.
pub(crate) const PARALLEL: usize = 4096;
/// Items between two beats: a few milliseconds of work on one thread.
const CHUNK: usize = 1 << 16;

/// Takes beats, each with the number of items done since the one before; or nothing.
#[derive(Clone, Copy, Default)]
pub(crate) struct Pulse<'a> {
    heard: Option<&'a (dyn Fn(usize) + Sync)>,
    /// Whether items are not to be counted.
    is_silent: bool,
}

impl<'a> Pulse<'a> {
    /// Nobody listens.
    pub const NONE: Self = Self { heard: None, is_silent: false };

    /// Beats go to a function, which may end the work by unwinding.
    pub fn new(heard: &'a (dyn Fn(usize) + Sync)) -> Self {
        Self { heard: Some(heard), is_silent: false }
    }

    /// The same, but no items are counted where the condition does not hold: for loops of which each thread runs one over the same
    /// items.
    pub fn counting_if(self, counts: bool) -> Self {
        Self { is_silent: self.is_silent || !counts, ..self }
    }

    /// A beat: so many items are done since the last one.
    #[inline]
    pub fn beat(self, n_items: usize) {
        if let Some(heard) = self.heard {
            heard(if self.is_silent { 0 } else { n_items });
        }
    }

    /// The items in chunks, a beat before each and one after the last.
    #[inline]
    pub fn over<T>(self, items: &[T]) -> impl Iterator<Item = &[T]> {
        self.through(0..items.len()).map(|range| &items[range])
    }

    /// The numbers of a range in chunks, a beat before each and one after the last.
    #[inline]
    pub fn through(self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        self.by(CHUNK, range)
    }

    /// The numbers of a range in chunks of so many, a beat before each and one after the last.
    #[inline]
    pub fn by(self, chunk: usize, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let (mut begin, mut n_before) = (range.start, 0);
        std::iter::from_fn(move || {
            self.beat(n_before);
            let next = begin..range.end.min(begin + chunk);
            (begin, n_before) = (next.end, next.len());
            (!next.is_empty()).then_some(next)
        })
    }

    /// What a function makes of each item, side by side.
    pub fn map<T: Sync, R: Send>(self, items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
        let mut all = Vec::with_capacity(items.len());
        for items in self.over(items) {
            all.par_extend(items.par_iter().with_min_len(PARALLEL).map(&of));
        }
        all
    }

    /// What a function makes of each number below `n`, side by side.
    pub fn map_numbers<R: Send>(self, n: usize, of: impl Fn(usize) -> R + Sync) -> Vec<R> {
        let mut all = Vec::with_capacity(n);
        for numbers in self.through(0..n) {
            all.par_extend(numbers.into_par_iter().with_min_len(PARALLEL).map(&of));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    #[test]
    fn every_item_comes_once_and_is_counted_once() {
        let (n_items, n_beats) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let heard = |n| {
            n_items.fetch_add(n, Relaxed);
            n_beats.fetch_add(1, Relaxed);
        };
        let pulse = Pulse::new(&heard);
        let items: Vec<usize> = (0..3 * CHUNK + 5).collect();
        assert!(pulse.over(&items).flatten().eq(&items));
        assert_eq!((n_items.swap(0, Relaxed), n_beats.load(Relaxed)), (items.len(), 5));
        assert_eq!(pulse.map(&items, |&x| 2 * x), items.iter().map(|x| 2 * x).collect::<Vec<_>>());
        assert_eq!(n_items.swap(0, Relaxed), items.len());
        assert_eq!(pulse.counting_if(false).map_numbers(items.len(), |x| x), items);
        assert_eq!(n_items.load(Relaxed), 0);
        assert!(pulse.over::<usize>(&[]).next().is_none());
    }
}
