//! Simulates a fleet of robots, some of which have an additional load or more friction. Counts how many of them `rist compare`
//! reports, and how many of the reported robots are unchanged.
//!
//! Each robot has logs of its own motions: two sines per joint. The torque noise is 1 % of the joint's torque, half of it white,
//! half correlated over 0.1 s. Friction varies by 2 % between logs, for example by temperature. A changed robot has a load on its
//! last link, or other viscous and Coulomb friction in one joint.
//!
//! The size of a change is the change of the parameter that changes most, in standard deviations of its difference from the
//! reference. Divided by the root of the number of logs, it is in standard deviations of a single log.

use std::f64::consts::TAU;

use fleet::Accumulator;
use fleet::{Compared, Comparison, SumsRequest, compare};
use identification::estimate::options::Options;
use logs::{Log, LogSource};
use processor::{in_order, threads};
use random::Random;
use rist::Model;
use robot::{Inertial, StandardParameter};

use crate::joint_log::even_log;

/// Sampling period, s.
const PERIOD: f64 = 0.01;

#[derive(Clone, Copy, Debug)]
pub struct Fleet {
    pub robots: usize,
    /// Number of changed robots.
    pub changed: usize,
    /// Number of logs of each robot. `seconds`: duration of a log.
    pub logs: usize,
    pub seconds: f64,
    pub reference_logs: usize,
    pub seed: u64,
}

#[derive(Clone)]
struct Machine {
    base: Vec<f64>,
    viscous: Vec<f64>,
    coulomb: Vec<f64>,
}

/// The results of the comparison of a fleet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// Number of robots that are reported as changed. `right_robots`: number of these that did change.
    pub robots: usize,
    pub right_robots: usize,
    /// Number of parameters that are reported as changed. `right_parameters`: number of these that did change.
    pub parameters: usize,
    pub right_parameters: usize,
    pub changed: usize,
    /// Number of parameters that changed by at least 90 % of the simulated size. `named`: number of these that are reported.
    pub moved: usize,
    pub named: usize,
}

impl Found {
    /// Share of the reported robots that did not change; zero if no robot is reported.
    pub fn false_robots(&self) -> f64 {
        1.0 - share(self.right_robots, self.robots)
    }

    /// Share of the reported parameters that did not change.
    pub fn false_parameters(&self) -> f64 {
        1.0 - share(self.right_parameters, self.parameters)
    }

    /// Share of the changed robots that are reported.
    pub fn power(&self) -> f64 {
        share(self.right_robots, self.changed)
    }

    /// Share of the fully changed parameters (at least 90 % of the simulated size) that are reported.
    pub fn parameter_power(&self) -> f64 {
        share(self.named, self.moved)
    }
}

fn share(some: usize, of: usize) -> f64 {
    if of > 0 { some as f64 / of as f64 } else { 1.0 }
}

/// Makes the robots of a fleet. It has the model, the options of the identification, and the parameters of a robot without
/// changes.
pub struct Workshop<'a> {
    model: &'a Model,
    options: Options,
    healthy: Machine,
    /// The change of the base parameters if 1 kg is added to the last link.
    load: Vec<f64>,
    /// Rms of each joint's torque, N m.
    scale: Vec<f64>,
}

impl<'a> Workshop<'a> {
    /// Uses the nominal base parameters. Friction is proportional to the rms torques of a motion.
    pub fn new(model: &'a Model) -> Workshop<'a> {
        let n = model.regressor().coordinates().len();
        let standard = StandardParameter::all(&model.robot);
        let last = standard.iter().map(|s| s.link.0).max().unwrap_or(0);
        // The load: 1 kg at (0.02, 0.03, 0.08) m in the frame of the last link.
        let body = |s: &StandardParameter| match s.inertial {
            _ if s.link.0 != last => 0.0,
            Inertial::M => 1.0,
            Inertial::Mx => 0.02,
            Inertial::My => 0.03,
            Inertial::Mz => 0.08,
            Inertial::Xx | Inertial::Yy | Inertial::Zz => 0.008,
            _ => 0.0,
        };
        let load = model.parameters.values(&standard.iter().map(body).collect::<Vec<f64>>());
        let base = model.nominal_parameters().expect("the model has inertials");
        let mut options = Options::default();
        options.signal.cutoff = Some(10.0);
        let none = Machine { base, viscous: vec![0.0; n], coulomb: vec![0.0; n] };
        let mut shop = Workshop { model, options, healthy: none, load, scale: vec![0.0; n] };
        let quiet = shop.log(&shop.healthy, "scale", 20.0, &mut Random::new(7));
        let rms = |x: &Vec<f64>| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        shop.scale = quiet.effort.iter().map(|x| rms(x).max(0.1)).collect();
        shop.healthy.viscous = shop.scale.iter().map(|s| 0.1 * s).collect();
        shop.healthy.coulomb = shop.scale.iter().map(|s| 0.2 * s).collect();
        shop
    }

    fn log(&self, machine: &Machine, name: &str, seconds: f64, random: &mut Random) -> Log {
        let regressor = self.model.regressor();
        let (n, p) = (regressor.coordinates().len(), regressor.parameters().len());
        let count = (seconds / PERIOD) as usize;
        let waves: Vec<[f64; 3]> = (0..2 * n)
            .map(|k| [[0.6, 0.25][k % 2], [0.25, 0.7][k % 2] * random.between(0.8, 1.2), random.between(0.0, TAU)])
            .collect();
        let warm: Vec<f64> = (0..n).map(|_| 1.0 + 0.02 * random.normal()).collect();
        let mut states = Vec::with_capacity(3 * n * count);
        for r in 0..count {
            let t = PERIOD * r as f64;
            for order in 0..3 {
                for j in 0..n {
                    let wave = |[a, f, phase]: &[f64; 3]| {
                        let w = TAU * f;
                        a * w.powi(order) * (w * t + phase + 0.25 * TAU * f64::from(order)).sin()
                    };
                    states.push(waves[2 * j..2 * j + 2].iter().map(wave).sum::<f64>());
                }
            }
        }
        let mut y = vec![0.0; n * p * count];
        regressor.fill_many(&states, &mut y);
        let mut slow = vec![0.0; n];
        let empty = || vec![Vec::with_capacity(count); n];
        let (mut q, mut dq, mut effort) = (empty(), empty(), empty());
        for r in 0..count {
            for j in 0..n {
                let speed = states[(3 * r + 1) * n + j];
                let rigid: f64 = y[(r * n + j) * p..][..p].iter().zip(&machine.base).map(|(y, x)| y * x).sum();
                let friction = warm[j] * (machine.viscous[j] * speed + machine.coulomb[j] * speed.signum());
                slow[j] = 0.9 * slow[j] + f64::sqrt(1.0 - 0.81) * random.normal();
                let noise = 0.01 * self.scale[j] * f64::sqrt(0.5) * (random.normal() + slow[j]);
                q[j].push(states[3 * r * n + j]);
                dq[j].push(speed);
                effort[j].push(rigid + friction + noise);
            }
        }
        Log { name: name.into(), ..even_log(regressor.coordinates(), PERIOD, [q, dq, effort]) }
    }

    fn sums(&self, machine: &Machine, name: &str, logs: usize, seconds: f64, random: &mut Random) -> Accumulator {
        let mut sums = fleet::accumulator(self.model, &SumsRequest::of_options(self.options.clone()))
            .expect("the options are those of sums");
        for k in 0..logs {
            let log = LogSource::Held(self.log(machine, &format!("{name}-{k:03}"), seconds, random));
            fleet::update(self.model, &mut sums, &log, true).unwrap_or_else(|e| panic!("{e}"));
        }
        sums
    }

    /// The parameters of a robot in the order of the columns of the sums: base parameters, then viscous and Coulomb friction per
    /// joint.
    fn truth(&self, machine: &Machine) -> Vec<f64> {
        let friction = |j: usize| [machine.viscous[j], machine.coulomb[j], 0.0];
        machine.base.iter().copied().chain((0..machine.viscous.len()).flat_map(friction)).collect()
    }

    /// A changed robot. If `k` is even, it has an additional load; if `k` is odd, it has other friction in one joint. `size`:
    /// size of the change in standard deviations. `sigma`: standard deviation of the difference of each parameter from the
    /// reference.
    fn changed(&self, k: usize, size: f64, sigma: &[f64]) -> Machine {
        let mut machine = self.healthy.clone();
        let (n, p) = (machine.viscous.len(), machine.base.len());
        if k.is_multiple_of(2) {
            let most = self.load.iter().zip(sigma).map(|(x, s)| (x / s).abs()).fold(0.0, f64::max);
            machine.base.iter_mut().zip(&self.load).for_each(|(x, load)| *x += size / most * load);
        } else {
            let j = k / 2 % n;
            machine.viscous[j] += size * sigma[p + 3 * j];
            machine.coulomb[j] += size * sigma[p + 3 * j + 1];
        }
        machine
    }
}

/// Simulates fleets with changes of the given sizes, and compares each robot with the reference robot. `rate`: false discovery
/// rate. The unchanged robots are the same for all sizes.
pub fn simulate(model: &Model, fleet: Fleet, sizes: &[f64], rate: f64) -> Vec<(f64, Found)> {
    let shop = Workshop::new(model);
    let random = |k: usize| Random::stream(fleet.seed, k as u64);
    let reference = shop.sums(&shop.healthy, "reference", fleet.reference_logs, fleet.seconds, &mut random(0));
    let sums = |machines: &[(usize, Machine)]| {
        let mut found = Vec::new();
        let one = |_: usize, (k, machine): &(usize, Machine)| {
            shop.sums(machine, &format!("robot-{k:03}"), fleet.logs, fleet.seconds, &mut random(1 + k))
        };
        let done: Result<(), ()> = in_order(machines, threads(), one, |_, sums| {
            found.push(sums);
            Ok(())
        });
        done.expect("nothing fails");
        found
    };
    let healthy: Vec<(usize, Machine)> = (fleet.changed..fleet.robots).map(|k| (k, shop.healthy.clone())).collect();
    let healthy = sums(&healthy);
    let compared = |robots: &[&Accumulator]| -> Comparison {
        let named: Vec<(&str, &Accumulator)> = robots.iter().map(|sums| ("robot", *sums)).collect();
        compare(("reference", &reference), &named, Compared::All, rate).unwrap_or_else(|e| panic!("{e}"))
    };
    // The standard deviations of the differences between a robot and the reference. Each is a mean over some robots, because the
    // value of a single robot has an uncertainty of 20 %.
    let some = compared(&healthy.iter().take(16).collect::<Vec<_>>());
    let columns = some.robots[0].parameters.len();
    let mean = |c: usize| some.robots.iter().map(|r| r.parameters[c].sigma.powi(2)).sum::<f64>();
    let sigma: Vec<f64> = (0..columns).map(|c| (mean(c) / some.robots.len() as f64).sqrt()).collect();
    let before = shop.truth(&shop.healthy);
    assert_eq!(before.len(), columns, "every parameter is determined");
    let outcome = |&size: &f64| {
        let machines: Vec<(usize, Machine)> = (0..fleet.changed).map(|k| (k, shop.changed(k, size, &sigma))).collect();
        let changed = sums(&machines);
        let all = compared(&changed.iter().chain(&healthy).collect::<Vec<_>>());
        let mut found = Found { changed: fleet.changed, ..Found::default() };
        for (k, robot) in all.robots.iter().enumerate() {
            let truth = machines.get(k).map(|(_, machine)| shop.truth(machine)).unwrap_or_else(|| before.clone());
            found.robots += usize::from(robot.changed);
            found.right_robots += usize::from(robot.changed && k < fleet.changed);
            for (c, difference) in robot.parameters.iter().enumerate() {
                let true_size = (truth[c] - before[c]).abs() / sigma[c];
                let is_full = true_size > 0.9 * size;
                found.parameters += usize::from(difference.moved);
                found.right_parameters += usize::from(difference.moved && true_size > 0.0);
                found.moved += usize::from(is_full);
                found.named += usize::from(is_full && difference.moved);
            }
        }
        (size, found)
    };
    sizes.iter().map(outcome).collect()
}
