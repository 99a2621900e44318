//! The functions of a robot: the front door to all that is derived here.
//!
//! Each method takes one [`Function`] from the robot's graph. Its equations are in the file of that name
//! under `dynamics/` or `base/`.

use expr::Function;

use crate::base::base_parameters::{BaseParameters, base_parameters};
use crate::base::unclear_rank::UnclearRank;
use crate::derivation::Derivation;
use crate::dynamics::energy::energy;
use crate::dynamics::forward_dynamics::forward_dynamics;
use crate::dynamics::friction::friction;
use crate::dynamics::inertia_matrix::inertia_matrix;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::pose::{self, LinkFrame};
use crate::dynamics::regressor;
use crate::dynamics::torque::torque;

impl Derivation<'_> {
    /// The regressor of the standard parameters, tau = D X: inputs `q`, `dq`, `ddq` (n each), output
    /// `y` (n x p, columns as [`robot::StandardParameter::all`]).
    pub fn regressor(&mut self) -> Function {
        regressor::regressor(self)
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
    pub(crate) fn power_regressor(&mut self) -> Function {
        regressor::power_regressor(self)
    }

    /// Energies per unit of each standard parameter: inputs `q`, `dq`, outputs `kinetic` and
    /// `potential` (1 x p), J.
    pub fn energy(&mut self) -> Function {
        energy(self)
    }

    /// Friction torques: inputs `dq`, `sign_dq` (n each) and `f` (FV FS OFF a coordinate), output `tau`.
    pub fn friction(&mut self) -> Function {
        friction(self)
    }

    /// Pose of a link or of a frame fixed to it: input `q`, output `t` (3 x 4): R_0j and p_0j.
    pub fn pose(&mut self, frame: impl Into<LinkFrame>) -> Function {
        pose::pose(self, &frame.into())
    }

    /// Jacobian of a link or of a frame fixed to it: input `q`, output `j` (6 x n): velocity of O_j, then angular velocity, in
    /// that frame, per unit of each coordinate's rate.
    pub fn jacobian(&mut self, frame: impl Into<LinkFrame>) -> Function {
        pose::jacobian(self, &frame.into())
    }

    /// Torques of a wrench: inputs `q`, `wrench` (force, then moment at O_j, that the link exerts on
    /// the environment, in its frame), output `tau`.
    pub fn external_torque(&mut self, frame: impl Into<LinkFrame>) -> Function {
        pose::external_torque(self, &frame.into())
    }

    /// The base parameters of `regressor`, which must be this derivation's; refused when the rank is
    /// not clear-cut.
    pub fn base_parameters(&mut self, regressor: &Function) -> Result<BaseParameters, UnclearRank> {
        base_parameters(self, regressor)
    }
}
