//! Reference frames, in whose axes the results of a link's functions are given: the frame of the base, or a frame of a link.

use expr::{Expr, Graph};
use robot::{LinkId, Pose, Robot};

use crate::dynamics::link_frame::LinkFrame;
use crate::kinematics::links::LinkMotion;
use crate::kinematics::vector::{Vector, add, dot};

/// A frame in whose axes the results of a link's function (such as a velocity) are given.
#[derive(Clone, Debug, PartialEq)]
pub enum ReferenceFrame {
    /// The frame of the base.
    Base,
    /// A frame fixed to a link.
    Link(LinkFrame),
}

impl ReferenceFrame {
    /// The reference frame with this name; `base` is the frame of the base. `None` if the robot has no such frame.
    pub fn named(robot: &Robot, name: &str) -> Option<ReferenceFrame> {
        match LinkFrame::named(robot, name) {
            Some(frame) => Some(ReferenceFrame::Link(frame)),
            None => (name == "base").then_some(ReferenceFrame::Base),
        }
    }

    /// The name of the frame.
    pub(crate) fn name(&self) -> &str {
        match self {
            ReferenceFrame::Base => "base",
            ReferenceFrame::Link(frame) => &frame.name,
        }
    }

    fn link(&self) -> Option<LinkId> {
        match self {
            ReferenceFrame::Base => None,
            ReferenceFrame::Link(frame) => Some(frame.link),
        }
    }

    fn pose(&self) -> Pose {
        match self {
            ReferenceFrame::Base => Pose::IDENTITY,
            ReferenceFrame::Link(frame) => frame.pose,
        }
    }
}

/// Converts the vector `v` from the axes of link `from` to the axes of the reference frame.
pub(crate) fn in_axes_of(
    g: &mut Graph,
    robot: &Robot,
    links: &[LinkMotion],
    v: Vector,
    from: LinkId,
    reference: &ReferenceFrame,
) -> Vector {
    let (up, down) = path(robot, from, reference.link());
    let v = up.iter().fold(v, |v, j| links[j.0].placement.to_antecedent(g, v));
    let v = down.iter().fold(v, |v, j| links[j.0].placement.to_link(g, v));
    turned_to(g, &reference.pose(), v)
}

/// Converts the point `p` from the frame of link `from` to the reference frame.
pub(crate) fn at_place_of(
    g: &mut Graph,
    robot: &Robot,
    links: &[LinkMotion],
    p: Vector,
    from: LinkId,
    reference: &ReferenceFrame,
) -> Vector {
    let (up, down) = path(robot, from, reference.link());
    let p = up.iter().fold(p, |p, j| {
        let turned = links[j.0].placement.to_antecedent(g, p);
        add(g, turned, links[j.0].placement.p)
    });
    let p = down.iter().fold(p, |p, j| {
        let apart = std::array::from_fn(|i| g.sub(p[i], links[j.0].placement.p[i]));
        links[j.0].placement.to_link(g, apart)
    });
    let pose = reference.pose();
    let origin = pose.position.map(|x| g.constant(x));
    let apart = std::array::from_fn(|i| g.sub(p[i], origin[i]));
    turned_to(g, &pose, apart)
}

/// Converts the vector `v` from the axes of a link to the axes of a frame fixed to this link: R^T v. `pose`: pose of the frame in
/// the link.
pub(crate) fn turned_to(g: &mut Graph, pose: &Pose, v: Vector) -> Vector {
    [0, 1, 2].map(|c| {
        let axis = [0, 1, 2].map(|r| g.constant(pose.rotation[r][c]));
        dot(g, axis, v)
    })
}

/// The links on the path from link `from` to link `to` (`None`: the base): first the links inward from `from`, then the links
/// outward to `to`. Links that carry both `from` and `to` are not included.
fn path(robot: &Robot, from: LinkId, to: Option<LinkId>) -> (Vec<LinkId>, Vec<LinkId>) {
    let to_base = |link: Option<LinkId>| {
        let next = |j: &LinkId| robot.link(*j).antecedent;
        std::iter::successors(link, next).collect::<Vec<LinkId>>()
    };
    let (up, mut down) = (to_base(Some(from)), to_base(to));
    let is_shared = |j: &LinkId| down.contains(j);
    let up: Vec<LinkId> = up.iter().copied().take_while(|j| !is_shared(j)).collect();
    let carries_both = up.last().map_or(Some(from), |j| robot.link(*j).antecedent);
    down = down.into_iter().take_while(|j| Some(*j) != carries_both).collect();
    down.reverse();
    (up, down)
}

/// The suffix of a function's name for its reference frame, such as `_in_base`; empty without a reference.
pub(crate) fn suffix(reference: Option<&ReferenceFrame>) -> String {
    let word = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    reference.map_or(String::new(), |r| format!("_in_{}", r.name().chars().map(word).collect::<String>()))
}

/// A vector of numbers as constants of the expression graph.
pub fn constants(g: &mut Graph, v: [f64; 3]) -> Vector {
    v.map(|x| -> Expr { g.constant(x) })
}
