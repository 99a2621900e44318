//! Random robots with one mistake in their logs. The tests check whether `rist doctor` names the true cause, whether its remedy
//! can be applied as printed, and whether the remedy corrects the log.
//!
//! The machine (the true robot) is simulated by independent mechanics ([`crate::recursion`]). Its bodies, rotors, friction and
//! sensors differ from the description. The seed and the list of robots determine robot, motion, mistake and noise.

pub mod arms;
pub mod case;
pub mod commands;
pub mod judge;
pub mod kinds;
pub mod machine;
pub mod motion;
pub mod obedience;
pub mod of_excite;
pub mod of_lint;
pub mod of_postures;
pub mod of_wrench;
pub mod said;
pub mod simulation;
pub mod tally;
pub mod wrong_columns;

use std::fmt;
use std::path::{Path, PathBuf};

use crate::joint_log::JointLog;
use crate::program::folder;
use crate::random_situations::draw::Draw;
use crate::random_situations::motion::Motion;
use arms::Arm;
use kinds::{Entry, KINDS, Kind, Mistake};
use machine::Machine;
use motion::{harmonics, points};
use simulation::Simulation;

/// Default duration of a log, s.
const DURATION: f64 = 20.0;
/// Durations of the logs without a mistake, s.
const DURATIONS: [f64; 6] = [1.0, 2.0, 3.0, 5.0, 10.0, 30.0];

/// A robot, its machine (the true robot), its motions, and the mistake in its log.
pub struct Situation<'a> {
    /// The seed, which determines all other fields.
    pub seed: u64,
    pub arm: &'a Arm,
    /// The robot that is logged. It differs from `arm` only for [`Kind::OtherRobot`].
    pub logged: &'a Arm,
    pub machine: Machine,
    pub motion: Motion,
    /// The motion of a second log, which `rist identify` gets together with the first one.
    pub second: Motion,
    /// A motion on which the estimate is evaluated.
    pub third: Motion,
    /// The kind of the mistake; `None`: there is none.
    pub entry: Option<&'static Entry>,
    /// The mistake with its joints; `None`: there is none.
    pub mistake: Option<Mistake>,
}

impl<'a> Situation<'a> {
    /// The situation for a seed. Successive seeds have successive kinds of mistakes. The robot is random among the robots that
    /// can have the kind.
    pub fn of(seed: u64, arms: &'a [Arm]) -> Situation<'a> {
        let entry = &KINDS[(seed % KINDS.len() as u64) as usize];
        let draw = &mut Draw::of(seed, 1);
        let able: Vec<&Arm> =
            arms.iter().filter(|arm| entry.kind != Kind::OtherRobot || !others(arm, arms).is_empty()).collect();
        let arm = able[draw.below(able.len())];
        let logged = if entry.kind == Kind::OtherRobot { others(arm, arms)[0] } else { arm };
        let [motion, second, third] =
            [2, 6, 8].map(|purpose| harmonics(logged, DURATION, &mut Draw::of(seed, purpose)));
        let machine = Machine::of(logged, &motion, &mut Draw::of(seed, 3));
        let mistake = Some(mistake(arm, entry.kind, &mut Draw::of(seed, 4)));
        Situation { seed, arm, logged, machine, motion, second, third, entry: Some(entry), mistake }
    }

    /// A situation without a mistake for a seed. The log lasts 1 s to 30 s, and one of three is a motion from point to point.
    pub fn clean(seed: u64, arms: &'a [Arm]) -> Situation<'a> {
        let draw = &mut Draw::of(seed, 1);
        let arm = &arms[draw.below(arms.len())];
        let (duration, stops) = (DURATIONS[draw.below(DURATIONS.len())], draw.chance(1.0 / 3.0));
        let draw = &mut Draw::of(seed, 2);
        let motion = if stops { points(arm, duration, draw) } else { harmonics(arm, duration, draw) };
        let machine = Machine::of(arm, &motion, &mut Draw::of(seed, 3));
        let [second, third] = [6, 8].map(|purpose| harmonics(arm, DURATION, &mut Draw::of(seed, purpose)));
        Situation { seed, arm, logged: arm, machine, motion, second, third, entry: None, mistake: None }
    }

    /// Writes the log with or without the mistake, and returns its path.
    pub fn write(&self, is_wrong: bool) -> PathBuf {
        self.written(if is_wrong { "wrong.csv" } else { "right.csv" }, &self.simulation(is_wrong), 5)
    }

    /// Writes a second log of the same machine with the same mistake.
    pub fn write_second(&self) -> PathBuf {
        self.written("second.csv", &Simulation { motion: &self.second, ..self.simulation(true) }, 7)
    }

    fn written(&self, name: &str, simulation: &Simulation, purpose: u64) -> PathBuf {
        self.saved(name, &simulation.log(&mut Draw::of(self.seed, purpose)))
    }

    fn saved(&self, name: &str, log: &JointLog) -> PathBuf {
        let path = folder("remedies").join(name);
        log.write(&path, &self.arm.names());
        path
    }

    /// Writes a log of a third motion. Positions and velocities have the mistake; the torques are the true motor torques. If the
    /// mistake is a delay, the torques are also delayed, because an estimate includes the delay that it corrects.
    pub fn write_judge(&self) -> PathBuf {
        let wrong = Simulation { motion: &self.third, ..self.simulation(true) };
        let is_logged = self.mistake.is_none_or(|m| m.kind.is_of_machine() || matches!(m.kind, Kind::Late(_)));
        let right = Simulation { mistake: wrong.mistake.filter(|_| is_logged), ..wrong };
        let [mut log, right] = [wrong, right].map(|simulation| simulation.log(&mut Draw::of(self.seed, 9)));
        log.tau = right.tau;
        self.saved("judge.csv", &log)
    }

    /// The size of the mistake in the unit of the program's claims about it; `None` if it has no size.
    pub fn size(&self) -> Option<f64> {
        let entry = self.entry?;
        match entry.kind {
            Kind::Spring => {
                let simulation = self.simulation(true);
                simulation.stiffness(&simulation.log(&mut Draw::of(self.seed, 5)))
            }
            _ => entry.size,
        }
    }

    /// The names of the joints that the mistake concerns: none, one or two.
    pub fn joints(&self) -> Vec<&str> {
        let Some(mistake) = &self.mistake else { return Vec::new() };
        let all: &[usize] = match mistake.kind {
            Kind::Zero(_) | Kind::MotionSign | Kind::TorqueSign | Kind::Reversed | Kind::Scaled(_) => &[mistake.a],
            Kind::Spring | Kind::DeadTorque | Kind::Saturated | Kind::Contact | Kind::Drift => &[mistake.a],
            Kind::SwappedMotions | Kind::SwappedVelocities | Kind::SwappedTorques => &[mistake.a, mistake.b],
            Kind::SwappedColumns | Kind::TwoScaled => &[mistake.a, mistake.b],
            _ => &[],
        };
        all.iter().map(|&k| self.arm.robot.coordinates[k].name.as_str()).collect()
    }

    pub fn description(&self) -> &Path {
        &self.arm.path
    }

    fn simulation(&self, is_wrong: bool) -> Simulation<'_> {
        let mistake = self.mistake.filter(|_| is_wrong);
        Simulation { arm: self.logged, machine: &self.machine, motion: &self.motion, mistake }
    }
}

impl fmt::Display for Situation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = self.entry.map_or("no mistake", |entry| entry.name);
        write!(f, "seed {} {}: {what}", self.seed, self.arm.name)?;
        let joints = self.joints();
        if joints.is_empty() { Ok(()) } else { write!(f, " of {}", joints.join(" and ")) }
    }
}

fn others<'a>(arm: &Arm, arms: &'a [Arm]) -> Vec<&'a Arm> {
    arms.iter().filter(|other| other.name != arm.name && other.n() == arm.n()).collect()
}

/// A mistake of this kind at random joints that can have it. Only revolute joints get a zero error.
fn mistake(arm: &Arm, kind: Kind, draw: &mut Draw) -> Mistake {
    let able: Vec<usize> = (0..arm.n()).filter(|&k| !matches!(kind, Kind::Zero(_)) || !arm.slides(k)).collect();
    let a = able[draw.below(able.len())];
    let rest: Vec<usize> = (0..arm.n()).filter(|&k| k != a).collect();
    let b = rest[draw.below(rest.len())];
    Mistake { kind, a, b, more: draw.uniform(0.0, 1.0) }
}
