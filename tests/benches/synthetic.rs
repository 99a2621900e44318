//! Compares all estimators with the Cramer-Rao bound on simulated logs: `cargo bench -p tests --bench synthetic [DRAWS]`.
//!
//! The arm R3G (three revolute axes, with gravity, without friction, 15 base parameters) moves from point to point in closed loop
//! (PD controller, torques constant during a sample) at 1 kHz. The model is exact, so all errors are caused by the estimator. The
//! motion is simulated once; each draw adds noise to it. Torque noise: 0.20, 0.15, 0.10 N m per sample.
//!
//! | column | meaning |
//! |---|---|
//! | bias | largest abs(mean error) of a parameter, divided by its bound; without bias about 2.3 / sqrt(draws) |
//! | RMSE | rms error over draws and parameters, divided by the bound |
//! | white, robust | coverage of the intervals x +- 1.96 sigma with the sigma of white noise, and with the robust sigma |
//!
//! The bound is for white torque noise: (sum_j W_j' W_j / sigma_j^2)^-1/2, with the noise-free states of all samples.
//!
//! | condition | meaning |
//! |---|---|
//! | white | exact states, white torque noise |
//! | spikes | 5 % of the samples have an additional error of 20 sigma with random sign |
//! | spikes upward | the same with positive sign, which gives an offset of one sigma |
//! | slow | torque noise e_i = 0.9 e_(i-1) + sqrt(1 - 0.81) n_i with the same standard deviation |
//! | f Hz | q with encoder noise (5e-5 rad) and rounding (1e-4 rad); both sides low-pass filtered at f Hz, or no filter |
//! | noisy columns | rows divided by sigma_j; the columns of MX2 and MX3 have white noise of 5 % of their rms |
//! | x 1, x 60 | `white` with 1 or 60 times the noise; `known`: reference bodies that are wrong by -15 .. 20 % |
//!
//! IV and DIDIM [Janot, Vandanjon, Gautier 2014; Gautier, Janot, Vandanjon 2013] start from links that are wrong by 20, -15, 15
//! %.

use std::cell::RefCell;

use experiments::motion::point_to_point::{ValidationMotion, validation_trajectory};
use experiments::motion::record::Record;
use experiments::motion::reference_motion::Reference;
use experiments::simulate::closed_loop::{Sensors, Simulation, Steps};
use identification::estimate::consistent::{Consistency, identify_consistent};
use identification::estimate::identify::Fit;
use identification::estimate::options::Options;
use identification::estimators::essential::{Elimination, essential};
use identification::estimators::weighted::Weights;
use research::{ClosedLoop, Simulator, simulated};

use identification::rows::observation::{Observation, weighted};
use identification::signals::signal_options::Signal;
use linear_model::linear_model::Model;
use linear_model::pseudo_inertia::Ten;
use linear_model::standard_map::StandardMap;
use linear_model::states::States;
use logs::{Error, Log};
use numerics::least_squares::solve;
use numerics::total_least_squares::total_least_squares;
use numerics::triangle::{Triangle, TriangleBuilder};
use random::Random;
use tests::benchmark::arms::{NO_FRICTION, NOISE, r3_arm};
use tests::benchmark::monte_carlo::each_draw;
use tests::benchmark::robots::r3;
use tests::benchmark::scenario::BenchmarkArm;
use tests::benchmark::tally::Tally;
use tests::joint_log::even_log;
use tests::tape_robot::TapeRobot;

/// The result of one estimator for one draw.
struct Found {
    estimator: &'static str,
    condition: String,
    /// Standard deviation of the noise, divided by the standard deviation for which the Cramer-Rao bound is computed.
    scale: f64,
    x: Vec<f64>,
    white: Vec<f64>,
    robust: Vec<f64>,
    /// Further numbers of the draw. Their mean and maximum are printed.
    figures: Vec<(&'static str, f64)>,
}

impl Found {
    fn new(estimator: &'static str, condition: impl Into<String>, x: &[f64]) -> Found {
        let (white, robust, figures) = (Vec::new(), Vec::new(), Vec::new());
        Found { estimator, condition: condition.into(), scale: 1.0, x: x.to_vec(), white, robust, figures }
    }

    fn of_fit(estimator: &'static str, condition: impl Into<String>, fit: &Fit) -> Found {
        let parameters = &fit.estimate.parameters;
        let white = parameters.iter().filter_map(|p| p.white_sigma).collect();
        let robust = parameters.iter().filter_map(|p| p.sigma).collect();
        Found { white, robust, ..Found::new(estimator, condition, &fit.solution.x) }
    }

    fn figure(mut self, name: &'static str, value: f64) -> Found {
        self.figures.push((name, value));
        self
    }
}

/// The arm, its motion, and the Cramer-Rao bound of the parameters for this motion.
struct Bench<'a> {
    arm: BenchmarkArm<'a>,
    robot: &'a TapeRobot,
    map: StandardMap,
    /// The robot with wrong inertial parameters: its links are wrong by 20, -15, 15 %.
    wrong: TapeRobot,
    reference: Reference,
    record: Record,
    /// All samples with noise-free torques. `information`: triangle (the R of a QR decomposition) of the rows divided by sigma of
    /// the torque noise.
    states: States,
    information: Triangle,
    bound: Vec<f64>,
}

impl<'a> Bench<'a> {
    fn new(robot: &'a TapeRobot) -> Bench<'a> {
        let arm = BenchmarkArm { friction: vec![NO_FRICTION; 3], ..r3_arm("R3G", robot) };
        let motion = ValidationMotion { moves: 8, ..ValidationMotion::default() };
        let (v, a) = (&arm.velocity, &arm.acceleration);
        let reference = validation_trajectory(&motion, &arm.position, v, a, arm.sample_time, &mut Random::new(1000));
        let record = run(&arm, robot, &reference);
        let mut states = states(robot, &record, &arm, None).expect("the arm's own record is a log");
        let model = Model::new(robot, &[], &[]);
        let mut torques = vec![0.0; states.tau.len()];
        model.residuals(&States { tau: torques.clone(), ..states.clone() }, &robot.truth, |r, j, e| {
            torques[r * 3 + j] = -e;
        });
        states.tau = torques;
        let joints = Observation::of(&model, &states, 1).joints(|_| true);
        let information = weighted(&joints, &NOISE.map(|s| 1.0 / s));
        let inverse = solve(&information).inverse;
        let bound = inverse.diagonal().iter().map(|v| v.sqrt()).collect();
        let (map, wrong) = (robot.map(), robot.with_scaled_links(&[1.2, 0.85, 1.15]));
        Bench { arm, robot, map, wrong, reference, record, states, information, bound }
    }

    /// The exact states with noise on the torques; `noise(joint)` gives the torque noise of one sample.
    fn noisy(&self, mut noise: impl FnMut(usize) -> f64) -> States {
        let mut states = self.states.clone();
        states.tau.iter_mut().enumerate().for_each(|(i, tau)| *tau += noise(i % 3));
        states
    }

    fn fit(&self, states: &States, weights: Weights) -> Fit {
        let options = Options { weights, friction: Vec::new(), ..Options::default() };
        Fit::of_records(self.robot, std::slice::from_ref(states), Vec::new(), &options).expect("states in memory")
    }

    /// Largest difference between two estimates of a parameter, divided by its Cramer-Rao bound.
    fn apart(&self, a: &[f64], b: &[f64]) -> f64 {
        (0..a.len()).map(|c| (a[c] - b[c]).abs() / self.bound[c]).fold(0.0, f64::max)
    }

    fn least_squares(&self, random: &mut Random) -> Vec<Found> {
        let white = self.noisy(|j| NOISE[j] * random.normal());
        let spike = |random: &mut Random, j: usize, both: bool| {
            let sign = if both && random.uniform() < 0.5 { -1.0 } else { 1.0 };
            NOISE[j] * (random.normal() + if random.uniform() < 0.05 { 20.0 * sign } else { 0.0 })
        };
        let spikes = self.noisy(|j| spike(random, j, true));
        let upward = self.noisy(|j| spike(random, j, false));
        let mut before = [0.0; 3];
        let slow = self.noisy(|j| {
            before[j] = 0.9 * before[j] + (1.0f64 - 0.81).sqrt() * random.normal();
            NOISE[j] * before[j]
        });
        let mut found = vec![Found::of_fit("OLS", "white", &self.fit(&white, Weights::None))];
        for (condition, states) in [("white", &white), ("spikes", &spikes), ("spikes upward", &upward)] {
            found.push(Found::of_fit("WLS", condition, &self.fit(states, Weights::Joint)));
            found.push(Found::of_fit("Huber", condition, &self.fit(states, Weights::Huber)));
        }
        found.push(Found::of_fit("WLS", "slow", &self.fit(&slow, Weights::Joint)));
        found.extend(self.essential(&self.fit(&white, Weights::Joint)));
        found
    }

    /// Elimination of insignificant parameters. Parameters below two Cramer-Rao bounds may be removed; parameters above five
    /// bounds must not be removed.
    fn essential(&self, fit: &Fit) -> Vec<Found> {
        let triangle = weighted(&fit.observation.joints(|_| true), &fit.weights);
        // Without a parameter whose true value is zero, the squared residual is larger by about one sigma^2, and in 95 % of the
        // cases by at most 3.84 sigma^2.
        let significant = 3.84 / triangle.rows as f64;
        let limits = [("residual 2 %", Elimination::default().growth), ("F test 95 %", 0.5 * significant)];
        let found = limits.map(|(name, growth)| {
            let kept = essential(&triangle, Elimination { growth, ..Elimination::default() });
            let size = |c: &usize| self.robot.truth[*c].abs() / self.bound[*c];
            let small = (0..self.bound.len()).filter(|c| size(c) < 2.0).count();
            let gone = kept.dropped.iter().filter(|c| size(c) < 2.0).count();
            Found::new("essential", name, &kept.x)
                .figure("dropped", kept.dropped.len() as f64)
                .figure("dropped above 5 bounds", kept.dropped.iter().filter(|c| size(c) > 5.0).count() as f64)
                .figure("kept below 2 bounds", (small - gone) as f64)
        });
        found.into()
    }

    /// Least squares and total least squares if two columns of the regressor have noise.
    fn noisy_columns(&self, random: &mut Random) -> Vec<Found> {
        let model = Model::new(self.robot, &[], &[]);
        let rows = 3.0 * self.states.len() as f64;
        let of = |name: &str| self.robot.column(name).expect("a base parameter of the arm");
        let noisy = [of("MX2"), of("MX3")].map(|c| (c, 0.05 * self.information.column_norm(c) / rows.sqrt()));
        let mut block = TriangleBuilder::new(model.p());
        model.rows(&self.states, 0..self.states.len(), |r, w| {
            for (j, row) in w.chunks_exact_mut(model.p()).enumerate() {
                row.iter_mut().for_each(|x| *x /= NOISE[j]);
                noisy.iter().for_each(|&(c, sd)| row[c] += sd * random.normal());
                block.push(row, self.states.tau[3 * r + j] / NOISE[j] + random.normal());
            }
        });
        let triangle = block.finish();
        // Noise of a column is equivalent to torque noise of the same size times the parameter of the column.
        let extra: f64 = noisy.iter().map(|&(c, sd)| (sd * self.robot.truth[c]).powi(2)).sum();
        let found = |name, x: &[f64]| Found { scale: (1.0 + extra).sqrt(), ..Found::new(name, "noisy columns", x) };
        let mixed = total_least_squares(&triangle, &noisy).expect("a motion that shows everything");
        vec![found("WLS", &solve(&triangle).x), found("LS-TLS", &mixed.x)]
    }

    /// Estimates from simulated measurements of the closed loop, with suitable and with unsuitable filters.
    fn closed_loop(&self, random: &mut Random) -> Vec<Found> {
        let sensing = Sensors { torque_noise: NOISE.to_vec(), ..self.arm.sensing.clone() };
        let measured = sensing.measure(&self.record, &self.arm.drives.gain, random);
        let mut found: Vec<Found> = Vec::new();
        for (name, cutoff) in [
            ("150 Hz", Some(150.0)),
            ("40 Hz", Some(40.0)),
            ("20 Hz", Some(20.0)),
            ("3 Hz", Some(3.0)),
            ("no filter", None),
        ] {
            let states = states(self.robot, &measured, &self.arm, cutoff).expect("a record of the arm");
            let fit = self.fit(&states, Weights::Joint);
            let rows = fit.estimate.rows as f64;
            let mut of = vec![Found::of_fit("WLS", name, &fit)];
            let model = Model::new(self.robot, &[], &[]);
            for (estimator, method) in
                [("IV", ClosedLoop::InstrumentalVariables), ("DIDIM", ClosedLoop::DirectAndInverse)]
            {
                let again = Again { bench: self, cutoff, tried: RefCell::default() };
                let Ok(x) = simulated(&model, &states, &again, &self.wrong.truth, method) else {
                    let nothing = vec![f64::NAN; self.bound.len()];
                    of.push(Found::new(estimator, name, &nothing));
                    continue;
                };
                let mut tried = again.tried.into_inner();
                tried.push(x.x.clone());
                let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
                let step = |w: &[Vec<f64>]| size(&w[0].iter().zip(&w[1]).map(|(a, b)| a - b).collect::<Vec<_>>());
                let settled = tried.windows(2).position(|w| step(w) < 1e-3 * size(&w[1])).unwrap_or(tried.len());
                let one =
                    Found { white: x.sigma.clone(), robust: x.robust.clone(), ..Found::new(estimator, name, &x.x) };
                of.push(one.figure("iterations to 1e-3", settled as f64).figure("to 1e-6", x.iterations as f64));
            }
            for one in of {
                let at_150 = found.iter().find(|f| f.estimator == one.estimator).map(|f| self.apart(&f.x, &one.x));
                let one = one.figure("rows", rows);
                found.push(match at_150 {
                    Some(apart) => one.figure("from 150 Hz", apart),
                    None => one,
                });
            }
        }
        found
    }

    /// Estimates with physically consistent bodies, compared with least squares.
    fn bodies(&self, random: &mut Random) -> Vec<Found> {
        let known: Vec<Option<Ten>> = self.wrong.bodies().into_iter().map(Some).collect();
        let options = Options { friction: Vec::new(), ..Options::default() };
        let mut found = Vec::new();
        for (name, scale) in [("x 1", 1.0), ("x 60", 60.0)] {
            let states = self.noisy(|j| scale * NOISE[j] * random.normal());
            let fit = self.fit(&states, Weights::Joint);
            // The norm of the errors of all parameters together, in standard deviations.
            let whitened = |x: &[f64]| (self.information.squares(x).1 / x.len() as f64).sqrt() / scale;
            let ls = fit.solution.x.clone();
            found.push(Found { scale, ..Found::of_fit("WLS", name, &fit) }.figure("whitened", whitened(&ls)));
            for (suffix, references, weight) in
                [("", vec![None; 3], 0.1), (", known", known.clone(), 0.1), (", weight 1e-3", vec![None; 3], 1e-3)]
            {
                let consistency = Consistency { prior_weight: weight, ..Consistency::default() };
                let out = identify_consistent(self.robot, &self.map, &references, &fit, &options, &consistency)
                    .expect("the map fits the arm");
                let x = &out.consistent.x;
                let sigma = out.estimate.parameters.iter().filter_map(|p| p.sigma).collect();
                let one = Found::new("consistent", format!("{name}{suffix}"), x);
                found.push(
                    Found { scale, white: sigma, ..one }
                        .figure("whitened", whitened(x))
                        .figure("whitened over LS", whitened(x) / whitened(&ls))
                        .figure("from LS", self.apart(x, &ls) / scale),
                );
            }
        }
        found
    }

    fn draw(&self, draw: u64) -> Vec<Found> {
        let random = &mut Random::stream(11, draw);
        let parts = [Bench::least_squares, Bench::noisy_columns, Bench::closed_loop, Bench::bodies];
        parts.into_iter().flat_map(|part| part(self, random)).collect()
    }
}

/// Repeats the experiment with other parameters and the same filter, for the estimators that need a simulation.
struct Again<'a> {
    bench: &'a Bench<'a>,
    cutoff: Option<f64>,
    tried: RefCell<Vec<Vec<f64>>>,
}

impl Simulator for Again<'_> {
    fn simulate(&self, x: &[f64]) -> Result<States, Error> {
        self.tried.borrow_mut().push(x.to_vec());
        let (bench, robot) = (self.bench, self.bench.robot.with_base(x));
        states(bench.robot, &run(&bench.arm, &robot, &bench.reference), &bench.arm, self.cutoff)
    }
}

/// Simulates the closed loop without rounding of the positions. If the parameters are physically impossible, the simulation stops
/// early, and the record is shorter than the reference.
fn run(arm: &BenchmarkArm, robot: &TapeRobot, reference: &Reference) -> Record {
    let simulation = Simulation {
        dynamics: robot,
        controller: &arm.controller,
        drives: &arm.drives,
        quantum: &[0.0; 3],
        friction: &arm.friction,
        steps: Steps::RungeKutta(2),
    };
    simulation.run(reference, None).0
}

/// Converts a simulated record to a log, and applies a low-pass filter with this cut-off, Hz.
fn states(robot: &TapeRobot, record: &Record, arm: &BenchmarkArm, cutoff: Option<f64>) -> Result<States, Error> {
    let torque = |(current, gain): (&Vec<f64>, &f64)| current.iter().map(|c| c * gain).collect();
    let effort = record.current.iter().zip(&arm.drives.gain).map(torque).collect();
    let names = linear_model::regressor::Regressor::coordinates(robot);
    let log = Log { dq: None, ..even_log(names, record.sample_time, [record.q.clone(), Vec::new(), effort]) };
    let order = if cutoff.is_some() { Signal::default().order } else { 0 };
    let signal = Signal { cutoff, order, standstill: Some(0.0), ..Signal::default() };
    let records = identification::signals::preparation::states(
        robot,
        &log,
        &Options { signal, friction: Vec::new(), ..Options::default() }.preparation(),
    )?;
    // The clock has no gaps, so there is exactly one record.
    records.into_iter().next().ok_or_else(|| Error::new("no record"))
}

fn main() {
    let draws = std::env::args().skip(1).find_map(|w| w.parse().ok()).unwrap_or(50).max(1);
    let robot = r3(true);
    let bench = Bench::new(&robot);
    let f95: Vec<String> = bench.states.f95.iter().map(|f| format!("{f:.1}")).collect();
    println!("R3G, {} samples at 1 kHz, f95 {} Hz, {draws} draws", bench.states.len(), f95.join(", "));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let found = each_draw(draws, threads, |draw| bench.draw(draw));
    println!(
        "| estimator | condition | bias | RMSE | white | robust | mean (largest) |\n|---|---|---|---|---|---|---|"
    );
    for row in 0..found[0].len() {
        println!("{}", line(&bench, &found.iter().map(|f| &f[row]).collect::<Vec<_>>()));
    }
}

fn line(bench: &Bench, draws: &[&Found]) -> String {
    let (mut white, mut robust) = (Tally::default(), Tally::default());
    for found in draws {
        let bound: Vec<f64> = bench.bound.iter().map(|b| found.scale * b).collect();
        white.add(&found.x, &bench.robot.truth, &bound, &found.white);
        robust.add(&found.x, &bench.robot.truth, &bound, &found.robust);
    }
    let share =
        |t: &Tally| if t.coverage().is_nan() { String::new() } else { format!("{:.1} %", 100.0 * t.coverage()) };
    let first = draws[0];
    let figure = |(i, (name, _)): (usize, &(&str, f64))| {
        let of = || draws.iter().filter_map(|d| d.figures.get(i)).map(|f| f.1);
        let (mean, largest) = (of().sum::<f64>() / draws.len() as f64, of().fold(f64::NEG_INFINITY, f64::max));
        if mean == largest { format!("{name} {mean}") } else { format!("{name} {mean:.3} ({largest:.3})") }
    };
    let figures: Vec<String> = first.figures.iter().enumerate().map(figure).collect();
    format!(
        "| {} | {} | {:.2} | {:.2} | {} | {} | {} |",
        first.estimator,
        first.condition,
        white.bias(),
        white.rmse(),
        share(&white),
        share(&robust),
        figures.join(", ")
    )
}
