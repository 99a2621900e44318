//! `rist generate`: a robot's functions as one file for a project of the user's own.

use std::path::PathBuf;

use clap::Args;
use modeling::RobotFunction;
use robot::{LinkId, Robot};

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;

/// Write a robot's base regressor as one Rust file that needs no other
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Functions beside base-regressor: regressor, power-regressor, energy, inverse-dynamics,
    /// inertia-matrix, bias, gravity, forward-dynamics, pose=LINK, jacobian=LINK, external-torque=LINK
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    functions: Vec<String>,

    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = arguments.model.model.display().to_string();
    let robot = arguments.model.read()?;
    let functions: Vec<RobotFunction> =
        arguments.functions.iter().map(|name| robot_function(&robot, name)).collect::<Result<_, _>>()?;
    let module =
        modeling::module(&robot, &functions).map_err(|unclear| Failure::new(format_args!("{path}: {unclear}")))?;
    let text = codegen::rust_file(&module, &format!("rist generate {path}"));
    match &arguments.out {
        None => print(&text),
        Some(out) => {
            write_file(out, &text)?;
            for f in &module.functions {
                let (name, c) = (&f.function.name, f.function.count());
                eprintln!("{}: {name}: {} mul, {} add, {} sin_cos a call", out.display(), c.mul, c.add, c.sin_cos);
            }
            Ok(())
        }
    }
}

/// `inertia-matrix`, `pose=5`; a link is named by its name, its joint or its label.
fn robot_function(robot: &Robot, text: &str) -> Result<RobotFunction, Failure> {
    use RobotFunction::*;
    let (name, link) = match text.split_once('=') {
        Some((name, link)) => (name, Some(link)),
        None => (text, None),
    };
    let of_link = |make: fn(LinkId) -> RobotFunction| {
        let Some(wanted) = link else {
            return Err(Failure::new(format_args!("`{name}` needs its link: `{name}=LINK`")));
        };
        let is = |l: &robot::Link| l.name == wanted || l.joint.name == wanted || l.label == wanted;
        robot.links.iter().position(is).map(|j| make(LinkId(j))).ok_or_else(|| {
            let names: Vec<&str> = robot.links.iter().map(|l| l.name.as_str()).collect();
            Failure::new(format_args!("{} has no link `{wanted}`; it has {}", robot.name, names.join(", ")))
        })
    };
    match (name, link) {
        ("base-regressor", None) => Ok(BaseRegressor),
        ("regressor", None) => Ok(Regressor),
        ("power-regressor", None) => Ok(PowerRegressor),
        ("energy", None) => Ok(Energy),
        ("inverse-dynamics", None) => Ok(InverseDynamics),
        ("inertia-matrix", None) => Ok(InertiaMatrix),
        ("bias", None) => Ok(Bias),
        ("gravity", None) => Ok(Gravity),
        ("forward-dynamics", None) => Ok(ForwardDynamics),
        ("pose", _) => of_link(Pose),
        ("jacobian", _) => of_link(Jacobian),
        ("external-torque", _) => of_link(ExternalTorque),
        _ => Err(Failure::new(format_args!(
            "there is no function `{text}`; there are base-regressor, regressor, power-regressor, energy, \
             inverse-dynamics, inertia-matrix, bias, gravity, forward-dynamics, pose=LINK, jacobian=LINK and \
             external-torque=LINK"
        ))),
    }
}
