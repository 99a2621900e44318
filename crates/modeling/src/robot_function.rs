//! What a generated file may hold: the word that asks for a function, the sentence above it, and its derivation.

use expr::{Function, Graph};
use robot::Robot;

use crate::base::base_parameters::BaseParameters;
use crate::base::unclear_rank::UnclearRank;
use crate::derivation::Derivation;
use crate::dynamics::inverse_arm::NoClosedForm;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::reference_frame::ReferenceFrame;

/// A function of a robot that a file may hold.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotFunction(Row);

/// A row of the tables.
#[derive(Clone, Debug, PartialEq)]
enum Row {
    OfRobot(usize),
    OfLink(usize, Box<(LinkFrame, Option<ReferenceFrame>)>),
}

/// What is derived once for all functions of a file.
pub(crate) struct Derived<'a> {
    /// D of the standard parameters.
    pub standard: &'a Function,
    pub base: &'a BaseParameters,
}

/// Word, sentence, derivation.
type OfRobot = (&'static str, &'static str, fn(&mut Derivation, &Derived) -> Function);

/// Functions of the whole robot. The first is in every file.
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

/// A function of one link.
struct OfLink {
    word: &'static str,
    /// What stands before and behind the name of the link in the sentence.
    sentence: [&'static str; 2],
    /// In the axes of the frame itself, or of another where `has_reference`.
    derive: fn(&mut Derivation, LinkFrame, Option<&ReferenceFrame>) -> Function,
    has_reference: bool,
}

/// Functions of one link.
const FUNCTIONS_OF_LINK: &[OfLink] = &[
    OfLink {
        word: "pose",
        sentence: ["Orientation and position of ", ""],
        derive: |of, frame, reference| match reference {
            None => of.pose(frame),
            Some(reference) => of.pose_in(frame, reference),
        },
        has_reference: true,
    },
    OfLink {
        word: "jacobian",
        sentence: ["Velocity of the origin of ", ", then its angular velocity, per unit of each coordinate's rate"],
        derive: |of, frame, reference| match reference {
            None => of.jacobian(frame),
            Some(reference) => of.jacobian_in(frame, reference),
        },
        has_reference: true,
    },
    OfLink {
        word: "point-jacobian",
        sentence: [
            "Velocity of a point fixed to ",
            " and given in its frame, then its angular velocity, per unit of each coordinate's rate",
        ],
        derive: |of, frame, reference| of.point_jacobian(frame, reference),
        has_reference: true,
    },
    OfLink {
        word: "velocity",
        sentence: ["Velocity of the origin of ", ", then its angular velocity"],
        derive: |of, frame, reference| of.velocity(frame, reference),
        has_reference: true,
    },
    OfLink {
        word: "acceleration",
        sentence: ["Acceleration of the origin of ", " without gravity, then its angular acceleration"],
        derive: |of, frame, reference| of.acceleration(frame, reference),
        has_reference: true,
    },
    OfLink {
        word: "jdot-dq",
        sentence: [
            "Acceleration of the origin of ",
            " at ddq = 0, then its angular acceleration: (dJ/dt) dq of the Jacobian in the axes of the base",
        ],
        derive: |of, frame, reference| of.jacobian_rate(frame, reference),
        has_reference: true,
    },
    OfLink {
        word: "jacobian-determinant",
        sentence: ["Determinant of the Jacobian of ", ", with other than six coordinates that of J^T J or J J^T"],
        derive: |of, frame, _| of.jacobian_determinant(frame),
        has_reference: false,
    },
    OfLink {
        word: "inverse-geometry",
        sentence: [
            "All eight configurations, one a row, that bring ",
            " to the pose t in the base frame: q = atan2(sin_q, cos_q), or slide of a joint that slides; an angle that is free, where axes lie along each other, is 0, and what is out of reach is no number",
        ],
        derive: |of, frame, _| of.inverse_geometry(frame).unwrap_or_else(|_| nothing("inverse_geometry")),
        has_reference: false,
    },
    OfLink {
        word: "external-torque",
        sentence: ["", ": what to add to the torques when it exerts this force and moment, in its frame"],
        derive: |of, frame, _| of.external_torque(frame),
        has_reference: false,
    },
];

/// A function without outputs, of a robot that does not have it ([`RobotFunction::check`]).
fn nothing(name: &str) -> Function {
    Function::new(name, &Graph::new(), Vec::new(), Vec::new())
}

impl Derivation<'_> {
    /// A function; `standard` and `base` are the robot's regressor of the standard parameters and its base parameters.
    pub fn function(&mut self, which: &RobotFunction, standard: &Function, base: &BaseParameters) -> Function {
        which.derive(self, &Derived { standard, base }).1
    }
}

/// The parameters that functions are of: base parameters, which the base regressor needs, else those of any rank.
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

/// Why a robot does not have a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotThere {
    /// An arm without a closed form of its inverse geometric model.
    NoClosedForm(NoClosedForm),
    /// Reactions of a robot with loops.
    Loops,
    /// Equations of loops of a robot without joints that are solved numerically.
    NoPassive,
}

impl std::fmt::Display for NotThere {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NotThere::NoClosedForm(e) => e.fmt(f),
            NotThere::Loops => f.write_str(
                "it has loops, and the forces of a cut joint, which its torques leave open, pass through the others; \
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
    /// Whether the robot has the function: an inverse geometric model is not there for all.
    ///
    /// Fails with the reason.
    pub fn check(&self, robot: &Robot) -> Result<(), NotThere> {
        match &self.0 {
            Row::OfRobot(i) => match FUNCTIONS_OF_ROBOT[*i].0 {
                "joint-reactions" if !robot.loops.is_empty() => Err(NotThere::Loops),
                "constraint-equations" if robot.passive.is_empty() => Err(NotThere::NoPassive),
                _ => Ok(()),
            },
            Row::OfLink(i, about) if FUNCTIONS_OF_LINK[*i].word == "inverse-geometry" => {
                // A robot whose loops do not close has other worries.
                let derivation = Derivation::new(robot).ok();
                let made = derivation.map(|mut d| d.inverse_geometry(about.0.clone()));
                made.and_then(Result::err).map_or(Ok(()), |e| Err(NotThere::NoClosedForm(e)))
            }
            _ => Ok(()),
        }
    }

    /// A function of the whole robot by its word, `inertia-matrix`; `None` where there is none.
    pub fn of_robot(word: &str) -> Option<RobotFunction> {
        FUNCTIONS_OF_ROBOT.iter().position(|row| row.0 == word).map(|i| RobotFunction(Row::OfRobot(i)))
    }

    /// A function of one link by its word, `pose`; `None` where there is none.
    pub fn of_link(word: &str) -> Option<impl Fn(LinkFrame) -> RobotFunction> {
        let i = FUNCTIONS_OF_LINK.iter().position(|row| row.word == word)?;
        Some(move |frame| RobotFunction(Row::OfLink(i, Box::new((frame, None)))))
    }

    /// The same function expressed in another frame; `None` where it is not of a link or has no axes.
    pub fn expressed_in(self, reference: ReferenceFrame) -> Option<RobotFunction> {
        match self.0 {
            Row::OfLink(i, of) if FUNCTIONS_OF_LINK[i].has_reference => {
                Some(RobotFunction(Row::OfLink(i, Box::new((of.0, Some(reference))))))
            }
            _ => None,
        }
    }

    /// All words, each with whether it is of a link.
    pub fn words() -> impl Iterator<Item = (&'static str, bool)> {
        FUNCTIONS_OF_ROBOT.iter().map(|row| (row.0, false)).chain(FUNCTIONS_OF_LINK.iter().map(|row| (row.word, true)))
    }

    /// Whether it is the base regressor, which every file holds.
    pub(crate) fn is_base_regressor(&self) -> bool {
        self.0 == Row::OfRobot(0)
    }

    /// The sentence above it, and the function.
    pub(crate) fn derive(&self, derivation: &mut Derivation, derived: &Derived) -> (String, Function) {
        match &self.0 {
            Row::OfRobot(i) => {
                let (_, sentence, derive) = FUNCTIONS_OF_ROBOT[*i];
                let sentence = match derived.base.refused {
                    None => sentence.to_string(),
                    Some(_) => sentence.replace("base parameter", "standard parameter"),
                };
                (sentence, derive(derivation, derived))
            }
            Row::OfLink(i, of) => {
                let (frame, reference) = of.as_ref();
                let OfLink { sentence: [before, behind], derive, has_reference, .. } = &FUNCTIONS_OF_LINK[*i];
                let place = match (reference, has_reference) {
                    (Some(reference), _) => format!(" in the axes of {}", reference.name()),
                    (None, true) if FUNCTIONS_OF_LINK[*i].word == "pose" => " in the base frame".into(),
                    (None, true) => " in its frame".into(),
                    (None, false) => String::new(),
                };
                let sentence = format!("{before}{}{behind}{place}: {}.", frame.name, frame.meaning());
                (sentence, derive(derivation, frame.clone(), reference.as_ref()))
            }
        }
    }
}
