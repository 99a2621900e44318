//! From the records of a plan to an estimate: the paper's rows or RIST-MH, gains known or not.
//!
//! With one gain known the others are estimated with the parameters from the currents
//! (`drive_gains`), and everything stands on that one gain. A parameter whose interval contains zero is
//! said to be not significant; one that the rows do not determine has no value.

use crate::Error;
use crate::drive_gains::{GainEstimate, JointEquations, maximum_likelihood, without_nuisance};
use crate::estimate::{Estimate, Identified, JointResidual, Status};
use crate::experiment_plan::ModelReference;
use crate::friction::label;
use crate::friction_columns::FrictionShape;
use crate::harmonic_estimation::{HarmonicData, HarmonicEstimate, HarmonicOptions};
use crate::observation::unit_of_inertial;
use crate::paper_estimation::{PaperWeights, paper_estimate, paper_rows};
use crate::regressor::Regressor;
use crate::spectral_experiment::{NoiseLevels, SpectralExperiment};

/// Which equations are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpectralMethod {
    /// One harmonic, one quadrature, no friction.
    Paper,
    /// All harmonics, friction as nuisance.
    Harmonic,
}

/// What is known of the drives.
#[derive(Clone, Debug, PartialEq)]
pub enum Gains {
    /// N m per unit of the records, one a coordinate; one where they are torques.
    Known(Vec<f64>),
    /// That of one coordinate.
    Reference { joint: usize, gain: f64 },
}

/// The parameters from the experiments of one robot.
///
/// Fails without a periodic experiment of two periods: nothing tells the noise.
pub fn identify_spectrum(
    model: &ModelReference,
    regressor: &dyn Regressor,
    experiments: &[SpectralExperiment],
    method: SpectralMethod,
    gains: &Gains,
    options: &HarmonicOptions,
) -> Result<Estimate, Error> {
    let Some(noise) = NoiseLevels::measured(experiments) else {
        return Err(Error::new("no experiment has two whole periods: the noise cannot be measured from their scatter"));
    };
    let mut estimate = Estimate {
        model: model.name.clone(),
        fingerprint: model.fingerprint.clone(),
        method: match method {
            SpectralMethod::Paper => "rist: rows of Sp, weighted by their noise".into(),
            SpectralMethod::Harmonic => "rist-mh: all harmonics, friction as nuisance".into(),
        },
        rows: 0,
        cutoff: options.band.equations,
        ..Estimate::default()
    };
    match gains {
        Gains::Known(gain) => match method {
            SpectralMethod::Paper => with_paper_rows(&mut estimate, regressor, experiments, gain, &noise),
            SpectralMethod::Harmonic => with_harmonics(&mut estimate, regressor, experiments, gain, &noise, options)?,
        },
        Gains::Reference { joint, gain } => {
            let one = vec![1.0; regressor.coordinates().len()];
            let equations = match method {
                SpectralMethod::Paper => paper_equations(regressor, experiments, &noise),
                SpectralMethod::Harmonic => {
                    let data = HarmonicData::new(experiments, regressor, &one, &noise, &options.band);
                    data.current_equations(&FrictionShape::ASYMMETRIC)
                }
            };
            let found = maximum_likelihood(&equations, regressor.parameters().len(), *joint, *gain);
            with_gains(&mut estimate, regressor, &found, *joint);
            estimate.rows = equations.iter().map(|e| e.rows.len()).sum();
            let row = |j: usize| {
                let e = &equations[j];
                e.rows.iter().cloned().zip(e.current.iter().map(|i| i * found.gain[j])).collect()
            };
            residuals(&mut estimate, regressor, &found.parameters, row);
        }
    }
    Ok(estimate)
}

fn identified(name: String, unit: &str, value: f64, sigma: f64, determined: bool) -> Identified {
    let relative = 100.0 * sigma / value.abs();
    Identified {
        name,
        unit: unit.into(),
        value: determined.then_some(value),
        sigma: determined.then_some(sigma),
        robust_sigma: None,
        relative_sigma: (determined && relative.is_finite()).then_some(relative),
        status: match determined {
            false => Status::NotIdentifiable,
            true if value.abs() <= 1.96 * sigma => Status::NotSignificant,
            true => Status::Identified,
        },
    }
}

fn remark_unidentifiable(estimate: &mut Estimate) {
    let lost: Vec<&str> = estimate.parameters.iter().filter(|p| p.value.is_none()).map(|p| p.name.as_str()).collect();
    if !lost.is_empty() {
        let remark = format!("not identifiable from these experiments (infinite interval): {}", lost.join(" "));
        estimate.remarks.push(remark);
    }
}

fn with_paper_rows(
    estimate: &mut Estimate,
    regressor: &dyn Regressor,
    experiments: &[SpectralExperiment],
    gain: &[f64],
    noise: &NoiseLevels,
) {
    let torque_noise = noise.torque(gain);
    let blocks: Vec<_> = experiments.iter().map(|e| paper_rows(e, regressor, gain, &torque_noise)).collect();
    let periodic: Vec<bool> = experiments.iter().map(|e| e.period().is_some()).collect();
    let samples: Vec<usize> = experiments.iter().map(SpectralExperiment::len).collect();
    let solution = paper_estimate(&blocks, &periodic, &samples, PaperWeights::Noise);
    estimate.rows = blocks.iter().map(|b| b.right.len()).sum();
    // Friction that leaks into the rows shows in their residual: it widens the intervals.
    let scale = if estimate.rows > solution.rank { solution.variance.max(1.0) } else { 1.0 };
    for (i, name) in regressor.parameters().iter().enumerate() {
        let sigma = (scale * solution.inverse[(i, i)].max(0.0)).sqrt();
        let unit = unit_of_inertial(name);
        estimate.parameters.push(identified(name.clone(), unit, solution.x[i], sigma, solution.determined[i]));
    }
    estimate.rank = solution.rank;
    estimate.condition_number = solution.condition_number;
    let rows = || blocks.iter().flat_map(|b| b.rows.iter().zip(b.right.iter().zip(&b.joint)));
    let at = |joint: usize| rows().filter(move |(_, (_, j))| **j == joint).map(|(d, (y, _))| (d.to_vec(), *y));
    residuals(estimate, regressor, &solution.x, |j| at(j).collect());
    estimate.remarks.push("friction is not estimated: the rows are meant to be orthogonal to it".into());
    remark_unidentifiable(estimate);
}

fn with_harmonics(
    estimate: &mut Estimate,
    regressor: &dyn Regressor,
    experiments: &[SpectralExperiment],
    gain: &[f64],
    noise: &NoiseLevels,
    options: &HarmonicOptions,
) -> Result<(), Error> {
    let data = HarmonicData::new(experiments, regressor, gain, noise, &options.band);
    let found = data.estimate(options).ok_or_else(|| Error::new("the experiments give no equation"))?;
    let p = found.parameters;
    let sigma = |i: usize| found.solution.inverse[(i, i)].max(0.0).sqrt();
    let value = |i: usize| (found.solution.x[i], sigma(i), found.solution.determined[i]);
    for (i, name) in regressor.parameters().iter().enumerate() {
        let (x, s, determined) = value(i);
        estimate.parameters.push(identified(name.clone(), unit_of_inertial(name), x, s, determined));
    }
    for (j, coordinate) in regressor.coordinates().iter().enumerate() {
        for (c, (letters, unit)) in found.shape.names().into_iter().enumerate() {
            let (x, s, determined) = value(p + j * found.shape.columns() + c);
            estimate.parameters.push(identified(format!("{letters}{}", label(coordinate)), unit, x, s, determined));
        }
    }
    estimate.rank = found.solution.rank;
    estimate.condition_number = found.solution.condition_number;
    estimate.rows = data.spectra().iter().map(|s| s.rows.len()).sum();
    harmonic_residuals(estimate, regressor, &data, &found, gain);
    estimate.remarks.push(describe(&found));
    remark_unidentifiable(estimate);
    Ok(())
}

fn describe(found: &HarmonicEstimate) -> String {
    let mut text = format!("friction of equation (5), its sign turning over {} rad/s", found.shape.rest_velocity);
    if found.shape.load {
        text.push_str(", growing with the load");
    }
    if let Some(speed) = found.shape.stribeck {
        text.push_str(&format!(", with a Stribeck term at {speed} rad/s"));
    }
    if found.drift_spread > 0.0 {
        text.push_str(&format!(", drifting by {:.1} % between experiments", 100.0 * found.drift_spread));
    }
    text
}

fn with_gains(estimate: &mut Estimate, regressor: &dyn Regressor, found: &GainEstimate, reference: usize) {
    for (i, name) in regressor.parameters().iter().enumerate() {
        let (x, s) = (found.parameters[i], found.deviation[i]);
        estimate.parameters.push(identified(name.clone(), unit_of_inertial(name), x, s, found.determined[i]));
    }
    for (j, coordinate) in regressor.coordinates().iter().enumerate() {
        let name = format!("KT{}", label(coordinate));
        estimate.parameters.push(identified(name, "N m/A", found.gain[j], found.gain_deviation[j], true));
    }
    estimate.rank = found.determined.iter().filter(|d| **d).count() + found.gain.len();
    estimate.condition_number = found.condition_number;
    let coordinate = &regressor.coordinates()[reference];
    estimate.remarks.push(format!(
        "all of it stands on the gain of {coordinate}, {} N m/A: if that is wrong by a factor, everything is",
        found.gain[reference]
    ));
    if found.steps.is_none() {
        estimate.remarks.push("the gains did not converge".into());
    }
    remark_unidentifiable(estimate);
}

fn paper_equations(
    regressor: &dyn Regressor,
    experiments: &[SpectralExperiment],
    noise: &NoiseLevels,
) -> Vec<JointEquations> {
    let n = regressor.coordinates().len();
    let one = vec![1.0; n];
    let blocks: Vec<_> = experiments.iter().map(|e| paper_rows(e, regressor, &one, &noise.current)).collect();
    let of_joint = |j: usize| {
        let (mut rows, mut current) = (vec![], vec![]);
        for b in &blocks {
            for (i, d) in b.rows.iter().enumerate().filter(|(i, _)| b.joint[*i] == j) {
                rows.push(d.iter().map(|d| d / b.deviation[i]).collect());
                current.push(b.right[i] / b.deviation[i]);
            }
        }
        without_nuisance(&rows, &current, 0, false)
    };
    (0..n).map(of_joint).collect()
}

/// What parameters leave of the rows of each joint, which are N m (over the noise of the joint where its rows
/// are so weighted).
fn residuals(
    estimate: &mut Estimate,
    regressor: &dyn Regressor,
    x: &[f64],
    rows: impl Fn(usize) -> Vec<(Vec<f64>, f64)>,
) {
    let (mut all, mut all_left) = (0.0, 0.0);
    for (j, coordinate) in regressor.coordinates().iter().enumerate() {
        let rows = rows(j);
        let model = |d: &[f64]| d.iter().zip(x).map(|(d, x)| d * x).sum::<f64>();
        let total: f64 = rows.iter().map(|(_, y)| y * y).sum();
        let left: f64 = rows.iter().map(|(d, y)| (y - model(d)).powi(2)).sum();
        all += total;
        all_left += left;
        estimate.joints.push(JointResidual {
            coordinate: coordinate.clone(),
            rms: (left / rows.len().max(1) as f64).sqrt(),
            relative: if total > 0.0 { (left / total).sqrt() } else { 0.0 },
            rows: rows.len(),
            ..JointResidual::default()
        });
    }
    estimate.total = if all > 0.0 { (all_left / all).sqrt() } else { 0.0 };
}

fn harmonic_residuals(
    estimate: &mut Estimate,
    regressor: &dyn Regressor,
    data: &HarmonicData,
    found: &HarmonicEstimate,
    gain: &[f64],
) {
    let drift = |e: usize| found.drift.get(e).map_or(1.0, |d| 1.0 + d.2);
    let mut rows: Vec<Vec<(Vec<f64>, f64)>> = vec![vec![]; gain.len()];
    for (e, s) in data.spectra().iter().enumerate() {
        let friction = s.friction_rows(&found.shape, gain[s.joint]);
        for r in 0..s.rows.len() {
            let f: f64 = friction[r].iter().zip(found.friction(s.joint)).map(|(c, f)| c * f).sum();
            rows[s.joint].push((s.rows[r].clone(), gain[s.joint] * s.current[r] - drift(e) * f));
        }
    }
    residuals(estimate, regressor, found.values(), |j| rows[j].clone());
}
