//! What a processor has more than one of: threads ([`in_parallel`], [`in_order`]), and numbers in a register ([`widely`]).
//!
//! A program for x86-64 may use what each of them has: registers of two numbers, and shifts through one fixed register.
//! Nearly every one in use has registers of four, and shifts and bit counts of any. What takes long is compiled for both.
//!
//! Fused multiplications are not among what is used, and the compiler reorders no sum: both give the same bits.

mod threads;

pub use threads::{in_order, in_parallel, threads};

/// What is compiled for both.
pub trait Work {
    /// What comes of it.
    type Output;

    /// Does it. `#[inline(always)]`, and so is what takes long in it: only what becomes part of the function that is compiled for
    /// wide registers uses them.
    fn run(self) -> Self::Output;
}

/// Does the work in wide registers, where the processor has them.
#[allow(unsafe_code, reason = "the processor is asked first")]
#[inline]
pub fn widely<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if has_wide_registers() {
        // SAFETY: the processor has what `wide` is compiled for.
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

    /// A sum after a product is rounded twice in both.
    #[test]
    fn the_same_bits() {
        let x: Vec<f64> = (0..1000).map(|i| (0.1 * f64::from(i)).sin()).collect();
        assert_eq!(widely(Steps(&x, 5)), Steps(&x, 5).run());
    }
}
