//! How long a derivation takes, and one call of what it gives: `cargo bench -p tests --bench speed`.
//!
//! Prints ns a derivation or a sample, and how many times faster than the line's first alternative.

mod harness;

use std::fmt::Write as _;
use std::path::PathBuf;

use expr::{Function, Tape};
use generated::Eight;
use harness::{alternative, compare};
use modeling::Derivation;
use robot::Robot;

/// States cycled through: more than a branch predictor remembers, less than a cache holds.
const STATES: usize = 128;

fn main() {
    println!("| what | how | ns | times the first |\n|---|---|---|---|");
    let models = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../models");
    let read = |name: &str| robot::format::read(&models.join(name)).unwrap_or_else(|e| panic!("{e}"));
    let [race, ur5, panda] = ["race.yaml", "ur5.yaml", "panda.yaml"].map(read);
    let tree = robot::format::read_urdf(&tree_urdf(44), "tree44.urdf").unwrap_or_else(|e| panic!("{e}"));

    for (name, robot) in [("race", &race), ("ur5", &ur5), ("panda", &panda), ("tree of 44 joints", &tree)] {
        let regressor = || Derivation::new(robot).unwrap_or_else(|e| panic!("{e}")).regressor();
        let both = || base_regressor(robot);
        let work = vec![alternative("regressor", 1, regressor), alternative("and base parameters, rules", 1, both)];
        compare(&format!("derivation, {name}"), work);
    }
    for (name, robot) in [("race", &race), ("ur5", &ur5), ("panda", &panda)] {
        base_regressor_calls(name, robot);
    }
}

/// The base regressor of `robot` at [`STATES`] states, by every evaluator there is.
fn base_regressor_calls(name: &str, robot: &Robot) {
    let function = base_regressor(robot);
    let tape = Tape::new(&function);
    let compiled = generated::find(function.fingerprint()).expect("the models are compiled in");
    let n = robot.n_coordinates();
    let mut random = random(1);
    let states: Vec<f64> = (0..STATES * 3 * n).map(|i| [3.1, 2.0, 5.0][i / n % 3] * random()).collect();
    let size = tape.n_outputs();
    let (mut one, mut two, mut many) = (vec![0.0; size], vec![0.0; size], vec![0.0; size * STATES]);
    let mut lanes_many = vec![0.0; size * STATES];
    let (mut work, mut work_many) = (tape.workspace(), tape.workspace());
    let scalar = alternative("compiled, one call", STATES, || {
        states.chunks_exact(3 * n).all(|s| compiled.fill(&s[..n], &s[n..2 * n], &s[2 * n..], &mut one))
    });
    let lanes = alternative("compiled, many", STATES, || compiled.fill_many(&states, &mut lanes_many));
    let (mut entries, mut eight) =
        (vec![0.0; compiled.non_zeros.len()], vec![Eight::default(); compiled.non_zeros.len()]);
    let entries_one = alternative("entries, one call", STATES, || {
        states.chunks_exact(3 * n).all(|s| compiled.fill_non_zeros(&s[..n], &s[n..2 * n], &s[2 * n..], &mut entries))
    });
    let entries_eight = alternative("entries, eight abreast", STATES, || {
        states.chunks_exact(24 * n).all(|s| compiled.fill_eight(s, &mut eight))
    });
    let tape_one = alternative("Tape, one call", STATES, || {
        states.chunks_exact(3 * n).for_each(|s| tape.evaluate(s, &mut work, &mut two));
    });
    let tape_many = alternative("Tape, many", STATES, || tape.evaluate_many(&states, &mut work_many, &mut many));
    compare(&format!("base regressor, {name}"), vec![scalar, entries_one, lanes, entries_eight, tape_one, tape_many]);
}

fn base_regressor(robot: &Robot) -> Function {
    let mut derivation = Derivation::new(robot).unwrap_or_else(|e| panic!("{e}"));
    let standard = derivation.regressor();
    let base = derivation.base_parameters(&standard).unwrap_or_else(|e| panic!("{e}"));
    base.regressor(&standard).bound()
}

/// Uniform in [-1, 1).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A tree of `n` revolute joints about oblique axes: four limbs on a base, the shape of a humanoid.
fn tree_urdf(n: usize) -> String {
    let mut random = random(44);
    let mut urdf = String::from("<robot name=\"tree44\"><link name=\"base\"/>");
    for j in 0..n {
        let parent = if j < 4 { "base".to_string() } else { format!("link{}", j - 4) };
        let mut three = |scale: f64| format!("{} {} {}", scale * random(), scale * random(), scale * random());
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
