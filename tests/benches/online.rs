//! Tests what `rist replay` finds (external torques, contacts, loads) in random logs of five arms at work. Command:
//! `cargo bench -p tests --bench online [HOURS] [PUSHES] [LOADS]`.
//!
//! The bodies differ by up to 15 % from the description. Each arm is identified from a log of 60 s. All other logs are new: slow
//! and fast motion with reversals, noise on torques and velocities, viscous and Coulomb friction.
//!
//! | table | columns |
//! |---|---|
//! | alarms | threshold for one false alarm an hour; hours of motion without contact; alarms |
//! | pushes | largest joint torque of the push, N m; share found within 20 ms, and at all; the last significant joint moves the touched link or a link before it; median of the limit of the pushed joint, N m |
//! | long pushes | share of the pushes of 1 s with 10 N m that are taken for a load |
//! | loads | number; found; after how long, median, s; RMS error of the mass, %; share of the masses within two sigma; RMS of (error / sigma) of the mass; the last two also of MX, MY and MZ |
//! | after .5 s | of the loads of 1 kg and more: their number; share with the mass within 3 %, and with the centre of mass within 5 mm, where the motion determines them; RMS error of the mass, %, and of a component of the centre, mm; RMS of (error / sigma) of the mass |

use std::path::Path;

use random::Random;
use rist::request::{IdentifyRequest, ReplayRequest};
use rist::{Estimate, KnownLoad, LogSource, Model, Replay};
use tests::joint_log::unlike;
use tests::on_robot::{Carried, Push, Scene};

const ARMS: [&str; 5] = ["ur5.urdf", "rx90.yaml", "tx40.yaml", "puma560.yaml", "panda.yaml"];
/// Length of a log, s.
const SECONDS: f64 = 120.0;

struct Arm {
    model: Model,
    x: Vec<f64>,
    friction: Vec<[f64; 3]>,
    estimate: Estimate,
    reference: LogSource,
}

impl Arm {
    fn new(file: &str) -> Arm {
        let model = Model::read(tests::model_path(file)).unwrap_or_else(|e| panic!("{e}"));
        let standard = match model.nominal_parameters() {
            Some(_) => unlike(&model.robot, 5),
            None => tests::random::Random(5).physical_parameters(&model.robot),
        };
        let x = model.parameters.values(&standard);
        let n = model.regressor().coordinates().len();
        let share = |k: usize| (1.0 - k as f64 / n as f64).powi(2) + 0.1;
        let friction: Vec<[f64; 3]> = (0..n).map(|k| [5.0 * share(k), 4.0 * share(k), 0.1]).collect();
        let reference = scene(&model, &x, &friction, 1, 60.0).source();
        let mut request = IdentifyRequest::default();
        request.samples.covariance = true;
        let found =
            rist::identify(&model, std::slice::from_ref(&reference), &request).unwrap_or_else(|e| panic!("{e}"));
        let estimate = found.estimate;
        Arm { model, x, friction, estimate, reference }
    }

    fn scene(&self, seed: u64, seconds: f64) -> Scene<'_> {
        scene(&self.model, &self.x, &self.friction, seed, seconds)
    }

    fn replay(&self, log: &LogSource) -> Replay {
        let (file, reference) = (Path::new("e.yaml"), std::slice::from_ref(&self.reference));
        let request = ReplayRequest { anyway: true, ..ReplayRequest::default() };
        rist::replay(&self.model, (file, &self.estimate), log, reference, &request).unwrap_or_else(|e| panic!("{e}"))
    }
}

fn scene<'a>(model: &'a Model, x: &[f64], friction: &[[f64; 3]], seed: u64, seconds: f64) -> Scene<'a> {
    Scene {
        model,
        x: x.to_vec(),
        friction: friction.to_vec(),
        seed,
        seconds,
        rate: 500.0,
        noise: 0.1,
        speed_noise: 1e-3,
        amplitude: 1.0,
        pushes: Vec::new(),
        loads: Vec::new(),
    }
}

fn main() {
    let mut numbers = std::env::args().skip(1).filter_map(|word| word.parse::<f64>().ok());
    let mut next = |default: f64| numbers.next().unwrap_or(default);
    let (hours, pushes, loads) = (next(1.0), next(40.0) as u64, next(20.0) as u64);
    let arms: Vec<(&str, Arm)> = ARMS.iter().map(|file| (*file, Arm::new(file))).collect();
    println!("| arm | threshold | hours | alarms |");
    println!("|---|---|---|---|");
    let mut all = 0;
    for (name, arm) in &arms {
        let logs = (hours * 3600.0 / SECONDS / arms.len() as f64).ceil() as u64;
        let replays = (0..logs).map(|seed| arm.replay(&arm.scene(1000 + seed, SECONDS).source()));
        let found: Vec<(usize, f64)> = replays.map(|r| (r.contacts.len() + r.loads.len(), r.threshold)).collect();
        let count: usize = found.iter().map(|(count, _)| count).sum();
        all += count;
        println!("| {name} | {:.2} | {:.2} | {count} |", found[0].1, logs as f64 * SECONDS / 3600.0);
    }
    println!("\n{all} alarms in {hours} hours\n");
    println!("| torque | within 20 ms | found | right side | limit |");
    println!("|---|---|---|---|---|");
    for torque in [2.0, 5.0, 10.0] {
        pushed(&arms, torque, pushes);
    }
    let taken = (0..pushes).filter(|draw| !pushed_once(&arms, 10.0, *draw, 1.0).0.loads.is_empty()).count();
    println!("\nlong pushes: {:.0} % are taken for a load", 100.0 * taken as f64 / pushes as f64);
    println!(
        "\n| loads | found | after, s | error % | within 2 sigma | error / sigma | moments within 2 sigma | error / sigma |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    loaded(&arms, loads);
}

/// Replays a log with one push of `seconds` s. Returns the replay, the time at which the push begins (s), the index of the
/// touched link, and the index of the joint with the largest torque.
fn pushed_once(arms: &[(&str, Arm)], torque: f64, draw: u64, seconds: f64) -> (Replay, f64, [usize; 2]) {
    let (_, arm) = &arms[draw as usize % arms.len()];
    let mut random = Random::new(7000 + draw);
    let n = arm.x.len().min(arm.friction.len());
    let link = 1 + (random.uniform() * (n - 1) as f64) as usize;
    let force = [random.normal(), random.normal(), random.normal()];
    let from = 3.0 + 14.0 * random.uniform();
    let mut scene = arm.scene(8000 + draw, 20.0);
    scene.pushes.push(Push { link, from, to: from + seconds, force, largest: Some(torque) });
    let (log, largest) = scene.log();
    (arm.replay(&LogSource::Held(log)), from, [link, largest[0].1])
}

fn pushed(arms: &[(&str, Arm)], torque: f64, pushes: u64) {
    let (mut quick, mut found, mut right, mut limits) = (0, 0, 0, Vec::new());
    for draw in 0..pushes {
        let (replay, from, [link, joint]) = pushed_once(arms, torque, draw, 0.3);
        let at = replay.series.iter().find(|cycle| cycle.t >= from).map_or(0.0, |cycle| cycle.band[joint]);
        limits.push(at);
        if let Some(contact) = replay.contacts.iter().find(|c| c.start >= from && c.start < from + 0.35) {
            found += 1;
            quick += u32::from(contact.start <= from + 0.02);
            right += u32::from(contact.last_joint <= link);
        }
    }
    limits.sort_by(f64::total_cmp);
    let share = |count: u32| 100.0 * f64::from(count) / pushes as f64;
    println!(
        "| {torque} | {:.0} % | {:.0} % | {:.0} % | {:.2} |",
        share(quick),
        share(found),
        100.0 * f64::from(right) / f64::from(found.max(1)),
        limits[limits.len() / 2]
    );
}

fn loaded(arms: &[(&str, Arm)], loads: u64) {
    let (mut found, mut errors, mut ratios, mut delays) = (0, Vec::new(), Vec::new(), Vec::new());
    let mut moment_ratios = Vec::new();
    let (mut early_masses, mut early_centres, mut early_ratios) = (Vec::new(), Vec::new(), Vec::new());
    for draw in 0..loads {
        let (_, arm) = &arms[draw as usize % arms.len()];
        let mut random = Random::new(9000 + draw);
        let mass = 0.3 + 2.7 * random.uniform();
        let link = arm.model.robot.links.last().map_or(String::new(), |link| link.name.clone());
        let centre_of_mass = [0.05 * random.normal(), 0.05 * random.normal(), 0.05 * random.normal()];
        let load = KnownLoad { link, mass, centre_of_mass, inertia: Default::default() };
        let mut scene = arm.scene(9500 + draw, 20.0);
        scene.loads.push(Carried { from: 5.0, to: 100.0, load });
        let replay = arm.replay(&scene.source());
        if let Some(carried) = replay.loads.last() {
            found += 1;
            delays.push(carried.found - 5.0);
            let (value, sigma) = carried.mass();
            errors.push(value / mass - 1.0);
            ratios.push((value - mass) / sigma);
            let moments = (6..9).filter(|k| carried.load.is_determined[*k]);
            moment_ratios.extend(
                moments.map(|k| (carried.load.parameters[k] - mass * centre_of_mass[k - 6]) / carried.load.sigma[k]),
            );
            if let Some(early) = carried.early.filter(|early| mass >= 1.0 && early.is_determined[9]) {
                early_masses.push(early.parameters[9] / mass - 1.0);
                early_ratios.push((early.parameters[9] - mass) / early.sigma[9]);
                let determined = (0..3).filter(|c| early.is_determined[6 + c]);
                early_centres
                    .extend(determined.map(|c| early.parameters[6 + c] / early.parameters[9] - centre_of_mass[c]));
            }
        }
    }
    delays.sort_by(f64::total_cmp);
    delays.extend(delays.is_empty().then_some(f64::NAN));
    let share = |errors: &[f64], limit: f64| {
        100.0 * errors.iter().filter(|e| e.abs() <= limit).count() as f64 / errors.len().max(1) as f64
    };
    let rms = |errors: &[f64]| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt();
    println!(
        "| {loads} | {found} | {:.2} | {:.2} | {:.0} % | {:.2} | {:.0} % | {:.2} |",
        delays[delays.len() / 2],
        100.0 * rms(&errors),
        share(&ratios, 2.0),
        rms(&ratios),
        share(&moment_ratios, 2.0),
        rms(&moment_ratios)
    );
    println!(
        "\n| after .5 s | mass within 3 % | centre within 5 mm | mass, % | centre, mm | error / sigma |\n|---|---|---|---|---|---|"
    );
    println!(
        "| {} ({} components) | {:.0} % | {:.0} % | {:.2} | {:.2} | {:.2} |",
        early_masses.len(),
        early_centres.len(),
        share(&early_masses, 0.03),
        share(&early_centres, 5e-3),
        100.0 * rms(&early_masses),
        1e3 * rms(&early_centres),
        rms(&early_ratios)
    );
}
