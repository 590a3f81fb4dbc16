//! Work that threads share, in the order of its numbers.
//!
//! Iterators of rayon are generic up to its threads, and each use compiles all of that. These functions share
//! [`run`], which is compiled once. Results have the same bits on any number of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Pieces of rows for each thread: enough to even out what some take longer.
const PIECES: usize = 8;

/// Calls `act` with each number below `n`, on the threads of the present pool.
pub fn run(n: usize, act: &(dyn Fn(usize) + Sync)) {
    if n < 2 || rayon::current_num_threads() < 2 {
        (0..n).for_each(act);
    } else {
        (0..n).into_par_iter().with_max_len(1).for_each(act);
    }
}

/// Does two pieces of work side by side, and returns what both gave.
pub fn join<A: Send, B: Send>(one: impl FnOnce() -> A + Send, other: impl FnOnce() -> B + Send) -> (A, B) {
    fn both(one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        rayon::join(one, other);
    }
    let (mut one, mut other) = (Some(one), Some(other));
    let (mut of_one, mut of_other) = (None, None);
    both(&mut || of_one = one.take().map(|act| act()), &mut || of_other = other.take().map(|act| act()));
    (of_one.expect("it has run"), of_other.expect("it has run"))
}

/// Calls `act` with each task, and returns what it gave in their order.
pub fn each<T: Send, R: Send>(tasks: impl IntoIterator<Item = T>, act: impl Fn(T) -> R + Sync) -> Vec<R> {
    // Plain loops: adapters of iterators would be compiled for each kind of task once more.
    let mut slots = Vec::new();
    for task in tasks {
        slots.push(Mutex::new((Some(task), None)));
    }
    run(slots.len(), &|number| {
        let task = open(&slots[number]).0.take();
        let made = task.map(&act);
        open(&slots[number]).1 = made;
    });
    let mut all = Vec::with_capacity(slots.len());
    for slot in &slots {
        all.push(open(slot).1.take().expect("each number is run"));
    }
    all
}

fn open<T>(slot: &Mutex<T>) -> MutexGuard<'_, T> {
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the value of each number below `n`; no thread takes fewer than `least` at once.
pub fn map<R: Send>(n: usize, least: usize, value: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let size = piece(n, least);
    if n <= size {
        return (0..n).map(value).collect();
    }
    let pieces = each((0..n).step_by(size), |start| (start..n.min(start + size)).map(&value).collect::<Vec<R>>());
    let mut all = Vec::with_capacity(n);
    pieces.into_iter().for_each(|piece| all.extend(piece));
    all
}

/// Lists what each of some numbers gives, in order; no thread takes fewer than `least` numbers at once.
pub fn flat_map<I: IntoIterator<Item: Send>>(
    numbers: Range<usize>,
    least: usize,
    items: impl Fn(usize) -> I + Sync,
) -> impl Iterator<Item = I::Item> {
    let size = piece(numbers.len(), least);
    let pieces = each(numbers.clone().step_by(size), |start| {
        (start..numbers.end.min(start + size)).flat_map(&items).collect::<Vec<_>>()
    });
    pieces.into_iter().flatten()
}

/// Merges the values of all numbers below `n`, in any order; `None` if there are none.
///
/// Each thread holds one value, and another while it is merged.
pub fn reduce<R: Send>(n: usize, value: impl Fn(usize) -> R + Sync, merge: impl Fn(R, R) -> R + Sync) -> Option<R> {
    let n_tasks = rayon::current_num_threads().min(n);
    let merged = each(0..n_tasks, |task| (task..n).step_by(n_tasks).map(&value).reduce(&merge));
    merged.into_iter().flatten().reduce(merge)
}

/// Returns whether `is_so` of a number below `n`; no number is asked for once the answer is known.
pub fn any(n: usize, least: usize, is_so: impl Fn(usize) -> bool + Sync) -> bool {
    let is_found = AtomicBool::new(false);
    let size = piece(n, least);
    run(n.div_ceil(size), &|piece| {
        let mut numbers = piece * size..n.min((piece + 1) * size);
        if numbers.any(|number| is_found.load(Relaxed) || is_so(number)) {
            is_found.store(true, Relaxed);
        }
    });
    is_found.into_inner()
}

/// Sets each item to the value of its number; no thread takes fewer than `least` at once.
pub fn fill<T: Send>(items: &mut [T], least: usize, value: impl Fn(usize) -> T + Sync) {
    change(items, least, |number, item| *item = value(number));
}

/// Calls `act` with each number and its item; no thread takes fewer than `least` at once.
pub fn change<T: Send>(items: &mut [T], least: usize, act: impl Fn(usize, &mut T) + Sync) {
    let size = piece(items.len(), least);
    chunks_mut(items, size, |chunk, items| {
        (chunk * size..).zip(items).for_each(|(number, item)| act(number, item));
    });
}

/// Calls `act` with the number of each row of `width` items and the row; no thread takes fewer than `least` rows at once.
pub fn rows_mut<T: Send>(items: &mut [T], width: usize, least: usize, act: impl Fn(usize, &mut [T]) + Sync) {
    let width = width.max(1);
    let size = piece(items.len() / width, least);
    chunks_mut(items, size * width, |chunk, items| {
        (chunk * size..).zip(items.chunks_mut(width)).for_each(|(number, row)| act(number, row));
    });
}

/// Calls `act` with the number of each chunk of `size` items and the chunk; the last may be shorter.
pub fn chunks_mut<T: Send>(items: &mut [T], size: usize, act: impl Fn(usize, &mut [T]) + Sync) {
    each(items.chunks_mut(size).enumerate(), |(chunk, items)| act(chunk, items));
}

/// Returns what each chunk of `size` items gives, in order; `act` gets its number, and the last chunk may be shorter.
pub fn chunks<T: Sync, R: Send>(items: &[T], size: usize, act: impl Fn(usize, &[T]) -> R + Sync) -> Vec<R> {
    each(items.chunks(size).enumerate(), |(chunk, items)| act(chunk, items))
}

/// Returns the number of rows in a piece of `n` rows; one thread takes all at once.
fn piece(n: usize, least: usize) -> usize {
    let n_pieces = match rayon::current_num_threads() {
        1 => 1,
        n_threads => PIECES * n_threads,
    };
    n.div_ceil(n_pieces).max(least).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_threads<R: Send>(n: usize, act: impl FnOnce() -> R + Send) -> R {
        rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(act)
    }

    #[test]
    fn everything_is_done_once_and_in_order_on_any_number_of_threads() {
        for threads in [1, 3] {
            for n in [0, 1, 2, 1000] {
                let squares: Vec<usize> = (0..n).map(|i| i * i).collect();
                for least in [0, 1, 7, 5000] {
                    assert_eq!(on_threads(threads, || map(n, least, |i| i * i)), squares);
                    let mut filled = vec![0; n];
                    on_threads(threads, || fill(&mut filled, least, |i| i * i));
                    assert_eq!(filled, squares);
                    on_threads(threads, || change(&mut filled, least, |i, item| *item += i));
                    assert!(filled.iter().enumerate().all(|(i, &item)| item == i * i + i));
                }
                let twice = on_threads(threads, || flat_map(5..n.max(5), 7, |i| [i, i]).collect::<Vec<_>>());
                assert_eq!(twice, (5..n.max(5)).flat_map(|i| [i, i]).collect::<Vec<_>>());
                let asked = |wanted: usize| on_threads(threads, || any(n, 3, |i| i == wanted));
                assert_eq!([asked(0), asked(n), asked(n / 2)], [n > 0, false, n > 0]);
                let mut rows = vec![0; 3 * n];
                on_threads(threads, || rows_mut(&mut rows, 3, 2, |i, row| row.copy_from_slice(&[i, i + 1, i + 2])));
                assert_eq!(rows, (0..n).flat_map(|i| [i, i + 1, i + 2]).collect::<Vec<_>>());
                let texts = squares.iter().map(|square| square.to_string());
                assert_eq!(on_threads(threads, || each(texts.clone(), |text| text)), texts.collect::<Vec<_>>());
                let sums = on_threads(threads, || chunks(&squares, 3, |at, some| (at, some.iter().sum::<usize>())));
                let naive = squares.chunks(3).enumerate().map(|(at, some)| (at, some.iter().sum()));
                assert_eq!(sums, naive.collect::<Vec<(usize, usize)>>());
            }
            assert_eq!(on_threads(threads, || reduce(0, |i| i, usize::max)), None);
            assert_eq!(on_threads(threads, || reduce(100, |i| i * 7 % 101, usize::max)), Some(100));
            assert_eq!(on_threads(threads, || join(|| 1, || "two")), (1, "two"));
        }
    }

    #[test]
    fn a_panic_of_one_task_reaches_the_caller() {
        let run = |threads| on_threads(threads, || map(100, 1, |i| assert!(i != 57, "no {i}")));
        for threads in [1, 3] {
            assert!(std::panic::catch_unwind(|| run(threads)).is_err());
        }
    }
}
