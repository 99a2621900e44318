//! The functions of a robot: the front door to all that is derived here.
//!
//! Each method takes one [`Function`] from the robot's graph. Its equations are in the file of that name
//! under `dynamics/` or `base/`.

use expr::Function;

use crate::base::base_parameters::{BaseParameters, base_parameters, ungrouped};
use crate::base::unclear_rank::UnclearRank;
use crate::derivation::Derivation;
use crate::dynamics::energy::{energies, energy};
use crate::dynamics::forward_dynamics::{forward_dynamics, inverse_inertia_matrix};
use crate::dynamics::friction::friction;
use crate::dynamics::inertia_matrix::inertia_matrix;
use crate::dynamics::inverse_arm::NoClosedForm;
use crate::dynamics::inverse_geometry::inverse_geometry;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::dynamics::pose;
use crate::dynamics::reference_frame::ReferenceFrame;
use crate::dynamics::regressor;
use crate::dynamics::slotine_li::slotine_li_regressor;
use crate::dynamics::torque::torque;
use crate::dynamics::{derivatives, determinant, frame_motion, mass_centre, momentum, reactions};

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

    /// Kinetic and potential energy: inputs `q`, `dq`, `x` (X_base), output `e` (2), J; the potential one is determined up to a
    /// constant.
    pub fn energies(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        energies(self, &x)
    }

    /// Force and moment through each joint: inputs `q`, `dq`, `ddq`, `x` (the standard parameters), output `f` (6 x links):
    /// force, then moment at O_j, with which the link before moves link j, in frame j. Of a robot without loops.
    pub fn joint_reactions(&mut self) -> Function {
        let x = ParameterInputs::standard(self);
        reactions::joint_reactions(self, &x)
    }

    /// What the loops that are solved numerically ask of positions and rates: inputs `q`, `passive`, outputs `e` (6 a loop,
    /// zero where it is closed), `ja`, `jp` with ja dq + jp dq_p = 0, and `g` with dq_p = g dq. `None` without such loops.
    pub fn constraint_equations(&self) -> Option<Function> {
        Some(self.implicit.as_ref()?.constraint_equations(&self.graph, &self.motion))
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
        pose::jacobian(self, &frame.into(), None)
    }

    /// Derivatives of the torques: inputs `q`, `dq`, `ddq`, `x` (X_base), outputs `dtau_by_q`, `dtau_by_dq` (n x n).
    pub fn inverse_dynamics_derivatives(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        derivatives::inverse_dynamics_derivatives(self, &x)
    }

    /// Derivatives of the accelerations: inputs `q`, `dq`, `tau`, `x` (X_base), outputs `ddq_by_q`, `ddq_by_dq`,
    /// `ddq_by_tau` (n x n).
    pub fn forward_dynamics_derivatives(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        derivatives::forward_dynamics_derivatives(self, &x)
    }

    /// Christoffel's C: inputs `q`, `dq`, `x` (X_base), output `c` (n x n); C dq is the bias less gravity, and
    /// dA/dt - 2 C is skew-symmetric.
    pub fn coriolis_matrix(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        derivatives::coriolis_matrix(self, &x)
    }

    /// The inverse of the inertia matrix: inputs `q`, `x` (X_base), output `inverse` (n x n).
    pub fn inverse_inertia_matrix(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        inverse_inertia_matrix(self, &x)
    }

    /// A ddq_r + C dq_r + g per unit of each base parameter: inputs `q`, `dq`, `dq_r`, `ddq_r`, output `y` (n x p).
    pub fn slotine_li_regressor(&mut self, base: &BaseParameters) -> Function {
        slotine_li_regressor(self, base)
    }

    /// The generalised momentum A dq: inputs `q`, `dq`, `x` (X_base), output `p` (n).
    pub fn momentum(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        momentum::momentum(self, &x)
    }

    /// A dq per unit of each base parameter: inputs `q`, `dq`, output `y` (n x p).
    pub fn momentum_regressor(&mut self, base: &BaseParameters) -> Function {
        momentum::momentum_regressor(self, base)
    }

    /// The centre of mass of the moving links: inputs `q`, `x` (the standard parameters), outputs `p` (3), m, in the base
    /// frame, and its Jacobian `j` (3 x n).
    pub fn centre_of_mass(&mut self) -> Function {
        let x = ParameterInputs::standard(self);
        mass_centre::centre_of_mass(self, &x)
    }

    /// Momentum, and angular momentum about the centre of mass: inputs `q`, `dq`, `x` (the standard parameters), outputs
    /// `h` (6), in the axes of the base, and `map` (6 x n) with h = map dq.
    pub fn centroidal_momentum(&mut self) -> Function {
        let x = ParameterInputs::standard(self);
        mass_centre::centroidal_momentum(self, &x)
    }

    /// Pose of a frame in another: input `q`, output `t` (3 x 4).
    pub fn pose_in(&mut self, frame: impl Into<LinkFrame>, reference: &ReferenceFrame) -> Function {
        pose::pose_in(self, &frame.into(), reference)
    }

    /// Jacobian of a frame in the axes of another: input `q`, output `j` (6 x n).
    pub fn jacobian_in(&mut self, frame: impl Into<LinkFrame>, reference: &ReferenceFrame) -> Function {
        pose::jacobian(self, &frame.into(), Some(reference))
    }

    /// Jacobian of a point fixed to a frame, in its axes or those of another: inputs `q`, `point` (3, m, in the frame),
    /// output `j` (6 x n).
    pub fn point_jacobian(&mut self, frame: impl Into<LinkFrame>, reference: Option<&ReferenceFrame>) -> Function {
        pose::point_jacobian(self, &frame.into(), reference)
    }

    /// Velocity of a frame's origin, then its angular velocity: inputs `q`, `dq`, output `v` (6), in its axes or those of
    /// another.
    pub fn velocity(&mut self, frame: impl Into<LinkFrame>, reference: Option<&ReferenceFrame>) -> Function {
        frame_motion::velocity(self, &frame.into(), reference)
    }

    /// Acceleration of a frame's origin, then its angular acceleration: inputs `q`, `dq`, `ddq`, output `a` (6).
    pub fn acceleration(&mut self, frame: impl Into<LinkFrame>, reference: Option<&ReferenceFrame>) -> Function {
        frame_motion::acceleration(self, &frame.into(), reference)
    }

    /// The acceleration at ddq = 0, which is (dJ/dt) dq for J in the axes of the base: inputs `q`, `dq`, output `a` (6).
    pub fn jacobian_rate(&mut self, frame: impl Into<LinkFrame>, reference: Option<&ReferenceFrame>) -> Function {
        frame_motion::jacobian_rate(self, &frame.into(), reference)
    }

    /// The inverse geometric model: input `t` (3 x 4, the pose of the frame in the base), outputs `sin_q`, `cos_q` (8 x 6),
    /// one solution a row, a column for each of the arm's six joints; what is out of reach is no number. Of a singular pose the
    /// free angle is 0. Where a joint slides, its coordinate is in a third output `slide` (8), and its sine and cosine are 0 and 1.
    ///
    /// Fails where the arm has no closed form of those that are known here.
    pub fn inverse_geometry(&mut self, frame: impl Into<LinkFrame>) -> Result<Function, NoClosedForm> {
        inverse_geometry(self, &frame.into())
    }

    /// Determinant of the Jacobian of a link with six coordinates, else that of J^T J or J J^T: input `q`, output `det`.
    pub fn jacobian_determinant(&mut self, frame: impl Into<LinkFrame>) -> Function {
        determinant::jacobian_determinant(self, &frame.into())
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

    /// The same, but where they are refused although all numbers are finite, the standard parameters, each for itself
    /// ([`BaseParameters::refused`]): what follows from those is right at any rank.
    ///
    /// Fails where a torque is no finite number.
    pub fn parameters_at_any_rank(&mut self, regressor: &Function) -> Result<BaseParameters, UnclearRank> {
        base_parameters(self, regressor).or_else(|refused| match refused {
            UnclearRank::NotFinite { .. } | UnclearRank::NeverCloses(_) => Err(refused),
            _ => Ok(ungrouped(self, regressor, refused)),
        })
    }
}
