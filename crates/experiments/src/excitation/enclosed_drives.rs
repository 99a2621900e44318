//! Torques and powers along a motion, enclosed: what a proof of their limits divides until it holds.

use numerics::interval::Interval;
use numerics::jet::Jet;

use crate::excitation::course::EnclosedCourse;
use crate::excitation::described_torque::DescribedTorque;
use crate::excitation::enclosure::Derivatives;
use crate::excitation::limits::{CoordinateLimits, LimitKind};

/// Dry friction of a coordinate, N m (N).
pub(super) fn dry(described: &DescribedTorque, k: usize) -> f64 {
    described.friction[k].coulomb.abs()
}

/// The limits of torque and power: coordinate, kind, and what of it may be used. The dry friction of a joint at rest may
/// act to either side, so it is kept free.
pub(super) fn limited_drives(limits: &[CoordinateLimits], described: &DescribedTorque) -> Vec<(usize, LimitKind, f64)> {
    let effort = |k: usize| Some((k, LimitKind::Effort, described.share * limits[k].effort? - dry(described, k)));
    let power = |k: usize| Some((k, LimitKind::Power, described.share * limits[k].power?));
    (0..limits.len()).filter_map(effort).chain((0..limits.len()).filter_map(power)).collect()
}

/// The jets of torque and velocity of each coordinate at an instant.
pub(super) type DriveJets = Vec<(Jet, Jet)>;

/// Torque of each coordinate on a part of a stretch, with viscous friction and offset, N m (N); and power, with dry friction
/// too, W. `last`: the middle of the part before with its jets, which an instant that is asked for next mostly is.
pub(super) fn drives_on(
    enclosed: &dyn EnclosedCourse,
    stretch: usize,
    part: Interval,
    described: &DescribedTorque,
    last: &mut Option<(f64, DriveJets)>,
) -> Vec<(Interval, Interval)> {
    let jets = |states: &[Derivatives]| -> DriveJets {
        let of =
            |d: usize| -> Vec<Jet> { states.iter().map(|x| Jet::of_derivatives(x[d], x[d + 1], x[d + 2])).collect() };
        let dq = of(1);
        described.torque.torque(&of(0), &dq, &of(2)).into_iter().zip(dq).collect()
    };
    let states = enclosed.on(stretch, part);
    let is_point = part.width() == 0.0;
    let middle = Interval::point(part.middle());
    let thin = match last.take_if(|(time, _)| is_point && *time == middle.low) {
        Some((_, known)) => known,
        None => jets(&enclosed.on(stretch, middle)),
    };
    let wide = if is_point { thin.clone() } else { jets(&states) };
    *last = (!is_point).then(|| (middle.low, thin.clone()));
    let over = |thin: Jet, wide: Jet| match is_point {
        true => wide.0[0],
        false => Jet::over_interval(thin, wide, part - middle),
    };
    let one = |k: usize| {
        let (f, velocity) = (described.friction[k], states[k][1]);
        let torque = over(thin[k].0, wide[k].0) + velocity * f.viscous + Interval::point(f.offset);
        // Where the joint does not turn round, the sign of its dry friction is known.
        let (sign, turning) = match velocity {
            v if v.low >= 0.0 => (1.0, Interval::ZERO),
            v if v.high <= 0.0 => (-1.0, Interval::ZERO),
            v => (0.0, Interval::new(0.0, v.magnitude())),
        };
        let dry = f.coulomb.abs();
        let power = |(torque, dq): &(Jet, Jet)| {
            let constant = |x: f64| Jet::constant(Interval::point(x));
            (*torque + *dq * constant(f.viscous) + constant(f.offset) + constant(sign * dry)) * *dq
        };
        (torque, over(power(&thin[k]), power(&wide[k])) + turning * dry)
    };
    (0..wide.len()).map(one).collect()
}
