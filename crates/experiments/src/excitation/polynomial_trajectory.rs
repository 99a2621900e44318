//! A trajectory of polynomials in time: through given points, or for an experiment of a plan.
//!
//! A polynomial leads from each point at time t_i to the next at t_i + h; s: time after t_i. Positions q_0, q_1, velocities v and
//! accelerations a are given at both points:
//!
//! | interpolation | polynomial | jumps at points |
//! |---|---|---|
//! | linear | q_0 + (q_1 - q_0) s/h | velocity |
//! | cubic | Hermite's polynomial of q and v | acceleration |
//! | quintic | Hermite's polynomial of q, v and a | jerk |
//!
//! On an interval with middle c, each derivative lies within its Taylor polynomial about c. This polynomial is exact, because a
//! polynomial has finitely many derivatives. All computations use interval arithmetic.

use numerics::interval::Interval;

use crate::excitation::enclosure::Derivatives;
use crate::excitation::trajectory::{EnclosedTrajectory, Trajectory, TrajectorySegment};
use crate::motion::point_trajectory::{Interpolation, PointTrajectory};
use crate::motion::profile::Profile;
use crate::plan::exciting_trajectory::{ExcitingTrajectory, JointMotion};

/// A trajectory that is a polynomial in time on each segment, for each coordinate.
#[derive(Clone, Debug)]
pub struct PolynomialTrajectory {
    stretches: Vec<TrajectorySegment>,
    /// Polynomial coefficients of 1, t, t^2, .. with local time t, s: one list per segment and coordinate.
    coefficients: Vec<Vec<Vec<Interval>>>,
}

/// Number of intervals into which a proof first divides a segment between two points.
const INTERVALS_BETWEEN_POINTS: usize = 1;
/// Number of intervals into which a proof first divides a segment of an experiment.
const INTERVALS_OF_AN_EXPERIMENT: usize = 32;

impl PolynomialTrajectory {
    /// Makes the trajectory through given points. [`PointTrajectory`] has already checked their order and number.
    pub fn through(points: &PointTrajectory, interpolation: Interpolation) -> PolynomialTrajectory {
        let method = match interpolation {
            Interpolation::Linear => "Taylor polynomials between points, linear",
            Interpolation::Cubic => "Taylor polynomials between points, cubic",
            Interpolation::Quintic => "Taylor polynomials between points, quintic",
        };
        let (mut stretches, mut coefficients) = (Vec::new(), Vec::new());
        for (i, pair) in points.times().windows(2).enumerate() {
            // h is an interval that contains the exact difference of the times. So the intervals of the coefficients contain
            // the exact coefficients.
            let h = Interval::point(pair[1]) - Interval::point(pair[0]);
            stretches.push(TrajectorySegment {
                start: pair[0],
                length: h.high,
                parts: INTERVALS_BETWEEN_POINTS,
                method,
            });
            let at = |x: &[Vec<f64>], k: usize, i: usize| Interval::point(x[k][i]);
            let of = |k: usize| {
                let q = [i, i + 1].map(|i| at(points.positions(), k, i));
                match (interpolation, points.velocities(), points.accelerations()) {
                    (Interpolation::Cubic, Some(v), _) => hermite_cubic(q, [i, i + 1].map(|i| at(v, k, i)), h),
                    (Interpolation::Quintic, Some(v), Some(a)) => {
                        hermite_quintic(q, [i, i + 1].map(|i| at(v, k, i)), [i, i + 1].map(|i| at(a, k, i)), h)
                    }
                    // Linear: q_0 + (q_1 - q_0) s/h.
                    _ => vec![q[0], (q[1] - q[0]).over(h)],
                }
            };
            coefficients.push((0..points.positions().len()).map(of).collect());
        }
        PolynomialTrajectory { stretches, coefficients }
    }

    /// Makes the trajectory of an experiment: one period of a swing (periodic motion), or one slow sweep there and back. The
    /// pauses of an experiment add no new positions, so they are omitted.
    pub fn of_experiment(experiment: &ExcitingTrajectory) -> PolynomialTrajectory {
        let mut course = PolynomialTrajectory { stretches: vec![], coefficients: vec![] };
        let still: Vec<Vec<Interval>> = experiment.centre.iter().map(|c| vec![Interval::point(*c)]).collect();
        let mut push = |start: f64, length: f64, own: &dyn Fn(usize) -> Option<Vec<Interval>>| {
            let method = "Taylor polynomials of the experiment";
            course.stretches.push(TrajectorySegment { start, length, parts: INTERVALS_OF_AN_EXPERIMENT, method });
            let of = |(k, still): (usize, &Vec<Interval>)| match own(k) {
                Some(moved) => {
                    let mut moved = moved;
                    moved[0] = moved[0] + still[0];
                    moved
                }
                None => still.clone(),
            };
            course.coefficients.push(still.iter().enumerate().map(of).collect());
        };
        match &experiment.motion {
            JointMotion::Swing { profile, period, half_range, .. } => {
                let t = *period as f64 * experiment.sample_time;
                let moving = experiment.moving();
                for (from, to, shape) in profile_pieces(*profile) {
                    push(from * t, (to - from) * t, &|k| {
                        // T: period; u = t/T: phase at which the segment starts at `from`. With u = from + s/T, the polynomial of
                        // the profile in u becomes a polynomial in the local time s.
                        let scale = |(n, c): (usize, &f64)| {
                            let power = Interval::point(t);
                            (0..n).fold(Interval::point(half_range[k]) * *c, |x, _| x.over(power))
                        };
                        moving.contains(&k).then(|| shape.iter().enumerate().map(scale).collect())
                    });
                }
            }
            JointMotion::Sweep { range, velocity, acceleration, .. } => {
                let ramp = velocity / acceleration;
                let cruise = (range / velocity - ramp).max(0.0);
                let point = Interval::point;
                for (way, first) in [(1.0, 0.0), (-1.0, 2.0 * ramp + cruise)] {
                    let (low, a, v) = (-way * 0.5 * range, way * acceleration, way * velocity);
                    let after = low + 0.5 * a * ramp * ramp;
                    let pieces = [
                        (0.0, ramp, [low, 0.0, 0.5 * a]),
                        (ramp, cruise, [after, v, 0.0]),
                        (ramp + cruise, ramp, [after + v * cruise, v, -0.5 * a]),
                    ];
                    for (start, length, shape) in pieces.into_iter().filter(|(_, length, _)| *length > 0.0) {
                        push(first + start, length, &|k| {
                            (k == experiment.fast).then(|| shape.iter().map(|x| point(*x)).collect())
                        });
                    }
                }
            }
        }
        course
    }
}

/// The segments of a profile over one period: start and end of u = t / period in [0, 1], and polynomial coefficients of u -
/// start.
fn profile_pieces(profile: Profile) -> Vec<(f64, f64, Vec<f64>)> {
    match profile {
        Profile::BangBang => vec![
            (0.0, 0.25, vec![-1.0, 0.0, 16.0]),
            (0.25, 0.75, vec![0.0, 8.0, -16.0]),
            (0.75, 1.0, vec![0.0, -8.0, 16.0]),
        ],
        Profile::Smooth => {
            // Smooth profile: 2 (35 s^4 - 84 s^5 + 70 s^6 - 20 s^7) - 1 with s = 2 u.
            let powers = [-1.0, 0.0, 0.0, 0.0, 70.0, -168.0, 140.0, -40.0];
            let scaled = |sign: f64| powers.iter().zip(0..).map(|(c, n)| sign * c * 2.0_f64.powi(n)).collect();
            vec![(0.0, 0.5, scaled(1.0)), (0.5, 1.0, scaled(-1.0))]
        }
    }
}

fn hermite_cubic(q: [Interval; 2], v: [Interval; 2], h: Interval) -> Vec<Interval> {
    let slope = (q[1] - q[0]).over(h);
    let bend = (slope * 3.0 - v[0] * 2.0 - v[1]).over(h);
    let twist = (v[0] + v[1] - slope * 2.0).over(h).over(h);
    vec![q[0], v[0], bend, twist]
}

/// Hermite's quintic polynomial with positions q, velocities v and accelerations a at times 0 and h, as coefficients of 1, t,
/// t^2, ..
fn hermite_quintic(q: [Interval; 2], v: [Interval; 2], a: [Interval; 2], h: Interval) -> Vec<Interval> {
    let (dq, square) = (q[1] - q[0], h * h);
    let third = dq * 20.0 - (v[1] * 8.0 + v[0] * 12.0) * h - (a[0] * 3.0 - a[1]) * square;
    let fourth = dq * -30.0 + (v[1] * 14.0 + v[0] * 16.0) * h + (a[0] * 3.0 - a[1] * 2.0) * square;
    let fifth = dq * 12.0 - (v[1] + v[0]) * h * 6.0 - (a[0] - a[1]) * square;
    let over = |x: Interval, n: usize| (0..n).fold(x * 0.5, |x, _| x.over(h));
    vec![q[0], v[0], a[0] * 0.5, over(third, 3), over(fourth, 4), over(fifth, 5)]
}

impl Trajectory for PolynomialTrajectory {
    fn stretches(&self) -> Vec<TrajectorySegment> {
        self.stretches.clone()
    }

    fn positions(&self, stretch: usize, t: f64) -> Vec<f64> {
        let value = |c: &Vec<Interval>| c.iter().rev().fold(0.0, |sum, c| sum * t + c.middle());
        self.coefficients.get(stretch).map_or(vec![], |all| all.iter().map(value).collect())
    }

    fn enclosed(&self) -> Box<dyn EnclosedTrajectory + '_> {
        Box::new(EnclosedPolynomials(self))
    }
}

struct EnclosedPolynomials<'a>(&'a PolynomialTrajectory);

impl EnclosedTrajectory for EnclosedPolynomials<'_> {
    fn on(&self, stretch: usize, part: Interval) -> Vec<Derivatives> {
        let middle = part.middle();
        let away = part - Interval::point(middle);
        self.0
            .coefficients
            .get(stretch)
            .map_or(vec![], |all| all.iter().map(|c| derivatives(c, middle, away)).collect())
    }
}

/// Encloses position and four derivatives of a polynomial on the interval `middle` + `away`.
fn derivatives(coefficients: &[Interval], middle: f64, away: Interval) -> Derivatives {
    // Taylor coefficients of the polynomial about the middle, by Horner's scheme.
    let (mut about, at) = (coefficients.to_vec(), Interval::point(middle));
    for i in 0..about.len() {
        for j in (i..about.len() - 1).rev() {
            about[j] = about[j] + about[j + 1] * at;
        }
    }
    // Powers of h = t - c on the interval with middle c. `square` gives even powers that are never negative.
    let square = away.square();
    let mut powers = vec![Interval::point(1.0), away];
    for n in 2..about.len() {
        powers.push(powers[n - 2] * square);
    }
    let mut factors = vec![1.0; about.len()];
    std::array::from_fn(|d| {
        let terms = about.iter().skip(d).zip(factors.iter().skip(d)).zip(&powers);
        let sum = terms.fold(Interval::ZERO, |sum, ((c, factor), power)| sum + *c * *factor * *power);
        // The next derivative multiplies the factor n (n - 1) .. of t^n by the next smaller number.
        factors.iter_mut().enumerate().for_each(|(n, factor)| *factor *= (n as f64 - d as f64).max(0.0));
        sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::exciting_trajectory::{MovingJoints, SwingCourse};

    fn points() -> PointTrajectory {
        // Coordinate q1 is sin t and q2 is t^2, at uneven times.
        let times: Vec<f64> = [0.0, 0.1, 0.25, 0.3, 0.55].to_vec();
        let of = |f: &dyn Fn(f64) -> f64, g: &dyn Fn(f64) -> f64| {
            vec![times.iter().map(|t| f(*t)).collect::<Vec<f64>>(), times.iter().map(|t| g(*t)).collect()]
        };
        let q = of(&|t| t.sin(), &|t| t * t);
        let v = of(&|t| t.cos(), &|t| 2.0 * t);
        let a = of(&|t| -t.sin(), &|_| 2.0);
        PointTrajectory::new(vec!["q1".into(), "q2".into()], times, q, Some(v), Some(a)).unwrap()
    }

    /// Checks that the polynomials match the points at both ends, up to the derivative that they interpolate, and lie within
    /// their enclosures. t^2 must be reproduced exactly.
    #[test]
    fn polynomials_go_through_their_points() {
        let points = points();
        for (interpolation, known) in
            [(Interpolation::Linear, 1), (Interpolation::Cubic, 2), (Interpolation::Quintic, 3)]
        {
            let course = PolynomialTrajectory::through(&points, interpolation);
            let enclosed = course.enclosed();
            assert_eq!(course.stretches().len(), 4);
            for (i, stretch) in course.stretches().into_iter().enumerate() {
                for (t, place) in [(0.0, i), (stretch.length, i + 1)] {
                    let found = enclosed.on(i, Interval::point(t));
                    let given = [Some(points.positions()), points.velocities(), points.accelerations()];
                    for (d, given) in given.into_iter().flatten().enumerate().take(known) {
                        for (found, given) in found.iter().zip(given) {
                            // Tolerance: a few rounding errors of numbers of magnitude 20/h^2.
                            assert!((found[d].middle() - given[place]).abs() < 1e-10 && found[d].width() < 1e-9);
                        }
                    }
                }
                let held = enclosed.on(i, Interval::new(0.0, stretch.length));
                for k in 0..=10 {
                    let t = stretch.length * f64::from(k) / 10.0;
                    let thin = enclosed.on(i, Interval::point(t));
                    for ((held, thin), q) in held.iter().zip(&thin).zip(course.positions(i, t)) {
                        assert!((0..5).all(|d| held[d].low <= thin[d].high && held[d].high >= thin[d].low));
                        assert!((thin[0].middle() - q).abs() < 1e-12);
                    }
                    let parabola = (stretch.start + t).powi(2);
                    assert!(known == 1 || (thin[1][0].middle() - parabola).abs() < 1e-12);
                }
            }
        }
    }

    /// Checks that the trajectory of an experiment equals the reference of the experiment at every sample.
    #[test]
    fn experiments_are_their_reference() {
        use crate::plan::motion_kind::MotionKind;
        let swing = |profile| {
            let joints = MovingJoints { kind: MotionKind::Mixed, fast: 0, slow: &[1], centre: &[0.3, -0.4, 0.1] };
            let course = SwingCourse {
                profile,
                period: 400,
                acceleration: 12.0,
                slow_velocity: &[0.5; 3],
                duration: 1.0,
                sample_time: 1e-3,
            };
            ExcitingTrajectory::swing(&joints, &course)
        };
        let sweep = ExcitingTrajectory::sweep(1, &[0.3, -0.4, 0.1], 1.5, 0.7, 1e-3);
        for (experiment, first) in [(swing(Profile::BangBang), 0), (swing(Profile::Smooth), 0), (sweep, 100)] {
            let (course, reference) = (PolynomialTrajectory::of_experiment(&experiment), experiment.reference());
            let enclosed = course.enclosed();
            for (i, stretch) in course.stretches().into_iter().enumerate().take(3) {
                for sample in 0..400 {
                    let t = sample as f64 * 1e-3 - stretch.start;
                    if !(1e-6..stretch.length - 1e-6).contains(&t) {
                        continue;
                    }
                    let found = enclosed.on(i, Interval::point(t));
                    for (k, x) in found.iter().enumerate() {
                        let expected = [&reference.q, &reference.dq, &reference.ddq].map(|s| s[k][first + sample]);
                        // Tolerance: rounding of a few terms of an acceleration of magnitude 1e3.
                        (0..3).for_each(|d| {
                            assert!(
                                (x[d].middle() - expected[d]).abs() < 1e-10,
                                "{i} {sample} {k} {d}: {x:?} {expected:?}"
                            );
                        });
                    }
                }
            }
        }
    }
}
