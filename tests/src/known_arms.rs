//! Known robot arms. Their descriptions are made from published kinematics and limits.
//!
//! The lengths of the four Universal Robots arms, and all numbers of the two iiwa, were compared with public programs
//! (2026-11-22). The numbers of the other five arms, and the velocities of Universal Robots, are from memory and were not
//! checked. The kinematics are standard Denavit-Hartenberg: Rz(theta) Tz(d) Tx(a) Rx(alpha). A constant that is added to theta is
//! included in the position limits. Masses and effort limits are omitted, because most manufacturers do not publish them.

use std::fmt::Write;

/// A joint: d and a, m; alpha, lowest and highest theta, degrees; largest velocity, degrees/s.
type JointRow = [f64; 6];

pub struct KnownArm {
    pub name: &'static str,
    /// Rotation of the first frame about the x axis of the base, degrees.
    base_alpha: f64,
    joints: &'static [JointRow],
}

const fn arm(name: &'static str, base_alpha: f64, joints: &'static [JointRow]) -> KnownArm {
    KnownArm { name, base_alpha, joints }
}

/// Four Universal Robots arms, and arms of KUKA, ABB, Staubli, UFactory and Kinova. A joint without position limits gets a range
/// of two turns.
pub const KNOWN_ARMS: [KnownArm; 11] = [
    arm(
        "ur3e",
        0.0,
        &[
            [0.15185, 0.0, 90.0, -360.0, 360.0, 180.0],
            [0.0, -0.24355, 0.0, -360.0, 360.0, 180.0],
            [0.0, -0.2132, 0.0, -360.0, 360.0, 180.0],
            [0.13105, 0.0, 90.0, -360.0, 360.0, 360.0],
            [0.08535, 0.0, -90.0, -360.0, 360.0, 360.0],
            [0.0921, 0.0, 0.0, -360.0, 360.0, 360.0],
        ],
    ),
    arm(
        "ur5e",
        0.0,
        &[
            [0.1625, 0.0, 90.0, -360.0, 360.0, 180.0],
            [0.0, -0.425, 0.0, -360.0, 360.0, 180.0],
            [0.0, -0.3922, 0.0, -360.0, 360.0, 180.0],
            [0.1333, 0.0, 90.0, -360.0, 360.0, 180.0],
            [0.0997, 0.0, -90.0, -360.0, 360.0, 180.0],
            [0.0996, 0.0, 0.0, -360.0, 360.0, 180.0],
        ],
    ),
    arm(
        "ur10e",
        0.0,
        &[
            [0.1807, 0.0, 90.0, -360.0, 360.0, 120.0],
            [0.0, -0.6127, 0.0, -360.0, 360.0, 120.0],
            [0.0, -0.57155, 0.0, -360.0, 360.0, 180.0],
            [0.17415, 0.0, 90.0, -360.0, 360.0, 180.0],
            [0.11985, 0.0, -90.0, -360.0, 360.0, 180.0],
            [0.11655, 0.0, 0.0, -360.0, 360.0, 180.0],
        ],
    ),
    arm(
        "ur16e",
        0.0,
        &[
            [0.1807, 0.0, 90.0, -360.0, 360.0, 120.0],
            [0.0, -0.4784, 0.0, -360.0, 360.0, 120.0],
            [0.0, -0.36, 0.0, -360.0, 360.0, 180.0],
            [0.17415, 0.0, 90.0, -360.0, 360.0, 180.0],
            [0.11985, 0.0, -90.0, -360.0, 360.0, 180.0],
            [0.11655, 0.0, 0.0, -360.0, 360.0, 180.0],
        ],
    ),
    arm(
        "iiwa7_r800",
        0.0,
        &[
            [0.34, 0.0, -90.0, -170.0, 170.0, 98.0],
            [0.0, 0.0, 90.0, -120.0, 120.0, 98.0],
            [0.4, 0.0, 90.0, -170.0, 170.0, 100.0],
            [0.0, 0.0, -90.0, -120.0, 120.0, 130.0],
            [0.4, 0.0, -90.0, -170.0, 170.0, 140.0],
            [0.0, 0.0, 90.0, -120.0, 120.0, 180.0],
            [0.126, 0.0, 0.0, -175.0, 175.0, 180.0],
        ],
    ),
    arm(
        "iiwa14_r820",
        0.0,
        &[
            [0.36, 0.0, -90.0, -170.0, 170.0, 85.0],
            [0.0, 0.0, 90.0, -120.0, 120.0, 85.0],
            [0.42, 0.0, 90.0, -170.0, 170.0, 100.0],
            [0.0, 0.0, -90.0, -120.0, 120.0, 75.0],
            [0.4, 0.0, -90.0, -170.0, 170.0, 130.0],
            [0.0, 0.0, 90.0, -120.0, 120.0, 135.0],
            [0.126, 0.0, 0.0, -175.0, 175.0, 135.0],
        ],
    ),
    arm(
        "irb120",
        0.0,
        &[
            [0.29, 0.0, -90.0, -165.0, 165.0, 250.0],
            [0.0, 0.27, 0.0, -200.0, 20.0, 250.0],
            [0.0, 0.07, -90.0, -110.0, 70.0, 250.0],
            [0.302, 0.0, 90.0, -160.0, 160.0, 320.0],
            [0.0, 0.0, -90.0, -120.0, 120.0, 320.0],
            [0.072, 0.0, 0.0, -400.0, 400.0, 420.0],
        ],
    ),
    arm(
        "kr6_r900",
        0.0,
        &[
            [0.4, 0.025, -90.0, -170.0, 170.0, 360.0],
            [0.0, 0.455, 0.0, -190.0, 45.0, 300.0],
            [0.0, 0.035, -90.0, -210.0, 66.0, 360.0],
            [0.42, 0.0, 90.0, -185.0, 185.0, 381.0],
            [0.0, 0.0, -90.0, -120.0, 120.0, 388.0],
            [0.08, 0.0, 0.0, -350.0, 350.0, 615.0],
        ],
    ),
    arm(
        "tx90",
        0.0,
        &[
            [0.478, 0.05, -90.0, -180.0, 180.0, 400.0],
            [0.0, 0.425, 0.0, -220.0, 57.5, 400.0],
            [0.05, 0.0, 90.0, -55.0, 235.0, 430.0],
            [0.425, 0.0, -90.0, -270.0, 270.0, 540.0],
            [0.0, 0.0, 90.0, -115.0, 140.0, 475.0],
            [0.1, 0.0, 0.0, -270.0, 270.0, 760.0],
        ],
    ),
    arm(
        "xarm6",
        0.0,
        &[
            [0.267, 0.0, -90.0, -360.0, 360.0, 180.0],
            [0.0, 0.28949, 0.0, -197.35, 40.65, 180.0],
            [0.0, 0.0775, -90.0, -145.65, 90.35, 180.0],
            [0.3425, 0.0, 90.0, -360.0, 360.0, 180.0],
            [0.0, 0.076, -90.0, -97.0, 180.0, 180.0],
            [0.097, 0.0, 0.0, -360.0, 360.0, 180.0],
        ],
    ),
    arm(
        "gen3_7dof",
        180.0,
        &[
            [-0.2848, 0.0, 90.0, -360.0, 360.0, 79.64],
            [-0.0118, 0.0, 90.0, 51.1, 308.9, 79.64],
            [-0.4208, 0.0, 90.0, -180.0, 540.0, 79.64],
            [-0.0128, 0.0, 90.0, 32.2, 327.8, 79.64],
            [-0.3143, 0.0, 90.0, -180.0, 540.0, 69.91],
            [0.0, 0.0, 90.0, 59.7, 300.3, 69.91],
            [-0.1674, 0.0, 180.0, -180.0, 540.0, 69.91],
        ],
    ),
];

pub struct PlacedJoint {
    /// Origin of the joint in the frame of the previous joint, m.
    pub origin: [f64; 3],
    /// Rotation of the joint frame about x, rad.
    pub alpha: f64,
    /// Lowest and highest position, rad.
    pub range: (f64, f64),
    /// Largest velocity, rad/s.
    pub velocity: f64,
    /// Origin of the next joint, in the frame of this joint, m.
    pub end: [f64; 3],
}

impl KnownArm {
    /// The joints of the arm, each placed in the frame of the previous joint. Tz(d) Tx(a) Rx(alpha) of a joint give the origin
    /// and the rotation of the next joint.
    pub fn placed(&self) -> Vec<PlacedJoint> {
        let (mut origin, mut turn) = ([0.0; 3], self.base_alpha);
        let mut placed = Vec::new();
        for [d, a, alpha, low, high, velocity] in self.joints.iter().copied() {
            let end = [a, 0.0, d];
            let [low, high, velocity] = [low, high, velocity].map(f64::to_radians);
            placed.push(PlacedJoint { origin, alpha: turn.to_radians(), range: (low, high), velocity, end });
            (origin, turn) = (end, alpha);
        }
        placed
    }

    /// The URDF of the arm, without inertial parameters and shapes.
    pub fn urdf(&self) -> String {
        let mut text = format!("<robot name=\"{}\">\n  <link name=\"base\"/>\n", self.name);
        let mut parent = "base".to_string();
        for (i, joint) in self.placed().into_iter().enumerate() {
            let (name, [x, _, z], (low, high)) = (i + 1, joint.origin, joint.range);
            // Writing to a `String` cannot fail, so the result is ignored.
            let _ = write!(
                text,
                "  <link name=\"link{name}\"/>\n  <joint name=\"joint{name}\" type=\"revolute\">\n    <parent \
                 link=\"{parent}\"/><child link=\"link{name}\"/>\n    <origin xyz=\"{x} 0 {z}\" rpy=\"{} 0 0\"/><axis xyz=\"0 0 \
                 1\"/>\n    <limit lower=\"{low}\" upper=\"{high}\" velocity=\"{}\" effort=\"0\"/>\n  </joint>\n",
                joint.alpha, joint.velocity,
            );
            parent = format!("link{name}");
        }
        text + "</robot>\n"
    }
}
