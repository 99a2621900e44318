//! Unknown mechanical properties that a description may lack: rotor inertias of the joints, and a tilt of the base.
//!
//! The fit tests whether such a property explains the residual.

use identification::estimate::claims::hypotheses::{Tilt as TiltTorque, UndeterminedMechanics};
use linear_model::description_options::RotorInertias;
use robot::value::CoordinateId;
use robot::{Format, RotorInertia};

use crate::describe::description::set_rotor_inertias;
use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::mount::Tilt;

/// Whether rotor inertias may be missing in the description: a URDF cannot contain rotor inertias, and in an MJCF they are
/// optional. False if the options decide about rotor inertias.
pub(crate) fn may_lack_rotors(model: &Model) -> bool {
    let may_say_none = model.robot.format != Format::Complete;
    let is_decided = model.description.as_ref().is_some_and(|d| d.rotor_inertia.is_some());
    let lacks = model.robot.links.iter().all(|link| link.joint.rotor_inertia == RotorInertia::Absent);
    may_say_none && !is_decided && lacks
}

/// Part of a sentence: why the model lacks rotor inertias.
pub(crate) fn lack(model: &Model) -> &'static str {
    if model.robot.format == Format::Urdf { "a URDF cannot say" } else { "the description does not give" }
}

/// The model with rotor inertias added to its actuated joints.
pub(crate) fn rotating(model: &Model) -> Result<Model, Error> {
    model.changed(
        |robot| set_rotor_inertias(robot, RotorInertias::Actuated),
        |description| description.rotor_inertia = Some(RotorInertias::Actuated),
    )
}

/// Calls `look` with properties that the description may lack: the torques per radian of a tilt of the base, and the
/// coordinates whose rotor inertia may be missing.
///
/// `fitted`: identified base parameters. The torques of a tilt are computed with bodies that have these base parameters: the
/// standard parameter of each column is changed, and all other standard parameters stay.
pub fn with_undetermined<T>(model: &Model, fitted: Option<&[f64]>, look: impl FnOnce(UndeterminedMechanics) -> T) -> T {
    let (of, described) = (&model.parameters, model.nominal_parameters().unwrap_or_default());
    let brought = of.base.iter().zip(fitted.unwrap_or_default().iter().zip(&described));
    let changes: Vec<_> = brought.map(|(base, (x, described))| (of.standard[base.column], x - described)).collect();
    let tilts = Tilt::both(&model.robot, &changes);
    let torques: Vec<_> = tilts.iter().map(|(axis, tilt)| (*axis, |q: &[f64]| tilt.torques(q))).collect();
    let torques: Vec<(usize, TiltTorque)> =
        torques.iter().map(|(axis, torque)| (*axis, torque as TiltTorque)).collect();
    look(UndeterminedMechanics { tilts: &torques, rotors: &undetermined_rotors(model), drives: &[], play: &[] })
}

/// The coordinates whose motor may have a rotor inertia that the description lacks.
fn undetermined_rotors(model: &Model) -> Vec<usize> {
    let is_actuated = |k: &usize| model.robot.joint_of(CoordinateId(*k)).is_some();
    let count = if may_lack_rotors(model) { model.robot.n_coordinates() } else { 0 };
    (0..count).filter(is_actuated).collect()
}
