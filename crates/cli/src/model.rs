//! A robot as the commands need it: read, derived, and with a base regressor to evaluate.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::{Args, ValueEnum};
use expr::{Function, Tape, Workspace};
use identification::model::regressor::Regressor;
use identification::model::standard_map::StandardMap;
use modeling::{BaseParameters, Closure, Derivation, UnclearRank};
use robot::format::{Angles, Mimic, ReadOptions};
use robot::{Drive, Inertial, LinkId, Robot, RotorInertia};

use crate::failure::Failure;

/// The model and how to read it.
#[derive(Args)]
pub struct ModelArguments {
    /// Robot description: .yaml (modified DH), .urdf or .par (SYMORO)
    pub model: PathBuf,

    /// Value of a symbol of the description, m or rad: D3=0.45 (a .par file gives its symbols none)
    #[arg(long = "value", value_name = "NAME=VALUE", value_parser = assignment)]
    values: Vec<(String, f64)>,

    /// How the mimic joints of a URDF are read: as following the joint they mimic, or as coordinates of
    /// their own
    #[arg(long, value_enum, default_value_t = MimicJoints::Constraint)]
    mimic: MimicJoints,

    /// Which joints have a rotor inertia (IA) among their parameters [default: as the file says: a YAML's
    /// actuated joints unless it says otherwise, none of a URDF's, which has no word for it]
    #[arg(long, value_name = "JOINTS")]
    rotor_inertia: Option<RotorJoints>,

    /// Let the base float: six coordinates in front (base_x, base_y, base_z, base_yaw, base_pitch,
    /// base_roll) and the base a link with parameters of its own
    #[arg(long)]
    floating_base: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum RotorJoints {
    None,
    Actuated,
    All,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum MimicJoints {
    Constraint,
    Independent,
}

impl ModelArguments {
    pub fn read(&self) -> Result<Robot, Failure> {
        self.read_angles(Angles::Meant)
    }

    /// With rounded angles taken for what they were meant to be, or as given.
    pub fn read_angles(&self, angles: Angles) -> Result<Robot, Failure> {
        let mut robot = read(&self.model, self.rotor_inertia, self.mimic, angles)?;
        for (name, value) in &self.values {
            robot
                .set_symbol(name, *value)
                .map_err(|e| Failure::new(format_args!("{}: --value {name}: {e}", self.model.display())))?;
        }
        Ok(if self.floating_base { robot.floating() } else { robot })
    }

    /// The same, refused where a symbol has no value: what is to be computed are figures.
    pub fn read_with_values(&self) -> Result<Robot, Failure> {
        let robot = self.read()?;
        let missing: Vec<&str> = robot.symbols.iter().filter(|s| s.generic).map(|s| s.name.as_str()).collect();
        match missing.first() {
            None => Ok(robot),
            Some(first) => Err(Failure::new(format_args!(
                "{}: no value for {}: figures need one (--value {first}=0.45, or `(* Value {first} = 0.45 *)` in the file)",
                self.model.display(),
                missing.join(", ")
            ))),
        }
    }
}

fn assignment(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    match value.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok((name.trim().to_string(), x)),
        _ => Err(format!("`{value}` is not a finite number")),
    }
}

fn read(path: &Path, rotors: Option<RotorJoints>, mimic: MimicJoints, angles: Angles) -> Result<Robot, Failure> {
    let mimic = match mimic {
        MimicJoints::Constraint => Mimic::Constraint,
        MimicJoints::Independent => Mimic::Independent,
    };
    let mut robot = robot::format::read_with(path, ReadOptions { mimic, angles })?;
    let Some(rotors) = rotors else { return Ok(robot) };
    for link in &mut robot.links {
        let has = match rotors {
            RotorJoints::None => false,
            RotorJoints::Actuated => link.joint.drive == Drive::Actuated,
            RotorJoints::All => link.joint.drive != Drive::Locked && link.joint.kind != robot::JointKind::Fixed,
        };
        link.joint.rotor_inertia = match (has, link.joint.rotor_inertia) {
            (false, _) => RotorInertia::Absent,
            (true, RotorInertia::Absent) => RotorInertia::Unknown,
            (true, known) => known,
        };
    }
    Ok(robot)
}

/// How the base parameters follow from the standard ones, in numbers.
pub fn standard_map(robot: &Robot, parameters: &BaseParameters) -> StandardMap {
    let (base, standard) = (&parameters.base, &parameters.standard);
    let terms: Vec<(usize, usize, f64)> = base
        .iter()
        .enumerate()
        .flat_map(|(k, b)| b.terms.iter().map(move |t| (k, t.parameter, t.coefficient)))
        .collect();
    let first = |c: &usize| standard[*c].inertial == Inertial::Xx;
    let bodies = (0..standard.len()).filter(first).map(|c| (robot.link(standard[c].link).name.clone(), c));
    StandardMap::new(
        standard.iter().map(|s| s.display(robot).to_string()).collect(),
        base.len(),
        &terms,
        bodies.collect(),
        (0..standard.len()).filter(|&c| standard[c].inertial == Inertial::Ia).collect(),
    )
}

/// The bodies that the description gives, in the order of the map.
pub fn references(robot: &Robot, parameters: &BaseParameters) -> Vec<Option<[f64; 10]>> {
    let bodies = parameters.standard.iter().filter(|s| s.inertial == Inertial::Xx);
    bodies.map(|s| robot.link(s.link).inertial).collect()
}

/// The link behind each body of the map.
pub fn body_links(parameters: &BaseParameters) -> Vec<LinkId> {
    parameters.standard.iter().filter(|s| s.inertial == Inertial::Xx).map(|s| s.link).collect()
}

/// What follows from a robot, derived once.
pub struct Derived {
    /// Regressor of the standard parameters.
    pub standard: Function,
    /// Regressor of the base parameters.
    pub base: Function,
    pub torque: Function,
    pub parameters: BaseParameters,
    /// Solves for passive joints that no affine function gives.
    pub closure: Option<Closure>,
}

impl Derived {
    /// Fails when the rank is not clear-cut.
    pub fn new(robot: &Robot, model: &Path) -> Result<Derived, Failure> {
        let refused = |unclear: UnclearRank| Failure::new(format_args!("{}: {unclear}", model.display()));
        let mut derivation = Derivation::new(robot).map_err(|e| refused(e.into()))?;
        let standard = derivation.regressor();
        let parameters = derivation.base_parameters(&standard).map_err(refused)?;
        let base = parameters.regressor(&standard).bound();
        let (torque, closure) = (derivation.torque().bound(), derivation.closure());
        Ok(Derived { standard: standard.bound(), base, torque, parameters, closure })
    }

    /// The compiled regressor where `generated` has this very one, a tape otherwise.
    pub fn regressor(&mut self, robot: &Robot) -> Box<dyn Regressor> {
        let is_prismatic = |k: usize| {
            let joint = robot.joint_of(robot::value::CoordinateId(k));
            joint.is_some_and(|j| robot.link(j).joint.kind == robot::JointKind::Prismatic)
        };
        let prismatic = (0..robot.n_coordinates()).map(is_prismatic).collect();
        Box::new(KindedRegressor { regressor: self.plain_regressor(robot), prismatic })
    }

    fn plain_regressor(&mut self, robot: &Robot) -> Box<dyn Regressor> {
        match identification::model::compiled::compiled(self.base.fingerprint()) {
            Some(compiled) => Box::new(compiled),
            None => Box::new(TapeRegressor {
                tape: Tape::new(&self.base),
                number: TAPES.fetch_add(1, Ordering::Relaxed),
                closure: self.closure.take().map(Mutex::new),
                coordinates: robot.coordinates.iter().map(|c| c.name.clone()).collect(),
                parameters: self.parameters.base.iter().map(|b| b.name.clone()).collect(),
            }),
        }
    }
}

/// A regressor that knows which coordinates are lengths.
struct KindedRegressor {
    regressor: Box<dyn Regressor>,
    prismatic: Vec<bool>,
}

impl Regressor for KindedRegressor {
    fn coordinates(&self) -> &[String] {
        self.regressor.coordinates()
    }

    fn parameters(&self) -> &[String] {
        self.regressor.parameters()
    }

    fn is_prismatic(&self, k: usize) -> bool {
        self.prismatic[k]
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        self.regressor.fill(q, dq, ddq, y);
    }

    fn fill_many(&self, states: &[f64], y: &mut [f64]) {
        self.regressor.fill_many(states, y);
    }
}

/// A base regressor evaluated by tape.
struct TapeRegressor {
    tape: Tape,
    /// Tells this tape's workspace from another's on the same thread.
    number: usize,
    /// Where loops are closed numerically, the solver.
    closure: Option<Mutex<Closure>>,
    coordinates: Vec<String>,
    parameters: Vec<String>,
}

/// Tapes made so far.
static TAPES: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Number, workspace and inputs of the tape last evaluated on this thread.
    static SCRATCH: RefCell<Option<(usize, Workspace, Vec<f64>)>> = const { RefCell::new(None) };
}

impl Regressor for TapeRegressor {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[String] {
        &self.parameters
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        let passive = match &self.closure {
            None => Vec::new(),
            Some(closure) => {
                let mut closure = closure.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
                match closure.passive(q) {
                    Ok(passive) => passive,
                    // No torque is known where the loops do not close: not a number, which is refused later.
                    Err(_) => return y.fill(f64::NAN),
                }
            }
        };
        SCRATCH.with_borrow_mut(|scratch| {
            let fresh = || (self.number, self.tape.workspace(), Vec::new());
            if scratch.as_ref().is_none_or(|s| s.0 != self.number) {
                *scratch = Some(fresh());
            }
            let (_, work, inputs) = scratch.get_or_insert_with(fresh);
            inputs.clear();
            inputs.extend(q.iter().chain(&passive).chain(dq).chain(ddq));
            self.tape.evaluate(inputs, work, y);
        });
    }
}
