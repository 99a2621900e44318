//! The joint variables of a robot, their rates and accelerations, as expressions and as inputs of functions.

use expr::{Expr, Graph, Input, SymbolKind};
use robot::Robot;

use crate::kinematics::names::coordinate_labels;

/// The joint variables with their rates and accelerations, as expressions: n coordinates, then the passive variables. The rates
/// of the passive variables follow from the rates of the coordinates.
#[derive(Clone, Debug)]
pub(crate) struct JointVariables {
    pub q: Vec<Expr>,
    pub dq: Vec<Expr>,
    pub ddq: Vec<Expr>,
    /// Number of coordinates.
    pub n: usize,
}

/// A quantity of the robot's motion that can be an input of a function. The name of the input is the variant in lower case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MotionInput {
    Q,
    Passive,
    Dq,
    Ddq,
}

impl JointVariables {
    pub(crate) fn new(g: &mut Graph, robot: &Robot) -> JointVariables {
        let labels = coordinate_labels(robot);
        let mut inputs = |prefix: &str, labels: &[String]| -> Vec<Expr> {
            labels.iter().map(|label| g.symbol(&format!("{prefix}{label}"), SymbolKind::Input)).collect()
        };
        let (mut q, mut dq, mut ddq) = (inputs("q", &labels), inputs("dq", &labels), inputs("ddq", &labels));
        let n = q.len();
        let passive: Vec<String> = (1..=robot.passive.len()).map(|p| p.to_string()).collect();
        q.extend(inputs("passive", &passive));
        dq.resize(q.len(), Expr::ZERO);
        ddq.resize(q.len(), Expr::ZERO);
        JointVariables { q, dq, ddq, n }
    }

    /// The motion as inputs of a function: `q`, `passive` (if there are passive variables), `dq` and `ddq`.
    pub(crate) fn inputs(&self) -> Vec<Input> {
        let mut inputs = self.configuration();
        inputs.extend([self.input(MotionInput::Dq), self.input(MotionInput::Ddq)]);
        inputs
    }

    /// The configuration as inputs of a function: `q`, and `passive` if there are passive variables.
    pub(crate) fn configuration(&self) -> Vec<Input> {
        let mut inputs = vec![self.input(MotionInput::Q)];
        if self.q.len() > self.n {
            inputs.push(self.input(MotionInput::Passive));
        }
        inputs
    }

    /// This quantity of the motion as an input of a function.
    pub(crate) fn input(&self, which: MotionInput) -> Input {
        let (name, entries) = match which {
            MotionInput::Q => ("q", &self.q[..self.n]),
            MotionInput::Passive => ("passive", &self.q[self.n..]),
            MotionInput::Dq => ("dq", &self.dq[..self.n]),
            MotionInput::Ddq => ("ddq", &self.ddq[..self.n]),
        };
        Input { name: name.into(), entries: entries.to_vec() }
    }
}
