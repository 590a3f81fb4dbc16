//! Vertex ranges per thread.

use std::ops::Range;

use super::pulse::Pulse;
use crate::linalg::Rows;
use crate::parallel;

const LEAST: usize = 20_000;
const CHUNK: usize = 8192;

/// Splits `0..n_vertices` into consecutive ranges, at most one per thread.
#[doc(hidden)]
pub fn thread_ranges(n_vertices: usize) -> Vec<Range<usize>> {
    let n = rayon::current_num_threads().min(n_vertices / LEAST).max(1);
    (0..n).map(|i| n_vertices * i / n..n_vertices * (i + 1) / n).collect()
}

/// Splits `rows` by the vertex ranges `shares`; the rows of a vertex end at index `end(vertex)`.
#[doc(hidden)]
pub fn split_rows<'a, T>(
    shares: &[Range<usize>],
    mut rows: &'a mut [T],
    end: impl Fn(usize) -> usize,
) -> Vec<&'a mut [T]> {
    let mut begin = 0;
    let mut parts = Vec::with_capacity(shares.len());
    for share in shares {
        let stop = share.clone().next_back().map_or(begin, &end);
        let (part, rest) = std::mem::take(&mut rows).split_at_mut(stop - begin);
        parts.push(part);
        (rows, begin) = (rest, stop);
    }
    parts
}

/// Adds the value `of` each face to its vertices' rows, in face order.
#[doc(hidden)]
pub fn add_faces<T: Send, F>(
    pulse: Pulse,
    rows: &mut [T],
    faces: &[[u32; 3]],
    of: impl Fn(usize) -> F + Sync,
    add: impl Fn(&mut T, &F, usize) + Sync,
) {
    let shares = thread_ranges(rows.len());
    let is_whole = shares.len() == 1;
    parallel::each(shares.iter().zip(split_rows(&shares, rows, |v| v + 1)), |(share, rows)| {
        for numbers in pulse.counting_if(share.start == 0).ranges(0..faces.len()) {
            for (f, face) in numbers.clone().zip(&faces[numbers]) {
                if is_whole || face.iter().any(|&v| share.contains(&(v as usize))) {
                    let of_face = of(f);
                    for (corner, &v) in face.iter().enumerate() {
                        if let Some(row) = rows.get_mut((v as usize).wrapping_sub(share.start)) {
                            add(row, &of_face, corner);
                        }
                    }
                }
            }
        }
    });
}

/// Sorts an item per corner into rows by vertex, in face order.
///
/// `item` gets the number of the face and its vertices in order, that of the corner first.
#[doc(hidden)]
pub fn corner_rows<T: Copy + Default + Send>(
    pulse: Pulse,
    n_vertices: usize,
    faces: &[[u32; 3]],
    item: impl Fn(u32, [u32; 3]) -> T + Sync,
) -> Rows<T> {
    let mut starts = vec![0u32; n_vertices + 1];
    add_faces(pulse, &mut starts[1..], faces, |_| (), |n_corners, (), _| *n_corners += 1);
    (0..n_vertices).for_each(|v| starts[v + 1] += starts[v]);
    let mut items = vec![T::default(); 3 * faces.len()];
    let shares = thread_ranges(n_vertices);
    let parts = split_rows(&shares, &mut items, |v| starts[v + 1] as usize);
    parallel::each(shares.iter().zip(parts), |(share, items)| {
        let mut slots: Vec<u32> = starts[share.clone()].iter().map(|start| start - starts[share.start]).collect();
        for numbers in pulse.counting_if(share.start == 0).ranges(0..faces.len()) {
            for (f, &[a, b, c]) in (numbers.start as u32..).zip(&faces[numbers]) {
                for corner in [[a, b, c], [b, c, a], [c, a, b]] {
                    if let Some(slot) = slots.get_mut((corner[0] as usize).wrapping_sub(share.start)) {
                        items[*slot as usize] = item(f, corner);
                        *slot += 1;
                    }
                }
            }
        }
    });
    Rows { starts, items }
}

#[doc(hidden)]
pub fn indices_where<T: Sync>(pulse: Pulse, items: &[T], is_wanted: impl Fn(u32, &T) -> bool + Sync) -> Vec<u32> {
    let of_chunk = |chunk: usize, items: &[T]| -> Vec<u32> {
        pulse.beat(items.len());
        let numbered = ((chunk * CHUNK) as u32..).zip(items);
        numbered.filter(|&(i, item)| is_wanted(i, item)).map(|(i, _)| i).collect()
    };
    parallel::chunks(items, CHUNK, of_chunk).concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_added_in_their_order() {
        let n = 3 * LEAST as u32;
        let faces: Vec<[u32; 3]> = (0..n).map(|f| [f, (7 * f + 1) % n, (f * f) % n]).collect();
        let mut naive = vec![Vec::new(); n as usize];
        let corners = faces.iter().enumerate().flat_map(|(f, face)| (0..3).map(move |i| (face[i], [f, i])));
        corners.for_each(|(v, corner)| naive[v as usize].push(corner));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let mut rows = vec![Vec::new(); n as usize];
        pool.install(|| add_faces(Pulse::NONE, &mut rows, &faces, |f| f, |row, &f, corner| row.push([f, corner])));
        assert_eq!(rows, naive);
    }

    #[test]
    fn indices_are_those_that_a_look_at_all_finds() {
        let items: Vec<u32> = (0..3 * CHUNK as u32 + 5).map(|i| i * i % 101).collect();
        let naive: Vec<u32> = (0..items.len() as u32).filter(|&i| items[i as usize] < 7 && i % 3 > 0).collect();
        assert_eq!(indices_where(Pulse::NONE, &items, |i, &item| item < 7 && i % 3 > 0), naive);
        assert!(indices_where(Pulse::NONE, &[0; 0], |_, _| true).is_empty());
    }

    #[test]
    fn shares_are_all_vertices_in_order() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        for n in [0, 1, 5 * LEAST + 1] {
            let shares = pool.install(|| thread_ranges(n));
            assert_eq!(shares.len(), if n < LEAST { 1 } else { 3 });
            assert_eq!(shares.iter().cloned().flatten().collect::<Vec<_>>(), (0..n).collect::<Vec<_>>());
            let mut rows: Vec<usize> = (0..2 * n).collect();
            let parts = split_rows(&shares, &mut rows, |v| 2 * (v + 1));
            assert!(
                parts.iter().zip(&shares).all(|(part, share)| part.iter().copied().eq(2 * share.start..2 * share.end))
            );
        }
    }
}
