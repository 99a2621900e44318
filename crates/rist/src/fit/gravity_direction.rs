//! Where gravity points, for a log that its description does not predict as its base is mounted.
//!
//! The torque of the description's bodies is linear in gravity g, seen from the base:
//!
//! ```text
//! tau_j ~ a P_j(q, dq, ddq) + sum_i b_i G_ij(q)     beside ddq_j, dq_j, its direction and 1
//! ```
//! P without gravity, G_i that of gravity along axis i. Least squares over all joints, each with the weight of its torque,
//! gives b, and its direction is that of gravity. The mount is found where the torques then are predicted much better, and
//! where the passport of the robot so turned has no gross finding left, or fewer, which are said beside it.

use identification::estimate::hypothesis::Hypothesis;
use identification::estimate::passport::finding::{Fault, Finding};
use identification::estimate::passport::{AS_WELL_RATIO, Passport};
use identification::signals::records::Records;
use linear_model::states::States;
use nalgebra::{DMatrix, DVector, Rotation3, Vector3, Vector4};

use crate::describe::description::{rounded_rpy, turn_base, turn_of_rpy};
use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::mount::{Tilt, axes};

/// Samples that are looked at.
const SAMPLES: usize = 400;
/// What is left of the torques, over that as the base is described, below which a mount is found.
const WORTHWHILE_RATIO: f64 = 0.5;
/// Share of what is left as described, in squares, below which a mount is said of a short motion.
const SHORT_SHARE: f64 = 0.1;
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

/// The samples of a log, and of each joint what they and the description say.
struct Look {
    states: States,
    joints: Vec<Option<Joint>>,
}

/// Of one joint: its torque, and P and G of the description by axis, without what the joint's own columns explain, over the
/// norm of the torque.
struct Joint {
    torque: DVector<f64>,
    columns: DMatrix<f64>,
}

/// Gravity in the frame of the base, m/s^2, and the share of the torques that it leaves and that as described leaves.
struct Gravity {
    vector: Vector3<f64>,
    left: f64,
    before: f64,
    /// The joints whose torque it explains: both are of these.
    joints: Vec<usize>,
}

/// Where gravity points by the records, m/s^2 in the frame of the base: a place to begin from. As described where that
/// explains them as well, and for robots that [`Tilt`] does not know.
///
/// Fails where a record cannot be read.
pub(crate) fn gravity<R: Records + ?Sized>(model: &Model, records: &R) -> Result<Vector3<f64>, Error> {
    let described = Vector3::from(model.robot.gravity_number());
    let found = Look::of(model, records)?.and_then(|look| look.gravity(described));
    Ok(found.filter(|found| found.left < found.before).map_or(described, |found| found.vector))
}

/// The base, from where it is described by the shortest turn, under which gravity points so.
pub fn base(model: &Model, gravity: &Vector3<f64>) -> Rotation3<f64> {
    let described = Vector3::from(model.robot.gravity_number());
    // Opposite: half a turn about an axis across it.
    let turn = Rotation3::rotation_between(gravity, &described)
        .unwrap_or_else(|| Rotation3::from_scaled_axis(axes(&described)[0].1 * std::f64::consts::PI));
    turn_of_rpy(model.description.as_ref().and_then(|d| d.base).unwrap_or_default()) * turn
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
    let has_cause = passport.findings.iter().any(|finding| may_be_mount(finding.fault));
    if !has_cause && passport.unexplained() < WORTH_A_LOOK {
        return Ok(());
    }
    let Some(look) = Look::of(model, records)? else { return Ok(()) };
    let described = Vector3::from(model.robot.gravity_number());
    let Some(gravity) = look.gravity(described).filter(|found| look.is_mount(found, &described)) else { return Ok(()) };
    // A digit less, and a quarter turn is none.
    let rpy = rounded_rpy(&base(model, &gravity.vector), 5);
    // A base under which no base parameters are told is none to advise.
    let Ok(turned) = model.changed(|robot| turn_base(robot, rpy), |description| description.base = Some(rpy)) else {
        return Ok(());
    };
    let turned = again(&turned)?;
    // A base under which something is wrong still is not the cause.
    if turned.findings.iter().any(|f| f.fault.is_gross() && f.tried.is_none()) {
        return Ok(());
    }
    let shares =
        [passport.unexplained(), turned.findings.iter().find_map(|f| f.tried).map_or(turned.unexplained(), |t| t[1])];
    // Of a short motion, what explains a part of it is chance.
    if passport.is_short && shares[1] > SHORT_SHARE * shares[0] {
        return Ok(());
    }
    let mount = Finding { tried: Some(shares), ..gravity.finding(described, rpy) };
    // What else mends the log stays, where it leaves as little, and alone where fewer faults do.
    let own: Vec<[f64; 2]> = passport.findings.iter().filter(|f| f.instead == 0).filter_map(|f| f.tried).collect();
    let beside = turned.findings.iter().filter(|f| f.fault.is_gross()).count();
    let left = own.iter().map(|tried| tried[1]).reduce(f64::max);
    let mounted = std::iter::once(mount).chain(turned.findings);
    match left {
        Some(left) if left <= shares[1] / AS_WELL_RATIO || own.len() <= beside => return Ok(()),
        Some(left) if left <= shares[1] * AS_WELL_RATIO => passport.put_before(mounted.collect()),
        _ => {
            passport.findings = mounted.collect();
            passport.explained = turned.explained;
        }
    }
    Ok(())
}

impl Gravity {
    /// That the base is mounted as `rpy` says, and not as described.
    fn finding(&self, described: Vector3<f64>, rpy: [f64; 3]) -> Finding {
        let along = |v: Vector3<f64>| v.normalize().iter().map(|x| format!("{x:.2}")).collect::<Vec<_>>().join(", ");
        let evidence = format!(
            "gravity along ({}) of the base leaves {:.1} % of the torques that it explains (joints alike), along ({}) as described {:.0} %",
            along(self.vector),
            100.0 * self.left,
            along(described),
            100.0 * self.before
        );
        let remedy = format!(
            "{}; as near as the bodies are described: [unknowns=mount] finds it with its deviation",
            mounted(rpy)
        );
        Finding::of(Fault::Mount(self.vector.angle(&described)), Vec::new(), evidence, remedy)
    }
}

/// What holds the mount: an option, and the joint of a URDF.
pub fn mounted([roll, pitch, yaw]: [f64; 3]) -> String {
    format!(
        "[base={roll},{pitch},{yaw}], or in a URDF <joint name=\"mount\" type=\"fixed\"><parent link=\"world\"/><child \
         link=\"ROOT\"/><origin rpy=\"{roll} {pitch} {yaw}\"/></joint> with the root link of the file for ROOT"
    )
}

/// Whether another mount could be the cause.
fn may_be_mount(fault: Fault) -> bool {
    matches!(
        fault,
        Fault::OtherRobot
            | Fault::Unidentified
            | Fault::TorqueSigns
            | Fault::Of(
                Hypothesis::Zero(_) | Hypothesis::TorqueSign(_) | Hypothesis::MotionSign(_) | Hypothesis::Reversed(_),
                _
            )
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
        let [Some(x), Some(y), Some(z)] = axes.map(|axis| Tilt::of(&model.robot, axis)) else { return None };
        if !model.robot.passive.is_empty() {
            return None;
        }
        let described = model.robot.gravity_number();
        // P, then G by axis: sample by sample, n each.
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
        let joints = (0..n).map(|j| Joint::of(&states, &columns, j)).collect();
        Some(Look { states, joints })
    }

    /// What gravity leaves of each joint's torque, in squares; `None` of a joint without torque.
    fn by_joint(&self, gravity: Vector3<f64>) -> Vec<Option<f64>> {
        let of_joint = |Joint { torque, columns }: &Joint| {
            let predicted = columns * Vector4::new(1.0, gravity.x, gravity.y, gravity.z);
            // Bodies of a description are wrong by tens of per cent.
            let slope = (predicted.dot(torque) / predicted.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.5, 2.0);
            (torque - predicted * slope).norm_squared()
        };
        self.joints.iter().map(|joint| joint.as_ref().map(of_joint)).collect()
    }

    /// Gravity by least squares.
    fn gravity(&self, described: Vector3<f64>) -> Option<Gravity> {
        let (mut normal, mut right) = (DMatrix::zeros(4, 4), DVector::zeros(4));
        for Joint { torque, columns } in self.joints.iter().flatten() {
            normal += columns.tr_mul(columns);
            right += columns.tr_mul(torque);
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
        let joints: Vec<usize> = (0..by_joint.len()).filter(|&j| is_explained(by_joint[j])).collect();
        let (left, before) = (mean(&by_joint, &joints), self.left(described, &joints));
        Some(Gravity { vector, left, before, joints })
    }

    /// Whether it is another mount that explains the log.
    fn is_mount(&self, found: &Gravity, described: &Vector3<f64>) -> bool {
        found.vector.angle(described) > SMALLEST_TURN_RAD
            && found.joints.len() >= 2.min(self.states.n)
            && found.left < WORTHWHILE_RATIO * found.before
    }

    /// What gravity leaves of the torques of some joints, these alike.
    fn left(&self, gravity: Vector3<f64>, joints: &[usize]) -> f64 {
        mean(&self.by_joint(gravity), joints)
    }
}

impl Joint {
    /// Of joint j; `None` where nothing of its torque is left.
    fn of(states: &States, columns: &[Vec<f64>; 4], j: usize) -> Option<Joint> {
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
        let columns = DMatrix::from_columns(&columns.each_ref().map(|x| without(column(x))));
        (norm > 0.0).then(|| Joint { torque: torque / norm, columns: columns / norm })
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
