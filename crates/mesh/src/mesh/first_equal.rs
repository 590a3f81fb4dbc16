//! Finds equal items, such as vertices at one position.

const BATCH: usize = 32;

/// Returns the first item with the same `key` as each item, and whether any two are equal.
pub fn first_equal(n_items: usize, key: impl Fn(usize) -> [u32; 3]) -> (Vec<u32>, bool) {
    const FREE: u32 = u32::MAX;
    let n_slots = (n_items + n_items / 2).next_power_of_two().max(BATCH);
    let shift = 64 - n_slots.trailing_zeros();
    let mut table = vec![FREE; n_slots];
    let mut first: Vec<u32> = Vec::with_capacity(n_items);
    let mut repeated = false;
    for start in (0..n_items).step_by(BATCH) {
        let n_batch = BATCH.min(n_items - start);
        let keys: [[u32; 3]; BATCH] = std::array::from_fn(|i| if i < n_batch { key(start + i) } else { [0; 3] });
        let slots = keys.map(|key| (hash(key) >> shift) as usize);
        // Prefetches the slots; the value is not needed yet.
        std::hint::black_box(slots.iter().fold(0, |touched, &slot| touched ^ table[slot]));
        for i in 0..n_batch {
            let mut slot = slots[i];
            while table[slot] != FREE && key(table[slot] as usize) != keys[i] {
                slot = (slot + 1) & (n_slots - 1);
            }
            if table[slot] == FREE {
                table[slot] = (start + i) as u32;
            } else {
                repeated = true;
            }
            first.push(table[slot]);
        }
    }
    (first, repeated)
}

pub type PositionKey = [u32; 3];

/// Returns the bits of a position, equal for 0 and -0.
pub fn position_key(position: [f32; 3]) -> PositionKey {
    position.map(|x| (x + 0.0).to_bits())
}

/// Returns the first vertex at each vertex's position, and whether any two share one.
pub fn join_positions(positions: &[[f32; 3]]) -> (Vec<u32>, bool) {
    first_equal(positions.len(), |v| position_key(positions[v]))
}

fn hash([x, y, z]: [u32; 3]) -> u64 {
    let low = (u64::from(x) | u64::from(y) << 32) ^ 0x9e37_79b9_7f4a_7c15;
    let high = u64::from(z) ^ 0xd1b5_4a32_d192_ed03;
    let product = u128::from(low) * u128::from(high);
    ((product as u64) ^ (product >> 64) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

#[cfg(test)]
mod tests {
    use super::first_equal;

    #[test]
    fn agrees_with_a_search_from_the_start() {
        let keys: Vec<[u32; 3]> = (0..500u32).map(|i| [i * i % 7, i % 5, i * 3 % 4]).collect();
        let (first, repeated) = first_equal(keys.len(), |i| keys[i]);
        for (i, &found) in first.iter().enumerate() {
            assert_eq!(keys.iter().position(|key| *key == keys[i]), Some(found as usize));
        }
        assert!(repeated);
        assert_eq!(first_equal(2, |i| [i as u32; 3]), (vec![0, 1], false));
        assert_eq!(first_equal(0, |_| [0; 3]), (vec![], false));
    }
}
