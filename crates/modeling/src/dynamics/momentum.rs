//! The generalised momentum p = A(q) dq with dp/dt = tau + C^T dq - g [De Luca, Albu-Schaeffer, Haddadin, Hirzinger 2006],
//! computed from the momentum of each link. A: inertia matrix; C: Christoffel's Coriolis matrix; g: gravity torques; tau: joint
//! torques.
//!
//! ```text
//! h = M v + w x MS,   L = J w + MS x v       p_j = z . L (revolute) or z . h (prismatic) + IA dq_j
//! ```
//! M, MS, J: mass, first moment and inertia matrix of link j; v, w: velocity of its origin and angular velocity; z: joint axis;
//! IA: rotor inertia. h and L of each link are transformed inward and added up. For the regressor, h and L of each link are
//! multiplied by the twists of the coordinates, as in [`crate::dynamics::regressor`].

use expr::{Expr, Function, Graph, Output};
use robot::{Inertial, StandardParameter};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::composite::RigidBody;
use crate::dynamics::momenta::velocities;
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::{MotionInput, add_to_coordinates, along_axis, joint_variable};
use crate::kinematics::vector::{NULL, Vector, add, cross, dot, plus_dot};

impl Derivation<'_> {
    /// The generalised momentum A dq as a function: inputs `q`, `dq`, `x` (X_base), output `p` (n), kg m^2/s (kg m/s).
    pub fn momentum(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let p = momentum_entries(self, x).0;
        let inputs = [self.motion.configuration(), vec![self.motion.input(MotionInput::Dq), x.input()]].concat();
        let output = Output { name: "p".into(), rows: p.len(), columns: 1, entries: p };
        Function::new("momentum", &self.graph, inputs, vec![output])
    }

    /// The generalised momentum A dq per unit of each of the p base parameters, as a function: inputs `q`, `dq`, output `y` (n x
    /// p).
    pub fn momentum_regressor(&mut self, base: &BaseParameters) -> Function {
        let Derivation { robot, graph: g, motion, links, implicit, .. } = self;
        let w: Vec<Vector> = links.iter().map(|link| link.w).collect();
        let v = velocities(g, robot, links, &w, &motion.dq);
        let parameters: Vec<StandardParameter> = base.base.iter().map(|b| base.standard[b.column]).collect();
        let mut rows = vec![vec![Expr::ZERO; parameters.len()]; robot.n_variables()];
        for (c, parameter) in parameters.iter().enumerate() {
            // One column of the regressor: IA of a rotor, or momentum h and angular momentum L per unit of the parameter.
            let (link, at) = (robot.link(parameter.link), &links[parameter.link.0]);
            if parameter.inertial == Inertial::Ia {
                let rate = joint_variable(g, link, &motion.dq);
                for &(k, coefficient) in &link.joint.variable.terms {
                    let coefficient = g.constant(coefficient);
                    rows[k.0][c] = g.mul(coefficient, rate);
                }
                continue;
            }
            let [h, L] = unit_momentum(g, at.w, v[parameter.link.0], parameter.inertial);
            // Entry z_jk . L + d_jk . h for each coordinate k that moves link j. (z_jk, d_jk): twist of link j per unit rate of
            // coordinate k.
            for (row, twist) in rows.iter_mut().zip(&at.jacobian) {
                if let Some(twist) = twist {
                    let angular = dot(g, twist.z, L);
                    row[c] = plus_dot(g, angular, twist.d, h);
                }
            }
        }
        if let Some(implicit) = implicit {
            rows = reduced(g, &implicit.G, &rows);
        }
        let inputs = [motion.configuration(), vec![motion.input(MotionInput::Dq)]].concat();
        let output = Output { name: "y".into(), rows: rows.len(), columns: parameters.len(), entries: rows.concat() };
        Function::new("momentum_regressor", g, inputs, vec![output])
    }
}

/// The generalised momentum A dq, one expression per coordinate. Also, for each link j together with all links that it carries:
/// the momentum h and the angular momentum L about O_j, in frame j.
pub(crate) fn momentum_entries(derivation: &mut Derivation, x: &ParameterInputs) -> (Vec<Expr>, Vec<[Vector; 2]>) {
    let Derivation { robot, graph: g, motion, links, implicit, .. } = derivation;
    let w: Vec<Vector> = links.iter().map(|link| link.w).collect();
    let v = velocities(g, robot, links, &w, &motion.dq);
    let mut p = vec![Expr::ZERO; robot.n_variables()];
    // Momentum h = M v + w x MS and angular momentum L = J w + MS x v of each link.
    let mut momenta: Vec<[Vector; 2]> = robot
        .link_ids()
        .map(|j| {
            let (body, w, v) = (RigidBody::new(x.body(j)), links[j.0].w, v[j.0]);
            let (moved, turned) = (v.map(|v| g.mul(body.mass, v)), cross(g, w, body.first_moment));
            let (own, lever) = (body.times(g, w), cross(g, body.first_moment, v));
            [add(g, moved, turned), add(g, own, lever)]
        })
        .collect();
    // From the end links inward: take the component of each link's momentum along the joint axis, then add the link's momentum
    // to the momentum of the antecedent.
    for j in robot.link_ids().rev() {
        let link = robot.link(j);
        let [h, L] = momenta[j.0];
        let along = along_axis(link.joint.kind, [h, L]);
        let rate = joint_variable(g, link, &motion.dq);
        let rotor = g.mul(x.get(j, Inertial::Ia), rate);
        let along = g.add(along, rotor);
        add_to_coordinates(g, link, along, &mut p);
        if let Some(i) = link.antecedent {
            let [h, L] = links[j.0].placement.wrench_to_antecedent(g, [h, L]);
            momenta[i.0] = [add(g, momenta[i.0][0], h), add(g, momenta[i.0][1], L)];
        }
    }
    // Passive coordinates follow from the coordinates (dq_p = G dq). So the momenta of the passive coordinates, times G^T, are
    // added to the momenta of the coordinates.
    let p = match implicit {
        None => p,
        Some(implicit) => reduced(g, &implicit.G, &p.into_iter().map(|x| vec![x]).collect::<Vec<_>>()).concat(),
    };
    (p, momenta)
}

/// Momentum h and angular momentum L of link j about O_j, per unit of one inertial parameter. w: angular velocity, v: velocity of
/// O_j.
pub(crate) fn unit_momentum(g: &mut Graph, w: Vector, v: Vector, parameter: Inertial) -> [Vector; 2] {
    let [x, y, z] = w;
    let o = Expr::ZERO;
    let axis = |c: usize| std::array::from_fn(|i| if i == c { Expr::ONE } else { o });
    let mut of_first_moment = |c: usize| [cross(g, w, axis(c)), cross(g, axis(c), v)];
    match parameter {
        Inertial::Xx => [NULL, [x, o, o]],
        Inertial::Xy => [NULL, [y, x, o]],
        Inertial::Xz => [NULL, [z, o, x]],
        Inertial::Yy => [NULL, [o, y, o]],
        Inertial::Yz => [NULL, [o, z, y]],
        Inertial::Zz => [NULL, [o, o, z]],
        Inertial::Mx => of_first_moment(0),
        Inertial::My => of_first_moment(1),
        Inertial::Mz => of_first_moment(2),
        Inertial::M => [v, NULL],
        Inertial::Ia => [NULL, NULL],
    }
}
