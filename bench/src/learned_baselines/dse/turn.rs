//! Best rotation or reflection of the plane (orthogonal Procrustes, Schönemann 1966).

/// A rotation, optionally after a reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Cosine and sine of the angle.
    pub cos_sin: [f64; 2],
    /// True to negate the second coordinate first.
    pub reflects: bool,
}

impl Turn {
    /// Returns the turn that minimises the weighted sum of `|turned x - y|^2` over pairs (x, y, weight).
    pub fn fit(pairs: impl IntoIterator<Item = ([f64; 2], [f64; 2], f64)>) -> Self {
        let (mut rotation, mut reflection) = ([0.0; 2], [0.0; 2]);
        for (x, y, weight) in pairs {
            rotation[0] += weight * (x[0] * y[0] + x[1] * y[1]);
            rotation[1] += weight * (x[0] * y[1] - x[1] * y[0]);
            reflection[0] += weight * (x[0] * y[0] - x[1] * y[1]);
            reflection[1] += weight * (x[0] * y[1] + x[1] * y[0]);
        }
        let length = |v: [f64; 2]| v[0].hypot(v[1]);
        // A cloud without normals has no sides, so reflections are allowed; among equal results a rotation wins.
        let reflects = length(reflection) > length(rotation);
        let best = if reflects { reflection } else { rotation };
        let cos_sin = if length(best) > 0.0 { best.map(|x| x / length(best)) } else { [1.0, 0.0] };
        Self { cos_sin, reflects }
    }

    /// Applies the turn to a point.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let y = if self.reflects { -y } else { y };
        let [cos, sin] = self.cos_sin;
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// Applies the inverse turn to a point.
    pub fn unapply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.cos_sin;
        let y_before = cos * y - sin * x;
        [cos * x + sin * y, if self.reflects { -y_before } else { y_before }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(n: usize) -> Vec<[f64; 2]> {
        (0..n).map(|i| [(1.3 * i as f64).sin(), (0.7 * (i * i) as f64).cos()]).collect()
    }

    #[test]
    fn turned_points_are_turned_back() {
        for reflects in [false, true] {
            let turn = Turn { cos_sin: [0.6, -0.8], reflects };
            let found = Turn::fit(points(9).into_iter().map(|x| (x, turn.apply(x), 0.5)));
            assert_eq!(found.reflects, reflects);
            for x in points(9) {
                let [a, b] = [found.apply(x), turn.apply(x)];
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12);
                let back = turn.unapply(b);
                assert!((back[0] - x[0]).hypot(back[1] - x[1]) < 1e-12);
            }
        }
    }

    #[test]
    fn no_other_turn_is_nearer() {
        let (from, to) = (points(7), points(14).split_off(7));
        let error = |turn: &Turn| -> f64 {
            let pairs = from.iter().zip(&to).map(|(x, y)| (turn.apply(*x), y));
            pairs.map(|(x, y)| (x[0] - y[0]).powi(2) + (x[1] - y[1]).powi(2)).sum()
        };
        let best = error(&Turn::fit(from.iter().zip(&to).map(|(x, y)| (*x, *y, 1.0))));
        for step in 0..200 {
            let angle = f64::from(step) * 0.0314;
            let others = [false, true].map(|reflects| Turn { cos_sin: [angle.cos(), angle.sin()], reflects });
            assert!(others.iter().all(|other| error(other) >= best - 1e-9));
        }
    }
}
