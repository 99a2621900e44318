//! Estimates drive gains, N m/A, from logs of motor currents.
//!
//! Position errors of servos, rad, are treated like currents; their gain is in N m/rad. The equations of a joint are its
//! triangle (R of QR) with filtered currents on the right-hand side; `estimators::drive_gains` solves them. Residuals are
//! correlated in time and repeat with the state of the robot, so the standard deviations come from the module `replicates`.
//!
//! The bodies that wrist joints move hardly contribute to the torques of other joints. So the gains of wrist joints are weakly
//! identifiable, and model errors dominate them. An expected value with its standard deviation regularises such a gain. The
//! data must not outweigh the expected value only because residuals are correlated. So s correlated equations count as one
//! independent equation. The discount s follows from the residuals.

use std::sync::Arc;

use linear_model::regressor::Regressor;
use logs::{Error, LogSource};
use numerics::triangle::Triangle;

use crate::estimate::options::Options;
use crate::estimators::drive_gains::equations::{JointEquations, NoiseEvidence};
use crate::estimators::drive_gains::likelihood::{DriveGains, Gain, drive_gains};
use crate::estimators::drive_gains::replicates::Replicates;
use crate::estimators::replicate_deviation::ReplicateDeviation;
use crate::estimators::state_bands::StateBands;
use crate::rows::observation::Observation;
use crate::rows::residual_sums::residual_sums;
use crate::signals::records::SourceRecords;

/// Estimates drive gains, N m/A, from logs of motor currents. `known`: prior knowledge of the gain of each joint (known,
/// expected or free).
///
/// The noise in the result is in A, because the equations are in currents. Fails if a log contains torques, and for the
/// reasons of `identify` and of [`drive_gains`].
pub fn estimate_drive_gains(
    regressor: &dyn Regressor,
    logs: &[LogSource],
    options: &Options,
    known: &[Gain],
) -> Result<DriveGains, Error> {
    if let Some(log) = logs.iter().find(|l| !l.effort_is().needs_gains()) {
        return Err(Error::at(&log.name(), 0, "the log holds torques; drive gains are estimated from currents"));
    }
    // With gains of 1 the right-hand sides stay currents, A.
    let mut options = options.clone();
    options.transmission.drive_gains = Some(vec![1.0; regressor.coordinates().len()]);
    let model = options.linear_model(regressor);
    let records = SourceRecords::new(regressor, logs, &options.preparation())?;
    let observation = Observation::of_records(&model, &records, None)?;
    let joints = observation.joints(|_| true);
    // The rows of one band of speed or of position may have a common error. So sums of the rows of each band are computed.
    let bands = StateBands::new(&model, &observation, Arc::new(|_, _| 1.0));
    let bands = residual_sums(&model, &records, &vec![0.0; model.p()], bands)?;
    let replicates = Replicates::of(&model, &observation, bands);
    let equations = equations(&joints);
    // Fixed-point iteration: the discounts s depend on the gains, and the gains on s. The iteration starts with s = 1.
    let mut weighing = vec![1.0; known.len()];
    let mut found = drive_gains(&equations, known)?;
    for _ in 0..WEIGHING_ROUNDS {
        weighing = discounts(&found, known, &weighing, &replicates.deviation(&found, known, &weighing));
        found = drive_gains(&equations, &gains_with_equations(known, &weighing))?;
    }
    // Standard deviations for correlated residuals. For a gain k: sigma(k) = |k| sigma(ln k).
    let deviation = replicates.deviation(&found, known, &weighing).sigma();
    let (parameters, gains) = deviation.split_at(model.p());
    found.deviation = parameters.to_vec();
    let unknown = (0..known.len()).filter(|&j| known[j].is_unknown());
    unknown.zip(gains).for_each(|(j, sigma)| found.gain_deviation[j] = sigma * found.gain[j].abs());
    Ok(found)
}

/// Number of fixed-point iterations of gains and discounts. Several are needed if the data contradict an expected gain,
/// because then each new discount changes the gain and the residuals.
const WEIGHING_ROUNDS: usize = 3;

/// The discount of an expected gain is not updated if the ratio (information of the data / information of the expected value)
/// is below this value, because rounding would dominate.
const LEAST_INFORMATION_RATIO: f64 = 1e-6;

/// Computes the discount s of each expected gain: the number of correlated equations that count as one. The discount of a gain
/// without an expected value is 1. `before`: the discounts s_0 with which `found` was computed.
///
/// For a gain k, let a be the information on ln k in the data (white noise), and b the information of the expected value.
/// Then ln k has the variance v = 1 / (a + b s_0) for white noise, and the variance v^2 (a s + b s_0^2) for correlated
/// residuals. The latter equation gives s.
fn discounts(found: &DriveGains, known: &[Gain], before: &[f64], deviation: &ReplicateDeviation) -> Vec<f64> {
    let (p, sigma) = (found.parameters.len(), deviation.sigma());
    let unknown: Vec<usize> = (0..known.len()).filter(|&j| known[j].is_unknown()).collect();
    let of_gain = |j: usize| {
        let (Gain::Expected(_, expected), Some(at)) = (known[j], unknown.iter().position(|&u| u == j)) else {
            return 1.0;
        };
        let (white, believed) = (deviation.white[p + at].powi(2), sigma[p + at].powi(2));
        let of_expectation = before[j] * (found.gain[j] / expected).powi(2);
        let of_data = 1.0 / white - of_expectation;
        // Below this ratio, the rounding error dominates the quotient.
        if of_data > LEAST_INFORMATION_RATIO * of_expectation {
            ((believed / (white * white) - before[j] * of_expectation) / of_data).max(1.0)
        } else {
            before[j]
        }
    };
    (0..known.len()).map(of_gain).collect()
}

/// The gains, with the standard deviation of each expected gain divided by sqrt(discount). With this division, the expected
/// value has the right weight compared with the equations, because `discounts` correlated equations count as one independent
/// equation.
fn gains_with_equations(known: &[Gain], discounts: &[f64]) -> Vec<Gain> {
    let scaled = |(gain, discount): (&Gain, &f64)| match *gain {
        Gain::Expected(value, deviation) => Gain::Expected(value, deviation / discount.sqrt()),
        Gain::Known(_) | Gain::Free => *gain,
    };
    known.iter().zip(discounts).map(scaled).collect()
}

/// The triangle (R of QR) of each joint as equations with currents, A, on the right-hand side.
fn equations(joints: &[Triangle]) -> Vec<JointEquations> {
    let of_joint = |t: &Triangle| {
        let p = t.columns();
        let row = |i: usize| (0..p).map(|c| if c >= i { t.at(i, c) } else { 0.0 }).collect();
        JointEquations {
            rows: (0..p).map(row).collect(),
            known: vec![0.0; p],
            current: (0..p).map(|i| t.at(i, p)).collect(),
            scatter: Some(NoiseEvidence { left: t.at(p, p).powi(2), equations: t.rows.max(1) as f64 }),
        }
    };
    joints.iter().map(of_joint).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::triangle::TriangleBuilder;
    use random::Random;

    /// Two joints that share two parameters, with noisy currents.
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
        let found = drive_gains(&equations(&joints(0.0, 1)), &[Gain::Known(3.0), Gain::Free]).unwrap();
        assert!((found.gain[1] - 0.5).abs() < 1e-10, "{found:?}");
        assert!((found.parameters[0] - 2.0).abs() < 1e-10);
    }

    /// With hardly any data, the estimated gain equals the expected value. With good data, the estimated gain equals the gain
    /// that follows from the data alone.
    #[test]
    fn an_expected_gain_is_weighed_against_the_data() {
        let expected = [Gain::Known(3.0), Gain::Expected(0.8, 0.1)];
        let weak = drive_gains(&equations(&joints(0.1, 3)), &gains_with_equations(&expected, &[1.0, 1e9])).unwrap();
        assert!((weak.gain[1] - 0.8).abs() < 0.01, "{weak:?}");
        let strong = drive_gains(&equations(&joints(0.01, 3)), &expected).unwrap();
        assert!((strong.gain[1] - 0.5).abs() < 0.01, "{strong:?}");
    }
}
