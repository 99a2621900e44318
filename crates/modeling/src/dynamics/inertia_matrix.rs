//! The inertia matrix of the robot, from composite bodies (each link with all links that it carries).
//!
//! A unit acceleration of joint j alone requires this wrench on the composite body of link j:
//!
//! ```text
//! f = z x MS (revolute) or M z (prismatic),   n = J z or MS x z
//! ```
//! at O_j, the origin of link j. z: joint axis; M, MS, J: mass, first moment and inertia matrix of the composite body. The
//! wrench is transformed inward to joint k. Its component along z_k is then A_kj [Walker, Orin 1982]. If joint variables are
//! linear functions of the coordinates, the inertia matrix of the coordinates is C^T A C with C = d(joint
//! variables)/d(coordinates).

use expr::{Expr, Function, Graph, Output};
use robot::{Inertial, JointKind, LinkId, Robot};

use crate::base::base_parameters::BaseParameters;
use crate::derivation::Derivation;
use crate::dynamics::composite::{RigidBody, composites};
use crate::dynamics::parameter_inputs::ParameterInputs;
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::along_axis;
use crate::kinematics::vector::{NULL, Vector};

impl Derivation<'_> {
    /// The inertia matrix as a function: inputs `q` and `x` (X_base), output `a` (n x n), kg m^2 (kg m or kg with prismatic
    /// joints).
    pub fn inertia_matrix(&mut self, base: &BaseParameters) -> Function {
        let x = &ParameterInputs::base(self, base);
        let entries = entries(self, x);
        let n = self.robot.n_coordinates();
        let inputs = [self.motion.configuration(), vec![x.input()]].concat();
        let output = Output { name: "a".into(), rows: n, columns: n, entries };
        Function::new("inertia_matrix", &self.graph, inputs, vec![output])
    }
}

pub(crate) fn entries(derivation: &mut Derivation, x: &ParameterInputs) -> Vec<Expr> {
    let Derivation { robot, graph: g, links, implicit, .. } = derivation;
    let bodies = composites(g, robot, links, x);
    let n = robot.n_variables();
    let mut a = vec![Expr::ZERO; n * n];
    for j in robot.link_ids() {
        if robot.link(j).joint.variable.terms.is_empty() {
            continue;
        }
        let rotor = x.get(j, Inertial::Ia);
        let (mut f, mut moment) = unit_wrench(g, bodies[j.0], robot.link(j).joint.kind);
        let mut k = Some(j);
        while let Some(at) = k {
            let link = robot.link(at);
            let mut along = along_axis(link.joint.kind, [f, moment]);
            if at == j {
                along = g.add(along, rotor);
            }
            accumulate(g, robot, &mut a, (at, j), along);
            [f, moment] = links[at.0].placement.wrench_to_antecedent(g, [f, moment]);
            k = link.antecedent;
        }
    }
    let Some(implicit) = implicit else { return a };
    // Passive coordinates follow dq_p = G dq, so the inertia matrix of the coordinates is [1 G^T] A [1; G]. First the rows are
    // combined, then the columns. Both steps use one function, because A is symmetric.
    let rows: Vec<Vec<Expr>> = a.chunks(n).map(<[Expr]>::to_vec).collect();
    let half = reduced(g, &implicit.G, &rows);
    let transposed: Vec<Vec<Expr>> = (0..n).map(|c| half.iter().map(|row| row[c]).collect()).collect();
    reduced(g, &implicit.G, &transposed).concat()
}

/// Adds the entry A_kj = A_jk of the joints k and j to the entries of the coordinates that these joints follow, times the joints'
/// coefficients.
fn accumulate(g: &mut Graph, robot: &Robot, a: &mut [Expr], (k, j): (LinkId, LinkId), entry: Expr) {
    let n = robot.n_variables();
    let terms = |link: LinkId| &robot.link(link).joint.variable.terms;
    for &(row, rc) in terms(k) {
        for &(column, cc) in terms(j) {
            let factor = g.constant(rc * cc);
            let term = g.mul(factor, entry);
            let places = if k == j { vec![(row.0, column.0)] } else { vec![(row.0, column.0), (column.0, row.0)] };
            for (r, c) in places {
                a[r * n + c] = g.add(a[r * n + c], term);
            }
        }
    }
}

/// Force and moment at O_j, in frame j, that give `body` a unit acceleration of joint j.
pub(crate) fn unit_wrench(g: &mut Graph, body: RigidBody, kind: JointKind) -> (Vector, Vector) {
    let [mx, my, _] = body.first_moment;
    match kind {
        JointKind::Revolute => ([-my, mx, Expr::ZERO], body.times(g, [Expr::ZERO, Expr::ZERO, Expr::ONE])),
        JointKind::Prismatic => ([Expr::ZERO, Expr::ZERO, body.mass], [my, -mx, Expr::ZERO]),
        JointKind::Fixed => (NULL, NULL),
    }
}
