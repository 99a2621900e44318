//! Frames fixed to links, with their names in the robot's file.

use robot::{LinkId, Pose, Robot};

/// A frame fixed to a link, to which functions such as poses and Jacobians refer.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkFrame {
    /// The link to which the frame is fixed.
    pub link: LinkId,
    /// The pose of the frame in the frame of the link.
    pub pose: Pose,
    /// Name of the frame, which becomes a part of the names of functions of this frame. Empty for a frame without a name.
    pub name: String,
    /// Whether the frame is a frame of the robot's file. Otherwise it is Khalil's frame of the link (z along the joint axis).
    pub is_files: bool,
}

impl From<LinkId> for LinkFrame {
    fn from(link: LinkId) -> LinkFrame {
        LinkFrame { link, pose: Pose::IDENTITY, name: String::new(), is_files: false }
    }
}

impl LinkFrame {
    /// The frame with the name `name`. In a URDF, this is the frame of a link, which may also be on a fixed joint. In other
    /// files, it is the frame of the link with this link name, joint name or label. `None` if the robot has no such frame.
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
            // The name of a joint in a URDF selects the link that this joint moves.
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

    /// A sentence for readers of a generated file. The sentence says whether the frame is a frame of the robot's file or
    /// Khalil's frame.
    pub(crate) fn meaning(&self) -> &'static str {
        match self.is_files {
            true => "the frame is that of the robot's file",
            false => "the frame is Khalil's, its z along the joint axis",
        }
    }

    /// The name of the function of kind `kind` for this frame: kind `pose` and frame `tool` give `pose_tool`.
    pub fn function(&self, kind: &str) -> String {
        let word: String =
            self.name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
        if word.is_empty() { kind.into() } else { format!("{kind}_{word}") }
    }
}
