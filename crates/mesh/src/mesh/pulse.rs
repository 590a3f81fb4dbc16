//! Reports the progress of long loops to a listener, which can end them by unwinding.

use std::ops::Range;

use crate::parallel;

#[doc(hidden)]
pub const PARALLEL: usize = 4096;
const CHUNK: usize = 1 << 16;

/// An optional listener that receives the number of items done since the last call.
#[derive(Clone, Copy, Default)]
#[doc(hidden)]
pub struct Pulse<'a> {
    listener: Option<&'a (dyn Fn(usize) + Sync)>,
    is_silent: bool,
}

impl<'a> Pulse<'a> {
    pub const NONE: Self = Self { listener: None, is_silent: false };

    pub fn new(listener: &'a (dyn Fn(usize) + Sync)) -> Self {
        Self { listener: Some(listener), is_silent: false }
    }

    /// Returns a pulse that reports 0 items unless `counts`.
    pub fn counting_if(self, counts: bool) -> Self {
        Self { is_silent: self.is_silent || !counts, ..self }
    }

    #[inline]
    pub fn beat(self, n_items: usize) {
        if let Some(listener) = self.listener {
            listener(if self.is_silent { 0 } else { n_items });
        }
    }

    /// Splits items into chunks; reports finished items before each and after the last.
    #[inline]
    pub fn chunks<T>(self, items: &[T]) -> impl Iterator<Item = &[T]> {
        self.ranges(0..items.len()).map(|range| &items[range])
    }

    #[inline]
    pub fn ranges(self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        self.ranges_of_size(CHUNK, range)
    }

    #[inline]
    pub fn ranges_of_size(self, chunk: usize, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let (mut begin, mut n_before) = (range.start, 0);
        std::iter::from_fn(move || {
            self.beat(n_before);
            let next = begin..range.end.min(begin + chunk);
            (begin, n_before) = (next.end, next.len());
            (!next.is_empty()).then_some(next)
        })
    }

    pub fn map<T: Sync, R: Send>(self, items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
        self.map_numbers(items.len(), |i| of(&items[i]))
    }

    pub fn map_numbers<R: Send>(self, n: usize, of: impl Fn(usize) -> R + Sync) -> Vec<R> {
        let mut all = Vec::with_capacity(n);
        for numbers in self.ranges(0..n) {
            all.extend(parallel::map(numbers.len(), PARALLEL, |i| of(numbers.start + i)));
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
        let listener = |n| {
            n_items.fetch_add(n, Relaxed);
            n_beats.fetch_add(1, Relaxed);
        };
        let pulse = Pulse::new(&listener);
        let items: Vec<usize> = (0..3 * CHUNK + 5).collect();
        assert!(pulse.chunks(&items).flatten().eq(&items));
        assert_eq!((n_items.swap(0, Relaxed), n_beats.load(Relaxed)), (items.len(), 5));
        assert_eq!(pulse.map(&items, |&x| 2 * x), items.iter().map(|x| 2 * x).collect::<Vec<_>>());
        assert_eq!(n_items.swap(0, Relaxed), items.len());
        assert_eq!(pulse.counting_if(false).map_numbers(items.len(), |x| x), items);
        assert_eq!(n_items.load(Relaxed), 0);
        assert!(pulse.chunks::<usize>(&[]).next().is_none());
    }
}
