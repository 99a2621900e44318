//! Elements that act along a combination of joints: a motor that turns with several joints, a spring, a cable or a bearing.
//!
//! The position of the element is w = sum_k c_k q_k. A column f of the element, with its parameter X, gives the torque c_k f X
//! on joint k, because the power f X dw/dt equals the power of these torques.
//!
//! R: matrix from joint speeds to motor speeds. For a motor m that also turns with other joints, c_m = 1 and c_k = R_mk / R_mm.
//! In addition to the columns of the joints, the motor has the columns
//!   tau_k += c_k (IAM (d2w/dt2 - c_k ddq_k) + FVM (dw/dt - c_k dq_k) + FSM sign(dw/dt))
//! The terms of ddq_k and dq_k are subtracted, because the columns of joint k already contain the rotor inertia and viscous
//! friction of the joint's own motion. [Gautier 1997; Janot, Vandanjon, Gautier 2014, for the TX40]
//!
//! An element that the user defines has the columns of its [`CouplingParameter`]s, without such a subtraction.

use crate::coupling_parameter::CouplingParameter;

/// A motor or an element that acts along a combination of joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Coupling {
    /// The kind of the coupling: a motor or an element.
    pub of: Coupled,
    /// The coordinates that move the motor or element, each with its coefficient c in w = sum_k c_k q_k. For a motor: first the
    /// other coordinates, then the coordinate of the motor.
    pub joints: Vec<(usize, f64)>,
}

/// The kind of a coupling.
#[derive(Clone, Debug, PartialEq)]
pub enum Coupled {
    /// The motor of this coordinate (index from 0), which other joints turn too.
    Motor(usize),
    /// An element that the user defines: its name and the parameters of its columns.
    Element(String, Vec<CouplingParameter>),
}

/// The state of all joints at one sample, and the direction of the coupled element.
pub struct Instant<'a> {
    /// Positions, rad (m).
    pub q: &'a [f64],
    /// Velocities, rad/s (m/s).
    pub dq: &'a [f64],
    /// Accelerations, rad/s^2 (m/s^2).
    pub ddq: &'a [f64],
    /// Direction of the coupled motor or element: the sign of its speed dw/dt, or the filtered sign, between -1 and 1.
    pub direction: f64,
}

impl Coupling {
    /// Makes the coupling of `motor`, which the joints `others` turn too, each with its coefficient c.
    pub fn motor(motor: usize, others: &[(usize, f64)]) -> Coupling {
        let joints = others.iter().copied().chain([(motor, 1.0)]).collect();
        Coupling { of: Coupled::Motor(motor), joints }
    }

    /// Speed dw/dt = sum_k c_k dq_k of the motor or element. With positions instead of speeds, the result is w; with
    /// accelerations, d2w/dt2.
    #[inline]
    pub fn speed(&self, dq: impl Fn(usize) -> f64) -> f64 {
        self.joints.iter().map(|&(k, c)| c * dq(k)).sum::<f64>()
    }

    /// The coordinates on which the coupling acts.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().map(|(k, _)| *k)
    }

    /// The parameters of the motor or element, in the order of its columns.
    pub fn parameters(&self) -> &[CouplingParameter] {
        match &self.of {
            Coupled::Motor(_) => &CouplingParameter::MOTOR,
            Coupled::Element(_, columns) => columns,
        }
    }

    /// Calls `take(row, column, entry)` for each entry of the columns of this coupling. `row`: index in `joints`; `column`: index
    /// in `parameters`.
    #[inline]
    pub fn columns(&self, at: &Instant, mut take: impl FnMut(usize, usize, f64)) {
        let of = |x: &[f64]| self.speed(|k| x[k]);
        let (position, speed, acceleration) = (of(at.q), of(at.dq), of(at.ddq));
        let is_motor = matches!(self.of, Coupled::Motor(_));
        for (row, &(k, c)) in self.joints.iter().enumerate() {
            // For a motor, the term of the joint's own motion is subtracted, because the columns of the joint already contain
            // this term.
            let own = if is_motor { c } else { 0.0 };
            for (column, parameter) in self.parameters().iter().enumerate() {
                use CouplingParameter::*;
                let of_speed = match parameter {
                    Rotor | Inertia => acceleration - own * at.ddq[k],
                    Viscous | ElementViscous => speed - own * at.dq[k],
                    Coulomb | ElementCoulomb => at.direction,
                    Stiffness => position,
                    Sine => position.sin(),
                    Cosine => position.cos(),
                    Offset => 1.0,
                };
                take(row, column, c * of_speed);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const Q: [f64; 3] = [0.2, -0.9, 1.3];
    const DQ: [f64; 3] = [0.7, -1.1, 0.4];
    const DDQ: [f64; 3] = [2.0, 3.0, -1.5];

    /// The power of each column, summed over all joints, for a parameter value of 1.
    fn power(coupling: &Coupling) -> Vec<f64> {
        let direction = coupling.speed(|k| DQ[k]).signum();
        let mut power = vec![0.0; coupling.parameters().len()];
        let joints: Vec<usize> = coupling.rows().collect();
        let at = Instant { q: &Q, dq: &DQ, ddq: &DDQ, direction };
        coupling.columns(&at, |row, column, entry| power[column] += DQ[joints[row]] * entry);
        power
    }

    /// The power of a motor that three joints turn equals its torque times its speed, minus the power of the rotor inertia and
    /// viscous friction that the columns of the joints already contain.
    #[test]
    fn the_power_is_that_of_the_motor() {
        let motor = Coupling::motor(2, &[(0, 0.5), (1, -0.3)]);
        let (speed, acceleration) = (motor.speed(|k| DQ[k]), motor.speed(|k| DDQ[k]));
        let own = |x: &[f64; 3]| motor.joints.iter().map(|&(k, c)| DQ[k] * c * c * x[k]).sum::<f64>();
        let whole = [acceleration * speed - own(&DDQ), speed * speed - own(&DQ), speed.abs()];
        for (power, whole) in power(&motor).iter().zip(whole) {
            assert!((power - whole).abs() < 1e-14, "{power} for {whole}");
        }
    }

    #[test]
    fn the_power_is_that_of_the_element() {
        let columns = CouplingParameter::ELEMENT.to_vec();
        let element = Coupling { of: Coupled::Element("cable".into(), columns), joints: vec![(0, 0.5), (2, -2.0)] };
        let of = |x: &[f64; 3]| 0.5 * x[0] - 2.0 * x[2];
        let (position, speed) = (of(&Q), of(&DQ));
        let forces = [of(&DDQ), speed, speed.signum(), position, position.sin(), position.cos(), 1.0];
        for (power, force) in power(&element).iter().zip(forces) {
            assert!((power - force * speed).abs() < 1e-14, "{power} for {force}");
        }
    }
}
