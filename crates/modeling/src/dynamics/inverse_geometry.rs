//! The inverse geometric model of arms of six joints, all eight solutions, by Paul's method [Paul 1981; Khalil, Dombre 2002,
//! chapter 4].
//!
//! Three classes of arms ([`crate::dynamics::inverse_arm`]), all with the second axis across the first and the last three axes
//! one across the other:
//!
//! ```text
//! spherical wrist   axes 2 and 3 parallel, axes 4, 5 and 6 meet in a point                     Puma 560, RX90
//!                   joint 3 slides across axis 2, axes 4, 5 and 6 meet in a point of its axis   Stanford arm
//! parallel axes     axes 2, 3 and 4 parallel                                                   UR5
//! ```
//! and the same arms from the other end: those whose first three axes meet, or with axes 3, 4 and 5 parallel.
//! With W the wrist's centre, or O_5, in the frame that the first joint turns, the part of W along axis 2 is a length h:
//!
//! ```text
//! -S1 W_x + C1 W_y = -sin(alpha_2) h              two angles: W_x, W_y and the root of W_x^2 + W_y^2 - h^2
//! u = d_3 c2 + (x c23 - y s23), v = ...           u^2 + v^2 gives theta_3, two angles; then u, v give theta_2
//! ```
//! (x, y) is the wrist's centre in frame 3, or (d_4, 0). Where joint 3 slides, u^2 + v^2 gives r_3, with two signs. The wrist
//! follows from the direction of axis 6, with two signs of sin theta_5. Of parallel axes the wrist comes before theta_3, since
//! it places O_4.
//!
//! Sines and cosines are the outputs: q = atan2(sin_q, cos_q). A solution that is out of reach, and one that is singular (a
//! root of zero: W on axis 1, or axis 6 along axis 4 or the parallel axes), has entries that are no numbers.

use expr::{Expr, Function, Graph, Input, Output, SymbolKind};
use robot::Pose;

use crate::derivation::Derivation;
use crate::dynamics::inverse_arm::{Arm, ArmJoint, Class, NoClosedForm, chain};
use crate::dynamics::link_frame::LinkFrame;
use crate::dynamics::reference_frame::constants;
use crate::kinematics::links::{Geometry, LinkMotion};
use crate::kinematics::vector::{Turn, Vector, add, dot};

/// Solutions of an arm.
const SOLUTIONS: usize = 8;

/// A configuration: the turn of each joint, theta with its offset, and r_3 of a joint that slides.
struct Solution {
    turns: [Turn; 6],
    slide: Expr,
}

/// Input `t` (3 x 4, row by row: the pose of the frame in the base); outputs `sin_q` and `cos_q` (8 x 6), one solution a row,
/// and `slide` (8), the coordinate of the joint that slides, where there is one: in its column sine is 0 and cosine 1.
///
/// Fails where the arm is of no class.
pub(crate) fn inverse_geometry(derivation: &mut Derivation, frame: &LinkFrame) -> Result<Function, NoClosedForm> {
    let arm = Arm::new(derivation, frame.link)?;
    let Derivation { robot, graph: g, links, constants, .. } = derivation;
    let t: Vec<Expr> = (0..12).map(|k| g.symbol(&format!("T{}{}", k / 4 + 1, k % 4 + 1), SymbolKind::Input)).collect();
    let chain = chain(robot, frame.link);
    let mut target = Target::new(g, &t, frame, &links[chain[0].0]);
    // b of link 2 is along axis 1, and no turn of the first joint moves it.
    let second = chain.get(1).map_or(Expr::ZERO, |&j| Geometry::of(g, constants, robot.link(j)).b);
    target.p[2] = g.sub(target.p[2], second);
    let target = if arm.is_reversed {
        let last = Geometry::of(g, constants, robot.link(frame.link));
        target.reversed(g, last.r)
    } else {
        target
    };
    let joints = &arm.joints;
    let (mut sines, mut cosines) = (vec![Expr::ZERO; SOLUTIONS * 6], vec![Expr::ZERO; SOLUTIONS * 6]);
    let mut slides = Vec::new();
    for k in 0..SOLUTIONS {
        let signs = [0, 1, 2].map(|bit| k >> bit & 1 == 1);
        let solution = match arm.class {
            Class::Wrist | Class::WristOfSlide => with_wrist(g, joints, &target, signs, arm.class),
            Class::ParallelAxes => with_parallel_axes(g, joints, &target, signs),
        };
        for (joint, turn) in joints.iter().zip(solution.turns) {
            if joint.slides {
                // r = r_3 +- q
                let q = g.sub(solution.slide, joint.r);
                slides.push(if joint.sign < 0.0 { -q } else { q });
                cosines[6 * k + joint.coordinate] = Expr::ONE;
                continue;
            }
            // q = +-(theta - offset)
            let back = joint.offset.negated().turn(g);
            let turn = together(g, turn, back);
            sines[6 * k + joint.coordinate] = if joint.sign < 0.0 { -turn.sin } else { turn.sin };
            cosines[6 * k + joint.coordinate] = turn.cos;
        }
    }
    let output = |name: &str, columns, entries| Output { name: name.into(), rows: SOLUTIONS, columns, entries };
    let inputs = vec![Input { name: "t".into(), entries: t }];
    let mut outputs = vec![output("sin_q", 6, sines), output("cos_q", 6, cosines)];
    if !slides.is_empty() {
        outputs.push(output("slide", 1, slides));
    }
    Ok(Function::new(&frame.function("inverse_geometry"), g, inputs, outputs))
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

    /// Where the frame before the first joint turns is to be in that of the last link at r_6 before its origin: the
    /// inverse pose, of the arm read from its end.
    fn reversed(&self, g: &mut Graph, r: Expr) -> Target {
        let Target { x, y, z, p } = *self;
        let mut along = |axis: Vector| -dot(g, axis, p);
        let [px, py, pz] = [along(x), along(y), along(z)];
        Target { x: [x[0], y[0], z[0]], y: [x[1], y[1], z[1]], z: [x[2], y[2], z[2]], p: [px, py, g.add(pz, r)] }
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

/// theta_2 and r that bring the point (d, -sin(alpha_3) r) of frame 2 to (u, v): r^2 = u^2 + v^2 - d^2.
fn slide(g: &mut Graph, three: &ArmJoint, [u, v]: [Expr; 2], is_other: bool) -> (Turn, Expr) {
    let squares = [u, v, three.d].map(|e| g.mul(e, e));
    let distance = g.add(squares[0], squares[1]);
    let rest = g.sub(distance, squares[2]);
    let root = g.sqrt(rest);
    let y = if is_other { -root } else { root };
    let products = [(u, three.d), (v, y), (v, three.d), (u, y)].map(|(a, b)| g.mul(a, b));
    let (cos, sin) = (g.add(products[0], products[1]), g.sub(products[2], products[3]));
    (unit_turn(g, cos, sin), signed(y, -three.sine()))
}

/// u, v of a point in the plane across axis 2, from its distance a along x of frame 1 and its height along axis 1.
fn in_plane(g: &mut Graph, two: &ArmJoint, a: Expr, height: Expr) -> [Expr; 2] {
    let v = if two.sine() > 0.0 { height } else { -height };
    [g.sub(a, two.d), v]
}

fn with_wrist(
    g: &mut Graph,
    joints: &[ArmJoint],
    target: &Target,
    [one, three, five]: [bool; 3],
    class: Class,
) -> Solution {
    let (j2, j3, j4, j5, j6) = (&joints[1], &joints[2], &joints[3], &joints[4], &joints[5]);
    let W = target.before(g, j6.r);
    let unturned = Turn { cos: Expr::ONE, sin: Expr::ZERO };
    let slides = class == Class::WristOfSlide;
    let h = if slides { j2.r } else { g.add(j2.r, j3.r) };
    let (first, a) = first_turn(g, j2, W, h, one);
    let place = in_plane(g, j2, a, W[2]);
    let (second, third, length) = if slides {
        let (second, length) = slide(g, j3, place, three);
        // The wrist's centre is r_4 cos(alpha_4) behind O_3.
        let behind = if j4.is_across() { Expr::ZERO } else { signed(j4.r, if j4.is_parallel() { 1.0 } else { -1.0 }) };
        // What turns the boom about its own axis is no variable.
        let fixed = j3.offset.turn(g);
        (second, fixed, g.sub(length, behind))
    } else {
        // In frame 3 the wrist's centre is (d_4, -r_4 sin alpha_4, 0).
        let y = if j4.sine() > 0.0 { -j4.r } else { j4.r };
        let [second, third] = arm_turns(g, j3.d, [j4.d, y], place, three);
        (second, third, Expr::ZERO)
    };

    // Axes of the last link in frame 3, then before theta_4 turns.
    let seen = |g: &mut Graph, v: Vector| {
        let v = first.turned(g, v);
        let v = about_x(v, -j2.alpha);
        let v = if slides {
            let v = second.turned(g, v);
            let v = about_x(v, -j3.alpha);
            third.turned(g, v)
        } else {
            let both = together(g, second, third);
            both.turned(g, v)
        };
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
    let third = if slides { unturned } else { third };
    Solution { turns: [first, second, third, fourth, fifth, sixth], slide: length }
}

fn with_parallel_axes(g: &mut Graph, joints: &[ArmJoint], target: &Target, [one, three, five]: [bool; 3]) -> Solution {
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
    Solution { turns: [first, second, third, fourth, fifth, sixth], slide: Expr::ZERO }
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
