//! The derivation of a robot: its expression graph, from which every function of the robot is derived.
//!
//! A derivation holds the data that all functions share: the graph, the constants of the graph, and the motion of every link.
//! The functions are methods of [`Derivation`]. Each function has a file of the same name under `dynamics/` or `base/`, which
//! also states the equations.

use expr::{Expr, Function, Graph};
use robot::Robot;

use crate::kinematics::closure::Closure;
use crate::kinematics::constants::Constants;
use crate::kinematics::implicit::{Implicit, implicit};
use crate::kinematics::links::{JointVariables, LinkMotion, link_motions};

/// A robot with the motion of its links as expressions. Lengths and angles are named constants in every function that is derived
/// from it; [`Function::bound`] replaces them by their values.
pub struct Derivation<'a> {
    pub(crate) robot: &'a Robot,
    pub(crate) graph: Graph,
    pub(crate) constants: Constants<'a>,
    pub(crate) motion: JointVariables,
    pub(crate) links: Vec<LinkMotion>,
    pub(crate) implicit: Option<Implicit>,
}

/// Error: no configuration was found in which the loops close. Either the geometry is wrong, or the search for the passive
/// joints starts at wrong values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NeverCloses;

impl std::fmt::Display for NeverCloses {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(
            "no configuration was found in which the loops close: check the lengths around each loop, and where the \
             search for its passive joints starts",
        )
    }
}

impl std::error::Error for NeverCloses {}

impl<'a> Derivation<'a> {
    /// Derives the motion of every link as expressions. Fails if the robot has passive coordinates and no configuration was
    /// found in which the loops close.
    pub fn new(robot: &'a Robot) -> Result<Derivation<'a>, NeverCloses> {
        Derivation::in_graph(robot, Graph::new())
    }

    /// Derives the motion of every link as expressions, in which intermediate results keep their names. Fails like
    /// [`Derivation::new`].
    pub fn with_names(robot: &'a Robot) -> Result<Derivation<'a>, NeverCloses> {
        Derivation::in_graph(robot, Graph::new().with_names())
    }

    fn in_graph(robot: &'a Robot, mut graph: Graph) -> Result<Derivation<'a>, NeverCloses> {
        let mut constants = Constants::new(robot);
        let mut motion = JointVariables::new(&mut graph, robot);
        let implicit = if robot.passive.is_empty() {
            None
        } else {
            Some(implicit(&mut graph, robot, &mut constants, &mut motion).ok_or(NeverCloses)?)
        };
        let links = link_motions(&mut graph, robot, &mut constants, &motion);
        Ok(Derivation { robot, graph, constants, motion, links, implicit })
    }

    /// The numeric solver of the passive coordinates; `None` if there are no passive coordinates.
    pub fn closure(&self) -> Option<Closure> {
        let start = self.robot.passive.iter().map(|p| p.start).collect();
        self.implicit.as_ref().map(|i| Closure::new(&i.function, start))
    }

    /// The function of the closure error e, which is zero if the loops are closed, and of its Jacobian by the m passive
    /// coordinates. Inputs `q`, `passive`; outputs `e` (6 per loop: m and rad) and `j` (6 rows per loop, m columns). `None`
    /// without passive coordinates.
    pub(crate) fn closure_function(&self) -> Option<Function> {
        self.implicit.as_ref().map(|i| i.function.clone())
    }

    /// The constraints on positions and rates of the loops that are closed numerically, as a function: inputs `q`, `passive`,
    /// outputs `e` (6 per loop, m and rad, zero if closed), `ja` and `jp` with ja dq + jp dq_p = 0, and `g` with dq_p = g dq.
    /// `None` without such loops.
    pub fn constraint_equations(&self) -> Option<Function> {
        Some(self.implicit.as_ref()?.constraint_equations(&self.graph, &self.motion))
    }

    /// The joint variables, their rates and their accelerations at ddq = 0, as expressions.
    pub(crate) fn coasting(&self) -> JointVariables {
        let mut still = self.motion.clone();
        still.ddq.fill(Expr::ZERO);
        if let Some(implicit) = &self.implicit {
            let n = self.robot.n_coordinates();
            still.ddq[n..].copy_from_slice(&implicit.coast);
        }
        still
    }

    /// The motions of all links at ddq = 0, as expressions.
    pub(crate) fn coasting_links(&mut self) -> Vec<LinkMotion> {
        let still = self.coasting();
        link_motions(&mut self.graph, self.robot, &mut self.constants, &still)
    }
}
