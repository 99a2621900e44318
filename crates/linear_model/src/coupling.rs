//! What acts along a combination of the joints: a motor that turns with several of them, a spring, a cable or a bearing.
//!
//! With w = sum_k c_k q_k its position, its torque on joint k is c_k f X for each of its columns f, since its power is that of
//! the joints.
//!
//! For a motor m that turns with joints other than its own too, c_m = 1 and c_k = R_mk / R_mm, the columns to be added to
//! those of the joints are
//!   tau_k += c_k (IAM (d2w/dt2 - c_k ddq_k) + FVM (dw/dt - c_k dq_k) + FSM sign(dw/dt))
//! since the share of a joint's own motion is in its rotor inertia and viscous friction.
//! [Gautier 1997; Janot, Vandanjon, Gautier 2014, for the TX40]
//!
//! An element of the user's own has the columns that [`CouplingParameter`] names, as they stand.

use crate::coupling_parameter::CouplingParameter;

/// What acts along a combination of joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Coupling {
    /// What it is.
    pub of: Coupled,
    /// The coordinates that move it, each with its c; those of a motor are the others, then its own.
    pub joints: Vec<(usize, f64)>,
}

/// What is coupled.
#[derive(Clone, Debug, PartialEq)]
pub enum Coupled {
    /// The motor of a coordinate, which other joints turn too.
    Motor(usize),
    /// An element with a name, and its columns.
    Element(String, Vec<CouplingParameter>),
}

/// Positions, velocities and accelerations of all joints at one instant, and the direction of what is coupled.
pub struct At<'a> {
    /// rad (m).
    pub q: &'a [f64],
    /// rad/s (m/s).
    pub dq: &'a [f64],
    /// rad/s^2 (m/s^2).
    pub ddq: &'a [f64],
    /// sign(dw/dt), or that sign behind a filter.
    pub direction: f64,
}

impl Coupling {
    /// A motor that other joints turn too.
    pub fn motor(motor: usize, others: &[(usize, f64)]) -> Coupling {
        let joints = others.iter().copied().chain([(motor, 1.0)]).collect();
        Coupling { of: Coupled::Motor(motor), joints }
    }

    /// Its speed from those of the joints; its position and acceleration likewise.
    #[inline]
    pub fn speed(&self, dq: impl Fn(usize) -> f64) -> f64 {
        self.joints.iter().map(|&(k, c)| c * dq(k)).sum::<f64>()
    }

    /// The joints on which it acts.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().map(|(k, _)| *k)
    }

    /// Its columns.
    pub fn parameters(&self) -> &[CouplingParameter] {
        match &self.of {
            Coupled::Motor(_) => &CouplingParameter::MOTOR,
            Coupled::Element(_, columns) => columns,
        }
    }

    /// Its columns in each of its rows: `take(row, column, entry)`, both counted from 0.
    #[inline]
    pub fn columns(&self, at: &At, mut take: impl FnMut(usize, usize, f64)) {
        let of = |x: &[f64]| self.speed(|k| x[k]);
        let (position, speed, acceleration) = (of(at.q), of(at.dq), of(at.ddq));
        let is_motor = matches!(self.of, Coupled::Motor(_));
        for (row, &(k, c)) in self.joints.iter().enumerate() {
            // A motor's own share stands in the columns of the joint.
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

    /// The power of each column over all joints.
    fn power(coupling: &Coupling) -> Vec<f64> {
        let direction = coupling.speed(|k| DQ[k]).signum();
        let mut power = vec![0.0; coupling.parameters().len()];
        let joints: Vec<usize> = coupling.rows().collect();
        let at = At { q: &Q, dq: &DQ, ddq: &DDQ, direction };
        coupling.columns(&at, |row, column, entry| power[column] += DQ[joints[row]] * entry);
        power
    }

    /// The power of a motor that three joints turn is its torque times its own speed, but for what stands in the joints' own
    /// rotor inertia and viscous friction.
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
