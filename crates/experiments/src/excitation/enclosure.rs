//! Proved bounds of the positions of a motion and of their derivatives on an interval of time.
//!
//! - Fourier series with velocity amplitudes a_l, b_l and angular frequencies w_l: about the middle c of the interval, q^(k)(t)
//!   is within q^(k)(c) + q^(k+1)(c) h + [-1, 1] h^2/2 sum_l |(a_l, b_l)| w_l^(k+1), with h = t - c, by Taylor's theorem.
//! - A blend, and each span of a spline: between the least and the greatest of the Bernstein control points of its interval,
//!   from polar forms.
//!
//! All computations use interval arithmetic, so the proof covers rounding errors.

use numerics::interval::Interval;

use crate::excitation::fourier_series::FourierSeries;
use crate::excitation::motion::{Motion, MotionShape};
use crate::excitation::spline_enclosure::EnclosedSpline;

/// A segment of a motion. Local time in a segment starts at 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionSegment {
    /// The blend from rest to the Fourier series.
    Start,
    /// One period of the Fourier series, or the whole spline. All periods are equal, so one of them suffices.
    Period,
    /// The blend from the Fourier series to rest.
    End,
}

/// Enclosures of a coordinate's position and of its first four time derivatives, rad (m), s.
pub type Derivatives = [Interval; 5];

/// A motion with precomputed data for enclosures of its positions and derivatives.
pub enum EnclosedMotion<'a> {
    /// A Fourier series with its blends (polynomials from rest to the series, and back to rest).
    Fourier(EnclosedSeries<'a>),
    /// A spline.
    Spline(EnclosedSpline),
}

/// A Fourier series with its blends (polynomials from rest to the series, and back to rest), with precomputed data for
/// enclosures.
pub struct EnclosedSeries<'a> {
    shape: FourierSeries,
    /// Coefficients (c, a_1, b_1, ..) of each coordinate: centre c, then amplitudes of the velocity.
    joints: &'a [Vec<f64>],
    /// Angular frequencies w_l = l 2 pi / T of the harmonics l = 1, 2, .., rad/s; T: period.
    frequency: Vec<Interval>,
    /// For each coordinate: bounds sum_l |(a_l, b_l)| w_l^(k+1), k = 0 .. 4, of the second derivative of q^(k).
    curvature: Vec<[f64; 5]>,
    /// Bernstein control points of the two blends (polynomials from rest to the series, and back to rest), one entry per
    /// coordinate.
    blends: Vec<[[Interval; 5]; 2]>,
}

impl MotionSegment {
    /// The segments of a motion, in the order of time.
    pub fn of(shape: &MotionShape) -> &'static [MotionSegment] {
        match shape {
            MotionShape::Fourier(_) => &[MotionSegment::Start, MotionSegment::Period, MotionSegment::End],
            MotionShape::Spline(_) => &[MotionSegment::Period],
        }
    }

    /// The time interval of the segment in its local time, s: from 0 to its duration.
    pub fn span(self, shape: &MotionShape) -> Interval {
        match self {
            MotionSegment::Period => Interval::new(0.0, shape.period()),
            MotionSegment::Start | MotionSegment::End => Interval::new(0.0, shape.blend()),
        }
    }

    /// Time after the start of the motion at which the segment starts, s.
    pub fn start(self, motion: &Motion) -> f64 {
        match self {
            MotionSegment::Start => 0.0,
            MotionSegment::Period => motion.shape.blend(),
            MotionSegment::End => motion.shape.blend() + motion.repetitions as f64 * motion.shape.period(),
        }
    }

    /// Name of the enclosure method for this segment, which a certificate states.
    pub fn method(self, shape: &MotionShape) -> &'static str {
        match (self, shape) {
            (MotionSegment::Period, MotionShape::Fourier(_)) => "Taylor enclosures of the series",
            (MotionSegment::Period, MotionShape::Spline(_)) => "Bernstein control points of the spline",
            (MotionSegment::Start | MotionSegment::End, _) => "Bernstein control points of the blend",
        }
    }
}

impl EnclosedMotion<'_> {
    /// Precomputes the data for enclosures of a motion.
    pub fn new(motion: &Motion) -> EnclosedMotion<'_> {
        match motion.shape {
            MotionShape::Fourier(shape) => EnclosedMotion::Fourier(EnclosedSeries::new(shape, &motion.joints)),
            MotionShape::Spline(shape) => EnclosedMotion::Spline(EnclosedSpline::new(shape, &motion.joints)),
        }
    }

    /// Encloses position and derivatives of each coordinate on the interval `part` (local time, s) of the segment `piece`.
    pub fn on(&self, piece: MotionSegment, part: Interval) -> Vec<Derivatives> {
        match self {
            EnclosedMotion::Fourier(series) => series.on(piece, part),
            EnclosedMotion::Spline(spline) => spline.on(part),
        }
    }
}

impl EnclosedSeries<'_> {
    fn new(shape: FourierSeries, joints: &[Vec<f64>]) -> EnclosedSeries<'_> {
        let turn = Interval::pi() * 2.0;
        let w = turn.over(Interval::point(shape.period));
        let frequency: Vec<Interval> = (1..=shape.harmonics).map(|l| w * l as f64).collect();
        let curvature = joints.iter().map(|joint| {
            let mut sums = [Interval::ZERO; 5];
            for (amplitudes, w) in joint[1..].chunks_exact(2).zip(&frequency) {
                let [a, b] = [0, 1].map(|i| Interval::point(amplitudes[i]));
                let mut term = (a.square() + b.square()).sqrt();
                for sum in &mut sums {
                    term = term * *w;
                    *sum = *sum + term;
                }
            }
            sums.map(|s| s.high)
        });
        let curvature = curvature.collect();
        let mut enclosed = EnclosedSeries { shape, joints, frequency, curvature, blends: vec![] };
        // Bernstein control points of the polynomial from rest to the series (start blend): s, s, s, q - D v/4, q, with s = q - D
        // v/2 + D^2 a/12. q, v, a: state of the series at its start; D: duration. The end blend is mirrored.
        let d = Interval::point(shape.blend);
        let blends = enclosed.series_at(Interval::ZERO).into_iter().map(|[q, v, a, ..]| {
            let bend = (d.square() * a).over(Interval::point(12.0));
            let (before, after) = (q - d * v * 0.5 + bend, q + d * v * 0.5 + bend);
            [[before, before, before, q - d * v * 0.25, q], [q, q + d * v * 0.25, after, after, after]]
        });
        enclosed.blends = blends.collect();
        enclosed
    }

    fn on(&self, piece: MotionSegment, part: Interval) -> Vec<Derivatives> {
        match piece {
            MotionSegment::Start => self.blend(0, part),
            MotionSegment::End => self.blend(1, part),
            MotionSegment::Period => {
                let middle = Interval::point(part.middle());
                let h = part - middle;
                let bend = h.square() * 0.5;
                let around = |(at, curvature): ([Interval; 6], &[f64; 5])| -> Derivatives {
                    std::array::from_fn(|k| at[k] + at[k + 1] * h + bend * Interval::around_zero(curvature[k]))
                };
                self.series_at(middle).into_iter().zip(&self.curvature).map(around).collect()
            }
        }
    }

    /// Encloses position and first five derivatives of each coordinate in the Fourier series at time `t` of a period.
    fn series_at(&self, t: Interval) -> Vec<[Interval; 6]> {
        let waves: Vec<(Interval, Interval)> =
            self.frequency.iter().map(|w| ((*w * t).sin(), (*w * t).cos())).collect();
        let of = |joint: &Vec<f64>| {
            let mut found = [Interval::ZERO; 6];
            found[0] = Interval::point(joint[0]);
            for (l, (s, c)) in waves.iter().enumerate() {
                let (a, b, w) = (joint[2 * l + 1], joint[2 * l + 2], self.frequency[l]);
                // `along` is w times the position of a harmonic of angular frequency w; `across` is its velocity. The other
                // derivatives are these two times powers of w.
                let (along, across) = (*s * a - *c * b, *c * a + *s * b);
                found[0] = found[0] + along.over(w);
                let mut scale = Interval::point(1.0);
                for (k, sum) in found.iter_mut().enumerate().skip(1) {
                    let term = match k % 4 {
                        1 => across,
                        2 => -along,
                        3 => -across,
                        _ => along,
                    };
                    *sum = *sum + term * scale;
                    scale = scale * w;
                }
            }
            found
        };
        self.joints.iter().map(of).collect()
    }

    fn blend(&self, which: usize, part: Interval) -> Vec<Derivatives> {
        let d = Interval::point(self.shape.blend);
        let within = |t: f64| Interval::point(t).over(d).meet(Interval::new(0.0, 1.0));
        let (from, to) = (within(part.low), within(part.high));
        let of = |control: &[[Interval; 5]; 2]| -> Derivatives {
            let mut points = control[which].to_vec();
            let mut degree = 4.0;
            std::array::from_fn(|_| {
                let held = restricted(&points, from, to);
                let factor = Interval::point(degree).over(d);
                points = points.windows(2).map(|p| (p[1] - p[0]) * factor).collect();
                degree -= 1.0;
                held
            })
        };
        self.blends.iter().map(of).collect()
    }
}

/// The hull of the Bernstein control points after restriction of the polynomial to the interval from u to v. Control point j is
/// the polar form with n - j arguments u and j arguments v; n: degree.
fn restricted(points: &[Interval], u: Interval, v: Interval) -> Interval {
    let between = |x: Interval, y: Interval, u: Interval| x + (y - x) * u;
    let polar = |j: usize| {
        let mut left = points.to_vec();
        for step in 1..points.len() {
            let at = if step <= j { v } else { u };
            left = left.windows(2).map(|p| between(p[0], p[1], at)).collect();
        }
        left[0]
    };
    (0..points.len()).map(polar).reduce(Interval::hull).unwrap_or(Interval::ALL)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::motion::tests::motions;

    #[test]
    fn the_motion_lies_within() {
        for motion in motions() {
            let enclosed = EnclosedMotion::new(&motion);
            for &piece in MotionSegment::of(&motion.shape) {
                let span = piece.span(&motion.shape);
                for k in 0..40 {
                    let at = |k: usize| span.low + span.width() * k as f64 / 40.0;
                    let part = Interval::new(at(k), at(k + 1));
                    hold(&motion, &enclosed, piece, part);
                }
            }
        }
    }

    fn hold(motion: &Motion, enclosed: &EnclosedMotion, piece: MotionSegment, part: Interval) {
        let (held, span) = (enclosed.on(piece, part), piece.span(&motion.shape));
        for i in 0..=20 {
            // Only times inside the segment are tested, because the jerk jumps at its ends.
            let t = (part.low + part.width() * f64::from(i) / 20.0).clamp(span.low + 1e-9, span.high - 1e-9);
            let thin = enclosed.on(piece, Interval::point(t));
            for (j, x) in motion.at(piece.start(motion) + t).iter().enumerate() {
                for d in 0..4 {
                    // The tolerance covers rounding of the time: 1e-15 s at 100 rad/s^4.
                    assert!(held[j][d].low <= x[d] + 1e-9 && held[j][d].high >= x[d] - 1e-9, "{piece:?} {t}");
                    assert!((thin[j][d].middle() - x[d]).abs() < 1e-9 && thin[j][d].width() < 1e-9);
                }
                // The fourth derivative is compared with a central difference of the third.
                let h = 1e-6;
                let [before, after] = [-h, h].map(|h| motion.at(piece.start(motion) + t + h)[j][3]);
                let slope = (after - before) / (2.0 * h);
                let is_inside = t - h > span.low && t + h < span.high;
                // Errors of the difference: rounding of a jerk of hundreds divided by h; h times the jumps of the fifth
                // derivative at knots.
                let near = 1e-3 * (1.0 + slope.abs());
                assert!(!is_inside || (thin[j][4].middle() - slope).abs() < near, "{t}: {:?} {slope}", thin[j][4]);
                assert!(held[j][4].low <= thin[j][4].high && held[j][4].high >= thin[j][4].low);
            }
        }
    }
}
