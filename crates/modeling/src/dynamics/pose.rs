//! Where a link is, how it moves with the coordinates, and what a force on it does to the torques.
//!
//! ```text
//! T_0j = [R_0j p_0j]            3 x 4, in the base frame
//! V_j  = J_j dq                 6 x n: velocity of O_j, then angular velocity, in frame j
//! tau  = J_j^T F_j              F_j: force, then moment at O_j, that link j exerts on the environment
//! ```
//! Of a frame f fixed to link j, with R = R_jf and p = p_jf: T_0f = T_0j T_jf, v_f = R^T (v_j + w_j x p), w_f = R^T w_j.

use expr::{Expr, Function, Input, Output, SymbolKind};
use robot::{LinkId, Pose, Robot};

use crate::derivation::Derivation;
use crate::kinematics::implicit::reduced;
use crate::kinematics::links::Twist;
use crate::kinematics::vector::{NULL, Vector, add, cross, dot};

/// A frame fixed to a link, by which functions say where they speak of.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkFrame {
    /// The link.
    pub link: LinkId,
    /// The frame in the frame of the link.
    pub pose: Pose,
    /// What functions of it are called after; empty for a frame without a name.
    pub name: String,
    /// Whether it is a frame of the robot's file, and not Khalil's frame of the link.
    pub is_files: bool,
}

impl From<LinkId> for LinkFrame {
    fn from(link: LinkId) -> LinkFrame {
        LinkFrame { link, pose: Pose::IDENTITY, name: String::new(), is_files: false }
    }
}

impl LinkFrame {
    /// The frame that is called so: a link of a URDF in the frame the URDF gives it, fixed ones among them, a link of
    /// another file by its name, its joint's name or its label. `None` where the robot has none of that name.
    pub fn named(robot: &Robot, name: &str) -> Option<LinkFrame> {
        let of_file = robot.link_ids().find_map(|link| {
            let (_, pose) = robot.link(link).frames.iter().find(|(frame, _)| frame == name)?;
            Some(LinkFrame { link, pose: *pose, name: name.into(), is_files: true })
        });
        of_file.or_else(|| {
            let is = |&j: &LinkId| {
                let link = robot.link(j);
                link.name == name || link.joint.name == name || link.label == name
            };
            let link = robot.link_ids().find(is)?;
            // A joint of a URDF stands for the link it moves.
            let own = robot.link(link).frames.first();
            let pose = own.map_or(Pose::IDENTITY, |frame| frame.1);
            Some(LinkFrame { link, pose, name: name.into(), is_files: own.is_some() })
        })
    }

    /// Names of all frames that [`LinkFrame::named`] knows.
    pub fn names(robot: &Robot) -> Vec<String> {
        let of = |link: &robot::Link| match link.frames.is_empty() {
            true => vec![link.name.clone()],
            false => link.frames.iter().map(|frame| frame.0.clone()).collect(),
        };
        robot.links.iter().flat_map(of).collect()
    }

    /// What the frame is, for the reader of a generated file.
    pub(crate) fn meaning(&self) -> &'static str {
        match self.is_files {
            true => "the frame is that of the robot's file",
            false => "the frame is Khalil's, its z along the joint axis",
        }
    }

    fn function(&self, kind: &str) -> String {
        let word: String =
            self.name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
        if word.is_empty() { kind.into() } else { format!("{kind}_{word}") }
    }
}

/// Input `q`; output `t`, 3 x 4: orientation and position of a frame in the base frame.
pub(crate) fn pose(derivation: &mut Derivation, frame: &LinkFrame) -> Function {
    let Derivation { robot, graph: g, motion, links, .. } = derivation;
    let (R, p) = (&frame.pose.rotation, &frame.pose.position);
    let mut columns = [0, 1, 2].map(|c| [0, 1, 2].map(|r| g.constant(R[r][c]))).to_vec();
    columns.push(p.map(|x| g.constant(x)));
    let mut columns: [Vector; 4] = std::array::from_fn(|c| columns[c]);
    let mut at = Some(frame.link);
    while let Some(k) = at {
        let placement = &links[k.0].placement;
        columns = columns.map(|v| placement.to_antecedent(g, v));
        columns[3] = add(g, columns[3], placement.p);
        at = robot.link(k).antecedent;
    }
    let entries = (0..3).flat_map(|r| columns.map(|c| c[r])).collect();
    let output = Output { name: "t".into(), rows: 3, columns: 4, entries };
    Function::new(&frame.function("pose"), g, motion.configuration(), vec![output])
}

/// Input `q`; output `j`, 6 x n.
pub(crate) fn jacobian(derivation: &mut Derivation, frame: &LinkFrame) -> Function {
    let rows = jacobian_rows(derivation, frame);
    let n = derivation.robot.n_coordinates();
    let output = Output { name: "j".into(), rows: 6, columns: n, entries: rows.concat() };
    Function::new(&frame.function("jacobian"), &derivation.graph, derivation.motion.configuration(), vec![output])
}

/// Inputs `q`, `wrench` (6); output `tau` (n): what to add to the torques when the link exerts the wrench,
/// which is given in the frame and about its origin.
pub(crate) fn external_torque(derivation: &mut Derivation, frame: &LinkFrame) -> Function {
    let rows = jacobian_rows(derivation, frame);
    let n = derivation.robot.n_coordinates();
    let g = &mut derivation.graph;
    let wrench: Vec<Expr> = ["fx", "fy", "fz", "nx", "ny", "nz"].map(|name| g.symbol(name, SymbolKind::Input)).to_vec();
    let mut tau = vec![Expr::ZERO; n];
    for (k, tau) in tau.iter_mut().enumerate() {
        for (row, &component) in rows.iter().zip(&wrench) {
            let term = g.mul(row[k], component);
            *tau = g.add(*tau, term);
        }
    }
    let mut inputs = derivation.motion.configuration();
    inputs.push(Input { name: "wrench".into(), entries: wrench });
    let output = Output { name: "tau".into(), rows: n, columns: 1, entries: tau };
    Function::new(&frame.function("external_torque"), &derivation.graph, inputs, vec![output])
}

fn jacobian_rows(derivation: &mut Derivation, frame: &LinkFrame) -> Vec<Vec<Expr>> {
    let g = &mut derivation.graph;
    let axes = transposed(&frame.pose.rotation).map(|axis| axis.map(|x| g.constant(x)));
    let p = frame.pose.position.map(|x| g.constant(x));
    let mut column = |t: &Option<Twist>| -> Vec<Expr> {
        let (v, w) = t.map_or((NULL, NULL), |t| (t.d, t.z));
        let lever = cross(g, w, p);
        let v = add(g, v, lever);
        [v, w].into_iter().flat_map(|part| axes.map(|axis| dot(g, axis, part))).collect()
    };
    let columns: Vec<Vec<Expr>> = derivation.links[frame.link.0].jacobian.iter().map(&mut column).collect();
    let columns = match &derivation.implicit {
        None => columns,
        Some(implicit) => reduced(&mut derivation.graph, &implicit.G, &columns),
    };
    (0..6).map(|row| columns.iter().map(|c| c[row]).collect()).collect()
}

fn transposed(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|c| [0, 1, 2].map(|r| m[r][c]))
}
