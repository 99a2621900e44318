//! Drive gains from logs of motor currents: the equations of `drive_gains` from filtered samples.
//!
//! The equations of a joint are its triangle with currents on the right-hand side. Residuals of logs stay the same
//! for a while: n samples count as n/s, s = (1 + rho) / (1 - rho), rho their correlation from sample to sample.
//!
//! Other joints hardly feel what wrist joints carry: the gains of wrists are weakly observable, and errors of the model
//! decide them. An expected value with its deviation holds them; it is weighed against the discounted data.

use logs::{Effort, Error, LogSource};

use crate::algebra::triangle::Triangle;
use crate::estimate::options::Options;
use crate::estimators::correlated_deviation::correlation;
use crate::estimators::drive_gains::equations::{JointEquations, Scatter};
use crate::estimators::drive_gains::likelihood::{DriveGains, Gain, drive_gains};
use crate::estimators::weighted::{Weights, fit};
use crate::model::linear_model::Model;
use crate::model::regressor::Regressor;
use crate::rows::observation::Observation;
use crate::signals::records::{Records, SourceRecords};

/// Gains from logs of motor currents. `known` says which gains are known, `options` everything else.
///
/// The noise of the answer is in A and contains the discount of correlated samples. Fails as `identify` does, for logs
/// without currents, and as [`drive_gains`] does.
pub fn estimate_drive_gains(
    regressor: &dyn Regressor,
    logs: &[LogSource],
    options: &Options,
    known: &[Gain],
) -> Result<DriveGains, Error> {
    if let Some(log) = logs.iter().find(|l| l.effort_is() != Effort::Current) {
        return Err(Error::at(&log.name(), 0, "the log holds torques; drive gains are estimated from currents"));
    }
    let mut options = options.clone();
    options.transmission.drive_gains = Some(vec![1.0; regressor.coordinates().len()]);
    let couplings = options.transmission.coupled();
    let model = Model::new(regressor, &options.friction, &couplings);
    let records = SourceRecords::new(regressor, logs, &options.preparation())?;
    let joints = Observation::of_records(&model, &records, None)?.joints(|_| true);
    let (currents, _) = fit(&joints, Weights::Joint);
    let mut rho = 0.0f64;
    records.each(&mut |states| rho = rho.max(correlation(&model, states, &currents.x)))?;
    let rho = rho.min(0.999);
    drive_gains(&equations(&joints, (1.0 + rho) / (1.0 - rho)), known)
}

/// Triangles by joint as equations; `discount` samples count as one.
fn equations(joints: &[Triangle], discount: f64) -> Vec<JointEquations> {
    let of_joint = |t: &Triangle| {
        let p = t.columns();
        let row = |i: usize| (0..p).map(|c| if c >= i { t.at(i, c) } else { 0.0 }).collect();
        JointEquations {
            rows: (0..p).map(row).collect(),
            known: vec![0.0; p],
            current: (0..p).map(|i| t.at(i, p)).collect(),
            scatter: Some(Scatter { left: t.at(p, p).powi(2), equations: t.rows.max(1) as f64 / discount.max(1.0) }),
        }
    };
    joints.iter().map(of_joint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::random::Random;
    use crate::algebra::triangle::TriangleBuilder;

    /// Two joints that share two parameters, currents with noise.
    fn joints(noise: f64, seed: u64) -> Vec<Triangle> {
        let (x, k) = ([2.0, -1.0], [3.0, 0.5]);
        let mut random = Random::new(seed);
        let joint = |k: f64| {
            let mut rows = TriangleBuilder::new(2);
            for _ in 0..500 {
                let row = [random.normal(), random.normal()];
                let torque = row[0] * x[0] + row[1] * x[1];
                rows.push(&row, torque / k + noise * random.normal());
            }
            rows.finish()
        };
        k.map(joint).to_vec()
    }

    #[test]
    fn gains_come_back_exactly_without_noise() {
        let found = drive_gains(&equations(&joints(0.0, 1), 1.0), &[Gain::Known(3.0), Gain::Free]).unwrap();
        assert!((found.gain[1] - 0.5).abs() < 1e-10, "{found:?}");
        assert!((found.parameters[0] - 2.0).abs() < 1e-10);
    }

    /// Noise of a third of the current: least squares in torque is 10 % low, maximum likelihood is not.
    #[test]
    fn noise_does_not_shrink_the_gain() {
        let runs = 60;
        let (mut mean, mut chi) = (0.0, 0.0);
        for seed in 0..runs {
            let found =
                drive_gains(&equations(&joints(1.5, 100 + seed), 1.0), &[Gain::Known(3.0), Gain::Free]).unwrap();
            mean += found.gain[1] / runs as f64;
            chi += ((found.gain[1] - 0.5) / found.gain_deviation[1]).powi(2) / runs as f64;
        }
        // The standard error of the mean is about 0.006.
        assert!((mean - 0.5).abs() < 0.02, "{mean}");
        assert!((0.5..1.7).contains(&chi), "{chi}");
    }

    /// With hardly any data the expected value stays; with good data it gives way.
    #[test]
    fn an_expected_gain_is_weighed_against_the_data() {
        let expected = [Gain::Known(3.0), Gain::Expected(0.8, 0.1)];
        let weak = drive_gains(&equations(&joints(0.1, 3), 1e9), &expected).unwrap();
        assert!((weak.gain[1] - 0.8).abs() < 0.01, "{weak:?}");
        let strong = drive_gains(&equations(&joints(0.01, 3), 1.0), &expected).unwrap();
        assert!((strong.gain[1] - 0.5).abs() < 0.01, "{strong:?}");
    }
}
