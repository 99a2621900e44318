//! What a description does not say: the rotors behind its joints, and how far its base is tilted.

use identification::estimate::ledger::hypotheses::{Open, Tilt as TiltTorque};
use linear_model::description_options::RotorInertias;
use robot::value::CoordinateId;
use robot::{Format, RotorInertia};

use crate::describe::description::set_rotor_inertias;
use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::mount::Tilt;

/// Whether rotor inertias are to be asked for: the model is of a URDF, which cannot say them, or of an MJCF, which does not
/// need to, and nobody decided.
pub(crate) fn may_lack_rotors(model: &Model) -> bool {
    let may_say_none = model.robot.format != Format::Complete;
    let is_pinned = model.description.as_ref().is_some_and(|d| d.rotor_inertia.is_some());
    let lacks = model.robot.links.iter().all(|link| link.joint.rotor_inertia == RotorInertia::Absent);
    may_say_none && !is_pinned && lacks
}

/// Why a model lacks rotor inertias.
pub(crate) fn lack(model: &Model) -> &'static str {
    if model.robot.format == Format::Urdf { "a URDF cannot say" } else { "the description does not give" }
}

/// The model with rotor inertias of its actuated joints.
pub(crate) fn rotating(model: &Model) -> Result<Model, Error> {
    model.changed(
        |robot| set_rotor_inertias(robot, RotorInertias::Actuated),
        |description| description.rotor_inertia = Some(RotorInertias::Actuated),
    )
}

/// With the torques by which a tilt of the mount shows, and the rotors of which nobody spoke.
///
/// `fitted`: base parameters, to which the described bodies are brought by the column that each has its name from.
pub fn with_open<T>(model: &Model, fitted: Option<&[f64]>, look: impl FnOnce(Open) -> T) -> T {
    let (of, described) = (&model.parameters, model.described_parameters().unwrap_or_default());
    let brought = of.base.iter().zip(fitted.unwrap_or_default().iter().zip(&described));
    let changes: Vec<_> = brought.map(|(base, (x, described))| (of.standard[base.column], x - described)).collect();
    let tilts = Tilt::both(&model.robot, &changes);
    let torques: Vec<_> = tilts.iter().map(|(axis, tilt)| (*axis, |q: &[f64]| tilt.torques(q))).collect();
    let torques: Vec<(usize, TiltTorque)> =
        torques.iter().map(|(axis, torque)| (*axis, torque as TiltTorque)).collect();
    look(Open { tilts: &torques, rotors: &open_rotors(model) })
}

/// The coordinates whose motor may have a rotor of which nobody spoke.
fn open_rotors(model: &Model) -> Vec<usize> {
    let is_actuated = |k: &usize| model.robot.joint_of(CoordinateId(*k)).is_some();
    let count = if may_lack_rotors(model) { model.robot.n_coordinates() } else { 0 };
    (0..count).filter(is_actuated).collect()
}
