//! The two branches of each loop as chains of constant placements and joints, for whoever closes a loop by algebra.
//!
//! A link stands at `Rz(gamma) Tz(b) Rx(alpha) Tx(d) Rz(theta) Tz(r)` in its antecedent's frame, and its variable turns
//! about, or slides along, the last z. The constants come as one function of the robot's symbols
//! ([`PLACEMENT`] outputs a link); the joints come as coefficients of all variables.

use expr::{Function, Graph, Output};
use robot::{JointKind, LinkId, Robot};

use crate::kinematics::constants::Constants;
use crate::kinematics::implicit::with_loop_frames;
use crate::kinematics::links::Geometry;

/// cos gamma, sin gamma, b, cos alpha, sin alpha, d, cos theta, sin theta, r.
pub(crate) const PLACEMENT: usize = 9;

/// The loops of a robot that no affine function closes.
pub(crate) struct LoopChains {
    /// [`PLACEMENT`] entries a link, of the links of the robot and of its loop frames.
    pub placements: Function,
    /// How each of these links moves against its antecedent.
    pub joints: Vec<ChainJoint>,
    /// Per loop the links from the last common one to the cut, and to the twin.
    pub loops: Vec<[Vec<usize>; 2]>,
}

/// The joint of a link: what its variable is of all variables.
#[derive(Clone, Debug)]
pub(crate) struct ChainJoint {
    pub kind: JointKind,
    /// Variable, coefficient. Coordinates come first, passive ones after them.
    pub terms: Vec<(usize, f64)>,
}

impl LoopChains {
    /// `g` and `constants` are those of the derivation, so that the symbols are.
    pub fn new(g: &mut Graph, robot: &Robot, constants: &mut Constants) -> LoopChains {
        let (open, pairs) = with_loop_frames(robot);
        let mut entries = Vec::with_capacity(PLACEMENT * open.links.len());
        for link in &open.links {
            let at = Geometry::of(g, constants, link);
            let (gamma, alpha, theta) = (at.gamma.turn(g), at.alpha.turn(g), at.theta.turn(g));
            entries.extend([gamma.cos, gamma.sin, at.b, alpha.cos, alpha.sin, at.d, theta.cos, theta.sin, at.r]);
        }
        let output = Output { name: "placement".into(), rows: open.links.len(), columns: PLACEMENT, entries };
        let joint = |link: &robot::Link| ChainJoint {
            kind: link.joint.kind,
            terms: link.joint.variable.terms.iter().map(|&(k, c)| (k.0, c)).collect(),
        };
        let way = |end: LinkId| -> Vec<usize> {
            let mut links: Vec<usize> =
                std::iter::successors(Some(end), |&j| open.link(j).antecedent).map(|j| j.0).collect();
            links.reverse();
            links
        };
        let branches = |&(cut, twin): &(LinkId, LinkId)| {
            let (cut, twin) = (way(cut), way(twin));
            let common = cut.iter().zip(&twin).take_while(|(a, b)| a == b).count();
            [cut[common..].to_vec(), twin[common..].to_vec()]
        };
        LoopChains {
            placements: Function::new("placements", g, Vec::new(), vec![output]),
            joints: open.links.iter().map(joint).collect(),
            loops: pairs.iter().map(branches).collect(),
        }
    }
}
