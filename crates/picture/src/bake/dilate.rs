//! Extension of charts beyond their borders, since viewers blend neighbouring texels.

use super::texel::{Texel, TexelPlace};
use crate::parallel;

/// Distance in texels to which charts are extended: five mipmap levels stay clean.
const REACH: usize = 32;

/// Gives each texel outside the charts the content of the nearest chart texel within [`REACH`].
pub(super) fn dilate(texels: &mut [Texel], size: usize) {
    let nearest = nearest_rows(texels, size);
    let rows = texels.chunks(size).zip(nearest.chunks(size)).enumerate();
    let found = parallel::each(rows, |(row, (texels, nearest))| sources(row, texels, nearest));
    // Any colour of the charts is better than black in the coarsest levels.
    let fallback = texels.iter().find(|texel| texel.place != TexelPlace::Outside).copied().unwrap_or_default();
    for (to, from) in found.into_iter().flatten() {
        texels[to] = Texel { place: TexelPlace::Dilated, ..texels[from] };
    }
    parallel::change(texels, 1 << 14, |_, texel| {
        if texel.place == TexelPlace::Outside {
            *texel = Texel { place: TexelPlace::Outside, ..fallback };
        }
    });
}

// Returns for each texel the row of the nearest chart texel in its column within `REACH`, or `u32::MAX`.
fn nearest_rows(texels: &[Texel], size: usize) -> Vec<u32> {
    let mut nearest = vec![u32::MAX; texels.len()];
    // Two sweeps find the nearest rows by column; rows are searched from their results.
    sweep(texels, size, 0..size, &mut nearest);
    sweep(texels, size, (0..size).rev(), &mut nearest);
    nearest
}

fn sweep(texels: &[Texel], size: usize, rows: impl Iterator<Item = usize>, nearest: &mut [u32]) {
    let mut last = vec![u32::MAX; size];
    for row in rows {
        let distance = |other: u32| if other == u32::MAX { usize::MAX } else { row.abs_diff(other as usize) };
        for (column, last) in last.iter_mut().enumerate() {
            let at = row * size + column;
            if texels[at].place != TexelPlace::Outside {
                *last = row as u32;
            }
            if distance(*last) <= REACH && distance(*last) < distance(nearest[at]) {
                nearest[at] = *last;
            }
        }
    }
}

fn sources(row: usize, texels: &[Texel], nearest: &[u32]) -> Vec<(usize, usize)> {
    let size = texels.len();
    let mut found = Vec::new();
    for column in (0..size).filter(|&column| texels[column].place == TexelPlace::Outside) {
        let mut best = (REACH * REACH + 1, 0);
        // The search goes outwards from the texel's own column, while something nearer is possible.
        for step in 0..=REACH {
            if step * step >= best.0 {
                break;
            }
            for other in [column.checked_sub(step), Some(column + step).filter(|&other| other < size)] {
                let Some(other) = other.filter(|&other| nearest[other] != u32::MAX) else { continue };
                let down = row.abs_diff(nearest[other] as usize);
                best = best.min((step * step + down * down, nearest[other] as usize * size + other));
            }
        }
        found.extend((best.0 <= REACH * REACH).then_some((row * size + column, best.1)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sparse(size: usize, every: u32) -> Vec<Texel> {
        let texel = |at: u32| {
            let is_inside = at.wrapping_mul(2_654_435_761).is_multiple_of(every);
            let colour = [at as u8, (at >> 8) as u8, 7];
            if is_inside { Texel { colour, place: TexelPlace::Inside, ..Texel::default() } } else { Texel::default() }
        };
        (0..(size * size) as u32).map(texel).collect()
    }

    fn naive(texels: &[Texel], size: usize, at: usize) -> Vec<(usize, [u8; 3])> {
        let inside = texels.iter().enumerate().filter(|(_, texel)| texel.place == TexelPlace::Inside);
        let distance2 = |other: usize| {
            let across = (at % size).abs_diff(other % size);
            let down = (at / size).abs_diff(other / size);
            across * across + down * down
        };
        inside.map(|(other, texel)| (distance2(other), texel.colour)).collect()
    }

    #[test]
    fn each_texel_outside_has_what_the_nearest_one_has() {
        for every in [2, 17, 400, 3000] {
            let size = 60;
            let texels = sparse(size, every);
            let mut dilated = texels.clone();
            dilate(&mut dilated, size);
            for (at, texel) in dilated.iter().enumerate() {
                let all = naive(&texels, size, at);
                let least = all.iter().map(|(distance2, _)| *distance2).min().unwrap();
                let is_one = |colour| all.iter().any(|&(distance2, other)| distance2 == least && other == colour);
                assert!(is_one(texel.colour) || least > REACH * REACH, "{every} {at}: {texel:?}");
                let place = match least {
                    0 => TexelPlace::Inside,
                    _ if least <= REACH * REACH => TexelPlace::Dilated,
                    _ => TexelPlace::Outside,
                };
                assert_eq!(texel.place, place, "{every} {at}");
            }
        }
    }

    #[test]
    fn nothing_to_carry_is_no_trouble() {
        let mut texels = vec![Texel::default(); 16 * 16];
        dilate(&mut texels, 16);
        assert_eq!(texels, vec![Texel::default(); 16 * 16]);
    }
}
