//! Tests RIST-MH (the estimator in the frequency domain) on robots with defects that its model does not contain: how often the
//! program names the cause; errors and coverage of fits without and with columns that model the defect.
//!
//! `cargo bench -p tests --bench misfit -- [DRAWS] [SEED] [NAME]`. Printed are |X^ - X| / |X|, %, median over the draws (X^:
//! estimate, X: true base parameters), and the coverage of the 95 % intervals of the base parameters.

use identification::spectrum::experiment::{NoiseLevels, SpectralExperiment};
use identification::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use identification::spectrum::rist_mh::effects::Effect;
use identification::spectrum::rist_mh::search::HarmonicEstimate;
use identification::spectrum::words::cause_sentence;
use tests::benchmark::arms::r3_arm;
use tests::benchmark::defects::{Defect, measured};
use tests::benchmark::monte_carlo::Fixture;
use tests::benchmark::plans::golden_plan;
use tests::benchmark::robots::r3;
use tests::benchmark::scenario::{BenchmarkArm, Scenario};

fn estimate(arm: &BenchmarkArm, experiments: &[SpectralExperiment], effects: &[Effect]) -> HarmonicEstimate {
    let noise = NoiseLevels::measured(experiments).unwrap_or_else(|| panic!("no two periods"));
    let options = HarmonicOptions::default().with_effects(effects.to_vec());
    let mut data = HarmonicData::new(experiments, arm.regressor, &arm.drives.gain, &noise, &options.band);
    data.estimate(&options).unwrap_or_else(|| panic!("no equations"))
}

#[derive(Default)]
struct Figures {
    error: Vec<f64>,
    covered: Vec<f64>,
    covered_by_experiment: Vec<f64>,
    chi: Vec<f64>,
    lacking: usize,
}

impl Figures {
    fn add(&mut self, found: &HarmonicEstimate, truth: &[f64]) {
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let errors: Vec<f64> = found.values().iter().zip(truth).map(|(x, t)| x - t).collect();
        self.error.push(100.0 * norm(&mut errors.iter().copied()) / norm(&mut truth.iter().copied()));
        let white = found.deviations();
        let share = |sigma: &dyn Fn(usize) -> f64| {
            let inside = (0..truth.len()).filter(|&i| errors[i].abs() <= 1.96 * sigma(i).max(white[i])).count();
            100.0 * inside as f64 / truth.len() as f64
        };
        self.covered.push(share(&|i| found.lacked(i)));
        self.covered_by_experiment.push(share(&|i| found.misfit.by_experiment.get(i).copied().unwrap_or(0.0)));
        self.chi.push(found.misfit.total);
        self.lacking += usize::from(found.misfit.is_lacking());
    }
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

fn median(x: &[f64]) -> f64 {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// For each case: name, defect, the joint with the defect (`None`: all joints), and the effects that model the defect.
fn cases() -> Vec<(&'static str, Defect, Option<usize>, Vec<Effect>)> {
    let all = |f: &dyn Fn(usize) -> Effect| (0..3).map(f).collect::<Vec<Effect>>();
    let ripple = all(&|joint| Effect::Ripple { joint, periods: 12.0 });
    let elastic = all(&|joint| Effect::Elastic { joint });
    let play = all(&|joint| Effect::Play { joint });
    vec![
        ("late 1 ms", Defect::Late(1e-3), None, vec![Effect::Delay]),
        ("late 1.5 ms", Defect::Late(1.5e-3), None, vec![Effect::Delay]),
        ("gain ripple 2 %", Defect::GainRipple(0.02, 12.0), None, ripple.clone()),
        ("gain ripple 5 %", Defect::GainRipple(0.05, 12.0), None, ripple.clone()),
        ("ripple 2 %", Defect::Ripple(0.02, 12.0), None, ripple.clone()),
        ("elastic 12 Hz", Defect::Elastic(12.0), None, elastic.clone()),
        ("elastic 15 Hz", Defect::Elastic(15.0), None, elastic.clone()),
        ("elastic 25 Hz", Defect::Elastic(25.0), None, elastic.clone()),
        ("play 0.3 mrad", Defect::Play(3e-4), None, play.clone()),
        ("play 1 mrad", Defect::Play(1e-3), None, play.clone()),
        ("ripple 2 % of q2", Defect::Ripple(0.02, 12.0), Some(1), ripple[1..2].to_vec()),
        ("elastic 15 Hz of q2", Defect::Elastic(15.0), Some(1), elastic[1..2].to_vec()),
        ("elastic 15 Hz of q3", Defect::Elastic(15.0), Some(2), elastic[2..3].to_vec()),
    ]
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let draws: u64 = words.first().and_then(|a| a.parse().ok()).unwrap_or(10);
    let seed: u64 = words.get(1).and_then(|a| a.parse().ok()).unwrap_or(1000);
    let only = words.get(2).map_or("", String::as_str);
    let robot = r3(true);
    let arm = r3_arm("R3G", &robot);
    println!("{:<20} lacking named |  chi^2   X %  cover (by experiments) | with: chi^2   X %  cover", "defect");
    for (name, defect, joint, effects) in cases().into_iter().filter(|c| c.0.contains(only)) {
        let Ok(exact) = defect.experiments(&arm, &golden_plan(), joint) else {
            println!("{name:<20} not physical");
            continue;
        };
        let (mut without, mut with, mut named, mut told) = (Figures::default(), Figures::default(), 0, Vec::new());
        for draw in 0..draws {
            let experiments = measured(&exact, &arm, &arm.sensing, seed, draw);
            let found = estimate(&arm, &experiments, &[]);
            without.add(&found, arm.truth);
            let kind = |e: &Effect| std::mem::discriminant(e);
            let is_named = found.cause.as_ref().is_some_and(|c| kind(&c.effects[0].effect) == kind(&effects[0]));
            named += usize::from(is_named);
            told.push(found.cause.as_ref().map_or("-".into(), |cause| cause_sentence(cause, arm.regressor)));
            with.add(&estimate(&arm, &experiments, &effects), arm.truth);
        }
        println!(
            "{name:<20} {:>7} {named:>5} | {:>6.1} {:>6.3} {:>5.1} ({:>5.1}) | {:>6.2} {:>6.3} {:>5.1}",
            without.lacking,
            mean(&without.chi),
            median(&without.error),
            mean(&without.covered),
            mean(&without.covered_by_experiment),
            mean(&with.chi),
            median(&with.error),
            mean(&with.covered)
        );
        told.dedup();
        told.iter().take(1).for_each(|sentence| println!("    {sentence}"));
    }
    sound(&arm, draws, seed, only);
}

fn sound(arm: &BenchmarkArm, draws: u64, seed: u64, only: &str) {
    for scenario in Scenario::all(arm).into_iter().filter(|s| s.name.contains(only)) {
        let (name, sensing) = (scenario.name, scenario.sensing.clone());
        let Ok(fixture) = Fixture::new(arm, scenario, &golden_plan()) else { continue };
        let exact = fixture.measured(None, 0);
        let (mut figures, mut named) = (Figures::default(), 0);
        for draw in 0..draws {
            let found = estimate(arm, &measured(&exact, arm, &sensing, seed, draw), &[]);
            named += usize::from(found.cause.is_some());
            figures.add(&found, arm.truth);
        }
        println!(
            "{name:<20} {:>7} {named:>5} | {:>6.1} {:>6.3} {:>5.1}",
            figures.lacking,
            mean(&figures.chi),
            median(&figures.error),
            mean(&figures.covered)
        );
    }
}
