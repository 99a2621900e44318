//! Tests on the Panda log of Gaz et al. 2019: the torque error of each joint, compared with an independent program (baseline).

use identification::estimate::artefact::Estimate;
use identification::estimate::identify::identify;
use identification::estimate::options::Options;
use identification::estimators::weighted::Weights;
use identification::signals::signal_options::Signal;
use linear_model::regressor::Regressor;
use logs::Log;
use tests::tape_robot::TapeRobot;
use tests::{model, shared};

fn baseline(weights: Weights) -> Option<Estimate> {
    let path = shared()?.join("data/panda_gaz2019/exciting_traj_1.csv.gz");
    let arm = TapeRobot::new(model("panda.yaml"));
    let (log, columns) = Log::read(&path, arm.coordinates(), &Default::default()).unwrap();
    println!("{columns}{}", log.report);
    let signal = Signal { cutoff: Some(10.0), rate: Some(1000.0), decimate: Some(5), ..Signal::default() };
    let options = Options { model: "panda".into(), signal, weights, ..Options::default() };
    let estimate = identify(&arm, &log, &options).unwrap();
    println!("{estimate}");
    Some(estimate)
}

#[test]
fn weighted_least_squares_is_as_good_as_the_baseline() {
    let Some(estimate) = baseline(Weights::Joint) else { return };
    assert_eq!(estimate.parameters.len(), 43 + 21);
    assert!(estimate.total.unwrap() <= 1.05 * 0.0122, "{}", estimate.total.unwrap());
    for (joint, relative) in estimate.joints.iter().zip([0.060, 0.010, 0.013, 0.010, 0.076, 0.032, 0.202]) {
        assert!(joint.relative <= 1.05 * relative + 0.0005, "{joint:?} {relative}");
    }
}

#[test]
fn ordinary_least_squares_is_as_good_as_the_baseline() {
    let Some(estimate) = baseline(Weights::None) else { return };
    assert!(estimate.total.unwrap() <= 1.05 * 0.0119, "{}", estimate.total.unwrap());
}
