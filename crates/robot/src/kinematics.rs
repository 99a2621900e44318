//! Forward kinematics in f64: computes the pose of every link frame in the base frame.
//!
//! iTj = Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r)  [Khalil, Kleinfinger 1986]. Its rotation R_ij and position p_ij
//! (sg, cg: sine and cosine of gamma; sa, ca: of alpha; st, ct: of theta):
//! R_ij = [ cg ct - sg ca st   -cg st - sg ca ct    sg sa ]   p_ij = [ cg d + sg sa r ]
//!        [ sg ct + cg ca st   -sg st + cg ca ct   -cg sa ]          [ sg d - cg sa r ]
//!        [ sa st               sa ct               ca    ]          [ ca r + b       ]

use crate::inertial::Pose;
use crate::robot::{JointKind, LoopFrame, ModifiedDh, Robot};
use crate::value::{Symbol, Value};

impl ModifiedDh {
    /// The transform iTj. `angle` (rad) is added to theta, and `length` (m) is added to r.
    pub fn pose(&self, symbols: &[Symbol], angle: f64, length: f64) -> Pose {
        let (sg, cg) = sin_cos(&self.gamma, symbols);
        let (sa, ca) = sin_cos(&self.alpha, symbols);
        let (s0, c0) = sin_cos(&self.theta, symbols);
        let (s1, c1) = angle.sin_cos();
        let (st, ct) = (s0 * c1 + c0 * s1, c0 * c1 - s0 * s1);
        let [b, d, r] = [&self.b, &self.d, &self.r].map(|v| v.number(symbols));
        let r = r + length;
        Pose {
            rotation: [
                [cg * ct - sg * ca * st, -cg * st - sg * ca * ct, sg * sa],
                [sg * ct + cg * ca * st, -sg * st + cg * ca * ct, -cg * sa],
                [sa * st, sa * ct, ca],
            ],
            position: [cg * d + sg * sa * r, sg * d - cg * sa * r, ca * r + b],
        }
    }
}

/// Sine and cosine of an angle in rad. If the expression of the angle is a multiple of pi/2, they are exactly 0, 1 or -1.
pub fn sin_cos(angle: &Value, symbols: &[Symbol]) -> (f64, f64) {
    if let Some((n, d)) = angle.as_multiple_of_pi(symbols)
        && 2 % d == 0
        && let Some(quarters) = n.checked_mul(2 / d)
    {
        return [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarters.rem_euclid(4) as usize];
    }
    angle.number(symbols).sin_cos()
}

impl Robot {
    /// Pose of every link frame in the base frame, in the order of the links. `q`: values of the coordinates and passive
    /// coordinates, [`Robot::n_variables`] entries, rad (m).
    pub fn link_poses(&self, q: &[f64]) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let (angle, length) = split(link.joint.kind, link.joint.variable.number(q, &self.symbols));
            let ahead = link.geometry.pose(&self.symbols, angle, length);
            poses.push(match link.antecedent {
                Some(i) => poses[i.0].compose(&ahead),
                None => ahead,
            });
        }
        poses
    }

    /// Pose of a loop frame in the base frame. `poses`: poses of the links at `q`.
    pub(crate) fn loop_frame_pose(&self, frame: &LoopFrame, poses: &[Pose], q: &[f64]) -> Pose {
        let (angle, length) = split(frame.kind, frame.variable.number(q, &self.symbols));
        let ahead = frame.geometry.pose(&self.symbols, angle, length);
        frame.antecedent.map_or(ahead, |i| poses[i.0].compose(&ahead))
    }
}

/// The part of a joint variable that is added to theta (rad) and the part that is added to r (m).
fn split(kind: JointKind, variable: f64) -> (f64, f64) {
    match kind {
        JointKind::Revolute => (variable, 0.0),
        JointKind::Prismatic => (0.0, variable),
        JointKind::Fixed => (0.0, 0.0),
    }
}
