//! Points that several joint axes pass through, as in shoulders and wrists.
//!
//! Where coordinates k turn a link about axes through one point P, the linear parts of their twists are
//!
//! ```text
//! d_jk = z_jk x c,   c = O_j - P
//! ```
//! with one c for all of them. The joints of a pole follow each other: only the last pole can get another axis.

use expr::Graph;
use robot::{JointKind, Link, LinkId};

use crate::kinematics::placement::{Placement, Twist};
use crate::kinematics::vector::{NULL, Vector, add};

/// The poles of what is before a link.
#[derive(Clone, Debug, Default)]
pub(crate) struct Poles {
    pub all: Vec<Pole>,
    /// The pole of each coordinate that moves the link by one axis through a pole and by nothing else.
    pub of: Vec<Option<usize>>,
}

/// A point that axes pass through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pole {
    /// From the pole to O_j, in frame j.
    pub lever: Vector,
    /// The link with the first of its axes.
    pub first: LinkId,
    /// Number of axes.
    axes: usize,
}

impl Poles {
    /// Of the base, that no coordinate moves.
    pub(crate) fn of_base(n: usize) -> Poles {
        Poles { all: Vec::new(), of: vec![None; n] }
    }

    /// Of link j, from those of the link before, whose twists are `before`.
    pub(crate) fn carried(
        &self,
        g: &mut Graph,
        (j, link): (LinkId, &Link),
        placement: &Placement,
        before: &[Option<Twist>],
    ) -> Poles {
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
        // Along the axis or none: the joint's own turn is left.
        for pole in &mut poles.all {
            pole.lever = placement.theta.turned(g, pole.lever);
        }
        for &(k, _) in &link.joint.variable.terms {
            let is_own = link.joint.kind == JointKind::Revolute && before[k.0].is_none();
            poles.of[k.0] = poles.all.len().checked_sub(1).filter(|_| is_own);
        }
        poles
    }

    /// A new pole at O_j. One that has got no second axis by now will never have one.
    fn begin(&mut self, j: LinkId) {
        if self.all.last().is_some_and(|last| last.axes < 2) {
            self.all.pop();
            let n = self.all.len();
            for of in &mut self.of {
                *of = of.filter(|&pole| pole < n);
            }
        }
        self.all.push(Pole { lever: NULL, first: j, axes: 1 });
    }
}
