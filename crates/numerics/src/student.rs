//! Student's t distribution (an error divided by its estimated standard deviation) and Fisher's F distribution (the mean square
//! of several such errors).
//!
//! P(|T| > t) = I_x(nu/2, 1/2), x = nu / (nu + t^2) [Abramowitz, Stegun 1964, 26.7.1], with the incomplete beta function
//! as a continued fraction [Abramowitz, Stegun 1964, 26.5.8].

/// Degrees of freedom are limited to this number. With more, t has practically a normal distribution.
const MAX_DEGREES_OF_FREEDOM: f64 = 1e5;
/// Squares are limited to this value, so that f64 does not overflow.
const MAX_SQUARE: f64 = 1e300;
/// Quantiles are limited to about this value.
const MAX_QUANTILE: f64 = 1e12;
/// Number of bisections for a quantile. After this number, the interval is as small as the rounding of f64.
const BISECTIONS: usize = 60;
/// `MAX_TERMS`: maximum number of terms of the continued fraction. `FRACTION_TOLERANCE`: relative change at which the continued
/// fraction ends.
const MAX_TERMS: i32 = 5000;
const FRACTION_TOLERANCE: f64 = 1e-15;

/// The probability that the magnitude of Student's t variable T exceeds `t`. `freedom`: degrees of freedom; if it is not
/// positive, the probability is 1.
pub fn two_sided(t: f64, freedom: f64) -> f64 {
    if freedom.is_nan() || freedom <= 0.0 || t.is_nan() {
        return 1.0;
    }
    let (nu, square) = (freedom.min(MAX_DEGREES_OF_FREEDOM), (t * t).min(MAX_SQUARE));
    let sum = nu + square;
    incomplete_beta(0.5 * nu, 0.5, nu / sum, square / sum)
}

/// The value t that |T| exceeds with probability `alpha`. T: Student's t variable with `freedom` degrees of freedom. If
/// `freedom` is not positive, the value is infinite.
pub fn two_sided_quantile(alpha: f64, freedom: f64) -> f64 {
    if freedom.is_nan() || freedom <= 0.0 {
        return f64::INFINITY;
    }
    let mut high = 1.0;
    while two_sided(high, freedom) > alpha && high < MAX_QUANTILE {
        high *= 2.0;
    }
    let mut low = 0.0;
    // Each step halves the interval.
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if two_sided(middle, freedom) > alpha { low = middle } else { high = middle }
    }
    high
}

/// The probability that a value of Fisher's F distribution with m and n degrees of freedom exceeds `f`: I_x(n/2, m/2) with x =
/// n / (n + m f) [Abramowitz, Stegun 1964, 26.6.2]; if m or n is not positive, the probability is 1.
pub fn exceeded(f: f64, m: f64, n: f64) -> f64 {
    if f.is_nan() || m.is_nan() || n.is_nan() || m <= 0.0 || n <= 0.0 || f <= 0.0 {
        return 1.0;
    }
    let n = n.min(MAX_DEGREES_OF_FREEDOM);
    let above = (m * f).min(MAX_SQUARE);
    incomplete_beta(0.5 * n, 0.5 * m, n / (n + above), above / (n + above))
}

/// The regularised incomplete beta function I_x(a, b). `rest` is 1 - x with full accuracy, also if x is near 1.
fn incomplete_beta(a: f64, b: f64, x: f64, rest: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if rest <= 0.0 {
        return 1.0;
    }
    // For larger x the continued fraction converges slowly. The symmetry I_x(a, b) = 1 - I_(1-x)(b, a) is used instead.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, rest, x);
    }
    let factor = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * x.ln() + b * rest.ln();
    factor.exp() / (a * fraction(a, b, x))
}

/// The continued fraction 1 + d_1 / (1 + d_2 / (1 + ..)) in I_x(a, b), computed from the front by Lentz's method.
fn fraction(a: f64, b: f64, x: f64) -> f64 {
    const SMALLEST_DENOMINATOR: f64 = 1e-300;
    let (mut value, mut above, mut below) = (1.0_f64, 1.0_f64, 0.0_f64);
    for k in 1..MAX_TERMS {
        let m = f64::from(k / 2);
        let d = match k % 2 {
            0 => m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            _ => -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        };
        below = 1.0 / nonzero(1.0 + d * below, SMALLEST_DENOMINATOR);
        above = nonzero(1.0 + d / above, SMALLEST_DENOMINATOR);
        let change = above * below;
        value *= change;
        if (change - 1.0).abs() < FRACTION_TOLERANCE {
            break;
        }
    }
    value
}

fn nonzero(x: f64, tiny: f64) -> f64 {
    if x.abs() < tiny { tiny } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The probabilities equal the values in Abramowitz, Stegun, table 26.9. With (1, n) degrees of freedom, F is the square of
    /// Student's t with n degrees of freedom.
    #[test]
    fn f_is_that_of_the_tables() {
        for (f, m, n, q) in [(3.10, 3.0, 20.0, 0.05), (4.94, 3.0, 20.0, 0.01), (2.53, 4.0, 60.0, 0.05)] {
            // The values in the table have three digits.
            assert!((exceeded(f, m, n) / q - 1.0).abs() < 0.02, "{f}: {}", exceeded(f, m, n));
        }
        assert!((exceeded(4.0, 1.0, 7.0) - two_sided(2.0, 7.0)).abs() < 1e-14);
        assert_eq!((exceeded(f64::NAN, 1.0, 7.0), exceeded(3.0, 1.0, 0.0), exceeded(-1.0, 1.0, 7.0)), (1.0, 1.0, 1.0));
    }

    #[test]
    fn closed_forms() {
        for t in [0.1, 0.9, 2.0, 7.5, 40.0] {
            let one = 1.0 - 2.0 / std::f64::consts::PI * f64::atan(t);
            let two = 1.0 - t / (2.0_f64 + t * t).sqrt();
            // One and two degrees of freedom have closed forms. These closed forms lose digits in the subtraction from 1.
            assert!((two_sided(t, 1.0) - one).abs() < 1e-13, "{t}");
            assert!((two_sided(t, 2.0) - two).abs() < 1e-13, "{t}");
            assert!((two_sided(-t, 2.0) - two).abs() < 1e-13, "{t}");
        }
        assert!((two_sided(1.959963984540054, 1e9) - 0.05).abs() < 1e-5);
        assert_eq!((two_sided(3.0, 0.0), two_sided(0.0, 5.0)), (1.0, 1.0));
    }

    /// The quantiles equal the values of the usual tables: 12.706, 2.1314, 1.9600.
    #[test]
    fn reach_is_the_inverse() {
        for (freedom, t) in [(1.0, 12.7062), (15.0, 2.13145), (1e9, 1.95996)] {
            assert!((two_sided_quantile(0.05, freedom) - t).abs() < 2e-4, "{freedom}");
        }
        assert!(two_sided(30.0, 15.0) < 1e-13 && two_sided(30.0, 15.0) > 0.0);
        assert_eq!(two_sided_quantile(0.05, 0.0), f64::INFINITY);
    }
}
