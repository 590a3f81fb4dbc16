//! Which sample each vertex belongs to: the regions.

/// Which sample each vertex belongs to.
pub struct Assignment {
    /// For each vertex the index of its sample, below `n_regions`.
    pub region: Vec<u32>,
    /// Number of samples.
    pub n_regions: usize,
    /// The vertex that each region grew from, as the darts left them.
    pub samples: Vec<u32>,
}

impl Assignment {
    /// Every vertex its own sample.
    pub fn identity(n_vertices: usize) -> Self {
        let region: Vec<u32> = (0..n_vertices as u32).collect();
        Self { samples: region.clone(), region, n_regions: n_vertices }
    }

    /// Gives each of these vertices a region of its own; whether there was one.
    pub fn set_apart(&mut self, vertices: impl Iterator<Item = u32>) -> bool {
        let n_before = self.n_regions;
        for v in vertices {
            self.region[v as usize] = self.n_regions as u32;
            self.n_regions += 1;
        }
        if self.n_regions == n_before {
            return false;
        }
        self.drop_empty(n_before);
        true
    }

    /// Renumbers the regions without those of the first `n_first` that hold nothing any more.
    fn drop_empty(&mut self, n_first: usize) {
        let mut taken = vec![false; n_first];
        self.region.iter().filter(|&&r| (r as usize) < n_first).for_each(|&r| taken[r as usize] = true);
        let mut number = 0;
        let numbers: Vec<u32> = (0..self.n_regions)
            .map(|r| {
                let is_one = taken.get(r).copied().unwrap_or(true);
                number += u32::from(is_one);
                number.wrapping_sub(1)
            })
            .collect();
        self.region.iter_mut().for_each(|r| *r = numbers[*r as usize]);
        self.n_regions = number as usize;
    }
}
