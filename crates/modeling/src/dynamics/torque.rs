//! The joint torques, by recursive Newton-Euler with moments about the frame origins.
//!
//! ```text
//! f_j = M_j a_j + U_j MS_j + sum_children R f_c
//! n_j = J_j dw_j + w_j x (J_j w_j) + MS_j x a_j + sum_children (R n_c + p x R f_c)
//! tau_j = z . n_j (revolute) or z . f_j (prismatic) + IA_j ddq_j
//! ```
//! [Khalil, Kleinfinger 1987]. M, MS, J, IA: mass, first moment, inertia matrix and rotor inertia; a, w, dw: acceleration of the
//! origin minus gravity, angular velocity and acceleration; U = [dw]x + [w]x^2; R, p: pose of a child. With base parameters most
//! masses, MZ and YY are zero and their terms are omitted. The forces are transformed inward, while the regressor transforms
//! twists outward. Both use the same link motions.

use expr::{Expr, Function, Graph, Output};
use robot::{Inertial, Robot};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::kinematics::angular_motion::AngularMotion;
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::{LinkMotion, add_to_coordinates, along_axis};
use crate::kinematics::vector::{NULL, Vector, add, cross, dot, name_vector, sum};

impl Derivation<'_> {
    /// The joint torques as a function: inputs `q`, `dq`, `ddq` (n each) and `x` (p, the standard parameters),
    /// output `tau` (n), N m (N).
    pub fn torque(&mut self) -> Function {
        let x = ParameterInputs::standard(self);
        torque(self, "torque", &x)
    }

    /// The joint torques from the base parameters, as a function: inputs `q`, `dq`, `ddq` (n each) and `x` (X_base), output
    /// `tau` (n), N m (N). This function needs fewer operations than [`Derivation::torque`].
    pub fn inverse_dynamics(&mut self, base: &BaseParameters) -> Function {
        let x = ParameterInputs::base(self, base);
        torque(self, "inverse_dynamics", &x)
    }

    /// The sum of Coriolis, centrifugal and gravity torques as a function: inputs `q`, `dq`, `x` (X_base), output `tau`, N m (N).
    pub fn bias(&mut self, base: &BaseParameters) -> Function {
        self.inverse_dynamics(base).without("bias", "ddq")
    }

    /// The gravity torques as a function: inputs `q`, `x` (X_base), output `tau`, N m (N).
    pub fn gravity(&mut self, base: &BaseParameters) -> Function {
        self.bias(base).without("gravity", "dq")
    }
}

/// Makes the function `name` of the joint torques: inputs q, dq, ddq, x, output tau.
fn torque(derivation: &mut Derivation, name: &str, x: &ParameterInputs) -> Function {
    let links = std::mem::take(&mut derivation.links);
    let tau = entries(derivation, &links, x);
    derivation.links = links;
    let inputs = [derivation.motion.inputs(), vec![x.input()]].concat();
    let output = Output { name: "tau".into(), rows: tau.len(), columns: 1, entries: tau };
    Function::new(name, &derivation.graph, inputs, vec![output])
}

/// The joint torques for given link motions and parameters, one expression per coordinate.
pub(crate) fn entries(derivation: &mut Derivation, links: &[LinkMotion], x: &ParameterInputs) -> Vec<Expr> {
    let Derivation { robot, graph: g, implicit, .. } = derivation;
    let mut tau = vec![Expr::ZERO; robot.n_variables()];
    let wrenches = wrenches(g, robot, links, x);
    for j in robot.link_ids().rev() {
        let link = robot.link(j);
        let (f, n) = wrenches[j.0];
        let along = along_axis(link.joint.kind, [f, n]);
        let rotor = g.mul(x.get(j, Inertial::Ia), links[j.0].joint_acceleration);
        let along = g.add(along, rotor);
        add_to_coordinates(g, link, along, &mut tau);
    }
    match implicit {
        None => tau,
        Some(implicit) => reduced(g, &implicit.G, &tau.into_iter().map(|t| vec![t]).collect::<Vec<_>>()).concat(),
    }
}

/// Force and moment at O_j, in frame j, that are needed to move link j together with all links that it carries.
pub(crate) fn wrenches(
    g: &mut Graph,
    robot: &Robot,
    links: &[LinkMotion],
    x: &ParameterInputs,
) -> Vec<(Vector, Vector)> {
    let mut wrenches = vec![(NULL, NULL); robot.links.len()];
    for j in robot.link_ids().rev() {
        let link = robot.link(j);
        let (own_f, own_n) = wrench(g, &links[j.0], x.body(j));
        let (child_f, child_n) = wrenches[j.0];
        let (f, n) = (add(g, own_f, child_f), add(g, own_n, child_n));
        name_vector(g, f, || format!("f{}", link.label));
        name_vector(g, n, || format!("n{}", link.label));
        wrenches[j.0] = (f, n);
        if let Some(i) = link.antecedent {
            let [f, n] = links[j.0].placement.wrench_to_antecedent(g, [f, n]);
            let (sum_f, sum_n) = wrenches[i.0];
            wrenches[i.0] = (add(g, sum_f, f), add(g, sum_n, n));
        }
    }
    wrenches
}

/// Force f and moment n at O_j that move link j, from its ten parameters `body`: f = M a + U MS, n = J dw + w x (J w) + MS x a; U
/// = [dw]x + [w]x^2. The terms of J are grouped by parameter, so that n uses the entries of U too.
pub(crate) fn wrench(g: &mut Graph, j: &LinkMotion, body: [Expr; 10]) -> (Vector, Vector) {
    let [xx, xy, xz, yy, yz, zz, mx, my, mz, m] = body;
    let AngularMotion { dw: [dwx, dwy, dwz], ww, U, differences } = j.angular_motion;
    let first_moment = [mx, my, mz];

    let ma = j.a.map(|a| g.mul(m, a));
    let u_ms = U.map(|row| dot(g, row, first_moment));
    let f = add(g, ma, u_ms);

    // Moment about x: XX dw_x + (ZZ - YY) w_y w_z - XY U_zx + XZ U_yx + YZ (w_y^2 - w_z^2).
    let terms_x = [
        g.mul(xx, dwx),
        gyroscopic(g, (zz, yy), ww[1][2]),
        g.mul(xy, -U[2][0]),
        g.mul(xz, U[1][0]),
        g.mul(yz, differences[0]),
    ];
    // Moment about y: YY dw_y + (XX - ZZ) w_x w_z + XY U_zy - YZ U_xy + XZ (w_z^2 - w_x^2).
    let terms_y = [
        g.mul(yy, dwy),
        gyroscopic(g, (xx, zz), ww[0][2]),
        g.mul(xy, U[2][1]),
        g.mul(yz, -U[0][1]),
        g.mul(xz, differences[1]),
    ];
    // Moment about z: ZZ dw_z + (YY - XX) w_x w_y - XZ U_yz + YZ U_xz + XY (w_x^2 - w_y^2).
    let terms_z = [
        g.mul(zz, dwz),
        gyroscopic(g, (yy, xx), ww[0][1]),
        g.mul(xz, -U[1][2]),
        g.mul(yz, U[0][2]),
        g.mul(xy, differences[2]),
    ];
    let of_inertia = [sum(g, &terms_x), sum(g, &terms_y), sum(g, &terms_z)];
    let of_first_moment = cross(g, first_moment, j.a);
    (f, add(g, of_inertia, of_first_moment))
}

/// The gyroscopic term (plus - minus) w_a w_b of a moment; `product`: w_a w_b.
fn gyroscopic(g: &mut Graph, (plus, minus): (Expr, Expr), product: Expr) -> Expr {
    let difference = g.sub(plus, minus);
    g.mul(difference, product)
}
