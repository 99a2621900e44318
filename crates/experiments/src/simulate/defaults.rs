//! Default properties of a simulated robot for those that its file does not state. Each default that is used gives a note.
//!
//! - Limits of +-1.5 rad, 5 rad/s, 30 rad/s^2; of +-0.25 m, 1.25 m/s, 7.5 m/s^2 if the joint is prismatic. Position limits are
//!   taken from [`crate::excitation::limits`]; velocities are five times the velocities there. The slow velocity is 0.5 rad/s
//!   (m/s), or a tenth of the greatest velocity if that is less.
//! - Coulomb friction of 5 % of the effort A_kk a_max that the greatest acceleration takes, with an offset of 5 % of the Coulomb
//!   friction; viscous friction of half the Coulomb friction at the greatest velocity, a tenth less for negative velocities.
//! - A greatest effort of five times A_kk a_max plus three times the gravity torque.
//!
//! A_kk: mean inertia of joint k; a_max: its greatest acceleration. Friction values in the file are used unchanged. If the file
//! has a Coulomb friction, the offset is the offset in the file, or zero.

use linear_model::friction::law::FrictionLaw;
use robot::value::CoordinateId;
use robot::{Joint, JointKind, Robot};

use crate::excitation::limits::{LimitKind, assumed};
use crate::plan::candidates::MotionLimits;

/// Bandwidth of the simulated controllers, Hz.
pub(super) const CONTROL_BANDWIDTH_HZ: f64 = 10.0;
/// Quantum of the simulated position sensors, rad (m).
pub(super) const POSITION_QUANTUM: f64 = 1e-4;
/// Default velocity limit of a simulated joint as a multiple of the velocity of [`assumed`]. It is greater, because a simulated
/// robot cannot be damaged.
const ASSUMED_VELOCITY_FACTOR: f64 = 5.0;
/// Ratio of the default acceleration limit to the default velocity limit, 1/s.
const ASSUMED_ACCELERATION_RATIO: f64 = 6.0;
/// Greatest default of a joint's slow velocity (smallest velocity without stick-slip), rad/s (m/s).
const MAX_SLOW_VELOCITY: f64 = 0.5;
/// Default of a joint's slow velocity as a share of its velocity limit, if that is below [`MAX_SLOW_VELOCITY`].
const SLOW_VELOCITY_SHARE: f64 = 0.1;
/// Default Coulomb friction as a share of the effort A_kk a_max; A_kk: mean inertia, a_max: greatest acceleration.
const COULOMB_SHARE_OF_EFFORT: f64 = 0.05;
/// Default offset of the friction torque as a share of the Coulomb friction.
const OFFSET_SHARE_OF_COULOMB: f64 = 0.05;
/// Default viscous friction at negative velocities, as a share of viscous friction at positive velocities.
const BACKWARD_VISCOUS_RATIO: f64 = 0.9;
/// Default greatest effort, without gravity, as a multiple of A_kk a_max; A_kk: mean inertia, a_max: greatest acceleration.
const EFFORT_MARGIN: f64 = 5.0;
/// Multiple of the greatest gravity torque that is added to the default greatest effort.
const GRAVITY_MARGIN: f64 = 3.0;

/// Notes on defaults that were used: (text, names of coordinates). One note covers all coordinates with the same default.
#[derive(Default)]
struct Taken(Vec<(String, Vec<String>)>);

impl Taken {
    /// Adds a note on a default of the coordinate `name`.
    fn note(&mut self, name: String, text: String) {
        match self.0.iter_mut().find(|t| t.0 == text) {
            Some(t) => t.1.push(name),
            None => self.0.push((text, vec![name])),
        }
    }

    /// The notes on defaults as sentences: `NAME, NAME: text`.
    fn sentences(self) -> impl Iterator<Item = String> {
        self.0.into_iter().map(|(text, names)| format!("{}: {text}", names.join(", ")))
    }

    /// The notes on defaults as sentences with values: `text: NAME VALUE, NAME VALUE`.
    fn with_values(self) -> impl Iterator<Item = String> {
        self.0.into_iter().map(|(text, values)| format!("{text}: {}", values.join(", ")))
    }
}

/// The joint that the coordinate with index k moves.
pub(super) fn joint_of(robot: &Robot, k: usize) -> Option<&Joint> {
    robot.joint_of(CoordinateId(k)).map(|j| &robot.link(j).joint)
}

fn is_prismatic(robot: &Robot, k: usize) -> bool {
    joint_of(robot, k).is_some_and(|joint| joint.kind == JointKind::Prismatic)
}

/// Limits of all coordinates from the robot's file or from defaults, and a note on each default that was used.
pub fn motion_limits(robot: &Robot) -> (Vec<MotionLimits>, Vec<String>) {
    let mut taken = Taken::default();
    let limits = robot.coordinates.iter().enumerate().map(|(k, c)| {
        let slides = is_prismatic(robot, k);
        let (far, fast) = assumed(slides);
        let mut note = |text: String| taken.note(c.name.clone(), text);
        let mut or = |found: Option<f64>, value: f64, kind: LimitKind| {
            let what = format!("greatest {kind} ({})", kind.unit(slides));
            match found {
                Some(x) if x.is_finite() && x > 0.0 => return x,
                Some(x) => note(format!("{what} of {x} in the file, which allows no motion; {value} assumed")),
                None => note(format!("no {what} in the file, {value} assumed")),
            }
            value
        };
        // The limits of the file are used if they allow a motion.
        let fast = ASSUMED_VELOCITY_FACTOR * fast;
        let velocity = or(c.limits.velocity, fast, LimitKind::Velocity);
        let acceleration = or(c.limits.acceleration, ASSUMED_ACCELERATION_RATIO * fast, LimitKind::Acceleration);
        let unit = LimitKind::Position.unit(slides);
        let position = match c.limits.position {
            Some((low, high)) if low < high && low.is_finite() && high.is_finite() => (low, high),
            Some((low, high)) => {
                note(format!(
                    "position from {low} to {high} in the file, which allows no motion; +-{far} {unit} assumed"
                ));
                (-far, far)
            }
            None => {
                note(format!("no limits of position in the file, +-{far} {unit} assumed"));
                (-far, far)
            }
        };
        let slow_velocity = MAX_SLOW_VELOCITY.min(SLOW_VELOCITY_SHARE * velocity);
        MotionLimits {
            position,
            velocity,
            acceleration,
            slow_velocity,
            bandwidth: CONTROL_BANDWIDTH_HZ,
            quantum: POSITION_QUANTUM,
        }
    });
    let limits = limits.collect();
    (limits, taken.sentences().collect())
}

/// The friction law of each joint, from the robot's file or from defaults. `effort`: torque A_kk a_max for the greatest
/// acceleration of each joint, N m (N); `notes` receives a sentence on each default.
pub(super) fn joint_friction(
    robot: &Robot,
    limits: &[MotionLimits],
    effort: &[f64],
    notes: &mut Vec<String>,
) -> Vec<FrictionLaw> {
    let mut taken = Taken::default();
    // Friction torque at the velocity v: G(v) = F v + Fs sign(v) + offset (F: viscous, Fs: Coulomb friction). Each coefficient is
    // from the file, or a share of the effort.
    let law = |(k, (limits, effort)): (usize, (&MotionLimits, &f64))| {
        let file = joint_of(robot, k).map(|j| j.friction).unwrap_or_default();
        let unit = LimitKind::Effort.unit(is_prismatic(robot, k));
        let per = LimitKind::Velocity.unit(is_prismatic(robot, k));
        let mut or = |found: Option<f64>, value: f64, what: &str, unit: String| {
            found.unwrap_or_else(|| {
                let name = format!("{} {} {unit}", robot.coordinates[k].name, digits(value));
                taken.note(name, format!("no {what} in the file, assumed"));
                value
            })
        };
        let coulomb = or(file.coulomb, COULOMB_SHARE_OF_EFFORT * effort, "Coulomb friction", unit.into());
        let what = "viscous friction (backward a tenth less)";
        let viscous = or(file.viscous, 0.5 * coulomb / limits.velocity, what, format!("{unit}/({per})"));
        let backward = if file.viscous.is_some() { viscous } else { BACKWARD_VISCOUS_RATIO * viscous };
        let offset = match file.coulomb {
            Some(_) => file.offset.unwrap_or(0.0),
            None => or(file.offset, OFFSET_SHARE_OF_COULOMB * coulomb, "offset of friction", unit.into()),
        };
        // Without viscous friction, the friction torque G is coulomb + offset for v > 0 and offset - coulomb for v < 0.
        FrictionLaw::asymmetric(viscous, coulomb + offset, backward, offset - coulomb)
    };
    let laws = limits.iter().zip(effort).enumerate().map(law).collect();
    notes.extend(taken.with_values());
    laws
}

/// The greatest effort of each drive, N m (N): from the robot's file, or else enough for the greatest acceleration and gravity.
/// `effort`: torque for the greatest acceleration; `bias`: greatest gravity torque.
pub(super) fn greatest_effort(robot: &Robot, effort: &[f64], bias: &[f64], notes: &mut Vec<String>) -> Vec<f64> {
    let mut taken = Taken::default();
    let of = |(k, (effort, bias)): (usize, (&f64, &f64))| match robot.coordinates[k].limits.effort {
        Some(limit) if limit > 0.0 && limit.is_finite() => limit,
        other => {
            let assumed = EFFORT_MARGIN * effort + GRAVITY_MARGIN * bias;
            let unit = LimitKind::Effort.unit(is_prismatic(robot, k));
            let text = match other {
                Some(limit) => format!("greatest effort of {limit} in the file, assumed"),
                None => "no greatest effort in the file, assumed".into(),
            };
            taken.note(format!("{} {} {unit}", robot.coordinates[k].name, digits(assumed)), text);
            assumed
        }
    };
    let greatest = effort.iter().zip(bias).enumerate().map(of).collect();
    notes.extend(taken.with_values());
    greatest
}

/// A default value as text with three significant digits, or with few decimals.
fn digits(x: f64) -> String {
    match x.abs() {
        size if size > 0.0 && size < 1e-3 => format!("{x:.2e}"),
        size if size < 10.0 => format!("{x:.3}"),
        _ => format!("{x:.1}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::dynamics::Dynamics;
    use crate::simulate::setup::SimulationSetup;

    /// Simulation setup of an arm of two joints with inertias 1 and 4 kg m^2. `first` and `second`: further text for the joints
    /// in its file.
    fn setup(first: &str, second: &str) -> SimulationSetup {
        struct Two;
        impl Dynamics for Two {
            fn n_coordinates(&self) -> usize {
                2
            }
            fn fill(&self, _: &[f64], _: &[f64], a: &mut [f64], h: &mut [f64]) {
                a.copy_from_slice(&[1.0, 0.0, 0.0, 4.0]);
                h.copy_from_slice(&[0.0, -2.0]);
            }
        }
        let text = format!(
            "convention: khalil-kleinfinger\nname: two\nlinks:\n  - {{link: 1, antecedent: base, theta: q1{first}}}\n  \
             - {{link: 2, antecedent: 1, r: q2, joint: prismatic{second}}}\n"
        );
        SimulationSetup::for_robot(&robot::format::read_yaml(&text, "two.yaml").unwrap(), &Two)
    }

    #[test]
    fn what_the_file_states_is_taken_and_all_else_is_said() {
        let limits = "limits: {position: [-1, 1], velocity: 2, acceleration: 10, effort: 50}";
        let stated = setup(
            &format!(", {limits}, friction: {{viscous: 0.4, coulomb: 0.3, offset: 0.1}}"),
            &format!(", {limits}, friction: {{viscous: 0.2, coulomb: 0.6}}"),
        );
        assert!(stated.notes.is_empty(), "{:?}", stated.notes);
        assert_eq!(stated.friction[0], FrictionLaw::asymmetric(0.4, 0.3 + 0.1, 0.4, 0.1 - 0.3));
        assert_eq!(stated.friction[1], FrictionLaw::asymmetric(0.2, 0.6, 0.2, -0.6));
        assert_eq!(stated.drives.greatest_torque, [50.0, 50.0]);
        let bare = setup("", "");
        // Coulomb friction: 5 % of the effort, 1 * 30 and 4 * 7.5. Viscous friction: half of the Coulomb friction, divided by the
        // greatest velocities 5 and 1.25. Greatest effort: five times the effort A_kk a_max plus three times the gravity torque.
        assert_eq!(
            bare.notes,
            [
                "q1: no greatest velocity (rad/s) in the file, 5 assumed",
                "q1: no greatest acceleration (rad/s^2) in the file, 30 assumed",
                "q1: no limits of position in the file, +-1.5 rad assumed",
                "q2: no greatest velocity (m/s) in the file, 1.25 assumed",
                "q2: no greatest acceleration (m/s^2) in the file, 7.5 assumed",
                "q2: no limits of position in the file, +-0.25 m assumed",
                "no Coulomb friction in the file, assumed: q1 1.500 N m, q2 1.500 N",
                "no viscous friction (backward a tenth less) in the file, assumed: q1 0.150 N m/(rad/s), q2 0.600 N/(m/s)",
                "no offset of friction in the file, assumed: q1 0.075 N m, q2 0.075 N",
                "no greatest effort in the file, assumed: q1 150.0 N m, q2 156.0 N",
            ]
        );
        // The inertia is a mean over twenty equal inertias, so it is one only up to rounding.
        let expected = FrictionLaw::asymmetric(0.15, 1.5 + 0.075, 0.9 * 0.15, 0.075 - 1.5);
        for speed in [-1.0, 0.002, 2.0] {
            assert!((bare.friction[0].torque(speed, 0.0) - expected.torque(speed, 0.0)).abs() < 1e-14);
        }
        let half = setup(", friction: {coulomb: 2}", ", limits: {effort: 0}");
        let (notes, said) = (&half.notes, "greatest effort of 0 in the file, assumed: q2 156.0 N");
        assert!(notes.iter().any(|note| note == said), "{notes:?}");
        assert_eq!((half.friction[0].coulomb_positive, half.friction[0].coulomb_negative), (2.0, -2.0));
    }
}
