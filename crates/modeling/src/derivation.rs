//! One derivation: a robot's graph, from which every function of it is taken.

use expr::{Function, Graph};
use robot::{LinkId, Robot};

use crate::base_parameters::{BaseParameters, UnclearRank};
use crate::constants::Constants;
use crate::energy::energy;
use crate::forward_dynamics::forward_dynamics;
use crate::inertia_matrix::inertia_matrix;
use crate::kinematics::{LinkMotion, Motion, link_motions};
use crate::pose;
use crate::torque::{ParameterInputs, torque};

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
        let x = ParameterInputs::standard(self);
        torque(self, "torque", &x)
    }

    /// The joint torques from the base parameters: as [`Derivation::torque`] with `x` the entries of
    /// X_base, and fewer operations.
    pub fn inverse_dynamics(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        torque(self, "inverse_dynamics", &x)
    }

    /// The inertia matrix: inputs `q` and `x` (X_base), output `a` (n x n), kg m^2.
    pub fn inertia_matrix(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        inertia_matrix(self, &x)
    }

    /// Coriolis, centrifugal and gravity torques: inputs `q`, `dq`, `x` (X_base), output `tau`.
    pub fn bias(&mut self, base: &BaseParameters) -> Function {
        self.inverse_dynamics(base).without("bias", "ddq")
    }

    /// Gravity torques: inputs `q`, `x` (X_base), output `tau`.
    pub fn gravity(&mut self, base: &BaseParameters) -> Function {
        self.bias(base).without("gravity", "dq")
    }

    /// Accelerations: inputs `q`, `dq`, `tau`, `x` (X_base), output `ddq`.
    pub fn forward_dynamics(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        forward_dynamics(self, &x)
    }

    /// Power per unit of each standard parameter: inputs `q`, `dq`, `ddq`, output `power` (1 x p), W.
    pub fn power_regressor(&mut self) -> Function {
        crate::regressor::power_regressor(self)
    }

    /// Energies per unit of each standard parameter: inputs `q`, `dq`, outputs `kinetic` and
    /// `potential` (1 x p), J.
    pub fn energy(&mut self) -> Function {
        energy(self)
    }

    /// Pose of a link: input `q`, output `t` (3 x 4): R_0j and p_0j.
    pub fn pose(&mut self, link: LinkId) -> Function {
        pose::pose(self, link)
    }

    /// Jacobian of a link: input `q`, output `j` (6 x n): velocity of O_j, then angular velocity, in
    /// the link's frame, per unit of each coordinate's rate.
    pub fn jacobian(&mut self, link: LinkId) -> Function {
        pose::jacobian(self, link)
    }

    /// Torques of a wrench: inputs `q`, `wrench` (force, then moment at O_j, that the link exerts on
    /// the environment, in its frame), output `tau`.
    pub fn external_torque(&mut self, link: LinkId) -> Function {
        pose::external_torque(self, link)
    }

    /// The base parameters of `regressor`, which must be this derivation's; refused when the rank is
    /// not clear-cut.
    pub fn base_parameters(&mut self, regressor: &Function) -> Result<BaseParameters, UnclearRank> {
        crate::base_parameters::base_parameters(self, regressor)
    }
}
