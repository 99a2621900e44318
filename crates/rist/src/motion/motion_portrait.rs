//! The data that a page draws of an exciting motion.

use std::path::Path;

use experiments::excitation::limits::CoordinateLimits;
use identification::portrait::motion_portrait::KnownRobot;

pub use identification::portrait::motion_portrait::MotionPortrait;
pub use report::excitation::ShownMotion;

use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::checking::{Checked, check};
use crate::motion::exciting::ExcitingMotion;
use crate::motion::known_torque::KnownTorque;
use crate::request::CheckRequest;

/// The motion according to its file alone. It lacks torques and positions of links, which need a model. `file` stands
/// in messages.
///
/// Fails where the file is of no motion.
pub fn motion_of_file(file: &Path, artefact: &ExcitingMotion) -> Result<MotionPortrait, Error> {
    Ok(MotionPortrait::of_file(artefact, &artefact.motion(&file.display().to_string())?))
}

/// The motion within the limits that a check of it finds and proves anew. `file` stands in messages.
///
/// Fails where the motion was made with another model or is invalid.
pub fn checked_motion(model: &Model, file: &Path, artefact: &ExcitingMotion) -> Result<MotionPortrait, Error> {
    let checked = check(model, file, artefact, &CheckRequest::default())?;
    let portrait = drawn(model, artefact, checked.limits.clone())?;
    let Checked { certificate, notes, left_out, floor, lowest, margins, .. } = checked;
    Ok(MotionPortrait { certificate, notes, left_out, floor, lowest, margins: Some(margins), ..portrait })
}

/// A motion that was found just now, with the certificate that it has.
///
/// Fails where it is none.
pub fn found_motion(model: &Model, found: &ExcitingMotion) -> Result<MotionPortrait, Error> {
    let portrait = drawn(model, found, found.joints.iter().map(|j| j.limits.clone()).collect())?;
    Ok(portrait.with_certificate_of(found))
}

fn drawn(model: &Model, artefact: &ExcitingMotion, limits: Vec<CoordinateLimits>) -> Result<MotionPortrait, Error> {
    let torque = KnownTorque::new(model, artefact.identified.as_ref());
    let known = KnownRobot {
        robot: &model.robot,
        regressor: model.regressor(),
        parameters: torque.parameters.as_deref(),
        friction: &torque.friction,
    };
    Ok(MotionPortrait::new(artefact, &artefact.motion("the motion")?, limits, Some(known)))
}
