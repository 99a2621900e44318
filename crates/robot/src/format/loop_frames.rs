//! Loops that a file states: a point of one link that coincides with a point of another, about an axis that both keep.

use super::reframe::placement;
use crate::inertial::Pose;
use crate::robot::{JointKind, Link, LinkId, Loop, LoopFrame, PassiveCoordinate};
use crate::value::{Affine, CoordinateId, Value};

/// Two frames that coincide but for a turn about their common z axis.
#[derive(Clone, Debug)]
pub(in crate::format) struct FileLoop {
    pub name: String,
    /// Index of the joint that carries it, `None`: the base; and the frame in that of the joint.
    pub cut: (Option<usize>, Pose),
    pub twin: (Option<usize>, Pose),
}

/// The loops of a robot with these links; each cut is one more passive coordinate. `n`: the number of coordinates.
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
