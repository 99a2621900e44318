//! Interval enclosures of drive torques and powers along a motion. A proof of their limits halves time intervals until the
//! enclosures are within the limits.

use numerics::interval::Interval;
use numerics::jet::Jet;

use crate::excitation::enclosure::Derivatives;
use crate::excitation::limits::{CoordinateLimits, LimitKind};
use crate::excitation::nominal_torque::NominalTorque;
use crate::excitation::trajectory::EnclosedTrajectory;

/// Magnitude of the dry friction of a coordinate, N m (N).
pub(super) fn dry(described: &NominalTorque, k: usize) -> f64 {
    described.friction[k].coulomb.abs()
}

/// The drive limits: coordinate, kind (effort or power), and the usable value, N m (N) or W. The dry friction of a joint at rest
/// may act in either direction, so its magnitude is subtracted from the effort.
pub(super) fn limited_drives(limits: &[CoordinateLimits], described: &NominalTorque) -> Vec<(usize, LimitKind, f64)> {
    let effort = |k: usize| Some((k, LimitKind::Effort, described.share * limits[k].effort? - dry(described, k)));
    let power = |k: usize| Some((k, LimitKind::Power, described.share * limits[k].power?));
    (0..limits.len()).filter_map(effort).chain((0..limits.len()).filter_map(power)).collect()
}

/// Torque without friction and velocity of each coordinate, as jets (values with two time derivatives, in intervals).
type DriveJets = Vec<(Jet, Jet)>;

/// Enclosures of each coordinate: torque with viscous friction and offset but without dry friction, N m (N); power with all
/// friction, W.
pub(super) type DriveEnclosure = Vec<(Interval, Interval)>;

/// Encloses torques and powers on the time interval `part` of segment number `stretch`, and at the middle of this interval.
pub(super) fn drives_on(
    enclosed: &dyn EnclosedTrajectory,
    stretch: usize,
    part: Interval,
    described: &NominalTorque,
) -> (DriveEnclosure, DriveEnclosure) {
    let middle = Interval::point(part.middle());
    let thin = jets(&enclosed.on(stretch, middle), described);
    let at_middle = drives(described, &thin, |jet| jet(&thin).0[0]);
    if part.width() == 0.0 {
        return (at_middle.clone(), at_middle);
    }
    let wide = jets(&enclosed.on(stretch, part), described);
    let over = |jet: &dyn Fn(&DriveJets) -> Jet| Jet::over_interval(jet(&thin), jet(&wide), part - middle);
    (drives(described, &wide, over), at_middle)
}

/// Encloses torques and powers at local time `t` (s) of segment number `stretch`.
pub(super) fn drives_at(
    enclosed: &dyn EnclosedTrajectory,
    stretch: usize,
    t: f64,
    described: &NominalTorque,
) -> DriveEnclosure {
    drives_on(enclosed, stretch, Interval::point(t), described).1
}

fn jets(states: &[Derivatives], described: &NominalTorque) -> DriveJets {
    let of = |d: usize| -> Vec<Jet> { states.iter().map(|x| Jet::of_derivatives(x[d], x[d + 1], x[d + 2])).collect() };
    let dq = of(1);
    described.torque.torque(&of(0), &dq, &of(2)).into_iter().zip(dq).collect()
}

/// Torques and powers from `states`, the jets of torque and velocity. `of` encloses a function of these jets on the interval.
fn drives(
    described: &NominalTorque,
    states: &DriveJets,
    of: impl Fn(&dyn Fn(&DriveJets) -> Jet) -> Interval,
) -> DriveEnclosure {
    let one = |k: usize| {
        let (f, velocity) = (described.friction[k], states[k].1.0[0]);
        let torque = of(&|all| all[k].0) + velocity * f.viscous + Interval::point(f.offset);
        // If the velocity does not change its sign on the interval, the sign of the dry friction is known.
        let (sign, turning) = match velocity {
            v if v.low >= 0.0 => (1.0, Interval::ZERO),
            v if v.high <= 0.0 => (-1.0, Interval::ZERO),
            v => (0.0, Interval::new(0.0, v.magnitude())),
        };
        let dry = f.coulomb.abs();
        let power = |all: &DriveJets| {
            let (torque, dq) = all[k];
            let constant = |x: f64| Jet::constant(Interval::point(x));
            (torque + dq * constant(f.viscous) + constant(f.offset) + constant(sign * dry)) * dq
        };
        (torque, of(&power) + turning * dry)
    };
    (0..states.len()).map(one).collect()
}
