//! The inverse geometric model of arms of six revolute joints, all eight solutions, by Paul's method [Paul 1981;
//! Khalil, Dombre 2002, chapter 4].
//!
//! Two classes of arms, both with the second axis across the first and the last three axes one across the other:
//!
//! ```text
//! spherical wrist   axes 2 and 3 parallel, axes 4, 5 and 6 meet in a point        Puma 560, RX90
//! parallel axes     axes 2, 3 and 4 parallel                                      UR5
//! ```
//! With W the wrist's centre, or O_5, in the frame that the first joint turns, the part of W along axis 2 is a length h:
//!
//! ```text
//! -S1 W_x + C1 W_y = -sin(alpha_2) h              two angles: W_x, W_y and the root of W_x^2 + W_y^2 - h^2
//! u = d_3 c2 + (x c23 - y s23), v = ...           u^2 + v^2 gives theta_3, two angles; then u, v give theta_2
//! ```
//! (x, y) is the wrist's centre in frame 3, or (d_4, 0). The wrist follows from the direction of axis 6, with two signs of
//! sin theta_5. Of parallel axes the wrist comes before theta_3, since it places O_4.
//!
//! Sines and cosines are the outputs: q = atan2(sin_q, cos_q). A solution that is out of reach, and one that is singular (a
//! root of zero: W on axis 1, or axis 6 along axis 4 or the parallel axes), has entries that are no numbers.

use expr::{Expr, Function, Graph, Input, Output, SymbolKind};
use robot::{JointKind, LinkId, Pose, Robot};

use crate::derivation::Derivation;
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::reference_frame::constants;
use crate::kinematics::angle::Angle;
use crate::kinematics::links::{Geometry, LinkMotion};
use crate::kinematics::vector::{Turn, Vector, add, dot};

/// Solutions of an arm.
const SOLUTIONS: usize = 8;

/// What keeps an arm from having these closed forms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoClosedForm(String);

impl std::fmt::Display for NoClosedForm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "no inverse geometric model: {}; closed forms are there for six revolute joints with a spherical wrist behind two \
             parallel axes, or with axes 2, 3 and 4 parallel",
            self.0
        )
    }
}

impl std::error::Error for NoClosedForm {}

/// A joint of the arm: alpha and d, then theta and r with what the next link adds to them.
struct ArmJoint {
    /// Quarter turns.
    alpha: i64,
    d: Expr,
    offset: Angle,
    r: Expr,
    coordinate: usize,
    sign: f64,
}

impl ArmJoint {
    /// sin(alpha), of an odd number of quarter turns.
    fn sine(&self) -> f64 {
        if self.alpha.rem_euclid(4) == 1 { 1.0 } else { -1.0 }
    }

    fn is_parallel(&self) -> bool {
        self.alpha.rem_euclid(4) == 0
    }

    fn is_across(&self) -> bool {
        self.alpha.rem_euclid(2) == 1
    }
}

/// Input `t` (3 x 4, row by row: the pose of the frame in the base); outputs `sin_q` and `cos_q` (8 x 6), one solution a row.
///
/// Fails where the arm is of neither class.
pub(crate) fn inverse_geometry(derivation: &mut Derivation, frame: &LinkFrame) -> Result<Function, NoClosedForm> {
    let joints = arm(derivation, frame.link)?;
    let has_wrist = class(&joints)?;
    let Derivation { robot, graph: g, links, .. } = derivation;
    let t: Vec<Expr> = (0..12).map(|k| g.symbol(&format!("T{}{}", k / 4 + 1, k % 4 + 1), SymbolKind::Input)).collect();
    let first = chain(robot, frame.link)[0];
    let target = Target::new(g, &t, frame, &links[first.0]);
    let mut solutions: Vec<[Turn; 6]> = Vec::new();
    for signs in 0..SOLUTIONS {
        let signs = [0, 1, 2].map(|bit| signs >> bit & 1 == 1);
        solutions.push(if has_wrist {
            with_wrist(g, &joints, &target, signs)
        } else {
            with_parallel_axes(g, &joints, &target, signs)
        });
    }
    let (mut sines, mut cosines) = (vec![Expr::ZERO; SOLUTIONS * 6], vec![Expr::ZERO; SOLUTIONS * 6]);
    for (k, solution) in solutions.into_iter().enumerate() {
        for (joint, turn) in joints.iter().zip(solution) {
            // q = +-(theta - offset)
            let back = joint.offset.negated().turn(g);
            let turn = together(g, turn, back);
            sines[6 * k + joint.coordinate] = if joint.sign < 0.0 { -turn.sin } else { turn.sin };
            cosines[6 * k + joint.coordinate] = turn.cos;
        }
    }
    let output = |name: &str, entries| Output { name: name.into(), rows: SOLUTIONS, columns: 6, entries };
    let inputs = vec![Input { name: "t".into(), entries: t }];
    let outputs = vec![output("sin_q", sines), output("cos_q", cosines)];
    Ok(Function::new(&frame.function("inverse_geometry"), g, inputs, outputs))
}

/// The links from the base to this one.
fn chain(robot: &Robot, link: LinkId) -> Vec<LinkId> {
    let mut chain: Vec<LinkId> = std::iter::successors(Some(link), |j| robot.link(*j).antecedent).collect();
    chain.reverse();
    chain
}

/// Its six joints.
fn arm(derivation: &mut Derivation, link: LinkId) -> Result<Vec<ArmJoint>, NoClosedForm> {
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
        if link.joint.kind != JointKind::Revolute || sign.abs() != 1.0 {
            return refused(format!("{} does not turn with its coordinate", link.name));
        }
        if !joints.is_empty() && !alpha.terms.is_empty() {
            return refused(format!("the axis of {} is oblique", link.name));
        }
        if let Some(last) = joints.last_mut() {
            last.offset = last.offset.plus(&gamma);
            last.r = g.add(last.r, b);
        }
        joints.push(ArmJoint { alpha: alpha.quarter_turns, d, offset: theta, r, coordinate: coordinate.0, sign });
    }
    Ok(joints)
}

/// Whether the arm has a spherical wrist; it has parallel axes if not.
fn class(joints: &[ArmJoint]) -> Result<bool, NoClosedForm> {
    let [_, two, three, four, five, six] = joints else { return Err(NoClosedForm("there are not six joints".into())) };
    let refused = |text: &str| Err(NoClosedForm(text.into()));
    if !two.is_across() || !three.is_parallel() {
        return refused("axis 2 is not across axis 1, or axis 3 not parallel to axis 2");
    }
    if !five.is_across() || !six.is_across() || !five.d.is_zero() || !six.d.is_zero() {
        return refused("axis 5 does not cross axis 4 and axis 6 at right angles");
    }
    if three.d.is_zero() {
        return refused("axes 2 and 3 are one");
    }
    match (four.is_parallel(), four.is_across(), five.r.is_zero()) {
        (true, ..) if !four.d.is_zero() => Ok(false),
        (_, true, true) => Ok(true),
        _ => refused("axes 4, 5 and 6 do not meet, and axis 4 is not parallel to axis 3"),
    }
}

/// Where the last link is to be, in the frame before the first joint turns.
struct Target {
    /// Columns of its orientation.
    x: Vector,
    y: Vector,
    z: Vector,
    p: Vector,
}

impl Target {
    fn new(g: &mut Graph, t: &[Expr], frame: &LinkFrame, first: &LinkMotion) -> Target {
        let column = |c: usize| [t[c], t[4 + c], t[8 + c]];
        let Pose { rotation, position } = frame.pose.inverse();
        // T_0j = T_0f T_fj
        let mut combined = |v: [f64; 3]| {
            let v = constants(g, v);
            [0, 1, 2].map(|r| dot(g, v, [t[4 * r], t[4 * r + 1], t[4 * r + 2]]))
        };
        let axes = [0, 1, 2].map(|c| combined([rotation[0][c], rotation[1][c], rotation[2][c]]));
        let p = combined(position);
        let p = add(g, p, column(3));
        let placement = &first.placement;
        let from_first: Vector = std::array::from_fn(|i| g.sub(p[i], placement.p[i]));
        let [x, y, z] = axes.map(|axis| placement.to_link_before_theta(g, axis));
        Target { x, y, z, p: placement.to_link_before_theta(g, from_first) }
    }

    /// The point of axis 6 at r_6 before its origin.
    fn before(&self, g: &mut Graph, r: Expr) -> Vector {
        let shift = self.z.map(|z| g.mul(r, z));
        std::array::from_fn(|i| g.sub(self.p[i], shift[i]))
    }
}

/// theta_1 that brings W to h along axis 2: -S1 W_x + C1 W_y = -sin(alpha_2) h. The distance of W from axis 1 and 2 along
/// x of frame 1 comes with it.
fn first_turn(g: &mut Graph, two: &ArmJoint, W: Vector, h: Expr, is_other: bool) -> (Turn, Expr) {
    let b = if two.sine() > 0.0 { -h } else { h };
    let (xx, yy, bb) = (g.mul(W[0], W[0]), g.mul(W[1], W[1]), g.mul(b, b));
    let square = g.add(xx, yy);
    let rest = g.sub(square, bb);
    let root = g.sqrt(rest);
    let a = if is_other { -root } else { root };
    // a = C1 W_x + S1 W_y
    let (cx, sx) = (g.mul(a, W[0]), g.mul(b, W[1]));
    let (cy, sy) = (g.mul(a, W[1]), g.mul(b, W[0]));
    let (cos, sin) = (g.add(cx, sx), g.sub(cy, sy));
    (unit_turn(g, cos, sin), a)
}

/// theta_2 and theta_3 that bring the point (x, y) of frame 3 to (u, v) of the plane across axis 2.
fn arm_turns(g: &mut Graph, d: Expr, [x, y]: [Expr; 2], [u, v]: [Expr; 2], is_other: bool) -> [Turn; 2] {
    // 2 d (x C3 - y S3) = u^2 + v^2 - d^2 - x^2 - y^2
    let squares = [u, v, d, x, y].map(|e| g.mul(e, e));
    let (distance, reach) = (g.add(squares[0], squares[1]), g.add(squares[3], squares[4]));
    let (two, half) = (g.constant(2.0), g.sub(distance, squares[2]));
    let (difference, twice) = (g.sub(half, reach), g.mul(two, d));
    let k = g.div(difference, twice);
    // x C3 - y S3 = k and x S3 + y C3 = l, with k^2 + l^2 = x^2 + y^2
    let kk = g.mul(k, k);
    let rest = g.sub(reach, kk);
    let root = g.sqrt(rest);
    let l = if is_other { -root } else { root };
    let products = [(x, k), (y, l), (x, l), (y, k)].map(|(a, b)| g.mul(a, b));
    let (cos, sin) = (g.add(products[0], products[1]), g.sub(products[2], products[3]));
    let third = Turn { cos: g.div(cos, reach), sin: g.div(sin, reach) };
    let X = g.add(d, k);
    let products = [(u, X), (v, l), (v, X), (u, l)].map(|(a, b)| g.mul(a, b));
    let (cos, sin) = (g.add(products[0], products[1]), g.sub(products[2], products[3]));
    [unit_turn(g, cos, sin), third]
}

/// The turn to (cos, sin), of length 1 whatever cancelled on the way: an arm that is folded reaches its pose all the same.
fn unit_turn(g: &mut Graph, cos: Expr, sin: Expr) -> Turn {
    let (cc, ss) = (g.mul(cos, cos), g.mul(sin, sin));
    let square = g.add(cc, ss);
    let length = g.sqrt(square);
    Turn { cos: g.div(cos, length), sin: g.div(sin, length) }
}

/// u, v of a point in the plane across axis 2, from its distance a along x of frame 1 and its height along axis 1.
fn in_plane(g: &mut Graph, two: &ArmJoint, a: Expr, height: Expr) -> [Expr; 2] {
    let v = if two.sine() > 0.0 { height } else { -height };
    [g.sub(a, two.d), v]
}

fn with_wrist(g: &mut Graph, joints: &[ArmJoint], target: &Target, [one, three, five]: [bool; 3]) -> [Turn; 6] {
    let (j2, j3, j4, j5, j6) = (&joints[1], &joints[2], &joints[3], &joints[4], &joints[5]);
    let W = target.before(g, j6.r);
    // In frame 3 the wrist's centre is (d_4, -r_4 sin alpha_4, 0).
    let y = if j4.sine() > 0.0 { -j4.r } else { j4.r };
    let h = g.add(j2.r, j3.r);
    let (first, a) = first_turn(g, j2, W, h, one);
    let place = in_plane(g, j2, a, W[2]);
    let [second, third] = arm_turns(g, j3.d, [j4.d, y], place, three);

    // Axes of the last link in frame 3, then before theta_4 turns.
    let both = together(g, second, third);
    let seen = |g: &mut Graph, v: Vector| {
        let v = first.turned(g, v);
        let v = about_x(v, -j2.alpha);
        let v = both.turned(g, v);
        about_x(v, -j4.alpha)
    };
    let axes = [target.x, target.y, target.z].map(|axis| seen(g, axis));
    let [x, y, z] = axes;
    let (s5, s6) = (j5.sine(), j6.sine());
    // z_6 = (C4 s6 S5, S4 s6 S5, -s5 s6 C5); the row along axis 4 is (s5 S5 C6, -s5 S5 S6, -s5 s6 C5).
    let (xx, yy) = (g.mul(z[0], z[0]), g.mul(z[1], z[1]));
    let square = g.add(xx, yy);
    let root = g.sqrt(square);
    let sin = if five { -root } else { root };
    let fifth = Turn { cos: signed(z[2], -s5 * s6), sin };
    let fourth = Turn { cos: g.div(signed(z[0], s6), sin), sin: g.div(signed(z[1], s6), sin) };
    let sixth = Turn { cos: g.div(signed(x[2], s5), sin), sin: g.div(signed(y[2], -s5), sin) };
    [first, second, third, fourth, fifth, sixth]
}

fn with_parallel_axes(g: &mut Graph, joints: &[ArmJoint], target: &Target, [one, three, five]: [bool; 3]) -> [Turn; 6] {
    let (j2, j3, j4, j5, j6) = (&joints[1], &joints[2], &joints[3], &joints[4], &joints[5]);
    let W = target.before(g, j6.r);
    let (r, s2) = (g.add(j2.r, j3.r), j2.sine());
    let h = g.add(r, j4.r);
    let (first, _) = first_turn(g, j2, W, h, one);

    // Axis 4 is (sin(alpha_2) S1, -sin(alpha_2) C1, 0); in frame 6 it is (s5 S5 C6, -s5 S5 S6, -s5 s6 C5).
    let axis = [signed(first.sin, s2), signed(first.cos, -s2), Expr::ZERO];
    let seen = [target.x, target.y, target.z].map(|column| dot(g, axis, column));
    let (s5, s6) = (j5.sine(), j6.sine());
    let (xx, yy) = (g.mul(seen[0], seen[0]), g.mul(seen[1], seen[1]));
    let square = g.add(xx, yy);
    let root = g.sqrt(square);
    let sin = if five { -root } else { root };
    let fifth = Turn { cos: signed(seen[2], -s5 * s6), sin };
    let sixth = Turn { cos: g.div(signed(seen[0], s5), sin), sin: g.div(signed(seen[1], -s5), sin) };

    // z_5 = s6 (S6 x_6 + C6 y_6), y_4 = -s5 z_5, and O_4 = O_5 - r_5 z_5.
    let z5 = [0, 1, 2].map(|i| {
        let (a, b) = (g.mul(sixth.sin, target.x[i]), g.mul(sixth.cos, target.y[i]));
        let sum = g.add(a, b);
        signed(sum, s6)
    });
    let shift = z5.map(|z| g.mul(j5.r, z));
    let O4: Vector = std::array::from_fn(|i| g.sub(W[i], shift[i]));
    let seen = |g: &mut Graph, v: Vector| {
        let v = first.turned(g, v);
        about_x(v, -j2.alpha)
    };
    let (y4, at) = (seen(g, z5.map(|z| signed(z, -s5))), first.turned(g, O4));
    let all = Turn { cos: y4[1], sin: -y4[0] };
    let place = in_plane(g, j2, at[0], O4[2]);
    let [second, third] = arm_turns(g, j3.d, [j4.d, Expr::ZERO], place, three);
    let both = together(g, second, third);
    let fourth = together(g, all, Turn { cos: both.cos, sin: -both.sin });
    [first, second, third, fourth, fifth, sixth]
}

/// The sum of two angles.
fn together(g: &mut Graph, a: Turn, b: Turn) -> Turn {
    let [cc, ss, sc, cs] = [(a.cos, b.cos), (a.sin, b.sin), (a.sin, b.cos), (a.cos, b.sin)].map(|(a, b)| g.mul(a, b));
    Turn { cos: g.sub(cc, ss), sin: g.add(sc, cs) }
}

/// A vector turned about x by quarter turns: Rx v.
fn about_x([x, y, z]: Vector, quarter_turns: i64) -> Vector {
    match quarter_turns.rem_euclid(4) {
        0 => [x, y, z],
        1 => [x, -z, y],
        2 => [x, -y, -z],
        _ => [x, z, -y],
    }
}

fn signed(e: Expr, sign: f64) -> Expr {
    if sign < 0.0 { -e } else { e }
}
