//! Times of derivations, and of one call of the derived functions: `cargo bench -p tests --bench speed`. With tables for
//! docs/benchmarks.md: `cargo xtask bench`.
//!
//! Printed are: time per derivation or sample, ns; how many times faster than the first alternative for the same work; and the
//! difference of the torques from an independent recursion, before and after the timing (for the worst joint, relative to its
//! largest torque). If a difference exceeds rounding, the bench fails. If something cannot be timed, the reason is printed.

mod harness;

use std::fmt::Write as _;
use std::hint::black_box;

use expr::{Function, Tape};
use generated::{Compiled, Eight};
use harness::{Alternative, Comparison};
use identification::estimators::weighted::{Weights, fit};
use identification::rows::observation::Observation;
use linear_model::friction::terms::FrictionTerm;
use linear_model::linear_model::Model;
use linear_model::states::States;
use modeling::{BaseParameters, Derivation};
use robot::Robot;
use tests::model;
use tests::random::{Random, State};
use tests::recursion;

/// Number of different states that are evaluated in turn. They are too many for a branch predictor to learn, and few enough to
/// fit in the cache.
const STATES: usize = 128;

fn main() {
    let mut comparison = Comparison::default();
    let tree = robot::format::read_urdf(&tree_urdf(44), "tree44.urdf").unwrap_or_else(|e| panic!("{e}"));
    let robots = [
        ("race", model("race.yaml")),
        ("ur5", model("ur5.yaml")),
        ("panda", model("panda.yaml")),
        ("tree of 44 joints", tree),
    ];
    for (name, robot) in &robots {
        derivations(&mut comparison, name, robot);
    }
    for (name, robot) in &robots {
        base_regressor_calls(&mut comparison, name, robot);
    }
    triangles(&mut comparison, "panda", &robots[2].1);
    comparison.finish();
}

/// States of a robot, and the torques at these states by an independent recursion (Newton-Euler).
struct Truth {
    /// Arbitrary values of the standard parameters.
    x: Vec<f64>,
    /// q, dq, ddq of each state, one state after the other.
    states: Vec<f64>,
    /// Torques of each state, N m (N), one state after the other.
    torques: Vec<f64>,
    n: usize,
}

impl Truth {
    fn new(robot: &Robot) -> Truth {
        let mut random = Random(1);
        let x = random.parameters(robot);
        let states: Vec<State> = (0..STATES).map(|_| random.state(robot)).collect();
        let torques = states.iter().flat_map(|state| recursion::torque(robot, state, &x)).collect();
        Truth { x, states: states.iter().flat_map(State::inputs).collect(), torques, n: robot.n_coordinates() }
    }

    /// The largest difference of a joint's torque from the true torque, divided by the largest torque of this joint. Infinite if
    /// a torque is NaN.
    fn difference(&self, torques: &[f64]) -> f64 {
        assert_eq!(torques.len(), self.torques.len());
        let of_joint = |j: usize| {
            let pairs = || torques.iter().zip(&self.torques).skip(j).step_by(self.n);
            let scale = pairs().map(|(_, truth)| truth.abs()).fold(f64::MIN_POSITIVE, f64::max);
            // NaN is converted to infinity, because `max` would ignore it.
            let apart = |(found, truth): (&f64, &f64)| Some((found - truth).abs() / scale).filter(|x| !x.is_nan());
            pairs().map(|pair| apart(pair).unwrap_or(f64::INFINITY)).fold(0.0, f64::max)
        };
        (0..self.n).map(of_joint).fold(0.0, f64::max)
    }

    /// The difference of the torques Y x from the true torques, for dense matrices Y, row by row, one state after the other. `x`:
    /// the parameters.
    fn difference_of(&self, matrices: &[f64], x: &[f64]) -> f64 {
        let torques: Vec<f64> = matrices.chunks_exact(x.len()).map(|row| tests::dot(row, x).0).collect();
        self.difference(&torques)
    }

    /// The difference of the torques Y(q, dq, ddq) x from the true torques, for a regressor Y given as a function.
    fn difference_of_function(&self, function: &Function, x: &[f64]) -> f64 {
        let tape = Tape::new(function);
        let mut matrices = vec![0.0; tape.n_outputs() * STATES];
        tape.evaluate_many(&self.states, &mut tape.workspace(), &mut matrices);
        self.difference_of(&matrices, x)
    }
}

fn derivations(comparison: &mut Comparison, name: &str, robot: &Robot) {
    let truth = Truth::new(robot);
    let regressor = || Derivation::new(robot).unwrap_or_else(|e| panic!("{e}")).regressor();
    let both = || base_regressor(robot);
    let alternatives = vec![
        Alternative::new("regressor", 1, regressor)
            .held(|| truth.difference_of_function(&regressor().bound(), &truth.x)),
        Alternative::new("and base parameters, rules", 1, both).held(|| {
            let (function, base) = both();
            truth.difference_of_function(&function, &base.values(&truth.x))
        }),
    ];
    comparison.of(&format!("derivation, {name}"), alternatives);
}

/// Times the base regressor of `robot` at [`STATES`] states, with all ways to evaluate it (tape, compiled code).
fn base_regressor_calls(comparison: &mut Comparison, name: &str, robot: &Robot) {
    let truth = Truth::new(robot);
    let (function, base) = base_regressor(robot);
    let x = base.values(&truth.x);
    let tape = Tape::new(&function);
    let size = tape.n_outputs();
    let (mut one, mut work) = (vec![0.0; size], tape.workspace());
    let (mut many, mut work_many) = (vec![0.0; size * STATES], tape.workspace());
    let mut alternatives = match generated::find(function.fingerprint()) {
        Some(compiled) => compiled_calls(compiled, &truth, &x),
        None => vec![Alternative::not_timed("compiled", "this robot is not compiled in")],
    };
    let each = |take: &mut dyn FnMut(&[f64])| truth.states.chunks_exact(3 * truth.n).for_each(take);
    alternatives.push(
        Alternative::new("Tape, one call", STATES, || each(&mut |s| tape.evaluate(s, &mut work, &mut one))).held(
            || {
                let (mut all, mut one, mut work) = (Vec::new(), vec![0.0; size], tape.workspace());
                each(&mut |s| {
                    tape.evaluate(s, &mut work, &mut one);
                    all.extend_from_slice(&one);
                });
                truth.difference_of(&all, &x)
            },
        ),
    );
    alternatives.push(
        Alternative::new("Tape, many", STATES, || tape.evaluate_many(&truth.states, &mut work_many, &mut many))
            .held(|| truth.difference_of_function(&function, &x)),
    );
    comparison.of(&format!("base regressor, {name}"), alternatives);
}

/// The ways to evaluate the compiled base regressor of a robot. `x`: its base parameters.
fn compiled_calls<'a>(compiled: &'static Compiled, truth: &'a Truth, x: &'a [f64]) -> Vec<Alternative<'a>> {
    let n = truth.n;
    let size = n * x.len();
    let split = move |s: &'a [f64]| (&s[..n], &s[n..2 * n], &s[2 * n..]);
    let each = move || truth.states.chunks_exact(3 * n).map(split);
    let eights = move || truth.states.chunks_exact(8 * 3 * n);
    let entries = compiled.non_zeros.len();
    let (mut one, mut many) = (vec![0.0; size], vec![0.0; size * STATES]);
    let (mut some, mut eight) = (vec![0.0; entries], vec![Eight::default(); entries]);
    let calls = Alternative::new("compiled, one call", STATES, move || {
        each().all(|(q, dq, ddq)| compiled.fill(q, dq, ddq, &mut one))
    });
    let entries_one = Alternative::new("entries, one call", STATES, move || {
        each().all(|(q, dq, ddq)| compiled.fill_non_zeros(q, dq, ddq, &mut some))
    });
    let lanes = Alternative::new("compiled, many", STATES, move || compiled.fill_many(&truth.states, &mut many));
    let entries_eight = Alternative::new("entries, eight in lanes", STATES, move || {
        eights().all(|states| compiled.fill_eight(states, &mut eight))
    });
    // The checked result is from the same call that is timed, for all states.
    let dense = move |fill: &dyn Fn(&mut [f64]) -> bool| {
        let mut all = vec![0.0; size * STATES];
        if fill(&mut all) { truth.difference_of(&all, x) } else { f64::INFINITY }
    };
    let sparse = move |entry: &dyn Fn(usize, usize) -> f64| {
        let mut torques = vec![0.0; n * STATES];
        for s in 0..STATES {
            for (k, (i, c)) in compiled.non_zeros.iter().enumerate() {
                torques[s * n + i] += entry(s, k) * x[*c];
            }
        }
        truth.difference(&torques)
    };
    vec![
        calls.held(move || {
            dense(&|all| each().zip(all.chunks_exact_mut(size)).all(|((q, dq, ddq), y)| compiled.fill(q, dq, ddq, y)))
        }),
        entries_one.held(move || {
            let mut all = vec![0.0; entries * STATES];
            let filled = each()
                .zip(all.chunks_exact_mut(entries))
                .all(|((q, dq, ddq), some)| compiled.fill_non_zeros(q, dq, ddq, some));
            if filled { sparse(&|s, k| all[s * entries + k]) } else { f64::INFINITY }
        }),
        lanes.held(move || dense(&|all| compiled.fill_many(&truth.states, all))),
        entries_eight.held(move || {
            let mut all = vec![Eight::default(); entries * STATES / 8];
            let filled =
                eights().zip(all.chunks_exact_mut(entries)).all(|(states, eight)| compiled.fill_eight(states, eight));
            if filled { sparse(&|s, k| all[s / 8 * entries + k].0[s % 8]) } else { f64::INFINITY }
        }),
    ]
}

/// Times the conversion of samples to rows of dynamics and friction, and then to one triangle (the R of a QR decomposition) per
/// joint.
fn triangles(comparison: &mut Comparison, name: &str, robot: &Robot) {
    const SAMPLES: usize = 4096;
    let truth = Truth::new(robot);
    let whole = rist::Model::of(robot.clone(), std::path::Path::new(name), false).unwrap_or_else(|e| panic!("{e}"));
    let friction = [FrictionTerm::Viscous, FrictionTerm::Coulomb, FrictionTerm::Offset];
    let model = Model::new(whole.regressor(), &friction, &[]);
    let n = truth.n;
    let mut states = States { n, used: vec![true; n * SAMPLES], ..States::default() };
    let at_states = truth.states.chunks_exact(3 * n).zip(truth.torques.chunks_exact(n));
    for (r, (state, tau)) in at_states.cycle().take(SAMPLES).enumerate() {
        states.t.push(1e-3 * r as f64);
        states.q.extend(&state[..n]);
        states.dq.extend(&state[n..2 * n]);
        states.ddq.extend(&state[2 * n..]);
        states.direction.extend(state[n..2 * n].iter().map(|dq| dq.signum()));
        states.tau.extend(tau);
    }
    // The largest difference between the torques W x and the true torques of a joint, divided by its largest torque.
    let left = |x: &[f64]| {
        let mut torques = truth.torques.clone();
        model.residuals(&states, x, |r, j, residual| {
            if let Some(torque) = torques.get_mut(r * n + j) {
                *torque -= residual;
            }
        });
        truth.difference(&torques)
    };
    let known: Vec<f64> =
        base_regressor(robot).1.values(&truth.x).into_iter().chain(std::iter::repeat(0.0)).take(model.p()).collect();
    let rows = || {
        model.blocks(&states, 0..SAMPLES, |_, block| {
            black_box(block);
        })
    };
    let observed = || Observation::of(&model, &states, 1);
    let alternatives = vec![
        Alternative::new("rows alone, in blocks", SAMPLES, rows).held(|| left(&known)),
        Alternative::new("and the triangle of each joint", SAMPLES, observed)
            .held(|| left(&fit(&observed().joints(|_| true), Weights::None).0.x)),
    ];
    comparison.of(&format!("states to triangles, {name}, {} columns", model.p()), alternatives);
}

fn base_regressor(robot: &Robot) -> (Function, BaseParameters) {
    let (_, standard, base) = tests::derived(robot);
    (base.regressor(&standard).bound(), base)
}

/// The URDF of a tree of `n` revolute joints with oblique axes: four limbs on a base, similar to a humanoid.
fn tree_urdf(n: usize) -> String {
    let mut random = Random(44);
    let mut urdf = String::from("<robot name=\"tree44\"><link name=\"base\"/>");
    for j in 0..n {
        let parent = if j < 4 { "base".to_string() } else { format!("link{}", j - 4) };
        let mut three =
            |scale: f64| format!("{} {} {}", scale * random.unit(), scale * random.unit(), scale * random.unit());
        let (xyz, rpy, axis, centre) = (three(0.3), three(1.5), three(1.0), three(0.1));
        let inertia = "ixx=\"0.02\" iyy=\"0.03\" izz=\"0.025\" ixy=\"0.001\" ixz=\"0.002\" iyz=\"-0.001\"";
        write!(
            urdf,
            "<link name=\"link{j}\"><inertial><origin xyz=\"{centre}\"/><mass value=\"1.5\"/><inertia {inertia}/></inertial></link>
             <joint name=\"joint{j}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"link{j}\"/>
             <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"{axis}\"/></joint>"
        )
        .unwrap();
    }
    urdf + "</robot>"
}
