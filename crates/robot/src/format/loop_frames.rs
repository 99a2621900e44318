//! Loops of a file: a point of one link coincides with a point of another link, and both links share an axis through this point
//! (a hinge).

use super::reframe::placement;
use crate::inertial::Pose;
use crate::robot::{JointKind, Link, LinkId, Loop, LoopFrame, PassiveCoordinate};
use crate::value::{Affine, CoordinateId, Value};

/// A loop: two frames that coincide except for a rotation about their common z axis.
#[derive(Clone, Debug)]
pub(in crate::format) struct FileLoop {
    pub name: String,
    /// Index of the joint that carries the first frame (`None`: the base), and pose of this frame in the joint's frame. `twin`:
    /// the two values for the second frame.
    pub cut: (Option<usize>, Pose),
    pub twin: (Option<usize>, Pose),
}

/// Converts the loops `given` of a file to loops between `links`. Each loop is cut at its hinge, and the angle of the hinge is
/// added to the passive coordinates. `n`: number of coordinates.
pub(in crate::format) fn loops(
    given: &[FileLoop],
    links: &[Link],
    n: usize,
    passive: &mut Vec<PassiveCoordinate>,
) -> Vec<Loop> {
    let frame = |(carrier, pose): &(Option<usize>, Pose), kind, variable| {
        let in_link = carrier.map_or(*pose, |j| links[j].file_frame.compose(pose));
        LoopFrame { antecedent: carrier.map(LinkId), geometry: placement(&in_link), kind, variable }
    };
    let one = |one: &FileLoop| {
        passive.push(PassiveCoordinate { name: one.name.clone(), start: 0.0 });
        let turn = Affine::coordinate(CoordinateId(n + passive.len() - 1));
        Loop {
            cut: frame(&one.cut, JointKind::Revolute, turn),
            twin: frame(&one.twin, JointKind::Fixed, Affine::constant(Value::ZERO)),
        }
    };
    given.iter().map(one).collect()
}
