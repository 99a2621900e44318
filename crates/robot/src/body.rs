//! The rigid bodies of a robot with the numbers as the file gives them, and what is known of their surroundings.

use crate::collision::Collision;
use crate::extent::{Extent, MeshPoints};
use crate::inertial::{Part, Pose, turned_inertia};
use crate::robot::{JointKind, Link, LinkId, Robot};
use crate::vector::{Vector3, norm};

/// A rigid body with the six numbers of its inertia as the file gives them.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub name: String,
    /// The moving link that carries the body; `None`: the base.
    pub link: Option<LinkId>,
    /// Whether this body is the moving link or the root itself, and not a body that is fixed to one of them.
    pub own: bool,
    pub mass: f64,
    /// The six numbers of the file: xx xy xz yy yz zz.
    pub given: [f64; 6],
    /// Whether `given` is about the origin of the frame; otherwise it is about the centre of mass.
    pub about_origin: bool,
    /// Pose of the inertial frame in the frame that the file gives the body. The origin of the inertial frame is the centre of
    /// mass.
    pub pose: Pose,
    /// The extent of the body's collision shapes, in the frame that the file gives the body; `None` if it is not known.
    pub extent: Option<Extent>,
    pub has_shape: bool,
    /// If the body has no collision shapes: the extent of its visual shapes, which often show only a part of the body.
    pub drawn: Option<Extent>,
    /// Whether a joint rotates the body, so that its inertia has an effect. The base counts as rotating.
    pub turns: bool,
    /// Whether the link of this body carries no other link.
    pub is_last: bool,
    /// Length of the longest chain of joints of the robot, m.
    pub reach: f64,
    /// Mass of all other bodies (kg) and the number of other bodies that have a mass.
    pub others: (f64, usize),
}

impl Body {
    /// Inertia about the centre of mass, in the axes of the inertial frame: xx xy xz yy yz zz.
    pub(crate) fn inertia(&self) -> [f64; 6] {
        if self.about_origin { shifted(&self.given, -self.mass, self.pose.position) } else { self.given }
    }

    /// The matrix of second moments about the centre of mass divided by the mass, m^2, in the axes of the file: (tr(I)/2 E - I)/m.
    pub(crate) fn variance(&self) -> [f64; 6] {
        let x = turned_inertia(&self.inertia(), &self.pose.rotation);
        let half_trace = 0.5 * (x[0] + x[3] + x[5]);
        [half_trace - x[0], -x[1], -x[2], half_trace - x[3], -x[4], half_trace - x[5]].map(|s| s / self.mass)
    }

    /// The vector from the origin of the frame that the file gives the body to the centre of mass, in the axes of the inertial
    /// frame.
    pub(crate) fn centre_from_origin(&self) -> Vector3 {
        self.pose.inverse().position.map(|x| -x)
    }
}

/// The six numbers of an inertia plus the parallel-axis term m (c.c E - c c^T), for a shift by c.
pub(crate) fn shifted(six: &[f64; 6], mass: f64, [x, y, z]: Vector3) -> [f64; 6] {
    let shift = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
    std::array::from_fn(|k| six[k] + mass * shift[k])
}

/// All bodies of a robot: first the bodies of the base, then the bodies of each link in order. Links without parameters have
/// none.
pub(crate) fn bodies(robot: &Robot, meshes: MeshPoints) -> Vec<Body> {
    let mut found = Vec::new();
    for (k, part) in robot.base.parts.iter().enumerate() {
        found.push(body(part, None, (&Pose::IDENTITY, k == 0), [&robot.base.collisions, &robot.visuals], meshes));
    }
    for (j, link) in robot.links.iter().enumerate() {
        match link.inertial {
            Some(x) if link.parts.is_empty() => found.push(about_origin(link, &x, j)),
            _ => found.extend(link.parts.iter().map(|part| {
                let own = part.name == link.name;
                let of_file = link.frames.iter().find(|frame| frame.0 == part.name).map(|frame| frame.1);
                let frame = of_file.unwrap_or(link.file_frame);
                body(part, Some(LinkId(j)), (&frame, own), [&link.collisions, &robot.visuals], meshes)
            })),
        }
    }
    let (total, count) = (found.iter().map(|b| b.mass).sum::<f64>(), found.iter().filter(|b| b.mass > 0.0).count());
    let reach = reach(robot);
    for body in &mut found {
        let mut chain = std::iter::successors(body.link, |&j| robot.link(j).antecedent);
        body.turns = body.link.is_none() || chain.any(|j| robot.link(j).joint.kind == JointKind::Revolute);
        body.is_last = body.link.is_some() && !robot.links.iter().any(|link| link.antecedent == body.link);
        body.reach = reach;
        body.others = (total - body.mass, count - usize::from(body.mass > 0.0));
    }
    found
}

/// Makes the body of a part. `frame`: pose of the frame of the body in the frame of the link, and whether the body is the link
/// itself. `shapes`: collision shapes of the link, and visual shapes of the robot.
fn body(
    part: &Part,
    link: Option<LinkId>,
    frame: (&Pose, bool),
    shapes: [&[Collision]; 2],
    meshes: MeshPoints,
) -> Body {
    let to_body = frame.0.inverse();
    let [shapes, drawn] =
        shapes.map(|shapes| shapes.iter().filter(|shape| shape.link == part.name).collect::<Vec<_>>());
    Body {
        name: part.name.clone(),
        link,
        own: frame.1,
        mass: part.mass,
        given: part.inertia,
        about_origin: false,
        pose: to_body.compose(&part.pose),
        extent: Extent::of(&shapes, &to_body, meshes),
        has_shape: !shapes.is_empty(),
        drawn: Extent::of(&drawn, &Pose::IDENTITY, meshes),
        turns: true,
        is_last: false,
        reach: 0.0,
        others: (0.0, 0),
    }
}

/// The body of a link whose parameters are given about the origin of its frame.
fn about_origin(link: &Link, x: &[f64; 10], j: usize) -> Body {
    let mass = x[9];
    let position = if mass == 0.0 { [0.0; 3] } else { [x[6] / mass, x[7] / mass, x[8] / mass] };
    let (name, pose) = (link.name.clone(), Pose { position, ..Pose::IDENTITY });
    let part = Part { name, pose, mass, inertia: std::array::from_fn(|k| x[k]) };
    Body { about_origin: true, ..body(&part, Some(LinkId(j)), (&Pose::IDENTITY, true), [&[], &[]], &|_| None) }
}

/// Length of the longest chain of joints, m. It is the sum of the distances between the origins of the joint frames, and of the
/// travel of prismatic joints; infinite if a prismatic joint has no limits.
fn reach(robot: &Robot) -> f64 {
    let mut so_far: Vec<f64> = Vec::new();
    for link in &robot.links {
        // The frame of the file is at the joint; Khalil's frame may be anywhere on the joint axis.
        let own = link.geometry.pose(&robot.symbols, 0.0, 0.0).compose(&link.file_frame);
        let before = link.antecedent.map_or(Pose::IDENTITY, |i| robot.link(i).file_frame);
        let step = norm(before.inverse().compose(&own).position);
        let limits = match link.joint.variable.terms[..] {
            [(k, _)] => robot.coordinates.get(k.0).and_then(|c| c.limits.position),
            _ => None,
        };
        let travel = match link.joint.kind {
            JointKind::Prismatic => limits.map_or(f64::INFINITY, |(low, high)| low.abs().max(high.abs())),
            _ => 0.0,
        };
        so_far.push(link.antecedent.map_or(0.0, |i| so_far[i.0]) + step + travel);
    }
    so_far.into_iter().fold(0.0, f64::max)
}
