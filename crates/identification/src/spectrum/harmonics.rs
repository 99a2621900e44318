//! Spectra of one joint in one experiment: the equations at all harmonics up to a cut-off, real and imaginary part.
//!
//! The record is averaged over its whole periods. f_P: fundamental frequency; X: base parameters; D_j: spectra of the regressor
//! columns of joint j; G_j: spectra of its friction columns, which the friction coefficients multiply (they are not written in
//! the equation). At f_h = h f_P, h = 0 .. H,
//!
//! (cos x / sinc x) D_j(f_h) X + (cos x / sinc^2 x) G_j(f_h) = exp(2 pi i f_h delay) tau_j(f_h)
//!
//! is two real rows (one at h = 0). x = pi f_h h_s, h_s: sample time, sinc x = sin x / x. The factors correct the sampling: a
//! torque with zero-order hold has the spectrum of its samples times sinc x; the recorded mean of two neighbouring samples
//! (`experiments::simulate::closed_loop`) has the factor cos x; and G is a mean over the cell of a sample
//! (`linear_model::friction::periodic`).
//!
//! c_h, the mean of s(t) exp(-2 pi i h t/T) over N samples with noise sigma, is a Fourier coefficient of the series s with
//! period T. The real part and the imaginary part of c_h each have the variance sigma^2/(2N). The row h = 0 is divided by sqrt
//! 2, so that its variance is equal. Noise of the position causes acceleration noise, which adds the variance (sum_l A_jl^2
//! sigma_q,l^2) (2 pi f_h)^4 / (2N), A: inertia matrix, sigma_q,l: noise of the position of joint l.

use experiments::plan::measured_motion::MeasuredMotion;
use linear_model::friction::periodic::FrictionShape;
use linear_model::regressor::Regressor;
use numerics::fourier::{Bins, Complex, harmonic_derivatives};

use crate::spectrum::experiment::{NoiseLevels, SpectralExperiment, folded, harmonics};

/// The equations of one joint in one experiment, without friction columns.
#[derive(Clone, Debug)]
pub struct JointSpectrum {
    /// Index of the experiment.
    pub experiment: usize,
    /// Index of the coordinate.
    pub joint: usize,
    /// Frequency of each row, Hz.
    pub frequency: Vec<f64>,
    /// Coefficients of each row, `rows[r]`: p numbers, N m per unit of the parameter.
    pub rows: Vec<Vec<f64>>,
    /// Torque of a known load in each row, N m.
    pub known: Vec<f64>,
    /// Right-hand side of each row, in the unit of the current.
    pub current: Vec<f64>,
    /// Contribution of a known load to the base parameters. Empty without a load.
    pub(crate) load: Vec<f64>,
    /// Number N of recorded samples.
    pub samples: usize,
    /// Derivative of row j of the regressor Y with respect to the acceleration of joint l, at the centre of the motion:
    /// `acceleration[l][c]` for parameter c. This derivative converts position noise of joint l into torque noise.
    pub acceleration: Vec<Vec<f64>>,
    bins: Bins,
    pub(crate) sample_time: f64,
    /// Number of the highest harmonic that the measured motion contains.
    pub(crate) kept: usize,
    /// Position q, velocity, acceleration and current (`drive`) over one mean period: rad, rad/s, rad/s^2, unit of the current.
    q: Vec<f64>,
    dq: Vec<f64>,
    ddq: Vec<f64>,
    pub(crate) drive: Vec<f64>,
}

/// The frequency bands of the equations and of the motion, and the delay of the currents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Highest frequency of the equations, Hz.
    pub equations: f64,
    /// Highest frequency that is kept in the measured motion, Hz.
    pub motion: f64,
    /// Delay of the recorded current relative to the position, s.
    pub delay: f64,
}

impl Default for Band {
    fn default() -> Band {
        Band { equations: 20.0, motion: 40.0, delay: 0.0 }
    }
}

/// The measured motion over the mean period of an experiment, with all harmonics up to the higher limit of `band`. `None` for a
/// sweep.
pub(crate) fn mean_period(experiment: &SpectralExperiment, band: &Band) -> Option<MeasuredMotion> {
    let period = experiment.period()?;
    let h = experiment.trajectory.sample_time;
    let highest = harmonics(band.motion.max(band.equations), period, h);
    Some(MeasuredMotion::by_harmonics(&folded(&experiment.q, period), h, highest))
}

/// The spectra of the moving joints of a periodic experiment. Empty for a sweep. `index`: number of the experiment; `motion`:
/// the [`mean_period`] of the experiment.
pub(crate) fn joint_spectra(
    index: usize,
    experiment: &SpectralExperiment,
    motion: &MeasuredMotion,
    regressor: &dyn Regressor,
    band: &Band,
) -> Vec<JointSpectrum> {
    let Some(period) = experiment.period() else { return vec![] };
    let h = experiment.trajectory.sample_time;
    let seconds = period as f64 * h;
    let highest = harmonics(band.equations, period, h);
    // The currents are averaged over all periods here. The motion is already averaged.
    let current = folded(&experiment.current, period);
    let columns = motion.regressor_columns(regressor);
    let bins = Bins::new(period);
    let acceleration = acceleration_columns(regressor, &experiment.trajectory.centre);
    // Each moving joint has one spectrum. A locked joint has no spectrum, because the friction of a locked joint is not
    // identifiable.
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
            kept: harmonics(band.motion.max(band.equations), period, h),
            q: motion.q[j].clone(),
            dq: motion.dq[j].clone(),
            ddq: motion.ddq[j].clone(),
            drive: harmonic_derivatives(&current[j], h, harmonics(band.motion, period, h))[0].clone(),
        };
        // The right-hand sides exp(2 pi i f_h delay) tau_j(f_h) at every harmonic of the band, as currents.
        for k in 0..=highest {
            let f = k as f64 / seconds;
            let turn = Complex::cis(std::f64::consts::TAU * f * band.delay);
            s.push(f, bins.of(&current[j], k) / period as f64 * turn);
        }
        s.take_columns(&columns[j]);
        spectra.push(s);
    }
    spectra
}

impl JointSpectrum {
    fn push(&mut self, f: f64, current: Complex<f64>) {
        let count = self.frequency.len();
        self.current.extend(quadratures(f, current));
        self.frequency.resize(count + quadratures(f, current).count(), f);
    }

    /// Sets `rows` to the spectra of the regressor columns of this joint. `columns`: values of the columns over one period, N m
    /// per unit.
    pub(crate) fn take_columns(&mut self, columns: &[Vec<f64>]) {
        self.rows = self.rows_of(columns, 1);
        let load = |row: &Vec<f64>| row.iter().zip(&self.load).map(|(d, x)| d * x).sum();
        self.known = self.rows.iter().map(load).collect();
    }

    /// The spectra of series over one period, `[row][series]`, in the order of `rows`. `power`: exponent of sinc in the
    /// correction of the sampling. The exponent is 1 for torques at the sample times, and 2 for means over the cell (one sample
    /// time) around each sample.
    pub(crate) fn rows_of(&self, series: &[Vec<f64>], power: i32) -> Vec<Vec<f64>> {
        self.spectrum_of(series, |f| hold(f * self.sample_time, power))
    }

    fn spectrum_of(&self, series: &[Vec<f64>], factor: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
        let samples = self.dq.len() as f64;
        let period = samples * self.sample_time;
        let mut rows = Vec::with_capacity(self.frequency.len());
        for same in self.frequency.chunk_by(|a, b| a == b) {
            let f = same[0];
            let mut at_f = vec![Vec::with_capacity(series.len()); same.len()];
            for bin in self.bins.of_each(series, (f * period).round() as usize) {
                let quadratures = quadratures(f, bin / samples * factor(f));
                at_f.iter_mut().zip(quadratures).for_each(|(row, x)| row.push(x));
            }
            rows.extend(at_f);
        }
        rows
    }

    /// The friction columns over one mean period, one series each. `gain`: N m per unit of current.
    pub(crate) fn friction_series(&self, shape: &FrictionShape, gain: f64) -> Vec<Vec<f64>> {
        let drive: Vec<f64> = self.drive.iter().map(|c| c * gain).collect();
        shape.fill(&self.dq, &self.ddq, &drive, self.sample_time)
    }

    /// Rows of torque ripple with `periods` per turn of the joint. Four columns: cos and sin of the angle times `periods` (N m
    /// per N m), then minus the torque of the drive times cos and times sin (N m per unit).
    pub(crate) fn ripple_rows(&self, periods: f64, gain: f64) -> Vec<Vec<f64>> {
        let (sin, cos): (Vec<f64>, Vec<f64>) = self.q.iter().map(|q| (periods * q).sin_cos()).unzip();
        let of_torque = |wave: &[f64]| wave.iter().zip(&self.drive).map(|(w, c)| -w * c * gain).collect();
        let shares: Vec<Vec<f64>> = vec![of_torque(&cos), of_torque(&sin)];
        let mut rows = self.rows_of(&[cos, sin], 1);
        // The last two columns are multiples of the recorded torque, so the zero-order hold needs no correction.
        rows.iter_mut().zip(self.spectrum_of(&shares, |_| 1.0)).for_each(|(row, shares)| row.extend(shares));
        rows
    }

    /// Rows of a spring at this joint with a stiffness of 1 N m/rad.
    pub(crate) fn position_rows(&self) -> Vec<Vec<f64>> {
        self.rows_of(std::slice::from_ref(&self.q), 1)
    }

    /// Rows of the friction columns, in the order of `rows`. `gain`: N m per unit of current.
    pub(crate) fn friction_rows(&self, shape: &FrictionShape, gain: f64) -> Vec<Vec<f64>> {
        self.rows_of(&self.friction_series(shape, gain), 2)
    }

    /// The derivative of each right-hand side with respect to the delay, per second. A delay rotates every Fourier coefficient.
    pub(crate) fn delay_column(&self) -> Vec<f64> {
        let mut column = vec![0.0; self.current.len()];
        for r in 1..column.len() {
            // The derivative of a coefficient c is 2 pi i f c: -w Im c in the real row, w Re c in the imaginary row.
            let w = std::f64::consts::TAU * self.frequency[r];
            column[r] = if r % 2 == 1 { -w * self.current[r + 1] } else { w * self.current[r - 1] };
        }
        column
    }

    /// Columns of two unknowns per joint, for a motion that does not end in its initial state. The unknowns are the jump of
    /// velocity and the jump of position from the end of the record to its start, each multiplied by the inertia of the joint.
    /// A jump of velocity has a constant spectrum; a jump of position has a spectrum proportional to i f.
    pub(crate) fn end_columns(&self) -> Vec<[f64; 2]> {
        let count = self.frequency.len();
        (0..count)
            .map(|r| match r {
                0 => [std::f64::consts::FRAC_1_SQRT_2, 0.0],
                r if r % 2 == 1 => [1.0, 0.0],
                r => [0.0, self.frequency[r]],
            })
            .collect()
    }

    /// The diagonal entry of the inertia matrix for this joint at the centre of the motion, kg m^2. The entry includes a known
    /// load.
    pub(crate) fn inertia(&self, parameters: &[f64]) -> f64 {
        self.felt(self.joint, parameters)
    }

    /// The entry of the inertia matrix in the row of this joint and the column of joint l, kg m^2. The entry includes a known
    /// load.
    fn felt(&self, l: usize, parameters: &[f64]) -> f64 {
        let along = |x: &[f64]| self.acceleration[l].iter().zip(x).map(|(y, x)| y * x).sum::<f64>();
        along(parameters) + along(&self.load)
    }

    /// Smallest and largest position of the joint, rad.
    pub(crate) fn range(&self) -> (f64, f64) {
        self.q.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), q| (a.min(*q), b.max(*q)))
    }

    /// The rms velocity of the joint, rad/s.
    pub(crate) fn speed(&self) -> f64 {
        (self.dq.iter().map(|v| v * v).sum::<f64>() / self.dq.len().max(1) as f64).sqrt()
    }

    /// Standard deviation of the right-hand side of each row as torque, N m. `parameters`: base parameters, which convert
    /// position noise into torque noise; `None`: only the noise of the torque counts. `gain`: N m per unit of current.
    pub fn deviation(&self, noise: &NoiseLevels, gain: f64, parameters: Option<&[f64]>) -> Vec<f64> {
        let torque = noise.current[self.joint] * gain;
        let per_acceleration: f64 = parameters
            .map_or(0.0, |x| noise.position.iter().enumerate().map(|(l, s)| (self.felt(l, x) * s).powi(2)).sum());
        let variance = |f: &f64| torque * torque + per_acceleration * (std::f64::consts::TAU * f).powi(4);
        self.frequency.iter().map(|f| (variance(f) / (2.0 * self.samples as f64)).sqrt()).collect()
    }
}

/// If x is below this value, the correction factor of [`hold`] is 1 up to rounding.
const SMALLEST_HOLD_ANGLE: f64 = 1e-8;

/// The rows of a Fourier coefficient c at frequency `f`: its real part and its imaginary part. At frequency zero there is one
/// row: the real part divided by sqrt 2.
fn quadratures(f: f64, c: Complex<f64>) -> impl Iterator<Item = f64> {
    let (first, second) = if f == 0.0 { (c.re * std::f64::consts::FRAC_1_SQRT_2, None) } else { (c.re, Some(c.im)) };
    std::iter::once(first).chain(second)
}

/// The correction factor of the sampling, cos x / sinc^power x with x = pi `cycles`. `cycles`: frequency in cycles per sample.
fn hold(cycles: f64, power: i32) -> f64 {
    let x = std::f64::consts::PI * cycles;
    if x.abs() < SMALLEST_HOLD_ANGLE { 1.0 } else { x.cos() * (x / x.sin()).powi(power) }
}

/// Columns of the regressor per unit of acceleration: `[j][l][c]` is row j, parameter c of Y(q, 0, e_l) - Y(q, 0, 0). e_l: unit
/// acceleration of joint l.
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
