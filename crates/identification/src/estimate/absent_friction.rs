//! Detects logged torques that contain no friction: the torques were measured behind the gears, or a controller subtracted the
//! friction from them. The result is a sentence with the names of these joints.
//!
//! A joint has the largest speed v, the torque rms T, viscous friction b and Coulomb friction c; s_b, s_c: standard deviations
//! of b and c. Friction is absent if neither b nor c is significant and
//! ```text
//! |c| + 2 s_c + (|b| + 2 s_b) v < 0.02 T
//! ```
//! Joints with gears have more friction than this limit: in the tests, no log with friction gives the sentence.

use linear_model::parameter::{FrictionParameter, ParameterId};

use crate::estimate::artefact::Estimate;
use crate::estimate::digits::percent;

/// Friction is absent if its bound is below this share of the torque.
const ABSENT_SHARE: f64 = 0.02;
/// A friction parameter is significant beyond this many standard deviations.
const SIGNIFICANT_SIGMAS: f64 = 3.0;
/// Half width of the interval of a parameter, in standard deviations.
const BOUND_SIGMAS: f64 = 2.0;

/// A sentence that friction is not in the torques of some joints; `None` if all torques contain friction, or if no friction was
/// fitted. `speeds`: largest speed of each coordinate, rad/s (m/s).
pub fn absent_friction(estimate: &Estimate, speeds: &[f64]) -> Option<String> {
    let bound = |k: usize| {
        let name = &estimate.joints[k].coordinate;
        let of = |friction: FrictionParameter| {
            let id = ParameterId::friction(friction, name);
            let found = estimate.parameters.iter().find(|p| p.id == id)?;
            let (value, sigma) = (found.value?.abs(), found.sigma?);
            (value <= SIGNIFICANT_SIGMAS * sigma).then_some(value + BOUND_SIGMAS * sigma)
        };
        let friction = of(FrictionParameter::Coulomb)? + of(FrictionParameter::Viscous)? * speeds[k];
        let joint = &estimate.joints[k];
        let share = friction * joint.relative / joint.rms;
        (share < ABSENT_SHARE).then_some((name.as_str(), share))
    };
    let absent: Vec<(&str, f64)> = (0..estimate.joints.len()).filter_map(bound).collect();
    let share = absent.iter().map(|of| of.1).fold(0.0, f64::max);
    let names: Vec<&str> = absent.iter().map(|of| of.0).collect();
    (!absent.is_empty()).then(|| {
        format!(
            "friction is not in this torque: {}: viscous and Coulomb friction are below {} of the torque; it was measured \
             behind the gear, friction was taken out of it, or the joint has no gear",
            names.join(", "),
            percent(share)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::identified::{Deviations, Identified};
    use crate::estimate::residuals::{Residuals, Squares};
    use crate::test_arm::Pendulum;
    use linear_model::unit::Unit;

    #[test]
    fn friction_is_absent_below_a_fiftieth_of_the_torque() {
        let said = |viscous: f64, coulomb: f64, sigma: f64| {
            let mut joints = Residuals::new(&Pendulum::new(), vec![Squares::default()]).joints;
            (joints[0].rms, joints[0].relative) = (0.1, 0.01);
            let name = joints[0].coordinate.clone();
            let of = |friction, unit, value| {
                let deviations = Deviations { sigma, white: Some(sigma), weak: false };
                Identified::new(ParameterId::friction(friction, &name), unit, value, deviations)
            };
            let parameters = vec![
                of(FrictionParameter::Viscous, Unit::VISCOUS, viscous),
                of(FrictionParameter::Coulomb, Unit::TORQUE, coulomb),
            ];
            absent_friction(&Estimate { parameters, joints, ..Estimate::default() }, &[2.0])
        };
        // The torque has an rms of 10 N m, so the limit is 0.2 N m.
        assert!(said(0.01, 0.01, 0.01).unwrap().starts_with("friction is not in this torque: "));
        // Significant friction; and an interval that is too wide.
        assert!(said(0.01, 0.05, 0.01).is_none() && said(0.01, 0.01, 0.05).is_none());
    }
}
