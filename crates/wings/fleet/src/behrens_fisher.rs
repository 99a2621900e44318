//! The distribution of the difference of two means whose standard deviations were estimated separately.
//!
//! The means x_1, x_2 have estimated standard deviations s_1, s_2 with nu_1, nu_2 degrees of freedom. If the true means are
//! equal, a difference as large as d = x_1 - x_2 has the probability
//!   p = P(|s_1 T_1 + s_2 T_2| > |d|),   T_i of Student's t with nu_i degrees of freedom    [Behrens 1929; Fisher 1935]
//! This p is exact or conservative [Robinson 1976]. A single t with (s_1^2 + s_2^2)^2 / (s_1^4/nu_1 + s_2^4/nu_2) degrees of
//! freedom [Welch 1947] is simpler and accurate at 5 %, but not in the far tail, because its degrees of freedom come from the
//! same s as the standard deviation. If s_1 is small by chance, d / s is large, and s_2 with its many degrees of freedom seems to
//! dominate; then the tail probability is underestimated. With 13 and 60 degrees of freedom and s_1^2 = 4 s_2^2, the method of
//! Welch reports twice the expected number of 500 robots as changed. A test below shows the effect.
//!
//! Let |s_2| <= |s_1|, t = |d|, S(., nu): probability above a value under Student's t, f: density of T_2. By the symmetry of T_2,
//!   p = 2 int f(u) S((t - s_2 u) / s_1, nu_1) du,   u = sqrt(nu_2) sinh x,   f(u) du = C cosh(x)^-nu_2 dx
//! (C: a constant). The integrand decreases exponentially and is smooth, so the trapezoidal rule converges exponentially.

use numerics::student::two_sided;

/// The density f of T_2 is neglected where it is below this fraction of its value at the centre. No relevant p-value is that
/// small.
const NEGLIGIBLE_DENSITY_SHARE: f64 = 1e-18;

/// Largest step of the integration variable x, if T_2 has few degrees of freedom.
const LARGEST_STEP: f64 = 0.05;
/// Largest step of x in standard deviations of x, 1 / sqrt(nu). With steps of h standard deviations, the integral of a normal
/// density has a relative error of exp(-2 pi^2 / h^2). In the worst case (a difference of thirty standard deviations, one degree
/// of freedom), p has a relative error of 1/300.
const LARGEST_STEP_SIGMAS: f64 = 0.5;
/// Largest number of degrees of freedom of T_2. With more, T_2 counts as a normal variable.
const MAX_DEGREES_OF_FREEDOM: f64 = 1e5;
/// Smallest number of degrees of freedom. With fewer, the density is too wide for the integration.
const MIN_DEGREES_OF_FREEDOM: f64 = 0.5;

/// An estimated standard deviation, and its degrees of freedom.
pub(crate) type Estimated = (f64, f64);

/// The probability that |s_1 T_1 + s_2 T_2| exceeds |difference|: `one` and `other` are s and degrees of freedom of the two
/// means. It is 1 if a standard deviation has no degrees of freedom.
pub(crate) fn two_sided_difference(difference: f64, one: Estimated, other: Estimated) -> f64 {
    let (large, small) = if one.0 >= other.0 { (one, other) } else { (other, one) };
    let t = difference.abs();
    if !(large.0 > 0.0 && t.is_finite()) {
        return 1.0;
    }
    if small.0 <= 0.0 {
        return two_sided(t / large.0, large.1);
    }
    if !(large.1 >= MIN_DEGREES_OF_FREEDOM && small.1 >= MIN_DEGREES_OF_FREEDOM) {
        return 1.0;
    }
    // With more degrees of freedom than `MAX_DEGREES_OF_FREEDOM`, T_2 cannot be distinguished from a normal variable.
    let freedom = small.1.min(MAX_DEGREES_OF_FREEDOM);
    let step = LARGEST_STEP.min(LARGEST_STEP_SIGMAS / freedom.sqrt());
    let end = (-NEGLIGIBLE_DENSITY_SHARE.ln() / freedom).exp().acosh();
    let count = (end / step).ceil() as i64;
    let (mut sum, mut mass) = (0.0, 0.0);
    for k in -count..=count {
        let x = step * k as f64;
        let density = (-freedom * x.cosh().ln()).exp();
        let reached = (t - small.0 * freedom.sqrt() * x.sinh()) / large.0;
        let beyond = 0.5 * two_sided(reached, large.1);
        sum += density * if reached > 0.0 { beyond } else { 1.0 - beyond };
        mass += density;
    }
    // `mass` is the integral of the density alone, with the same steps. So the constant C cancels in the quotient.
    (2.0 * sum / mass).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use random::Random;

    /// With one degree of freedom each, T_1 and T_2 are Cauchy variables, and their sum is a Cauchy variable whose scale is the
    /// sum of the scales. With many degrees of freedom, the sum is normal.
    #[test]
    fn closed_forms() {
        for (t, one, other) in [(3.0, 0.8, 0.6), (30.0, 0.6, 0.8), (0.2, 1.0, 0.01), (5.0, 1.0, 1.0)] {
            let p = two_sided_difference(t, (one, 1.0), (other, 1.0));
            let error = (p / two_sided(t / (one + other), 1.0) - 1.0).abs();
            // S changes over a width of s_1 / t in x. So steps of 0.05 are less accurate if t is large.
            assert!(error < if t > 10.0 { 3e-3 } else { 1e-5 }, "{t}: {p}");
            let p = two_sided_difference(t, (one, 1e9), (other, 1e9));
            let normal = two_sided(t / f64::hypot(one, other), 1e9);
            // Degrees of freedom above 1e5 count as 1e5; this increases the tail by a factor of at most 1 + t^4 / 4e5.
            assert!((p / normal - 1.0).abs() < 1e-3 || normal < 1e-30, "{t}: {p} {normal}");
        }
        let alone = two_sided_difference(-4.0, (1.0, 7.0), (1e-9, 3.0));
        assert!((alone / two_sided(4.0, 7.0) - 1.0).abs() < 1e-6);
        assert_eq!(two_sided_difference(4.0, (1.0, 7.0), (0.0, 0.0)), two_sided(4.0, 7.0));
        for nothing in [(0.0, 5.0), (1.0, 0.0), (f64::NAN, 5.0), (1.0, f64::NAN)] {
            assert_eq!(two_sided_difference(4.0, nothing, (0.0, 5.0)), 1.0);
        }
        assert_eq!(two_sided_difference(4.0, (1.0, 5.0), (1.0, 0.0)), 1.0);
        assert_eq!(two_sided_difference(f64::NAN, (1.0, 5.0), (1.0, 5.0)), 1.0);
        assert_eq!(two_sided_difference(0.0, (1.0, 5.0), (1.0, 5.0)), 1.0);
    }

    /// Few logs are compared with many. At a level of 0.001, the share of rejections is at most 0.001; with Welch's degrees of
    /// freedom it is three times as large.
    #[test]
    fn the_tail_is_held() {
        let mut random = Random::new(12);
        let mut deviation = |variance: f64, freedom: usize| {
            let square = (0..freedom).map(|_| random.normal().powi(2)).sum::<f64>();
            (random.normal() * variance.sqrt(), (variance * square / freedom as f64).sqrt())
        };
        let (draws, level) = (200_000, 1e-3);
        let (mut held, mut welch) = (0, 0);
        for _ in 0..draws {
            let ((a, s), (b, r)) = (deviation(0.8, 6), deviation(0.2, 60));
            let (d, sigma) = ((a - b).abs(), f64::hypot(s, r));
            // Of all these distributions, the normal distribution has the smallest tails. Its quantile at 0.001 is 3.29, so a
            // difference below 3.2 standard deviations is never rejected and needs no computation.
            if d < 3.2 * sigma {
                continue;
            }
            held += i32::from(two_sided_difference(d, (s, 6.0), (r, 60.0)) < level);
            let freedom = sigma.powi(4) / (s.powi(4) / 6.0 + r.powi(4) / 60.0);
            welch += i32::from(two_sided(d / sigma, freedom) < level);
        }
        // 200 rejections are expected, with a standard deviation of 14. The upper limit is three standard deviations above. Fewer
        // rejections mean that the test is conservative.
        assert!((60..243).contains(&held), "{held}");
        assert!(welch > 300, "{welch}");
    }
}
