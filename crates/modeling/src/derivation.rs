//! One derivation: a robot's graph, from which every function of it is taken.

use expr::{Function, Graph};
use robot::Robot;

use crate::base_parameters::{BaseParameters, UnclearRank};
use crate::constants::Constants;
use crate::kinematics::{LinkMotion, Motion, link_motions};

/// A robot with its link motions derived. Lengths and angles are named constants in every function
/// taken from it; [`Function::bound`] replaces them by their values.
pub struct Derivation<'a> {
    pub(crate) robot: &'a Robot,
    pub(crate) graph: Graph,
    pub(crate) constants: Constants<'a>,
    pub(crate) motion: Motion,
    pub(crate) links: Vec<LinkMotion>,
}

impl<'a> Derivation<'a> {
    pub fn new(robot: &'a Robot) -> Derivation<'a> {
        let mut graph = Graph::new();
        let mut constants = Constants::new(robot);
        let motion = Motion::new(&mut graph, robot);
        let links = link_motions(&mut graph, robot, &mut constants, &motion);
        Derivation { robot, graph, constants, motion, links }
    }

    /// The regressor of the standard parameters, tau = D X: inputs `q`, `dq`, `ddq` (n each), output
    /// `y` (n x p, columns as [`robot::StandardParameter::all`]).
    pub fn regressor(&mut self) -> Function {
        crate::regressor::regressor(self)
    }

    /// The joint torques: inputs `q`, `dq`, `ddq` (n each) and `x` (p, the standard parameters),
    /// output `tau` (n), N m (N).
    pub fn torque(&mut self) -> Function {
        crate::torque::torque(self)
    }

    /// The base parameters of `regressor`, which must be this derivation's; refused when the rank is
    /// not clear-cut.
    pub fn base_parameters(&mut self, regressor: &Function) -> Result<BaseParameters, UnclearRank> {
        crate::base_parameters::base_parameters(self, regressor)
    }
}
