//! Tests of `rist identify` on a UR5 whose log contains an effect that the fitted model lacks: coverage of intervals, friction at
//! reversals, the delay.

use identification::estimate::delay::estimate_delay;
use identification::estimate::identify::{Fit, identify};
use identification::estimate::options::Options;
use identification::estimate::selection::{friction_candidates, preparation, select_friction};
use identification::signals::preparation::states;
use linear_model::friction::terms::FrictionTerm;
use logs::{Log, LogSource};
use tests::benchmark::lack_of_fit::{LackOfFit, Truth};

/// Share of the 95 % intervals that contain the true value, for several effects that the fitted model lacks. `cargo bench -p
/// tests --bench coverage` prints the table for all effects.
#[test]
fn intervals_hold_the_truth() {
    let robot = LackOfFit::default();
    let truth = robot.truth();
    for what in [Truth::WhiteNoise, Truth::SlowNoise, Truth::Tanh, Truth::LuGre, Truth::Backlash] {
        let (mut held, mut of_white) = (0, 0);
        let draws = 3;
        for draw in 0..draws {
            let estimate = identify(&robot.robot, &robot.log(what, 100 + draw), &Options::default()).unwrap();
            for (p, truth) in estimate.parameters.iter().zip(&truth) {
                let error = (p.value.unwrap() - truth).abs();
                held += u32::from(error <= 1.96 * p.sigma.unwrap());
                of_white += u32::from(error <= 1.96 * p.white_sigma.unwrap());
            }
        }
        let all = draws as f64 * truth.len() as f64;
        let (held, of_white) = (f64::from(held) / all, f64::from(of_white) / all);
        // The expected share is 0.95. The 174 intervals of one log are correlated, so the bound is lower.
        assert!(held > 0.88, "{what:?}: {held}");
        assert!(of_white < 0.85, "{what:?}: {of_white}");
    }
}

fn smooth(log: &Log, robot: &LackOfFit) -> (Options, Fit) {
    let mut options = Options::default();
    let candidates = friction_candidates(2.0);
    let records = states(&robot.robot, log, &preparation(&options, &candidates)).unwrap();
    let found = select_friction(&robot.robot, records.as_slice(), &options, &candidates).unwrap();
    options.friction = found.candidates[found.chosen].terms.clone();
    let fit = Fit::of(&robot.robot, std::slice::from_ref(log), &options).unwrap();
    (options, fit)
}

/// The sign of Coulomb friction changes gradually over 0.005 rad/s. The program finds this width. Then the residual is only
/// noise, and viscous and Coulomb friction (FV, FS) are within 0.5 %.
#[test]
fn friction_is_told_by_a_velocity_of_its_own() {
    let robot = LackOfFit::default();
    let (log, truth) = (robot.log(Truth::Tanh, 1), robot.truth());
    let (options, fit) = smooth(&log, &robot);
    // Two friction terms can represent this: tanh with about that width, or a Stribeck term that subtracts the missing friction
    // at low speed.
    let is_narrow = |term: &FrictionTerm| matches!(term, FrictionTerm::SmoothCoulomb(speed) | FrictionTerm::Stribeck(speed) if *speed < 0.01);
    assert!(options.friction.iter().any(is_narrow), "{:?}", options.friction);
    // Noise alone gives a relative residual of 0.0022. Friction that jumps with the sign of the velocity, and is filtered after
    // that, would give 0.02.
    assert!(fit.estimate.total.unwrap() < 0.004, "{}", fit.estimate.total.unwrap());
    let base = robot.robot.truth.len();
    let columns: usize = options.friction.iter().map(|term| term.parameters().len()).sum();
    for k in 0..6 {
        // In the fitted and in the true model, viscous and Coulomb friction (FV, FS) are the first two friction columns of each
        // joint.
        for c in [0, 1] {
            let found = &fit.estimate.parameters[base + columns * k + c];
            let truth = truth[base + 3 * k + c];
            assert!((found.value.unwrap() / truth - 1.0).abs() < 5e-3, "{found:?} {truth}");
        }
    }
}

/// The delay is estimated with the default friction model on a log with friction at reversals.
#[test]
fn the_delay_is_unbiased_where_joints_stick() {
    let robot = LackOfFit::default();
    let log = robot.log(Truth::Tanh, 2);
    // The log has 500 Hz, so 2 rows are 0.004 s.
    for (rows, seconds) in [(0, 0.0), (2, 0.004), (5, 0.01), (10, 0.02), (-5, -0.01)] {
        let at = |i: usize, last: usize| i.saturating_add_signed(-rows).min(last);
        let late: Vec<Vec<f64>> =
            log.effort.iter().map(|tau| (0..tau.len()).map(|i| tau[at(i, tau.len() - 1)]).collect()).collect();
        let late = LogSource::Held(Log { effort: late, ..log.clone() });
        let found = estimate_delay(&robot.robot, &[late], &Options::default()).unwrap();
        assert!((found.seconds - seconds).abs() < 3e-4, "{found:?}, not {seconds}");
    }
}
