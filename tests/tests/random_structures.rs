//! Robots drawn at random, with loops, ratios and equal lengths: their rank is that of an independent regressor.

use expr::Tape;
use modeling::Derivation;
use nalgebra::DMatrix;
use tests::random::Random;
use tests::random_structures::{rank, structure};

/// Relative to the largest entry of a regressor: the passive joints are closed to 1e-13, and some thousand operations follow.
const AGREES: f64 = 1e-9;

/// What is wrong with the robot of this number; `None` where it is right.
fn wrong(seed: u64) -> Option<String> {
    let drawn = structure(seed);
    let robot = match drawn.robot() {
        Ok(robot) => robot,
        Err(e) => return Some(e),
    };
    let mut derivation = match Derivation::new(&robot) {
        Ok(derivation) => derivation,
        Err(e) => return Some(e.to_string()),
    };
    let regressor = derivation.regressor();
    let (n, p) = (robot.n_coordinates(), regressor.outputs[0].columns);
    let states = drawn.states(2 * p / n + 8, &mut Random(seed + 1_000_000));
    let tape = Tape::new(&regressor);
    for state in &states {
        let mut y = vec![0.0; n * p];
        tape.evaluate(&state.inputs(&robot), &mut tape.workspace(), &mut y);
        let y = DMatrix::from_row_slice(n, p, &y);
        let (apart, largest) = ((&y - &state.regressor).amax(), state.regressor.amax());
        if !(apart <= AGREES * (1.0 + largest)) {
            return Some(format!("the regressor differs by {apart:e} of {largest:e}"));
        }
    }
    let base = match derivation.base_parameters(&regressor) {
        Ok(base) => base,
        Err(e) => return Some(e.to_string()),
    };
    let (found, gap) = rank(&states);
    if base.len() != found {
        return Some(format!("{} base parameters, the independent rank is {found} (gap {gap:.0e})", base.len()));
    }
    // The kept columns are independent, and nothing is lost: D_base X_base = D X.
    let x = Random(seed + 2_000_000).vector(p, 1.0);
    let x_base = base.values(&x);
    for state in &states {
        let kept = DMatrix::from_fn(n, base.len(), |i, k| state.regressor[(i, base.base[k].column)]);
        let tau = &state.regressor * DMatrix::from_column_slice(p, 1, &x);
        let tau_base = kept * DMatrix::from_column_slice(x_base.len(), 1, &x_base);
        let apart = (&tau - tau_base).amax();
        // Numeric coefficients carry the rounding of the scan.
        if !(apart <= AGREES * 10.0 * (1.0 + state.regressor.amax())) {
            return Some(format!("D_base X_base is off by {apart:e} of {:e}", tau.amax()));
        }
    }
    None
}

#[test]
fn two_hundred_robots_have_their_independent_rank() {
    let failed: Vec<String> = (0..200)
        .filter_map(|seed| wrong(seed).map(|why| format!("{seed} {:?}: {why}", structure(seed).kinds)))
        .collect();
    assert!(failed.is_empty(), "{} of 200:\n{}", failed.len(), failed.join("\n"));
    let all: Vec<&str> = (0..200).flat_map(|seed| structure(seed).kinds).collect();
    for kind in ["four-bar", "parallelogram", "crossed", "slider", "ratio", "two coordinates"] {
        assert!(all.iter().filter(|k| **k == kind).count() >= 15, "too few of {kind}");
    }
}

#[test]
fn debug_one() {
    let Ok(seed) = std::env::var("SEED") else { return };
    let d = structure(seed.parse().unwrap());
    println!("{}", d.text);
    let robot = d.robot().unwrap();
    for n in &robot.notes {
        println!("{n:?}");
    }
    println!("{:?}", wrong(seed.parse().unwrap()));
    let p = tests::standard_names(&robot).len();
    println!(
        "{:?}",
        rank(&d.states(2 * p / robot.n_coordinates() + 8, &mut Random(seed.parse::<u64>().unwrap() + 1_000_000)))
    );
    std::fs::write("/tmp/m/one.yaml", &d.text).unwrap();
}
