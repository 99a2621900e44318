//! The functions that a generated file may contain. For each function: the word that requests it, its comment, and its
//! derivation.

use std::sync::OnceLock;

use expr::{Function, Graph};
use robot::Robot;

use crate::base::base_parameters::BaseParameters;
use crate::base::unclear_rank::UnclearRank;
use crate::derivation::Derivation;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::reference_frame::ReferenceFrame;

/// A function of a robot that a generated file may contain.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotFunction(FunctionRow);

/// A row of one of the two tables of functions: functions of the whole robot, and functions of a link.
#[derive(Clone, Debug, PartialEq)]
enum FunctionRow {
    OfRobot(usize),
    OfLink(OfLink, Box<(LinkFrame, Option<ReferenceFrame>)>),
}

/// A row of the table of functions of a link. Two rows are equal if they have the same request word.
#[derive(Clone, Copy)]
struct OfLink(&'static FunctionOfLink);

impl PartialEq for OfLink {
    fn eq(&self, other: &OfLink) -> bool {
        self.0.word == other.0.word
    }
}

impl std::fmt::Debug for OfLink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.word)
    }
}

/// Data that is derived once for all functions of a generated file.
pub(crate) struct Derived<'a> {
    /// The regressor D of the standard parameters.
    pub standard: &'a Function,
    pub base: &'a BaseParameters,
}

/// A function of the whole robot: the word that requests it, the sentence above the function in the generated file, and the
/// derivation.
type OfRobot = (&'static str, &'static str, fn(&mut Derivation, &Derived) -> Function);

/// The table of functions of the whole robot. Every generated file contains the first function.
const FUNCTIONS_OF_ROBOT: &[OfRobot] = &[
    ("base-regressor", "Y of the base parameters.", |_, d| d.base.regressor(d.standard)),
    ("regressor", "The regressor of the standard parameters, row by row.", |_, d| d.standard.clone()),
    ("power-regressor", "dq^T D: the power per unit of each standard parameter, W.", |of, _| of.power_regressor()),
    ("energy", "Kinetic and potential energy per unit of each standard parameter, J.", |of, _| of.energy()),
    (
        "energies",
        "Kinetic and potential energy from the base parameters x, J; the potential one up to a constant.",
        |of, d| of.energies(d.base),
    ),
    ("inverse-dynamics", "The torques from the base parameters x, N m (N).", |of, d| of.inverse_dynamics(d.base)),
    ("torque", "The torques from the standard parameters x, N m (N).", |of, _| of.torque()),
    ("inertia-matrix", "The inertia matrix from the base parameters x, kg m^2.", |of, d| of.inertia_matrix(d.base)),
    ("bias", "Coriolis, centrifugal and gravity torques from the base parameters x.", |of, d| of.bias(d.base)),
    ("gravity", "Gravity torques from the base parameters x.", |of, d| of.gravity(d.base)),
    ("forward-dynamics", "The accelerations from the torques and x.", |of, d| of.forward_dynamics(d.base)),
    ("inverse-inertia-matrix", "The inverse of the inertia matrix from the base parameters x.", |of, d| {
        of.inverse_inertia_matrix(d.base)
    }),
    (
        "coriolis-matrix",
        "C of Christoffel from the base parameters x: C dq is the bias less gravity, dA/dt - 2 C is skew-symmetric.",
        |of, d| of.coriolis_matrix(d.base),
    ),
    (
        "inverse-dynamics-derivatives",
        "Derivatives of the torques by q and dq, from the base parameters x; that by ddq is the inertia matrix.",
        |of, d| of.inverse_dynamics_derivatives(d.base),
    ),
    (
        "forward-dynamics-derivatives",
        "Derivatives of the accelerations by q, dq and the torques, from the base parameters x.",
        |of, d| of.forward_dynamics_derivatives(d.base),
    ),
    ("slotine-li-regressor", "A ddq_r + C dq_r + g per unit of each base parameter, with Christoffel's C.", |of, d| {
        of.slotine_li_regressor(d.base)
    }),
    ("momentum", "The generalised momentum A dq from the base parameters x, kg m^2/s (kg m/s).", |of, d| {
        of.momentum(d.base)
    }),
    ("momentum-regressor", "The generalised momentum A dq per unit of each base parameter.", |of, d| {
        of.momentum_regressor(d.base)
    }),
    (
        "momentum-and-rate",
        "The generalised momentum p = A dq and b = C^T dq - g from the base parameters x: dp/dt = tau + b without contact.",
        |of, d| of.momentum_and_rate(d.base),
    ),
    (
        "centre-of-mass",
        "Centre of mass of the moving links, m, and its Jacobian, in the base frame, from the standard parameters x.",
        |of, _| of.centre_of_mass(),
    ),
    (
        "centroidal-momentum",
        "Momentum, then angular momentum about the centre of mass, and map with h = map dq, from the standard parameters x.",
        |of, _| of.centroidal_momentum(),
    ),
    (
        "joint-reactions",
        "Force, then moment at O_j, with which the link before moves each link, in its frame, one column per link, from the \
         standard parameters x; that along the axis is the joint's torque less IA ddq.",
        |of, _| of.joint_reactions(),
    ),
    (
        "constraint-equations",
        "The loops that are solved numerically: e = 0, ja dq + jp dq_p = 0, and dq_p = g dq of the passive joints.",
        |of, _| of.constraint_equations().unwrap_or_else(|| nothing("constraint_equations")),
    ),
    ("friction", "Friction torques: f is FV FS OFF of each coordinate.", |of, _| of.friction()),
];

/// A function of one link that a generated file may contain, such as its pose.
#[derive(Clone, Copy)]
pub struct FunctionOfLink {
    /// The word that requests the function.
    pub word: &'static str,
    /// The texts before and after the name of the link's frame in the sentence above the function in the generated file.
    pub sentence: [&'static str; 2],
    /// Derives the function, in the axes of the link's own frame, or in the axes of a reference frame if `has_reference`. Fails
    /// if the robot does not have the function.
    pub derive: fn(&mut Derivation, LinkFrame, Option<&ReferenceFrame>) -> Result<Function, String>,
    /// Whether the function can be given in the axes of another frame.
    pub has_reference: bool,
}

/// The table of functions of one link.
const FUNCTIONS_OF_LINK: &[FunctionOfLink] = &[
    FunctionOfLink {
        word: "pose",
        sentence: ["Orientation and position of ", ""],
        derive: |of, frame, reference| match reference {
            None => Ok(of.pose(frame)),
            Some(reference) => Ok(of.pose_in(frame, reference)),
        },
        has_reference: true,
    },
    FunctionOfLink {
        word: "jacobian",
        sentence: ["Velocity of the origin of ", ", then its angular velocity, per unit of each coordinate's rate"],
        derive: |of, frame, reference| match reference {
            None => Ok(of.jacobian(frame)),
            Some(reference) => Ok(of.jacobian_in(frame, reference)),
        },
        has_reference: true,
    },
    FunctionOfLink {
        word: "point-jacobian",
        sentence: [
            "Velocity of a point fixed to ",
            " and given in its frame, then its angular velocity, per unit of each coordinate's rate",
        ],
        derive: |of, frame, reference| Ok(of.point_jacobian(frame, reference)),
        has_reference: true,
    },
    FunctionOfLink {
        word: "geometric-error-jacobian",
        sentence: [
            "Velocity of the origin of ",
            ", then its angular velocity, per unit of the errors of gamma, b, beta, alpha, d, theta and r of each link from the base",
        ],
        derive: |of, frame, reference| Ok(of.geometric_error_jacobian(frame, reference)),
        has_reference: true,
    },
    FunctionOfLink {
        word: "velocity",
        sentence: ["Velocity of the origin of ", ", then its angular velocity"],
        derive: |of, frame, reference| Ok(of.velocity(frame, reference)),
        has_reference: true,
    },
    FunctionOfLink {
        word: "acceleration",
        sentence: ["Acceleration of the origin of ", " without gravity, then its angular acceleration"],
        derive: |of, frame, reference| Ok(of.acceleration(frame, reference)),
        has_reference: true,
    },
    FunctionOfLink {
        word: "jdot-dq",
        sentence: [
            "Acceleration of the origin of ",
            " at ddq = 0, then its angular acceleration: (dJ/dt) dq of the Jacobian in the axes of the base",
        ],
        derive: |of, frame, reference| Ok(of.jacobian_rate(frame, reference)),
        has_reference: true,
    },
    FunctionOfLink {
        word: "external-torque",
        sentence: ["", ": what to add to the torques when it exerts this force and moment, in its frame"],
        derive: |of, frame, _| Ok(of.external_torque(frame)),
        has_reference: false,
    },
    FunctionOfLink {
        word: "load-momentum",
        sentence: [
            "Momentum p and b = C^T dq - g per unit of XX XY XZ YY YZ ZZ MX MY MZ M of a load on ",
            ", in its frame",
        ],
        derive: |of, frame, _| Ok(of.load_momentum(frame)),
        has_reference: false,
    },
];

static REGISTERED: OnceLock<Vec<FunctionOfLink>> = OnceLock::new();

/// Adds functions of a link that other packages derive. Only the first call has an effect.
pub fn register_functions(functions: Vec<FunctionOfLink>) {
    REGISTERED.get_or_init(|| functions);
}

/// All functions of a link: the functions of this package and the registered functions.
fn functions_of_link() -> impl Iterator<Item = &'static FunctionOfLink> {
    FUNCTIONS_OF_LINK.iter().chain(REGISTERED.get().into_iter().flatten())
}

/// A function without outputs. It stands for a function that does not exist for the robot ([`RobotFunction::check`] reports
/// this).
fn nothing(name: &str) -> Function {
    Function::new(name, &Graph::new(), Vec::new(), Vec::new())
}

impl Derivation<'_> {
    /// Derives the function `which`. `standard`: regressor of the robot's standard parameters; `base`: the robot's base
    /// parameters.
    pub fn function(&mut self, which: &RobotFunction, standard: &Function, base: &BaseParameters) -> Function {
        which.derive(self, &Derived { standard, base }).1
    }
}

/// The parameters that these functions need: base parameters if the base regressor is requested, or if no function is
/// requested. For other functions, an unclear rank is not an error; the standard parameters are then used.
pub(crate) fn parameters_of(
    functions: &[RobotFunction],
    derivation: &mut Derivation,
    regressor: &Function,
) -> Result<BaseParameters, UnclearRank> {
    match functions.is_empty() || functions.iter().any(RobotFunction::is_base_regressor) {
        true => derivation.base_parameters(regressor),
        false => derivation.parameters_at_any_rank(regressor),
    }
}

/// The reason why a robot does not have a requested function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotThere {
    /// The robot does not have this function of a link; the text is the reason.
    OfLink(String),
    /// Joint reactions were requested for a robot with loops.
    Loops,
    /// Constraint equations were requested for a robot without loops that are solved numerically.
    NoPassive,
}

impl std::fmt::Display for NotThere {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NotThere::OfLink(why) => f.write_str(why),
            NotThere::Loops => f.write_str(
                "it has loops, and the forces of a cut joint, which its torques do not determine, pass through the others; \
                 reactions are there for trees of links",
            ),
            NotThere::NoPassive => f.write_str(
                "it has no joint that a loop determines numerically; `[:inspect]` prints the relations of the others",
            ),
        }
    }
}

impl std::error::Error for NotThere {}

impl RobotFunction {
    /// Checks whether the robot has this function. An inverse geometric model, for example, does not exist for all robots.
    ///
    /// The error is the reason why the robot does not have the function.
    pub fn check(&self, robot: &Robot) -> Result<(), NotThere> {
        match &self.0 {
            FunctionRow::OfRobot(i) => match FUNCTIONS_OF_ROBOT[*i].0 {
                "joint-reactions" if !robot.loops.is_empty() => Err(NotThere::Loops),
                "constraint-equations" if robot.passive.is_empty() => Err(NotThere::NoPassive),
                _ => Ok(()),
            },
            FunctionRow::OfLink(OfLink(function), about)
                if FUNCTIONS_OF_LINK.iter().all(|core| core.word != function.word) =>
            {
                // This check is needed only for functions of other packages. If the robot cannot be derived because its loops
                // do not close, the error is reported elsewhere.
                let derivation = Derivation::new(robot).ok();
                let made = derivation.map(|mut d| (function.derive)(&mut d, about.0.clone(), None));
                made.and_then(Result::err).map_or(Ok(()), |why| Err(NotThere::OfLink(why)))
            }
            _ => Ok(()),
        }
    }

    /// The function of the whole robot that a word requests, such as `inertia-matrix`; `None` for an unknown word.
    pub fn of_robot(word: &str) -> Option<RobotFunction> {
        FUNCTIONS_OF_ROBOT.iter().position(|row| row.0 == word).map(|i| RobotFunction(FunctionRow::OfRobot(i)))
    }

    /// The function of one link that a word requests, such as `pose`; `None` for an unknown word.
    pub fn of_link(word: &str) -> Option<impl Fn(LinkFrame) -> RobotFunction> {
        let found = functions_of_link().find(|row| row.word == word)?;
        Some(move |frame| RobotFunction(FunctionRow::OfLink(OfLink(found), Box::new((frame, None)))))
    }

    /// The same function, given in the axes of a reference frame. `None` if it is no function of a link, or if it does not
    /// depend on the axes.
    pub fn expressed_in(self, reference: ReferenceFrame) -> Option<RobotFunction> {
        match self.0 {
            FunctionRow::OfLink(found, of) if found.0.has_reference => {
                Some(RobotFunction(FunctionRow::OfLink(found, Box::new((of.0, Some(reference))))))
            }
            _ => None,
        }
    }

    /// For all functions: the word that requests the function, and whether it is a function of a link.
    pub fn words() -> impl Iterator<Item = (&'static str, bool)> {
        FUNCTIONS_OF_ROBOT.iter().map(|row| (row.0, false)).chain(functions_of_link().map(|row| (row.word, true)))
    }

    /// Whether this is the base regressor, which every generated file contains.
    pub(crate) fn is_base_regressor(&self) -> bool {
        self.0 == FunctionRow::OfRobot(0)
    }

    /// Derives the function. Returns the sentence above the function in the generated file, and the function.
    pub(crate) fn derive(&self, derivation: &mut Derivation, derived: &Derived) -> (String, Function) {
        match &self.0 {
            FunctionRow::OfRobot(i) => {
                let (_, sentence, derive) = FUNCTIONS_OF_ROBOT[*i];
                let sentence = match derived.base.refused {
                    None => sentence.to_string(),
                    Some(_) => sentence.replace("base parameter", "standard parameter"),
                };
                (sentence, derive(derivation, derived))
            }
            FunctionRow::OfLink(OfLink(found), of) => {
                let (frame, reference) = of.as_ref();
                let FunctionOfLink { word, sentence: [before, behind], derive, has_reference } = found;
                let place = match (reference, has_reference) {
                    (Some(reference), _) => format!(" in the axes of {}", reference.name()),
                    (None, true) if *word == "pose" => " in the base frame".into(),
                    (None, true) => " in its frame".into(),
                    (None, false) => String::new(),
                };
                let sentence = format!("{before}{}{behind}{place}: {}.", frame.name, frame.meaning());
                let derived = derive(derivation, frame.clone(), reference.as_ref());
                (sentence, derived.unwrap_or_else(|_| nothing(&word.replace('-', "_"))))
            }
        }
    }
}
