//! Tests that the standard deviations that `rist excite` predicts agree with the errors of estimates from simulated logs.

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::visibility::JointNoise;
use rist::Model;
use rist::motion::simulation::SimulateRequest;
use rist::request::{ExciteRequest, FrictionChoice};
use tests::model_path;
use tests::promise::{FRICTION, Kept, kept, promised};

/// A short motion that identifies all parameters of the UR5.
fn motion(model: &Model, rate: f64) -> ExcitingMotion {
    let request = ExciteRequest {
        starts: 1,
        iterations: 15,
        period: Some(6.0),
        repetitions: 1,
        rate,
        friction: Some(FrictionChoice::Terms(FRICTION.to_vec())),
        ..Default::default()
    };
    rist::excite(model, &request, &|_, _, _| ()).unwrap()
}

/// The simulated motion does not depend on the sampling rate of the log: a log at 200 Hz equals every fifth row of a log at 1
/// kHz.
#[test]
fn the_rate_of_a_log_does_not_change_the_motion() {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let coarse = motion(&model, 200.0);
    let fine = ExcitingMotion { rate_hz: 1000.0, ..coarse.clone() };
    let simulated = |motion: &ExcitingMotion| {
        let request = SimulateRequest { validation: 0, noise_free: true, ..Default::default() };
        let mut found = None;
        rist::simulate(&model, motion, &request, &mut |_, record| {
            found = Some(record.clone());
            Ok(())
        })
        .unwrap();
        found.unwrap()
    };
    let (coarse, fine) = (simulated(&coarse), simulated(&fine));
    for (k, (slow, fast)) in coarse.q.iter().zip(&fine.q).enumerate() {
        let worst = slow.iter().zip(fast.iter().step_by(5)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // At some instants, rounding of the reference changes an encoder value by one quantum of 1e-4 rad. This changes the
        // control loop slightly.
        assert!(worst < 1e-4, "joint {k}: {worst}");
    }
}

#[test]
fn errors_are_as_large_as_promised() {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let kept = kept(&model, &motion(&model, 200.0), 4, 1.0).unwrap();
    assert_eq!(kept.len(), model.regressor().parameters().len());
    let mean = |of: &dyn Fn(&Kept) -> f64| kept.iter().map(of).sum::<f64>() / kept.len() as f64;
    let (rms, held) = (mean(&|k| k.ratio.powi(2)).sqrt(), mean(&|k| k.held));
    eprintln!("error over promise {rms:.3}, 95 % intervals hold {held:.3}");
    // There are 160 errors of 40 correlated parameters. The rms of the errors, in standard deviations, has itself a standard
    // deviation of about 10 %.
    assert!((0.7..1.3).contains(&rms), "{rms}");
    assert!(held > 0.85, "{held}");
}

/// The predicted standard deviations equal the standard deviations of weighted least squares. The weights of the joints include
/// the encoder noise.
#[test]
fn promised_deviations_are_those_of_weighted_least_squares() {
    let model = Model::read(model_path("ur5.urdf")).unwrap();
    let motion = motion(&model, 200.0);
    let deviations: Vec<f64> = motion.parameters.iter().map(|p| p.deviation.unwrap()).collect();
    let noise = JointNoise { torque: motion.torque_noise.clone(), encoders: motion.encoder_noise.clone() };
    let all: Vec<usize> = (0..deviations.len()).collect();
    let found = promised(&model, &motion, &noise, &FRICTION, &all);
    for (one, square) in deviations.iter().zip(&found) {
        // The tolerance is the rounding error 1e-16 times the fourth power of a condition number of some hundred: the normal
        // equations square it twice.
        assert!((one / square.sqrt() - 1.0).abs() < 1e-7, "{one} {square}");
    }
    // The encoder noise must have an effect in this test: 1e-4 rad at 14 Hz corresponds to 0.4 rad/s^2.
    assert!(motion.encoder_noise.iter().zip(&motion.torque_noise).any(|(e, s)| *e > 0.1 * s), "{motion:?}");
}
