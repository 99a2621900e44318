//! Tests that the bodies in a URDF that `rist` writes are closer to the true bodies than the nominal bodies that they replace.

use rist::Model;
use rist::fit::samples::Identification;
use rist::fit::verdict::{Trust, Verdict};
use rist::request::IdentifyRequest;
use tests::joint_log::{JointLog, described, swinging, swinging_by, unlike};
use tests::model_path;
use tests::program::folder;
use tests::random::Random;

/// Error of the rigid-body torque with base parameters `x`, relative to the true torque, over 1000 random states.
fn error(model: &Model, x: &[f64], truth: &[f64]) -> f64 {
    let regressor = model.regressor();
    let (n, p) = (regressor.coordinates().len(), x.len());
    let mut random = Random(9);
    let (mut left, mut whole) = (0.0, 0.0);
    let mut y = vec![0.0; n * p];
    for _ in 0..1000 {
        let mut state = |scale: f64| (0..n).map(|_| scale * random.unit()).collect::<Vec<f64>>();
        let (q, dq, ddq) = (state(3.0), state(2.0), state(5.0));
        regressor.fill(&q, &dq, &ddq, &mut y);
        for row in y.chunks(p) {
            let of = |x: &[f64]| row.iter().zip(x).map(|(y, x)| y * x).sum::<f64>();
            left += (of(x) - of(truth)).powi(2);
            whole += of(truth).powi(2);
        }
    }
    (left / whole).sqrt()
}

/// The physically consistent estimate of a log, its verdict and its base parameters.
fn consistent(model: &Model, log: &JointLog, file: &str) -> (Identification, Verdict, Vec<f64>) {
    let source = log.opened(model, &folder("written").join(file));
    let request = IdentifyRequest { consistent: true, ..Default::default() };
    let mut found = rist::identify(model, &[source], &request).unwrap();
    let verdict = found.verdict_of_logs(model, &[], false).unwrap().verdict;
    let base = &found.estimate.parameters[..model.parameters.len()];
    let written = base.iter().map(|p| p.prediction()).collect();
    (found, verdict, written)
}

/// If the nominal bodies are wrong by up to 15 %, the written bodies have a smaller torque error in every draw. If the nominal
/// bodies are exact, the error of the written bodies is within the printed uncertainty.
#[test]
fn a_written_description_is_nearer_the_truth() {
    for (file, amplitude) in [("ur5.urdf", 1.2), ("puma560.yaml", 1.0), ("kuka_lwr.yaml", 0.8), ("ur5.urdf", 0.3)] {
        let model = Model::read(model_path(file)).unwrap();
        let of_description = model.nominal_parameters().unwrap();
        for seed in 0..6 {
            let is_exact = seed == 0;
            let truth = if is_exact { described(&model.robot) } else { unlike(&model.robot, seed) };
            let log = swinging(&model.robot, &truth, amplitude, 0.0);
            let base = model.parameters.values(&truth);
            let (found, verdict, written) = consistent(&model, &log, &format!("{seed}{file}.csv"));
            let (now, before) = (error(&model, &written, &base), error(&model, &of_description, &base));
            if is_exact {
                let printed = found.estimate.torque_errors.iter().map(|e| e.relative).fold(0.0, f64::max);
                // The limit is three standard deviations, because this is one draw of many parameters.
                assert!(now < 3.0 * printed, "{file}: off by {now}, {printed} are printed");
                assert_eq!(
                    verdict.of_bodies().0,
                    Trust::No,
                    "nothing is gained where the description is exact: {verdict}"
                );
            } else {
                assert!(now < before, "{file}, draw {seed}: {now} where the description has {before}");
            }
        }
    }
}

/// The weight of a vertical slide and a torque offset of its drive give the same constant force, so no motion can separate them.
/// The force is assigned to the bodies, and the verdict says so. The torque error at rest is small.
#[test]
fn the_weight_of_a_slide_is_in_its_bodies() {
    let model = Model::read(model_path("scara.yaml")).unwrap();
    let before = model.nominal_parameters().unwrap();
    let slide = model.coordinate("q4").unwrap();
    let at_rest = |x: &[f64]| {
        let mut y = vec![0.0; 4 * x.len()];
        model.regressor().fill(&[0.3; 4], &[0.0; 4], &[0.0; 4], &mut y);
        y[slide * x.len()..][..x.len()].iter().zip(x).map(|(y, x)| y * x).sum::<f64>()
    };
    for seed in 1..4 {
        let truth = unlike(&model.robot, seed);
        let weight = at_rest(&model.parameters.values(&truth));
        let log = swinging_by(&model.robot, &truth, &[1.0, 1.2, 1.5, 0.1], 0.0);
        let (_, verdict, written) = consistent(&model, &log, &format!("{seed}_scara.csv"));
        // The force at rest is a mean over five thousand samples with white noise of 0.1 N, so its error from the noise is some
        // mN.
        assert!((at_rest(&written) - weight).abs() < 0.05, "draw {seed}: {} N, {weight} N", at_rest(&written));
        assert!((at_rest(&before) - weight).abs() > 0.05, "draw {seed} shows nothing");
        let bodies = verdict.uses.last().unwrap();
        assert_ne!(bodies.trust, Trust::Yes, "{verdict}");
        assert!(verdict.to_string().contains("bodies of q4: assumed by default"), "{verdict}");
    }
}
