//! Which arms have an inverse geometric model in closed form ([`crate::dynamics::inverse_geometry`]), and their joints.
//!
//! An arm whose first three axes meet is one with a spherical wrist when it is read from its end: of
//!
//! ```text
//! T_06 = prod_i Rx(alpha_i) Tx(d_i) Rz(theta_i) Tz(r_i)
//! T_06^-1 = Tz(-r_6) Rz(-theta_6) Tx(-d_6) Rx(-alpha_6) Rz(-theta_5) Tz(-r_5) ..
//! ```
//! the second is the first with theta'_k = -theta_(7-k), r'_k = -r_(7-k), alpha'_k = -alpha_(8-k), d'_k = -d_(8-k).

use expr::Expr;
use robot::{JointKind, LinkId, Robot};

use crate::derivation::Derivation;
use crate::kinematics::angle::Angle;
use crate::kinematics::links::Geometry;

/// What keeps an arm from having these closed forms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoClosedForm(String);

impl std::fmt::Display for NoClosedForm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "no inverse geometric model: {}; closed forms are there for six joints with a spherical wrist behind two parallel \
             axes or behind a joint that slides across axis 2, or with axes 2, 3 and 4 parallel, and for the same arms read from \
             the other end",
            self.0
        )
    }
}

impl std::error::Error for NoClosedForm {}

/// A joint of the arm: alpha and d, then theta and r with what the next link adds to them.
#[derive(Clone)]
pub(super) struct ArmJoint {
    /// Quarter turns.
    pub alpha: i64,
    pub d: Expr,
    pub offset: Angle,
    pub r: Expr,
    /// Whether the coordinate is added to r, and not to theta.
    pub slides: bool,
    pub coordinate: usize,
    pub sign: f64,
}

impl ArmJoint {
    /// sin(alpha), of an odd number of quarter turns.
    pub(super) fn sine(&self) -> f64 {
        if self.alpha.rem_euclid(4) == 1 { 1.0 } else { -1.0 }
    }

    pub(super) fn is_parallel(&self) -> bool {
        self.alpha.rem_euclid(4) == 0
    }

    pub(super) fn is_across(&self) -> bool {
        self.alpha.rem_euclid(2) == 1
    }
}

/// Arms that are solved alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// A spherical wrist behind two parallel axes.
    Wrist,
    /// A spherical wrist behind a joint that slides across axis 2.
    WristOfSlide,
    /// Axes 2, 3 and 4 parallel.
    ParallelAxes,
}

/// An arm of a class.
pub(super) struct Arm {
    pub joints: Vec<ArmJoint>,
    pub class: Class,
    /// Whether it is read from its end.
    pub is_reversed: bool,
}

impl Arm {
    /// The arm that ends with this link. Fails where it is of no class from either end.
    pub(super) fn new(derivation: &mut Derivation, link: LinkId) -> Result<Arm, NoClosedForm> {
        let joints = joints(derivation, link)?;
        let forward = class(&joints);
        if let Ok(class) = forward {
            return Ok(Arm { joints, class, is_reversed: false });
        }
        let reversed = reversed(&joints);
        match class(&reversed) {
            Ok(class) => Ok(Arm { joints: reversed, class, is_reversed: true }),
            Err(_) => forward.map(|class| Arm { joints, class, is_reversed: false }),
        }
    }
}

/// The links from the base to this one.
pub(super) fn chain(robot: &Robot, link: LinkId) -> Vec<LinkId> {
    let mut chain: Vec<LinkId> = std::iter::successors(Some(link), |j| robot.link(*j).antecedent).collect();
    chain.reverse();
    chain
}

/// Its six joints.
fn joints(derivation: &mut Derivation, link: LinkId) -> Result<Vec<ArmJoint>, NoClosedForm> {
    let Derivation { robot, graph: g, constants, .. } = derivation;
    let chain = chain(robot, link);
    let refused = |text: String| Err(NoClosedForm(text));
    if chain.len() != 6 || robot.n_coordinates() != 6 || robot.n_variables() != 6 {
        return refused(format!(
            "{} joints lead to the link, and the robot has {}",
            chain.len(),
            robot.n_coordinates()
        ));
    }
    let mut joints: Vec<ArmJoint> = Vec::new();
    for j in chain {
        let link = robot.link(j);
        let Geometry { gamma, b, alpha, d, theta, r } = Geometry::of(g, constants, link);
        let [(coordinate, sign)] = link.joint.variable.terms[..] else {
            return refused(format!("{} does not follow one coordinate", link.name));
        };
        if link.joint.kind == JointKind::Fixed || sign.abs() != 1.0 {
            return refused(format!("{} does not move as its coordinate does", link.name));
        }
        if !joints.is_empty() && !alpha.terms.is_empty() {
            return refused(format!("the axis of {} is oblique", link.name));
        }
        if let Some(last) = joints.last_mut() {
            last.offset = last.offset.plus(&gamma);
            last.r = g.add(last.r, b);
        }
        let slides = link.joint.kind == JointKind::Prismatic;
        let alpha = alpha.quarter_turns;
        joints.push(ArmJoint { alpha, d, offset: theta, r, slides, coordinate: coordinate.0, sign });
    }
    Ok(joints)
}

/// The same arm read from its end; alpha and d of the first joint, and r of the last, are those of no joint.
fn reversed(joints: &[ArmJoint]) -> Vec<ArmJoint> {
    let n = joints.len();
    (0..n)
        .map(|k| {
            let (joint, behind) = (&joints[n - 1 - k], joints.get(n - k));
            ArmJoint {
                alpha: behind.map_or(0, |b| -b.alpha),
                d: behind.map_or(Expr::ZERO, |b| -b.d),
                offset: joint.offset.negated(),
                // The target is taken without r of either end.
                r: if k == 0 || k == n - 1 { Expr::ZERO } else { -joint.r },
                sign: -joint.sign,
                ..joint.clone()
            }
        })
        .collect()
}

/// The class of an arm, or why it is of none.
fn class(joints: &[ArmJoint]) -> Result<Class, NoClosedForm> {
    let [one, two, three, four, five, six] = joints else {
        return Err(NoClosedForm("there are not six joints".into()));
    };
    let refused = |text: &str| Err(NoClosedForm(text.into()));
    if let Some(k) = [one, two, four, five, six].iter().position(|joint| joint.slides) {
        return refused(&format!("joint {} slides", [1, 2, 4, 5, 6][k]));
    }
    if !two.is_across() || !(three.is_parallel() || three.slides) {
        return refused("axis 2 is not across axis 1, or axis 3 not parallel to axis 2");
    }
    if !five.is_across() || !six.is_across() || !five.d.is_zero() || !six.d.is_zero() {
        return refused("axis 5 does not cross axis 4 and axis 6 at right angles");
    }
    if three.slides {
        let behind = if four.is_across() { four.r } else { Expr::ZERO };
        return match three.is_across() && four.d.is_zero() && five.r.is_zero() && behind.is_zero() {
            true => Ok(Class::WristOfSlide),
            false => refused("axes 4, 5 and 6 do not meet on the axis along which joint 3 slides across axis 2"),
        };
    }
    if three.d.is_zero() {
        return refused("axes 2 and 3 are one");
    }
    match (four.is_parallel(), four.is_across(), five.r.is_zero()) {
        (true, ..) if !four.d.is_zero() => Ok(Class::ParallelAxes),
        (_, true, true) => Ok(Class::Wrist),
        _ => refused("axes 4, 5 and 6 do not meet, and axis 4 is not parallel to axis 3"),
    }
}
