//! Errors of estimated drive gains over many draws of noise: bias, rms error, and the mean standard deviation that the estimate
//! states.
//!
//! A drive gain is the torque per unit of current. RIST-MH is the estimator in the frequency domain, which estimates gains
//! together with parameters.

use std::fmt;

use crate::benchmark::monte_carlo::{Figures, Fixture};
use identification::estimators::drive_gains::likelihood::{DriveGains, Gain};
use identification::spectrum::experiment::{NoiseLevels, SpectralExperiment};
use identification::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};

/// The errors of the drive gains in one scenario, in % of the gain, one per joint.
#[derive(Clone, Debug)]
pub struct GainComparison {
    pub draws: usize,
    pub bias: Vec<f64>,
    /// Rms error of each gain, %.
    pub rmse: Vec<f64>,
    /// Mean standard deviation that the estimate states, %.
    pub sigma: Vec<f64>,
    /// Errors of the parameters.
    pub parameters: Figures,
}

impl Fixture<'_> {
    /// Estimates the drive gains by RIST-MH with these options, over several draws of noise.
    ///
    /// `None` if some draw gives no gains: the noise cannot be measured, or the scale of the gains is undetermined.
    pub fn compare_gains(
        &self,
        known: &[Gain],
        options: &HarmonicOptions,
        draws: usize,
        seed: u64,
        threads: usize,
    ) -> Option<GainComparison> {
        let truth = &self.arm.drives.gain;
        let one = |experiments: &[SpectralExperiment]| -> Option<DriveGains> {
            let noise = NoiseLevels::measured(experiments)?;
            let unit = vec![1.0; truth.len()];
            let mut data = HarmonicData::new(experiments, self.arm.regressor, &unit, &noise, &options.band);
            data.estimate_with_gains(known, options).ok().map(|f| f.gains)
        };
        let found: Vec<DriveGains> = self.each_draw(draws, seed, threads, one).into_iter().collect::<Option<_>>()?;
        let mean = |f: &dyn Fn(&DriveGains, usize) -> f64| -> Vec<f64> {
            let of_joint = |j: usize| found.iter().map(|d| f(d, j)).sum::<f64>() / found.len() as f64;
            (0..truth.len()).map(of_joint).collect()
        };
        let error = |d: &DriveGains, j: usize| 100.0 * (d.gain[j] / truth[j] - 1.0);
        let parameters: Vec<&[f64]> = found.iter().map(|d| d.parameters.as_slice()).collect();
        Some(GainComparison {
            draws,
            bias: mean(&error),
            rmse: mean(&|d, j| error(d, j).powi(2)).iter().map(|e| e.sqrt()).collect(),
            sigma: mean(&|d, j| 100.0 * d.gain_deviation[j] / truth[j]),
            parameters: self.figures(&parameters),
        })
    }
}

impl fmt::Display for GainComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |x: &[f64]| x.iter().map(|x| format!("{x:>7.3}")).collect::<String>();
        write!(f, "bias %{}  RMSE %{}  sigma %{}", list(&self.bias), list(&self.rmse), list(&self.sigma))?;
        write!(f, "  X % {:.3}  tau % {:.3}", self.parameters.parameters, self.parameters.torque)
    }
}
