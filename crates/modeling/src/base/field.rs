//! The finite field of integers modulo the prime P = 2^61 - 465. Its arithmetic has no rounding, so a zero is exactly zero.
//!
//! A polynomial identity that holds at a random point of this field is true, with an error probability of degree / 2^61 per point
//! [Schwartz 1980]. Lengths are random elements; an angle is a random point (c, s) of the circle c^2 + s^2 = 1, so that no angle
//! needs a value. P is 23 modulo 24. So the field has the square roots of two and three, and every multiple of pi/12 has its
//! cosine and sine. It has no square root of minus one, so 1 + t^2 is never zero.

use random::SplitMix;

/// Difference of 2^61 and the prime P of the field.
const PRIME_OFFSET: u64 = 465;
pub(crate) const P: u64 = (1 << 61) - PRIME_OFFSET;
/// The square roots of two and three modulo P.
const ROOT_2: Residue = Residue(1_986_480_468_971_546_878);
const ROOT_3: Residue = Residue(1_111_797_624_405_771_273);

/// An element x of the finite field, 0 <= x < P.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct Residue(pub u64);

impl Residue {
    pub(crate) const ZERO: Residue = Residue(0);
    pub(crate) const ONE: Residue = Residue(1);

    pub(crate) fn integer(n: i64) -> Residue {
        Residue(n.rem_euclid(P as i64) as u64)
    }

    /// The ratio n/d as a field element.
    pub(crate) fn ratio((n, d): (i128, i128)) -> Residue {
        let element = |x: i128| Residue(x.rem_euclid(i128::from(P)) as u64);
        element(n) * element(d).inverse()
    }

    /// The field element for an f64. If x equals, within rounding, a ratio of small integers or a decimal number (1/3, 0.35),
    /// the element is this ratio. Otherwise the element is the exact binary fraction of x.
    pub(crate) fn number(x: f64) -> Residue {
        match short_ratio(x, DIGITS) {
            Some((n, d)) => Residue::ratio((n.into(), d.into())),
            None => Residue::dyadic(x),
        }
    }

    /// The field element for the exact binary fraction mantissa * 2^power of an f64.
    fn dyadic(x: f64) -> Residue {
        let bits = x.abs().to_bits();
        let exponent = (bits >> 52) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (mantissa, power) = if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
        // 2^(P - 1) = 1 in the field, so a negative power can be replaced by a positive one.
        let scaled = Residue(mantissa) * Residue(2).power(power.rem_euclid(P as i64 - 1) as u64);
        if x < 0.0 { -scaled } else { scaled }
    }

    /// A uniformly random field element, except zero and one.
    pub(crate) fn random(random: &mut SplitMix) -> Residue {
        loop {
            let x = random.bits() >> 3;
            if x < P && x > 1 {
                return Residue(x);
            }
        }
    }

    pub(crate) fn inverse(self) -> Residue {
        self.power(P - 2)
    }

    pub(crate) fn power(self, mut n: u64) -> Residue {
        let (mut square, mut result) = (self, Residue::ONE);
        while n > 0 {
            if n & 1 == 1 {
                result = result * square;
            }
            square = square * square;
            n >>= 1;
        }
        result
    }

    /// A square root in the field, x^((P + 1)/4), because P is 3 modulo 4. `None` if there is no root.
    pub(crate) fn root(self) -> Option<Residue> {
        let root = self.power((P + 1) / 4);
        (root * root == self).then_some(root)
    }

    /// The ratio n/d of integers with |n|, d <= bound that equals this field element; `None` if there is no such ratio.
    pub(crate) fn as_ratio(self, bound: i64) -> Option<(i64, i64)> {
        for d in 1..=bound {
            let n = (self * Residue::integer(d)).0;
            if n <= bound as u64 {
                return Some((n as i64, d));
            }
            if P - n <= bound as u64 {
                return Some((-((P - n) as i64), d));
            }
        }
        None
    }
}

impl std::ops::Add for Residue {
    type Output = Residue;
    fn add(self, b: Residue) -> Residue {
        let sum = self.0 + b.0;
        Residue(if sum >= P { sum - P } else { sum })
    }
}

impl std::ops::Neg for Residue {
    type Output = Residue;
    fn neg(self) -> Residue {
        Residue(if self.0 == 0 { 0 } else { P - self.0 })
    }
}

impl std::ops::Sub for Residue {
    type Output = Residue;
    fn sub(self, b: Residue) -> Residue {
        self + -b
    }
}

impl std::ops::Mul for Residue {
    type Output = Residue;
    fn mul(self, b: Residue) -> Residue {
        // 2^61 = PRIME_OFFSET modulo P, so the high bits are folded. After the first folding, the value above the low 61 bits is
        // less than 2^10.
        let product = u128::from(self.0) * u128::from(b.0);
        let folded = (product >> 61) * u128::from(PRIME_OFFSET) + (product & u128::from(LOW_BITS));
        let sum = (folded >> 61) as u64 * PRIME_OFFSET + (folded as u64 & LOW_BITS);
        Residue(if sum >= P { sum - P } else { sum })
    }
}

const LOW_BITS: u64 = (1 << 61) - 1;

/// Largest denominator of a ratio of small integers that [`small_ratio`] finds.
const MAX_DENOMINATOR: i64 = 1_000_000;
/// Upper bound of the numbers for which [`small_ratio`] searches a ratio of small integers.
const MAX_RATIO: f64 = 1e9;
/// A term of a continued fraction that reaches this bound is the reciprocal of a rounding error.
const MAX_FRACTION_TERM: f64 = 1e12;
/// Largest relative difference between a double and the ratio of integers that represents it: two units in the last place.
const TWO_ULP: f64 = 2.0 * f64::EPSILON;
/// Number of significant digits up to which different decimal numbers are different doubles.
pub(crate) const DIGITS: usize = 15;

/// (n, d) with x = n/d if `x` equals, within two units in the last place, a ratio of small integers or a decimal of `digits`
/// digits.
pub(crate) fn short_ratio(x: f64, digits: usize) -> Option<(i64, i64)> {
    small_ratio(x).or_else(|| {
        let text = format!("{x:.0$e}", digits - 1);
        let is_near = (text.parse::<f64>().ok()? - x).abs() <= TWO_ULP * x.abs();
        let (figures, power) = text.split_once('e').filter(|_| is_near)?;
        let figures = figures.trim_end_matches('0');
        let behind = figures.split_once('.').map_or(0, |(_, behind)| behind.len()) as i32;
        let places = u32::try_from(behind - power.parse::<i32>().ok()?).ok()?;
        Some((figures.replace('.', "").parse().ok()?, 10_i64.checked_pow(places)?))
    })
}

/// (n, d) with a small d if `x` equals n/d within two units in the last place, from the continued fraction of x. About one in a
/// thousand numbers that are no such ratio is taken for one by mistake.
fn small_ratio(x: f64) -> Option<(i64, i64)> {
    let near = |n: i64, d: i64| (x.abs() - n as f64 / d as f64).abs() <= TWO_ULP * x.abs();
    if x.is_nan() || x.abs() >= MAX_RATIO {
        return None;
    }
    let ((mut n, mut n_before), (mut d, mut d_before)) = ((1_i64, 0_i64), (0_i64, 1_i64));
    let mut rest = x.abs();
    loop {
        let whole = rest.floor();
        if whole.is_nan() || whole >= MAX_FRACTION_TERM {
            return None;
        }
        (n, n_before) = ((whole as i64).checked_mul(n)?.checked_add(n_before)?, n);
        (d, d_before) = ((whole as i64).checked_mul(d)?.checked_add(d_before)?, d);
        if d > MAX_DENOMINATOR {
            return None;
        }
        if near(n, d) {
            return Some((if x < 0.0 { -n } else { n }, d));
        }
        rest = 1.0 / (rest - whole);
    }
}

/// The field elements of one named constant: one element for the value as a length, and (cos, sin) for the value as an angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Assignment {
    pub length: Residue,
    pub cos: Residue,
    pub sin: Residue,
}

impl Assignment {
    pub(crate) fn random(random: &mut SplitMix) -> Assignment {
        let length = Residue::random(random);
        let (cos, sin) = circle(random);
        Assignment { length, cos, sin }
    }
}

/// A point (cos, sin) of the circle over the finite field, which represents an angle.
pub(crate) type CirclePoint = (Residue, Residue);

/// A random point of the circle over the finite field: ((1 - t^2), 2 t) / (1 + t^2) with random t.
pub(crate) fn circle(random: &mut SplitMix) -> CirclePoint {
    let t = Residue::random(random);
    let scale = (Residue::ONE + t * t).inverse();
    ((Residue::ONE - t * t) * scale, (t + t) * scale)
}

/// The point (cos, sin) of the sum of two angles.
pub(crate) fn turned((a, b): CirclePoint, (c, d): CirclePoint) -> CirclePoint {
    (a * c - b * d, a * d + b * c)
}

/// The point (cos, sin) of n times an angle.
pub(crate) fn times(mut point: CirclePoint, mut n: u128) -> CirclePoint {
    let mut sum = (Residue::ONE, Residue::ZERO);
    while n > 0 {
        if n & 1 == 1 {
            sum = turned(sum, point);
        }
        point = turned(point, point);
        n >>= 1;
    }
    sum
}

/// Cosine and sine in the field of an angle in rad, if the angle is a multiple of pi/12 within rounding; otherwise `None`.
pub(crate) fn twelfth_turn(angle: f64) -> Option<CirclePoint> {
    let twelfths = (angle / (std::f64::consts::PI / 12.0)).round();
    if (angle - twelfths * (std::f64::consts::PI / 12.0)).abs() > 4.0 * f64::EPSILON * angle.abs() {
        return None;
    }
    // In the field: cos(pi/12) = (sqrt(6) + sqrt(2)) / 4, sin(pi/12) = (sqrt(6) - sqrt(2)) / 4.
    let quarter = Residue::integer(4).inverse();
    let (six, two) = (ROOT_2 * ROOT_3 * quarter, ROOT_2 * quarter);
    Some(times((six + two, six - two), twelfths.rem_euclid(24.0) as u128))
}

/// Solves A x = b over the finite field by elimination. Each of `rows` is [a_1 .. a_n b]. `None` if there is no solution, or
/// more than one solution.
pub(crate) fn solve(mut rows: Vec<Vec<Residue>>, n: usize) -> Option<Vec<Residue>> {
    for c in 0..n {
        let pivot = (c..rows.len()).find(|&r| rows[r][c] != Residue::ZERO)?;
        rows.swap(c, pivot);
        let scale = rows[c][c].inverse();
        for x in &mut rows[c][c..] {
            *x = *x * scale;
        }
        let (head, tail) = rows.split_at_mut(c + 1);
        let pivot = &head[c];
        for row in tail {
            let factor = row[c];
            if factor != Residue::ZERO {
                for k in c..=n {
                    row[k] = row[k] - factor * pivot[k];
                }
            }
        }
    }
    if rows[n..].iter().any(|row| row[n] != Residue::ZERO) {
        return None;
    }
    let mut x = vec![Residue::ZERO; n];
    for c in (0..n).rev() {
        let known = (c + 1..n).fold(Residue::ZERO, |s, k| s + rows[c][k] * x[k]);
        x[c] = rows[c][n] - known;
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic() {
        let half = Residue::number(0.5);
        assert_eq!(half + half, Residue::ONE);
        assert_eq!(Residue::number(-3.0), Residue::integer(-3));
        assert_eq!(Residue::number(0.1), Residue::ratio((1, 10)));
        assert_eq!(Residue::number(4.0 / 3.0) * Residue::integer(3), Residue::integer(4));
        // Neither number is a decimal of few digits, so both become their exact binary fractions.
        let digits = 0.123_456_789_012_345_67;
        assert_eq!(Residue::number(digits) * Residue::number(1.0 / 1024.0), Residue::number(digits / 1024.0));
        assert_eq!(Residue(P - 1) * Residue(P - 1), Residue::ONE);
        let x = Residue::random(&mut SplitMix(7));
        assert_eq!(x * x.inverse(), Residue::ONE);
        assert_eq!((Residue::integer(-2) * Residue::integer(3).inverse()).as_ratio(100), Some((-2, 3)));
        let (c, s) = circle(&mut SplitMix(1));
        assert_eq!(c * c + s * s, Residue::ONE);
        let root = (x * x).root().unwrap();
        assert!(root == x || root == -x);
        assert_eq!((-(x * x)).root(), None);
    }

    #[test]
    fn twelfths_of_pi_are_on_the_circle_and_add_up() {
        for k in -13..14 {
            let (c, s) = twelfth_turn(f64::from(k) * std::f64::consts::PI / 12.0).unwrap();
            assert_eq!(c * c + s * s, Residue::ONE);
            let one = twelfth_turn(std::f64::consts::PI / 12.0).unwrap();
            assert_eq!(turned((c, s), one), twelfth_turn(f64::from(k + 1) * std::f64::consts::PI / 12.0).unwrap());
        }
        let half = Residue::integer(2).inverse();
        assert_eq!(twelfth_turn(std::f64::consts::FRAC_PI_3).unwrap().0, half);
        assert_eq!(twelfth_turn(std::f64::consts::FRAC_PI_6).unwrap().1, half);
        assert_eq!(twelfth_turn(std::f64::consts::FRAC_PI_2).unwrap(), (Residue::ZERO, Residue::ONE));
        assert!(twelfth_turn(0.78).is_none());
    }

    #[test]
    fn small_ratios_are_found() {
        assert_eq!(small_ratio(4.0 / 3.0), Some((4, 3)));
        assert_eq!(small_ratio(-0.8024), Some((-1003, 1250)));
        assert_eq!(small_ratio(3.0), Some((3, 1)));
        assert_eq!(small_ratio(0.0), Some((0, 1)));
        assert_eq!(small_ratio(1.0 / 3.0 + 1e-12), None);
        assert_eq!(small_ratio(std::f64::consts::PI), None);
        assert_eq!(small_ratio(f64::INFINITY).or(small_ratio(f64::NAN)), None);
        // Decimal numbers with up to 15 digits are found, and also the product of two decimal numbers, which is rounded as a
        // double.
        assert_eq!(short_ratio(0.761_236_88, 12), Some((76_123_688, 100_000_000)));
        assert_eq!(short_ratio(0.8024 * 0.9487, 12), Some((76_123_688, 100_000_000)));
        assert_eq!(short_ratio(-0.123_456_789_012_345, DIGITS), Some((-123_456_789_012_345, 1_000_000_000_000_000)));
        assert_eq!(short_ratio(0.123_456_789_012_345, 12), None);
        for x in [std::f64::consts::PI, f64::INFINITY, f64::NAN, 1e300, 1e-300] {
            assert_eq!(short_ratio(x, DIGITS), None, "{x}");
        }
    }

    #[test]
    fn solves_and_refuses() {
        let row = |v: [i64; 3]| v.map(Residue::integer).to_vec();
        let rows = vec![row([0, 1, 2]), row([1, 1, 3]), row([1, 2, 5])];
        assert_eq!(solve(rows, 2), Some(vec![Residue::ONE, Residue::integer(2)]));
        assert_eq!(solve(vec![row([1, 1, 3]), row([2, 2, 6])], 2), None);
        assert_eq!(solve(vec![row([1, 0, 3]), row([0, 1, 6]), row([1, 1, 1])], 2), None);
    }
}
