//! Counts the instructions of one call of a compiled base regressor: `cargo xtask bench instructions`.
//!
//! It needs valgrind and gungraun-runner (`cargo install gungraun-runner`). The number of instructions does not depend on other
//! programs. Callgrind supports AVX2 with FMA, but not AVX-512.
//!
//! Compiled code of a robot is in the crate `generated`; it evaluates one state, or eight states at once.

#![allow(unused_qualifications, reason = "gungraun's macros name what they import")]

use generated::{Compiled, Eight};
use gungraun::{library_benchmark, library_benchmark_group, main};
use tests::random::Random;

struct Robot {
    compiled: &'static Compiled,
    states: Vec<f64>,
    entries: Vec<f64>,
    eights: Vec<Eight>,
}

fn robot(name: &str) -> Robot {
    let compiled = generated::all().iter().find(|robot| robot.name == name).expect("the models are compiled in");
    let (n, entries) = (compiled.coordinates.len(), compiled.non_zeros.len());
    let states = Random(1).vector(8 * 3 * n, 2.0);
    let mut robot = Robot { compiled, states, entries: vec![0.0; entries], eights: vec![Eight::default(); entries] };
    // The first call queries the features of the processor, so it is not counted.
    assert!(robot.compiled.fill_eight(&robot.states, &mut robot.eights));
    robot
}

#[library_benchmark]
#[bench::race(robot("race"))]
#[bench::ur5(robot("ur5"))]
#[bench::panda(robot("panda"))]
fn one_call(mut robot: Robot) -> Robot {
    let n = robot.compiled.coordinates.len();
    let (q, dq, ddq) = (&robot.states[..n], &robot.states[n..2 * n], &robot.states[2 * n..3 * n]);
    assert!(robot.compiled.fill_non_zeros(q, dq, ddq, &mut robot.entries));
    robot
}

#[library_benchmark]
#[bench::race(robot("race"))]
#[bench::ur5(robot("ur5"))]
#[bench::panda(robot("panda"))]
fn eight_in_lanes(mut robot: Robot) -> Robot {
    assert!(robot.compiled.fill_eight(&robot.states, &mut robot.eights));
    robot
}

library_benchmark_group!(name = base_regressor; benchmarks = one_call, eight_in_lanes);
main!(library_benchmark_groups = base_regressor);
