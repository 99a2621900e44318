//! Finds a function of a robot by name.
//!
//! Names are those of `rist generate`, such as `inertia-matrix`, or `pose=5:2` for the pose of link 5 in the frame of link 2.

use modeling::{LinkFrame, ReferenceFrame, RobotFunction};
use robot::Robot;

use crate::error::Error;
use crate::request::function_names;

/// The function with the name `text`: `inertia-matrix`, `pose=5`. A link is given by its name, its joint or its label; a link
/// of a URDF that is fixed to a moving link is allowed. Results are in the frame that the file gives the link, unless a frame
/// is named: `jacobian=5:base` is in the frame of the base, `pose=5:2` in the frame of link 2.
///
/// Fails with the list of names if the function or the link is unknown.
pub fn function_named(robot: &Robot, text: &str) -> Result<RobotFunction, Error> {
    let (name, link) = text.split_once('=').map_or((text, None), |(name, link)| (name, Some(link)));
    let checked = |function: RobotFunction| match function.check(robot) {
        Ok(()) => Ok(function),
        Err(e) => Err(Error::new(format_args!("`{text}`: {}: {e}", robot.name))),
    };
    if let Some(function) = RobotFunction::of_robot(name).filter(|_| link.is_none()) {
        return checked(function);
    }
    let Some(make) = RobotFunction::of_link(name) else {
        return Err(Error::new(format_args!("there is no function `{text}`; there are {}", function_names())));
    };
    let Some(wanted) = link else {
        return Err(Error::new(format_args!("`{name}` needs its link: `{name}=LINK`")));
    };
    let absent = |wanted: &str| {
        let names = LinkFrame::names(robot).join(", ");
        Error::new(format_args!("{} has no moving link `{wanted}`; it has {names}", robot.name))
    };
    if let Some(frame) = LinkFrame::named(robot, wanted) {
        return checked(make(frame));
    }
    let Some((link, reference)) = wanted.rsplit_once(':') else { return Err(absent(wanted)) };
    let frame = LinkFrame::named(robot, link).ok_or_else(|| absent(link))?;
    let reference = ReferenceFrame::named(robot, reference).ok_or_else(|| absent(reference))?;
    let function = make(frame).expressed_in(reference);
    function.ok_or_else(|| Error::new(format_args!("`{name}` is not expressed in a frame: `{name}={link}`")))
}
