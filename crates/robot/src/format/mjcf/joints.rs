//! Reads the joints of the bodies: hinges and slides, each with a point and an axis in the frame of its body.
//!
//! Several joints of one body are in series; the first is nearest to the parent: T = T_0 M_1(q_1) M_2(q_2) ... T: pose of the
//! body in its parent; T_0: its pose in the file; M_i: motion of joint i. Between two consecutive joints there is a massless
//! link. The position of a joint equals its `ref` at the pose in the file.

use super::bodies::MjcfBody;
use super::compiler::{Compiler, direction};
use super::defaults::View;
use crate::angle_snap::{given_length, unit_axis};
use crate::error::Error;
use crate::format::reframe::JointPlacement;
use crate::format::shown::shown;
use crate::inertial::Pose;
use crate::robot::{Friction, Limits, Note, RotorInertia};
use crate::vector::turned;

/// A hinge (revolute joint) or a slide (prismatic joint).
pub(super) struct MjcfJoint<'a> {
    pub name: String,
    pub view: View<'a>,
    /// Index of the body that the joint moves.
    pub body: usize,
    pub given: JointPlacement,
    /// Position of the joint (`ref`) at the pose of the body in the file, rad or m.
    pub reference: f64,
    pub limits: Limits,
    pub friction: Friction,
    pub armature: f64,
}

/// Text of the note on a joint with several numbers in `damping`.
pub(super) const POLYNOMIAL_DAMPING: &str = "is damped by a polynomial of its speed; the first coefficient is read";

/// All joints of the model, and for each body the joint that carries it.
pub(super) struct Moved<'a> {
    /// The joints in the order of MuJoCo's coordinates. An antecedent (parent) precedes its successors.
    pub joints: Vec<MjcfJoint<'a>>,
    /// For each body: index of the joint that carries it (`None`: the base), and pose of the body in the frame of this joint.
    pub carriers: Vec<(Option<usize>, Pose)>,
    /// Index of the body with the free joint that is the floating base; `None` for a fixed base.
    pub floating: Option<usize>,
    /// For each body, whether it belongs to the robot. A separate floating body does not belong to it. If the robot itself
    /// floats, the world and the bodies fixed to the world do not belong to it.
    pub is_part: Vec<bool>,
}

/// The type of a joint in MJCF.
#[derive(Clone, Copy, PartialEq)]
enum MjcfJointType {
    Hinge,
    Slide,
    Ball,
    Free,
}

fn kind(view: View) -> Result<MjcfJointType, Error> {
    if view.element.tag == "freejoint" {
        return Ok(MjcfJointType::Free);
    }
    let which = view.choice("type", &["hinge", "slide", "ball", "free"])?.unwrap_or(0);
    Ok([MjcfJointType::Hinge, MjcfJointType::Slide, MjcfJointType::Ball, MjcfJointType::Free][which])
}

/// Reads the joints of the bodies. `floats`: whether a floating base was requested. `root`: the child of the world that is the
/// robot; `None`: all children of the world.
pub(super) fn moved<'a>(
    bodies: &[MjcfBody<'a>],
    compiler: &Compiler,
    floats: bool,
    root: Option<&str>,
    notes: &mut Vec<Note>,
) -> Result<Moved<'a>, Error> {
    let (floating, is_part) = parts(bodies, floats, root, notes)?;
    let mut all = Moved { joints: Vec::new(), carriers: Vec::new(), floating, is_part };
    for (b, body) in bodies.iter().enumerate() {
        if !all.is_part[b] || all.floating == Some(b) {
            all.carriers.push((None, Pose::IDENTITY));
            continue;
        }
        let (mut carrier, pose) = body.parent.map_or((None, Pose::IDENTITY), |p| all.carriers[p]);
        let position = body.pose.position.map(|x| given_length(x, compiler.angles));
        let mut place = pose.compose(&Pose { position, ..body.pose });
        place.rotation = crate::angle_snap::exact(&place.rotation);
        for (view, frame) in &body.joints {
            let joint = joint(*view, frame, b, (carrier, place), body, compiler, notes)?;
            // The origin of the joint frame is the point of the joint. So the position of the body in the joint frame is the
            // negative of this point.
            place = Pose { position: joint.1.map(|x| -x), ..Pose::IDENTITY };
            carrier = Some(all.joints.len());
            all.joints.push(joint.0);
        }
        all.carriers.push((carrier, place));
    }
    name(&mut all.joints, bodies)?;
    Ok(all)
}

/// The index of each body that has a free joint, and this joint.
///
/// Fails if there is a ball joint, or a free joint whose body has other joints or is not a child of the world.
fn free<'a>(bodies: &[MjcfBody<'a>]) -> Result<Vec<(usize, View<'a>)>, Error> {
    let mut free = Vec::new();
    for (b, body) in bodies.iter().enumerate() {
        for (view, _) in &body.joints {
            let called = || format!("{} of body `{}`", view.element.called(), shown(&body.name));
            match kind(*view)? {
                MjcfJointType::Ball => {
                    let message = format!(
                        "{} is a ball: only hinges and slides are read; write three hinges through one point, or weld it",
                        called()
                    );
                    return Err(view.element.error(message));
                }
                MjcfJointType::Free if body.joints.len() > 1 || body.parent != Some(0) => {
                    let message = format!("{} is free: it stands alone in a body of the world", called());
                    return Err(view.element.error(message));
                }
                MjcfJointType::Free => free.push((b, *view)),
                _ => {}
            }
        }
    }
    Ok(free)
}

/// The index of the body that is the floating base, and for each body whether it belongs to the robot.
fn parts(
    bodies: &[MjcfBody],
    floats: bool,
    root: Option<&str>,
    notes: &mut Vec<Note>,
) -> Result<(Option<usize>, Vec<bool>), Error> {
    let mut free = free(bodies)?;
    // For each body, the child of the world that carries it; `None` if it is left out.
    let mut top: Vec<Option<usize>> = Vec::with_capacity(bodies.len());
    for (b, body) in bodies.iter().enumerate() {
        top.push(match body.parent {
            None | Some(0) => Some(b),
            Some(p) => top[p],
        });
    }
    if let Some(root) = root {
        let left_out = left_out(bodies, &top, root, notes)?;
        free.retain(|f| !left_out.contains(&f.0));
        top.iter_mut().for_each(|top| *top = top.filter(|t| !left_out.contains(t)));
    }
    let has_joints = |t: usize| (0..bodies.len()).any(|b| top[b] == Some(t) && b != t && !bodies[b].joints.is_empty());
    let of_world = |b: usize| top[b].is_some_and(|t| !free.iter().any(|f| f.0 == t)) && !bodies[b].joints.is_empty();
    let fixed: Vec<usize> = (0..bodies.len()).filter(|b| of_world(*b)).filter_map(|b| top[b]).collect();
    let (robots, objects): (Vec<&(usize, View)>, Vec<_>) =
        free.iter().partition(|(b, _)| has_joints(*b) || (free.len() == 1 && fixed.is_empty()));
    let named = |list: &[&(usize, View)]| listed(bodies, list.iter().map(|(b, _)| *b));
    let choice = |b: usize| format!("one description is of one robot, [root={}]", shown(&bodies[b].name));
    match robots[..] {
        [(_, view)] if !floats => {
            let message = "the body is free to move: its base floats, which is asked for by [floating_base=true]";
            return Err(view.element.error(message));
        }
        [(b, view)] if !fixed.is_empty() => {
            let (robot, fixed) = (named(&robots), listed(bodies, fixed.iter().copied()));
            let message = format!("`{robot}` floats while other joints hang on the world ({fixed}): {}", choice(*b));
            return Err(view.element.error(message));
        }
        [(b, _), (_, view), ..] => {
            let message = format!("several robots float ({}): {}", named(&robots), choice(*b));
            return Err(view.element.error(message));
        }
        _ => {}
    }
    if !objects.is_empty() {
        let text = format!("floats and carries no joint: an object next to the robot, left out ({})", named(&objects));
        notes.push(Note { subject: named(&objects[..1]), text });
    }
    let floating = robots.first().map(|f| f.0);
    for (b, view) in robots {
        note_dynamics_of_base(*view, &bodies[*b], notes)?;
    }
    let is_part = |top: &Option<usize>| match (floating, top) {
        (Some(f), top) => *top == Some(f),
        (None, top) => top.is_some_and(|t| !objects.iter().any(|o| o.0 == t)),
    };
    Ok((floating, top.iter().map(is_part).collect()))
}

/// The names of bodies, each once, for a message.
fn listed(bodies: &[MjcfBody], list: impl Iterator<Item = usize>) -> String {
    let mut names: Vec<String> = list.map(|b| shown(&bodies[b].name)).collect();
    names.dedup();
    names.join(", ")
}

/// The children of the world that move and are not the robot `root`. Bodies that the world carries without a joint stay in the
/// base.
///
/// Fails if no child of the world that moves has this name.
fn left_out(
    bodies: &[MjcfBody],
    top: &[Option<usize>],
    root: &str,
    notes: &mut Vec<Note>,
) -> Result<Vec<usize>, Error> {
    let moves = |t: usize| (1..bodies.len()).any(|b| top[b] == Some(t) && !bodies[b].joints.is_empty());
    let moving: Vec<usize> = (1..bodies.len()).filter(|t| top[*t] == Some(*t) && moves(*t)).collect();
    let (chosen, others): (Vec<usize>, Vec<usize>) = moving.iter().partition(|t| bodies[**t].name == root);
    if chosen.is_empty() {
        let all = listed(bodies, moving.into_iter());
        let message = format!("[root]: the world has no body `{}` that moves; it has {all}", shown(root));
        return Err(bodies[0].element.error(message));
    }
    if !others.is_empty() {
        let all = listed(bodies, others.iter().copied());
        let text = format!("is the robot, as is asked for; not read are the other bodies that move ({all})");
        notes.push(Note { subject: shown(root), text });
    }
    Ok(others)
}

/// Notes on the dynamics of a free joint that carries the floating base.
fn note_dynamics_of_base(view: View, body: &MjcfBody, notes: &mut Vec<Note>) -> Result<(), Error> {
    for name in ["armature", "damping", "frictionloss"] {
        if let Some(given) = view.numbers(name, 1, 9)?.filter(|given| given.iter().any(|x| *x != 0.0)) {
            let text = format!(
                "has the `{name}` {} on its free joint, which is not read: no motor turns a floating base. MuJoCo counts \
                 it; <freejoint> takes none from a <default>",
                given[0]
            );
            notes.push(Note { subject: shown(&body.name), text });
        }
    }
    Ok(())
}

/// Reads a joint; also returns its point in the frame of its body, m.
fn joint<'a>(
    view: View<'a>,
    frame: &Pose,
    body: usize,
    (antecedent, place): (Option<usize>, Pose),
    of: &MjcfBody,
    compiler: &Compiler,
    notes: &mut Vec<Note>,
) -> Result<(MjcfJoint<'a>, [f64; 3]), Error> {
    let slides = kind(view)? == MjcfJointType::Slide;
    let point = frame.compose(&Pose { position: view.vector("pos")?.unwrap_or([0.0; 3]), ..Pose::IDENTITY }).position;
    let point = point.map(|x| given_length(x, compiler.angles));
    let axis = turned(&frame.rotation, direction(view, "axis", view.vector("axis")?.unwrap_or([0.0, 0.0, 1.0]))?);
    // Removes rounding errors from the axis. The axis is not zero, because `direction` refuses a zero vector.
    let axis = unit_axis(axis, compiler.angles).unwrap_or(axis);
    // The positions of a hinge are angles, possibly in degrees. The positions of a slide are lengths, m.
    let position = |x: f64| if slides { x } else { compiler.angle(x) };
    let reference = position(view.number("ref")?.unwrap_or(0.0));
    let name = view.element.attribute("name").unwrap_or("").to_string();
    let subject = if name.is_empty() { of.name.clone() } else { name.clone() };
    let mut note = |text: &str| notes.push(Note { subject: subject.clone(), text: text.into() });
    // MuJoCo allows damping as a polynomial of the velocity. The robot model has only the first coefficient, viscous friction.
    let damping = view.numbers("damping", 1, 9)?;
    if damping.as_ref().is_some_and(|d| d[1..].iter().any(|x| *x != 0.0)) {
        note(POLYNOMIAL_DAMPING);
    }
    let joint = MjcfJoint {
        name,
        view,
        body,
        given: JointPlacement {
            antecedent,
            pose: place.compose(&Pose { position: point, ..Pose::IDENTITY }),
            axis,
            prismatic: slides,
        },
        reference,
        limits: limits(view, compiler, position)?,
        friction: Friction { viscous: damping.map(|d| d[0]), coulomb: view.number("frictionloss")?, offset: None },
        armature: view.number("armature")?.unwrap_or(0.0),
    };
    Ok((joint, point))
}

fn limits(view: View, compiler: &Compiler, position: impl Fn(f64) -> f64) -> Result<Limits, Error> {
    let range = |range: &str, limited: &str| -> Result<Option<[f64; 2]>, Error> {
        let given = view.vector::<2>(range)?;
        let is_limited = match view.flag(limited)? {
            Some(is_limited) => is_limited,
            None => compiler.ranges_are_limits && given.is_some_and(|[low, high]| low < high),
        };
        Ok(given.filter(|_| is_limited))
    };
    let force = range("actuatorfrcrange", "actuatorfrclimited")?.map(|[low, high]| low.abs().max(high.abs()));
    Ok(Limits {
        position: range("range", "limited")?.map(|[low, high]| (position(low), position(high))),
        effort: force.filter(|force| *force > 0.0),
        ..Limits::default()
    })
}

/// Gives each joint without a name a name made of the name of its body: `BODY_joint`. Fails if a name is used twice.
fn name(joints: &mut [MjcfJoint], bodies: &[MjcfBody]) -> Result<(), Error> {
    for k in 0..joints.len() {
        let own = joints[k].name.clone();
        if own.is_empty() {
            let body = &bodies[joints[k].body].name;
            let mut made = format!("{body}_joint");
            let mut count = 1;
            while joints.iter().any(|joint| joint.name == made) {
                count += 1;
                made = format!("{body}_joint{count}");
            }
            joints[k].name = made;
        } else if let Some(first) = joints[..k].iter().find(|joint| joint.name == own) {
            let line = first.view.element.at().0;
            let message = format!("joint `{}` stands twice, first on line {line}", shown(&own));
            return Err(joints[k].view.element.error(message));
        }
    }
    Ok(())
}

impl MjcfJoint<'_> {
    pub(super) fn rotor_inertia(&self) -> RotorInertia {
        if self.armature > 0.0 { RotorInertia::Known(self.armature) } else { RotorInertia::Absent }
    }
}
