//! Sine and cosine, computed with the same operations as in generated files. So the tape (the interpreter of functions) gives the
//! same bits as generated code.
//!
//! A multiple of pi/2 is subtracted from the angle, so that the result is in [-pi/4, pi/4]. For this, pi/2 is the sum of three
//! numbers [Cody, Waite 1980]. Then the minimax polynomials of fdlibm are evaluated. The error is below 2e-16 for |x| < 2^27; for
//! larger |x| the result is NaN. `codegen` copies the statements from here.

/// The text of this file. Generated files contain the statements of `sin_cos`, which compute sine and cosine from `angle` and
/// `fused`.
pub const SINE_SOURCE: &str = include_str!("sine.rs");

/// Sine and cosine of an angle in rad. `fused(a, b, c)` computes a b + c, rounded once or twice.
#[inline(always)]
pub(crate) fn sin_cos(angle: f64, fused: impl Fn(f64, f64, f64) -> f64) -> (f64, f64) {
    // Adding 1.5 * 2^52 to a number rounds it to an integer, which is in the low bits of the sum.
    const ROUND: f64 = 6755399441055744.0;
    const REACH: f64 = 1.3393857589828342e300;
    const PARTS: [f64; 3] = [1.570796251296997, 7.549789415861596e-8, 5.390302858158119e-15];
    let turns = fused(angle, core::f64::consts::FRAC_2_PI, ROUND);
    let quadrant = turns.to_bits();
    let n = turns - ROUND;
    // For |angle| >= 2^27 this product overflows and makes the result NaN. There, n has so many digits that n times the first
    // number of `PARTS` is no longer exact.
    let reach = angle * REACH;
    let x = fused(-n, PARTS[2], fused(-n, PARTS[1], fused(-n, PARTS[0], angle)));
    let x = x * fused(0.0, reach, 1.0);
    let z = x * x;
    let s = fused(z, 1.58969099521155e-10, -2.5050760253406863e-8);
    let s = fused(z, fused(z, s, 2.7557313707070068e-6), -1.984126982985795e-4);
    let s = fused(z, fused(z, s, 8.33333333332249e-3), -1.6666666666666632e-1);
    let s = fused(x * z, s, x);
    let c = fused(z, -1.1359647557788195e-11, 2.087572321298175e-9);
    let c = fused(z, fused(z, c, -2.7557314351390663e-7), 2.480158728947673e-5);
    let c = fused(z, fused(z, c, -1.388888888887411e-3), 4.16666666666666e-2);
    let c = fused(z * z, c, fused(-0.5, z, 1.0));
    let (s, c) = if quadrant & 1 == 0 { (s, c) } else { (c, s) };
    let sign = |x: f64, bits: u64| f64::from_bits(x.to_bits() ^ (bits & 2) << 62);
    (sign(s, quadrant), sign(c, quadrant.wrapping_add(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_to_an_ulp_with_and_without_fusing() {
        for k in -4000..=4000 {
            let x = f64::from(k) * 0.0317;
            for (s, c) in [sin_cos(x, f64::mul_add), sin_cos(x, |a, b, c| a * b + c)] {
                // Allowed error: 2e-16 of this function, and half an ulp of the library function.
                assert!((s - x.sin()).abs() < 2.6e-16 && (c - x.cos()).abs() < 2.6e-16, "{x}");
            }
        }
        for x in [f64::NAN, f64::INFINITY, -1e9, f64::MAX] {
            assert!(sin_cos(x, f64::mul_add).0.is_nan() && sin_cos(x, f64::mul_add).1.is_nan());
        }
    }
}
