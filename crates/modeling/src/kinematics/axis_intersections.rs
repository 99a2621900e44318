//! Finds axis intersections: points through which several joint axes pass, as in shoulders and wrists.
//!
//! If coordinates k turn link j about axes z_jk through one point P, the linear parts of the twists at the origin O_j are
//!
//! ```text
//! d_jk = z_jk x c,   c = O_j - P
//! ```
//! with the same c for all these coordinates. The axes of an intersection belong to consecutive joints: only the last
//! intersection of a chain can get another axis.

use expr::Graph;
use robot::{JointKind, Link, LinkId};

use crate::kinematics::placement::{Placement, Twist};
use crate::kinematics::vector::{NULL, Vector, add};

/// The axis intersections of all joints between the base and a link.
#[derive(Clone, Debug, Default)]
pub(crate) struct AxisIntersections {
    pub all: Vec<AxisIntersection>,
    /// For each coordinate, the index of its axis intersection. `None` if the coordinate does not move the link, or moves it by
    /// something else than a single revolute joint.
    pub of: Vec<Option<usize>>,
}

/// A point through which one or several joint axes pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisIntersection {
    /// The vector from the point to the origin of link j, in frame j, m.
    pub lever: Vector,
    /// The link of the first axis through the point.
    pub first: LinkId,
    /// Number of joint axes that pass through the point.
    axes: usize,
}

impl AxisIntersections {
    /// The axis intersections of the base. There are none, because no coordinate moves the base.
    pub(crate) fn of_base(n: usize) -> AxisIntersections {
        AxisIntersections { all: Vec::new(), of: vec![None; n] }
    }

    /// The axis intersections of link j, from the intersections of its antecedent (`self`); `before`: the twists of the
    /// antecedent.
    pub(crate) fn carried(
        &self,
        g: &mut Graph,
        (j, link): (LinkId, &Link),
        placement: &Placement,
        before: &[Option<Twist>],
    ) -> AxisIntersections {
        let mut poles = self.clone();
        for pole in &mut poles.all {
            let lever = add(g, pole.lever, placement.p);
            pole.lever = placement.to_link_before_theta(g, lever);
        }
        if link.joint.kind == JointKind::Revolute {
            match poles.all.last_mut() {
                Some(last) if last.lever[0].is_zero() && last.lever[1].is_zero() => last.axes += 1,
                _ => poles.begin(j),
            }
        }
        // So far, the levers (vectors from the points to O_j) are in the axes before the joint turns. The rotation by theta
        // converts the levers to frame j.
        for pole in &mut poles.all {
            pole.lever = placement.theta.turned(g, pole.lever);
        }
        for &(k, _) in &link.joint.variable.terms {
            let is_own = link.joint.kind == JointKind::Revolute && before[k.0].is_none();
            poles.of[k.0] = poles.all.len().checked_sub(1).filter(|_| is_own);
        }
        poles
    }

    /// Adds a new point at O_j, for the axis of joint j. If the last point has only one axis, this last point is removed,
    /// because it cannot get a second axis any more.
    fn begin(&mut self, j: LinkId) {
        if self.all.last().is_some_and(|last| last.axes < 2) {
            self.all.pop();
            let n = self.all.len();
            for of in &mut self.of {
                *of = of.filter(|&pole| pole < n);
            }
        }
        self.all.push(AxisIntersection { lever: NULL, first: j, axes: 1 });
    }
}
