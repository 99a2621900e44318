//! Defects of a machine or a log that the fitted model does not contain, and gross faults of a description or of columns.
//!
//! The machine is the true robot. A kind of defect has a size in a unit of its own, for example rad or a relative factor.

use std::f64::consts::{PI, TAU};
use std::fmt;

use super::chain::{Vector, about};
use super::draw::Draw;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    // Defects of the machine: they change the torque of every motion.
    Stribeck,
    Bristle,
    LoadFriction,
    Asymmetric,
    TorqueRipple,
    Spring,
    Flexible,
    // Defects of the sensors.
    Late,
    TorqueLag,
    EncoderRipple,
    VelocityFiltered,
    GainDrift,
    CrossTalk,
    ClockJitter,
    DroppedRows,
    RepeatedRows,
    QuantisedTorque,
    Saturation,
    // Gross faults of the description, of columns or of units.
    Tilt,
    Zero,
    ScaleOfJoint,
    ScaleOfAll,
    Swapped,
    Negated,
    Degrees,
    Payload,
    /// The columns of the first half of the joints have the names of the second half, and vice versa. This needs two equal arms,
    /// so it is never drawn at random.
    Sides,
}

#[derive(Clone, Copy, Debug)]
pub struct Defect {
    pub kind: Kind,
    /// The joint with the defect, if the kind concerns one joint. `other`: a second joint, if the kind concerns two.
    pub joint: usize,
    pub other: usize,
    /// Size of the defect, in the unit of its kind.
    pub size: f64,
    /// A random number in [0, 1) from which other properties of the defect follow, for example its sign.
    pub more: f64,
}

impl Kind {
    pub const ALL: [Kind; 26] = [
        Kind::Stribeck,
        Kind::Bristle,
        Kind::LoadFriction,
        Kind::Asymmetric,
        Kind::TorqueRipple,
        Kind::Spring,
        Kind::Flexible,
        Kind::Late,
        Kind::TorqueLag,
        Kind::EncoderRipple,
        Kind::VelocityFiltered,
        Kind::GainDrift,
        Kind::CrossTalk,
        Kind::ClockJitter,
        Kind::DroppedRows,
        Kind::RepeatedRows,
        Kind::QuantisedTorque,
        Kind::Saturation,
        Kind::Tilt,
        Kind::Zero,
        Kind::ScaleOfJoint,
        Kind::ScaleOfAll,
        Kind::Swapped,
        Kind::Negated,
        Kind::Degrees,
        Kind::Payload,
    ];

    /// Whether the defect is a gross fault.
    pub fn is_gross(self) -> bool {
        self >= Kind::Tilt
    }

    /// Smallest size, largest size, and unit of a defect of this kind.
    fn sizes(self) -> (f64, f64, &'static str) {
        match self {
            Kind::Stribeck => (0.1, 0.8, "of Coulomb friction more at rest"),
            Kind::Bristle => (1e-4, 1e-2, "of the range until friction is full"),
            Kind::LoadFriction => (0.02, 0.2, "of the load"),
            Kind::Asymmetric => (0.05, 0.4, "of viscous friction to one side"),
            Kind::TorqueRipple => (0.005, 0.1, "of the torque"),
            Kind::Spring => (0.05, 1.0, "of the torque at the end of the range"),
            Kind::Flexible => (6.0, 60.0, "Hz"),
            Kind::Late => (0.0005, 0.02, "s"),
            Kind::TorqueLag => (3.0, 60.0, "Hz"),
            Kind::EncoderRipple => (2e-4, 5e-3, "rad"),
            Kind::VelocityFiltered => (3.0, 50.0, "Hz"),
            Kind::GainDrift => (0.02, 0.3, "of the torque"),
            Kind::CrossTalk => (0.01, 0.1, "of another joint"),
            Kind::ClockJitter => (1e-4, 1e-3, "s"),
            Kind::DroppedRows => (0.01, 0.3, "of the rows"),
            Kind::RepeatedRows => (0.02, 0.6, "of the rows"),
            Kind::QuantisedTorque => (0.005, 0.2, "of the torque"),
            Kind::Saturation => (0.4, 0.95, "of the largest torque"),
            Kind::Tilt => (0.03, PI, "rad"),
            Kind::Zero => (0.01, 1.0, "rad"),
            Kind::ScaleOfJoint => (0.02, 0.5, "in the logarithm"),
            Kind::ScaleOfAll => (0.05, 1.1, "in the logarithm"),
            Kind::Payload => (0.05, 0.8, "of the mass of the last link"),
            Kind::Swapped | Kind::Negated | Kind::Degrees | Kind::Sides => (1.0, 1.0001, ""),
        }
    }
}

impl Defect {
    /// A defect of this kind with a random size, on a random joint of n joints.
    pub fn of(kind: Kind, n: usize, draw: &mut Draw) -> Defect {
        let (low, high, _) = kind.sizes();
        let joint = draw.below(n);
        let other = (joint + 1 + draw.below(n - 1)) % n;
        Defect { kind, joint, other, size: draw.log(low, high), more: draw.uniform(0.0, 1.0) }
    }

    /// Zero to three random defects. At most one of them is gross.
    pub fn some(n: usize, draw: &mut Draw) -> Vec<Defect> {
        let fine: Vec<Kind> = Kind::ALL.into_iter().filter(|k| !k.is_gross()).collect();
        let gross: Vec<Kind> = Kind::ALL.into_iter().filter(|k| k.is_gross()).collect();
        let count = [0, 0, 0, 1, 1, 1, 1, 2, 2, 3][draw.below(10)];
        let mut defects: Vec<Defect> = Vec::new();
        for _ in 0..count {
            let kind = fine[draw.below(fine.len())];
            if defects.iter().all(|d| d.kind != kind) {
                defects.push(Defect::of(kind, n, draw));
            }
        }
        if draw.chance(0.3) {
            let kind = gross[draw.below(gross.len())];
            defects.push(Defect::of(kind, n, draw));
        }
        defects
    }

    /// The factor by which a scale defect multiplies torques: exp(size) or, with equal probability, exp(-size).
    pub fn factor(&self) -> f64 {
        if self.more < 0.5 { self.size.exp() } else { (-self.size).exp() }
    }

    /// The gravity vector in the frame of a base that is tilted by `size`, rad, about a random horizontal axis.
    pub fn tilted(&self, gravity: Vector) -> Vector {
        let (s, c) = (TAU * self.more).sin_cos();
        super::chain::turned(&about([c, s, 0.0], self.size), gravity)
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (_, _, unit) = self.kind.sizes();
        write!(f, "{:?} at joint_{} ({:.3} {unit})", self.kind, self.joint + 1, self.size)
    }
}
