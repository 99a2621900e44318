//! Spectra of one joint in one experiment: every harmonic up to a cut-off, both quadratures.
//!
//! The record is averaged over its whole periods. At f_h = h f_P, h = 0 .. H,
//!
//! (cos x / sinc x) D_j(f_h) X + (cos x / sinc^2 x) G_j(f_h) = exp(2 pi i f_h delay) tau_j(f_h)
//!
//! is two real rows (one at h = 0). x = pi f_h h_s, h_s the sample time, sinc x = sin x / x. The torque
//! held over each sample has the spectrum of its samples times sinc x; the recorded mean of two neighbours
//! (`simulate::closed_loop`) has cos x; and G is a mean over the cell (`model::friction::periodic`).
//!
//! Fourier coefficients c_h = mean of x exp(-2 pi i h t/T) have Re and Im of variance sigma^2/(2N)
//! for N samples recorded; the row h = 0 is divided by sqrt 2 to have the same variance. Noise of the
//! position adds (sum_l A_jl^2 sigma_q,l^2) (2 pi f_h)^4 through the acceleration.

use crate::algebra::fourier::{Bins, Complex, harmonic_derivatives};
use crate::experiments::measured_motion::MeasuredMotion;
use crate::model::friction::periodic::FrictionShape;
use crate::model::regressor::Regressor;
use crate::spectrum::experiment::{NoiseLevels, SpectralExperiment, folded};

/// The rows of one joint in one experiment, friction apart.
#[derive(Clone, Debug)]
pub struct JointSpectrum {
    /// Index of the experiment.
    pub experiment: usize,
    /// Index of the coordinate.
    pub joint: usize,
    /// Frequency of each row, Hz.
    pub frequency: Vec<f64>,
    /// `rows[r]`: p coefficients, N m per unit.
    pub rows: Vec<Vec<f64>>,
    /// Torque of a known load in each row, N m.
    pub known: Vec<f64>,
    /// Right-hand sides, in the unit of the current.
    pub current: Vec<f64>,
    /// Contribution of the load to the parameters; empty without one.
    load: Vec<f64>,
    /// Number of samples recorded.
    pub samples: usize,
    /// `[l][c]`: dY_j/dddq_l at the centre of the motion, per unit of parameter c: how position noise of joint l
    /// becomes torque noise.
    pub acceleration: Vec<Vec<f64>>,
    bins: Bins,
    sample_time: f64,
    /// Velocity, acceleration and current over one mean period: rad/s, rad/s^2, the unit of the current.
    dq: Vec<f64>,
    ddq: Vec<f64>,
    drive: Vec<f64>,
}

/// The harmonics that are used, and those of the motion that are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Highest frequency that gives equations, Hz.
    pub equations: f64,
    /// Highest frequency kept of the motion, Hz.
    pub motion: f64,
    /// Delay of the recorded current behind the position, s.
    pub delay: f64,
}

impl Default for Band {
    fn default() -> Band {
        Band { equations: 20.0, motion: 40.0, delay: 0.0 }
    }
}

/// The spectra of the moving joints of a periodic experiment; none for a sweep.
pub fn joint_spectra(
    index: usize,
    experiment: &SpectralExperiment,
    regressor: &dyn Regressor,
    band: &Band,
) -> Vec<JointSpectrum> {
    let Some(period) = experiment.period() else { return vec![] };
    let h = experiment.trajectory.sample_time;
    let seconds = period as f64 * h;
    // 1e-9 forgives a product that is an integer but for rounding.
    let harmonics = |f: f64| ((f * seconds + 1e-9) as usize).min(period.saturating_sub(1) / 2);
    let highest = harmonics(band.equations);
    let motion =
        MeasuredMotion::by_harmonics(&folded(&experiment.q, period), h, harmonics(band.motion.max(band.equations)));
    let current = folded(&experiment.current, period);
    let columns = motion.regressor_columns(regressor);
    let bins = Bins::new(period);
    let coefficient = |x: &[f64], k: usize| bins.of(x, k) / period as f64;
    let acceleration = acceleration_columns(regressor, &experiment.trajectory.centre);
    let mut spectra = Vec::new();
    for j in experiment.trajectory.moving() {
        let mut s = JointSpectrum {
            experiment: index,
            joint: j,
            frequency: vec![],
            rows: vec![],
            known: vec![],
            current: vec![],
            load: experiment.load.clone(),
            samples: experiment.len(),
            acceleration: acceleration[j].clone(),
            bins: bins.clone(),
            sample_time: h,
            dq: motion.dq[j].clone(),
            ddq: motion.ddq[j].clone(),
            drive: harmonic_derivatives(&current[j], h, harmonics(band.motion))[0].clone(),
        };
        for k in 0..=highest {
            let f = k as f64 / seconds;
            let turn = Complex::cis(std::f64::consts::TAU * f * band.delay);
            let d: Vec<Complex<f64>> = columns[j].iter().map(|c| coefficient(c, k) * hold(f * h, 1)).collect();
            s.push(f, &d, coefficient(&current[j], k) * turn);
        }
        spectra.push(s);
    }
    spectra
}

impl JointSpectrum {
    fn push(&mut self, f: f64, d: &[Complex<f64>], current: Complex<f64>) {
        let mut quadrature = |part: &dyn Fn(&Complex<f64>) -> f64| {
            self.frequency.push(f);
            let row: Vec<f64> = d.iter().map(part).collect();
            self.known.push(row.iter().zip(&self.load).map(|(d, x)| d * x).sum());
            self.rows.push(row);
            self.current.push(part(&current));
        };
        if f == 0.0 {
            quadrature(&|c| c.re * std::f64::consts::FRAC_1_SQRT_2);
        } else {
            quadrature(&|c| c.re);
            quadrature(&|c| c.im);
        }
    }

    /// Rows of the friction columns, in the order of `rows`. `gain`: N m per unit of current.
    pub fn friction_rows(&self, shape: &FrictionShape, gain: f64) -> Vec<Vec<f64>> {
        let drive: Vec<f64> = self.drive.iter().map(|c| c * gain).collect();
        let columns = shape.fill(&self.dq, &self.ddq, &drive, self.sample_time);
        let count = self.dq.len() as f64;
        let period = count * self.sample_time;
        let mut rows = Vec::with_capacity(self.rows.len());
        let mut harmonic = usize::MAX;
        let mut at: Vec<Complex<f64>> = vec![];
        for &f in &self.frequency {
            let k = (f * period).round() as usize;
            let second = k == harmonic;
            if !second {
                let held = hold(f * self.sample_time, 2);
                at = columns.iter().map(|c| self.bins.of(c, k) / count * held).collect();
                harmonic = k;
            }
            rows.push(match (k, second) {
                (0, _) => at.iter().map(|c| c.re * std::f64::consts::FRAC_1_SQRT_2).collect(),
                (_, false) => at.iter().map(|c| c.re).collect(),
                (_, true) => at.iter().map(|c| c.im).collect(),
            });
        }
        rows
    }

    /// d current / d delay of each row, per second: a turn of every coefficient.
    pub fn delay_column(&self) -> Vec<f64> {
        let mut column = vec![0.0; self.current.len()];
        for r in 1..column.len() {
            // 2 pi i f c: the real row loses w Im, the imaginary row gains w Re.
            let w = std::f64::consts::TAU * self.frequency[r];
            column[r] = if r % 2 == 1 { -w * self.current[r + 1] } else { w * self.current[r - 1] };
        }
        column
    }

    /// Columns for a motion that does not end as it began. The two unknowns are the jumps of the velocity and of the
    /// position from the end of the record to its start, as this joint feels them through the inertia. A jump of the
    /// momentum is the same at all frequencies; one of the position grows with i f.
    pub fn end_columns(&self) -> Vec<[f64; 2]> {
        let count = self.frequency.len();
        (0..count)
            .map(|r| match r {
                0 => [std::f64::consts::FRAC_1_SQRT_2, 0.0],
                r if r % 2 == 1 => [1.0, 0.0],
                r => [0.0, self.frequency[r]],
            })
            .collect()
    }

    /// Standard deviation of each row, N m. `parameters` (where known) turn the noise of the position
    /// into torque; without them only the torque's own noise counts.
    pub fn deviation(&self, noise: &NoiseLevels, gain: f64, parameters: Option<&[f64]>) -> Vec<f64> {
        let torque = noise.current[self.joint] * gain;
        let per_acceleration: f64 = parameters.map_or(0.0, |x| {
            let along = |y: &Vec<f64>, x: &[f64]| y.iter().zip(x).map(|(y, x)| y * x).sum::<f64>();
            let inertia = |y: &Vec<f64>| along(y, x) + along(y, &self.load);
            self.acceleration.iter().zip(&noise.position).map(|(y, s)| (inertia(y) * s).powi(2)).sum()
        });
        let variance = |f: &f64| torque * torque + per_acceleration * (std::f64::consts::TAU * f).powi(4);
        self.frequency.iter().map(|f| (variance(f) / (2.0 * self.samples as f64)).sqrt()).collect()
    }
}

/// cos x / sinc^power x for x = pi `cycles`, `cycles` a sample.
fn hold(cycles: f64, power: i32) -> f64 {
    let x = std::f64::consts::PI * cycles;
    if x.abs() < 1e-8 { 1.0 } else { x.cos() * (x / x.sin()).powi(power) }
}

/// `[j][l][c]`: row j, parameter c of Y(q, 0, e_l) - Y(q, 0, 0).
fn acceleration_columns(regressor: &dyn Regressor, q: &[f64]) -> Vec<Vec<Vec<f64>>> {
    let (n, p) = (q.len(), regressor.parameters().len());
    let (zero, mut unit) = (vec![0.0; n], vec![0.0; n]);
    let (mut still, mut y) = (vec![0.0; n * p], vec![0.0; n * p]);
    regressor.fill(q, &zero, &zero, &mut still);
    let mut columns = vec![vec![vec![0.0; p]; n]; n];
    for l in 0..n {
        unit[l] = 1.0;
        regressor.fill(q, &zero, &unit, &mut y);
        unit[l] = 0.0;
        for j in 0..n {
            for c in 0..p {
                columns[j][l][c] = y[j * p + c] - still[j * p + c];
            }
        }
    }
    columns
}
