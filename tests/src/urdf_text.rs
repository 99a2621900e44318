//! URDF texts of random trees.
//!
//! The trees are for tests and benches of large robots.

use std::fmt::Write;

use crate::random::Random;

/// A random tree of `n` joints. The parent of a link is one of the last `reach` links before it; 1 gives a serial robot.
pub fn random_tree(n: usize, reach: usize, seed: u64) -> String {
    let mut random = Random(seed);
    let mut text = format!("<robot name=\"tree_of_{n}\">\n  <link name=\"link_0\"/>\n");
    for j in 1..=n {
        let parent = j - 1 - random.below(reach.min(j));
        let right = std::f64::consts::FRAC_PI_2;
        let rpy: Vec<f64> = (0..3).map(|_| right * random.below(4) as f64).collect();
        let xyz: Vec<f64> = (0..3).map(|_| if random.unit() < 0.2 { 0.0 } else { 0.3 * random.unit() }).collect();
        // One axis in eight is oblique, and one joint in ten is prismatic.
        let axis = match random.below(8) {
            0 => [0.6, 0.0, 0.8],
            1 | 2 => [1.0, 0.0, 0.0],
            3 => [0.0, -1.0, 0.0],
            _ => [0.0, 0.0, 1.0],
        };
        let kind = if random.below(10) == 0 { "prismatic" } else { "revolute" };
        let three = |v: &[f64]| format!("{} {} {}", v[0], v[1], v[2]);
        writeln!(
            text,
            "  <link name=\"link_{j}\">
    <inertial>
      <origin xyz=\"{}\" rpy=\"0 0 0\"/><mass value=\"{:.3}\"/>
      <inertia ixx=\"0.02\" ixy=\"0.001\" ixz=\"0\" iyy=\"0.03\" iyz=\"0.002\" izz=\"0.025\"/>
    </inertial>
  </link>
  <joint name=\"joint_{j}\" type=\"{kind}\">
    <parent link=\"link_{parent}\"/><child link=\"link_{j}\"/>
    <origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"{}\"/>
    <limit lower=\"-2\" upper=\"2\" velocity=\"3\" effort=\"50\"/>
  </joint>",
            three(&random.vector(3, 0.1)),
            1.0 + 0.5 * random.unit(),
            three(&xyz),
            three(&rpy),
            three(&axis),
        )
        .expect("a string takes what is written to it");
    }
    text + "</robot>\n"
}
