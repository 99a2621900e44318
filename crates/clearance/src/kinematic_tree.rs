//! Forward kinematics: the poses of the links of a robot. The constant transforms are computed once.
//!
//! ```text
//! T_j = T_a(j) A_j Rz(q_j)  or  T_a(j) A_j Tz(q_j),   q_j = offset + sum of multiple * coordinate
//! ```
//! T_j is the pose of link j in the base frame. A_j is the transform from link j to its antecedent a(j) at q_j = 0. [Khalil,
//! Kleinfinger 1986]
//!
//! Not here: robots with joints that are solved numerically because of a loop.

use robot::{JointKind, Pose, Robot};

use robot::vector::{Vector3, norm};

/// The constant transform of a link relative to its antecedent, and its joint.
struct LinkPlacement {
    antecedent: Option<usize>,
    fixed: Pose,
    kind: JointKind,
    /// The coordinates on which the joint position depends: index of the coordinate, and its factor.
    terms: Vec<(usize, f64)>,
    offset: f64,
}

/// The kinematic tree of a robot: its links with their antecedents and joints.
pub struct KinematicTree {
    places: Vec<LinkPlacement>,
}

impl KinematicTree {
    /// The kinematic tree of a robot. `None` if joint positions are solved numerically, because then the motion of a joint per
    /// coordinate has no known bound.
    pub fn new(robot: &Robot) -> Option<KinematicTree> {
        let place = |link: &robot::Link| LinkPlacement {
            antecedent: link.antecedent.map(|a| a.0),
            fixed: link.geometry.pose(&robot.symbols, 0.0, 0.0),
            kind: link.joint.kind,
            terms: link.joint.variable.terms.iter().map(|(k, x)| (k.0, *x)).collect(),
            offset: link.joint.variable.offset.number(&robot.symbols),
        };
        robot.passive.is_empty().then(|| KinematicTree { places: robot.links.iter().map(place).collect() })
    }

    /// A tree without links.
    pub(crate) fn none() -> KinematicTree {
        KinematicTree { places: vec![] }
    }

    /// The pose of every link in the base frame. `q`: one position per coordinate, rad (m).
    pub fn poses(&self, q: &[f64]) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.places.len());
        for place in &self.places {
            let x = place.offset + place.terms.iter().map(|(k, m)| m * q[*k]).sum::<f64>();
            let motion = match place.kind {
                JointKind::Revolute => {
                    let (s, c) = x.sin_cos();
                    Pose { rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], position: [0.0; 3] }
                }
                JointKind::Prismatic => Pose { position: [0.0, 0.0, x], ..Pose::IDENTITY },
                JointKind::Fixed => Pose::IDENTITY,
            };
            let ahead = place.fixed.compose(&motion);
            poses.push(place.antecedent.map_or(ahead, |a| poses[a].compose(&ahead)));
        }
        poses
    }

    /// Index of the antecedent of a link; `None` if the antecedent is the base.
    pub fn antecedent(&self, link: usize) -> Option<usize> {
        self.places[link].antecedent
    }

    /// The chain of links from a link inward to the base, starting with the link itself. Empty for the base (`None`).
    pub fn inward(&self, link: Option<usize>) -> Vec<usize> {
        std::iter::successors(link, |&j| self.places[j].antecedent).collect()
    }

    /// The type of the joint of a link: revolute, prismatic or fixed.
    pub fn kind(&self, link: usize) -> JointKind {
        self.places[link].kind
    }

    /// The coordinates that move the joint of a link: index of each coordinate, and its factor in the joint position.
    pub fn terms(&self, link: usize) -> &[(usize, f64)] {
        &self.places[link].terms
    }

    /// The joint axis of a link whose antecedent is the base. This axis does not move; it is given in the base frame. `None`
    /// for all other links.
    pub(crate) fn standing_axis(&self, link: usize) -> Option<Vector3> {
        let place = &self.places[link];
        place.antecedent.is_none().then(|| axis(&place.fixed))
    }

    /// Largest distance (m) between the frame of a link and the frame of its antecedent, if the absolute value of each
    /// coordinate is at most its value in `ranges`.
    pub(crate) fn length(&self, link: usize, ranges: &[f64]) -> f64 {
        let place = &self.places[link];
        let slid = match place.kind {
            JointKind::Prismatic => place.offset.abs() + self.spread(link, ranges),
            _ => 0.0,
        };
        norm(place.fixed.position) + slid
    }

    /// Largest motion of the joint of a link (rad or m) if each coordinate moves by at most its value in `spread`.
    pub fn spread(&self, link: usize, spread: &[f64]) -> f64 {
        self.places[link].terms.iter().map(|(k, m)| m.abs() * spread[*k]).sum()
    }
}

/// The axis of the joint of a link, from the pose of the link: the z axis of its frame.
pub(crate) fn axis(pose: &Pose) -> Vector3 {
    pose.rotation.map(|row| row[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_those_of_the_robot() {
        let text = "convention: khalil-kleinfinger\nname: three\nlinks:\n  - {link: 1, antecedent: base, theta: q1 + 0.3}\n  \
                    - {link: 2, antecedent: 1, alpha: pi/2, d: 0.5, b: 0.1, r: q2, joint: prismatic}\n  - {link: 3, antecedent: 2, \
                    alpha: 0.4, d: 0.2, theta: q3}\n";
        let robot = robot::format::read_yaml(text, "three.yaml").unwrap();
        let q = [0.7, -0.3, 1.9];
        let (found, expected) = (KinematicTree::new(&robot).unwrap().poses(&q), robot.link_poses(&q));
        for (a, b) in found.iter().zip(&expected) {
            let entries = |p: &Pose| [p.rotation[0], p.rotation[1], p.rotation[2], p.position].concat();
            // Allowed error: rounding of a few products of numbers below one.
            assert!(entries(a).iter().zip(entries(b)).all(|(x, y)| (x - y).abs() < 1e-14), "{a:?} {b:?}");
        }
        assert_eq!(found.len(), 3);
    }
}
