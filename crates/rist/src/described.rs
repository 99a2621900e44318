//! What the description tells of torques: friction, values of parameters, noise.

use experiments::excitation::limits::CoordinateLimits;
use experiments::excitation::proof::DescribedFriction;
use linear_model::linear_model::Model as LinearModel;
use linear_model::parameter::FrictionParameter;
use robot::RotorInertia;
use robot::value::CoordinateId;

use crate::model::Model;

/// Torque noise where no effort limit is known, N m (N).
const UNKNOWN_NOISE: f64 = 0.1;

/// Noise of a torque sample, N m (N), one a coordinate: a share of the effort limit.
pub(crate) fn torque_noise(model: &Model, share: f64, notes: &mut Vec<String>) -> Vec<f64> {
    let coordinates = &model.robot.coordinates;
    let effort = |c: &robot::Coordinate| c.limits.effort.filter(|x| x.is_finite() && *x > 0.0);
    let unknown: Vec<&str> = coordinates.iter().filter(|c| effort(c).is_none()).map(|c| c.name.as_str()).collect();
    if !unknown.is_empty() {
        let names = unknown.join(", ");
        notes.push(format!("{names}: no effort limit given, torque noise of {UNKNOWN_NOISE} N m (N) a sample assumed"));
    }
    coordinates.iter().map(|c| effort(c).map_or(UNKNOWN_NOISE, |e| share * e)).collect()
}

/// Friction of the description, one a coordinate.
pub(crate) fn described_friction(model: &Model) -> Vec<DescribedFriction> {
    let of = |k: usize| {
        let joint = model.robot.joint_of(CoordinateId(k)).map(|j| &model.robot.link(j).joint);
        let friction = joint.map(|j| j.friction).unwrap_or_default();
        DescribedFriction {
            viscous: friction.viscous.unwrap_or(0.0),
            coulomb: friction.coulomb.unwrap_or(0.0),
            offset: friction.offset.unwrap_or(0.0),
        }
    };
    (0..model.robot.n_coordinates()).map(of).collect()
}

/// A note where torques are not checked, with the reason.
pub(crate) fn torque_note(is_known: bool, names: &[String], limits: &[CoordinateLimits]) -> Option<String> {
    if !is_known {
        return Some("torques are not looked at: the description has no inertial parameters".into());
    }
    let unknown = names.iter().zip(limits).filter(|(_, l)| l.effort.is_none());
    let unknown: Vec<&str> = unknown.map(|(name, _)| name.as_str()).collect();
    let names = unknown.join(", ");
    (!unknown.is_empty()).then(|| format!("torques of {names} are not looked at: no effort limit given"))
}

/// Values of the description, one a parameter of the model.
pub(crate) fn described_values(model: &Model, linear: &LinearModel) -> Vec<Option<f64>> {
    let base = model.described_parameters();
    let count = model.regressor().parameters().len();
    let mut values: Vec<Option<f64>> = (0..count).map(|c| base.as_ref().map(|b| b[c])).collect();
    for k in 0..linear.n() {
        let joint = model.robot.joint_of(CoordinateId(k)).map(|j| &model.robot.link(j).joint);
        let friction = joint.map(|j| j.friction).unwrap_or_default();
        let rotor = joint.and_then(|j| if let RotorInertia::Known(x) = j.rotor_inertia { Some(x) } else { None });
        values.extend(linear.friction.iter().flat_map(|t| t.parameters_of(k)).map(|p| match p {
            FrictionParameter::Viscous | FrictionParameter::ViscousForward | FrictionParameter::ViscousBackward => {
                friction.viscous
            }
            FrictionParameter::Coulomb => friction.coulomb,
            FrictionParameter::Offset => friction.offset,
            FrictionParameter::Rotor => rotor,
            _ => None,
        }));
    }
    values
}
