//! The choice of lanes at run time.

use super::eight::Kernel;
#[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
use super::plain::PlainLanes as StaticLanes;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
use super::simd128::Simd128Lanes as StaticLanes;

/// Runs a kernel with the widest lanes that this processor has.
pub(crate) fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    let kernel = match super::avx2::run_if_present(kernel) {
        Ok(output) => return output,
        Err(kernel) => kernel,
    };
    kernel.run::<StaticLanes>()
}

/// Runs a kernel with plain arrays, as on processors without AVX2.
#[cfg(test)]
pub(crate) fn run_plain<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<super::plain::PlainLanes>()
}

#[cfg(test)]
mod tests {
    use super::super::eight::*;
    use super::*;
    use crate::collapse::rings::Vertex;

    struct EveryOperation([f32; 8], [f32; 8]);

    impl Kernel for EveryOperation {
        type Output = Vec<u32>;

        #[inline(always)]
        fn run<L: EightLanes>(self) -> Vec<u32> {
            let mut out = Vec::new();
            let quadrics = [VertexQuadric(self.0), VertexQuadric(self.1)];
            let rows = L::load_quadrics(&quadrics, &[0, 1, 1, 0, 1, 0, 0, 1]);
            let (a, b) = (rows[0], rows[1]);
            let mask = a.greater(b);
            let lanes = [a + b, a - b, a * b, a / b, (a * a).sqrt(), a.min(b), a.max(b), mask, a.and(mask)];
            let more = [mask.select(a, b), L::mask_first(3), a.permute(&[3, 2, 1, 0, 7, 7, 5, 4]), L::splat(2.5)];
            for x in lanes.into_iter().chain(more).chain(rows) {
                out.extend(x.to_array().map(f32::to_bits));
            }
            out.extend(L::sum_rows(rows).map(f32::to_bits));
            out.extend(L::sum_four_rows([a, b, rows[2], rows[3]]).map(f32::to_bits));
            out.extend([mask.to_bits(), a.find_least().0.to_bits(), a.find_least().1 as u32]);
            let vertices: Vec<Vertex> =
                self.0.iter().enumerate().map(|(i, &x)| Vertex::new([x, x * x, self.1[i]], i as u32)).collect();
            for x in L::load_points(&vertices, &[7, 0, 3, 3, 2, 1, 6, 5]) {
                out.extend(x.to_array().map(f32::to_bits));
            }
            let raw = [3, 9, 1, 4, 7, 0, 2, 5];
            out.extend(L::load_numbers(&[5, 4, 3, 2, 1, 0, 9, 8, 7, 6], &raw));
            out.extend(L::keep_first(&raw, 5, 77));
            let (mut us, mut vs) = ([0; 8], [0; 8]);
            let n = L::keep_above(&raw, 6, 3, &mut us, &mut vs);
            out.extend(vs[..n].iter().chain(&us[..n]));
            let mut best = vec![u64::MAX; 10];
            assert!(!L::lower_prices(&mut best, 1, &us, &raw, a));
            assert!(L::lower_prices(&mut best, 0, &us, &raw, a * a));
            out.extend(best.iter().flat_map(|&x| [x as u32, (x >> 32) as u32]));
            out
        }
    }

    #[test]
    fn all_lanes_give_the_bits_of_plain_arrays() {
        let (a, b) = ([0.1, -2.7, 3.3, 4.9, 1e-20, -6.0, 7.5, 0.25], [1.5, 2.5, -0.3, 4.7, 8.1, 1e10, -7.5, 3.0]);
        assert_eq!(dispatch(EveryOperation(a, b)), run_plain(EveryOperation(a, b)));
        assert_eq!(dispatch(EveryOperation(b, a)), run_plain(EveryOperation(b, a)));
    }
}
