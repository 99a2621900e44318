//! Work compiled for registers of four doubles where the processor has them.
//!
//! No product is fused with a sum here, and no sum is regrouped, so that every processor computes the same bits.

#![allow(unsafe_code, reason = "the processor has been asked")]

/// Work that is compiled for narrow and for wide registers.
pub trait Work {
    /// Does it. To be marked `#[inline(always)]`, as what it calls: a call leads to code for narrow registers.
    fn run(self);
}

/// Does work, in AVX2's registers where the processor has them.
#[inline]
pub fn in_wide_registers(work: impl Work) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what `by_avx2` is compiled for.
        return unsafe { by_avx2(work) };
    }
    work.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn by_avx2(work: impl Work) {
    work.run();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of products and sums, which a fused operation would round otherwise.
    struct Chain<'a>(&'a mut [[f64; 8]]);

    impl Work for Chain<'_> {
        #[inline(always)]
        fn run(self) {
            let mut z = [0.0; 8];
            for x in self.0 {
                for lane in 0..8 {
                    z[lane] = 0.7 * z[lane] + x[lane];
                    x[lane] = z[lane] - 0.3 * x[lane];
                }
            }
        }
    }

    #[test]
    fn the_bits_are_those_of_narrow_registers() {
        let mut narrow: Vec<[f64; 8]> =
            (0..1000).map(|i| std::array::from_fn(|lane| (0.1 * (i * lane) as f64).sin())).collect();
        let mut wide = narrow.clone();
        in_wide_registers(Chain(&mut wide));
        Chain(&mut narrow).run();
        assert_eq!(wide, narrow);
    }
}
