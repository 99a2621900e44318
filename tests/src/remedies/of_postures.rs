//! Tests `rist postures`: tables of postures at rest with one mistake. Some machines agree with their description, others do not.
//!
//! The machine is the true robot; `off` and zeros are errors of joint positions, rad.

use std::f64::consts::PI;

use super::arms::Arm;
use super::case::{Case, Command, with_steps};
use super::kinds::{Entry, KINDS, Kind, Mistake};
use super::machine::Machine;
use super::motion::harmonics;
use super::said::names;
use super::wrong_columns::spoil;
use super::{DURATION, mistake};
use crate::joint_log::{JointLog, described};
use crate::program::{Run, folder};
use crate::random::State;
use crate::random_situations::draw::Draw;
use crate::recursion;

/// The kinds of mistakes that are used here, from the kinds for logs.
const NAMES: [&str; 11] = [
    "torque sign",
    "all torque signs",
    "motion sign",
    "degrees",
    "torque x0.25",
    "torque x4",
    "swapped torques",
    "torques in N mm",
    "on a wall",
    "zero 30 deg",
    "zero 90 deg",
];
/// Fraction of the Coulomb friction that acts on a joint at rest.
const HOLDING: f64 = 0.2;
/// A mistake should be found if it changes a torque by at least this multiple of all other errors.
const SHOWS: f64 = 10.0;
/// The direction of gravity, or a zero, is found correctly if its error is below this, rad.
const NEAR: f64 = 0.1;
/// A zero error below this may be caused by wrong nominal bodies, rad.
const FAR: f64 = 0.1;

pub const COMMAND: Command = Command { word: "postures", case, findings, obeyed: with_steps };

fn case(seed: u64, arms: &[Arm]) -> Case<'_> {
    let draw = &mut Draw::of(seed, 1);
    let arm = &arms[draw.below(arms.len())];
    let machine = Machine::of(arm, &harmonics(arm, DURATION, &mut Draw::of(seed, 2)), &mut Draw::of(seed, 3));
    let is_described = draw.chance(0.5);
    let bodies = if is_described { described(&arm.robot) } else { machine.parameters.clone() };
    let name = NAMES.get((seed % (NAMES.len() as u64 + 1)) as usize);
    let entry = name.and_then(|name| KINDS.iter().find(|entry| entry.name == *name));
    let mistake = entry.map(|entry| mistake(arm, entry.kind, &mut Draw::of(seed, 4)));
    let base = if let Some(Kind::Base(base)) = entry.map(|entry| entry.kind) { Some(base) } else { None };
    let postures: Vec<Vec<f64>> = (0..30 + draw.below(50)).map(|_| posture(arm, draw)).collect();
    let at_rest = |base: Option<[f64; 3]>, q: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let robot = arm.mounted(base);
        let rest = vec![0.0; arm.n()];
        let state = |q: &Vec<f64>| State { q: q.clone(), dq: rest.clone(), ddq: rest.clone() };
        transposed(&q.iter().map(|q| recursion::torque(&robot, &state(q), &bodies)).collect::<Vec<_>>())
    };
    let noise = |k: usize, draw: &mut Draw| {
        HOLDING * machine.coulomb[k] * draw.uniform(-1.0, 1.0) + machine.sensors.noise * machine.size[k] * draw.normal()
    };
    let table = |mistake: Option<Mistake>, is_noisy: bool| {
        let mut tau = at_rest(base.filter(|_| mistake.is_some()), &postures);
        let draw = &mut Draw::of(seed, 5);
        let noise = |k: usize, draw: &mut Draw| if is_noisy { noise(k, draw) } else { 0.0 };
        tau.iter_mut().enumerate().for_each(|(k, tau)| tau.iter_mut().for_each(|x| *x += noise(k, draw)));
        let (t, q) = ((0..postures.len()).map(|r| r as f64).collect(), transposed(&postures));
        let mut log = JointLog { t, dq: q.clone(), q, tau };
        mistake.iter().for_each(|mistake| spoil(arm, mistake, &mut log));
        log.dq.clear();
        log
    };
    let (right, wrong, exact) = (table(None, true), table(mistake, true), table(mistake, false));
    // The torque residual that the mistake causes, computed with the true bodies.
    let of_wrong = at_rest(None, &transposed(&exact.q));
    let left = |a: &[f64], b: &[f64]| {
        let left: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        let mean = left.iter().sum::<f64>() / left.len() as f64;
        (left.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / left.len() as f64).sqrt()
    };
    let shows = (0..arm.n()).any(|k| left(&exact.tau[k], &of_wrong[k]) > SHOWS * left(&wrong.tau[k], &exact.tau[k]));
    let is_of_place = matches!(entry.map(|entry| entry.kind), Some(Kind::Zero(_) | Kind::Base(_) | Kind::Scaled(_)));
    let words = |log: &JointLog, file: &str| {
        let path = folder("remedies").join(file);
        log.write(&path, &arm.names());
        let words = ["postures".into(), arm.path.display().to_string(), path.display().to_string()];
        [words.to_vec(), arm.flags()].concat()
    };
    let off = mistake.map(|mistake| wrong.q[mistake.a][0] - right.q[mistake.a][0]);
    let joints = mistake.map_or(vec![], |m| [m.a, m.b].map(|k| arm.names()[k].clone()).to_vec());
    Case {
        arm,
        kind: name.unwrap_or(&"none"),
        is_right: is_right(entry, joints, mistake.map_or(0, |m| m.a), off.unwrap_or(0.0)),
        is_above: shows && (is_described || !is_of_place),
        words: words(&wrong, "wrong.csv"),
        clean: Some(words(&right, "right.csv")),
    }
}

fn transposed(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..rows.first().map_or(0, Vec::len)).map(|k| rows.iter().map(|row| row[k]).collect()).collect()
}

fn posture(arm: &Arm, draw: &mut Draw) -> Vec<f64> {
    let place = |k: usize| {
        let (low, high) = arm.range(k);
        draw.uniform(0.95 * low + 0.05 * high, 0.05 * low + 0.95 * high)
    };
    (0..arm.n()).map(place).collect()
}

/// Returns a function: whether a text names the mistake of these joints. `off`: zero error of joint a.
fn is_right(entry: Option<&'static Entry>, joints: Vec<String>, a: usize, off: f64) -> Box<dyn Fn(&str) -> bool> {
    Box::new(move |text| match entry.map(|entry| entry.kind) {
        None => false,
        Some(Kind::Zero(_)) => {
            let Some((_, list)) = text.split_once("offsets: [") else { return false };
            let zero = list.split([',', ']']).nth(a).and_then(|x| x.trim().parse::<f64>().ok());
            zero.is_some_and(|zero| (zero + off).sin().abs() < NEAR && (zero + off).cos() > 0.0)
        }
        Some(Kind::AllTorqueSigns) if text.contains("all joints have the wrong sign") => true,
        Some(kind @ (Kind::Base(_) | Kind::AllTorqueSigns)) => {
            // If the robot is at rest, torques with the wrong sign are equivalent to a base that hangs upside down.
            let base = if let Kind::Base(base) = kind { base } else { [PI, 0.0, 0.0] };
            let Some((_, flag)) = text.split_once("--base ") else { return false };
            let found: Vec<f64> = flag.split([',', ';', ' ']).filter_map(|x| x.parse().ok()).take(3).collect();
            let down = |[r, p, _]: [f64; 3]| [-p.sin(), p.cos() * r.sin(), p.cos() * r.cos()];
            found.len() == 3
                && down([found[0], found[1], 0.0]).iter().zip(down(base)).all(|(a, b)| (a - b).abs() < NEAR)
        }
        Some(kind) => {
            entry.into_iter().flat_map(|entry| entry.right).any(|words| {
                let said = |a: &str, b: &str| text.contains(&words.replace("{a}", a).replace("{b}", b));
                said(&joints[0], &joints[1]) || (kind == Kind::SwappedTorques && said(&joints[1], &joints[0]))
            }) && (!entry.is_some_and(|entry| entry.right[0].contains("{a}")) || names(text, &joints[0]))
        }
    })
}

/// The findings of a run: mistakes in the columns, or zeros and base orientation that differ from the description.
fn findings(_: &[String], run: &Run) -> Vec<String> {
    let is_far = run.out.lines().any(is_far);
    let is_finding = |line: &&str| line.contains("; corrected: ") || (is_far && line.starts_with("to hold them"));
    run.out.lines().filter(is_finding).map(str::to_string).collect()
}

/// Whether a line states a zero error or a base rotation too large to be caused by a wrong centre of mass (an error of some
/// centimetres gives a small zero error).
fn is_far(line: &str) -> bool {
    let Some((told, _)) = line.split_once(" zero, ").or(line.split_once(" turn of gravity")) else { return false };
    let numbers: Vec<f64> = told.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    matches!(numbers[..], [value, deviation] if value.abs() > FAR && value.abs() > 3.0 * deviation)
}
