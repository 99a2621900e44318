//! The inverse geometric model of arms with six joints: all eight solutions, by Paul's method [Paul 1981; Khalil, Dombre 2002,
//! chapter 4].
//!
//! There are three classes of arms ([`crate::inverse_arm`]). In all of them axis 2 is at a right angle to axis 1, axis 5 to axis
//! 4, and axis 6 to axis 5:
//!
//! ```text
//! spherical wrist   axes 2 and 3 parallel, axes 4, 5 and 6 meet in a point                     Puma 560, RX90
//!                   joint 3 slides across axis 2, axes 4, 5 and 6 meet in a point of its axis   Stanford arm
//! parallel axes     axes 2, 3 and 4 parallel                                                   UR5
//! ```
//! The same arms, traversed from their end to their base, are also covered: the first three axes intersect, or axes 3, 4 and 5
//! are parallel. Let W be the wrist centre (in the class of parallel axes: the origin O_5), in the frame before the rotation of
//! joint 1. The component of W along axis 2 is a known length h (S1, C1: sine and cosine of theta_1; c2: of theta_2; c23, s23: of
//! theta_2 + theta_3):
//!
//! ```text
//! -S1 W_x + C1 W_y = -sin(alpha_2) h              two angles: W_x, W_y and the root of W_x^2 + W_y^2 - h^2
//! u = d_3 c2 + (x c23 - y s23), v = ...           u^2 + v^2 gives theta_3, two angles; then u, v give theta_2
//! ```
//! u, v: coordinates of the wrist centre in the plane normal to axis 2; (x, y): the wrist centre in frame 3. In the class of
//! parallel axes, both are for the origin O_4, and (x, y) = (d_4, 0). If joint 3 is prismatic, u^2 + v^2 gives r_3, with two
//! signs. The wrist angles follow from the direction of axis 6, with two signs of sin theta_5. In the class of parallel axes, the
//! wrist angles are computed before theta_3, because they determine O_4.
//!
//! At singular poses there are solutions too. No angle is computed from a quotient of differences that may vanish: one of theta_4
//! and theta_6 is the direction of a vector, and the other follows from the remaining orientation. If this vector is shorter than
//! 1e-13, it is only rounding (axis 6 along axis 4 or along the parallel axes, or W on axis 1 or 2). Then its angle is free, and
//! the coordinate q is set to 0. The angles of a triangle with sides A, B, c follow from Heron's formula, a root of four factors
//! that are sums and differences of lengths. A factor that is negative by less than 1e-13 m is set to zero: the arm is stretched
//! or folded.
//!
//! In the class of parallel axes, a free theta_6 moves O_4 about O_5. Solutions with one sign of sin theta_5 get q_6 = 0.
//! Solutions with the other sign move O_4 as near to axis 2 as possible or, if that is too near, as far from it as possible. So
//! if the pose can be reached, at least one solution is found (for arms with |r_5| below the shorter of d_3 and d_4). If the
//! vector for theta_6 is slightly longer than 1e-13, rounding still changes theta_6, and a nearly stretched arm would not reach
//! O_4. So theta_6 is shifted towards the angle at which O_4 is reached; the shift is below the rounding of the last link's
//! orientation.
//!
//! The outputs are sines and cosines: q = atan2(sin_q, cos_q). If a solution cannot be reached, its entries are NaN.

use expr::{Expr, Function, Graph, Input, Output, SymbolKind};
use robot::Pose;

use crate::inverse_arm::{Arm, ArmJoint, Class, NoClosedForm, chain};
use crate::inverse_turns::{between, direction, norm, root, unit_turn};
use modeling::Derivation;
use modeling::LinkFrame;
use modeling::building::{Placement, Vector, ZRotation, add, constants, dot};

/// Number of solutions of an arm.
const SOLUTIONS: usize = 8;
/// theta_6 is shifted by this fraction of the vector that gives theta_6, towards the angle at which O_4 is reached.
const SHIFT_SHARE: f64 = 1e-14;

/// One solution: the angle theta of each joint, including its offset, and r_3 if joint 3 is prismatic.
struct Solution {
    turns: [ZRotation; 6],
    slide: Expr,
}

/// The inverse geometric model of the arm that ends with a frame. Input `t` (3 x 4): pose of the frame in the base. Outputs
/// `sin_q`, `cos_q` (8 x 6): one row per solution, one column per joint of the arm; NaN if the pose cannot be reached. At a
/// singular pose, the free angle is 0. If a joint is prismatic, its coordinate is in a third output `slide` (8), and its sine and
/// cosine are 0 and 1.
///
/// Fails if the arm has none of the closed forms of the module `inverse_arm`.
pub fn inverse_geometry(derivation: &mut Derivation, frame: impl Into<LinkFrame>) -> Result<Function, NoClosedForm> {
    let frame = &frame.into();
    let arm = Arm::new(derivation, frame.link)?;
    let chain = chain(derivation.robot(), frame.link);
    // b of link 2 is a length along axis 1. It does not change when joint 1 rotates, so it is subtracted from the target.
    let second = chain.get(1).map_or(Expr::ZERO, |&j| derivation.geometry(j).b);
    let last = derivation.geometry(frame.link).r;
    let first = derivation.placement(chain[0]).clone();
    let g = derivation.graph();
    let t: Vec<Expr> = (0..12).map(|k| g.symbol(&format!("T{}{}", k / 4 + 1, k % 4 + 1), SymbolKind::Input)).collect();
    let mut target = Target::new(g, &t, frame, &first);
    target.p[2] = g.sub(target.p[2], second);
    let target = if arm.is_reversed { target.reversed(g, last) } else { target };
    let joints = &arm.joints;
    let (mut sines, mut cosines) = (vec![Expr::ZERO; SOLUTIONS * 6], vec![Expr::ZERO; SOLUTIONS * 6]);
    let mut slides = Vec::new();
    // The eight solutions differ in the signs of three roots: for theta_1, for theta_3 (or r_3), and for sin theta_5.
    for k in 0..SOLUTIONS {
        let signs = [0, 1, 2].map(|bit| k >> bit & 1 == 1);
        let solution = match arm.class {
            Class::Wrist | Class::WristOfSlide => with_wrist(g, joints, &target, signs, arm.class),
            Class::ParallelAxes => with_parallel_axes(g, joints, &target, signs),
        };
        for (joint, turn) in joints.iter().zip(solution.turns) {
            if joint.slides {
                // The joint variable is r = r_3 + q or r_3 - q, so the coordinate is q = +-(r - r_3).
                let q = g.sub(solution.slide, joint.r);
                slides.push(if joint.sign < 0.0 { -q } else { q });
                cosines[6 * k + joint.column] = Expr::ONE;
                continue;
            }
            // The joint variable is theta = offset + q or offset - q, so the coordinate is q = +-(theta - offset).
            let back = joint.offset.negated().turn(g);
            let turn = together(g, turn, back);
            sines[6 * k + joint.column] = if joint.sign < 0.0 { -turn.sin } else { turn.sin };
            cosines[6 * k + joint.column] = turn.cos;
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

/// The desired pose of the last link, expressed in the frame before the rotation of joint 1.
struct Target {
    /// Columns x, y, z of the orientation matrix. `p`: position of the origin, m.
    x: Vector,
    y: Vector,
    z: Vector,
    p: Vector,
}

impl Target {
    fn new(g: &mut Graph, t: &[Expr], frame: &LinkFrame, placement: &Placement) -> Target {
        let column = |c: usize| [t[c], t[4 + c], t[8 + c]];
        let Pose { rotation, position } = frame.pose.inverse();
        // T_0j = T_0f T_fj: the pose of the last link j follows from the pose of the given frame f, which is fixed to it.
        let mut combined = |v: [f64; 3]| {
            let v = constants(g, v);
            [0, 1, 2].map(|r| dot(g, v, [t[4 * r], t[4 * r + 1], t[4 * r + 2]]))
        };
        let axes = [0, 1, 2].map(|c| combined([rotation[0][c], rotation[1][c], rotation[2][c]]));
        let p = combined(position);
        let p = add(g, p, column(3));
        let from_first: Vector = std::array::from_fn(|i| g.sub(p[i], placement.p[i]));
        let [x, y, z] = axes.map(|axis| placement.to_link_before_theta(g, axis));
        Target { x, y, z, p: placement.to_link_before_theta(g, from_first) }
    }

    /// The inverse pose, for an arm that is traversed from its end: pose of the frame before joint 1 in the frame of the last
    /// link, moved by r_6 along axis 6.
    fn reversed(&self, g: &mut Graph, r: Expr) -> Target {
        let Target { x, y, z, p } = *self;
        let mut along = |axis: Vector| -dot(g, axis, p);
        let [px, py, pz] = [along(x), along(y), along(z)];
        Target { x: [x[0], y[0], z[0]], y: [x[1], y[1], z[1]], z: [x[2], y[2], z[2]], p: [px, py, g.add(pz, r)] }
    }

    /// The position before the shift r along axis 6: the point on axis 6 at the distance -r from the origin of the last frame.
    fn before(&self, g: &mut Graph, r: Expr) -> Vector {
        let shift = self.z.map(|z| g.mul(r, z));
        std::array::from_fn(|i| g.sub(self.p[i], shift[i]))
    }
}

/// Two results: theta_1, such that W has the component h along axis 2, -S1 W_x + C1 W_y = -sin(alpha_2) h (S1, C1: sine and
/// cosine of theta_1); and the component of W along x of frame 1, C1 W_x + S1 W_y.
fn first_turn(g: &mut Graph, [one, two]: [&ArmJoint; 2], W: Vector, h: Expr, is_other: bool) -> (ZRotation, Expr) {
    let b = signed(h, -two.sine());
    let distance = norm(g, [W[0], W[1]]);
    let root = if h.is_zero() {
        distance
    } else {
        let size = norm(g, [h, Expr::ZERO]);
        let (spare, sum) = (g.sub(distance, size), g.add(distance, size));
        root(g, &[spare], &[sum])
    };
    let a = if is_other { -root } else { root };
    // a: component of W along x of frame 1, C1 W_x + S1 W_y.
    let turn = between(g, [W[0], W[1]], [a, b]);
    let free = one.offset.turn(g);
    (direction(g, turn, distance, free), a)
}

/// theta_2 and theta_3 that move the point (x, y) of frame 3 to (u, v). All are in the plane normal to axis 2.
fn arm_turns(
    g: &mut Graph,
    [two, three]: [&ArmJoint; 2],
    point: [Expr; 2],
    to: [Expr; 2],
    is_other: bool,
) -> [ZRotation; 2] {
    // A triangle has the sides A = |d|, B = |(x, y)| and c = |(u, v)|. With X = d + x C3 - y S3 and l = x S3 + y C3 (S3, C3: sine
    // and cosine of theta_3): 2 d X = c^2 + (A + B) (A - B), 4 d^2 l^2 = (A + B - c) (c - |A - B|) (A + B + c) (c + |A - B|).
    let d = three.d;
    let (A, B, c) = (norm(g, [d, Expr::ZERO]), norm(g, point), norm(g, to));
    let (sum, difference) = (g.add(A, B), g.sub(A, B));
    let size = norm(g, [difference, Expr::ZERO]);
    let spare = [g.sub(sum, c), g.sub(c, size)];
    let others = [g.add(sum, c), g.add(c, size)];
    let root = root(g, &spare, &others);
    let (cc, sides, number) = (g.mul(c, c), g.mul(sum, difference), g.constant(2.0));
    let (above, [twice, twice_size]) = (g.add(cc, sides), [d, A].map(|e| g.mul(number, e)));
    let (X, l) = (g.div(above, twice), g.div(if is_other { -root } else { root }, twice_size));
    let k = g.sub(X, d);
    let [cos, sin] = between(g, [k, l], point);
    let third = unit_turn(g, cos, sin);
    let (turn, free) = (between(g, to, [X, l]), two.offset.turn(g));
    [direction(g, turn, c, free), third]
}

/// theta_2 and r that move the point (d, -sin(alpha_3) r) of frame 2 to (u, v). r follows from r^2 = u^2 + v^2 - d^2.
fn slide(g: &mut Graph, [two, three]: [&ArmJoint; 2], to: [Expr; 2], is_other: bool) -> (ZRotation, Expr) {
    let (distance, size) = (norm(g, to), norm(g, [three.d, Expr::ZERO]));
    let (spare, sum) = (g.sub(distance, size), g.add(distance, size));
    let root = root(g, &[spare], &[sum]);
    let y = if is_other { -root } else { root };
    let (turn, free) = (between(g, to, [three.d, y]), two.offset.turn(g));
    (direction(g, turn, distance, free), signed(y, -three.sine()))
}

/// Coordinates u, v (m) of a point in the plane normal to axis 2. `a`: component of the point along x of frame 1. `height`:
/// component of the point along axis 1.
fn in_plane(g: &mut Graph, two: &ArmJoint, a: Expr, height: Expr) -> [Expr; 2] {
    let v = if two.sine() > 0.0 { height } else { -height };
    [g.sub(a, two.d), v]
}

fn with_wrist(
    g: &mut Graph,
    joints: &[ArmJoint; 6],
    target: &Target,
    [one, three, five]: [bool; 3],
    class: Class,
) -> Solution {
    let [j1, j2, j3, j4, j5, j6] = joints;
    let W = target.before(g, j6.r);
    let unturned = ZRotation { cos: Expr::ONE, sin: Expr::ZERO };
    let slides = class == Class::WristOfSlide;
    let h = if slides { j2.r } else { g.add(j2.r, j3.r) };
    let (first, a) = first_turn(g, [j1, j2], W, h, one);
    let place = in_plane(g, j2, a, W[2]);
    let (second, third, length) = if slides {
        let (second, length) = slide(g, [j2, j3], place, three);
        // If axis 4 is along the slide, r_4 is the distance of the wrist centre from O_3. It is subtracted from the length.
        let behind = if j4.is_across() { Expr::ZERO } else { j4.r };
        // Joint 3 is prismatic and does not rotate: its theta is the constant offset.
        let fixed = j3.offset.turn(g);
        (second, fixed, g.sub(length, behind))
    } else {
        // In frame 3, the wrist centre is at (d_4, -r_4 sin alpha_4, 0).
        let y = signed(j4.r, -j4.sine());
        let [second, third] = arm_turns(g, [j2, j3], [j4.d, y], place, three);
        (second, third, Expr::ZERO)
    };

    // The axes x, y, z of the last link: they are rotated into frame 3, and then into the frame before the rotation by theta_4.
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
    // In this frame, z_6 = (C4 s6 S5, S4 s6 S5, -s5 s6 C5): C4, S4, ..: cosine and sine of theta_4, ..; s5, s6: sin(alpha_5),
    // sin(alpha_6). After the rotation by -theta_4, the components of the axes along y are (-s5 s6 S6, -s5 s6 C6, 0).
    let size = norm(g, [z[0], z[1]]);
    let sign = if five { -s6 } else { s6 };
    let free = j4.offset.turn(g);
    let fourth = direction(g, [signed(z[0], sign), signed(z[1], sign)], size, free);
    let [x, y, z] = [x, y, z].map(|axis| fourth.turned(g, axis));
    let fifth = ZRotation { cos: signed(z[2], -s5 * s6), sin: signed(z[0], s6) };
    let sixth = ZRotation { cos: signed(y[1], -s5 * s6), sin: signed(x[1], -s5 * s6) };
    let third = if slides { unturned } else { third };
    Solution { turns: [first, second, third, fourth, fifth, sixth], slide: length }
}

fn with_parallel_axes(
    g: &mut Graph,
    joints: &[ArmJoint; 6],
    target: &Target,
    [one, three, five]: [bool; 3],
) -> Solution {
    let [j1, j2, j3, j4, j5, j6] = joints;
    let W = target.before(g, j6.r);
    let (r, s2) = (g.add(j2.r, j3.r), j2.sine());
    let h = g.add(r, j4.r);
    let (first, a) = first_turn(g, [j1, j2], W, h, one);

    // Axis 4 is (sin(alpha_2) S1, -sin(alpha_2) C1, 0) (S1, C1, ..: sine and cosine of theta_1, ..). In frame 6 it is (s5 S5 C6,
    // -s5 S5 S6, -s5 s6 C5), s5 and s6: sin(alpha_5) and sin(alpha_6).
    let axis = [signed(first.sin, s2), signed(first.cos, -s2), Expr::ZERO];
    let seen = [target.x, target.y, target.z].map(|column| dot(g, axis, column));
    let (s5, s6) = (j5.sine(), j6.sine());
    let (size, sign) = (norm(g, [seen[0], seen[1]]), if five { -s5 } else { s5 });
    let to = [signed(seen[0], sign), signed(seen[1], -sign)];
    let reach = reaching(g, joints, target, first, [a, W[2]]);
    let (to, free) = (leaning(g, to, reach), if five { reach } else { j6.offset.turn(g) });
    let sixth = direction(g, to, size, free);
    let [S5, _] = between(g, [seen[0], -seen[1]], [sixth.cos, sixth.sin]);
    let fifth = ZRotation { cos: signed(seen[2], -s5 * s6), sin: signed(S5, s5) };

    // Axis 5 is z_5 = s6 (S6 x_6 + C6 y_6). It gives y_4 = -s5 z_5, and the origin O_4 = O_5 - r_5 z_5.
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
    let all = ZRotation { cos: y4[1], sin: -y4[0] };
    let place = in_plane(g, j2, at[0], O4[2]);
    let [second, third] = arm_turns(g, [j2, j3], [j4.d, Expr::ZERO], place, three);
    let both = together(g, second, third);
    let fourth = together(g, all, ZRotation { cos: both.cos, sin: -both.sin });
    Solution { turns: [first, second, third, fourth, fifth, sixth], slide: Expr::ZERO }
}

/// A vector with the angle theta_6, for the case that axis 6 is along the parallel axes and theta_6 is free. It moves O_4 = O_5 -
/// r_5 z_5 as near to axis 2 as possible; but as far as possible if the nearest point is too near for the arm (nearer than |A -
/// B|, A and B: lengths of links 2 and 3). `at`: coordinates of O_5 along x of frame 1 and along axis 1, m.
fn reaching(g: &mut Graph, joints: &[ArmJoint; 6], target: &Target, first: ZRotation, at: [Expr; 2]) -> ZRotation {
    let [_, j2, j3, j4, j5, j6] = joints;
    if j5.r.is_zero() {
        return j6.offset.turn(g);
    }
    let from = [g.sub(at[0], j2.d), at[1]];
    let sizes = [from, [j5.r, Expr::ZERO], [j3.d, Expr::ZERO], [j4.d, Expr::ZERO]].map(|v| norm(g, v));
    let apart = [(sizes[0], sizes[1]), (sizes[2], sizes[3])].map(|(a, b)| {
        let difference = g.sub(a, b);
        norm(g, [difference, Expr::ZERO])
    });
    let room = g.sub(apart[0], apart[1]);
    let along = g.mul(room, j5.r);
    let outward = first.unturned(g, [from[0], Expr::ZERO, from[1]]);
    // From z_5 = s6 (S6 x_6 + C6 y_6): the products of the direction to O_5 with x_6 and y_6 give S6 and C6.
    let [sin, cos] = [target.x, target.y].map(|axis| {
        let part = dot(g, outward, axis);
        signed(g.mul(along, part), j6.sine())
    });
    ZRotation { cos, sin }
}

/// Adds [`SHIFT_SHARE`] times the unit vector `to` to the vector (cos, sin), which gives the direction of theta_6. `to` is the
/// direction at which the origin O_4 of frame 4 is within reach.
///
/// If (cos, sin) is not short, the shift changes the orientation by less than rounding does. If (cos, sin) is very short, its
/// direction is mostly rounding, which could put O_4 out of reach. The shift is larger than this rounding and prevents this.
fn leaning(g: &mut Graph, [cos, sin]: [Expr; 2], to: ZRotation) -> [Expr; 2] {
    let share = g.constant(SHIFT_SHARE);
    [(cos, to.cos), (sin, to.sin)].map(|(own, to)| {
        let part = g.mul(share, to);
        g.add(own, part)
    })
}

/// The sum of two angles, each given by its sine and cosine.
fn together(g: &mut Graph, a: ZRotation, b: ZRotation) -> ZRotation {
    let [cc, ss, sc, cs] = [(a.cos, b.cos), (a.sin, b.sin), (a.sin, b.cos), (a.cos, b.sin)].map(|(a, b)| g.mul(a, b));
    ZRotation { cos: g.sub(cc, ss), sin: g.add(sc, cs) }
}

/// The vector v rotated about x by a number of quarter turns.
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
