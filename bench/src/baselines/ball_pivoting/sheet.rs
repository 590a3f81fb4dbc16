//! The faces found so far and their open edges.

use rustc_hash::FxHashSet;

// No directed edge is in two faces, so no edge has more than two faces.
pub(super) struct Sheet {
    pub(super) faces: Vec<[u32; 3]>,
    edges: FxHashSet<[u32; 2]>,
    n_faces: Vec<u32>,
    n_open: Vec<u32>,
}

impl Sheet {
    pub(super) fn new(n_points: usize) -> Self {
        let none = || vec![0; n_points];
        Self { faces: Vec::new(), edges: FxHashSet::default(), n_faces: none(), n_open: none() }
    }

    pub(super) fn is_free(&self, v: u32) -> bool {
        self.n_faces[v as usize] == 0
    }

    pub(super) fn is_open(&self, [a, b]: [u32; 2]) -> bool {
        self.edges.contains(&[a, b]) && !self.edges.contains(&[b, a])
    }

    pub(super) fn can_take(&self, [a, b, c]: [u32; 3]) -> bool {
        let has_room = |v: u32| self.is_free(v) || self.n_open[v as usize] > 0;
        [a, b, c].into_iter().all(has_room) && ![[a, b], [b, c], [c, a]].iter().any(|edge| self.edges.contains(edge))
    }

    pub(super) fn add(&mut self, face: [u32; 3]) {
        let [a, b, c] = face;
        self.faces.push(face);
        for [v, w] in [[a, b], [b, c], [c, a]] {
            self.edges.insert([v, w]);
            let closes = self.edges.contains(&[w, v]);
            for end in [v, w] {
                let open = &mut self.n_open[end as usize];
                *open = if closes { *open - 1 } else { *open + 1 };
            }
            self.n_faces[v as usize] += 1;
        }
    }
}
