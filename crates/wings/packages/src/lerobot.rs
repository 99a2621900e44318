//! The package for servo arms: one Python file with a simulated bus.
//!
//! A package is a folder that runs an identified model on a robot. The simulated bus stands for the servos, so that the file
//! can be tried without a robot.

use expr::Function;
use logs::Effort;
use modeling::RobotFunction;
use rist::Error;
use rist::describe::source::function_named;

use crate::names::{numbers, quoted};
use crate::parts::{PackageFile, PackageParts};
use crate::python::definition;

/// The files of the package. Fails if the drives take torques, or if the functions of the robot cannot be derived.
pub(crate) fn files(parts: &PackageParts) -> Result<Vec<PackageFile>, Error> {
    let (drives, robot) = (&parts.drives, &parts.model.robot);
    if drives.effort == Effort::Torque {
        return Err(Error::new(
            "[target=lerobot]: servos take currents or goals, and nothing says so: give the [options] of the identification, \
             with `columns: {current: ..}` or `columns: {goal: ..}`, and the gains of the drives",
        ));
    }
    let wanted: Vec<RobotFunction> =
        ["inverse-dynamics", "gravity"].iter().map(|name| function_named(robot, name)).collect::<Result<_, _>>()?;
    let module = modeling::module(robot, &wanted).map_err(Error::new)?;
    // The generated function as the definition of a Python function, with `doc` as its docstring.
    let python = |(name, doc): (&str, &str)| {
        let function = module.functions.iter().map(|f| &f.function).find(|f| f.name == name);
        function.map(|f: &Function| definition(&f.bound(), doc)).unwrap_or_default()
    };
    let functions = [
        ("inverse_dynamics", "Torques without friction, N m (N); x: base parameters."),
        ("gravity", "Torques that hold the joints against gravity, N m (N)."),
    ];
    // IS_GOAL: the servos take position goals, not currents. IS_WHOLE: the unit is a count of a register, so it has integers.
    let is_goal = drives.effort == Effort::PositionError;
    let quoted_joints: Vec<String> = parts.model.regressor().coordinates().iter().map(|name| quoted(name)).collect();
    let truth = |x: bool| String::from(if x { "True" } else { "False" });
    let more = [
        ("JOINTS", quoted_joints.join(", ")),
        ("X", numbers(&parts.values.base, "")),
        ("FRICTION", numbers(&parts.values.friction, "")),
        ("LIMIT_NUMBERS", numbers(&parts.limits, "")),
        ("POSITION_NUMBERS", numbers(&drives.positions, "")),
        ("VELOCITY_NUMBERS", numbers(&drives.velocities, "")),
        ("OFFSET_NUMBERS", numbers(&drives.offsets, "")),
        ("EFFORT_NUMBERS", numbers(&drives.efforts, "")),
        ("SPRING_NUMBERS", numbers(&drives.springs, "")),
        ("IS_GOAL", truth(is_goal)),
        ("GOAL_PER_POSITION", format!("{:?}", drives.effort_per_position)),
        ("IS_WHOLE", truth(["counts", "ticks", "int", "signbit"].iter().any(|word| drives.units[2].starts_with(word)))),
        ("FUNCTIONS", functions.map(python).join("\n\n")),
        ("START", numbers(&start(parts), "")),
    ];
    let file = |path: String, template: &str| PackageFile { path, text: parts.filled(template, &more) };
    Ok(vec![
        file(format!("{}.py", parts.prefix), include_str!("../templates/lerobot/arm.py")),
        file("README.md".into(), include_str!("../templates/lerobot/README.md")),
    ])
}

/// The pose from which the simulation starts, rad (m): at six tenths of the range, where gravity bends most arms.
fn start(parts: &PackageParts) -> Vec<f64> {
    let pose = |(low, high): (f64, f64)| low + 0.6 * (high - low);
    let coordinates = parts.model.robot.coordinates.iter();
    coordinates.map(|c| c.limits.position.map_or(0.5, pose)).collect()
}
