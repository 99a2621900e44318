//! A clamped quintic B-spline as the motion of one coordinate, from rest to rest at one position.
//!
//! ```text
//! q(t) = sum_i P_i N_i(u),   u = K t / T,   knots 0 (six times), 1, .., K - 1, K (six times)
//! ```
//! [Piegl, Tiller 1997, chapters 2 and 3]: T is the duration; there are K spans of T/K seconds and K + 5 control points P. The
//! first three and the last three equal the position c, so velocity and acceleration vanish at both ends. The others are c + d_i,
//! i = 1 .. K - 1. The basis functions N add up to one, so every quantity is linear in (c, d_1, d_2, ..). The jerk and its
//! derivative are continuous.

/// Degree of the spline's polynomials between knots.
pub(crate) const SPLINE_DEGREE: usize = 5;

/// Duration and number of spans of a quintic spline motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuinticSpline {
    /// Time T from rest to rest, s.
    pub period: f64,
    /// Number of spans K.
    pub spans: usize,
}

impl QuinticSpline {
    /// Knot number i of the clamped spline, in units of u (spans).
    pub(crate) fn knot(&self, i: usize) -> f64 {
        i.saturating_sub(SPLINE_DEGREE).min(self.spans) as f64
    }

    /// The k-th derivative (k <= 5) of the coordinate at time `t` after the start (s) as factors of (c, d_1, d_2, ..).
    ///
    /// Recursion of B-splines [Piegl, Tiller 1997, sections 2.2 and 2.3] in u = K t / T, with the knots t_m: a function N of
    /// degree p - 1 that is not zero on [t_m, t_{m+p}] contributes to two functions of degree p. The contribution to N_m is
    /// (u - t_m) / (t_{m+p} - t_m) N, and the contribution to N_{m-1} is (t_{m+p} - u) / (t_{m+p} - t_m) N. The contributions
    /// to the derivatives by u have the factor p / (t_{m+p} - t_m) for N_m, and -p / (t_{m+p} - t_m) for N_{m-1}.
    pub fn row(&self, t: f64, k: usize) -> Vec<f64> {
        let rate = self.spans as f64 / self.period;
        let u = (t * rate).clamp(0.0, self.spans as f64);
        let span = (u as usize).min(self.spans.saturating_sub(1));
        // The basis functions that are not zero on the span. Each pass raises their degree by one; the last k passes
        // differentiate them.
        let mut values = vec![1.0];
        for degree in 1..=SPLINE_DEGREE {
            let mut raised = vec![0.0; degree + 1];
            for (j, value) in values.iter().enumerate() {
                let m = span + SPLINE_DEGREE + 1 - degree + j;
                let (left, right) = (self.knot(m), self.knot(m + degree));
                let (before, own) = match degree > SPLINE_DEGREE - k {
                    true => (-(degree as f64) * rate, degree as f64 * rate),
                    false => (right - u, u - left),
                };
                raised[j] += before * value / (right - left);
                raised[j + 1] += own * value / (right - left);
            }
            values = raised;
        }
        let mut row = vec![0.0; self.spans];
        row[0] = f64::from(u8::from(k == 0));
        for (j, value) in values.into_iter().enumerate() {
            // The first three and the last three control points are the centre.
            if let Some(place) = (span + j).checked_sub(2).filter(|i| (1..self.spans).contains(i)) {
                row[place] = value;
            }
        }
        row
    }

    /// Unit in which a search scales a control point, rad (m): half the position range, or the distance during one span at the
    /// greatest velocity if that is less.
    pub fn unit(&self, half_room: f64, velocity: f64) -> f64 {
        half_room.min(velocity * self.period / self.spans as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_of_a_clamped_spline() {
        let spline = QuinticSpline { period: 3.0, spans: 12 };
        for i in 0..=60 {
            let t = 0.05 * f64::from(i);
            for k in 0..=5 {
                let (row, mirror) = (spline.row(t, k), spline.row(3.0 - t, k));
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                // The fifth derivative jumps at a knot, so it is not compared there.
                let is_at_a_knot = i % 5 == 0;
                for j in (1..12).filter(|_| k < 5 || !is_at_a_knot) {
                    // Tolerance: rounding of functions of magnitude (K/T)^k.
                    assert!((row[j] - sign * mirror[12 - j]).abs() < 1e-11 * 4.0_f64.powi(k as i32), "{t} {k} {j}");
                }
                let is_inside = (0.75..2.25).contains(&t);
                let sum: f64 = row[1..].iter().sum();
                let expected = f64::from(u8::from(k == 0));
                assert!(!is_inside || (sum - expected).abs() < 1e-11 * 4.0_f64.powi(k as i32), "{t} {k}: {sum}");
            }
        }
        for (t, k) in [(0.0, 0), (0.0, 1), (0.0, 2), (3.0, 0), (3.0, 1), (3.0, 2)] {
            assert!(spline.row(t, k)[1..].iter().all(|x| *x == 0.0), "{t} {k}");
        }
    }
}
