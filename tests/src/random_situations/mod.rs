//! Random situations of a user who has a robot, a description and one or two logs. They test whether the answers of `rist
//! identify` are correct.
//!
//! The machine (the true robot) is simulated by independent mechanics ([`chain`]) on prescribed motions; then sensor errors are
//! added ([`sensors`]). `experiments::simulate` and `identification` are not used. The seed determines the whole situation.

pub mod chain;
pub mod defects;
pub mod draw;
pub mod judge;
pub mod motion;
pub mod robots;
pub mod sensors;
pub mod tally;
pub mod torque;
pub mod truth;
pub mod urdf;

use std::fmt;
use std::path::Path;

use logs::Table;
use rist::Model;
use rist::describe::description::{ModelOptions, parse_robot};

use defects::{Defect, Kind};
use draw::Draw;
use motion::Motion;
use robots::Machine;
use sensors::Sensors;

/// A machine (true robot), its defects, its sensors, and its motions.
pub struct Situation {
    pub seed: u64,
    pub machine: Machine,
    pub defects: Vec<Defect>,
    pub sensors: Sensors,
    /// The one or two motions that are logged.
    pub motions: Vec<Motion>,
    /// The motion on which the estimate is evaluated.
    pub of_use: Motion,
}

impl Situation {
    /// The situation for a seed. Four special situations have a probability of 1/20 each: a gantry; a SCARA; two arms, possibly
    /// with exchanged columns of left and right; and a machine of which only one joint moves.
    pub fn of(seed: u64) -> Situation {
        let sort = Draw::of(seed, 6).below(20);
        let draw = &mut Draw::of(seed, 1);
        let machine = match sort {
            0 => robots::gantry(draw),
            1 => robots::scara(draw),
            2 => robots::mirrored_arms(draw),
            _ => robots::machine(draw),
        };
        let n = machine.chain.len();
        let draw = &mut Draw::of(seed, 2);
        let mut defects = Defect::some(n, draw);
        if sort == 2 && draw.chance(0.6) {
            defects.retain(|d| !d.kind.is_gross());
            defects.push(Defect::of(Kind::Sides, n, draw));
        }
        let mut situation = Situation::with(seed, machine, defects);
        if sort == 3 {
            let chain = &situation.machine.chain;
            let alone = |i: usize| Motion::of_one_joint(chain, &mut Draw::of(seed, 10 + i as u64));
            situation.motions = (0..situation.motions.len()).map(alone).collect();
        }
        situation
    }

    /// The situation for a seed, with this machine and these defects.
    pub fn with(seed: u64, machine: Machine, defects: Vec<Defect>) -> Situation {
        let count = 1 + Draw::of(seed, 3).below(2);
        let motion = |i: usize| Motion::recorded(&machine.chain, &mut Draw::of(seed, 10 + i as u64));
        let motions = (0..count).map(motion).collect();
        let of_use = Motion::of_use(&machine.chain, &mut Draw::of(seed, 4));
        let sensors = Sensors::some(&mut Draw::of(seed, 5));
        Situation { seed, machine, defects, sensors, motions, of_use }
    }

    /// Whether the machine in log i carries a load that the description does not contain. The load is present in all logs, or
    /// only in the second one.
    pub fn is_loaded(&self, i: usize) -> bool {
        let payload = self.defects.iter().find(|d| d.kind == Kind::Payload);
        payload.is_some_and(|d| d.more < 0.5 || i > 0 || self.motions.len() == 1)
    }

    /// Whether the load differs between the two logs.
    pub fn changes(&self) -> bool {
        self.motions.len() > 1 && self.is_loaded(0) != self.is_loaded(1)
    }

    pub fn description(&self) -> String {
        urdf::urdf(&self.machine.name, &self.machine.chain, self.machine.described.as_deref())
    }

    pub fn model(&self) -> Model {
        let path = Path::new("situation.urdf");
        let robot = parse_robot(&self.description(), path, &ModelOptions::default())
            .unwrap_or_else(|e| panic!("situation {}: {e}", self.seed));
        Model::of(robot, path, false).unwrap_or_else(|e| panic!("situation {}: {e}", self.seed))
    }

    pub fn log(&self, i: usize) -> Table {
        let chain = torque::standing(&self.machine, &self.defects, self.is_loaded(i));
        let series = torque::series(&self.machine, &chain, &self.motions[i], &self.defects);
        let mut draw = Draw::of(self.seed, 20 + i as u64);
        let table = self.sensors.log(&self.machine, &series, &self.defects, &mut draw);
        Table { file: format!("log_{}.csv", i + 1), ..table }
    }
}

impl fmt::Display for Situation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Machine { name, chain, description, .. } = &self.machine;
        let rotors = chain.joints.iter().filter(|j| j.rotor > 0.0).count();
        let slides = chain.joints.iter().filter(|j| j.slides).count();
        let n = chain.len();
        writeln!(
            f,
            "seed {}: {name}, {n} joints, {slides} slide, {rotors} rotors, description {description}",
            self.seed
        )?;
        for (i, motion) in self.motions.iter().enumerate() {
            writeln!(f, "  log {}: {}", i + 1, motion.said)?;
        }
        let Sensors { rate, noise, level, bits, speed } = &self.sensors;
        let speed = speed.map_or("no velocities".to_string(), |s| format!("velocities to {:.2} %", 100.0 * s));
        let bits = bits.map_or("exact".to_string(), |b| format!("{b} bit"));
        writeln!(f, "  {rate} Hz, {bits}, {speed}, torque noise {:.2} % {noise:?}", 100.0 * level)?;
        for defect in &self.defects {
            writeln!(f, "  {defect}")?;
        }
        Ok(())
    }
}
