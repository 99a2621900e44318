//! Random situations in which somebody identifies a robot, from a simulator that shares nothing with the estimators.
//!
//! | file | |
//! |---|---|
//! | `motion` | how the joints move, prescribed |
//! | `machine` | the robot as it is: bodies, rotors, friction, defects |
//! | `sensors` | what a log holds of it |
//! | `judge` | what rist says, and whether that is true |
//!
//! A situation is a function of its seed.

pub mod judge;
mod machine;
mod motion;
mod sensors;

use std::collections::BTreeMap;

use rist::Model;
use robot::Robot;

use crate::model_path;
use crate::random::Random;
use crate::situations::machine::Machine;
use crate::situations::motion::Motion;
use crate::situations::sensors::{Fault, Sensors};

/// One situation: the machine, its motions, its sensors.
pub struct Situation {
    pub seed: u64,
    /// The description that is given to rist: file of models/.
    pub file: &'static str,
    /// What is wrong with the machine or with its sensors, in words.
    pub defects: Vec<String>,
    pub machine: Machine,
    pub motions: Vec<Motion>,
    pub sensors: Sensors,
    /// Whether a second log is given, which is not fitted.
    pub has_second: bool,
    /// Whether it has the gross fault too.
    pub second_is_faulty: bool,
}

/// Robots whose description has bodies: files of models/, and URDFs made of them, which say nothing of rotors.
pub const FILES: [&str; 6] =
    ["ur5.urdf", "puma560.yaml", "kuka_lwr.yaml", "puma560.urdf", "kuka_lwr.urdf", "panda.urdf"];

/// The models of these files.
pub fn models() -> BTreeMap<&'static str, Model> {
    let read = |file: &'static str| {
        let path = model_path(file);
        if path.is_file() {
            return (file, Model::read(path).unwrap_or_else(|e| panic!("{e}")));
        }
        let robot = Model::read(model_path(&file.replace(".urdf", ".yaml"))).unwrap_or_else(|e| panic!("{e}")).robot;
        let (text, _) = robot::format::write_urdf(&robot);
        (file, Model::parse(&text, file, &Default::default()).unwrap_or_else(|e| panic!("{e}")))
    };
    FILES.into_iter().map(read).collect()
}

impl Situation {
    /// The situation of a seed, for the robot that `read` gives for a file.
    pub fn new(seed: u64, read: &dyn Fn(&str) -> Robot) -> Situation {
        let mut random = Random(0x5171_0000 + seed);
        let file = FILES[random.below(FILES.len())];
        let robot = read(file);
        let mut defects = Vec::new();
        let mut machine = Machine::random(&robot, file.ends_with(".urdf"), &mut random);
        let kind = random.below(6);
        let motions = vec![Motion::random(&robot, kind, &mut random), Motion::random(&robot, 1, &mut random)];
        defects.push(motions[0].name.to_string());
        let mut sensors = Sensors::random(&robot, &mut random);
        for _ in 0..random.below(4) {
            let text = match random.below(15) {
                k @ 0..=7 => machine.defect(k, &mut random),
                k => sensors.defect(k - 8, &mut random),
            };
            defects.push(text);
        }
        if random.below(3) == 0 {
            sensors.fault = Fault::random(&robot, &mut random);
            defects.push(sensors.fault.to_string());
        }
        let (has_second, second_is_faulty) = (seed % 2 == 1, random.below(2) == 0);
        Situation { seed, file, defects, machine, motions, sensors, has_second, second_is_faulty }
    }
}

/// One number of a standard normal law.
pub(crate) fn normal(random: &mut Random) -> f64 {
    0.5 * (0..12).map(|_| random.unit()).sum::<f64>()
}

/// One number between two, each factor alike.
pub(crate) fn log_between(random: &mut Random, low: f64, high: f64) -> f64 {
    low * (high / low).powf(0.5 * (1.0 + random.unit()))
}
