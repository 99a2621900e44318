//! A motion of all joints from rest to rest: each coordinate is a sum of basis functions.
//!
//! q_i(t) = c_i + sum_j x_ij f_j(t), c_i is the centre of coordinate i, x_ij are its coefficients. The basis functions f_j are
//! equal for all coordinates; they come from a Fourier series ([`crate::excitation::fourier_series`]) or a quintic spline
//! ([`crate::excitation::quintic_spline`]). Positions and their derivatives are linear in (c, x_1, x_2, ..).

use crate::excitation::fourier_series::FourierSeries;
use crate::excitation::limits::CoordinateLimits;
use crate::excitation::quintic_spline::QuinticSpline;
use crate::motion::reference_motion::Reference;

/// The basis functions of a motion of all joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionShape {
    /// Whole periods of a Fourier series, with a polynomial from rest before them and a polynomial to rest after them (blends).
    Fourier(FourierSeries),
    /// A quintic spline from rest to rest, once per repetition.
    Spline(QuinticSpline),
}

impl MotionShape {
    /// Number of coefficients of each coordinate, including its centre.
    pub fn size(&self) -> usize {
        match self {
            MotionShape::Fourier(series) => 2 * series.harmonics + 1,
            MotionShape::Spline(spline) => spline.spans,
        }
    }

    /// Duration of one repetition, s: a period of the Fourier series, or the whole spline.
    pub fn period(&self) -> f64 {
        match self {
            MotionShape::Fourier(series) => series.period,
            MotionShape::Spline(spline) => spline.period,
        }
    }

    /// Duration of the blend from rest to the Fourier series, and of the blend back to rest, s; zero for a spline.
    pub fn blend(&self) -> f64 {
        match self {
            MotionShape::Fourier(series) => series.blend,
            MotionShape::Spline(_) => 0.0,
        }
    }

    /// Factors of the coefficients (c, x_1, x_2, ..) in the k-th derivative of a coordinate (k <= 3), at time `t` in a period, s.
    pub fn row(&self, t: f64, k: usize) -> Vec<f64> {
        match self {
            MotionShape::Fourier(series) => series.row(t, k),
            MotionShape::Spline(spline) => spline.row(t, k),
        }
    }

    /// The units in which a search scales the coefficients of a coordinate. One unit is a large share of the range that the
    /// limits allow.
    pub fn units(&self, limits: &CoordinateLimits) -> Vec<f64> {
        let half_room = 0.5 * (limits.position.1 - limits.position.0);
        let unit = match self {
            MotionShape::Fourier(_) => limits.reachable_velocity(),
            MotionShape::Spline(spline) => spline.unit(half_room, limits.velocity),
        };
        std::iter::once(half_room).chain(std::iter::repeat_n(unit, self.size() - 1)).collect()
    }

    /// The metric of a coordinate's coefficients, which are in the units of [`MotionShape::units`], m x m for m coefficients.
    ///
    /// A motion about the centre with the greatest velocity, or over half the position range, has a squared norm of about 1. For
    /// a Fourier series the metric is the identity, because its functions are orthogonal. For a spline it is twice the mean of
    /// (dq/v)^2 over `count` instants; v: limit of velocity. So a fast motion of the control points has the norm of a fast
    /// harmonic.
    pub fn metric(&self, limits: &CoordinateLimits, count: usize) -> Vec<f64> {
        let m = self.size();
        let mut metric = vec![0.0; m * m];
        match self {
            MotionShape::Fourier(_) => metric.iter_mut().step_by(m + 1).for_each(|x| *x = 1.0),
            MotionShape::Spline(_) => {
                let units = self.units(limits);
                metric[0] = 1.0;
                for row in self.rows(1, count, std::iter::empty()) {
                    let shares: Vec<f64> = row.iter().zip(&units).map(|(x, u)| x * u / limits.velocity).collect();
                    for (i, a) in shares.iter().enumerate() {
                        metric[i * m..][..m]
                            .iter_mut()
                            .zip(&shares)
                            .for_each(|(x, b)| *x += 2.0 * a * b / count as f64);
                    }
                }
            }
        }
        metric
    }

    /// Rows with the factors of the coefficients in the k-th derivative: at `count` instants of a period, then at the fractions
    /// `of_blends`, in [0, 1], of each blend.
    pub fn rows(&self, k: usize, count: usize, of_blends: impl Iterator<Item = f64> + Clone) -> Vec<Vec<f64>> {
        let of_period = |r: usize| self.row(self.period() * r as f64 / count as f64, k);
        let mut rows: Vec<Vec<f64>> = (0..count).map(of_period).collect();
        if let MotionShape::Fourier(series) = self {
            for is_start in [true, false] {
                rows.extend(of_blends.clone().map(|u| series.blend_row(k, is_start, u)));
            }
        }
        rows
    }

    /// Bernstein control points whose hull encloses the k-th derivative of the blends (polynomials from rest and to rest), as
    /// factors of the coefficients. The start blend is first. Empty for a spline.
    pub(crate) fn blend_control(&self, k: usize) -> Vec<Vec<f64>> {
        match self {
            MotionShape::Fourier(series) => {
                [true, false].into_iter().flat_map(|s| series.blend_control(k, s)).collect()
            }
            MotionShape::Spline(_) => vec![],
        }
    }
}

/// A motion of all joints from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Sample rate of the reference file that a controller plays, Hz.
    pub rate: f64,
    /// Number of times that the period (or the spline) is repeated.
    pub repetitions: usize,
    /// The basis functions of the motion: a Fourier series or a spline.
    pub shape: MotionShape,
    /// Coefficients (c, x_1, x_2, ..) of each coordinate: centre c, then one factor per basis function.
    pub joints: Vec<Vec<f64>>,
}

/// The coefficients of a joint after its swing about the centre is multiplied by `factor` and its centre is replaced by `centre`.
pub fn scaled(coefficients: &[f64], factor: f64, centre: f64) -> Vec<f64> {
    let swing = coefficients.iter().skip(1).map(|x| factor * x);
    std::iter::once(centre).chain(swing).collect()
}

impl Motion {
    /// Duration from rest to rest, s.
    pub fn duration(&self) -> f64 {
        2.0 * self.shape.blend() + self.repetitions as f64 * self.shape.period()
    }

    /// Position, velocity, acceleration and jerk of each coordinate at `t` s after the start. Before and after the motion the
    /// robot is at rest.
    pub fn at(&self, t: f64) -> Vec<[f64; 4]> {
        let series = self.repetitions as f64 * self.shape.period();
        let rows: [Vec<f64>; 4] = match self.shape {
            MotionShape::Fourier(shape) if t < shape.blend || t - shape.blend > series => {
                let is_start = t < shape.blend;
                let local = if is_start { t } else { t - shape.blend - series };
                let u = (local / shape.blend).clamp(0.0, 1.0);
                [0, 1, 2, 3].map(|k| shape.blend_row(k, is_start, u))
            }
            MotionShape::Fourier(_) => {
                let phase = (t - self.shape.blend()) % self.shape.period();
                [0, 1, 2, 3].map(|k| self.shape.row(phase, k))
            }
            MotionShape::Spline(spline) => {
                let phase = if t < series { t.max(0.0) % spline.period } else { spline.period };
                [0, 1, 2, 3].map(|k| spline.row(phase, k))
            }
        };
        let of = |x: &Vec<f64>| [0, 1, 2, 3].map(|k: usize| rows[k].iter().zip(x).map(|(b, x)| b * x).sum());
        self.joints.iter().map(of).collect()
    }

    /// The motion sampled at its rate, from rest to rest. The window of the reference (samples for identification) covers the
    /// whole periods.
    pub fn reference(&self) -> Reference {
        let count = |seconds: f64| (seconds * self.rate).round() as usize;
        let (samples, n) = (count(self.duration()) + 1, self.joints.len());
        let mut reference = Reference { sample_time: 1.0 / self.rate, ..Reference::default() };
        for series in [&mut reference.q, &mut reference.dq, &mut reference.ddq] {
            *series = vec![Vec::with_capacity(samples); n];
        }
        for r in 0..samples {
            for (k, [q, dq, ddq, _]) in self.at(r as f64 / self.rate).into_iter().enumerate() {
                // The velocity at the last instant must be exactly zero, because controllers refuse a rounding error there.
                let is_end = r + 1 == samples;
                reference.q[k].push(q);
                reference.dq[k].push(if is_end { 0.0 } else { dq });
                reference.ddq[k].push(if is_end { 0.0 } else { ddq });
            }
        }
        let first = count(self.shape.blend());
        let whole = count(self.repetitions as f64 * self.shape.period());
        reference.windows = std::iter::once(first..first + whole).collect();
        reference
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use random::Random;

    /// One motion of each shape, with two coordinates and two repetitions.
    pub(crate) fn motions() -> [Motion; 2] {
        let mut random = Random::new(3);
        let mut motion = |shape: MotionShape| {
            let joints = vec![vec![(); shape.size()]; 2];
            let joints = joints.iter().map(|x| x.iter().map(|()| random.normal()).collect()).collect();
            Motion { rate: 100.0, repetitions: 2, shape, joints }
        };
        [
            motion(MotionShape::Fourier(FourierSeries { period: 4.0, blend: 1.0, harmonics: 3 })),
            motion(MotionShape::Spline(QuinticSpline { period: 4.0, spans: 9 })),
        ]
    }

    /// Checks that each time derivative is the derivative of the previous one, also where segments join, and that the motion
    /// starts and ends at rest.
    #[test]
    fn derivatives_follow_and_the_ends_rest() {
        for motion in motions() {
            let duration = motion.duration();
            assert_eq!(duration, 8.0 + 2.0 * motion.shape.blend());
            let h = 1e-5;
            for i in 0..100 * duration as usize {
                // The jerk does not jump at these instants.
                let t = 0.01 * i as f64 + 0.003;
                let (before, at, after) = (motion.at(t - h), motion.at(t), motion.at(t + h));
                for k in 0..2 {
                    for d in 0..3 {
                        let slope = (after[k][d] - before[k][d]) / (2.0 * h);
                        // Error of the difference: h^2 times the derivative two orders higher. For the series, the highest
                        // angular frequency is 3 w = 4.7 rad/s; for the spline, the fifth derivative is about 120 K^5 / T^5 =
                        // 6900 (K spans in T seconds). Rounding: 1e-16 of a hundred, divided by h.
                        assert!((slope - at[k][d + 1]).abs() < 1e-5, "{t} {k} {d}: {slope} {}", at[k][d + 1]);
                    }
                }
            }
            let joins = [motion.shape.blend(), motion.shape.blend() + 4.0, motion.shape.blend() + 4.0 / 9.0];
            for t in joins.into_iter().chain([duration - motion.shape.blend()]).filter(|t| (0.1..7.9).contains(t)) {
                let (before, after) = (motion.at(t - 1e-9), motion.at(t + 1e-9));
                for k in 0..2 {
                    for d in 0..3 {
                        // At a jerk of 200 rad/s^3, the acceleration changes by less than 1e-6 rad/s^2 in 2e-9 s.
                        assert!((before[k][d] - after[k][d]).abs() < 1e-6, "{t}");
                    }
                }
            }
            for t in [0.0, duration] {
                assert!(motion.at(t).iter().all(|x| x[1] == 0.0 && x[2].abs() < 1e-12), "{:?}", motion.at(t));
            }
        }
    }

    #[test]
    fn a_spline_is_continuous_through_its_jerk() {
        let [_, motion] = motions();
        for knot in 1..9 {
            let t = 4.0 * f64::from(knot) / 9.0;
            let [before, after] = [-1e-7, 1e-7].map(|h| motion.at(t + h));
            for k in 0..2 {
                // If the derivative of the jerk is some thousands, the jerk changes by less than 2e-3 rad/s^3 in 2e-7 s.
                assert!((before[k][3] - after[k][3]).abs() < 2e-3, "{knot}: {} {}", before[k][3], after[k][3]);
            }
        }
    }

    #[test]
    fn the_file_ends_at_rest_and_repeats() {
        for motion in motions() {
            let (reference, first) = (motion.reference(), (100.0 * motion.shape.blend()) as usize);
            assert_eq!((reference.q[0].len(), reference.windows[0].clone()), (2 * first + 801, first..first + 800));
            for k in 0..2 {
                assert_eq!((reference.dq[k][2 * first + 800], reference.ddq[k][2 * first + 800]), (0.0, 0.0));
                assert!((reference.q[k][first + 50] - reference.q[k][first + 450]).abs() < 1e-12);
            }
        }
    }
}
