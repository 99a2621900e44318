//! The largest torque that each joint needs against gravity, over the postures of the robot, compared with the effort limit of
//! the joint.
//!
//! tau_j = -dU/dq_j, U: potential energy. As a function of one revolute coordinate q that rotates the links by +q or -q, tau_j
//! is A cos q + B sin q + C, so three values give its extremes within the limits. The search treats one coordinate after the
//! other. Its result is the torque of one posture, and so a lower bound of the largest torque.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::body_doubt::shown;
use crate::finding::{Finding, Mistake};
use crate::inertial::Pose;
use crate::robot::{Drive, JointKind, LinkId, Robot};
use crate::vector::{Vector3, cross, dot, minus, plus_scaled, scaled, turned};

/// Number of passes through the coordinates.
const PASSES: usize = 3;
/// An axis counts as vertical if its angle to gravity is at most this value, rad. Angles in files have at least nine digits.
const UPRIGHT_SLACK: f64 = 1e-9;
/// A torque exceeds the limit only if it is above this multiple of the limit, because limits are rounded.
const EXCEEDED: f64 = 1.05;

/// Adds the findings on the joints. `is_doubted`: whether there is a finding on a mass; then torques are not compared with
/// their limits.
pub(crate) fn gravity_load(robot: &Robot, is_doubted: bool, findings: &mut Vec<Finding>) {
    let is_weightless = !robot.links.iter().any(|link| link.inertial.is_some_and(|x| x[9] > 0.0));
    // A floating robot cannot hold a posture without contacts, and in a loop several joints share a load. Such robots are not
    // checked.
    if is_weightless || robot.massless > 0 || !robot.loops.is_empty() {
        return;
    }
    for j in robot.link_ids() {
        let joint = &robot.link(j).joint;
        let ([(k, _)], Drive::Actuated) = (&joint.variable.terms[..], joint.drive) else { continue };
        if is_upright(robot, j) {
            let fact = "the axis is vertical in every posture: gravity never asks for a torque here";
            findings.push(Finding::new(&joint.name, Mistake::NoGravity, fact, ""));
            continue;
        }
        let limit =
            robot.coordinates.get(k.0).and_then(|c| c.limits.effort).filter(|effort| *effort > 0.0 && !is_doubted);
        let Some(limit) = limit else { continue };
        let worst = worst(robot, j);
        if worst > EXCEEDED * limit {
            let unit = if joint.kind == JointKind::Prismatic { "N" } else { "N m" };
            let text = format!("{} {unit} in the worst posture, the limit is {limit} {unit}", shown(worst, 3));
            let fact = "gravity alone asks for more than the limit of the effort";
            findings.push(Finding::new(&joint.name, Mistake::Effort, fact, text));
        }
    }
}

/// Whether the axis of a revolute joint is parallel to gravity in every posture. This holds if this axis and all revolute axes
/// before it are parallel to gravity at the zero position.
fn is_upright(robot: &Robot, j: LinkId) -> bool {
    let poses = robot.link_poses(&vec![0.0; robot.n_variables()]);
    let g = robot.gravity_number();
    let chain = std::iter::successors(Some(j), |&i| robot.link(i).antecedent);
    let mut turning = chain.filter(|&i| robot.link(i).joint.kind == JointKind::Revolute);
    let is_parallel = |i: LinkId| {
        let axis = turned(&poses[i.0].rotation, [0.0, 0.0, 1.0]);
        let across = cross(axis, g);
        dot(across, across) <= UPRIGHT_SLACK * UPRIGHT_SLACK * dot(g, g)
    };
    robot.link(j).joint.kind == JointKind::Revolute && turning.all(is_parallel)
}

/// The largest absolute torque of joint j against gravity that the search found, N m (N).
fn worst(robot: &Robot, j: LinkId) -> f64 {
    let mut posture = start(robot);
    let mut best = torque(robot, j, &posture).abs();
    // Only the joints before joint j and the joints after it change its torque.
    let mut related = vec![false; robot.n_variables()];
    for i in robot.link_ids().filter(|&i| is_before(robot, i, j) || is_before(robot, j, i)) {
        robot.link(i).joint.variable.terms.iter().for_each(|(k, _)| related[k.0] = true);
    }
    for _ in 0..PASSES {
        for k in (0..robot.n_coordinates()).filter(|&k| related[k]) {
            for candidate in candidates(robot, j, &posture, k) {
                let kept = std::mem::replace(&mut posture[k], candidate);
                let found = torque(robot, j, &posture).abs();
                if found > best {
                    best = found;
                } else {
                    posture[k] = kept;
                }
            }
        }
    }
    best
}

/// Whether link i is link j or carries it.
fn is_before(robot: &Robot, i: LinkId, j: LinkId) -> bool {
    std::iter::successors(Some(j), |&j| robot.link(j).antecedent).any(|j| i == j)
}

/// The posture at which the search starts: each coordinate at zero, or at the position within its limits that is nearest to
/// zero.
fn start(robot: &Robot) -> Vec<f64> {
    let mut posture = vec![0.0; robot.n_variables()];
    for (q, coordinate) in posture.iter_mut().zip(&robot.coordinates) {
        if let Some((low, high)) = coordinate.limits.position.filter(|(low, high)| low <= high) {
            *q = low.max(0.0).min(high);
        }
    }
    posture
}

/// The positions of coordinate k at which the torque of joint j may be extreme: the limits, and the extremes of the sinusoid.
fn candidates(robot: &Robot, j: LinkId, posture: &[f64], k: usize) -> Vec<f64> {
    let is_turning = robot
        .links
        .iter()
        .any(|link| link.joint.kind == JointKind::Revolute && link.joint.variable.terms.iter().any(|(c, _)| c.0 == k));
    let range = robot.coordinates[k].limits.position.filter(|(low, high)| low <= high);
    let mut found: Vec<f64> = range.map_or(vec![], |(low, high)| vec![low, high]);
    if is_turning {
        let at = |q: f64| {
            let mut moved = posture.to_vec();
            moved[k] = q;
            torque(robot, j, &moved)
        };
        let [zero, quarter, half] = [0.0, FRAC_PI_2, PI].map(at);
        let (a, middle) = (0.5 * (zero - half), 0.5 * (zero + half));
        let extreme = (quarter - middle).atan2(a);
        found.extend(
            [extreme, extreme + PI, extreme - PI]
                .into_iter()
                .filter(|q| range.is_none_or(|(low, high)| low <= *q && *q <= high)),
        );
    }
    found.retain(|q| q.is_finite());
    found
}

/// The torque that holds joint j against gravity, N m (N).
fn torque(robot: &Robot, j: LinkId, q: &[f64]) -> f64 {
    let poses = robot.link_poses(q);
    let Pose { rotation, position } = &poses[j.0];
    let axis = turned(rotation, [0.0, 0.0, 1.0]);
    // First moment about the joint and mass of all links that the joint carries.
    let (mut moment, mut mass): (Vector3, f64) = ([0.0; 3], 0.0);
    for i in robot.link_ids().filter(|&i| i.0 >= j.0) {
        let Some(x) = robot.link(i).inertial.filter(|_| is_before(robot, j, i)) else { continue };
        let pose = &poses[i.0];
        let first = plus_scaled(turned(&pose.rotation, [x[6], x[7], x[8]]), minus(pose.position, *position), x[9]);
        (moment, mass) = (plus_scaled(moment, first, 1.0), mass + x[9]);
    }
    let g = robot.gravity_number();
    match robot.link(j).joint.kind {
        JointKind::Revolute => -dot(axis, cross(moment, g)),
        JointKind::Prismatic => -dot(axis, scaled(g, mass)),
        JointKind::Fixed => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use crate::format::read_urdf;
    use crate::lint::{Mistake, lint};

    /// Two rods of 1 m and 2 kg in one plane. The worst torque of the first joint is (1 + 3) 2 9.81/2 = 39.24 N m, and of the
    /// second joint 9.81 N m; both occur where the rods are level.
    fn found(axis: &str, first: &str, second: &str) -> Vec<(String, Mistake)> {
        let joint = |name: &str, parent: &str, child: &str, at: &str, limit: &str| {
            format!(
                "<link name=\"{child}\"><inertial><origin xyz=\"0.5 0 0\"/><mass value=\"2\"/><inertia ixx=\"0.01\" ixy=\"0\" \
                 ixz=\"0\" iyy=\"0.17\" iyz=\"0\" izz=\"0.17\"/></inertial></link><joint name=\"{name}\" type=\"revolute\">\
                 <parent link=\"{parent}\"/><child link=\"{child}\"/><origin xyz=\"{at}\"/><axis xyz=\"{axis}\"/>\
                 <limit {limit} velocity=\"1\"/></joint>"
            )
        };
        let text = format!(
            "<robot name=\"r\"><link name=\"b\"/>{}{}</robot>",
            joint("j1", "b", "l1", "0 0 0.5", first),
            joint("j2", "l1", "l2", "1 0 0", second)
        );
        lint(&read_urdf(&text, "r.urdf").unwrap()).into_iter().map(|f| (f.subjects.join(" "), f.mistake)).collect()
    }

    #[test]
    fn the_worst_posture_within_the_limits_counts() {
        let of = |effort: f64, low: f64, high: f64| format!("effort=\"{effort}\" lower=\"{low}\" upper=\"{high}\"");
        // At the zero position both rods are level. The search must also find this posture if it starts with hanging rods.
        for (effort, low, wanted) in [(36.0, -1.0, true), (39.0, -1.0, false), (36.0, 1.4, false), (36.0, -3.0, true)] {
            let found = found("0 1 0", &of(effort, low, 1.6), &of(20.0, -3.0, 3.0));
            let wanted = if wanted { vec![("j1".to_string(), Mistake::Effort)] } else { vec![] };
            assert_eq!(found, wanted, "{effort} {low}");
        }
        let other = found("0 1 0", &of(50.0, 1.0, 3.0), &of(9.0, -3.0, 3.0));
        assert_eq!(other, [("j2".to_string(), Mistake::Effort)]);
        // An effort limit of 0 does not count as a limit here; another finding reports it.
        let none = found("0 1 0", &of(0.0, -1.0, 1.0), &of(20.0, -3.0, 3.0));
        assert_eq!(none, [("j1".to_string(), Mistake::Limits)]);
    }

    #[test]
    fn vertical_axes_are_a_note() {
        let limit = "effort=\"1\" lower=\"-1\" upper=\"1\"";
        assert_eq!(found("0 0 1", limit, limit), [("j1 j2".to_string(), Mistake::NoGravity)]);
        assert!(found("1 0 0", limit, limit).iter().all(|f| f.1 != Mistake::NoGravity));
    }
}
