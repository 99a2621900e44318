//! Makes the files of a package.
//!
//! A package is a folder that runs an identified model on a robot. Input: a model, the values of an estimate and the options of
//! its logs (units, gains and signs of the drives). Output: the texts of the files.

use rist::describe::source::IdentifiedValues;
use rist::{Error, Estimate, Model};
use robot::CoordinateId;

use crate::drive_units::DriveUnits;
use crate::parts::{PackageFile, PackageParts};
use crate::request::{PackageRequest, PackageTarget};
use crate::{arduino, lerobot, ros2_control};

/// The files that run the model of an estimate on a robot. `values`: the values of the estimate. `made_by`: the command that the
/// heads of the files name.
///
/// Fails if the request has no target, if a joint has no torque limit, if a drive has no gain, or if the robot has a floating
/// base or loops that are solved numerically.
pub fn package(
    model: &Model,
    estimate: &Estimate,
    values: &IdentifiedValues,
    request: &PackageRequest,
    made_by: &str,
) -> Result<Vec<PackageFile>, Error> {
    let target = request.target.ok_or_else(|| Error::new("[target] is missing"))?;
    let robot = &model.robot;
    if robot.massless > 0 || !robot.passive.is_empty() {
        let what = if robot.massless > 0 { "a base that floats" } else { "passive joints that are solved numerically" };
        return Err(Error::new(format_args!(
            "{}: a package is for arms on a fixed base, and this robot has {what}; [language=c] writes the functions alone",
            robot.name
        )));
    }
    let drives = DriveUnits::of(model, estimate, &request.options.clone().unwrap_or_default())?;
    let limits = limits(model, &drives.is_driven)?;
    let prefix = modeling::module(robot, &[]).map_err(Error::new)?.name;
    let parts = PackageParts { model, values, drives, limits, made_by, prefix };
    match target {
        PackageTarget::Ros2Control => ros2_control::files(&parts),
        PackageTarget::Lerobot => lerobot::files(&parts),
        PackageTarget::Arduino => arduino::files(&parts),
    }
}

/// The torque limits of the description. Fails if a joint with a drive has none.
fn limits(model: &Model, is_driven: &[bool]) -> Result<Vec<f64>, Error> {
    let limit = |(k, is_driven): (usize, &bool)| {
        let coordinate = &model.robot.coordinates[k];
        match coordinate.limits.effort.filter(|effort| *effort > 0.0 && effort.is_finite()) {
            _ if !is_driven => Ok(0.0),
            Some(effort) => Ok(effort),
            None => Err(Error::new(format_args!(
                "{}: the joint {} has no torque limit, and a package needs one of each: in a URDF write \
                 `<limit effort=\"..\"/>`, in YAML `limits: {{effort: ..}}` at the joint, in N m (N)",
                model.path.display(),
                model.robot.coordinate_name(CoordinateId(k))
            ))),
        }
    };
    is_driven.iter().enumerate().map(limit).collect()
}
