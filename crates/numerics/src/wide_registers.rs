//! Work compiled for registers of four doubles where the processor has them.
//!
//! No product is fused with a sum here, and no sum is regrouped, so that every processor computes the same bits.

#![allow(unsafe_code, reason = "the processor has been asked")]

/// Runs `work`, compiled for AVX2 where the processor has it. What `work` calls has to be inlined into it.
#[inline]
pub fn in_wide_registers<T>(work: impl FnOnce() -> T) -> T {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what `by_avx2` is compiled for.
        return unsafe { by_avx2(work) };
    }
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn by_avx2<T>(work: impl FnOnce() -> T) -> T {
    work()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of products and sums, which a fused operation would round otherwise.
    #[test]
    fn the_bits_are_those_of_narrow_registers() {
        let chain = |x: &mut [[f64; 8]]| {
            let mut z = [0.0; 8];
            for x in x {
                for lane in 0..8 {
                    z[lane] = 0.7 * z[lane] + x[lane];
                    x[lane] = z[lane] - 0.3 * x[lane];
                }
            }
        };
        let mut narrow: Vec<[f64; 8]> =
            (0..1000).map(|i| std::array::from_fn(|lane| (0.1 * (i * lane) as f64).sin())).collect();
        let mut wide = narrow.clone();
        in_wide_registers(|| chain(&mut wide));
        chain(&mut narrow);
        assert_eq!(wide, narrow);
    }
}
