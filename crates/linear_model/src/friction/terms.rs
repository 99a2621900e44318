//! Joint friction, linear in its parameters: one set of columns per joint.
//!
//! tau_f = FV dq + FS sign(dq) + OFF, and these additional terms of all joints:
//! - asymmetric: FV+ dq + FS+ for dq > 0, FV- dq + FS- for dq < 0 (FS- < 0)
//!   [Vandanjon, Gautier, Desbats 1995, equation (5)];
//! - Stribeck: FT sign(dq) exp(-(dq / v_s)^2) in addition to Coulomb friction, v_s given;
//! - smooth Coulomb: FS tanh(dq / v_0), v_0 given;
//! - load: FL |tau| sign(dq), tau: measured torque. Since tau is on both sides of the equation, a small residual is no evidence
//!   for this term. It is used for diagnosis only, never for the comparison of models;
//! - rotor inertia IA ddq, for regressors without this parameter.
//!
//! Terms of a single joint, which cross-validation chooses:
//! - load: FL |Y x0| sign(dq), Y x0: the torque without friction, predicted by an earlier fit x0. So the measured torque tau is
//!   on one side of the equation only;
//! - Stribeck, with a speed for this joint;
//! - viscous asymmetry: FVA |dq|;
//! - root: FR sqrt(|dq|) sign(dq).
//!
//! Names and units: [`crate::parameter`].

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::parameter::FrictionParameter;

/// A friction term that a single joint can have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointTerm {
    /// Coulomb friction that grows with the load: FL abs(Y x0) sign(dq). Y x0: torque without friction, predicted by an earlier
    /// fit x0.
    Load,
    /// Stribeck friction FT exp(-(dq / v)^2) sign(dq), v in rad/s.
    Stribeck(f64),
    /// Viscous friction that differs by direction: FVA abs(dq).
    ViscousAsymmetry,
    /// Friction with the root of the speed: FR sqrt(abs(dq)) sign(dq).
    Root,
}

impl JointTerm {
    /// The parameter of the term; each term has exactly one.
    #[inline]
    pub fn parameter(self) -> FrictionParameter {
        match self {
            JointTerm::Load => FrictionParameter::Load,
            JointTerm::Stribeck(_) => FrictionParameter::Stribeck,
            JointTerm::ViscousAsymmetry => FrictionParameter::ViscousAsymmetry,
            JointTerm::Root => FrictionParameter::Root,
        }
    }

    /// A sentence that states the term for the joint of this name.
    pub fn sentence(self, joint: &str) -> String {
        match self {
            JointTerm::Load => format!("friction of {joint} grows with its load"),
            JointTerm::Stribeck(_) => format!("friction of {joint} is larger at low speed"),
            JointTerm::ViscousAsymmetry => format!("viscous friction of {joint} differs by direction"),
            JointTerm::Root => format!("friction of {joint} grows with the root of its speed"),
        }
    }

    /// The entry of the column of the term at one sample. `load`: torque without friction that an earlier fit predicts, N m
    /// (N); `direction`: sign of dq, possibly filtered.
    #[inline]
    fn column(self, dq: f64, load: f64, direction: f64) -> f64 {
        match self {
            JointTerm::Load => direction * load.abs(),
            JointTerm::Stribeck(speed) => direction * (-(dq / speed).powi(2)).exp(),
            JointTerm::ViscousAsymmetry => dq.abs(),
            JointTerm::Root => direction * dq.abs().sqrt(),
        }
    }
}

/// A friction term, either of every joint or of a single joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionTerm {
    /// Viscous friction FV dq.
    Viscous,
    /// Coulomb friction FS sign(dq).
    Coulomb,
    /// A constant torque OFF.
    Offset,
    /// Smooth Coulomb friction FS tanh(dq / v), v in rad/s.
    SmoothCoulomb(f64),
    /// Viscous and Coulomb friction with separate values for each direction.
    Asymmetric,
    /// Stribeck friction FT exp(-(dq / v)^2) sign(dq), v in rad/s.
    Stribeck(f64),
    /// Coulomb friction that grows with the measured torque: FL abs(tau) sign(dq).
    Load,
    /// Rotor inertia IA ddq.
    Rotor,
    /// A term of a single joint only: the number of the joint, counted from 1, and the term.
    At(usize, JointTerm),
}

use FrictionTerm::*;

impl FrictionTerm {
    /// The default terms: viscous friction, Coulomb friction and offset.
    pub const STANDARD: [FrictionTerm; 3] = [Viscous, Coulomb, Offset];

    /// Reads a term from its word in text: `viscous`, `stribeck=0.1` with the speed in rad/s; `load@2` is the term of joint 2
    /// only.
    ///
    /// Fails if there is no such term; the message lists the words.
    pub fn of_word(text: &str) -> Result<FrictionTerm, String> {
        // A word with @ is a term of a single joint.
        if let Some((term, number)) = text.split_once('@') {
            let number: usize =
                number.parse().ok().filter(|n| *n > 0).ok_or_else(|| {
                    format!("`{text}`: behind @ stands the number of a joint, from 1, as in `load@2`")
                })?;
            let term = match (term, term.contains('=')) {
                ("viscous-asymmetry", _) => JointTerm::ViscousAsymmetry,
                ("root", _) => JointTerm::Root,
                ("load", _) => JointTerm::Load,
                (_, true) if let Ok(Stribeck(speed)) = FrictionTerm::of_word(term) => JointTerm::Stribeck(speed),
                _ => {
                    return Err(format!(
                        "there is no friction term `{term}` of a single joint; there are load, stribeck=V, \
                         viscous-asymmetry and root"
                    ));
                }
            };
            return Ok(At(number, term));
        }
        // A word without @ is a term of all joints. If the term has a speed, the speed follows the word.
        let (name, speed) = match text.split_once('=') {
            Some((name, speed)) => (name, Some(speed)),
            None => (text, None),
        };
        let speed = match speed.map(str::parse::<f64>) {
            None => None,
            Some(Ok(v)) if v.is_finite() && v > 0.0 => Some(v),
            Some(_) => return Err(format!("the speed of `{name}` must be a positive number of rad/s")),
        };
        match (name, speed) {
            ("viscous", None) => Ok(Viscous),
            ("coulomb", None) => Ok(Coulomb),
            ("offset", None) => Ok(Offset),
            ("asymmetric", None) => Ok(Asymmetric),
            ("load", None) => Ok(Load),
            ("rotor", None) => Ok(Rotor),
            ("smooth-coulomb", Some(v)) => Ok(SmoothCoulomb(v)),
            ("stribeck", Some(v)) => Ok(Stribeck(v)),
            ("smooth-coulomb" | "stribeck", None) => Err(format!("`{name}` needs its speed in rad/s: `{name}=0.1`")),
            _ => Err(format!(
                "there is no friction term `{text}`; there are viscous, coulomb, offset, asymmetric, load, rotor, \
                 smooth-coulomb=V, stribeck=V, none and auto, and of joint N alone load@N, stribeck=V@N, \
                 viscous-asymmetry@N, root@N"
            )),
        }
    }

    /// The parameters of the term in one joint, in the order of its columns.
    #[inline]
    pub fn parameters(self) -> &'static [FrictionParameter] {
        match self {
            Viscous => &[FrictionParameter::Viscous],
            Coulomb | SmoothCoulomb(_) => &[FrictionParameter::Coulomb],
            Offset => &[FrictionParameter::Offset],
            Asymmetric => &[
                FrictionParameter::ViscousForward,
                FrictionParameter::CoulombForward,
                FrictionParameter::ViscousBackward,
                FrictionParameter::CoulombBackward,
            ],
            Stribeck(_) => &[FrictionParameter::Stribeck],
            Load => &[FrictionParameter::Load],
            Rotor => &[FrictionParameter::Rotor],
            At(_, JointTerm::Load) => &[FrictionParameter::Load],
            At(_, JointTerm::Stribeck(_)) => &[FrictionParameter::Stribeck],
            At(_, JointTerm::ViscousAsymmetry) => &[FrictionParameter::ViscousAsymmetry],
            At(_, JointTerm::Root) => &[FrictionParameter::Root],
        }
    }

    /// The parameters of the term in joint j, counted from 0. Empty if the term belongs to another joint.
    #[inline]
    pub fn parameters_of(self, j: usize) -> &'static [FrictionParameter] {
        match self {
            At(number, _) if number != j + 1 => &[],
            term => term.parameters(),
        }
    }

    /// Whether the term belongs to a single joint (and not to all joints).
    #[inline]
    pub fn is_of_one_joint(self) -> bool {
        matches!(self, At(..))
    }

    /// Whether the torque of the term jumps at a reversal (dry friction). Such a torque can hold a joint at standstill.
    #[inline]
    pub fn is_dry(self) -> bool {
        matches!(self, Coulomb | SmoothCoulomb(_) | Asymmetric | Stribeck(_) | Load)
            || matches!(self, At(_, JointTerm::Load | JointTerm::Stribeck(_)))
    }

    /// Whether the columns must be computed from lightly filtered velocities and then filtered like the torques.
    ///
    /// A column needs this computation if it is neither linear in velocity and acceleration nor equal to the direction.
    #[inline]
    pub fn is_bent(self) -> bool {
        matches!(self, SmoothCoulomb(_) | Asymmetric | Stribeck(_) | Load)
    }

    /// Writes the entries of the columns of one joint at one sample, in the order of `parameters`. `direction`: sign(dq), or the
    /// sign after the low-pass of the torques, between -1 and 1. `tau`: measured torque, N m (N); for a term of a single joint,
    /// the torque without friction that an earlier fit predicts.
    #[inline]
    pub fn fill(self, dq: f64, ddq: f64, tau: f64, direction: f64, out: &mut [f64]) {
        match (self, out) {
            (Viscous, [v]) => *v = dq,
            (Coulomb, [c]) => *c = direction,
            (Offset, [o]) => *o = 1.0,
            (SmoothCoulomb(width), [c]) => *c = (dq / width).tanh(),
            (Asymmetric, [vp, cp, vn, cn]) => {
                // `forward` is 1 for dq > 0 and `backward` is 1 for dq < 0. With a filtered sign, both are between 0 and 1.
                let (forward, backward) = (0.5 * (1.0 + direction), 0.5 * (1.0 - direction));
                (*vp, *cp, *vn, *cn) = (dq.max(0.0), forward, dq.min(0.0), backward);
            }
            (Stribeck(speed), [s]) => *s = direction * (-(dq / speed).powi(2)).exp(),
            (Load, [l]) => *l = direction * tau.abs(),
            (Rotor, [r]) => *r = ddq,
            (At(_, term), [x]) => *x = term.column(dq, tau, direction),
            _ => {}
        }
    }
}

/// Writes the term as on the command line: `viscous`, `stribeck=0.1`.
impl fmt::Display for FrictionTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Viscous => write!(f, "viscous"),
            Coulomb => write!(f, "coulomb"),
            Offset => write!(f, "offset"),
            SmoothCoulomb(speed) => write!(f, "smooth-coulomb={speed:.4}"),
            Asymmetric => write!(f, "asymmetric"),
            Stribeck(speed) => write!(f, "stribeck={speed:.4}"),
            Load => write!(f, "load"),
            Rotor => write!(f, "rotor"),
            At(number, JointTerm::Load) => write!(f, "load@{number}"),
            At(number, JointTerm::Stribeck(speed)) => write!(f, "stribeck={speed:.4}@{number}"),
            At(number, JointTerm::ViscousAsymmetry) => write!(f, "viscous-asymmetry@{number}"),
            At(number, JointTerm::Root) => write!(f, "root@{number}"),
        }
    }
}

/// Checks the friction terms of a robot with `n` joints.
///
/// Fails if a term is for a joint that does not exist, or if two terms have a parameter with the same name.
pub fn check_terms(terms: &[FrictionTerm], n: usize) -> Result<(), String> {
    for (i, term) in terms.iter().enumerate() {
        if let At(number, _) = term
            && !(1..=n).contains(number)
        {
            return Err(format!(
                "friction `{term}`: the robot has joints 1 to {n}; leave the term out or mend its number"
            ));
        }
        let is_twice = |other: &&FrictionTerm| {
            let share = |j: usize| other.parameters_of(j).iter().any(|p| term.parameters_of(j).contains(p));
            (0..n).any(share)
        };
        if let Some(other) = terms[..i].iter().find(is_twice) {
            return Err(format!(
                "friction `{other}` and `{term}` have a parameter of one name in one joint: take one of them"
            ));
        }
    }
    Ok(())
}

/// The number of friction columns of joint j (counted from 0).
pub fn columns_of(terms: &[FrictionTerm], j: usize) -> usize {
    terms.iter().map(|term| term.parameters_of(j).len()).sum()
}

/// The number of friction columns of all joints before joint j.
pub fn columns_before(terms: &[FrictionTerm], j: usize) -> usize {
    (0..j).map(|j| columns_of(terms, j)).sum()
}

/// The sign of x: -1, 0 or 1. The result is 0 for x = 0, because Coulomb friction at standstill has no sign.
#[inline]
pub fn sign(x: f64) -> f64 {
    f64::from(x > 0.0) - f64::from(x < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(term: FrictionTerm, dq: f64) -> Vec<f64> {
        let mut out = vec![f64::NAN; term.parameters().len()];
        term.fill(dq, 7.0, -3.0, sign(dq), &mut out);
        out
    }

    #[test]
    fn columns_of_each_term() {
        assert_eq!(columns(Viscous, -2.0), [-2.0]);
        assert_eq!(columns(Coulomb, -2.0), [-1.0]);
        assert_eq!(columns(Coulomb, 0.0), [0.0]);
        assert_eq!(columns(Offset, 0.0), [1.0]);
        assert_eq!(columns(Asymmetric, -2.0), [0.0, 0.0, -2.0, 1.0]);
        assert_eq!(columns(Asymmetric, 2.0), [2.0, 1.0, 0.0, 0.0]);
        assert_eq!(columns(Load, -2.0), [-3.0]);
        assert_eq!(columns(Rotor, 1.0), [7.0]);
        assert_eq!(columns(SmoothCoulomb(0.1), 50.0), [1.0]);
        assert!((columns(Stribeck(2.0), 2.0)[0] - (-1f64).exp()).abs() < 1e-15);
    }

    #[test]
    fn asymmetric_holds_viscous_coulomb_and_offset() {
        for dq in [-1.5, 0.4] {
            let a = columns(Asymmetric, dq);
            assert_eq!(a[0] + a[2], columns(Viscous, dq)[0]);
            assert_eq!(a[1] - a[3], columns(Coulomb, dq)[0]);
            assert_eq!(a[1] + a[3], columns(Offset, dq)[0]);
        }
    }
}
