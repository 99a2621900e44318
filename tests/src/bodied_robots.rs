//! Twenty robots with inertial parameters and collision bodies: known arms, and other machines.
//!
//! Each link is a rod: a cylinder from its joint to the next joint, shorter at both ends, with some kilograms per metre. The arms
//! have the kinematics of [`crate::known_arms`]; the other machines are invented.

use std::fmt::Write;

use crate::known_arms::{KNOWN_ARMS, KnownArm};

pub struct BodiedRobot {
    pub name: &'static str,
    pub is_arm: bool,
    joints: Vec<Rod>,
}

/// A joint with the rod that it moves. Lengths in m, angles in rad.
struct Rod {
    /// Index of the parent joint; `None`: the base.
    parent: Option<usize>,
    slides: bool,
    origin: [f64; 3],
    rpy: [f64; 3],
    axis: [f64; 3],
    range: (f64, f64),
    velocity: f64,
    effort: f64,
    /// Position of the end of the rod in the frame of the joint, m.
    end: [f64; 3],
    radius: f64,
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
/// Mass of a rod: mass per length, kg/m, and an additional mass, kg.
const MASS: (f64, f64) = (6.0, 0.3);

impl Rod {
    fn turning(parent: Option<usize>, origin: [f64; 3], axis: [f64; 3], range: f64, end: [f64; 3]) -> Rod {
        let (rpy, velocity, effort, radius) = ([0.0; 3], 2.0, 150.0, 0.02);
        Rod { parent, slides: false, origin, rpy, axis, range: (-range, range), velocity, effort, end, radius }
    }

    fn sliding(parent: Option<usize>, origin: [f64; 3], axis: [f64; 3], range: f64, end: [f64; 3]) -> Rod {
        Rod { slides: true, velocity: 0.5, effort: 400.0, ..Rod::turning(parent, origin, axis, range, end) }
    }

    fn length(&self) -> f64 {
        self.end.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

fn arm(known: &KnownArm) -> BodiedRobot {
    let rod = |(i, joint): (usize, crate::known_arms::PlacedJoint)| Rod {
        parent: i.checked_sub(1),
        slides: false,
        origin: joint.origin,
        rpy: [joint.alpha, 0.0, 0.0],
        axis: Z,
        range: joint.range,
        velocity: joint.velocity,
        effort: if i < 3 { 250.0 } else { 80.0 },
        end: joint.end,
        radius: 0.04,
    };
    BodiedRobot { name: known.name, is_arm: true, joints: known.placed().into_iter().enumerate().map(rod).collect() }
}

/// Adds a chain of revolute joints with rods to `joints`. `parent`: index of the joint that carries the chain.
fn limb(joints: &mut Vec<Rod>, parent: Option<usize>, origin: [f64; 3], links: &[([f64; 3], f64, [f64; 3])]) {
    let (mut parent, mut origin) = (parent, origin);
    for (axis, range, end) in links {
        joints.push(Rod::turning(parent, origin, *axis, *range, *end));
        (parent, origin) = (Some(joints.len() - 1), *end);
    }
}

fn machine(name: &'static str, joints: Vec<Rod>) -> BodiedRobot {
    BodiedRobot { name, is_arm: false, joints }
}

pub fn bodied_robots() -> Vec<BodiedRobot> {
    let mut all: Vec<BodiedRobot> = KNOWN_ARMS.iter().map(arm).collect();
    // In a SCARA, the quill is fixed to the second link.
    let mut scara = Vec::new();
    limb(&mut scara, None, [0.0, 0.0, 0.4], &[(Z, 2.2, [0.3, 0.0, 0.0]), (Z, 2.4, [0.25, 0.0, 0.0])]);
    scara.push(Rod::sliding(Some(1), [0.25, 0.0, 0.05], Z, 0.08, [0.0, 0.0, -0.15]));
    limb(&mut scara, Some(2), [0.0, 0.0, -0.16], &[(Z, 3.0, [0.04, 0.0, -0.02])]);
    all.push(BodiedRobot { is_arm: true, ..machine("rod_scara", scara) });
    let mut gantry = vec![
        Rod::sliding(None, [0.0, 0.0, 1.0], X, 0.4, [0.0, 0.3, 0.0]),
        Rod::sliding(Some(0), [0.0, 0.15, -0.08], Y, 0.1, [0.0, 0.0, 0.02]),
        Rod::sliding(Some(1), [0.05, 0.0, 0.0], Z, 0.2, [0.0, 0.0, -0.3]),
    ];
    limb(&mut gantry, Some(2), [0.0, 0.0, -0.34], &[(Z, 3.0, [0.1, 0.0, 0.0])]);
    all.push(machine("rod_gantry", gantry));
    let mut hand = Vec::new();
    for k in 0..3 {
        let finger = [(X, 0.4, [0.0, 0.0, 0.05]), (Y, 0.9, [0.0, 0.0, 0.06]), (Y, 1.2, [0.0, 0.0, 0.05])];
        limb(&mut hand, None, [0.0, 0.08 * f64::from(k) - 0.08, 0.1], &finger);
    }
    hand.iter_mut().for_each(|rod| (rod.radius, rod.effort) = (0.01, 5.0));
    all.push(machine("rod_hand", hand));
    let mut beast = Vec::new();
    for (x, y) in [(0.25, 0.15), (0.25, -0.15), (-0.25, 0.15), (-0.25, -0.15)] {
        let leg = [(X, 0.5, [0.0, 0.4 * y, 0.0]), (Y, 1.0, [0.0, 0.0, -0.25]), (Y, 2.0, [0.0, 0.0, -0.25])];
        limb(&mut beast, None, [x, y, 0.8], &leg);
    }
    all.push(machine("rod_quadruped", beast));
    let mut torso = vec![Rod::turning(None, [0.0, 0.0, 0.3], Z, 1.0, [0.0, 0.0, 0.4])];
    for y in [0.2, -0.2] {
        let arm = [(Y, 2.0, [0.0, 0.3 * y, 0.0]), (X, 1.2, [0.0, 0.0, -0.25]), (Y, 1.8, [0.0, 0.0, -0.25])];
        limb(&mut torso, Some(0), [0.0, y, 0.4], &arm);
    }
    all.push(machine("rod_torso", torso));
    let mut head = Vec::new();
    limb(&mut head, None, [0.0, 0.0, 0.2], &[(Z, 2.5, [0.0, 0.0, 0.1]), (Y, 0.8, [0.15, 0.0, 0.0])]);
    all.push(machine("rod_head", head));
    let mut cart = vec![Rod::sliding(None, [0.0, 0.0, 0.6], X, 0.8, [0.0, 0.1, 0.0])];
    limb(&mut cart, Some(0), [0.0, 0.15, 0.0], &[(Y, 3.0, [0.0, 0.0, -0.4])]);
    all.push(machine("rod_cart", cart));
    let mut pendulum = Vec::new();
    limb(&mut pendulum, None, [0.0, 0.1, 1.0], &[(Y, 3.0, [0.0, 0.0, -0.4]), (Y, 3.0, [0.0, 0.06, -0.4])]);
    all.push(machine("rod_pendulum", pendulum));
    let mut digger = Vec::new();
    let boom =
        [(Z, 2.5, [0.0, 0.0, 0.2]), (Y, 0.8, [0.6, 0.0, 0.2]), (Y, 1.2, [0.5, 0.0, 0.0]), (Y, 1.4, [0.2, 0.0, 0.0])];
    limb(&mut digger, None, [0.0, 0.0, 0.4], &boom);
    all.push(machine("rod_digger", digger));
    all
}

impl BodiedRobot {
    /// The URDF of the robot. All bodies are cylinders and spheres.
    pub fn urdf(&self) -> String {
        let foot = "<origin xyz=\"0 0 0.01\"/><geometry><cylinder radius=\"0.05\" length=\"0.02\"/></geometry>";
        let mut text =
            format!("<robot name=\"{}\">\n  <link name=\"base\"><collision>{foot}</collision></link>\n", self.name);
        for (i, rod) in self.joints.iter().enumerate() {
            let vector = |v: [f64; 3]| v.map(|x| x.to_string()).join(" ");
            let parent = rod.parent.map_or("base".to_string(), |p| format!("link{}", p + 1));
            let (length, radius) = (rod.length(), rod.radius);
            let middle = vector(rod.end.map(|x| 0.5 * x));
            // The z axis of the cylinder is rotated to the rod. The cylinder is shorter than the rod, so that neighbouring links
            // do not touch.
            let [x, y, z] = rod.end;
            let (roll, pitch) = (-(y / length.max(1e-9)).asin(), x.atan2(z));
            let body = match length - 2.0 * radius {
                rest if rest > radius => format!(
                    "<origin xyz=\"{middle}\" rpy=\"{roll} {pitch} 0\"/><geometry><cylinder radius=\"{radius}\" length=\"{rest}\"/></geometry>"
                ),
                _ => format!("<origin xyz=\"{middle}\"/><geometry><sphere radius=\"{radius}\"/></geometry>"),
            };
            let mass = MASS.0 * length + MASS.1;
            // Inertia of a rod about its centre, the same about all axes. This is accurate enough for torques.
            let inertia = mass * (length * length / 12.0 + radius * radius);
            let kind = if rod.slides { "prismatic" } else { "revolute" };
            let name = i + 1;
            // Writing to a `String` cannot fail, so the result is ignored.
            let _ = write!(
                text,
                "  <joint name=\"joint{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"link{name}\"/><origin \
                 xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"{}\"/><limit lower=\"{}\" upper=\"{}\" velocity=\"{}\" effort=\"{}\"/></joint>\n  \
                 <link name=\"link{name}\"><inertial><origin xyz=\"{middle}\"/><mass value=\"{mass}\"/><inertia ixx=\"{inertia}\" ixy=\"0\" \
                 ixz=\"0\" iyy=\"{inertia}\" iyz=\"0\" izz=\"{inertia}\"/></inertial><collision>{body}</collision></link>\n",
                vector(rod.origin),
                vector(rod.rpy),
                vector(rod.axis),
                rod.range.0,
                rod.range.1,
                rod.velocity,
                rod.effort,
            );
        }
        text + "</robot>\n"
    }
}
