//! The transmission from motors to joints: gears, couplings, offsets, drive gains, scales, springs.
//!
//! q = R^-1 q_m + q_0, tau = R' tau_m / s - k q, so that the power is equal on both sides of R; tau_m = K i for currents i and
//! drive gains K. q_m, tau_m: positions and torques of the motors; q_0: offsets; s, k: scale and spring of each joint. R has
//! gear ratios with signs on its diagonal, and couplings off the diagonal. For example, the wrist of a Staubli TX40 has q_m6 =
//! 32 (q_5 + q_6).
//!
//! The inertia and friction of a motor that also turns with other joints act on all of these joints
//! ([`linear_model::coupling`]).

use linear_model::coupling::{Coupled, Coupling};
use linear_model::coupling_parameter::CouplingParameter;
use logs::{Effort, Error, Log, unwrap_angle};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::signals::joint_signals::JointSignals;

/// The transmission between the signals of a log and the joints. A field that is absent changes nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Transmission {
    /// Gear ratio of each joint: motor angle divided by joint angle, with sign. The ratios apply to the torques too.
    pub ratios: Option<Vec<f64>>,
    /// Off-diagonal entries of R: (motor, joint, entry). Motors and joints are counted from 1.
    pub couplings: Vec<(usize, usize, f64)>,
    /// Whether coupled motors have no columns of inertia and friction in the model.
    pub rigid_couplings: bool,
    /// Whether positions and velocities in the log are those of the joints, and only the torques are those of the motors.
    pub joint_side_positions: bool,
    /// Offset of each joint: position in the model minus position in the log, rad (m).
    pub offsets: Option<Vec<f64>>,
    /// Drive gain of each motor, N m/A, at the motor shaft (at the joint if there are no ratios).
    pub drive_gains: Option<Vec<f64>>,
    /// Dead current of each motor, A: the part of the current that gives no torque. The torque is K sign(i) max(|i| - i_0, 0).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dead_currents: Option<Vec<f64>>,
    /// Scale of each joint: torque in the log divided by torque of the joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scales: Option<Vec<f64>>,
    /// Stiffness of a known spring at each joint, N m/rad (N/m). The torque of the spring, stiffness times position in the
    /// model, is subtracted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub springs: Option<Vec<f64>>,
    /// Springs, cables and bearings whose torques are columns of the model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<TransmissionElement>,
}

/// A mechanical element that acts along w = sum_k c_k q_k ([`linear_model::coupling`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransmissionElement {
    /// The name of the element, which is the suffix in the names of its parameters.
    pub name: String,
    /// The joints of the element with their coefficients: pairs (joint, c), joints counted from 1.
    pub along: Vec<(usize, f64)>,
    /// The torques of the element, each with a column in the model.
    pub torques: Vec<CouplingParameter>,
}

impl TransmissionElement {
    /// The reason why the element is invalid for a robot of n joints, as text. `None` if the element is valid.
    fn fault(&self, n: usize) -> Option<String> {
        let joints: Vec<usize> = self.along.iter().map(|(k, _)| *k).collect();
        let is_joint = |(k, c): &(usize, f64)| (1..=n).contains(k) && c.is_finite() && *c != 0.0;
        let is_doubled = |places: &[usize]| places.iter().enumerate().any(|(i, k)| places[..i].contains(k));
        let is_torque_doubled = self.torques.iter().enumerate().any(|(i, t)| self.torques[..i].contains(t));
        if self.name.is_empty() || !self.name.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c)) {
            return Some("its name needs letters, digits, `_`, `-` or `.`, one at least".into());
        }
        if joints.is_empty() || !self.along.iter().all(is_joint) || is_doubled(&joints) {
            let found = &self.along;
            return Some(format!(
                "`along` needs pairs [joint, factor] of different joints of 1 to {n}, factors other than 0; it has {found:?}"
            ));
        }
        if self.torques.is_empty() || is_torque_doubled {
            return Some("`torques` needs one or more different words".into());
        }
        None
    }
}

impl Transmission {
    /// The coupled motors, then the elements (springs, cables, bearings). A motor occurs once, with all joints that turn it.
    /// All motors and elements have columns in the model.
    pub fn coupled(&self) -> Vec<Coupling> {
        let ratio = |m: usize| self.ratios.as_ref().and_then(|r| r.get(m)).copied().unwrap_or(1.0);
        let mut motors: Vec<(usize, Vec<(usize, f64)>)> = Vec::new();
        for &(m, k, r) in self.couplings.iter().filter(|_| !self.rigid_couplings) {
            let (Some(motor), Some(joint)) = (m.checked_sub(1), k.checked_sub(1)) else { continue };
            let turned = (joint, r / ratio(motor));
            match motors.iter_mut().find(|known| known.0 == motor) {
                Some(known) => known.1.push(turned),
                None => motors.push((motor, vec![turned])),
            }
        }
        let element = |element: &TransmissionElement| Coupling {
            of: Coupled::Element(element.name.clone(), element.torques.clone()),
            joints: element.along.iter().map(|&(k, c)| (k.saturating_sub(1), c)).collect(),
        };
        let motors = motors.iter().map(|(motor, others)| Coupling::motor(*motor, others));
        motors.chain(self.elements.iter().map(element)).collect()
    }

    /// Fails if a list does not fit a robot of n joints, or if an element is invalid.
    pub fn check(&self, n: usize) -> Result<(), Error> {
        let lists = [
            ("ratios", &self.ratios),
            ("offsets", &self.offsets),
            ("drive_gains", &self.drive_gains),
            ("dead_currents", &self.dead_currents),
            ("scales", &self.scales),
            ("springs", &self.springs),
        ];
        // Offsets, dead currents and springs may be zero. The other numbers must not be zero, because they multiply or divide
        // the torque.
        for (name, list) in lists {
            let Some(list) = list else { continue };
            if list.len() != n || list.iter().any(|x| !x.is_finite()) {
                return Err(Error::new(format!(
                    "transmission: {name} needs {n} finite numbers, one per joint; it has {list:?}"
                )));
            }
            if !["offsets", "dead_currents", "springs"].contains(&name) && list.contains(&0.0) {
                return Err(Error::new(format!("transmission: {name} holds a zero: {list:?}")));
            }
        }
        if self.dead_currents.iter().flatten().any(|i| *i < 0.0) {
            return Err(Error::new("transmission: dead_currents must not be negative"));
        }
        // The names of elements are part of parameter names, so they must be unique.
        for (i, element) in self.elements.iter().enumerate() {
            let name = &element.name;
            if let Some(fault) = element.fault(n) {
                return Err(Error::new(format!("transmission: element `{name}`: {fault}")));
            }
            if self.elements[..i].iter().any(|known| known.name == *name) {
                return Err(Error::new(format!("transmission: two elements are called `{name}`")));
            }
        }
        for &(m, k, r) in &self.couplings {
            let inside = |i: usize| (1..=n).contains(&i);
            if !inside(m) || !inside(k) || m == k || !r.is_finite() {
                return Err(Error::new(format!(
                    "transmission: the coupling ({m}, {k}, {r}) is not of two joints of 1 to {n}"
                )));
            }
        }
        Ok(())
    }

    /// The matrix R (gear ratios and couplings), n x n, and its inverse. The inverse is `None` if the positions in the log are
    /// positions of the joints.
    fn matrices(&self, n: usize) -> Result<(DMatrix<f64>, Option<DMatrix<f64>>), Error> {
        self.check(n)?;
        let mut matrix = DMatrix::from_diagonal_element(n, n, 1.0);
        for (j, &ratio) in self.ratios.iter().flatten().enumerate() {
            matrix[(j, j)] = ratio;
        }
        for &(m, k, r) in &self.couplings {
            matrix[(m - 1, k - 1)] = r;
        }
        let inverse = matrix.clone().try_inverse();
        let inverse = inverse.ok_or_else(|| Error::new("transmission: the matrix of ratios is singular"))?;
        Ok((matrix, (!self.joint_side_positions).then_some(inverse)))
    }

    /// R^-1, row by row: the joint angles per motor angle. The transpose of R^-1 maps torques of joints to torques of motors.
    ///
    /// Fails if a list does not have n entries, or if R is singular.
    pub fn joints_per_motor(&self, n: usize) -> Result<Vec<Vec<f64>>, Error> {
        let of_motors = Transmission { joint_side_positions: false, ..self.clone() };
        let (matrix, inverse) = of_motors.matrices(n)?;
        let inverse = inverse.unwrap_or(matrix);
        Ok(inverse.row_iter().map(|row| row.iter().copied().collect()).collect())
    }

    /// The torque of each joint per current, N m/A (N/A). Empty without drive gains, and if motors are coupled, because then
    /// the current of a motor does not belong to a single joint.
    pub fn torque_per_current(&self, n: usize) -> Vec<f64> {
        let Some(gains) = self.drive_gains.as_ref().filter(|_| self.couplings.is_empty()) else { return Vec::new() };
        let of = |list: &Option<Vec<f64>>, k: usize| list.as_ref().and_then(|all| all.get(k)).copied().unwrap_or(1.0);
        let gain = |k: usize| gains.get(k).map_or(0.0, |gain| gain * of(&self.ratios, k) / of(&self.scales, k));
        (0..n).map(|k| gain(k).abs()).collect()
    }

    fn shifted(&self, mut q: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        for (q, offset) in q.iter_mut().zip(self.offsets.iter().flatten()) {
            q.iter_mut().for_each(|q| *q += offset);
        }
        q
    }

    /// Removes scales and springs from the torques of the joints, N m (N). `q`: positions in the model.
    fn of_bodies(&self, mut tau: Vec<Vec<f64>>, q: &[Vec<f64>]) -> Vec<Vec<f64>> {
        for (tau, scale) in tau.iter_mut().zip(self.scales.iter().flatten()) {
            tau.iter_mut().for_each(|x| *x /= scale);
        }
        for ((tau, q), stiffness) in tau.iter_mut().zip(q).zip(self.springs.iter().flatten()) {
            tau.iter_mut().zip(q).for_each(|(x, q)| *x -= stiffness * q);
        }
        tau
    }

    /// The positions of the joints from the positions of a log, rad (m).
    ///
    /// Fails if a list does not have n entries, or if R is singular.
    pub fn positions(&self, log: &Log) -> Result<Vec<Vec<f64>>, Error> {
        let (_, to_joint) = self.matrices(log.coordinates.len())?;
        Ok(self.shifted(joint_angles(to_joint.as_ref(), log.q.clone())))
    }

    /// Converts the signals of a log into signals of the joints.
    ///
    /// Fails if a list does not have n entries, if R is singular, or if currents have no drive gains.
    pub fn apply(&self, mut log: Log) -> Result<JointSignals, Error> {
        let (matrix, to_joint) = self.matrices(log.coordinates.len())?;
        let positions = |x: Vec<Vec<f64>>| match &to_joint {
            Some(m) => product(m, x),
            None => x,
        };
        let mut motor = std::mem::take(&mut log.effort);
        if let Some(dead) = &self.dead_currents {
            if log.effort_is != Effort::Current {
                let message =
                    format!("transmission: dead_currents are of currents, and the log holds {}", log.effort_is.words());
                return Err(Error::at(&log.name, 0, message));
            }
            // i <- sign(i) max(|i| - i_0, 0), where i is the current and i_0 the dead current, which gives no torque.
            for (x, dead) in motor.iter_mut().zip(dead) {
                x.iter_mut().for_each(|x| *x = x.signum() * (x.abs() - dead).max(0.0));
            }
        }
        // tau_m = K i. Torques are not multiplied by K, even if gains are given.
        match (&self.drive_gains, log.effort_is) {
            (_, Effort::Torque) => {}
            (Some(gains), _) => {
                motor.iter_mut().zip(gains).for_each(|(x, gain)| x.iter_mut().for_each(|x| *x *= gain));
            }
            (None, effort) => {
                let message = format!(
                    "the log holds {}; drive gains ({}) are needed to make torques of them",
                    effort.words(),
                    effort.gain_unit()
                );
                return Err(Error::at(&log.name, 0, message));
            }
        }
        // tau = R' tau_m / s - k q. The torque of the spring needs the positions of the joints, so the positions are converted
        // first.
        let q = self.shifted(joint_angles(to_joint.as_ref(), std::mem::take(&mut log.q)));
        Ok(JointSignals {
            dq: log.dq.take().map(positions),
            ddq: log.ddq.take().map(positions),
            tau: self.of_bodies(product(&matrix.transpose(), motor), &q),
            q,
            couplings: self.coupled(),
            log,
        })
    }
}

/// The angles of the joints, rad, without jumps by whole turns. When the log was read, jumps were removed from its positions by
/// whole turns of the motor. But one turn of a joint is many turns of its motor. So jumps by one turn of the joint are removed
/// here. `to_joint`: R^-1; `None`: q belongs to the joints already.
fn joint_angles(to_joint: Option<&DMatrix<f64>>, q: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let Some(matrix) = to_joint.filter(|m| !m.is_identity(0.0)) else { return q };
    let mut q = product(matrix, q);
    for angle in &mut q {
        unwrap_angle(angle);
    }
    q
}

/// The product of a matrix and a vector of series: y_i(t) = sum_j m_ij x_j(t).
fn product(m: &DMatrix<f64>, x: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    if m.is_identity(0.0) {
        return x;
    }
    let len = x.first().map_or(0, Vec::len);
    let row = |i: usize| {
        let mut y = vec![0.0; len];
        for (j, x) in x.iter().enumerate().filter(|(j, _)| m[(i, *j)] != 0.0) {
            y.iter_mut().zip(x).for_each(|(y, x)| *y += m[(i, j)] * x);
        }
        y
    };
    (0..m.nrows()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn log(q: Vec<Vec<f64>>, effort: Vec<Vec<f64>>, effort_is: Effort) -> Log {
        Log { dq: Some(q.clone()), ..crate::test_arm::log(vec![0.0], q, effort, effort_is) }
    }

    /// The power of motors and joints is equal for a coupled transmission: tau' dq = tau_m' dq_m.
    #[test]
    fn power_is_the_same_on_both_sides() {
        let transmission =
            Transmission { ratios: Some(vec![45.0, -48.0]), couplings: vec![(2, 1, 32.0)], ..Transmission::default() };
        let log = log(vec![vec![2.0], vec![-3.0]], vec![vec![0.7], vec![0.2]], Effort::Torque);
        let joints = transmission.apply(log.clone()).unwrap();
        let dq = joints.dq.unwrap();
        let joint: f64 = joints.tau.iter().zip(&dq).map(|(t, v)| t[0] * v[0]).sum();
        assert!((joint - (0.7 * 2.0 + 0.2 * -3.0)).abs() < 1e-12);
        assert!((45.0 * joints.q[0][0] - 2.0).abs() < 1e-12);
        assert!((-48.0 * joints.q[1][0] + 32.0 * joints.q[0][0] + 3.0).abs() < 1e-12);
        assert_eq!(transmission.coupled(), [Coupling::motor(1, &[(0, 32.0 / -48.0)])]);
        // If two joints turn one motor, this motor has one inertia and one friction term.
        let two = Transmission { couplings: vec![(3, 1, 2.0), (3, 2, -1.0)], ..Transmission::default() };
        assert_eq!(two.coupled(), [Coupling::motor(2, &[(0, 2.0), (1, -1.0)])]);
    }

    #[test]
    fn jumps_are_taken_back_at_the_joint() {
        let joint: Vec<f64> = (0..1000).map(|i| 5.0 * (0.04 * f64::from(i)).sin()).collect();
        let wrapped = joint.iter().map(|q| 121.0 * (q - TAU * (q / TAU).round())).collect();
        let fast: Vec<f64> = joint.iter().map(|q| 0.5 * q).collect();
        let motor = fast.iter().map(|q| 121.0 * q).collect();
        let log = log(vec![wrapped, motor], vec![vec![0.0; 1000]; 2], Effort::Torque);
        let transmission = Transmission { ratios: Some(vec![121.0; 2]), ..Transmission::default() };
        for q in [transmission.positions(&log).unwrap(), transmission.apply(log.clone()).unwrap().q] {
            for (found, expected) in q.iter().zip([&joint, &fast]) {
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9));
            }
        }
    }

    /// The logged torque is s (tau + k q), with the scale s, the stiffness k and the position q in the model. The result must
    /// be tau, the torque of the bodies.
    #[test]
    fn scales_and_springs_are_taken_out() {
        let transmission = Transmission {
            offsets: Some(vec![0.5]),
            scales: Some(vec![1.1]),
            springs: Some(vec![20.0]),
            ..Transmission::default()
        };
        let log = log(vec![vec![0.3]], vec![vec![1.1 * (7.0 + 20.0 * 0.8)]], Effort::Torque);
        assert!((transmission.apply(log).unwrap().tau[0][0] - 7.0).abs() < 1e-12);
    }

    #[test]
    fn currents_need_gains() {
        let log = log(vec![vec![1.0]], vec![vec![2.0]], Effort::Current);
        let message = Transmission::default().apply(log.clone()).err().unwrap().to_string();
        assert!(message.contains("drive gains"), "{message}");
        let gains = Transmission { drive_gains: Some(vec![-3.0]), ..Transmission::default() };
        assert_eq!(gains.apply(log).unwrap().tau, [[-6.0]]);
    }

    #[test]
    fn refusals() {
        let log = log(vec![vec![1.0], vec![1.0]], vec![vec![2.0], vec![1.0]], Effort::Torque);
        let broken = [
            (Transmission { ratios: Some(vec![1.0]), ..Transmission::default() }, "ratios needs 2 finite numbers"),
            (Transmission { ratios: Some(vec![1.0, 0.0]), ..Transmission::default() }, "ratios holds a zero"),
            (Transmission { couplings: vec![(3, 1, 1.0)], ..Transmission::default() }, "coupling (3, 1, 1)"),
            (Transmission { couplings: vec![(1, 2, 1.0), (2, 1, 1.0)], ..Transmission::default() }, "singular"),
        ];
        for (transmission, expected) in broken {
            let message = transmission.apply(log.clone()).err().unwrap().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
