//! Tests of the verdict on estimates of RIST-MH from the experiments of a plan. Each experiment is predicted with the parameters
//! from the other experiments. The covariance gives the uncertainty of the torques.

use identification::estimators::drive_gains::likelihood::Gain;
use identification::spectrum::experiment::SpectralExperiment;
use identification::spectrum::identify::SpectralMethod;
use identification::spectrum::rist_mh::data::HarmonicOptions;
use rist::fit::experiments::identify_records;
use rist::fit::verdict::{Trust, Verdict, estimate_verdict};
use rist::{Estimate, Model};
use tests::benchmark::arms::r3_arm;
use tests::benchmark::defects::Defect;
use tests::benchmark::monte_carlo::{Fixture, each_draw};
use tests::benchmark::plans::golden_plan;
use tests::benchmark::robots::{r3, robot_of_tests};
use tests::benchmark::scenario::{BenchmarkArm, Scenario};

/// Random draws of each scenario; the environment variable RIST_DRAWS changes the number.
const DRAWS: usize = 1;
const SEED: u64 = 61;

fn judged(arm: &BenchmarkArm, experiments: &[SpectralExperiment]) -> (Estimate, Verdict) {
    let path = tests::workspace().join("tests/data/robots/r3g.yaml");
    let model = Model::of(robot_of_tests("r3g.yaml"), &path, false).unwrap();
    let gains: Vec<Gain> = arm.drives.gain.iter().map(|k| Gain::Known(*k)).collect();
    let options = HarmonicOptions::default();
    let estimate = identify_records(&model, experiments, SpectralMethod::Harmonic, &gains, &options).unwrap();
    let verdict = estimate_verdict(&estimate);
    (estimate, verdict)
}

/// If friction and noise are such that the model of RIST-MH contains them, the verdict is yes, and each use has an error figure.
#[test]
fn the_golden_plan_earns_a_yes() {
    let draws = std::env::var("RIST_DRAWS").ok().and_then(|x| x.parse().ok()).unwrap_or(DRAWS);
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    for scenario in Scenario::all(&arm).into_iter().skip(1) {
        let name = scenario.name;
        let fixture = Fixture::new(&arm, scenario, &golden_plan()).unwrap();
        for (estimate, verdict) in each_draw(draws, 2, |draw| judged(&arm, &fixture.measured(Some(draw), SEED))) {
            assert_eq!(verdict.trust, Trust::Yes, "{name}: {verdict}");
            assert!(verdict.uses.iter().all(|of| of.error.is_some()), "{name}: {verdict}");
            let predicted = estimate.cross_validation.unwrap();
            // The error of cross-validation exceeds the residual a little: fewer experiments are fitted, and the held-out rows
            // have noise too.
            assert!(
                predicted >= estimate.total.unwrap() && predicted < 0.05,
                "{name}: {predicted} {:?}",
                estimate.total
            );
            let text = verdict.to_string();
            assert!(text.contains("relative residual of held-out parts, each a motion of its own: "), "{text}");
            // An estimate that is written to a file and read back has the same verdict.
            let again = Estimate::from_yaml("estimate.yaml", &estimate.to_yaml().unwrap()).unwrap();
            assert_eq!(estimate_verdict(&again), verdict);
        }
    }
}

/// The verdict is not yes in two cases: the torques are late, which the model does not contain; or there is only one experiment,
/// so the bodies of a joint are not determined.
#[test]
fn what_the_model_lacks_is_no_yes() {
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    let exact = Defect::Late(0.003).experiments(&arm, &golden_plan(), None).unwrap();
    let late = judged(&arm, &tests::benchmark::defects::measured(&exact, &arm, &arm.sensing, SEED, 0)).1;
    assert_ne!(late.trust, Trust::Yes, "{late}");
    let scenario = Scenario::all(&arm).into_iter().nth(1).unwrap();
    let few = Fixture::new(&arm, scenario, &golden_plan()[..1]).unwrap();
    let (estimate, verdict) = judged(&arm, &few.measured(Some(0), SEED));
    assert_ne!(verdict.trust, Trust::Yes, "{verdict}");
    assert_eq!(estimate.cross_validation, None);
    // One experiment determines the parameters so badly that the torque error is unknown or above 50 %.
    assert!(verdict.uses.iter().all(|of| of.error.is_none_or(|error| error > 0.5)), "{verdict}");
}
