//! Tests that `rist identify` uses physically consistent bodies only if the log is poor and they predict another log better.

use logs::LogSource;
use rist::Model;
use rist::request::IdentifyRequest;
use tests::faults::cut;
use tests::joint_log::{Machine, unlike};
use tests::model_path;
use tests::program::folder;

const SENTENCE: &str = "the log is poor, and the bodies are constrained to be physically possible";

/// A log of five seconds: the joints of a UR5 swing with `amplitude`, rad; the torques have `noise`, N m.
fn log(model: &Model, amplitude: [f64; 6], noise: f64, name: &str) -> LogSource {
    let parameters = unlike(&model.robot, 5);
    let exact = Machine::exact(&model.robot, &parameters, &amplitude);
    let machine = Machine { viscous: &[2.0; 6], coulomb: &[1.0; 6], noise, speed: 1e-3, ..exact };
    cut(&machine.log(), 5.0).opened(model, &folder("possible_bodies").join(name))
}

/// The error on another log with a larger motion; and whether the remarks say that the bodies were constrained to be physically
/// consistent.
fn error(model: &Model, log: &LogSource, request: &IdentifyRequest, other: &LogSource) -> (f64, bool) {
    let mut found = rist::identify(model, std::slice::from_ref(log), request).unwrap();
    let judged = found.verdict_of_logs(model, std::slice::from_ref(other), false).unwrap();
    assert!(request.consistent || found.bodies.is_none(), "nobody asked for bodies");
    let is_said = found.estimate.remarks.iter().any(|remark| remark.starts_with(SENTENCE));
    assert_eq!(is_said, judged.verdict.claims.iter().any(|claim| claim.to_string().contains(SENTENCE)));
    (judged.predictions[0].1.total, is_said)
}

#[test]
fn a_poor_log_is_predicted_better_and_a_rich_one_is_left_alone() {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let other = log(&model, [1.0; 6], 0.1, "other.csv");
    let free = IdentifyRequest { free_bodies: true, ..Default::default() };
    let poor = log(&model, [0.12, 0.1, 0.1, 0.08, 0.08, 0.06], 2.0, "poor.csv");
    let [(taken, is_taken), (plain, is_free)] =
        [&IdentifyRequest::default(), &free].map(|request| error(&model, &poor, request, &other));
    println!("poor: {taken} {plain}");
    assert!(is_taken && !is_free && taken < 0.8 * plain, "{taken} {plain}");
    let rich = log(&model, [1.2; 6], 0.1, "rich.csv");
    let [of_rich, free_rich] =
        [&IdentifyRequest::default(), &free].map(|request| error(&model, &rich, request, &other));
    println!("rich: {of_rich:?}");
    assert!(!of_rich.1 && of_rich == free_rich, "{of_rich:?} {free_rich:?}");
    let both = IdentifyRequest { free_bodies: true, consistent: true, ..Default::default() };
    let Err(refused) = rist::identify(&model, &[rich], &both) else { panic!("both were taken") };
    assert!(refused.to_string().contains("exclude one another"), "{refused}");
}
