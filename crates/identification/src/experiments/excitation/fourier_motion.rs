//! A motion of all joints that is a finite Fourier series, between rest and rest.
//!
//! ```text
//! q_i(t) = c_i + sum_l a_il / (w l) sin(w l t) - b_il / (w l) cos(w l t),   l = 1 .. H,   w = 2 pi / T
//! ```
//! [Swevers, Ganseman, Tukel, De Schutter, Van Brussel 1997], over whole periods. a and b are amplitudes of
//! the velocity. A blend of D seconds leads from rest to the series, and one from the series to rest: the polynomial of
//! fifth degree with the position, velocity and acceleration of the series at one end and no velocity and acceleration at
//! the other, which starts where its fifth degree vanishes, q(0) - D v/2 + D^2 a/12. Its control points (Bernstein) are
//! s, s, s, q(0) - D v/4, q(0). So the acceleration is continuous and the jerk bounded. Every quantity is linear in
//! (c, a, b).

use crate::experiments::exciting_trajectory::Reference;

/// The motion.
#[derive(Clone, Debug, PartialEq)]
pub struct FourierMotion {
    /// Of the file that is played, Hz.
    pub rate: f64,
    /// T, s.
    pub period: f64,
    /// D, s.
    pub blend: f64,
    /// Whole periods between the blends.
    pub repetitions: usize,
    /// One a coordinate.
    pub joints: Vec<FourierJoint>,
}

/// The series of one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct FourierJoint {
    /// c, rad (m).
    pub centre: f64,
    /// a_1 .. a_H, rad/s (m/s).
    pub cosine: Vec<f64>,
    /// b_1 .. b_H.
    pub sine: Vec<f64>,
}

impl FourierJoint {
    /// A coordinate that stands still.
    pub fn at_rest(position: f64, harmonics: usize) -> FourierJoint {
        FourierJoint { centre: position, cosine: vec![0.0; harmonics], sine: vec![0.0; harmonics] }
    }

    /// From (c, a_1, b_1, a_2, b_2, ..).
    pub fn from_coefficients(x: &[f64]) -> FourierJoint {
        let pairs = x.get(1..).unwrap_or_default().chunks_exact(2);
        FourierJoint {
            centre: x.first().copied().unwrap_or(0.0),
            cosine: pairs.clone().map(|p| p[0]).collect(),
            sine: pairs.map(|p| p[1]).collect(),
        }
    }

    /// (c, a_1, b_1, a_2, b_2, ..).
    pub fn coefficients(&self) -> Vec<f64> {
        let pairs = self.cosine.iter().zip(&self.sine).flat_map(|(a, b)| [*a, *b]);
        std::iter::once(self.centre).chain(pairs).collect()
    }

    /// The same motion with its swing about `centre` times `factor`.
    pub fn scaled(&self, factor: f64, centre: f64) -> FourierJoint {
        let times = |x: &[f64]| x.iter().map(|x| factor * x).collect();
        FourierJoint { centre, cosine: times(&self.cosine), sine: times(&self.sine) }
    }
}

/// The k-th derivative of the series at `t` (s from the start of a period) per unit of (c, a_1, b_1, ..); T in s.
pub fn basis(harmonics: usize, period: f64, t: f64, k: i32) -> Vec<f64> {
    let w = std::f64::consts::TAU / period;
    let mut row = vec![f64::from(u8::from(k == 0))];
    for l in 1..=harmonics {
        let wl = w * l as f64;
        let (s, c) = libm::sincos(wl * t);
        let scale = wl.powi(k - 1);
        // d^k sin / dx^k and d^k (-cos) / dx^k.
        let (a, b) = match k.rem_euclid(4) {
            0 => (s, -c),
            1 => (c, s),
            2 => (-s, c),
            _ => (-c, -s),
        };
        row.extend([scale * a, scale * b]);
    }
    row
}

/// The control points of the k-th derivative of the blends, per unit of (c, a_1, b_1, ..): degree 4 - k, k at most 3.
pub fn blend_control(harmonics: usize, period: f64, blend: f64, k: usize, is_start: bool) -> Vec<Vec<f64>> {
    let [q, v, a] = [0, 1, 2].map(|k| basis(harmonics, period, 0.0, k));
    let along = |sv: f64, sa: f64| -> Vec<f64> { (0..q.len()).map(|j| q[j] + sv * v[j] + sa * a[j]).collect() };
    let sign = if is_start { -1.0 } else { 1.0 };
    let (rest, near) = (along(0.5 * sign * blend, blend * blend / 12.0), along(0.25 * sign * blend, 0.0));
    let mut points = vec![rest.clone(), rest.clone(), rest, near, q];
    if !is_start {
        points.reverse();
    }
    for degree in (4 - k + 1..=4).rev() {
        let difference = |p: &[Vec<f64>]| -> Vec<f64> {
            p[0].iter().zip(&p[1]).map(|(x, y)| degree as f64 / blend * (y - x)).collect()
        };
        points = points.windows(2).map(difference).collect();
    }
    points
}

impl FourierMotion {
    /// H; of a motion without coordinates 0.
    pub fn harmonics(&self) -> usize {
        self.joints.first().map_or(0, |j| j.cosine.len())
    }

    /// s, from rest to rest.
    pub fn duration(&self) -> f64 {
        2.0 * self.blend + self.repetitions as f64 * self.period
    }

    /// Position, velocity, acceleration, jerk of each coordinate at t s after the start; at rest before and after.
    pub fn at(&self, t: f64) -> Vec<[f64; 4]> {
        let series = self.repetitions as f64 * self.period;
        let in_series = t - self.blend;
        let rows: [Vec<f64>; 4] = if in_series < 0.0 || in_series > series {
            let is_start = in_series < 0.0;
            let local = if is_start { t } else { in_series - series };
            let u = (local / self.blend).clamp(0.0, 1.0);
            let row = |k| casteljau(blend_control(self.harmonics(), self.period, self.blend, k, is_start), u);
            [0, 1, 2, 3].map(row)
        } else {
            let phase = in_series % self.period;
            [0, 1, 2, 3].map(|k| basis(self.harmonics(), self.period, phase, k))
        };
        let of = |joint: &FourierJoint| {
            let x = joint.coefficients();
            [0, 1, 2, 3].map(|k: usize| rows[k].iter().zip(&x).map(|(b, x)| b * x).sum())
        };
        self.joints.iter().map(of).collect()
    }

    /// The motion at its rate, from rest to rest; the window is the whole periods.
    pub fn reference(&self) -> Reference {
        let count = |seconds: f64| (seconds * self.rate).round() as usize;
        let (samples, n) = (count(self.duration()) + 1, self.joints.len());
        let mut reference = Reference { sample_time: 1.0 / self.rate, ..Reference::default() };
        for series in [&mut reference.q, &mut reference.dq, &mut reference.ddq] {
            *series = vec![Vec::with_capacity(samples); n];
        }
        for r in 0..samples {
            for (k, [q, dq, ddq, _]) in self.at(r as f64 / self.rate).into_iter().enumerate() {
                // The rounding of the last instant must not leave a rest of velocity: controllers refuse it.
                let is_end = r + 1 == samples;
                reference.q[k].push(q);
                reference.dq[k].push(if is_end { 0.0 } else { dq });
                reference.ddq[k].push(if is_end { 0.0 } else { ddq });
            }
        }
        let first = count(self.blend);
        reference.windows = std::iter::once(first..first + count(self.repetitions as f64 * self.period)).collect();
        reference
    }
}

/// The point of control points at u in [0, 1].
pub(crate) fn casteljau(mut points: Vec<Vec<f64>>, u: f64) -> Vec<f64> {
    while points.len() > 1 {
        let between =
            |p: &[Vec<f64>]| -> Vec<f64> { p[0].iter().zip(&p[1]).map(|(x, y)| (1.0 - u) * x + u * y).collect() };
        points = points.windows(2).map(between).collect();
    }
    points.pop().unwrap_or_default()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::algebra::random::Random;

    pub(crate) fn motion() -> FourierMotion {
        let mut random = Random::new(3);
        let mut joint = || FourierJoint {
            centre: random.normal(),
            cosine: (0..3).map(|_| random.normal()).collect(),
            sine: (0..3).map(|_| random.normal()).collect(),
        };
        FourierMotion { rate: 100.0, period: 4.0, blend: 1.0, repetitions: 2, joints: vec![joint(), joint()] }
    }

    /// Each derivative is the slope of the one before, across the joints of the pieces too; it starts and ends at rest.
    #[test]
    fn derivatives_follow_and_the_ends_rest() {
        let motion = motion();
        assert_eq!(motion.duration(), 10.0);
        let h = 1e-5;
        for i in 0..=1000 {
            // Away from the instants where the jerk jumps.
            let t = 0.01 * f64::from(i) + 0.003;
            let (before, at, after) = (motion.at(t - h), motion.at(t), motion.at(t + h));
            for k in 0..2 {
                for d in 0..3 {
                    let slope = (after[k][d] - before[k][d]) / (2.0 * h);
                    if t < 10.0 {
                        // h^2 times the third derivative: 3 w = 4.7, five powers of it.
                        assert!((slope - at[k][d + 1]).abs() < 1e-5, "{t} {k} {d}: {slope} {}", at[k][d + 1]);
                    }
                }
            }
        }
        for t in [1.0, 3.0, 5.0, 9.0] {
            let (before, after) = (motion.at(t - 1e-9), motion.at(t + 1e-9));
            for k in 0..2 {
                for d in 0..3 {
                    assert!((before[k][d] - after[k][d]).abs() < 1e-6, "{t}");
                }
            }
        }
        for t in [0.0, 10.0] {
            assert!(motion.at(t).iter().all(|x| x[1] == 0.0 && x[2].abs() < 1e-12), "{:?}", motion.at(t));
        }
    }

    #[test]
    fn the_file_ends_at_rest_and_repeats() {
        let motion = motion();
        let reference = motion.reference();
        assert_eq!((reference.q[0].len(), reference.windows[0].clone()), (1001, 100..900));
        for k in 0..2 {
            assert_eq!((reference.dq[k][1000], reference.ddq[k][1000]), (0.0, 0.0));
            assert!((reference.q[k][150] - reference.q[k][550]).abs() < 1e-12);
        }
        let back = FourierJoint::from_coefficients(&motion.joints[1].coefficients());
        assert_eq!(back, motion.joints[1]);
    }
}
