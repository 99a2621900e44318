//! Values of the description that torques depend on: friction, parameters, noise.
//!
//! A noise is the standard deviation of one torque sample.

use claims::{LeftOut, LeftOutTopic};
use experiments::excitation::limits::{AskedLimits, CoordinateLimits, LimitsFile};
use experiments::excitation::proof::NominalFriction;
use linear_model::linear_model::Model as LinearModel;
use linear_model::parameter::FrictionParameter;
use robot::RotorInertia;
use robot::value::CoordinateId;

use crate::describe::model::Model;

/// Noise (sigma) of a torque sample if no effort limit is known, N m (N).
const DEFAULT_TORQUE_NOISE: f64 = 0.1;

/// Noise (sigma) of a torque sample, N m (N), one per coordinate: `share` of the effort limit. `notes` gets a sentence on
/// coordinates without a limit.
pub fn torque_noise(model: &Model, share: f64, notes: &mut Vec<String>) -> Vec<f64> {
    let coordinates = &model.robot.coordinates;
    let effort = |c: &robot::Coordinate| c.limits.effort.filter(|x| x.is_finite() && *x > 0.0);
    let unknown: Vec<&str> = coordinates.iter().filter(|c| effort(c).is_none()).map(|c| c.name.as_str()).collect();
    if !unknown.is_empty() {
        let names = unknown.join(", ");
        notes.push(format!(
            "{names}: no effort limit given, torque noise of {DEFAULT_TORQUE_NOISE} N m (N) a sample assumed"
        ));
    }
    coordinates.iter().map(|c| effort(c).map_or(DEFAULT_TORQUE_NOISE, |e| share * e)).collect()
}

/// The friction in the description, one entry per coordinate; missing values are zero.
pub(crate) fn nominal_friction(model: &Model) -> Vec<NominalFriction> {
    let of = |k: usize| {
        let joint = model.robot.joint_of(CoordinateId(k)).map(|j| &model.robot.link(j).joint);
        let friction = joint.map(|j| j.friction).unwrap_or_default();
        NominalFriction {
            viscous: friction.viscous.unwrap_or(0.0),
            coulomb: friction.coulomb.unwrap_or(0.0),
            offset: friction.offset.unwrap_or(0.0),
        }
    };
    (0..model.robot.n_coordinates()).map(of).collect()
}

/// Reports the limits of torque and power that are not checked, with the reason. `asked`: the limits file of the user.
pub(crate) fn torque_left_out(
    model: &Model,
    is_known: bool,
    names: &[String],
    limits: &[CoordinateLimits],
    asked: Option<&LimitsFile>,
) -> Vec<LeftOut> {
    // Limits in the user's file are reported separately from limits that only the description gives.
    let is_asked = |name: &str, of: fn(&AskedLimits) -> Option<f64>| {
        asked.is_some_and(|file| of(&file.of(name)).or(of(&file.all)).is_some())
    };
    let of = |is: &dyn Fn(&str, &CoordinateLimits) -> bool| -> Vec<String> {
        names.iter().zip(limits).filter(|(name, l)| is(name, l)).map(|(name, _)| name.clone()).collect()
    };
    let out = |matter: LeftOutTopic, of: Vec<String>, why: &str, would_tell: &str, is_asked: bool| {
        let found = LeftOut::not_looked_at(matter, of, why, would_tell);
        LeftOut { is_asked, ..found }
    };
    let unknown = |matter: LeftOutTopic, of: Vec<String>, is_asked: bool| {
        let would_tell = "inertial parameters in the description, or an estimate ([after=ESTIMATE])";
        out(matter, of, "the description has no inertial parameters", would_tell, is_asked)
    };
    let effort = |l: &AskedLimits| l.effort;
    let power = |l: &AskedLimits| l.power;
    let all = match is_known {
        true => {
            let unlimited = of(&|_, l| l.effort.is_none());
            let bears = |link: &&robot::Link| link.joint.follower_effort.is_some();
            let followers = model.robot.links.iter().filter(bears).map(|link| link.joint.name.clone()).collect();
            let why = "it follows another joint, and what it bears itself is only a part of that joint's torque";
            vec![
                out(LeftOutTopic::Effort, unlimited, "no effort limit is given", "an effort limit", false),
                out(
                    LeftOutTopic::Effort,
                    followers,
                    why,
                    "the description with followers as coordinates ([mimic=independent])",
                    false,
                ),
            ]
        }
        false => vec![
            unknown(LeftOutTopic::Effort, of(&|name, _| !is_asked(name, effort)), false),
            unknown(LeftOutTopic::Effort, of(&|name, _| is_asked(name, effort)), true),
            unknown(LeftOutTopic::Power, of(&|name, l| l.power.is_some() && !is_asked(name, power)), false),
            unknown(LeftOutTopic::Power, of(&|name, l| l.power.is_some() && is_asked(name, power)), true),
        ],
    };
    all.into_iter().filter(|out| !out.of.is_empty()).collect()
}

/// The value of each parameter of `linear` in the description; `None` if the description gives no value.
pub fn nominal_values(model: &Model, linear: &LinearModel) -> Vec<Option<f64>> {
    let base = model.nominal_parameters();
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
