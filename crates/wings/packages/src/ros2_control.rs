//! The package of ROS 2: a chainable controller of ros2_control, and a solver of inverse dynamics.
//!
//! A package is a folder that runs an identified model on a robot. A chainable controller adds its torques to the commands of
//! another controller.

use rist::Error;

use crate::names::{comment, numbers, quoted, ros_package, xml};
use crate::parts::{PackageFile, PackageParts};

/// The files of the package, each with its template.
const TEMPLATES: [(&str, &str); 8] = [
    ("src/controller.cpp", include_str!("../templates/ros2/controller.cpp")),
    ("src/solver.cpp", include_str!("../templates/ros2/solver.cpp")),
    ("CMakeLists.txt", include_str!("../templates/ros2/CMakeLists.txt")),
    ("package.xml", include_str!("../templates/ros2/package.xml")),
    ("controller_plugin.xml", include_str!("../templates/ros2/controller_plugin.xml")),
    ("solver_plugin.xml", include_str!("../templates/ros2/solver_plugin.xml")),
    ("controllers.yaml", include_str!("../templates/ros2/controllers.yaml")),
    ("README.md", include_str!("../templates/ros2/README.md")),
];

/// The files of the package. Fails if the functions of the robot cannot be derived.
pub(crate) fn files(parts: &PackageParts) -> Result<Vec<PackageFile>, Error> {
    let joints = parts.model.regressor().coordinates();
    let of_each = |x: f64| numbers(&vec![x; joints.len()], "");
    let quoted_joints: Vec<String> = joints.iter().map(|name| quoted(name)).collect();
    let more = [
        ("PACKAGE", ros_package(&parts.prefix)),
        ("ROBOT_XML", xml(&parts.model.robot.name)),
        ("JOINTS", quoted_joints.join(", ")),
        ("JOINT_LIST", comment(&joints.join(", "))),
        // Gains for a control loop with 10 rad/s and damping 1. The width is the value in
        // docs/how-to/code-for-a-control-loop.md.
        ("KP", of_each(100.0)),
        ("KD", of_each(20.0)),
        ("WIDTH", of_each(0.02)),
        ("LIMIT_NUMBERS", numbers(&parts.limits, "")),
    ];
    let mut files = parts.c_files("src/", &["inertia-matrix", "friction"])?;
    for (path, template) in TEMPLATES {
        files.push(PackageFile { path: path.into(), text: parts.filled(template, &more) });
    }
    Ok(files)
}
