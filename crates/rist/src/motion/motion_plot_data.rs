//! Plot data of an exciting motion, for a page.
//!
//! The certificate in a motion file has one proven bound per limit. A page shows it, or the result of a new proof.

use std::path::Path;

use experiments::excitation::limits::CoordinateLimits;
use identification::plot_data::motion_plot_data::KnownRobot;

pub use identification::plot_data::motion_plot_data::MotionPlotData;
pub use report::excitation::ShownMotion;

use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::checking::{Checked, check};
use crate::motion::exciting::ExcitingMotion;
use crate::motion::known_torque::KnownTorque;
use crate::request::CheckRequest;

/// The plot data of a motion from its file alone. Torques and positions of links are missing, because they need a model. `file`
/// is named in messages.
///
/// Fails if the file contains no motion.
pub fn motion_of_file(file: &Path, artefact: &ExcitingMotion) -> Result<MotionPlotData, Error> {
    Ok(MotionPlotData::of_file(artefact, &artefact.motion(&file.display().to_string())?))
}

/// The plot data of a motion, with the limits and proofs of a new check. `file` is named in messages.
///
/// Fails if the motion was made with another model or is invalid.
pub fn checked_motion(model: &Model, file: &Path, artefact: &ExcitingMotion) -> Result<MotionPlotData, Error> {
    let checked = check(model, file, artefact, &CheckRequest::default())?;
    let plot_data = drawn(model, artefact, checked.limits.clone())?;
    let Checked { certificate, notes, left_out, floor, lowest, margins, .. } = checked;
    Ok(MotionPlotData { certificate, notes, left_out, floor, lowest, margins: Some(margins), ..plot_data })
}

/// The plot data of a motion with the certificate in its file.
///
/// Fails if `found` holds no valid motion.
pub fn found_motion(model: &Model, found: &ExcitingMotion) -> Result<MotionPlotData, Error> {
    let plot_data = drawn(model, found, found.joints.iter().map(|j| j.limits.clone()).collect())?;
    Ok(plot_data.with_certificate_of(found))
}

fn drawn(model: &Model, artefact: &ExcitingMotion, limits: Vec<CoordinateLimits>) -> Result<MotionPlotData, Error> {
    let torque = KnownTorque::new(model, artefact.identified.as_ref());
    let known = KnownRobot {
        robot: &model.robot,
        regressor: model.regressor(),
        parameters: torque.parameters.as_deref(),
        friction: &torque.friction,
    };
    Ok(MotionPlotData::new(artefact, &artefact.motion("the motion")?, limits, Some(known)))
}
