//! One derivation: a robot's graph, from which every function of it is taken.

use expr::{Expr, Function, Graph};
use robot::{LinkId, Robot};

use crate::base_parameters::{BaseParameters, UnclearRank};
use crate::closure::Closure;
use crate::constants::Constants;
use crate::energy::energy;
use crate::forward_dynamics::forward_dynamics;
use crate::implicit::{Implicit, implicit};
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
    pub(crate) implicit: Option<Implicit>,
}

/// A robot whose loops were never found closed: its geometry or the start of its passive joints is wrong.
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
    /// Derives the motion of every link. Fails when the robot has passive coordinates and no
    /// configuration was found in which its loops close.
    pub fn new(robot: &'a Robot) -> Result<Derivation<'a>, NeverCloses> {
        let mut graph = Graph::new();
        let mut constants = Constants::new(robot);
        let mut motion = Motion::new(&mut graph, robot);
        let implicit = if robot.passive.is_empty() {
            None
        } else {
            Some(implicit(&mut graph, robot, &mut constants, &mut motion).ok_or(NeverCloses)?)
        };
        let links = link_motions(&mut graph, robot, &mut constants, &motion);
        Ok(Derivation { robot, graph, constants, motion, links, implicit })
    }

    /// The solver of the passive coordinates, where there are such.
    pub fn closure(&self) -> Option<Closure> {
        let start = self.robot.passive.iter().map(|p| p.start).collect();
        self.implicit.as_ref().map(|i| Closure::new(&i.function, start))
    }

    /// What is zero where the loops are closed, and its Jacobian: inputs `q`, `passive`, outputs `e`
    /// (6 a loop: m and rad) and `j` (6 a loop, x m). `None` without passive coordinates.
    pub fn closure_function(&self) -> Option<Function> {
        self.implicit.as_ref().map(|i| i.function.clone())
    }

    /// Link motions at ddq = 0.
    pub(crate) fn coasting_links(&mut self) -> Vec<LinkMotion> {
        let mut still = self.motion.clone();
        still.ddq.fill(Expr::ZERO);
        if let Some(implicit) = &self.implicit {
            let n = self.robot.n_coordinates();
            still.ddq[n..].copy_from_slice(&implicit.coast);
        }
        link_motions(&mut self.graph, self.robot, &mut self.constants, &still)
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

    /// Friction torques: inputs `dq`, `sign_dq` (n each) and `f` (FV FS OFF a coordinate), output `tau`.
    pub fn friction(&mut self) -> Function {
        crate::friction::friction(self)
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
