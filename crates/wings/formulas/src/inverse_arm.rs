//! Determines whether an arm has an inverse geometric model in closed form ([`crate::inverse_geometry`]), its class, and its
//! joints.
//!
//! If the first three axes of an arm intersect, the arm has a spherical wrist when it is traversed from its end to its base. Let
//!
//! ```text
//! T_06 = prod_i Rx(alpha_i) Tx(d_i) Rz(theta_i) Tz(r_i)
//! T_06^-1 = Tz(-r_6) Rz(-theta_6) Tx(-d_6) Rx(-alpha_6) Rz(-theta_5) Tz(-r_5) ..
//! ```
//! (product over the joints i = 1 .. 6). Then the inverse has the form of the first line with theta'_k = -theta_(7-k), r'_k =
//! -r_(7-k), alpha'_k = -alpha_(8-k), d'_k = -d_(8-k).
//!
//! If an axis is antiparallel to the previous axis, its frame is rotated by a half turn about x, which makes the axes parallel:
//!
//! ```text
//! Rx(pi) Tx(d_i) Rz(theta_i) Tz(r_i) = Tx(d_i) Rz(-theta_i) Tz(-r_i) Rx(pi)
//! ```

use expr::Expr;
use robot::{JointKind, LinkId, Robot};

use modeling::Derivation;
use modeling::building::{Angle, Geometry};

/// The reason why no closed form of the arm is known here.
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

/// A joint of the arm. alpha and d are parameters of its link. theta and r also include gamma and b of the next link, which act
/// about and along the same axis.
#[derive(Clone)]
pub(crate) struct ArmJoint {
    /// Angle alpha as a number of quarter turns.
    pub alpha: i64,
    pub d: Expr,
    pub offset: Angle,
    pub r: Expr,
    /// Whether the joint is prismatic: its coordinate is added to r instead of theta.
    pub slides: bool,
    /// Index of the joint's coordinate among the coordinates of the six joints, from 0.
    pub column: usize,
    pub sign: f64,
}

impl ArmJoint {
    /// sin(alpha), which is 1 or -1. Only for an odd number of quarter turns.
    pub(crate) fn sine(&self) -> f64 {
        if self.alpha.rem_euclid(4) == 1 { 1.0 } else { -1.0 }
    }

    pub(crate) fn is_parallel(&self) -> bool {
        self.alpha.rem_euclid(4) == 0
    }

    pub(crate) fn is_across(&self) -> bool {
        self.alpha.rem_euclid(2) == 1
    }
}

/// The classes of arms for which a closed form is known. Each class has its own method of solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    /// Axes 2 and 3 are parallel, and the last three axes meet in a point (spherical wrist).
    Wrist,
    /// Joint 3 is prismatic at a right angle to axis 2, and the last three axes meet in a point (spherical wrist).
    WristOfSlide,
    /// Axes 2, 3 and 4 are parallel.
    ParallelAxes,
}

/// An arm with its class.
pub(crate) struct Arm {
    pub joints: [ArmJoint; 6],
    pub class: Class,
    /// Whether the joints are listed in reverse order, from the end of the arm to its base.
    pub is_reversed: bool,
}

impl Arm {
    /// The arm that ends with `link`. Fails if the arm belongs to no class: neither from its base to its end, nor from its end to
    /// its base.
    pub(crate) fn new(derivation: &mut Derivation, link: LinkId) -> Result<Arm, NoClosedForm> {
        let joints = joints(derivation, link)?;
        let arm = |mut joints, is_reversed| {
            align(&mut joints);
            class(&joints).map(|class| Arm { joints, class, is_reversed })
        };
        let reversed = reversed(&joints);
        arm(joints, false).or_else(|refused| arm(reversed, true).map_err(|_| refused))
    }
}

/// The links from the base to `link`.
pub(crate) fn chain(robot: &Robot, link: LinkId) -> Vec<LinkId> {
    let mut chain: Vec<LinkId> = std::iter::successors(Some(link), |j| robot.link(*j).antecedent).collect();
    chain.reverse();
    chain
}

/// The six joints from the base to a link. Joints that do not move the link, for example of a gripper, are ignored.
fn joints(derivation: &mut Derivation, link: LinkId) -> Result<[ArmJoint; 6], NoClosedForm> {
    let robot = derivation.robot();
    let chain = chain(robot, link);
    let refused = |text: String| Err(NoClosedForm(text));
    if chain.len() != 6 {
        return refused(format!("{} joints lead to the link", chain.len()));
    }
    let mut joints: Vec<ArmJoint> = Vec::new();
    // Each joint variable must equal one coordinate up to sign and offset, and no two joints may have the same coordinate. The
    // joint axis must be parallel to the previous axis or at a right angle to it.
    for j in chain {
        let link = robot.link(j);
        let Geometry { gamma, b, alpha, d, theta, r } = derivation.geometry(j);
        let [(coordinate, sign)] = link.joint.variable.terms[..] else {
            return refused(format!("{} does not follow one coordinate", link.name));
        };
        let is_taken = coordinate.0 >= robot.n_coordinates() || joints.iter().any(|j| j.column == coordinate.0);
        if link.joint.kind == JointKind::Fixed || sign.abs() != 1.0 || is_taken {
            return refused(format!("{} does not move as its coordinate does", link.name));
        }
        if !joints.is_empty() && !alpha.terms.is_empty() {
            return refused(format!("the axis of {} is oblique", link.name));
        }
        // gamma of this link is an angle about the previous axis, and b a length along it. So they are added to theta and r of
        // the previous joint.
        if let Some(last) = joints.last_mut() {
            last.offset = last.offset.plus(&gamma);
            last.r = derivation.graph().add(last.r, b);
        }
        let slides = link.joint.kind == JointKind::Prismatic;
        let alpha = alpha.quarter_turns;
        joints.push(ArmJoint { alpha, d, offset: theta, r, slides, column: coordinate.0, sign });
    }
    // The coordinates of the six joints get new numbers from 0 to 5, in the same order.
    let all: Vec<usize> = joints.iter().map(|joint| joint.column).collect();
    for joint in &mut joints {
        joint.column = all.iter().filter(|other| **other < joint.column).count();
    }
    joints.try_into().or_else(|_| refused("there are not six joints".into()))
}

/// If an axis is antiparallel to the previous axis, rotates its frame by a half turn about x, so that the axes become parallel.
fn align(joints: &mut [ArmJoint; 6]) {
    for k in 1..6 {
        if joints[k].alpha.rem_euclid(4) == 2 {
            let ArmJoint { alpha, offset, r, sign, .. } = &mut joints[k];
            (*alpha, *offset, *r, *sign) = (0, offset.negated(), -*r, -*sign);
            if let Some(next) = joints.get_mut(k + 1) {
                next.alpha += 2;
            }
        }
    }
}

/// The joints of the arm in reverse order (see the equations at the top of this file). alpha and d of the first joint are 0.
fn reversed(joints: &[ArmJoint; 6]) -> [ArmJoint; 6] {
    std::array::from_fn(|k| {
        let (joint, behind) = (&joints[5 - k], joints.get(6 - k));
        ArmJoint {
            alpha: behind.map_or(0, |b| -b.alpha),
            d: behind.map_or(Expr::ZERO, |b| -b.d),
            offset: joint.offset.negated(),
            // r of the first and the last joint is 0, because the target pose already contains these lengths.
            r: if k == 0 || k == 5 { Expr::ZERO } else { -joint.r },
            sign: -joint.sign,
            ..joint.clone()
        }
    })
}

/// The class of an arm. Fails with the reason if the arm belongs to no class.
fn class([one, two, three, four, five, six]: &[ArmJoint; 6]) -> Result<Class, NoClosedForm> {
    let refused = |text: &str| Err(NoClosedForm(text.into()));
    if let Some(k) = [one, two, four, five, six].iter().position(|joint| joint.slides) {
        return refused(&format!("joint {} slides", [1, 2, 4, 5, 6][k]));
    }
    // In all classes, axis 2 is at a right angle to axis 1, axis 5 to axis 4, and axis 6 to axis 5.
    if !two.is_across() {
        return refused("axis 2 is not across axis 1");
    }
    if !(three.is_parallel() || three.slides) {
        return refused("axis 3 is not parallel to axis 2");
    }
    for (joint, before, after) in [(five, 4, 5), (six, 5, 6)] {
        if !joint.is_across() || !joint.d.is_zero() {
            return refused(&format!("axes {before} and {after} do not cross at right angles"));
        }
    }
    // The arm may be like the Stanford arm: the wrist centre must lie on the axis of the prismatic joint.
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
    // Now there are two possibilities: axes 2, 3 and 4 are parallel, or axes 4, 5 and 6 meet in a point that is not on axis 3.
    match (four.is_parallel(), four.is_across(), five.r.is_zero()) {
        (true, ..) if !four.d.is_zero() => Ok(Class::ParallelAxes),
        (_, true, true) if four.d.is_zero() && four.r.is_zero() => refused("axes 4, 5 and 6 meet on axis 3"),
        (_, true, true) => Ok(Class::Wrist),
        _ => refused("axes 4, 5 and 6 do not meet, and axis 4 is not parallel to axis 3"),
    }
}
