//! The two branches of each loop as chains of constant placements and joints. From these chains, the loop is closed
//! algebraically.
//!
//! The pose of a link in its antecedent's frame is `Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r)`. The joint variable turns
//! about the last z, or slides along it. The constants of all poses are one function of the robot's symbols ([`PLACEMENT`]
//! outputs per link); the joints are lists of coefficients of the variables.

use expr::{Function, Graph, Output};
use robot::{JointKind, Robot};

use crate::kinematics::constants::Constants;
use crate::kinematics::implicit::{OpenLoop, open_loops};
use crate::kinematics::links::Geometry;

/// Number of constants in the placement of a link: cos gamma, sin gamma, b, cos alpha, sin alpha, d, cos theta, sin theta, r.
pub(crate) const PLACEMENT: usize = 9;

/// The two branches of each loop, as chains, for loops that are solved numerically.
pub(crate) struct LoopChains {
    /// Function of the constant placements: [`PLACEMENT`] entries for each link and both loop frames of each loop.
    pub placements: Function,
    /// For each link and loop frame of `placements`, in the same order: its joint, which connects it to its antecedent.
    pub joints: Vec<ChainJoint>,
    /// For each loop, the indices of the links of the two branches of the loop: from the last common link to the cut frame, and
    /// to the twin frame.
    pub loops: Vec<[Vec<usize>; 2]>,
}

/// The joint of a link: its kind, and its joint variable as a linear combination of coordinates and passive variables.
#[derive(Clone, Debug)]
pub(crate) struct ChainJoint {
    pub kind: JointKind,
    /// Joint variable as pairs (variable, coefficient). Variables: coordinates first, then passive variables.
    pub terms: Vec<(usize, f64)>,
}

impl LoopChains {
    /// Makes the chains of all loops. `g` and `constants` belong to the derivation, so the chains and the derivation share
    /// their symbols.
    pub(crate) fn new(g: &mut Graph, robot: &Robot, constants: &mut Constants) -> LoopChains {
        let (mut entries, mut joints, mut loops) = (Vec::new(), Vec::new(), Vec::new());
        for OpenLoop { robot, cut, twin } in open_loops(robot) {
            let before = joints.len();
            for link in &robot.links {
                let at = Geometry::of(g, constants, link);
                let (gamma, alpha, theta) = (at.gamma.turn(g), at.alpha.turn(g), at.theta.turn(g));
                entries.extend([gamma.cos, gamma.sin, at.b, alpha.cos, alpha.sin, at.d, theta.cos, theta.sin, at.r]);
                let terms = link.joint.variable.terms.iter().map(|&(k, c)| (k.0, c)).collect();
                joints.push(ChainJoint { kind: link.joint.kind, terms });
            }
            // The links of a branch are consecutive, and the branch's loop frame is the last one.
            loops.push([(before..=before + cut.0).collect(), (before + cut.0 + 1..=before + twin.0).collect()]);
        }
        let output = Output { name: "placement".into(), rows: joints.len(), columns: PLACEMENT, entries };
        LoopChains { placements: Function::new("placements", g, Vec::new(), vec![output]), joints, loops }
    }
}
