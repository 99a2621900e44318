//! Tests that a motion keeps the limits of the description if its file passes `rist check`, no matter what was changed in the
//! file.
//!
//! Files are changed at random: numbers, lines, whole keys. Files that pass the check are evaluated with the formulas of
//! docs/motion-and-plan.md and with the Newton-Euler recursion, both independent of the check. Plans are tested in the same way.
//! `MUTANTS=10000 INSTANTS=10000` in the environment tests more files and instants.

use experiments::excitation::artefact::ExcitingMotion;
use random::Random;
use rist::request::{CheckRequest, ExciteRequest, PlanRequest};
use rist::{ExperimentPlan, Model};
use tests::joint_log::described;
use tests::program::LIMITED_ARM;
use tests::random::State;
use tests::recursion;

fn asked(name: &str, otherwise: usize) -> usize {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

/// Position, velocity and acceleration of a Fourier series at s seconds after the start of a period.
fn series(centre: f64, amplitudes: (&[f64], &[f64]), w: f64, s: f64) -> [f64; 3] {
    let mut found = [centre, 0.0, 0.0];
    for (l, (a, b)) in amplitudes.0.iter().zip(amplitudes.1).enumerate() {
        let lw = w * (l + 1) as f64;
        let (sine, cosine) = (lw * s).sin_cos();
        found[0] += a / lw * sine - b / lw * cosine;
        found[1] += a * cosine + b * sine;
        found[2] += lw * (b * cosine - a * sine);
    }
    found
}

/// Position, velocity and acceleration of a Bezier polynomial of degree 4 at u, 0 <= u <= 1. p: control points, d: duration, s.
fn bezier(p: [f64; 5], u: f64, d: f64) -> [f64; 3] {
    let sum = |points: &[f64]| {
        let n = points.len() - 1;
        let binomial = |k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
        let term = |(k, x): (usize, &f64)| binomial(k) * u.powi(k as i32) * (1.0 - u).powi((n - k) as i32) * x;
        points.iter().enumerate().map(term).sum::<f64>()
    };
    let slope: Vec<f64> = p.windows(2).map(|p| 4.0 / d * (p[1] - p[0])).collect();
    let bend: Vec<f64> = slope.windows(2).map(|p| 3.0 / d * (p[1] - p[0])).collect();
    [sum(&p), sum(&slope), sum(&bend)]
}

/// Position, velocity and acceleration of each joint. `share`: 0 at the start of the first blend (from rest), 1 at the end of the
/// last blend (to rest).
fn state(motion: &ExcitingMotion, share: f64) -> Vec<[f64; 3]> {
    let (period, d) = (motion.period_s, motion.blend_s.expect("a series has a blend"));
    let w = std::f64::consts::TAU / period;
    let t = share * (period + 2.0 * d);
    let of = |joint: &experiments::excitation::artefact::MotionJoint| {
        let at = |s: f64| series(joint.centre, (&joint.cosine, &joint.sine), w, s);
        let [q, v, a] = at(0.0);
        let rest = |sign: f64| q + sign * d * v / 2.0 + d * d * a / 12.0;
        let (start, end) = (rest(-1.0), rest(1.0));
        if t < d {
            bezier([start, start, start, q - d * v / 4.0, q], t / d, d)
        } else if t > d + period {
            bezier([q, q + d * v / 4.0, end, end, end], (t - d - period) / d, d)
        } else {
            at(t - d)
        }
    };
    motion.joints.iter().map(of).collect()
}

/// Largest ratio of a position, velocity or torque to its limit in this state; 1: at the limit.
fn share(model: &Model, state: &State, x: &[f64]) -> f64 {
    let tau = recursion::torque(&model.robot, state, x);
    let of = |(k, coordinate): (usize, &robot::Coordinate)| {
        let limits = &coordinate.limits;
        let (low, high) = limits.position.expect("the arm has limits");
        let middle = 0.5 * (low + high);
        [
            (state.q[k] - middle).abs() / (high - middle),
            state.dq[k].abs() / limits.velocity.expect("the arm has limits"),
            tau[k].abs() / limits.effort.expect("the arm has limits"),
        ]
    };
    model.robot.coordinates.iter().enumerate().flat_map(of).fold(0.0, f64::max)
}

/// Largest ratio of a quantity to its limit during a motion, at `instants` instants.
fn used(model: &Model, motion: &ExcitingMotion, instants: usize) -> f64 {
    let x = described(&model.robot);
    let mut greatest = 0.0_f64;
    for i in 0..=instants {
        let joints = state(motion, i as f64 / instants as f64);
        let of = |d: usize| joints.iter().map(|x| x[d]).collect::<Vec<f64>>();
        greatest = greatest.max(share(model, &State { q: of(0), dq: of(1), ddq: of(2) }, &x));
    }
    greatest
}

/// Another number for the number in a text: a similar one, or a very different one.
fn other_number(random: &mut Random, text: &str) -> String {
    let x: f64 = text.parse().unwrap_or(1.0);
    match random.index(10) {
        0 => "0".into(),
        1 => format!("{:?}", -x),
        2 => [".nan", ".inf", "1e300", "-1e-300", "1e6"][random.index(5)].into(),
        3 => format!("{:?}", x * 10.0_f64.powi(random.index(9) as i32 - 4)),
        _ => format!("{:?}", x * (1.0 + 0.05 * random.between(-1.0, 1.0))),
    }
}

/// The text with one to four random changes.
fn mutant(random: &mut Random, text: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    for _ in 0..=random.index(4) {
        let at = random.index(lines.len());
        match random.index(12) {
            0 => drop(lines.remove(at)),
            1 => {
                let copy = lines[random.index(lines.len())].clone();
                lines.insert(at, copy);
            }
            2 => {
                let other = random.index(lines.len());
                lines.swap(at, other);
            }
            _ => {
                // The next line that ends with a number.
                let is_number = |line: &String| line.rsplit(' ').next().is_some_and(|x| x.parse::<f64>().is_ok());
                let Some(at) = (at..lines.len()).find(|&k| is_number(&lines[k])) else { continue };
                let Some((before, number)) = lines[at].rsplit_once(' ') else { continue };
                lines[at] = format!("{before} {}", other_number(random, number));
            }
        }
    }
    lines.join("\n") + "\n"
}

#[test]
fn what_passes_a_check_keeps_the_limits_of_the_description() {
    let model = Model::parse(LIMITED_ARM, "arm.yaml", &Default::default()).unwrap();
    let request =
        ExciteRequest { starts: 1, iterations: 20, repetitions: 1, period: Some(4.0), ..ExciteRequest::default() };
    let motion = rist::excite(&model, &request, &|_, _, _| ()).unwrap();
    let instants = asked("INSTANTS", 400);
    let honest = used(&model, &motion, instants);
    // The search uses the limits almost fully, so a slightly faster motion would exceed them.
    assert!(honest > 0.8 && honest <= 1.0, "{honest}");
    let text = motion.to_yaml().unwrap();
    // Most changes are made in the part of the file that defines the motion.
    let head = text.find("\neffort_share:").unwrap();
    let change = |random: &mut Random| mutant(random, &text[..head]) + &text[head + 1..];
    // The tolerance is for the rounding of a sum of ten terms.
    mutants_keep(&text, 39, 1.0 + 1e-12, change, |changed| {
        let read = ExcitingMotion::from_yaml("motion.yaml", changed).ok()?;
        let checked = rist::check(&model, "motion.yaml".as_ref(), &read, &CheckRequest::default());
        Some(checked.is_ok_and(|checked| checked.is_proven()).then(|| used(&model, &read, instants)))
    });
}

/// Checks that changed files whose motions are proven use at most `most` times a limit. A quarter of the changes are anywhere in
/// the file. `judged`: `None` if the text cannot be read, `Some(None)` if the motion is not proven, otherwise the largest ratio
/// to a limit.
fn mutants_keep(
    text: &str,
    seed: u64,
    most: f64,
    change: impl Fn(&mut Random) -> String,
    judged: impl Fn(&str) -> Option<Option<f64>>,
) {
    let count = asked("MUTANTS", 150);
    let (mut random, mut passed, mut broken, mut nearest) = (Random::new(seed), 0, 0, 0.0_f64);
    for k in 0..count {
        let changed = if k % 4 == 3 { mutant(&mut random, text) } else { change(&mut random) };
        match judged(&changed) {
            Some(Some(share)) => {
                assert!(share <= most, "mutant {k} uses {share} of a limit:\n{changed}");
                (passed, nearest) = (passed + 1, nearest.max(share));
            }
            Some(None) => broken += 1,
            None => {}
        }
    }
    println!("{count} mutants: {passed} pass, using at most {nearest} of a limit; {broken} are read and do not");
    // Enough changed files must be proven, and enough must be refused; otherwise the test would prove nothing.
    assert!(passed >= count / 10 && broken >= count / 20, "{passed} {broken}");
}

/// Largest ratio of a quantity to its limit during the experiments of a plan, at evenly spaced instants; `None` if the plan
/// cannot be read.
fn used_by_plan(model: &Model, plan: &ExperimentPlan, instants: usize) -> Option<f64> {
    let x = described(&model.robot);
    let mut greatest = 0.0_f64;
    for experiment in plan.trajectories("plan").ok()? {
        let reference = experiment.reference();
        let all = reference.q.first().map_or(0, Vec::len);
        for i in (0..all).step_by((all / instants).max(1)) {
            let of = |series: &[Vec<f64>]| series.iter().map(|x| x[i]).collect::<Vec<f64>>();
            let state = State { q: of(&reference.q), dq: of(&reference.dq), ddq: of(&reference.ddq) };
            greatest = greatest.max(share(model, &state, &x));
        }
    }
    Some(greatest)
}

#[test]
fn what_passes_a_check_of_a_plan_keeps_the_limits_of_the_description() {
    let model = Model::parse(LIMITED_ARM, "arm.yaml", &Default::default()).unwrap();
    let request =
        PlanRequest { experiments: 4, starts: 1, configurations: 4, effort_share: 1.0, ..PlanRequest::default() };
    let plan = rist::plan(&model, &request, &|_, _, _| ()).unwrap().plan;
    let instants = asked("INSTANTS", 400);
    let honest = used_by_plan(&model, &plan, instants).unwrap();
    assert!(honest > 0.5 && honest <= 1.0 + 1e-9, "{honest}");
    let text = plan.to_yaml().unwrap();
    // Most changes are made in the experiments.
    let head = text.find("\nexperiments:").unwrap();
    let change = |random: &mut Random| text[..=head].to_string() + &mutant(random, &text[head + 1..]);
    // A plan may reach its limits fully. So 1e-8 beyond a limit is rounding.
    mutants_keep(&text, 40, 1.0 + 1e-8, change, |changed| {
        let read = ExperimentPlan::from_yaml("plan.yaml", changed).ok()?;
        let checked = rist::check_experiments(&model, "plan.yaml".as_ref(), &read, &CheckRequest::default());
        let is_proven = checked.is_ok_and(|checked| checked.iter().all(|(_, checked)| checked.is_proven()));
        Some(is_proven.then(|| used_by_plan(&model, &read, instants).expect("what was checked can be read")))
    });
}
