//! Reads `<equality>`: joints that follow other joints, and points of two bodies that coincide.
//!
//! A `<joint>` equality of first order makes a joint follow another: q_1 - ref_1 = a_0 + a_1 (q_2 - ref_2). A `<connect>` between
//! links that move in one plane becomes a hinge normal to this plane. It closes a loop with passive joints: the three equations
//! in the plane determine two undriven joints and the angle of the hinge. All other equalities are ignored, with a note.

use super::actuators::MjcfActuator;
use super::bodies::MjcfBody;
use super::compiler::to_z;
use super::defaults::{Defaults, View};
use super::element::MjcfElement;
use super::joints::Moved;
use crate::error::Error;
use crate::format::follows::{Follows, resolved};
use crate::format::loop_frames::FileLoop;
use crate::format::options::Mimic;
use crate::format::shown::shown;
use crate::inertial::Pose;
use crate::robot::Note;
use crate::vector::{Vector3, cross, dot, norm, turned};
use gate::suggestion::did_you_mean;

/// Axes count as parallel if the sine of their angle is at most this value, and as perpendicular if the cosine is at most this
/// value.
const PARALLEL_SINE: f64 = 1e-6;

/// The content of `<equality>`: following joints and loops.
pub(super) struct Equalities {
    /// For each joint, the joint that it follows, or itself.
    pub follows: Vec<Follows>,
    pub loops: Vec<FileLoop>,
    /// Indices of the joints that are moved only by a loop.
    pub passive: Vec<usize>,
}

/// Reads the `<equality>` elements of a model.
pub(super) fn equalities(
    root: &MjcfElement,
    defaults: &Defaults,
    bodies: &[MjcfBody],
    moved: &Moved,
    drives: &[MjcfActuator],
    mimic: Mimic,
    notes: &mut Vec<Note>,
) -> Result<Equalities, Error> {
    // `next` has one entry more than `joints`. The last entry stands for an imaginary joint that never moves. A locked joint
    // (`<joint>` equality without `joint2`) follows this imaginary joint.
    let mut next: Vec<Option<Follows>> = vec![None; moved.joints.len() + 1];
    let mut connects = Vec::new();
    let is_off = ["equality", "constraint"].into_iter().find(|flag| root.disables(flag));
    for element in root.children("equality").flat_map(|equality| &equality.children) {
        let view = defaults.view(element, None)?;
        let mut left_out = |why: &str| {
            let text = format!("{why}, and is not read");
            notes.push(Note { subject: element.called(), text });
        };
        if view.flag("active")? == Some(false) {
            left_out("is not active in the file");
            continue;
        }
        if let Some(flag) = is_off {
            left_out(&format!("is disabled in the file (`{flag}` of <flag>)"));
            continue;
        }
        match element.tag.as_str() {
            "joint" if mimic == Mimic::Independent => {
                left_out("ties joints that are read as coordinates of their own, as was asked");
            }
            "joint" => {
                if let Some((k, follows)) = joint(view, moved)? {
                    next[k] = Some(follows);
                }
            }
            "connect" => connects.push(view),
            "weld" => left_out("holds two bodies together: the robot is taken without it"),
            other => left_out(&format!("is a <{}>", shown(other))),
        }
    }
    let name = |k: usize| moved.joints.get(k).map_or("", |joint| joint.name.as_str());
    let mut follows = resolved(&next, name).map_err(|(k, what)| moved.joints[k].view.element.error(what))?;
    for (follows, joint) in follows.iter_mut().zip(&moved.joints) {
        // The equality gives the offset between joint positions; here the offset is between displacements from the pose in the
        // file.
        follows.offset -= joint.reference;
    }
    let closing = Closing { bodies, moved, drives, follows: &follows };
    let (loops, passive) = closing.loops(&connects, notes)?;
    Ok(Equalities { follows, loops, passive })
}

/// Reads a `<joint>` equality: the index of the joint that follows, and its leader. Fails if a joint is unknown or if the
/// relation is not affine.
fn joint(view: View, moved: &Moved) -> Result<Option<(usize, Follows)>, Error> {
    let find = |key: &str| -> Result<Option<usize>, Error> {
        let Some(name) = view.get(key) else { return Ok(None) };
        let found = moved.joints.iter().position(|joint| joint.name == name);
        found.map(Some).ok_or_else(|| {
            let meant = did_you_mean(name, moved.joints.iter().map(|joint| joint.name.as_str()));
            view.element.error(format!("`{key}` of {} is no joint: `{}`{meant}", view.element.called(), shown(name)))
        })
    };
    let follower = find("joint1")?.ok_or_else(|| view.element.error("<joint> of <equality> has no `joint1`"))?;
    let coefficients = view.numbers("polycoef", 1, 5)?.unwrap_or_default();
    let a = |k: usize| coefficients.get(k).copied().unwrap_or(if k == 1 { 1.0 } else { 0.0 });
    let Some(leader) = find("joint2")? else {
        // The equality has no second joint: the joint is locked at the constant term of the polynomial.
        let offset = moved.joints[follower].reference + a(0);
        return Ok(Some((follower, Follows { leader: moved.joints.len(), multiplier: 0.0, offset })));
    };
    if (2..5).any(|k| a(k) != 0.0) {
        let message = format!(
            "{} ties `{}` to `{}` by a curve (`polycoef`): a joint follows another by a factor and an offset; \
             [mimic=independent] takes both for coordinates",
            view.element.called(),
            shown(&moved.joints[follower].name),
            shown(&moved.joints[leader].name)
        );
        return Err(view.element.error(message));
    }
    let [own, other] = [follower, leader].map(|k| moved.joints[k].reference);
    Ok(Some((follower, Follows { leader, multiplier: a(1), offset: own + a(0) - a(1) * other })))
}

/// The data for finding the loops of a model.
struct Closing<'a, 'b> {
    bodies: &'b [MjcfBody<'a>],
    moved: &'b Moved<'a>,
    drives: &'b [MjcfActuator],
    follows: &'b [Follows],
}

/// A `<connect>` between links that move in one plane, as a hinge.
struct Hinge {
    one: FileLoop,
    /// Indices of the joints around the loop that have no actuator; the nearest to the base is first.
    undriven: Vec<usize>,
}

impl Closing<'_, '_> {
    /// The loops of all `<connect>` elements, and the indices of their passive joints.
    fn loops(&self, connects: &[View], notes: &mut Vec<Note>) -> Result<(Vec<FileLoop>, Vec<usize>), Error> {
        let mut hinges = Vec::new();
        let mut open = Vec::new();
        for view in connects {
            match self.hinge(*view)? {
                Some(hinge) => hinges.push((hinge, view)),
                None => open.push((view, "joins points of links that do not move in one plane")),
            }
        }
        let mut passive: Vec<usize> = hinges.iter().flat_map(|(hinge, _)| hinge.undriven.clone()).collect();
        passive.sort_unstable();
        passive.dedup();
        // A single loop in a plane has two passive joints. If more than two of its joints are undriven, the joints nearest to
        // the base become coordinates.
        if let (1, Some(surplus)) = (hinges.len(), passive.len().checked_sub(2)) {
            passive.drain(..surplus);
        }
        if passive.len() != 2 * hinges.len() {
            let why = "closes a loop in a plane with other than two undriven joints";
            open.extend(hinges.drain(..).map(|(_, view)| (view, why)));
            passive.clear();
        }
        for (view, why) in open {
            let text = format!("{why}: the loop is not read, and the robot is taken cut open there");
            notes.push(Note { subject: view.element.called(), text });
        }
        Ok((hinges.into_iter().map(|(hinge, _)| hinge.one).collect(), passive))
    }

    /// Converts a `<connect>` to a hinge whose axis is normal to the plane of the loop. `None` if the links of the loop do not
    /// move in one plane.
    fn hinge(&self, view: View) -> Result<Option<Hinge>, Error> {
        let Some(ends) = self.ends(view)? else { return Ok(None) };
        let above = ends.map(|(body, _)| self.above(body));
        let own =
            |a: usize, b: usize| -> Vec<usize> { above[a].iter().copied().filter(|k| !above[b].contains(k)).collect() };
        let around = [own(0, 1), own(1, 0)].concat();
        let axis = |k: usize| turned(&self.joint_pose(k).rotation, self.moved.joints[k].given.axis);
        let hinges = || around.iter().copied().filter(|&k| !self.moved.joints[k].given.prismatic);
        let Some(normal) = hinges().next().map(axis) else { return Ok(None) };
        let is_plane = around.iter().all(|&k| match self.moved.joints[k].given.prismatic {
            true => dot(axis(k), normal).abs() < PARALLEL_SINE,
            false => norm(cross(axis(k), normal)) < PARALLEL_SINE,
        });
        if !is_plane {
            return Ok(None);
        }
        let end = |(body, point): (usize, Vector3)| {
            let carrier = self.moved.carriers[body].0;
            let frame = Pose { rotation: to_z(normal), position: point };
            (carrier, carrier.map_or(frame, |k| self.joint_pose(k).inverse().compose(&frame)))
        };
        let is_undriven = |k: &usize| !self.drives[*k].is_driven && self.follows[*k].leader == *k;
        let mut undriven: Vec<usize> = around.iter().copied().filter(is_undriven).collect();
        undriven.sort_unstable();
        let name = view.element.attribute("name").map_or_else(|| "loop".to_string(), str::to_string);
        Ok(Some(Hinge { one: FileLoop { name, cut: end(ends[0]), twin: end(ends[1]) }, undriven }))
    }

    /// The two bodies of a `<connect>`. Each has its point in the base frame (m) with the joints at their positions in the
    /// file. `None` if a body is not part of the robot.
    fn ends(&self, view: View) -> Result<Option<[(usize, Vector3); 2]>, Error> {
        let error = |what: String| view.element.error(what);
        // The world has index 0. It is the body if the attribute is missing.
        let body = |key: &str| -> Result<usize, Error> {
            let Some(name) = view.get(key) else { return Ok(0) };
            let found = self.bodies.iter().position(|body| body.name == name);
            found.ok_or_else(|| {
                let meant = did_you_mean(name, self.bodies.iter().map(|body| body.name.as_str()));
                error(format!("`{key}` of {} is no body: `{}`{meant}", view.element.called(), shown(name)))
            })
        };
        let site = |key: &str| -> Result<(usize, Vector3), Error> {
            let name = view.get(key).unwrap_or("");
            let on = |(b, body): (usize, &MjcfBody)| {
                let site = body.sites.iter().find(|site| site.0 == name)?;
                Some((b, self.body_pose(b).compose(&site.1).position))
            };
            let found = self.bodies.iter().enumerate().find_map(on);
            found.ok_or_else(|| error(format!("`{key}` of {} is no site: `{}`", view.element.called(), shown(name))))
        };
        // `anchor` is one point, in the frame of `body1`. With the joints at their positions in the file, both bodies have this
        // point in common. Without an anchor, two sites give one point on each body.
        let ends = match view.vector::<3>("anchor")? {
            Some(anchor) => {
                let (first, second) = (body("body1")?, body("body2")?);
                let own = Pose { position: anchor, ..Pose::IDENTITY };
                let point = self.body_pose(first).compose(&own).position;
                [(first, point), (second, point)]
            }
            None => [site("site1")?, site("site2")?],
        };
        // The world is no link of the robot. But a loop may end at the world if the base is fixed to it.
        let is_part = |b: usize| self.moved.is_part[b] || (b == 0 && self.moved.floating.is_none());
        Ok(Some(ends).filter(|ends| ends.iter().all(|(b, _)| is_part(*b))))
    }

    /// Indices of the joints on the path from the base to a body.
    fn above(&self, body: usize) -> Vec<usize> {
        let joints = std::iter::successors(self.moved.carriers[body].0, |&k| self.moved.joints[k].given.antecedent);
        let mut joints: Vec<usize> = joints.collect();
        joints.reverse();
        joints
    }

    /// Pose of the frame of joint k in the base frame, with the joints at their positions in the file.
    fn joint_pose(&self, k: usize) -> Pose {
        let given = &self.moved.joints[k].given;
        given.antecedent.map_or(given.pose, |i| self.joint_pose(i).compose(&given.pose))
    }

    fn body_pose(&self, b: usize) -> Pose {
        let (carrier, pose) = self.moved.carriers[b];
        carrier.map_or(pose, |k| self.joint_pose(k).compose(&pose))
    }
}
