//! Where gravity points, for a log that its description does not predict as its base is mounted.
//!
//! The torque of the description's bodies is linear in gravity g, seen from the base:
//!
//! ```text
//! tau_j ~ a P_j(q, dq, ddq) + sum_i b_i G_ij(q)     beside ddq_j, dq_j, its direction and 1
//! ```
//! P without gravity, G_i that of gravity along axis i. Least squares over all joints, each with the weight of its torque,
//! gives b, and its direction is that of gravity. The mount is found where the torques then are predicted much better, and
//! where the passport of the robot so turned has no gross finding left.

use identification::estimate::passport::finding::{Fault, Finding};
use identification::estimate::passport::{JointPassport, Passport};
use identification::signals::records::Records;
use linear_model::states::States;
use nalgebra::{DMatrix, DVector, Rotation3, Unit, Vector3, Vector4};

use crate::description::{turn_base, turn_of_rpy};
use crate::error::Error;
use crate::model::Model;
use crate::mount::Tilt;

/// Samples that are looked at.
const SAMPLES: usize = 400;
/// What is left of the torques, over that as the base is described, below which a mount is found.
const WORTHWHILE_RATIO: f64 = 0.5;
/// A change explains a log as well where it leaves at most so many times as much.
const AS_WELL_RATIO: f64 = 1.25;
/// A joint of fewer samples says nothing beside its own four columns.
const LEAST_SAMPLES: usize = 9;
/// A joint's torque is explained where less than this is left of it, in squares.
const EXPLAINED_JOINT: f64 = 0.5;
/// Descriptions that explain all but this share, in squares, need no other mount.
const WORTH_A_LOOK: f64 = 0.1;
/// Smaller turns are told by the fit, which leaves the bodies free, rad.
const SMALLEST_TURN_RAD: f64 = 0.26;
/// Bases are mounted along an axis: a direction so near to one is that of the axis, rad.
const AXIS_RAD: f64 = 0.09;

/// The samples of a log, with what the description computes for them.
struct Look {
    states: States,
    /// P, then G by axis: sample by sample, n each.
    columns: [Vec<f64>; 4],
}

/// Gravity in the frame of the base, m/s^2, and the share of the torques that it leaves.
pub(crate) struct Gravity {
    vector: Vector3<f64>,
    left: f64,
    /// The joints whose torque it explains: `left` is of these.
    joints: Vec<usize>,
}

/// Where gravity points by the records, and what it leaves as described; `None` where it points as described, and for robots
/// that [`Tilt`] does not know.
///
/// Fails where a record cannot be read.
pub(crate) fn gravity<R: Records + ?Sized>(model: &Model, records: &R) -> Result<Option<(Gravity, f64)>, Error> {
    let Some(look) = Look::of(model, records)? else { return Ok(None) };
    Ok(look.gravity(Vector3::from(model.robot.gravity_number())))
}

/// The turn of the base, as it is described, under which gravity points so: by the shortest way.
pub(crate) fn turn(model: &Model, gravity: &Gravity) -> Rotation3<f64> {
    let described = Vector3::from(model.robot.gravity_number());
    Rotation3::rotation_between(&gravity.vector, &described)
        // Opposite: half a turn about x, or about y where gravity is along x.
        .unwrap_or_else(|| {
            let axis = if described.y != 0.0 || described.z != 0.0 { Vector3::x() } else { Vector3::y() };
            Rotation3::from_axis_angle(&Unit::new_normalize(axis), std::f64::consts::PI)
        })
}

/// Adds a mount to the findings of a passport, where one explains the log. `again` makes the passport of another model.
///
/// Fails where a record cannot be read.
pub(crate) fn look_for_mount<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    passport: &mut Passport,
    again: impl FnOnce(&Model) -> Result<Passport, Error>,
) -> Result<(), Error> {
    if !passport.findings.iter().any(|finding| may_be_mount(finding.fault)) && unexplained(passport) < WORTH_A_LOOK {
        return Ok(());
    }
    let Some(look) = Look::of(model, records)? else { return Ok(()) };
    let described = Vector3::from(model.robot.gravity_number());
    let Some((gravity, before)) = look.gravity(described) else { return Ok(()) };
    let turn = turn(model, &gravity);
    let base = turn_of_rpy(model.description.as_ref().and_then(|d| d.base).unwrap_or_default()) * turn;
    let (roll, pitch, yaw) = base.euler_angles();
    let rpy = [roll, pitch, yaw];
    let turned = model.changed(|robot| turn_base(robot, &turn), |description| description.base = Some(rpy))?;
    if again(&turned)?.findings.iter().any(|finding| finding.fault.is_gross()) {
        return Ok(());
    }
    // What else was found stays where it explains the log as well.
    let of = |finding: &Finding| match finding.fault {
        Fault::Zero(angle) => {
            let joint =
                finding.joints.first().and_then(|name| model.regressor().coordinates().iter().position(|c| c == name));
            joint.map(|k| look.moved(model, k, angle).left(described, &gravity.joints))
        }
        _ => None,
    };
    let others: Vec<f64> = passport.findings.iter().map(|f| of(f).unwrap_or(f64::INFINITY)).collect();
    let mut lefts = others.iter();
    passport.findings.retain(|finding| {
        let explains_as_well = lefts.next().is_some_and(|left| *left <= AS_WELL_RATIO * gravity.left);
        !may_be_mount(finding.fault) || explains_as_well
    });
    let along = |v: Vector3<f64>| v.normalize().iter().map(|x| format!("{x:.2}")).collect::<Vec<_>>().join(", ");
    let finding = Finding {
        fault: Fault::Mount(turn.angle()),
        joints: Vec::new(),
        evidence: format!(
            "gravity along ({}) of the base leaves {:.1} % of the torques that it explains (joints alike), along ({}) as described {:.0} %",
            along(gravity.vector),
            100.0 * gravity.left,
            along(described),
            100.0 * before
        ),
        remedy: mounted(rpy),
    };
    let place = if others.iter().any(|left| *left < gravity.left) { passport.findings.len() } else { 0 };
    passport.findings.insert(place, finding);
    Ok(())
}

/// What holds the mount: an option, and the joint of a URDF.
pub(crate) fn mounted(rpy: [f64; 3]) -> String {
    // A digit less, and a quarter turn is none.
    let [roll, pitch, yaw] =
        rpy.map(|angle| format!("{angle:.5}").trim_end_matches('0').trim_end_matches('.').to_string());
    let [roll, pitch, yaw] = [roll, pitch, yaw].map(|angle| if angle == "-0" { "0".into() } else { angle });
    format!(
        "[base={roll},{pitch},{yaw}], or in a URDF <joint name=\"mount\" type=\"fixed\"><parent link=\"world\"/><child \
         link=\"ROOT\"/><origin rpy=\"{roll} {pitch} {yaw}\"/></joint> with the root link of the file for ROOT"
    )
}

/// The share of the torques, joints alike and in squares, that the description does not explain with its own sign.
fn unexplained(passport: &Passport) -> f64 {
    let of_joint = |j: &JointPassport| Some(if j.slope? > 0.0 { 1.0 - j.share? } else { 1.0 });
    let all: Vec<f64> = passport.joints.iter().filter_map(of_joint).collect();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

/// Whether another mount could be the cause.
fn may_be_mount(fault: Fault) -> bool {
    matches!(
        fault,
        Fault::OtherRobot
            | Fault::Zero(_)
            | Fault::TorqueSigns
            | Fault::TorqueSign
            | Fault::MotionSign
            | Fault::Reversed
    )
}

impl Look {
    fn of<R: Records + ?Sized>(model: &Model, records: &R) -> Result<Option<Look>, Error> {
        let records: Vec<States> = records.thinned(SAMPLES)?.records.into_iter().map(|(_, states)| states).collect();
        Ok(Look::of_states(model, States::joined(&records)))
    }

    fn of_states(model: &Model, states: States) -> Option<Look> {
        let (parameters, n, p) = (model.described_parameters()?, states.n, model.regressor().parameters().len());
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let tilts = axes.map(|axis| Tilt::of(&model.robot, axis));
        let [Some(x), Some(y), Some(z)] = tilts else { return None };
        if !model.robot.passive.is_empty() {
            return None;
        }
        let described = model.robot.gravity_number();
        let mut columns = [const { Vec::new() }; 4];
        let mut rows = vec![0.0; n * p];
        for r in 0..states.len() {
            let at = r * n..(r + 1) * n;
            model.regressor().fill(&states.q[at.clone()], &states.dq[at.clone()], &states.ddq[at.clone()], &mut rows);
            let by_axis = [&x, &y, &z].map(|tilt| tilt.torques(&states.q[at.clone()]));
            for (j, row) in rows.chunks_exact(p.max(1)).enumerate() {
                let whole: f64 = row.iter().zip(&parameters).map(|(y, x)| y * x).sum();
                let gravity: f64 = by_axis.iter().zip(described).map(|(torques, g)| torques[j] * g).sum();
                columns[0].push(whole - gravity);
                (0..3).for_each(|i| columns[i + 1].push(by_axis[i][j]));
            }
        }
        Some(Look { states, columns })
    }

    /// The same with the zero of a joint moved.
    fn moved(&self, model: &Model, k: usize, angle: f64) -> Look {
        let mut states = self.states.clone();
        states.q.iter_mut().skip(k).step_by(states.n).for_each(|q| *q += angle);
        // The robot has columns, since this look has.
        Look::of_states(model, states)
            .unwrap_or_else(|| Look { states: self.states.clone(), columns: self.columns.clone() })
    }

    /// Of joint j: its torque and the columns of the description, without what the joint's own columns explain, over the norm
    /// of the torque; `None` where nothing is left.
    fn joint(&self, j: usize) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let states = &self.states;
        let used: Vec<usize> = (0..states.len()).map(|r| r * states.n + j).filter(|&i| states.used[i]).collect();
        if used.len() < LEAST_SAMPLES {
            return None;
        }
        let column = |x: &[f64]| DVector::from_iterator(used.len(), used.iter().map(|&i| x[i]));
        let own =
            [column(&states.ddq), column(&states.dq), column(&states.direction), DVector::repeat(used.len(), 1.0)];
        let own = finite(DMatrix::from_columns(&own))?.svd(true, false).u?;
        let without = |x: DVector<f64>| &x - &own * own.tr_mul(&x);
        let torque = without(column(&states.tau));
        let norm = torque.norm();
        let columns = DMatrix::from_columns(&self.columns.each_ref().map(|x| without(column(x))));
        (norm > 0.0).then(|| (torque / norm, columns / norm))
    }

    /// What gravity leaves of each joint's torque, in squares; `None` of a joint without torque.
    fn by_joint(&self, gravity: Vector3<f64>) -> Vec<Option<f64>> {
        let of_joint = |(torque, columns): (DVector<f64>, DMatrix<f64>)| {
            let predicted = columns * Vector4::new(1.0, gravity.x, gravity.y, gravity.z);
            // Bodies of a description are wrong by tens of per cent.
            let slope = (predicted.dot(&torque) / predicted.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.5, 2.0);
            (torque - predicted * slope).norm_squared()
        };
        (0..self.states.n).map(|j| self.joint(j).map(of_joint)).collect()
    }

    /// Gravity by least squares, and what it leaves as described.
    fn gravity(&self, described: Vector3<f64>) -> Option<(Gravity, f64)> {
        let (mut normal, mut right) = (DMatrix::zeros(4, 4), DVector::zeros(4));
        for (torque, columns) in (0..self.states.n).filter_map(|j| self.joint(j)) {
            normal += columns.tr_mul(&columns);
            right += columns.tr_mul(&torque);
        }
        let found = finite(normal)?.svd(true, true).solve(&right, f64::EPSILON).ok()?;
        let direction = Vector3::new(found[1], found[2], found[3]).try_normalize(f64::MIN_POSITIVE)?;
        let nearest = direction.iamax();
        let axis = Vector3::ith(nearest, direction[nearest].signum());
        let direction = if direction.angle(&axis) < AXIS_RAD { axis } else { direction };
        let vector = direction * described.norm();
        // Light joints follow no description.
        let is_explained = |left: Option<f64>| left.is_some_and(|left| left < EXPLAINED_JOINT);
        let by_joint = self.by_joint(vector);
        let joints: Vec<usize> = (0..self.states.n).filter(|&j| is_explained(by_joint[j])).collect();
        let gravity = Gravity { vector, left: mean(&by_joint, &joints), joints };
        let before = self.left(described, &gravity.joints);
        let is_found = vector.angle(&described) > SMALLEST_TURN_RAD
            && gravity.joints.len() >= 2.min(self.states.n)
            && gravity.left < WORTHWHILE_RATIO * before;
        is_found.then_some((gravity, before))
    }

    /// What gravity leaves of the torques of some joints, these alike.
    fn left(&self, gravity: Vector3<f64>, joints: &[usize]) -> f64 {
        mean(&self.by_joint(gravity), joints)
    }
}

/// A matrix of finite numbers: the decomposition of another would not end.
fn finite(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    matrix.iter().all(|x| x.is_finite()).then_some(matrix)
}

/// The root of the mean square of some joints.
fn mean(by_joint: &[Option<f64>], joints: &[usize]) -> f64 {
    (joints.iter().filter_map(|&j| by_joint[j]).sum::<f64>() / joints.len().max(1) as f64).sqrt()
}
