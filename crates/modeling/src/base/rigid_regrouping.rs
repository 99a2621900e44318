//! The regrouping rules of trees: combinations of a link's inertial parameters that act like parameters of its antecedent.
//!
//! If a body is symmetric about the joint axis and has no inertia about this axis, its inertia, seen from the antecedent, does
//! not depend on the joint variable. For a revolute joint, such bodies have the parameters XX = YY, MZ and M; for a prismatic
//! joint the whole inertia tensor; for a fixed joint all parameters [Gautier, Khalil 1990]. Such a body of link j adds to the
//! parameters of the antecedent i, about O_i and in frame i,
//!
//! ```text
//! J_i  += R J R^T + 2 (p . s) 1 - p s^T - s p^T + m (p . p 1 - p p^T)
//! MS_i += s + m p,   M_i += m,      s = R MS_j
//! ```
//! with R = R_ij and p = p_ij at joint variable zero. So the columns of D obey D_j X_j = D_i X_i: one relation for each such
//! set of parameters, exact in the robot's symbols. The relation also holds for passive joints.

use expr::{Expr, Graph};
use robot::{Inertial, JointKind, LinkId, Robot};

use crate::base::coefficient::Coefficient;
use crate::kinematics::constants::Constants;
use crate::kinematics::vector::{NULL, Vector, add, dot};

/// A relation of regressor columns: the column of `dropped` = sum of coefficient * column over the terms. A column is named by
/// link and parameter.
#[derive(Clone, Debug)]
pub(crate) struct TreeRule {
    pub dropped: (LinkId, Inertial),
    pub terms: Vec<((LinkId, Inertial), Coefficient)>,
}

/// The rules between all links and their antecedents, link by link. A link whose lengths are
/// not polynomials in symbols (a division by a sum) has no rules.
pub(crate) fn tree_rules(robot: &Robot, g: &mut Graph, constants: &mut Constants) -> Vec<TreeRule> {
    let mut rules = Vec::new();
    // Links without inertial parameters have no rules, so such links are left out.
    let has_parameters = |j: LinkId| j.0 >= robot.massless;
    for j in robot.link_ids().filter(|&j| has_parameters(j) && robot.link(j).antecedent.is_none_or(has_parameters)) {
        let frame = RelativeFrame::of(robot, g, constants, j);
        for (dropped, own, body) in free_directions(robot.link(j).joint.kind) {
            let carried = match robot.link(j).antecedent {
                Some(i) => {
                    let parameters = frame.carried(g, body);
                    Inertial::BODY.into_iter().zip(parameters).map(|(inertial, e)| ((i, inertial), e)).collect()
                }
                None => Vec::new(),
            };
            let terms: Option<Vec<_>> = carried
                .into_iter()
                .filter(|(_, e)| !e.is_zero())
                .map(|(parameter, e)| Some((parameter, Coefficient::from_expr(g, e)?)))
                .collect();
            let Some(mut terms) = terms else { continue };
            terms.extend(own.iter().map(|&o| ((j, o), Coefficient::one().negated())));
            rules.push(TreeRule { dropped: (j, dropped), terms });
        }
    }
    rules
}

/// A body whose ten parameters are 0 or 1, in the order of [`Inertial::BODY`]: true means 1.
type ParameterSet = [bool; 10];

/// For each rule of a joint of this kind: the dropped parameter; the other parameters of the same link that absorb the dropped
/// parameter; and the set of parameters of the symmetric body.
fn free_directions(kind: JointKind) -> Vec<(Inertial, Vec<Inertial>, ParameterSet)> {
    use Inertial::*;
    let body = |set: &[Inertial]| Inertial::BODY.map(|i| set.contains(&i));
    match kind {
        JointKind::Revolute => {
            vec![(Yy, vec![Xx], body(&[Xx, Yy])), (Mz, vec![], body(&[Mz])), (M, vec![], body(&[M]))]
        }
        JointKind::Prismatic => [Xx, Xy, Xz, Yy, Yz, Zz].map(|i| (i, vec![], body(&[i]))).into(),
        JointKind::Fixed => Inertial::BODY.map(|i| (i, vec![], body(&[i]))).into(),
    }
}

/// The pose of link frame j in the antecedent's frame i at joint variable zero.
struct RelativeFrame {
    /// The axes x, y, z of frame j in frame i: the columns of R.
    axes: [Vector; 3],
    p: Vector,
}

impl RelativeFrame {
    fn of(robot: &Robot, g: &mut Graph, constants: &mut Constants, j: LinkId) -> RelativeFrame {
        let link = robot.link(j);
        let name = |letter: &str| format!("{letter}{}", link.label);
        let dh = &link.geometry;
        let mut turn = |g: &mut Graph, value, letter: &str| constants.angle(g, value, &name(letter)).turn(g);
        let (gamma, alpha) = (turn(g, &dh.gamma, "gamma"), turn(g, &dh.alpha, "alpha"));
        let theta = turn(g, &dh.theta, "theta");
        let mut length = |g: &mut Graph, value, letter: &str| constants.length(g, value, &name(letter));
        let (b, d, r) = (length(g, &dh.b, "b"), length(g, &dh.d, "d"), length(g, &dh.r, "r"));
        let mut place = |v: Vector, offset: Vector| {
            let v = alpha.unturned_about_x(g, v);
            let v = add(g, v, offset);
            gamma.unturned(g, v)
        };
        let p = place([Expr::ZERO, Expr::ZERO, r], [d, Expr::ZERO, b]);
        let axes = [
            place([theta.cos, theta.sin, Expr::ZERO], NULL),
            place([-theta.sin, theta.cos, Expr::ZERO], NULL),
            place([Expr::ZERO, Expr::ZERO, Expr::ONE], NULL),
        ];
        RelativeFrame { axes, p }
    }

    /// The ten parameters of a body in frame i, about O_i. In frame j, the parameters in `body` are 1 and the others are 0.
    fn carried(&self, g: &mut Graph, body: ParameterSet) -> [Expr; 10] {
        let unit = |i: usize| if body[i] { Expr::ONE } else { Expr::ZERO };
        let [xx, xy, xz, yy, yz, zz, mx, my, mz, m] = std::array::from_fn(unit);
        let J = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let (R, p) = (&self.axes, self.p);

        // First moment in frame i: s = R MS_j. The columns of R are the axes.
        let mut s = NULL;
        for (moment, axis) in [mx, my, mz].into_iter().zip(R) {
            for i in 0..3 {
                let term = g.mul(moment, axis[i]);
                s[i] = g.add(s[i], term);
            }
        }
        // Terms on the diagonal: 2 (p . s) + m p . p.
        let (ps, pp) = (dot(g, p, s), dot(g, p, p));
        let mpp = g.mul(m, pp);
        let two = g.constant(2.0);
        let twice = g.mul(two, ps);
        let isotropic = g.add(twice, mpp);

        // Inertia tensor: R J R^T, the diagonal terms, and -p s^T - s p^T - m p p^T.
        let mut inertia = |r: usize, c: usize| {
            let mut sum = if r == c { isotropic } else { Expr::ZERO };
            for a in 0..3 {
                for b in 0..3 {
                    let turned = g.mul(R[a][r], R[b][c]);
                    let term = g.mul(J[a][b], turned);
                    sum = g.add(sum, term);
                }
            }
            let (p_s, s_p, p_p) = (g.mul(p[r], s[c]), g.mul(s[r], p[c]), g.mul(p[r], p[c]));
            let mpp = g.mul(m, p_p);
            for term in [p_s, s_p, mpp] {
                sum = g.sub(sum, term);
            }
            sum
        };
        let six = [inertia(0, 0), inertia(0, 1), inertia(0, 2), inertia(1, 1), inertia(1, 2), inertia(2, 2)];
        let first = [0, 1, 2].map(|i| {
            let mp = g.mul(m, p[i]);
            g.add(s[i], mp)
        });
        [six[0], six[1], six[2], six[3], six[4], six[5], first[0], first[1], first[2], m]
    }
}
