//! Coverage of the intervals of `rist identify`: the share of the 95 % intervals that contain the true value. Command: `cargo
//! bench -p tests --bench coverage [DRAWS]`.
//!
//! The log: a UR5 with rotor inertias, a motion of 10 s repeated three times, 500 Hz. The program has its default options
//! (viscous and Coulomb friction, an offset). Each draw has its own motion and noise. The function `lack_of_fit` lists the
//! effects that are in the log but not in the fitted model.
//!
//! | column | meaning |
//! |---|---|
//! | residual | mean of norm(tau - W X) / norm(tau) |
//! | held | coverage: share of the intervals x +- 1.96 sigma that contain the true value, over all parameters and draws |
//! | base, friction | coverage for base parameters, and for the friction parameters FV, FS, OFF (viscous, Coulomb, offset) |
//! | worst | coverage for the parameter with the smallest coverage |
//! | width | rms of sigma divided by the rms error, median over the parameters |
//! | FS | relative rms error of FS over all joints |
//! | sums | coverage of the intervals that `rist solve` computes from the stored sums of the same log |
//! | chosen | coverage for the base parameters if the program itself chooses delay, source of the velocity and friction |
//! | its width | width for the case `chosen` |
//! | yes | number of draws for which the program trusts the estimate, with a second log of another motion |

use std::path::Path;

use fleet::accumulator::Accumulator;
use fleet::replicate::Replicate;
use fleet::settings::Settings;
use identification::estimate::artefact::Estimate;
use identification::estimate::claims::hypotheses::UndeterminedMechanics;
use identification::estimate::identified::Identified;
use identification::estimate::identify::identify;
use identification::estimate::options::Options;
use identification::signals::records::SourceRecords;
use linear_model::reference::ModelReference;
use logs::Log;
use rist::fit::verdict::Trust;
use rist::request::IdentifyRequest;
use rist::{LogSource, Model};
use tests::benchmark::lack_of_fit::{LackOfFit, Truth};
use tests::benchmark::monte_carlo::each_draw;

/// The errors of an estimate and its standard deviations, one per parameter.
struct Found {
    residual: f64,
    error: Vec<f64>,
    white: Vec<f64>,
    sigma: Vec<f64>,
    sums: Vec<f64>,
    /// Error and standard deviation of each base parameter if the program itself chooses the options.
    chosen: Vec<(f64, f64)>,
    is_yes: bool,
}

fn main() {
    let draws = std::env::args().skip(1).find_map(|w| w.parse().ok()).unwrap_or(24).max(1);
    let robot = LackOfFit::default();
    let truth = robot.truth();
    let base = robot.robot.truth.len();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!("UR5, {} parameters, {draws} draws", truth.len());
    println!(
        "| truth | residual | white holds | held | base | friction | worst | width | FS | sums | chosen | its width | yes |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let model = Model::of(robot.robot.robot.clone(), Path::new("ur5.yaml"), false).unwrap_or_else(|e| panic!("{e}"));
    for what in Truth::ALL {
        let start = std::time::Instant::now();
        let found = each_draw(draws, threads, |draw| one(&model, &robot, &truth, what, draw));
        let held = |range: std::ops::Range<usize>, by: fn(&Found) -> &Vec<f64>| {
            let of = |f: &Found, c: usize| f.error[c].abs() <= 1.96 * by(f)[c];
            let count: usize = found.iter().map(|f| range.clone().filter(|&c| of(f, c)).count()).sum();
            100.0 * count as f64 / (range.len() * draws) as f64
        };
        let p = truth.len();
        let is_held = |(error, sigma): &&(f64, f64)| error.abs() <= 1.96 * sigma;
        let chosen: usize = found.iter().map(|f| f.chosen.iter().filter(is_held).count()).sum();
        let root = |x: &dyn Fn(&Found) -> f64| (found.iter().map(|f| x(f).powi(2)).sum::<f64>() / draws as f64).sqrt();
        let mut width: Vec<f64> = (0..p).map(|c| root(&|f| f.sigma[c]) / root(&|f| f.error[c])).collect();
        width.sort_by(f64::total_cmp);
        let of = |c: usize| root(&|f| f.chosen[c].1) / root(&|f| f.chosen[c].0);
        let mut its_width: Vec<f64> = (0..base).map(of).collect();
        its_width.sort_by(f64::total_cmp);
        let dry: Vec<usize> = (0..6).map(|k| base + 3 * k + 1).collect();
        let dry = (dry.iter().map(|&c| (root(&|f| f.error[c]) / truth[c]).powi(2)).sum::<f64>() / 6.0).sqrt();
        println!(
            "| {what:?} | {:.4} | {:.1} % | {:.1} % | {:.1} % | {:.1} % | {:.0} % | {:.2} | {:.2} % | {:.1} % | {:.1} % | {:.2} | {} |",
            found.iter().map(|f| f.residual).sum::<f64>() / draws as f64,
            held(0..p, |f| &f.white),
            held(0..p, |f| &f.sigma),
            held(0..base, |f| &f.sigma),
            held(base..p, |f| &f.sigma),
            (0..p).map(|c| held(c..c + 1, |f| &f.sigma)).fold(100.0, f64::min),
            width[p / 2],
            100.0 * dry,
            held(0..p, |f| &f.sums),
            100.0 * chosen as f64 / (base * draws) as f64,
            its_width[base / 2],
            found.iter().filter(|f| f.is_yes).count(),
        );
        eprintln!("{:.2} s a draw", start.elapsed().as_secs_f64() / draws as f64);
    }
}

fn one(model: &Model, robot: &LackOfFit, truth: &[f64], what: Truth, draw: u64) -> Found {
    let log = robot.log(what, draw);
    let estimate = identify(&robot.robot, &log, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    let of = |f: &dyn Fn(&Identified) -> f64| estimate.parameters.iter().map(f).collect::<Vec<f64>>();
    let sums = solved(robot, &log);
    let [log, other] = [log, robot.log(what, 1000 + draw)].map(LogSource::Held);
    let mut chosen = rist::identify(model, &[log], &IdentifyRequest::default()).unwrap_or_else(|e| panic!("{e}"));
    let judged = chosen.verdict_of_logs(model, &[other], false).unwrap_or_else(|e| panic!("{e}"));
    Found {
        sums: sums.parameters.iter().map(Identified::sigma_or_infinity).collect(),
        chosen: chosen.estimate.parameters[..robot.robot.truth.len()]
            .iter()
            .zip(truth)
            .map(|(p, truth)| (p.value.unwrap_or(f64::NAN) - truth, p.sigma_or_infinity()))
            .collect(),
        is_yes: judged.verdict.trust == Trust::Yes,
        residual: estimate.total.unwrap_or(f64::NAN),
        error: of(&|p| p.value.unwrap_or(f64::NAN)).iter().zip(truth).map(|(x, t)| x - t).collect(),
        white: of(&|p| p.white_sigma.unwrap_or(f64::NAN)),
        sigma: of(&|p| p.sigma_or_infinity()),
    }
}

fn solved(robot: &LackOfFit, log: &Log) -> Estimate {
    let options = Options::default();
    let source = LogSource::Held(log.clone());
    let records = SourceRecords::new(&robot.robot, std::slice::from_ref(&source), &options.preparation());
    let linear = options.linear_model(&robot.robot);
    let replicate =
        records.and_then(|records| Replicate::of(&linear, &source, &records, UndeterminedMechanics::default()));
    let reference = ModelReference { name: "ur5".into(), fingerprint: "1".into() };
    let sums =
        Settings::new(&robot.robot, reference, None, &options, UndeterminedMechanics::default()).map(Accumulator::new);
    let solved = sums.and_then(|mut sums| {
        sums.add(replicate?)?;
        sums.solve()
    });
    solved.unwrap_or_else(|e| panic!("{e}"))
}
