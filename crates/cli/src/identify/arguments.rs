//! The arguments of `rist identify`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use identification::estimators::weighted::Weights;
use identification::signals::signal_options::possible_delay;
use linear_model::friction::terms::FrictionTerm;
use rist::request::harmonic_request::{Delay, Whose};

use crate::model::ModelArguments;

/// Headings of the help.
const METHOD: &str = "Method";
const SIGNALS: &str = "Signals";
const BODIES: &str = "Bodies and loads";
const OUTPUTS: &str = "Outputs";

const EXAMPLES: &str = "\
Examples:
  rist identify robot.urdf log.csv --rotor-inertia actuated --out estimate.yaml --report page.html
      identify a robot from a log, with the inertias of its motors
  rist identify robot.urdf a.csv b.csv --validate c.csv --friction auto --delay auto
      fit two logs, choose the friction model and the delay of the torques, and predict a third log
  rist identify robot.urdf log.mcap --gain elbow=11.5,wrist=7+-2 --consistent --write-urdf identified.urdf
      identify bodies that can exist from motor currents, and write the description with them
  rist identify robot.yaml logs --plan plan.yaml --method rist-mh --gain q3=1
      identify from the experiments of a plan";

/// Identify a robot's base parameters and friction from logs
///
/// A log is CSV (also .csv.gz) with a header, .npz, Parquet, or the joint states of an MCAP file or a rosbag2
/// directory. It holds the time t and, for every coordinate, positions, torques or currents, and velocities where they
/// were measured. Columns are found by their names (q1 or q_<coordinate>, dq.., tau.., i..).
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    pub model: ModelArguments,

    /// The logs, fitted together; log.mcap#/topic names one of several topics of a recording. With --plan: the directory
    /// of its logs, one an experiment: e01.csv, ..
    #[arg(required = true, value_name = "LOG")]
    pub logs: Vec<PathBuf>,

    /// The equations to solve; all but ls and essential need the plan behind the logs
    #[arg(long, value_enum, default_value_t = Method::Ls, help_heading = METHOD)]
    pub method: Method,

    /// The plan behind the logs, for rist, rist-mh, iv and didim
    #[arg(long, value_name = "FILE", help_heading = METHOD)]
    pub plan: Option<PathBuf>,

    /// Torque per unit of current of a drive, N m/A [default: as the file says; with --load, none]. Where only some
    /// drives are given, the others are estimated. With ls, q5=11+-2 expects a gain near 11
    #[arg(long, value_name = "COORDINATE=GAIN", value_delimiter = ',', help_heading = METHOD)]
    pub gain: Vec<String>,

    /// Predict this log, which is not fitted; may be given several times
    #[arg(long, value_name = "LOG", help_heading = OUTPUTS)]
    pub validate: Vec<PathBuf>,

    /// A known load, for rist and rist-mh: YAML with link, mass (kg), centre_of_mass (m) and inertia about it (kg m^2).
    /// The logs of the experiments repeated with it, e01_loaded.csv, .., stand beside the others; no gain need be known
    #[arg(long, value_name = "FILE", help_heading = METHOD)]
    pub load: Option<PathBuf>,

    /// Cut-off of the zero-phase low-pass, Hz [default: by the frequency content of the logs]; rist-mh: highest frequency
    /// of its equations [default: 20]
    #[arg(long, value_name = "HZ", help_heading = SIGNALS)]
    pub cutoff: Option<f64>,

    /// Order of the Butterworth filter, 0 for none [default: 4]
    #[arg(long, help_heading = SIGNALS)]
    pub order: Option<usize>,

    /// Keep every N-th filtered sample [default: by the cut-off]
    #[arg(long, value_name = "N", value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..), help_heading = SIGNALS)]
    pub decimate: Option<usize>,

    /// Seconds by which the torques lag the positions, or auto, the delay with the smallest residual [default: 0];
    /// rist-mh: auto estimates the remaining delay with the parameters
    #[arg(long, value_name = "SECONDS", value_parser = delay, help_heading = SIGNALS)]
    pub delay: Option<Delay>,

    /// rist-mh: estimate ripple of torque and gain with so many periods a turn, of a coordinate or of all
    #[arg(long, value_name = "[COORDINATE=]PERIODS", value_delimiter = ',', value_parser = ripple, help_heading = METHOD)]
    pub ripple: Vec<(Whose, f64)>,

    /// rist-mh: estimate the springs of these coordinates, or of all; the encoders are at the motors. Its equations end at
    /// 10 Hz then, unless --cutoff says otherwise
    #[arg(long, value_name = "COORDINATE|all", value_delimiter = ',', value_parser = whose, help_heading = METHOD)]
    pub elastic: Vec<Whose>,

    /// rist-mh: the same for the play of these joints, or of all
    #[arg(long, value_name = "COORDINATE|all", value_delimiter = ',', value_parser = whose, help_heading = METHOD)]
    pub play: Vec<Whose>,

    /// Friction columns per joint: viscous, coulomb, offset, asymmetric, load, rotor, smooth-coulomb=V, stribeck=V (V
    /// in rad/s), none, or auto, the set that best predicts parts of the logs left out of the fit [default:
    /// viscous,coulomb,offset]
    #[arg(long, value_delimiter = ',', value_name = "TERMS", value_parser = friction, help_heading = METHOD)]
    pub friction: Option<Vec<Friction>>,

    /// What rows weigh [default: joint]
    #[arg(long, value_parser = weights(), help_heading = METHOD)]
    pub weights: Option<Weights>,

    /// YAML with any option of an identification; flags override it
    #[arg(long, value_name = "FILE", help_heading = METHOD)]
    pub options: Option<PathBuf>,

    /// Physically consistent parameters: only bodies that can exist. Where the log says nothing, they stay near the
    /// bodies of the description
    #[arg(long, help_heading = BODIES)]
    pub consistent: bool,

    /// Also identify the load that the last link carries in this log; may be given several times
    #[arg(long, value_name = "LOG", help_heading = BODIES)]
    pub loaded: Vec<PathBuf>,

    /// The link that carries the load [default: the last]
    #[arg(long, value_name = "LINK", requires = "loaded", help_heading = BODIES)]
    pub loaded_link: Option<String>,

    /// Write the URDF with the identified inertials, joint damping and friction; implies --consistent
    #[arg(long, value_name = "FILE", help_heading = OUTPUTS)]
    pub write_urdf: Option<PathBuf>,

    /// Write a MuJoCo model with the identified inertials, joint damping, friction loss and armature, without shapes;
    /// implies --consistent
    #[arg(long, value_name = "FILE", help_heading = OUTPUTS)]
    pub write_mjcf: Option<PathBuf>,

    /// The MuJoCo model whose inertials and joints --write-mjcf replaces, with its shapes and all the rest
    #[arg(long, value_name = "MODEL.xml", requires = "write_mjcf", help_heading = OUTPUTS)]
    pub into: Option<PathBuf>,

    /// Write the URDF and the MuJoCo model even where the verdict is no
    #[arg(long, help_heading = OUTPUTS)]
    pub anyway: bool,

    /// Write the estimate as YAML
    #[arg(long, value_name = "FILE", help_heading = OUTPUTS)]
    pub out: Option<PathBuf>,

    /// Write a page with verdict, torques, residuals, friction and parameters as HTML
    #[arg(long, value_name = "FILE", help_heading = OUTPUTS)]
    pub report: Option<PathBuf>,

    /// The date on that page, in any form
    #[arg(long, requires = "report", help_heading = OUTPUTS)]
    pub date: Option<String>,

    /// Write measured and predicted torques, filtered as they were fitted, as CSV, or as Parquet (FILE.parquet)
    #[arg(long, value_name = "FILE", help_heading = OUTPUTS)]
    pub series: Option<PathBuf>,
}

/// The equations to solve.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Least squares on filtered samples
    Ls,
    /// Least squares with the parameters that the data need; the others are zero
    Essential,
    /// The paper's equations, rows of the operator Sp
    Rist,
    /// All harmonics, with friction
    RistMh,
    /// Instrumental variables: the experiments, simulated in closed loop, are the instruments of the samples
    Iv,
    /// Direct and inverse dynamics: only torques are fitted, to the experiments simulated in closed loop
    Didim,
}

/// A word of --friction.
#[derive(Clone, Copy, PartialEq)]
pub enum Friction {
    Auto,
    None,
    Term(FrictionTerm),
}

fn delay(text: &str) -> Result<Delay, String> {
    match (text, text.parse::<f64>()) {
        ("auto", _) => Ok(Delay::Auto),
        (_, Ok(seconds)) => possible_delay(seconds).map(Delay::Seconds),
        _ => Err("expected auto, or seconds".into()),
    }
}

/// `q2`, or `all`.
fn whose(text: &str) -> Result<Whose, String> {
    Ok(if text == "all" { Whose::All } else { Whose::Coordinate(text.into()) })
}

/// `q2=12`, or `12` for all.
fn ripple(text: &str) -> Result<(Whose, f64), String> {
    let (name, number) = text.split_once('=').unwrap_or(("all", text));
    let periods = number.parse().map_err(|_| format!("`{number}` is no number of periods a turn"))?;
    Ok((whose(name)?, periods))
}

/// Those of the library, with what they do in the help.
fn weights() -> impl TypedValueParser<Value = Weights> {
    let words = Weights::ALL.map(|w| PossibleValue::new(w.word()).help(w.help()));
    PossibleValuesParser::new(words).try_map(|word| Weights::of_word(&word).ok_or("no such weights"))
}

/// `viscous`, `stribeck=0.1`, `none`, `auto`.
pub fn friction(text: &str) -> Result<Friction, String> {
    match text {
        "auto" => Ok(Friction::Auto),
        "none" => Ok(Friction::None),
        _ => FrictionTerm::of_word(text).map(Friction::Term),
    }
}

/// A flag that not all methods use, and whether it was given.
type Given = (&'static str, bool);

/// Flags of least squares on samples.
const OF_SAMPLES: [&str; 10] = [
    "--cutoff",
    "--delay",
    "--validate",
    "--order",
    "--decimate",
    "--friction",
    "--weights",
    "--loaded",
    "--report",
    "--series",
];

/// Flags of bodies that can exist. A body needs all of its parameters, and --method essential leaves some out.
const OF_BODIES: [&str; 4] = ["--consistent", "--write-urdf", "--write-mjcf", "--anyway"];

impl Method {
    /// Whether this method uses a flag that not all do.
    fn uses(self, flag: &str) -> bool {
        let own: &[&str] = match self {
            Method::Ls | Method::Essential => &OF_SAMPLES,
            Method::Rist => &["--plan", "--load"],
            Method::RistMh => &["--plan", "--load", "--cutoff", "--delay", "--ripple", "--elastic", "--play"],
            Method::Iv | Method::Didim => &["--plan", "--cutoff", "--order", "--decimate", "--delay"],
        };
        own.contains(&flag) || self == Method::Ls && OF_BODIES.contains(&flag)
    }

    /// The word of --method.
    pub fn word(self) -> String {
        self.to_possible_value().map_or(String::new(), |value| value.get_name().to_string())
    }
}

impl Arguments {
    /// The flags that were given and that this method does not use, each with the methods that do.
    pub fn unused(&self) -> Vec<(&'static str, Vec<String>)> {
        let users = |flag: &str| -> Vec<String> {
            Method::value_variants().iter().filter(|method| method.uses(flag)).map(|m| m.word()).collect()
        };
        let given = self.given().into_iter().filter(|(flag, is_given)| *is_given && !self.method.uses(flag));
        given.map(|(flag, _)| (flag, users(flag))).collect()
    }

    /// Flags that all methods use are not here: --method, --gain, --options, --out and those of the model.
    fn given(&self) -> [Given; 19] {
        [
            ("--plan", self.plan.is_some()),
            ("--load", self.load.is_some()),
            ("--cutoff", self.cutoff.is_some()),
            ("--delay", self.delay.is_some()),
            ("--ripple", !self.ripple.is_empty()),
            ("--elastic", !self.elastic.is_empty()),
            ("--play", !self.play.is_empty()),
            ("--validate", !self.validate.is_empty()),
            ("--order", self.order.is_some()),
            ("--decimate", self.decimate.is_some()),
            ("--friction", self.friction.is_some()),
            ("--weights", self.weights.is_some()),
            ("--consistent", self.consistent),
            ("--loaded", !self.loaded.is_empty()),
            ("--write-urdf", self.write_urdf.is_some()),
            ("--write-mjcf", self.write_mjcf.is_some()),
            ("--anyway", self.anyway),
            ("--report", self.report.is_some()),
            ("--series", self.series.is_some()),
        ]
    }
}
