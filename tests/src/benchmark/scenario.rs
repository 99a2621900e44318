//! The robots and the conditions (scenarios) in which estimators are compared.
//!
//! A scenario gives sensors, friction and feedforward of a simulation.

use experiments::simulate::closed_loop::{Drives, JointPd, Sensors};
use experiments::simulate::dynamics::Dynamics;
use linear_model::friction::law::FrictionLaw;
use linear_model::regressor::Regressor;

pub struct BenchmarkArm<'a> {
    pub name: &'static str,
    pub regressor: &'a dyn Regressor,
    pub dynamics: &'a dyn Dynamics,
    pub truth: &'a [f64],
    pub controller: JointPd,
    pub drives: Drives,
    pub sensing: Sensors,
    pub friction: Vec<FrictionLaw>,
    /// Limits for the validation motions: `position`, rad; `velocity`, rad/s; `acceleration`, rad/s^2.
    pub position: Vec<(f64, f64)>,
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
    pub sample_time: f64,
}

/// The conditions of a simulation. Sensors and friction may differ from the sensors and friction of the arm.
#[derive(Clone, Debug)]
pub struct Scenario {
    pub name: &'static str,
    /// Whether a feedforward is added to the controller output: inverse dynamics with parameters that are wrong by 20 %.
    pub feedforward: bool,
    pub sensing: Sensors,
    pub friction: Vec<FrictionLaw>,
    /// Friction of each joint changes between experiments by up to this fraction.
    pub drift: f64,
}

impl Scenario {
    /// S1: sensors and friction of the arm. S2: S1 with encoder quantum 5 times, encoder noise 6 times, torque noise 3 times. S3:
    /// S1 with 50 % more Stribeck friction and 25 % drift. S4: S1 with Coulomb friction that grows by 5 % per N m.
    pub fn all(arm: &BenchmarkArm) -> Vec<Scenario> {
        let base = |name, feedforward| Scenario {
            name,
            feedforward,
            sensing: arm.sensing.clone(),
            friction: arm.friction.clone(),
            drift: 0.0,
        };
        let times = |x: &[f64], f: f64| x.iter().map(|x| x * f).collect::<Vec<f64>>();
        let coarse = Sensors {
            quantum: times(&arm.sensing.quantum, 5.0),
            position_noise: times(&arm.sensing.position_noise, 6.0),
            torque_noise: times(&arm.sensing.torque_noise, 3.0),
        };
        let friction = |f: &dyn Fn(&FrictionLaw) -> FrictionLaw| arm.friction.iter().map(f).collect::<Vec<_>>();
        let stribeck = friction(&|law| FrictionLaw { stribeck: 0.5, stribeck_velocity: 0.1, ..*law });
        let load = friction(&|law| FrictionLaw { load: 0.05, ..*law });
        vec![
            base("S1-PD", false),
            base("S1", true),
            Scenario { sensing: coarse, ..base("S2", true) },
            Scenario { friction: stribeck, drift: 0.25, ..base("S3", true) },
            Scenario { friction: load, ..base("S4", true) },
        ]
    }
}
