//! Random situations of a user with a robot, a description and one log or two, and whether what `rist identify` says of
//! them can be believed.
//!
//! The machine is simulated by mechanics of its own ([`chain`]), on motions that are prescribed exactly; the sensors stand
//! behind ([`sensors`]). Nothing of `experiments::simulate` and nothing of `identification` takes part in it.
//! A situation follows from its seed alone.

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

/// A machine, what is wrong with it, and what it did.
pub struct Situation {
    pub seed: u64,
    pub machine: Machine,
    pub defects: Vec<Defect>,
    pub sensors: Sensors,
    /// One or two that are logged.
    pub motions: Vec<Motion>,
    /// The motion on which the estimate is judged.
    pub of_use: Motion,
}

impl Situation {
    /// The situation of a seed. Of twenty one each is of a gantry, of a SCARA, of two arms whose sides may be exchanged, and of a
    /// single joint that moves.
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

    /// The situation of a seed with other defects.
    pub fn with(seed: u64, machine: Machine, defects: Vec<Defect>) -> Situation {
        let count = 1 + Draw::of(seed, 3).below(2);
        let motion = |i: usize| Motion::recorded(&machine.chain, &mut Draw::of(seed, 10 + i as u64));
        let motions = (0..count).map(motion).collect();
        let of_use = Motion::of_use(&machine.chain, &mut Draw::of(seed, 4));
        let sensors = Sensors::some(&mut Draw::of(seed, 5));
        Situation { seed, machine, defects, sensors, motions, of_use }
    }

    /// Whether the machine of log i carries a load that the description does not know of. The load is there always, or
    /// in the second log only.
    pub fn is_loaded(&self, i: usize) -> bool {
        let payload = self.defects.iter().find(|d| d.kind == Kind::Payload);
        payload.is_some_and(|d| d.more < 0.5 || i > 0 || self.motions.len() == 1)
    }

    /// Whether the second log is of another machine than the first.
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
