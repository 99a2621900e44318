//! Compares estimators on the same records: bias, rms error relative to the Cramer-Rao bound, and validation.
//!
//! A scenario is simulated once in closed loop without noise. Each draw adds sensor noise to these records and runs all
//! estimators.
//!
//! | number | meaning |
//! |---|---|
//! | bias | mean error / sigma: rms over the parameters, and largest |
//! | RMSE | rms error / sigma: rms over the parameters |
//! | X | median over draws of norm(X^ - X) / norm(X), % (X^: estimate, X: true parameters) |
//! | tau | mean of norm(D (X^ - X)) / norm(D X) over draws and validation motions, % (D: regressor) |
//!
//! sigma: Cramer-Rao bound for white torque noise. It assumes that the motion is known exactly, that all samples of all moving
//! joints are used, and that each joint has four unknown friction coefficients, equal in all experiments.

use std::fmt;

use crate::benchmark::defects::measured;
use crate::benchmark::filtered_estimation::{filtered_least_squares, friction_row};
use crate::benchmark::scenario::{BenchmarkArm, Scenario};
use experiments::motion::point_to_point::{ValidationMotion, validation_trajectory};
use experiments::motion::record::Record;
use experiments::motion::reference_motion::Reference;
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::measured_motion::MeasuredMotion;
use experiments::simulate::closed_loop::{Sensors, Simulation, Steps, Stop};
use experiments::simulate::dynamics::{Dynamics, inverse_dynamics};
use identification::spectrum::experiment::{NoiseLevels, SpectralExperiment};
use identification::spectrum::paper::{PaperWeights, paper_estimate, paper_rows};
use identification::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use linear_model::friction::law::FrictionLaw;
use linear_model::regressor::Regressor;
use numerics::least_squares::solve;
use numerics::triangle::TriangleBuilder;
use random::Random;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    PaperEqual,
    PaperWeighted,
    /// RIST-MH (estimator in the frequency domain) with viscous and Coulomb friction in each direction, four columns per joint.
    HarmonicPlain,
    /// RIST-MH with the friction model that it chooses itself, and with friction that changes between experiments (drift).
    Harmonic,
    /// Least squares with a Butterworth filter at 40 Hz, decimation by 20, and friction columns.
    FilteredLeastSquares,
}

impl Method {
    pub const ALL: [Method; 5] = [
        Method::PaperEqual,
        Method::PaperWeighted,
        Method::HarmonicPlain,
        Method::Harmonic,
        Method::FilteredLeastSquares,
    ];
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Method::PaperEqual => "Sp rows, OLS (paper)",
            Method::PaperWeighted => "Sp rows, WLS",
            Method::HarmonicPlain => "RIST-MH, equation (5)",
            Method::Harmonic => "RIST-MH",
            Method::FilteredLeastSquares => "IDIM-LS, Butterworth",
        })
    }
}

/// The noise-free experiments of a scenario, and what is computed from them once.
pub struct Fixture<'a> {
    pub(crate) arm: &'a BenchmarkArm<'a>,
    pub scenario: Scenario,
    /// Noise-free records, restricted to the intervals that estimators use.
    experiments: Vec<SpectralExperiment>,
    /// The Cramer-Rao bound of each parameter, as a standard deviation.
    pub sigma: Vec<f64>,
    /// D'D of each validation motion, p x p, D: regressor.
    validation: Vec<Vec<f64>>,
    /// Largest tracking error of an experiment, rad.
    pub tracking: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    pub bias: f64,
    pub greatest_bias: f64,
    pub rmse: f64,
    pub greatest_rmse: f64,
    /// Error of the parameters, %.
    pub parameters: f64,
    /// Error of the torque on validation motions, %.
    pub torque: f64,
}

#[derive(Clone, Debug)]
pub struct Comparison {
    pub arm: &'static str,
    pub scenario: &'static str,
    pub experiments: usize,
    pub draws: usize,
    pub methods: Vec<(Method, Figures)>,
}

impl<'a> Fixture<'a> {
    /// Simulates the experiments and ten validation motions. Fails with the time at which the simulation stops, if the parameters
    /// of the robot are physically impossible.
    pub fn new(
        arm: &'a BenchmarkArm<'a>,
        scenario: Scenario,
        plan: &[ExcitingTrajectory],
    ) -> Result<Fixture<'a>, Stop> {
        let (n, p) = (arm.drives.gain.len(), arm.truth.len());
        let mut fixture =
            Fixture { arm, scenario, experiments: vec![], sigma: vec![], validation: vec![], tracking: 0.0 };
        let mut information = TriangleBuilder::new(p + 4 * n);
        for (trajectory, record) in plan.iter().zip(fixture.records(arm.dynamics, plan, 77)?) {
            let reference = trajectory.reference();
            for k in 0..n {
                let worst = record.q[k].iter().zip(&reference.q[k]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                fixture.tracking = fixture.tracking.max(worst);
            }
            add_information(&mut information, arm, &fixture.scenario.sensing, trajectory, &record);
            fixture.experiments.extend(SpectralExperiment::new(trajectory.clone(), &record));
        }
        let bound = solve(&information.finish());
        fixture.sigma = (0..p).map(|i| bound.inverse[(i, i)].max(0.0).sqrt()).collect();
        for seed in 0..10 {
            let motion = ValidationMotion::default();
            let random = &mut Random::new(1000 + seed);
            let (v, a) = (&arm.velocity, &arm.acceleration);
            let reference = validation_trajectory(&motion, &arm.position, v, a, arm.sample_time, random);
            let record = fixture.run(arm.dynamics, &reference, None, &fixture.scenario.friction)?;
            let whole = std::iter::once(5..record.q[0].len().saturating_sub(5)).collect::<Vec<_>>();
            fixture.validation.push(gram(&cut_motion(&record, &whole), arm.regressor));
        }
        Ok(fixture)
    }

    /// Adds the experiments of `plan` with a known load. `load`: its contribution to the base parameters. `dynamics`: dynamics of
    /// the loaded robot. The feedforward does not contain the load.
    pub fn with_load(
        mut self,
        dynamics: &dyn Dynamics,
        load: &[f64],
        plan: &[ExcitingTrajectory],
    ) -> Result<Fixture<'a>, Stop> {
        for (trajectory, record) in plan.iter().zip(self.records(dynamics, plan, 78)?) {
            self.experiments.extend(SpectralExperiment::new(trajectory.clone(), &record).map(|e| e.loaded(load)));
        }
        Ok(self)
    }

    /// One record per experiment. The friction changes between experiments, and the feedforward uses wrong parameters.
    fn records(&self, dynamics: &dyn Dynamics, plan: &[ExcitingTrajectory], seed: u64) -> Result<Vec<Record>, Stop> {
        let (mut random, scenario) = (Random::new(seed), &self.scenario);
        let wrong = |x: &f64, up: bool| x * if up { 1.2 } else { 0.8 };
        let wrong: Vec<f64> = self.arm.truth.iter().map(|x| wrong(x, random.uniform() >= 0.5)).collect();
        let mut record = |trajectory: &ExcitingTrajectory| {
            let mut drift = || 1.0 + random.between(-1.0, 1.0) * scenario.drift;
            let friction: Vec<FrictionLaw> = scenario.friction.iter().map(|law| law.scaled(drift())).collect();
            let reference = trajectory.reference();
            let feedforward = scenario.feedforward.then(|| inverse_dynamics(self.arm.regressor, &wrong, &reference));
            self.run(dynamics, &reference, feedforward.as_deref(), &friction)
        };
        plan.iter().map(&mut record).collect()
    }

    fn run(
        &self,
        dynamics: &dyn Dynamics,
        reference: &Reference,
        feedforward: Option<&[Vec<f64>]>,
        friction: &[FrictionLaw],
    ) -> Result<Record, Stop> {
        let simulation = Simulation {
            dynamics,
            controller: &self.arm.controller,
            drives: &self.arm.drives,
            quantum: &self.scenario.sensing.quantum,
            friction,
            steps: Steps::RungeKutta(2),
        };
        match simulation.run(reference, feedforward) {
            (record, Stop::End) => Ok(record),
            (_, stop) => Err(stop),
        }
    }

    /// The experiments with the sensor noise of one draw. If `draw` is `None`: without noise and rounding.
    pub fn measured(&self, draw: Option<u64>, seed: u64) -> Vec<SpectralExperiment> {
        let Some(draw) = draw else { return self.experiments.clone() };
        measured(&self.experiments, self.arm, &self.scenario.sensing, seed, draw)
    }

    /// The base parameters, estimated by one method.
    pub fn estimate(&self, method: Method, experiments: &[SpectralExperiment]) -> Vec<f64> {
        let (arm, gain) = (self.arm, &self.arm.drives.gain);
        let noise = &self.scenario.sensing.torque_noise;
        let paper = |weights| {
            let blocks: Vec<_> = experiments.iter().map(|e| paper_rows(e, arm.regressor, gain, noise)).collect();
            let periodic: Vec<bool> = experiments.iter().map(|e| e.period().is_some()).collect();
            let samples: Vec<usize> = experiments.iter().map(SpectralExperiment::len).collect();
            paper_estimate(&blocks, &periodic, &samples, weights).x
        };
        let harmonic = |options: &HarmonicOptions| {
            let levels = NoiseLevels::measured(experiments).unwrap_or_else(|| NoiseLevels {
                position: self.scenario.sensing.position_noise.clone(),
                current: noise.iter().zip(gain).map(|(s, g)| s / g).collect(),
            });
            let mut data = HarmonicData::new(experiments, arm.regressor, gain, &levels, &options.band);
            data.estimate(options).map(|e| e.values().to_vec()).unwrap_or_default()
        };
        match method {
            Method::PaperEqual => paper(PaperWeights::Equal),
            Method::PaperWeighted => paper(PaperWeights::Noise),
            Method::HarmonicPlain => harmonic(&HarmonicOptions::plain()),
            Method::Harmonic => harmonic(&HarmonicOptions::default()),
            Method::FilteredLeastSquares => filtered_least_squares(experiments, arm.regressor, gain, noise),
        }
    }

    /// The errors of several methods over `draws` draws of noise.
    pub fn compare(&self, methods: &[Method], draws: usize, seed: u64, threads: usize) -> Comparison {
        let one = |experiments: &[SpectralExperiment]| -> Vec<Vec<f64>> {
            methods.iter().map(|&m| self.estimate(m, experiments)).collect()
        };
        let found = self.each_draw(draws, seed, threads, one);
        let figures = |m: usize| self.figures(&found.iter().map(|f| f[m].as_slice()).collect::<Vec<_>>());
        Comparison {
            arm: self.arm.name,
            scenario: self.scenario.name,
            experiments: self.experiments.len(),
            draws,
            methods: methods.iter().enumerate().map(|(i, &m)| (m, figures(i))).collect(),
        }
    }

    /// Calls `one` with the experiments of each draw. The results are in the order of the draws.
    pub(crate) fn each_draw<T: Send>(
        &self,
        draws: usize,
        seed: u64,
        threads: usize,
        one: impl Fn(&[SpectralExperiment]) -> T + Sync,
    ) -> Vec<T> {
        each_draw(draws, threads, |draw| one(&self.measured(Some(draw), seed)))
    }

    pub fn figures(&self, estimates: &[&[f64]]) -> Figures {
        let truth = self.arm.truth;
        let (p, count) = (truth.len(), estimates.len() as f64);
        let errors: Vec<Vec<f64>> =
            estimates.iter().map(|x| x.iter().zip(truth).map(|(x, t)| x - t).collect()).collect();
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let over = |f: &dyn Fn(usize) -> f64| (0..p).map(|i| f(i) / self.sigma[i]).collect::<Vec<f64>>();
        let bias = over(&|i| errors.iter().map(|e| e[i]).sum::<f64>() / count);
        let rmse = over(&|i| (errors.iter().map(|e| e[i] * e[i]).sum::<f64>() / count).sqrt());
        let greatest = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let mut relative: Vec<f64> = errors.iter().map(|e| 100.0 * norm(e) / norm(truth)).collect();
        relative.sort_by(f64::total_cmp);
        let form = |g: &[f64], x: &[f64]| {
            let row = |i: usize| x[i] * (0..p).map(|j| g[i * p + j] * x[j]).sum::<f64>();
            (0..p).map(row).sum::<f64>().max(0.0).sqrt()
        };
        let torque = |e: &Vec<f64>| self.validation.iter().map(|g| form(g, e) / form(g, truth)).sum::<f64>();
        let torques = errors.iter().map(torque).sum::<f64>() / (count * self.validation.len() as f64);
        Figures {
            bias: norm(&bias) / (p as f64).sqrt(),
            greatest_bias: greatest(&bias),
            rmse: norm(&rmse) / (p as f64).sqrt(),
            greatest_rmse: greatest(&rmse),
            parameters: relative.get(relative.len() / 2).copied().unwrap_or(f64::NAN),
            torque: 100.0 * torques,
        }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} {}: {} experiments, {} draws", self.arm, self.scenario, self.experiments, self.draws)?;
        writeln!(f, "{:<24} bias/s rms    max | RMSE/s rms    max |    X %  tau %", "method")?;
        for (method, g) in &self.methods {
            write!(f, "{method:<24} {:>10.2} {:>6.1} | ", g.bias, g.greatest_bias)?;
            writeln!(f, "{:>10.2} {:>6.1} | {:>6.3} {:>6.3}", g.rmse, g.greatest_rmse, g.parameters, g.torque)?;
        }
        Ok(())
    }
}

/// Calls `one` for each draw on several threads. The results are in the order of the draws, for any number of threads.
pub fn each_draw<T: Send>(draws: usize, threads: usize, one: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let threads = threads.clamp(1, draws.max(1));
    let of_draw = |d: usize| (d, one(d as u64));
    let mut found: Vec<(usize, T)> = std::thread::scope(|scope| {
        let of_draw = &of_draw;
        let share = |w: usize| move || (w..draws).step_by(threads).map(of_draw).collect::<Vec<_>>();
        let workers: Vec<_> = (0..threads).map(|w| scope.spawn(share(w))).collect();
        workers.into_iter().flat_map(|w| w.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    });
    found.sort_by_key(|f| f.0);
    found.into_iter().map(|f| f.1).collect()
}

/// The motion of a noise-free record in the samples of `windows`. Velocities and accelerations are central differences.
fn cut_motion(record: &Record, windows: &[std::ops::Range<usize>]) -> MeasuredMotion {
    let whole = MeasuredMotion::by_differences(&record.q, record.sample_time);
    let reference = Reference {
        sample_time: record.sample_time,
        q: whole.q,
        dq: whole.dq,
        ddq: whole.ddq,
        windows: windows.to_vec(),
    };
    MeasuredMotion::of_reference(&reference)
}

/// Adds the rows of all samples and moving joints to the information matrix: regressor and four friction columns, divided by the
/// torque noise.
fn add_information(
    information: &mut TriangleBuilder,
    arm: &BenchmarkArm,
    sensing: &Sensors,
    trajectory: &ExcitingTrajectory,
    record: &Record,
) {
    let p = arm.truth.len();
    let mut windows = trajectory.windows();
    let last = record.q[0].len() - 1;
    // The last sample is not used, because the difference quotient takes the first sample as its neighbour.
    windows.iter_mut().for_each(|w| w.end = w.end.min(last));
    let motion = cut_motion(record, &windows);
    let columns = motion.regressor_columns(arm.regressor);
    for j in trajectory.moving() {
        let mut row = vec![0.0; p + 4 * arm.friction.len()];
        for i in 0..motion.len() {
            let w = 1.0 / sensing.torque_noise[j];
            (0..p).for_each(|c| row[c] = w * columns[j][c][i]);
            friction_row(motion.dq[j][i], &mut row[p + 4 * j..p + 4 * j + 4]);
            row[p + 4 * j..p + 4 * j + 4].iter_mut().for_each(|x| *x *= w);
            information.push(&row, 0.0);
        }
    }
}

fn gram(motion: &MeasuredMotion, regressor: &dyn Regressor) -> Vec<f64> {
    let columns = motion.regressor_columns(regressor);
    let p = regressor.parameters().len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    (0..p * p).map(|at| columns.iter().map(|d| dot(&d[at / p], &d[at % p])).sum()).collect()
}
