//! Runs work in parallel: on threads ([`in_parallel`], [`in_order`]) and in wide SIMD registers ([`widely`]).
//!
//! By default a program for x86-64 uses only SIMD registers of two numbers, because every such processor has them. Nearly every
//! processor in use also has registers of four numbers (AVX2) and faster shifts and bit counts (BMI). Slow work is compiled for
//! both kinds of processors.
//!
//! Both versions give the same bits: they use no fused multiplications, and the compiler reorders no sum.

mod threads;

pub use threads::{in_order, in_parallel, threads};

/// Work that is compiled twice: for narrow and for wide SIMD registers.
pub trait Work {
    /// The result of the work.
    type Output;

    /// Does the work. `run` and the slow functions that it calls need `#[inline(always)]`: only code that is inlined into `wide`
    /// is compiled for wide registers.
    fn run(self) -> Self::Output;
}

/// Does the work, with wide SIMD registers if the processor has them.
#[allow(unsafe_code, reason = "the processor is asked first")]
#[inline]
pub fn widely<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if has_wide_registers() {
        // SAFETY: the processor has the features that `wide` is compiled for.
        return unsafe { wide(work) };
    }
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn wide<W: Work>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
fn has_wide_registers() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Steps<'a>(&'a [f64], u32);

    impl Work for Steps<'_> {
        type Output = Vec<u64>;

        #[inline(always)]
        fn run(self) -> Vec<u64> {
            let mut state = 0.3;
            let step = |x: &f64| {
                state = state * x + x / 7.0;
                state.to_bits().rotate_left(self.1) ^ u64::from(x.to_bits().trailing_zeros())
            };
            self.0.iter().map(step).collect()
        }
    }

    /// The narrow and the wide version give the same bits, because both round the product and the sum separately.
    #[test]
    fn the_same_bits() {
        let x: Vec<f64> = (0..1000).map(|i| (0.1 * f64::from(i)).sin()).collect();
        assert_eq!(widely(Steps(&x, 5)), Steps(&x, 5).run());
    }
}
