//! The motion of one experiment of a plan: a fast joint moves, possibly with slow joints; the other joints are locked.
//!
//! A swing moves the fast joint between two positions A and B with the period T. Its acceleration is +a on [0, T/4), -a on
//! [T/4, 3T/4), +a on [3T/4, T) (bang-bang profile). Stroke L = |B - A|, peak velocity v_peak and frequency f_P are:
//!
//! L = a T^2 / 16,   v_peak = 4 L / T,   f_P = 1/T = sqrt(a/L) / 4.
//!
//! | kind | fast joint k | slow joints l | equations (`paper_rows`) |
//! |---|---|---|---|
//! | Inertial (1) | greatest acceleration | none | (8) |
//! | Centrifugal (2) | greatest velocity | one | (10) |
//! | Coupling (3) | as Inertial | one | (11) |
//! | Mixed (1+2+3) | between the two | all joints after it in the chain | (8), (10), (11) |
//! | Gravity (4) | constant slow velocity, there and back | none | (13) |
//!
//! Slow joints move with the period and the phase of the fast joint. Every profile has the odd half-wave symmetries
//! q(t + T/2) - c = -(q(t) - c) and q(T/4 + s) - c = -(q(T/4 - s) - c), c: centre of the motion. Therefore the friction of the
//! moving joint is orthogonal to its acceleration at odd harmonics.
//!
//! The equation numbers refer to [Vandanjon, Gautier, Desbats 1995, section 3.2].

use std::ops::Range;

use crate::motion::profile::Profile;
use crate::motion::reference_motion::Reference;
use crate::plan::motion_kind::MotionKind;

/// The motion of the moving joints in an experiment: a periodic swing, or a slow sweep at constant velocity.
#[derive(Clone, Debug, PartialEq)]
pub enum JointMotion {
    /// Whole periods of a motion between the positions A = centre - half_range and B = centre + half_range.
    Swing {
        /// Profile (position over time) of the swing in one period.
        profile: Profile,
        /// Number of samples of one period.
        period: usize,
        /// (B - A)/2 of each coordinate, rad (m); A, B: ends of its swing. 0 for a locked coordinate.
        half_range: Vec<f64>,
        /// Number of periods that run before the record starts, so that transients decay.
        transient_periods: usize,
        /// Number of recorded periods.
        periods: usize,
    },
    /// A movement of one joint over `range` at constant velocity, and then the same path back.
    Sweep {
        /// Length of the sweep, rad (m).
        range: f64,
        /// Constant velocity, rad/s (m/s).
        velocity: f64,
        /// Acceleration of the ramps at the ends, rad/s^2 (m/s^2).
        acceleration: f64,
        /// Time after each ramp whose samples are not used, because the controller settles, s.
        settling: f64,
    },
}

/// The motion of one experiment of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitingTrajectory {
    /// The kind of torques that the motion excites, such as inertial torques.
    pub kind: MotionKind,
    /// Index of the fast coordinate, or of the only coordinate that moves.
    pub fast: usize,
    /// Indices of the slow coordinates.
    pub slow: Vec<usize>,
    /// Position of each coordinate, rad (m): middle of the motion if it moves, constant position if it is locked.
    pub centre: Vec<f64>,
    /// Time between samples, s.
    pub sample_time: f64,
    /// The motion of the moving joints: a periodic swing, or a slow sweep.
    pub motion: JointMotion,
}

/// The joints that move in an experiment, with the centre of the motion.
#[derive(Clone, Copy, Debug)]
pub struct MovingJoints<'a> {
    /// The kind of torques that the motion excites, such as inertial torques.
    pub kind: MotionKind,
    /// Index of the fast coordinate, or of the only coordinate that moves.
    pub fast: usize,
    /// Indices of the slow coordinates.
    pub slow: &'a [usize],
    /// Position of each coordinate, rad (m): middle of the motion if it moves, constant position if it is locked.
    pub centre: &'a [f64],
}

/// Profile (position over time), period and amplitudes of a swing (periodic motion).
#[derive(Clone, Copy, Debug)]
pub struct SwingCourse<'a> {
    /// Profile (position over time) of the swing in one period.
    pub profile: Profile,
    /// Number of samples of one period.
    pub period: usize,
    /// Peak acceleration of the fast joint, rad/s^2 (m/s^2).
    pub acceleration: f64,
    /// Peak velocity that each coordinate has if it is a slow joint, rad/s (m/s).
    pub slow_velocity: &'a [f64],
    /// Recorded time, s. It is rounded down to whole periods, but is at least one period.
    pub duration: f64,
    /// Time between samples, s.
    pub sample_time: f64,
}

/// The signal on which a spectral equation projects the torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projector {
    /// ddq of the fast joint, at the frequency f_P of its swing: equations (8) and (11) of [Vandanjon, Gautier, Desbats 1995].
    Acceleration,
    /// dq^2 of the fast joint, at twice the frequency f_P of its swing: equation (10) of [Vandanjon, Gautier, Desbats 1995].
    SquaredVelocity,
}

impl Projector {
    /// The harmonic of the motion's frequency at which the torque is projected on this signal.
    pub fn harmonic(self) -> usize {
        match self {
            Projector::Acceleration => 1,
            Projector::SquaredVelocity => 2,
        }
    }
}

/// A spectral equation Sp(D_joint, v) X = Sp(tau_joint, v). D_joint, tau_joint: regressor row and torque of the joint; X:
/// parameters; v: signal of the fast joint (projector). Sp(m, v) = Re(m conj v) / |v|^2, from the spectra of m and v at the
/// projector's frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpectralEquation {
    /// Index of the joint whose torque is projected.
    pub joint: usize,
    /// Signal of the fast joint on which the torque is projected.
    pub projector: Projector,
}

/// Acceleration of the ramps of a slow sweep (motion at constant velocity there and back), rad/s^2 (m/s^2).
pub(crate) const SWEEP_ACCELERATION: f64 = 2.0;
/// Time for which a slow sweep rests at each of its ends, s.
const SWEEP_REST_S: f64 = 0.1;
/// Time after each ramp of a slow sweep, s. In this time the controller settles, so the samples are not used.
const SWEEP_SETTLING_S: f64 = 0.15;
/// Number of periods of a swing (periodic motion) before the record starts.
const TRANSIENT_PERIODS: usize = 2;
/// Relative tolerance for rounding in the division of the recorded time by the period.
const PERIODS_TOLERANCE: f64 = 1e-9;

impl ExcitingTrajectory {
    /// Makes a swing (periodic motion) of the moving joints with the given profile, period and amplitudes.
    pub fn swing(joints: &MovingJoints, course: &SwingCourse) -> ExcitingTrajectory {
        let &MovingJoints { kind, fast, slow, centre } = joints;
        let &SwingCourse { profile, period, acceleration, slow_velocity, duration, sample_time } = course;
        let t = period as f64 * sample_time;
        let (v_factor, a_factor) = profile.peaks();
        let mut half_range = vec![0.0; centre.len()];
        half_range[fast] = 0.5 * acceleration * t * t / a_factor;
        for &l in slow {
            half_range[l] = 0.5 * slow_velocity[l] * t / v_factor;
        }
        // At least one whole period. The tolerance covers rounding if the duration is a multiple of the period.
        let periods = ((duration / t + PERIODS_TOLERANCE) as usize).max(1);
        ExcitingTrajectory {
            kind,
            fast,
            slow: slow.to_vec(),
            centre: centre.to_vec(),
            sample_time,
            motion: JointMotion::Swing { profile, period, half_range, transient_periods: TRANSIENT_PERIODS, periods },
        }
    }

    /// Makes a slow sweep of joint `fast` over `range` (rad or m) at `velocity` (rad/s or m/s) about the configuration
    /// `centre`.
    pub fn sweep(fast: usize, centre: &[f64], range: f64, velocity: f64, sample_time: f64) -> ExcitingTrajectory {
        ExcitingTrajectory {
            kind: MotionKind::Gravity,
            fast,
            slow: vec![],
            centre: centre.to_vec(),
            sample_time,
            motion: JointMotion::Sweep {
                range,
                velocity,
                acceleration: SWEEP_ACCELERATION,
                settling: SWEEP_SETTLING_S,
            },
        }
    }

    /// Indices of the coordinates that move. Only these give equations.
    pub fn moving(&self) -> Vec<usize> {
        std::iter::once(self.fast).chain(self.slow.iter().copied()).collect()
    }

    /// The spectral equations of this experiment. Empty for a gravity sweep (slow motion), which has the centred equations (13)
    /// of `paper_rows` instead.
    pub fn equations(&self) -> Vec<SpectralEquation> {
        let of = |projector: Projector| move |&joint: &usize| SpectralEquation { joint, projector };
        let own = SpectralEquation { joint: self.fast, projector: Projector::Acceleration };
        let (squares, couplings) = (of(Projector::SquaredVelocity), of(Projector::Acceleration));
        match self.kind {
            MotionKind::Inertial => vec![own],
            MotionKind::Centrifugal => self.slow.iter().map(squares).collect(),
            MotionKind::Coupling => self.slow.iter().map(couplings).collect(),
            MotionKind::Mixed => {
                let each = self.slow.iter().flat_map(|l| [squares(l), couplings(l)]);
                std::iter::once(own).chain(each).collect()
            }
            MotionKind::Gravity => vec![],
        }
    }

    /// Duration of the whole experiment, including transient periods or rests, s.
    pub fn duration(&self) -> f64 {
        self.samples() as f64 * self.sample_time
    }

    fn samples(&self) -> usize {
        match &self.motion {
            JointMotion::Swing { period, transient_periods, periods, .. } => period * (transient_periods + periods),
            JointMotion::Sweep { range, velocity, acceleration, .. } => {
                let one_way = velocity / acceleration + range / velocity;
                ((2.0 * one_way + 4.0 * SWEEP_REST_S) / self.sample_time).ceil() as usize
            }
        }
    }

    /// Ranges of sample indices that are used. Swing: whole periods after the transients. Sweep: the section of constant velocity
    /// in each direction.
    pub fn windows(&self) -> Vec<Range<usize>> {
        match &self.motion {
            JointMotion::Swing { period, transient_periods, periods, .. } => {
                let start = transient_periods * period;
                std::iter::once(start..start + periods * period).collect()
            }
            JointMotion::Sweep { range, velocity, acceleration, settling } => {
                let (ramp, all) = (velocity / acceleration, velocity / acceleration + range / velocity);
                let window = |start: f64| {
                    let first = ((start + ramp + settling) / self.sample_time).floor() as usize + 1;
                    let end = ((start + all - ramp) / self.sample_time).ceil() as usize;
                    first..end.max(first)
                };
                vec![window(SWEEP_REST_S), window(3.0 * SWEEP_REST_S + all)]
            }
        }
    }

    /// The reference motion of all coordinates at every sample.
    pub fn reference(&self) -> Reference {
        let (n, count, h) = (self.centre.len(), self.samples(), self.sample_time);
        let mut r = Reference {
            sample_time: h,
            q: self.centre.iter().map(|&c| vec![c; count]).collect(),
            dq: vec![vec![0.0; count]; n],
            ddq: vec![vec![0.0; count]; n],
            windows: self.windows(),
        };
        match &self.motion {
            // Swing: each moving joint follows its half range times the profile; all joints are in phase.
            JointMotion::Swing { profile, period, half_range, .. } => {
                let t = *period as f64 * h;
                for i in 0..count {
                    let (p, dp, ddp) = profile.at((i % period) as f64 / *period as f64);
                    for k in self.moving() {
                        r.q[k][i] += half_range[k] * p;
                        r.dq[k][i] = half_range[k] * dp / t;
                        r.ddq[k][i] = half_range[k] * ddp / (t * t);
                    }
                }
            }
            // Sweep: ramp up to the velocity, constant velocity, ramp down; after a rest, the same path back.
            JointMotion::Sweep { range, velocity, acceleration, .. } => {
                let k = self.fast;
                let (ramp, all) = (velocity / acceleration, velocity / acceleration + range / velocity);
                let cruise = all - 2.0 * ramp;
                let one_way = |t: f64| match t {
                    t if t <= 0.0 => (0.0, 0.0, 0.0),
                    t if t < ramp => (0.5 * acceleration * t * t, acceleration * t, *acceleration),
                    t if t < ramp + cruise => (velocity * (t - 0.5 * ramp), *velocity, 0.0),
                    t if t < all => {
                        (range - 0.5 * acceleration * (all - t).powi(2), acceleration * (all - t), -acceleration)
                    }
                    _ => (*range, 0.0, 0.0),
                };
                let (forth, back) = (SWEEP_REST_S, 3.0 * SWEEP_REST_S + all);
                for i in 0..count {
                    let t = i as f64 * h;
                    let ((p, v, a), (p_back, v_back, a_back)) = (one_way(t - forth), one_way(t - back));
                    r.q[k][i] += p - p_back - 0.5 * range;
                    r.dq[k][i] = v - v_back;
                    r.ddq[k][i] = a - a_back;
                }
            }
        }
        r
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use linear_model::friction::terms::sign;
    use random::Random;

    fn swing(profile: Profile) -> ExcitingTrajectory {
        let joints = MovingJoints { kind: MotionKind::Mixed, fast: 0, slow: &[1, 2], centre: &[0.0, 0.4, -0.2] };
        let course = SwingCourse {
            profile,
            period: 500,
            acceleration: 30.0,
            slow_velocity: &[0.5; 3],
            duration: 4.0,
            sample_time: 1e-3,
        };
        ExcitingTrajectory::swing(&joints, &course)
    }

    #[test]
    fn odd_half_wave_symmetry() {
        for profile in [Profile::BangBang, Profile::Smooth] {
            let r = swing(profile).reference();
            for k in 0..3 {
                let q: Vec<f64> = r.q[k].iter().map(|q| q - [0.0, 0.4, -0.2][k]).collect();
                for i in 125..375 {
                    // Tolerance: rounding of the profile's polynomial, whose amplitude is below 0.3 rad.
                    assert!((q[i + 250] + q[i]).abs() < 1e-15 * 4.0);
                    let s = i - 125;
                    assert!(s > 125 || (q[125 + s] + q[125 - s]).abs() < 1e-15 * 4.0);
                }
            }
        }
    }

    #[test]
    fn friction_of_the_moving_joint_is_orthogonal_to_its_acceleration() {
        // Theorem: for any friction law f(dq), f is orthogonal to ddq at any odd harmonic of the swing. In addition, the integral
        // of f(dq) ddq over a period is zero, even without symmetry.
        let mut random = Random::new(5);
        for profile in [Profile::BangBang, Profile::Smooth] {
            let r = swing(profile).reference();
            let (v, a) = (&r.dq[0][..500], &r.ddq[0][..500]);
            for _ in 0..20 {
                let c: Vec<f64> = (0..8).map(|_| random.normal()).collect();
                let law = |v: f64| {
                    let (s, asymmetric) = (sign(v), c[0] * v + c[2] * v.abs());
                    asymmetric
                        + c[1] * s
                        + c[3] * s * s
                        + c[4] * v.abs().sqrt()
                        + c[5] * (c[6] * v).sin()
                        + c[7] * (-v * v).exp()
                };
                let f: Vec<f64> = v.iter().map(|&v| law(v)).collect();
                for h in [1, 3, 5, 7] {
                    let (f_h, a_h) = (numerics::fourier::bin(&f, h), numerics::fourier::bin(a, h));
                    let cosine = (f_h * a_h.conj()).re / (f_h.norm() * a_h.norm());
                    // Tolerance for the cosine of the angle between friction and acceleration: rounding of sums of 500 terms.
                    assert!(cosine.abs() < 1e-11, "{profile:?} {h} {cosine}");
                }
                let integral: f64 = f.iter().zip(a).map(|(f, a)| f * a).sum();
                let scale: f64 = f.iter().zip(a).map(|(f, a)| (f * a).abs()).sum();
                assert!(integral.abs() < 1e-11 * scale);
            }
        }
    }

    #[test]
    fn derivatives_belong_to_positions() {
        let sweep = ExcitingTrajectory::sweep(1, &[0.0, 0.0, 0.3], 2.0, 1.0, 1e-3);
        for t in [swing(Profile::BangBang), swing(Profile::Smooth), sweep] {
            let r = t.reference();
            for k in 0..3 {
                for i in 1..r.q[k].len() - 1 {
                    let v = (r.q[k][i + 1] - r.q[k][i - 1]) / 2e-3;
                    // Two errors of the central difference are allowed: a term of second order in the sample time; and, where
                    // the acceleration jumps by 32 rad/s^2, at most half of the jump times the sample time.
                    assert!((v - r.dq[k][i]).abs() < 0.02, "{k} {i} {v} {}", r.dq[k][i]);
                }
            }
        }
    }

    #[test]
    fn a_sweep_goes_forth_and_back_at_its_velocity() {
        let r = ExcitingTrajectory::sweep(1, &[0.0, 0.1, 0.3], 2.0, 1.0, 1e-3).reference();
        for (window, velocity) in r.windows.iter().zip([1.0, -1.0]) {
            assert!(window.len() > 800);
            assert!(window.clone().all(|i| (r.dq[1][i] - velocity).abs() < 1e-12 && r.ddq[1][i] == 0.0));
        }
        let last = r.q[1].len() - 1;
        assert!((r.q[1][0] + 0.9).abs() < 1e-12 && (r.q[1][last] + 0.9).abs() < 1e-12);
    }

    #[test]
    fn equations_of_the_kinds() {
        let mut t = swing(Profile::BangBang);
        assert_eq!(t.equations().len(), 5);
        t.kind = MotionKind::Centrifugal;
        let found: Vec<_> = t.equations().iter().map(|e| (e.joint, e.projector.harmonic())).collect();
        assert_eq!(found, [(1, 2), (2, 2)]);
        assert_eq!(MotionKind::from_word("coupling"), Some(MotionKind::Coupling));
    }
}
