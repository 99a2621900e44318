//! What the intervals of `identify` hold, `cargo bench -p tests --bench coverage [DRAWS]`.
//!
//! A UR5 with rotors, a motion of 10 s three times over, 500 Hz, defaults of the program (viscous and Coulomb friction, an
//! offset). Each draw has a motion and noise of its own. What the truth has that the fit has not: `lack_of_fit`.
//!
//! | column | is |
//! |---|---|
//! | residual | mean of norm(tau - W X) / norm(tau) |
//! | held | share of the intervals x +- 1.96 sigma that hold the truth, of all parameters and draws |
//! | base, friction | the same of base parameters and of FV, FS, OFF |
//! | worst | that of the parameter held least often |
//! | width | root mean square sigma over root mean square error, median over the parameters |
//! | FS | root mean square error of FS, relative, all joints |

use identification::estimate::identify::identify;
use identification::estimate::options::Options;
use tests::benchmark::lack_of_fit::{LackOfFit, Truth};
use tests::benchmark::monte_carlo::each_draw;

/// An error and the deviation that is claimed of it, a parameter.
struct Found {
    residual: f64,
    error: Vec<f64>,
    white: Vec<f64>,
    sigma: Vec<f64>,
}

fn main() {
    let draws = std::env::args().skip(1).find_map(|w| w.parse().ok()).unwrap_or(24).max(1);
    let robot = LackOfFit::new();
    let truth = robot.truth();
    let base = robot.robot.truth.len();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!("UR5, {} parameters, {draws} draws", truth.len());
    println!("| truth | residual | white holds | held | base | friction | worst | width | FS |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for what in Truth::ALL {
        let start = std::time::Instant::now();
        let found = each_draw(draws, threads, |draw| one(&robot, &truth, what, draw));
        let held = |range: std::ops::Range<usize>, white: bool| {
            let of = |f: &Found, c: usize| f.error[c].abs() <= 1.96 * if white { f.white[c] } else { f.sigma[c] };
            let count: usize = found.iter().map(|f| range.clone().filter(|&c| of(f, c)).count()).sum();
            100.0 * count as f64 / (range.len() * draws) as f64
        };
        let p = truth.len();
        let root = |x: &dyn Fn(&Found) -> f64| (found.iter().map(|f| x(f).powi(2)).sum::<f64>() / draws as f64).sqrt();
        let mut width: Vec<f64> = (0..p).map(|c| root(&|f| f.sigma[c]) / root(&|f| f.error[c])).collect();
        width.sort_by(f64::total_cmp);
        let dry: Vec<usize> = (0..6).map(|k| base + 3 * k + 1).collect();
        let dry = (dry.iter().map(|&c| (root(&|f| f.error[c]) / truth[c]).powi(2)).sum::<f64>() / 6.0).sqrt();
        println!(
            "| {what:?} | {:.4} | {:.1} % | {:.1} % | {:.1} % | {:.1} % | {:.0} % | {:.2} | {:.2} % |",
            found.iter().map(|f| f.residual).sum::<f64>() / draws as f64,
            held(0..p, true),
            held(0..p, false),
            held(0..base, false),
            held(base..p, false),
            (0..p).map(|c| held(c..c + 1, false)).fold(100.0, f64::min),
            width[p / 2],
            100.0 * dry,
        );
        eprintln!("{:.2} s a draw", start.elapsed().as_secs_f64() / draws as f64);
    }
}

fn one(robot: &LackOfFit, truth: &[f64], what: Truth, draw: u64) -> Found {
    let log = robot.log(what, draw);
    let estimate = identify(&robot.robot, &log, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    let of = |f: &dyn Fn(&identification::estimate::identified::Identified) -> f64| {
        estimate.parameters.iter().map(f).collect::<Vec<f64>>()
    };
    Found {
        residual: estimate.total.unwrap_or(f64::NAN),
        error: of(&|p| p.value.unwrap_or(f64::NAN)).iter().zip(truth).map(|(x, t)| x - t).collect(),
        white: of(&|p| p.white_sigma.unwrap_or(f64::NAN)),
        sigma: of(&|p| p.sigma_or_infinity()),
    }
}
