//! Searches another direction of gravity, if a log contradicts the mount of the base in the description.
//!
//! The torque of the described bodies is linear in gravity g in the frame of the base:
//!
//! ```text
//! tau_j ~ a P_j(q, dq, ddq) + sum_i b_i G_ij(q) + terms in ddq_j, dq_j, its direction and 1
//! ```
//! tau_j: torque of joint j; "its direction": the sign of dq_j; a: common factor of the bodies' torques; P_j: torque of joint j
//! by the described bodies without gravity; G_ij: torque of joint j by unit gravity along axis i of the base; b: a times
//! gravity. Least squares over all joints, with each joint divided by the norm of its torque, gives b, which points along
//! gravity. The new mount is accepted if it lowers the residual of the torques strongly, and if a log check with the new mount
//! has fewer gross findings or none. Findings that remain are reported too.

use identification::estimate::hypothesis::Hypothesis;
use identification::estimate::log_check::finding::{Fault, Finding};
use identification::estimate::log_check::{AS_WELL_RATIO, LogCheck};
use identification::signals::records::Records;
use linear_model::states::States;
use nalgebra::{DMatrix, DVector, Rotation3, Vector3, Vector4};

use crate::describe::description::{rounded_rpy, turn_base, turn_of_rpy};
use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::mount::{Tilt, axes};

/// Largest number of samples of a log that are evaluated.
const EVALUATED_SAMPLES: usize = 400;
/// Another mount (orientation of the base) is accepted only if it reduces the relative residual of the torques enough: the
/// residual with this mount, divided by the residual with the described mount, must be below this value.
const ACCEPTED_RESIDUAL_RATIO: f64 = 0.5;
/// For a short motion: another mount is reported only if its squared residual, divided by the squared residual of the described
/// mount, is at most this value.
const SHORT_MOTION_RATIO: f64 = 0.1;
/// Least number of used samples of a joint, since four columns (ddq, dq, sign of dq, 1) are fitted to each joint alone.
const LEAST_SAMPLES: usize = 9;
/// The torque of a joint counts as explained if its squared relative residual is below this value.
const EXPLAINED_JOINT_RESIDUAL: f64 = 0.5;
/// No other mount is searched if the squared relative residual of the description is below this value.
const LEAST_UNEXPLAINED_SHARE: f64 = 0.1;
/// Smallest rotation of gravity that the log check searches, rad. Smaller rotations are identified by the fit, which does not
/// assume the described bodies.
const SMALLEST_TURN_RAD: f64 = 0.26;
/// A direction is replaced by an axis of the base if the angle between them is below this value, rad, because bases are usually
/// mounted along an axis.
const AXIS_TOLERANCE_RAD: f64 = 0.09;

/// Range of the common factor that is fitted to the torques of the described bodies, since descriptions are inaccurate.
const LEAST_FACTOR: f64 = 0.5;
const LARGEST_FACTOR: f64 = 2.0;

/// Samples of a log. For each joint: the torques of the joint with the columns that predict these torques; `None` for a joint
/// that is not used.
struct SampledLog {
    states: States,
    joints: Vec<Option<GravityOfJoint>>,
}

/// The samples of one joint: its torque, its torque P without gravity, and its torques G by unit gravity along each axis. The
/// joint's own columns (ddq, dq, sign of dq, 1) are projected out of these torques. All torques are divided by the norm of the
/// projected measured torque.
struct GravityOfJoint {
    torque: DVector<f64>,
    columns: DMatrix<f64>,
}

/// A found gravity vector in the frame of the base, m/s^2, with the relative residuals of the torques: `left` with this vector,
/// `before` with the described mount.
struct Gravity {
    vector: Vector3<f64>,
    left: f64,
    before: f64,
    /// The joints whose torque this vector explains. Both residuals are computed over these joints.
    joints: Vec<usize>,
}

/// Estimates gravity from the records, m/s^2 in the frame of the base, as an initial guess. Returns the vector of the
/// description if the residual with this vector is not larger, or if [`Tilt`] cannot compute the torques of gravity for the
/// robot.
///
/// Fails if a record cannot be read.
pub(crate) fn gravity<R: Records + ?Sized>(model: &Model, records: &R) -> Result<Vector3<f64>, Error> {
    let described = Vector3::from(model.robot.gravity_number());
    let found = SampledLog::of(model, records)?.and_then(|look| look.gravity(described));
    Ok(found.filter(|found| found.left < found.before).map_or(described, |found| found.vector))
}

/// The orientation of the base with which gravity has the direction `gravity` in the base frame: the described orientation,
/// rotated by the smallest possible angle.
pub fn base(model: &Model, gravity: &Vector3<f64>) -> Rotation3<f64> {
    let described = Vector3::from(model.robot.gravity_number());
    // If the directions are opposite, the rotation is half a turn about an axis perpendicular to gravity.
    let turn = Rotation3::rotation_between(gravity, &described)
        .unwrap_or_else(|| Rotation3::from_scaled_axis(axes(&described)[0].1 * std::f64::consts::PI));
    turn_of_rpy(model.description.as_ref().and_then(|d| d.base).unwrap_or_default()) * turn
}

/// Adds another mount to the findings of a log check, if it explains the log. `again`: checks the log with another model.
///
/// Fails if a record cannot be read.
pub(crate) fn look_for_mount<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    log_check: &mut LogCheck,
    again: impl FnOnce(&Model) -> Result<LogCheck, Error>,
) -> Result<(), Error> {
    let has_cause = log_check.findings.iter().any(|finding| may_be_mount(finding.fault));
    if !has_cause && log_check.unexplained() < LEAST_UNEXPLAINED_SHARE {
        return Ok(());
    }
    let Some(look) = SampledLog::of(model, records)? else { return Ok(()) };
    let described = Vector3::from(model.robot.gravity_number());
    let Some(gravity) = look.gravity(described).filter(|found| look.is_mount(found, &described)) else { return Ok(()) };
    // Angles are rounded to five digits. With fewer digits, pi/2 would not be recognised as a quarter turn.
    let rpy = rounded_rpy(&base(model, &gravity.vector), 5);
    // If the base parameters cannot be derived with this mount, the mount is not proposed.
    let Ok(turned) = model.changed(|robot| turn_base(robot, rpy), |description| description.base = Some(rpy)) else {
        return Ok(());
    };
    let turned = again(&turned)?;
    // If gross findings remain with this mount, the mount is not the cause.
    if turned.findings.iter().any(|f| f.fault.is_gross() && f.tried.is_none()) {
        return Ok(());
    }
    let shares =
        [log_check.unexplained(), turned.findings.iter().find_map(|f| f.tried).map_or(turned.unexplained(), |t| t[1])];
    // In a short motion, a mount that explains the log only in part may be chance.
    if log_check.is_short && shares[1] > SHORT_MOTION_RATIO * shares[0] {
        return Ok(());
    }
    let mount = Finding { tried: Some(shares), ..gravity.finding(described, rpy) };
    // Other explanations are kept together with the mount if their residual is about equal. Other explanations replace the
    // mount if their residual is smaller or if they need fewer faults.
    let own: Vec<[f64; 2]> = log_check.findings.iter().filter(|f| f.instead == 0).filter_map(|f| f.tried).collect();
    let gross_count = turned.findings.iter().filter(|f| f.fault.is_gross()).count();
    let left = own.iter().map(|tried| tried[1]).reduce(f64::max);
    let mounted = std::iter::once(mount).chain(turned.findings);
    match left {
        Some(left) if left <= shares[1] / AS_WELL_RATIO || own.len() <= gross_count => return Ok(()),
        Some(left) if left <= shares[1] * AS_WELL_RATIO => log_check.put_before(mounted.collect()),
        _ => {
            log_check.findings = mounted.collect();
            log_check.explained = turned.explained;
        }
    }
    Ok(())
}

impl Gravity {
    /// The finding that the base is mounted with roll, pitch and yaw `rpy`, rad, and not as in the description.
    fn finding(&self, described: Vector3<f64>, rpy: [f64; 3]) -> Finding {
        let along = |v: Vector3<f64>| v.normalize().iter().map(|x| format!("{x:.2}")).collect::<Vec<_>>().join(", ");
        let evidence = format!(
            "the residual with gravity along ({}) of the base is {:.1} % of the torques that gravity explains (joints alike), along the nominal ({}) {:.0} %",
            along(self.vector),
            100.0 * self.left,
            along(described),
            100.0 * self.before
        );
        let remedy = format!(
            "{}; as accurate as the nominal bodies: [unknowns=mount] estimates it with its sigma",
            mounted(rpy)
        );
        Finding::of(Fault::Mount(self.vector.angle(&described)), Vec::new(), evidence, remedy)
    }
}

/// Text for the user that sets the mount: as an option, and as a joint in a URDF. Roll, pitch and yaw in rad.
pub fn mounted([roll, pitch, yaw]: [f64; 3]) -> String {
    format!(
        "[base={roll},{pitch},{yaw}], or in a URDF <joint name=\"mount\" type=\"fixed\"><parent link=\"world\"/><child \
         link=\"ROOT\"/><origin rpy=\"{roll} {pitch} {yaw}\"/></joint> with the root link of the file for ROOT"
    )
}

/// Whether another mount could be the cause of this fault.
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

impl SampledLog {
    fn of<R: Records + ?Sized>(model: &Model, records: &R) -> Result<Option<SampledLog>, Error> {
        let thinned = records.thinned(EVALUATED_SAMPLES)?.records;
        let records: Vec<States> = thinned.into_iter().map(|(_, states)| states).collect();
        Ok(SampledLog::of_states(model, States::joined(&records)))
    }

    fn of_states(model: &Model, states: States) -> Option<SampledLog> {
        let (parameters, n, p) = (model.nominal_parameters()?, states.n, model.regressor().parameters().len());
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [Some(x), Some(y), Some(z)] = axes.map(|axis| Tilt::of(&model.robot, axis)) else { return None };
        if !model.robot.passive.is_empty() {
            return None;
        }
        let described = model.robot.gravity_number();
        // The columns P (torques without gravity) and G_x, G_y, G_z (torques by unit gravity along an axis); each has n entries
        // per sample.
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
        let joints = (0..n).map(|j| GravityOfJoint::of(&states, &columns, j)).collect();
        Some(SampledLog { states, joints })
    }

    /// Squared relative residual of each joint's torque with the vector `gravity`, m/s^2; `None` for a joint without torque.
    fn by_joint(&self, gravity: Vector3<f64>) -> Vec<Option<f64>> {
        let of_joint = |GravityOfJoint { torque, columns }: &GravityOfJoint| {
            let predicted = columns * Vector4::new(1.0, gravity.x, gravity.y, gravity.z);
            // A common factor is fitted to the described torques, because descriptions are wrong by tens of per cent.
            let slope = predicted.dot(torque) / predicted.norm_squared().max(f64::MIN_POSITIVE);
            let slope = slope.clamp(LEAST_FACTOR, LARGEST_FACTOR);
            (torque - predicted * slope).norm_squared()
        };
        self.joints.iter().map(|joint| joint.as_ref().map(of_joint)).collect()
    }

    /// Gravity by least squares, scaled to the length of `described`; `None` if no direction is determined.
    fn gravity(&self, described: Vector3<f64>) -> Option<Gravity> {
        let (mut normal, mut right) = (DMatrix::zeros(4, 4), DVector::zeros(4));
        for GravityOfJoint { torque, columns } in self.joints.iter().flatten() {
            normal += columns.tr_mul(columns);
            right += columns.tr_mul(torque);
        }
        let found = finite(normal)?.svd(true, true).solve(&right, f64::EPSILON).ok()?;
        let direction = Vector3::new(found[1], found[2], found[3]).try_normalize(f64::MIN_POSITIVE)?;
        let nearest = direction.iamax();
        let axis = Vector3::ith(nearest, direction[nearest].signum());
        let direction = if direction.angle(&axis) < AXIS_TOLERANCE_RAD { axis } else { direction };
        let vector = direction * described.norm();
        // Only joints whose torque is explained by this gravity count, because descriptions do not predict the torques of light
        // joints.
        let is_explained = |left: Option<f64>| left.is_some_and(|left| left < EXPLAINED_JOINT_RESIDUAL);
        let by_joint = self.by_joint(vector);
        let joints: Vec<usize> = (0..by_joint.len()).filter(|&j| is_explained(by_joint[j])).collect();
        let (left, before) = (mean(&by_joint, &joints), self.left(described, &joints));
        Some(Gravity { vector, left, before, joints })
    }

    /// Whether `found` is large enough, and explains the log well enough, to be reported as another mount.
    fn is_mount(&self, found: &Gravity, described: &Vector3<f64>) -> bool {
        found.vector.angle(described) > SMALLEST_TURN_RAD
            && found.joints.len() >= 2.min(self.states.n)
            && found.left < ACCEPTED_RESIDUAL_RATIO * found.before
    }

    /// Relative residual of the torques of `joints` with the vector `gravity`, all joints weighted equally.
    fn left(&self, gravity: Vector3<f64>, joints: &[usize]) -> f64 {
        mean(&self.by_joint(gravity), joints)
    }
}

impl GravityOfJoint {
    /// The samples of joint j; `None` if the joint's own columns (ddq, dq, sign of dq, 1) explain the whole torque, or if the
    /// joint has too few samples.
    fn of(states: &States, columns: &[Vec<f64>; 4], j: usize) -> Option<GravityOfJoint> {
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
        (norm > 0.0).then(|| GravityOfJoint { torque: torque / norm, columns: columns / norm })
    }
}

/// Returns the matrix if all entries are finite, otherwise `None`. The decomposition of a matrix with other entries would not
/// terminate.
fn finite(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    matrix.iter().all(|x| x.is_finite()).then_some(matrix)
}

/// Root of the mean of the squared residuals `by_joint` over the joints `joints`.
fn mean(by_joint: &[Option<f64>], joints: &[usize]) -> f64 {
    (joints.iter().filter_map(|&j| by_joint[j]).sum::<f64>() / joints.len().max(1) as f64).sqrt()
}
