//! What RIST-MH says of effects that its model does not have: late torques, ripple of a drive, joints that bend. Never of
//! the friction and the noise that it has.

use identification::algebra::random::Random;
use identification::experiments::record::Record;
use identification::simulate::closed_loop::Sensing;
use identification::spectrum::experiment::{NoiseLevels, SpectralExperiment};
use identification::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use identification::spectrum::rist_mh::search::HarmonicEstimate;
use tests::benchmark::arms::r3_arm;
use tests::benchmark::monte_carlo::Fixture;
use tests::benchmark::plans::golden_plan;
use tests::benchmark::robots::r3;
use tests::benchmark::scenario::{BenchmarkArm, Scenario};

/// What is in the record and not in the model.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Effect {
    None,
    /// The torques are logged so many s late.
    Late(f64),
    /// The drive's gain goes up and down by this share, twelve times a turn.
    Ripple(f64),
    /// The position is that of the motor, before a spring of so many N m/rad.
    Bent(f64),
}

impl Effect {
    fn of(self, experiment: &SpectralExperiment, gain: &[f64], h: f64) -> SpectralExperiment {
        let mut changed = experiment.clone();
        let n = experiment.len();
        for k in 0..gain.len() {
            for i in 0..n {
                match self {
                    Effect::None => {}
                    Effect::Late(seconds) => {
                        // Whole periods: what comes in at the start went out at the end.
                        let at = (i as f64 - seconds / h).rem_euclid(n as f64);
                        let (low, share) = (at.floor() as usize % n, at.fract());
                        let c = &experiment.current[k];
                        changed.current[k][i] = (1.0 - share) * c[low] + share * c[(low + 1) % n];
                    }
                    Effect::Ripple(share) => changed.current[k][i] *= 1.0 + share * (12.0 * experiment.q[k][i]).sin(),
                    Effect::Bent(stiffness) => {
                        changed.q[k][i] += gain[k] * experiment.current[k][i] / stiffness;
                    }
                }
            }
        }
        changed
    }
}

/// The estimate of one draw.
fn estimate(
    arm: &BenchmarkArm,
    fixture: &Fixture,
    sensing: &Sensing,
    draw: u64,
    effect: Effect,
    options: &HarmonicOptions,
) -> HarmonicEstimate {
    let h = arm.sample_time;
    let gain = &arm.drives.gain;
    let exact = fixture.measured(None, 0);
    let mut random = Random::stream(5, draw);
    let measured: Vec<SpectralExperiment> = exact
        .iter()
        .map(|e| {
            let e = effect.of(e, gain, h);
            let record = Record { sample_time: h, q: e.q.clone(), current: e.current.clone() };
            let noisy = sensing.measure(&record, gain, &mut random);
            SpectralExperiment { q: noisy.q, current: noisy.current, ..e }
        })
        .collect();
    let noise = NoiseLevels::measured(&measured).unwrap();
    HarmonicData::new(&measured, arm.regressor, gain, &noise, &options.band).estimate(options).unwrap()
}

/// Share of the base parameters whose 95 % interval holds the truth: by the noise alone, and by what is to be believed.
fn held(found: &HarmonicEstimate, truth: &[f64]) -> (f64, f64) {
    let white = found.deviations();
    let share = |sigma: &dyn Fn(usize) -> f64| {
        let inside = (0..truth.len()).filter(|&i| (found.values()[i] - truth[i]).abs() <= 1.96 * sigma(i)).count();
        inside as f64 / truth.len() as f64
    };
    (share(&|i| white[i]), share(&|i| white[i].max(found.misfit.by_experiment[i])))
}

#[test]
fn what_the_model_has_is_no_misfit() {
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    for scenario in Scenario::all(&arm) {
        let (name, sensing) = (scenario.name, scenario.sensing.clone());
        let fixture = Fixture::new(&arm, scenario, &golden_plan()).unwrap();
        for draw in 0..3 {
            let found = estimate(&arm, &fixture, &sensing, draw, Effect::None, &HarmonicOptions::default());
            assert!(!found.misfit.is_lacking(), "{name}: {:?}", found.misfit.joints);
        }
    }
}

#[test]
fn what_it_lacks_is_named_and_widens_the_intervals() {
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    let scenario = Scenario::all(&arm).into_iter().find(|s| s.name == "S1").unwrap();
    let sensing = scenario.sensing.clone();
    let fixture = Fixture::new(&arm, scenario, &golden_plan()).unwrap();
    for effect in [Effect::Late(1.5e-3), Effect::Ripple(0.02), Effect::Bent(2e4)] {
        for draw in 0..3 {
            let found = estimate(&arm, &fixture, &sensing, draw, effect, &HarmonicOptions::default());
            let (white, believed) = held(&found, arm.truth);
            assert!(found.misfit.is_lacking(), "{effect:?}: {:?}", found.misfit.joints);
            // A joint that bends moves everything the same way in all experiments, which no replicate shows.
            let least: f64 = if matches!(effect, Effect::Bent(_)) { 0.8 } else { 0.9 };
            assert!(believed >= least.max(white), "{effect:?}: {white} {believed}");
            if let Effect::Late(seconds) = effect {
                let with = HarmonicOptions { delay: true, ..HarmonicOptions::default() };
                let with = estimate(&arm, &fixture, &sensing, draw, effect, &with);
                assert!(!with.misfit.is_lacking(), "{:?}", with.misfit.joints);
                assert!(with.delay.is_some_and(|found| (found - seconds).abs() < 1e-4), "{:?}", with.delay);
            }
        }
    }
}
