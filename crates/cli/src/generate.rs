//! `rist generate`: a robot's functions as source for a project of the user's own.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use expr::Module;
use modeling::RobotFunction;
use robot::{LinkId, Robot};

use crate::failure::{Failure, print, write_file};
use crate::model::ModelArguments;

/// Write a robot's base regressor, and other functions of it, as source that needs no other file
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// Functions beside base-regressor: regressor, power-regressor, energy, inverse-dynamics,
    /// inertia-matrix, bias, gravity, forward-dynamics, friction, pose=LINK, jacobian=LINK, external-torque=LINK
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    functions: Vec<String>,

    /// Language to write
    #[arg(long, value_enum, default_value_t = Language::Rust)]
    language: Language,

    /// File to write [default: standard output]; C makes FILE.c and FILE.h
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Language {
    /// One file, no_std, generic over f64, f32 and numbers of your own
    Rust,
    /// C99: a header and a source file that need math.h
    C,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = arguments.model.model.display().to_string();
    let robot = arguments.model.read_with_values()?;
    let functions: Vec<RobotFunction> =
        arguments.functions.iter().map(|name| robot_function(&robot, name)).collect::<Result<_, _>>()?;
    let module =
        modeling::module(&robot, &functions).map_err(|unclear| Failure::new(format_args!("{path}: {unclear}")))?;
    let mut made_by = format!("rist generate {path}");
    if !arguments.functions.is_empty() {
        made_by += &format!(" --functions {}", arguments.functions.join(","));
    }
    match (arguments.language, &arguments.out) {
        (Language::Rust, None) => return print(&codegen::rust_file(&module, &made_by)),
        (Language::Rust, Some(out)) => write_file(out, &codegen::rust_file(&module, &made_by))?,
        (Language::C, None) => {
            return Err(Failure::new("C makes a header and a source file: say where with `--out FILE.c`"));
        }
        (Language::C, Some(out)) => write_c(&module, &format!("{made_by} --language c"), out)?,
    }
    for f in &module.functions {
        let (name, c) = (&f.function.name, f.function.bound().count());
        eprintln!("{name}: {} mul, {} add, {} sin_cos a call", c.mul, c.add, c.sin_cos);
    }
    Ok(())
}

fn write_c(module: &Module, made_by: &str, out: &Path) -> Result<(), Failure> {
    let (header, source) = (out.with_extension("h"), out.with_extension("c"));
    let name = header.file_name().unwrap_or_default().to_string_lossy();
    let files = codegen::c_files(module, made_by, &name);
    write_file(&header, &files.header)?;
    write_file(&source, &files.source)
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
        ("friction", None) => Ok(Friction),
        ("pose", _) => of_link(Pose),
        ("jacobian", _) => of_link(Jacobian),
        ("external-torque", _) => of_link(ExternalTorque),
        _ => Err(Failure::new(format_args!(
            "there is no function `{text}`; there are base-regressor, regressor, power-regressor, energy, \
             inverse-dynamics, inertia-matrix, bias, gravity, forward-dynamics, friction, pose=LINK, jacobian=LINK and \
             external-torque=LINK"
        ))),
    }
}
