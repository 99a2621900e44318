//! What a generated file may hold: the word that asks for a function, the sentence above it, and its derivation.

use expr::Function;

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::pose::LinkFrame;

/// A function of a robot that a file may hold.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotFunction(Row);

/// A row of the tables.
#[derive(Clone, Debug, PartialEq)]
enum Row {
    OfRobot(usize),
    OfLink(usize, LinkFrame),
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
    ("inverse-dynamics", "The torques from the base parameters x, N m (N).", |of, d| of.inverse_dynamics(d.base)),
    ("torque", "The torques from the standard parameters x, N m (N).", |of, _| of.torque()),
    ("inertia-matrix", "The inertia matrix from the base parameters x, kg m^2.", |of, d| of.inertia_matrix(d.base)),
    ("bias", "Coriolis, centrifugal and gravity torques from the base parameters x.", |of, d| of.bias(d.base)),
    ("gravity", "Gravity torques from the base parameters x.", |of, d| of.gravity(d.base)),
    ("forward-dynamics", "The accelerations from the torques and x.", |of, d| of.forward_dynamics(d.base)),
    ("friction", "Friction torques: f is FV FS OFF of each coordinate.", |of, _| of.friction()),
];

/// Word, what stands before and behind the name of the link in the sentence, derivation.
type OfLink = (&'static str, [&'static str; 2], fn(&mut Derivation, LinkFrame) -> Function);

/// Functions of one link.
const FUNCTIONS_OF_LINK: &[OfLink] = &[
    ("pose", ["Orientation and position of ", " in the base frame"], |of, frame| of.pose(frame)),
    ("jacobian", ["Velocity of the origin of ", ", then its angular velocity, in its frame"], |of, frame| {
        of.jacobian(frame)
    }),
    (
        "external-torque",
        ["", ": what to add to the torques when it exerts this force and moment, in its frame"],
        |of, frame| of.external_torque(frame),
    ),
];

impl RobotFunction {
    /// A function of the whole robot by its word, `inertia-matrix`; `None` where there is none.
    pub fn of_robot(word: &str) -> Option<RobotFunction> {
        FUNCTIONS_OF_ROBOT.iter().position(|row| row.0 == word).map(|i| RobotFunction(Row::OfRobot(i)))
    }

    /// A function of one link by its word, `pose`; `None` where there is none.
    pub fn of_link(word: &str) -> Option<impl Fn(LinkFrame) -> RobotFunction> {
        let i = FUNCTIONS_OF_LINK.iter().position(|row| row.0 == word)?;
        Some(move |frame| RobotFunction(Row::OfLink(i, frame)))
    }

    /// All words, each with whether it is of a link.
    pub fn words() -> impl Iterator<Item = (&'static str, bool)> {
        FUNCTIONS_OF_ROBOT.iter().map(|row| (row.0, false)).chain(FUNCTIONS_OF_LINK.iter().map(|row| (row.0, true)))
    }

    /// Whether it is the base regressor, which every file holds.
    pub(crate) fn is_base_regressor(&self) -> bool {
        self.0 == Row::OfRobot(0)
    }

    /// The sentence above it, and the function.
    pub(crate) fn derive(&self, derivation: &mut Derivation, derived: &Derived) -> (String, Function) {
        match &self.0 {
            Row::OfRobot(i) => (FUNCTIONS_OF_ROBOT[*i].1.to_string(), FUNCTIONS_OF_ROBOT[*i].2(derivation, derived)),
            Row::OfLink(i, frame) => {
                let (_, [before, behind], derive) = &FUNCTIONS_OF_LINK[*i];
                (format!("{before}{}{behind}: {}.", frame.name, frame.meaning()), derive(derivation, frame.clone()))
            }
        }
    }
}
