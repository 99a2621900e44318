//! `rist identify`: a log and a model -> parameters.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use identification::{
    ColumnNames, Estimate, FrictionTerm, JointDynamics, Log, Options, SpectralMethod, Weights, bodies,
    coordinate_label, identify_consistent, write_back,
};
use robot::{Coordinate, LinkId, Robot};

use crate::failure::{Failure, print, write_file};
use crate::identify_spectrum::Scale;
use crate::model::{Derived, ModelArguments, body_links, references, standard_map};

/// Identify a robot's base parameters and friction from a log
///
/// The log is CSV (also .csv.gz) with a header: the time t, positions, torques and, where measured,
/// velocities of every coordinate, found by their names (q1 or q_<coordinate>, dq.., tau..).
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelArguments,

    /// The log; with --plan the directory of its logs, one an experiment: e01.csv, ..
    log: PathBuf,

    /// ls: least squares on filtered samples; of the experiments of a plan, rist: the paper's rows of Sp; rist-mh:
    /// all their harmonics, with friction
    #[arg(long, value_enum, default_value_t = Method::Ls)]
    method: Method,

    /// The plan behind the logs, for rist and rist-mh
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,

    /// Torque per unit of current of a drive, N m/A, for rist and rist-mh [default: as the file says, with --load none];
    /// of some drives only: the others are estimated
    #[arg(long, value_name = "COORDINATE=GAIN", value_delimiter = ',')]
    gain: Vec<String>,

    /// A known load, for rist and rist-mh: YAML with link, mass (kg), centre_of_mass (m) and inertia about it (kg m^2).
    /// The logs of experiments done again with it, e01_loaded.csv, .., stand beside the others; no gain need be known
    #[arg(long, value_name = "FILE")]
    load: Option<PathBuf>,

    /// Cut-off of the zero-phase low-pass, Hz [default: by the frequency content of the log]
    #[arg(long, value_name = "HZ")]
    cutoff: Option<f64>,

    /// Order of the Butterworth filter, 0 for none [default: 4]
    #[arg(long)]
    order: Option<usize>,

    /// Keep every N-th filtered sample [default: by the cut-off]
    #[arg(long, value_name = "N")]
    decimate: Option<usize>,

    /// Friction columns a joint: viscous, coulomb, offset, asymmetric, load, rotor, smooth-coulomb=V,
    /// stribeck=V (V in rad/s), or none [default: viscous,coulomb,offset]
    #[arg(long, value_delimiter = ',', value_name = "TERMS", value_parser = friction_term)]
    friction: Option<Vec<Option<FrictionTerm>>>,

    /// YAML with any option of an identification; flags override it
    #[arg(long, value_name = "FILE")]
    options: Option<PathBuf>,

    /// Ordinary instead of weighted least squares
    #[arg(long)]
    ols: bool,

    /// Only bodies that can exist: physically consistent parameters, held where the log is silent by the
    /// description's own bodies
    #[arg(long)]
    consistent: bool,

    /// Write the URDF with the identified inertials, joint damping and friction; implies --consistent
    #[arg(long, value_name = "FILE")]
    write_urdf: Option<PathBuf>,

    /// Write the estimate as YAML
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    Ls,
    Rist,
    RistMh,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let spectral = match arguments.method {
        Method::Ls => None,
        Method::Rist => Some(SpectralMethod::Paper),
        Method::RistMh => Some(SpectralMethod::Harmonic),
    };
    match (spectral, &arguments.plan) {
        (None, None) if arguments.load.is_some() => Err(Failure::new("--load is for --method rist and rist-mh")),
        (None, None) => identify_samples(arguments),
        (Some(method), Some(plan)) => {
            let names = match &arguments.options {
                Some(path) => Options::read(path)?.columns,
                None => ColumnNames::default(),
            };
            let scale = Scale { gain: &arguments.gain, load: arguments.load.as_deref() };
            let (model, out) = (&arguments.model, arguments.out.as_deref());
            crate::identify_spectrum::run(model, &arguments.log, plan, method, &scale, &names, out)
        }
        (None, Some(_)) => Err(Failure::new("--plan is for --method rist and rist-mh")),
        (Some(_), None) => {
            Err(Failure::new("--method rist and rist-mh need the plan behind the logs: --plan plan.yaml"))
        }
    }
}

fn identify_samples(arguments: &Arguments) -> Result<(), Failure> {
    let robot = arguments.model.read_with_values()?;
    let mut derived = Derived::new(&robot, &arguments.model.model)?;
    let regressor = derived.regressor(&robot);

    let mut options = match &arguments.options {
        Some(path) => Options::read(path)?,
        None => Options::default(),
    };
    options.model = robot.name.clone();
    let signal = &mut options.signal;
    signal.cutoff = arguments.cutoff.or(signal.cutoff);
    signal.order = arguments.order.unwrap_or(signal.order);
    signal.decimate = arguments.decimate.or(signal.decimate);
    if arguments.ols {
        options.weights = Weights::None;
    }
    if let Some(terms) = &arguments.friction {
        options.friction = terms.iter().copied().flatten().collect();
    }

    let (log, columns) = Log::read(&arguments.log, regressor.coordinates(), &options.columns)?;
    let estimate = if arguments.consistent || arguments.write_urdf.is_some() {
        let map = standard_map(&robot, &derived.parameters);
        let known = references(&robot, &derived.parameters);
        let logs = std::slice::from_ref(&log);
        let fit = identify_consistent(regressor.as_ref(), &map, &known, logs, &options, &Default::default())?;
        if let Some(out) = &arguments.write_urdf {
            let ids = body_links(&derived.parameters);
            let bodies: Vec<_> = ids.into_iter().zip(bodies(&map, &fit.consistent.phi).map(|b| b.1)).collect();
            write_urdf(arguments, &robot, &bodies, &fit.estimate, out)?;
        }
        fit.estimate
    } else {
        identification::identify(regressor.as_ref(), &log, &options)?
    };
    print(&format!("{columns}\n{}\n{estimate}", log.report))?;
    match &arguments.out {
        Some(out) => write_file(out, &estimate.to_yaml()?),
        None => Ok(()),
    }
}

/// The URDF of the model with the identified bodies, and friction where all of it is there.
fn write_urdf(
    arguments: &Arguments,
    robot: &Robot,
    bodies: &[(LinkId, [f64; 10])],
    estimate: &Estimate,
    out: &Path,
) -> Result<(), Failure> {
    let path = &arguments.model.model;
    let text = std::fs::read_to_string(path).map_err(|e| Failure::new(format_args!("{}: {e}", path.display())))?;
    let friction = |coordinate: &Coordinate| {
        let label = coordinate_label(&coordinate.name);
        let value = |letters: &str| estimate.value(&format!("{letters}{label}"));
        // Simulators refuse friction that drives.
        let (damping, friction) = (value("FV")?.max(0.0), value("FS")?.max(0.0));
        Some(JointDynamics { joint: coordinate.name.clone(), damping, friction })
    };
    let dynamics: Vec<JointDynamics> = robot.coordinates.iter().filter_map(friction).collect();
    let written = write_back(&text, &path.display().to_string(), robot, bodies, &dynamics)?;
    for note in &written.notes {
        eprintln!("note: {note}");
    }
    write_file(out, &written.text)
}

/// `viscous`, `stribeck=0.1`; `none` is no term.
fn friction_term(text: &str) -> Result<Option<FrictionTerm>, String> {
    let (name, speed) = match text.split_once('=') {
        Some((name, speed)) => (name, Some(speed)),
        None => (text, None),
    };
    let speed = match speed.map(str::parse::<f64>) {
        None => None,
        Some(Ok(v)) if v.is_finite() && v > 0.0 => Some(v),
        Some(_) => return Err(format!("the speed of `{name}` must be a positive number of rad/s")),
    };
    match (name, speed) {
        ("none", None) => Ok(None),
        ("viscous", None) => Ok(Some(FrictionTerm::Viscous)),
        ("coulomb", None) => Ok(Some(FrictionTerm::Coulomb)),
        ("offset", None) => Ok(Some(FrictionTerm::Offset)),
        ("asymmetric", None) => Ok(Some(FrictionTerm::Asymmetric)),
        ("load", None) => Ok(Some(FrictionTerm::Load)),
        ("rotor", None) => Ok(Some(FrictionTerm::Rotor)),
        ("smooth-coulomb", Some(v)) => Ok(Some(FrictionTerm::SmoothCoulomb(v))),
        ("stribeck", Some(v)) => Ok(Some(FrictionTerm::Stribeck(v))),
        ("smooth-coulomb" | "stribeck", None) => Err(format!("`{name}` needs its speed in rad/s: `{name}=0.1`")),
        _ => Err(format!(
            "there is no friction term `{text}`; there are viscous, coulomb, offset, asymmetric, load, rotor, \
             smooth-coulomb=V, stribeck=V and none"
        )),
    }
}
