//! Tests of the causes that RIST-MH (the method in the frequency domain) reports if its model does not explain the data: late
//! torques, ripple of a drive, springs, eccentric encoders, flexible joints and joints with play. It must not report friction and
//! noise, because its model contains them.
//!
//! The thresholds were chosen on other random draws (`tests/benches/misfit.rs`, seed 1000).

use identification::estimators::drive_gains::likelihood::Gain;
use identification::spectrum::experiment::{NoiseLevels, SpectralExperiment};
use identification::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use identification::spectrum::rist_mh::effects::Effect;
use identification::spectrum::rist_mh::search::HarmonicEstimate;
use identification::spectrum::words::cause_sentence;
use tests::benchmark::arms::r3_arm;
use tests::benchmark::defects::{Defect, measured};
use tests::benchmark::monte_carlo::{Fixture, each_draw};
use tests::benchmark::plans::golden_plan;
use tests::benchmark::robots::r3;
use tests::benchmark::scenario::{BenchmarkArm, Scenario};

/// Random draws of each defect. docs/benchmarks.md has the results of ten draws, which take minutes.
const DRAWS: usize = 1;
/// Number of random draws for tests of drive gains. The shares that these tests check are means over parameters and draws.
const DRAWS_OF_GAINS: usize = 3;
/// Random draws of each scenario without a defect.
const SOUND: usize = 4;
const SEED: u64 = 5;

fn estimate(arm: &BenchmarkArm, experiments: &[SpectralExperiment], effects: &[Effect]) -> HarmonicEstimate {
    let noise = NoiseLevels::measured(experiments).unwrap();
    let options = HarmonicOptions::default().with_effects(effects.to_vec());
    let gain = &arm.drives.gain;
    HarmonicData::new(experiments, arm.regressor, gain, &noise, &options.band).estimate(&options).unwrap()
}

/// Relative error of the parameters, |X^ - X| / |X|, %.
fn error(found: &HarmonicEstimate, truth: &[f64]) -> f64 {
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let errors: Vec<f64> = found.values().iter().zip(truth).map(|(x, t)| x - t).collect();
    100.0 * norm(&errors) / norm(truth)
}

fn mean(x: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = x.len() as f64;
    x.sum::<f64>() / count
}

#[test]
fn what_the_model_has_is_no_misfit() {
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    for scenario in Scenario::all(&arm) {
        let (name, sensing) = (scenario.name, scenario.sensing.clone());
        let fixture = Fixture::new(&arm, scenario, &golden_plan()).unwrap();
        let exact = fixture.measured(None, 0);
        for found in each_draw(SOUND, 2, |draw| estimate(&arm, &measured(&exact, &arm, &sensing, SEED, draw), &[])) {
            assert!(!found.misfit.is_lacking() && found.cause.is_none(), "{name}: {:?}", found.misfit.joints);
        }
    }
}

/// Checks three things on experiments with `defect`. The kind of the defect is named. The intervals of the fit without columns
/// for the defect contain the true values. The fit with these columns (`kind`) has the right parameters.
fn looked_at(defect: Defect, kind: &(dyn Fn(usize) -> Effect + Sync)) {
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    let exact = defect.experiments(&arm, &golden_plan(), None).unwrap();
    let found = each_draw(DRAWS, 2, |draw| {
        let experiments = measured(&exact, &arm, &arm.sensing, SEED, draw);
        let without = estimate(&arm, &experiments, &[]);
        assert!(without.misfit.is_beyond_noise(), "{defect:?}: {:?}", without.misfit.joints);
        let is_kind = |e: &Effect| std::mem::discriminant(e) == std::mem::discriminant(&kind(0));
        let named = without.cause.as_ref().is_some_and(|cause| cause.effects.iter().all(|e| is_kind(&e.effect)));
        let sentence = without.cause.as_ref().map(|cause| cause_sentence(cause, arm.regressor));
        let white = without.deviations();
        let is_held = |&i: &usize| (without.values()[i] - arm.truth[i]).abs() <= 1.96 * without.lacked(i).max(white[i]);
        let held = (0..arm.truth.len()).filter(is_held).count() as f64 / arm.truth.len() as f64;
        let mut effects: Vec<Effect> = (0..3).map(kind).collect();
        effects.dedup();
        (named, held, error(&estimate(&arm, &experiments, &effects), arm.truth), sentence)
    });
    let sentences: Vec<_> = found.iter().map(|f| &f.3).collect();
    assert!(found.iter().filter(|f| f.0).count() == DRAWS, "{defect:?}: {sentences:?}");
    let (held, error) = (mean(found.iter().map(|f| f.1)), mean(found.iter().map(|f| f.2)));
    assert!(held >= 0.9, "{defect:?}: {held}");
    assert!(error <= 0.3, "{defect:?}: {error} %");
}

/// Elastic(25.0) and Elastic(12.0): the links resonate at 25 and 12 Hz; equations up to 10 Hz are used. Play(1e-3): backlash of 1
/// mrad, which changes the parameters as much as elastic joints of 30 Hz do.
#[test]
fn defects_are_named() {
    let ripple = |joint: usize| Effect::Ripple { joint, periods: 12.0 };
    looked_at(Defect::Late(1e-3), &|_| Effect::Delay);
    looked_at(Defect::GainRipple(0.02, 12.0), &ripple);
    looked_at(Defect::Ripple(0.02, 12.0), &ripple);
    looked_at(Defect::Spring(6.0), &|joint| Effect::Spring { joint });
    looked_at(Defect::Eccentric(6e-3), &|joint| Effect::Eccentric { joint });
    looked_at(Defect::Elastic(25.0), &|joint| Effect::Elastic { joint });
    looked_at(Defect::Elastic(12.0), &|joint| Effect::Elastic { joint });
    looked_at(Defect::Play(1e-3), &|joint| Effect::Play { joint });
}

/// An encoder eccentricity of 2 mrad is within the noise of the arm R3G, so no cause is named. The error of the parameters is
/// below 0.3 %. The intervals do not account for the error that the eccentricity causes.
#[test]
fn an_encoder_within_the_noise_is_not_named() {
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    let exact = Defect::Eccentric(2e-3).experiments(&arm, &golden_plan(), None).unwrap();
    for draw in 0..DRAWS as u64 {
        let found = estimate(&arm, &measured(&exact, &arm, &arm.sensing, SEED, draw), &[]);
        assert!(found.cause.is_none() && !found.misfit.is_beyond_noise(), "{:?}", found.misfit.joints);
        assert!(error(&found, arm.truth) < 0.3, "{}", error(&found, arm.truth));
    }
}

#[test]
fn the_joint_is_named() {
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    let sentence = |defect: Defect| {
        let exact = defect.experiments(&arm, &golden_plan(), Some(1)).unwrap();
        let found = estimate(&arm, &measured(&exact, &arm, &arm.sensing, SEED, 0), &[]);
        found.cause.map_or(String::new(), |cause| cause_sentence(&cause, arm.regressor))
    };
    let ripple = sentence(Defect::Ripple(0.02, 12.0));
    assert!(ripple.starts_with("q2 has ripple of 0.") && ripple.contains("[ripple=q2=12] "), "{ripple}");
    let spring = sentence(Defect::Spring(6.0));
    assert!(
        spring.starts_with("a spring of ") && spring.contains("acts on q2") && spring.contains("[spring=q2]"),
        "{spring}"
    );
    let elastic = sentence(Defect::Elastic(15.0));
    assert!(elastic.starts_with("q2 bends: 2") && elastic.contains("[elastic=q2] "), "{elastic}");
}

#[test]
fn gains_widen_with_the_rest() {
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    let known = [Gain::Free, Gain::Free, Gain::Known(1.0)];
    let exact = Defect::GainRipple(0.05, 12.0).experiments(&arm, &golden_plan(), None).unwrap();
    let found = each_draw(DRAWS_OF_GAINS, 2, |draw| {
        let experiments = measured(&exact, &arm, &arm.sensing, SEED, draw);
        let noise = NoiseLevels::measured(&experiments).unwrap();
        let options = HarmonicOptions::default();
        let mut data = HarmonicData::new(&experiments, arm.regressor, &[1.0; 3], &noise, &options.band);
        let found = data.estimate_with_gains(&known, &options).unwrap();
        let friction = found.friction.unwrap();
        assert!(friction.misfit.is_lacking());
        assert_eq!(friction.misfit.gains_by_experiment[2], 0.0);
        let gains = &found.gains;
        let errors = gains.parameters.iter().zip(arm.truth).chain(gains.gain[..2].iter().zip(&arm.drives.gain));
        let errors: Vec<f64> = errors.map(|(x, truth)| (x - truth).abs()).collect();
        let white: Vec<f64> = gains.deviation.iter().chain(&gains.gain_deviation[..2]).copied().collect();
        let lacked: Vec<f64> = (0..arm.truth.len()).map(|i| friction.lacked(i)).collect();
        let lacked = [&lacked[..], &friction.misfit.gains_by_experiment[..2]].concat();
        let share = |sigma: &dyn Fn(usize) -> f64| {
            (0..errors.len()).filter(|&i| errors[i] <= 1.96 * sigma(i)).count() as f64 / errors.len() as f64
        };
        (share(&|i| white[i]), share(&|i| white[i].max(lacked[i])))
    });
    let (white, believed) = (mean(found.iter().map(|f| f.0)), mean(found.iter().map(|f| f.1)));
    assert!(believed >= 0.9 && believed > white, "{white} {believed}");
}
