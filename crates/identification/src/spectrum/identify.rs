//! Identifies parameters from the records of planned experiments, with known or unknown drive gains. The equations are those of
//! [Vandanjon, Gautier, Desbats 1995] (module `paper`) or of RIST-MH (module `rist_mh`).
//!
//! Unknown gains are estimated together with the parameters from the currents (`estimators::drive_gains`). The equations in
//! currents do not determine the common scale of gains and parameters. This scale follows from a known gain or from a known
//! load. A parameter is not significant if its 95 % interval contains zero. A parameter that the rows do not determine has no
//! value.

use experiments::plan::paper_rows::EquationBlock;
use linear_model::parameter::{Parameter, ParameterId};
use linear_model::reference::ModelReference;
use linear_model::regressor::Regressor;
use logs::Error;
use nalgebra::DMatrix;
use numerics::vector::dot;

use crate::estimate::artefact::Estimate;
use crate::estimate::identified::{Deviations, Identified};
use crate::estimate::identify::with_deviations;
use crate::estimate::residuals::{Residuals, Squares};
use crate::estimators::drive_gains::equations::JointEquations;
use crate::estimators::drive_gains::likelihood::{DriveGains, Gain, drive_gains};
use crate::estimators::drive_gains::total_least_squares::{Scaling, gains_by_total_least_squares};
use crate::spectrum::experiment::{NoiseLevels, SpectralExperiment};
use crate::spectrum::paper::{PaperWeights, paper_estimate, paper_rows};
use crate::spectrum::rist_mh::data::{HarmonicData, HarmonicOptions};
use crate::spectrum::rist_mh::search::HarmonicEstimate;
use crate::spectrum::words::{misfit_remarks, size_words};

/// The method of identification from experiments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpectralMethod {
    /// The method of [Vandanjon, Gautier, Desbats 1995] (module `paper`): one row per harmonic, either the real or the
    /// imaginary part of the harmonic; no friction columns.
    Paper,
    /// The rows of `Paper`; the drive gains are estimated by total least squares.
    TotalLeastSquares,
    /// RIST-MH: all harmonics, with friction coefficients as nuisance parameters.
    Harmonic,
}

impl SpectralMethod {
    /// The name of the method, which is written into an estimate.
    fn sentence(self) -> &'static str {
        match self {
            SpectralMethod::Paper => "rist: rows of Sp, weighted by their noise",
            SpectralMethod::TotalLeastSquares => "tls: rows of Sp, drive gains by total least squares",
            SpectralMethod::Harmonic => "rist-mh: all harmonics, friction as nuisance",
        }
    }
}

/// The result of an identification from experiments.
pub struct SpectralFit {
    /// The parameters and their standard deviations.
    pub estimate: Estimate,
    /// Covariance of the base parameters, row by row. The diagonal contains the squares of the standard deviations in
    /// `estimate`.
    pub covariance: Vec<Vec<f64>>,
}

/// Identifies the parameters of a robot from experiments.
///
/// `gains`: one per coordinate, N m per unit of the records; if the records contain torques and no currents, the gains are
/// known and equal 1. Fails without a periodic experiment of two periods, because the noise is then unknown. Fails if
/// [`drive_gains`] fails.
pub fn identify_spectrum(
    model: &ModelReference,
    regressor: &dyn Regressor,
    experiments: &[SpectralExperiment],
    method: SpectralMethod,
    gains: &[Gain],
    options: &HarmonicOptions,
) -> Result<SpectralFit, Error> {
    let Some(noise) = NoiseLevels::measured(experiments) else {
        return Err(Error::new("no experiment has two whole periods: the noise cannot be measured from their scatter"));
    };
    let mut estimate = Estimate {
        model: model.name.clone(),
        fingerprint: Some(model.fingerprint.clone()),
        method: method.sentence().into(),
        rows: 0,
        cutoff: Some(options.band.equations),
        ..Estimate::default()
    };
    let known = |g: &Gain| if let Gain::Known(k) = g { Some(*k) } else { None };
    if let Some(gain) = gains.iter().map(known).collect::<Option<Vec<f64>>>() {
        let inverse = match method {
            SpectralMethod::TotalLeastSquares => {
                return Err(Error::new(
                    "[method=tls] estimates gains of drives, and all of them are known: [method=rist] takes them",
                ));
            }
            SpectralMethod::Paper => with_paper_rows(&mut estimate, regressor, experiments, &gain, &noise),
            SpectralMethod::Harmonic => with_harmonics(&mut estimate, regressor, experiments, &gain, &noise, options)?,
        };
        return Ok(SpectralFit::of(estimate, regressor, &inverse));
    }
    // At least one gain is unknown here. So the rows are computed for currents: all gains are set to 1.
    let one = vec![1.0; regressor.coordinates().len()];
    let inverse = match method {
        SpectralMethod::Paper | SpectralMethod::TotalLeastSquares => {
            let blocks: Vec<_> = experiments.iter().map(|e| paper_rows(e, regressor, &one, &noise.current)).collect();
            estimate.doubts.extend(narrow_by_load(experiments));
            with_paper_gains(&mut estimate, regressor, &blocks, method, gains)?
        }
        SpectralMethod::Harmonic => {
            let mut data = HarmonicData::new(experiments, regressor, &one, &noise, &options.band);
            let found = data.estimate_with_gains(gains, options)?;
            with_gains(&mut estimate, regressor, &found.gains);
            if let Some(friction) = &found.friction {
                inflate_by_gains(&mut estimate, friction);
            }
            if found.rounds.is_none() {
                estimate.remarks.push("the choice of the friction did not settle with the gains".into());
            }
            if let Some(friction) = found.friction {
                harmonic_residuals(&mut estimate, regressor, &data, &friction);
                estimate.remarks.push(describe(&friction, regressor));
                estimate.doubts.extend(drifting(&friction));
                judge(&mut estimate, regressor, &friction);
            }
            found.gains.covariance
        }
    };
    estimate.rows = estimate.joints.iter().map(|j| j.rows).sum();
    estimate.remarks.push(scale(regressor, experiments, gains));
    remark_unidentifiable(&mut estimate);
    Ok(SpectralFit::of(estimate, regressor, &inverse))
}

impl SpectralFit {
    /// Makes the result. The covariance has the correlations of `inverse` and the standard deviations of `estimate`. The first
    /// rows of `inverse` belong to the base parameters.
    fn of(estimate: Estimate, regressor: &dyn Regressor, inverse: &DMatrix<f64>) -> SpectralFit {
        let base = estimate.parameters.iter().take(regressor.parameters().len());
        let sigma: Vec<f64> = base.map(|p| p.sigma.unwrap_or(0.0)).collect();
        SpectralFit { covariance: with_deviations(inverse, &sigma), estimate }
    }
}

/// Adds gains and parameters to an estimate, from rows of the method `paper` with currents as right-hand sides. Returns the
/// covariance of the parameters for white noise. Fails if the equations do not determine the gains.
fn with_paper_gains(
    estimate: &mut Estimate,
    regressor: &dyn Regressor,
    blocks: &[EquationBlock],
    method: SpectralMethod,
    gains: &[Gain],
) -> Result<DMatrix<f64>, Error> {
    let equations = paper_equations(blocks, regressor.coordinates().len());
    let mut found = drive_gains(&equations, gains)?;
    if method == SpectralMethod::TotalLeastSquares {
        (found.gain, found.parameters) = by_total_least_squares(&equations, gains)?;
        estimate.remarks.push(TLS_DEVIATIONS.into());
    }
    with_gains(estimate, regressor, &found);
    paper_residuals(estimate, regressor, blocks, &found.gain, &found.parameters);
    Ok(found.covariance)
}

/// Warning for the user if the gains follow from a known load. In simulations only 55 to 61 % of the 95 % intervals contained the
/// true value, because friction leaks into the rows of the paper.
fn narrow_by_load(experiments: &[SpectralExperiment]) -> Option<String> {
    let is_loaded = experiments.iter().any(|experiment| !experiment.load.is_empty());
    is_loaded
        .then(|| "the intervals of this method are too narrow where a load gives the gains: [method=rist-mh]".into())
}

/// Warning for the user if the estimated friction drifts more than friction does in any drive. Such a drift shows that friction
/// terms explain an effect that the model lacks.
fn drifting(found: &HarmonicEstimate) -> Option<String> {
    let percent = 100.0 * found.drift_spread;
    (found.drift_spread > LARGE_FRICTION_DRIFT).then(|| {
        format!(
            "friction comes out different by {percent:.0} % from experiment to experiment: it takes up something else that \
             the model does not have"
        )
    })
}

/// An estimated parameter with its standard deviation for white noise. White noise is assumed here because the rows of an
/// experiment are few and uncorrelated.
fn identified(parameter: Parameter, value: f64, sigma: f64, determined: bool) -> Identified {
    let unit = parameter.unit();
    match determined {
        true => Identified::new(parameter.id, unit, value, Deviations::white(sigma)),
        false => Identified::unidentifiable(parameter.id, unit, value),
    }
}

/// Makes a parameter that belongs to coordinate j.
fn of_joint(regressor: &dyn Regressor, j: usize, id: ParameterId) -> Parameter {
    Parameter { id, coordinates: vec![j], is_prismatic: regressor.is_prismatic(j) }
}

fn remark_unidentifiable(estimate: &mut Estimate) {
    let lost = estimate.parameters.iter().filter(|p| p.value.is_none());
    let lost: Vec<String> = lost.map(|p| p.id.to_string()).collect();
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
) -> DMatrix<f64> {
    let torque_noise = noise.torque(gain);
    let blocks: Vec<_> = experiments.iter().map(|e| paper_rows(e, regressor, gain, &torque_noise)).collect();
    let periodic: Vec<bool> = experiments.iter().map(|e| e.period().is_some()).collect();
    let samples: Vec<usize> = experiments.iter().map(SpectralExperiment::len).collect();
    let solution = paper_estimate(&blocks, &periodic, &samples, PaperWeights::Noise);
    estimate.rows = blocks.iter().map(|b| b.right.len()).sum();
    // Friction that leaks into the rows raises the residual of the rows. So the standard deviations are inflated.
    let scale = if estimate.rows > solution.rank { solution.variance.max(1.0) } else { 1.0 };
    for (i, base) in regressor.parameters().iter().enumerate() {
        let sigma = (scale * solution.inverse[(i, i)].max(0.0)).sqrt();
        estimate.parameters.push(identified(base.into(), solution.x[i], sigma, solution.determined[i]));
    }
    estimate.rank = solution.rank;
    estimate.condition_number = Some(solution.condition_number);
    let one = vec![1.0; gain.len()];
    paper_residuals(estimate, regressor, &blocks, &one, &solution.x);
    estimate.remarks.push("friction is not estimated: the rows are meant to be orthogonal to it".into());
    remark_unidentifiable(estimate);
    solution.inverse
}

fn with_harmonics(
    estimate: &mut Estimate,
    regressor: &dyn Regressor,
    experiments: &[SpectralExperiment],
    gain: &[f64],
    noise: &NoiseLevels,
    options: &HarmonicOptions,
) -> Result<DMatrix<f64>, Error> {
    let mut data = HarmonicData::new(experiments, regressor, gain, noise, &options.band);
    let found = data.estimate(options).ok_or_else(|| Error::new("the experiments give no equation"))?;
    let mut push = |parameter: Parameter, i: usize| {
        let white = found.solution.inverse[(i, i)].max(0.0).sqrt();
        let one = identified(parameter, found.solution.x[i], white, found.solution.determined[i]);
        // If the model lacks effects, `lacked` (the standard deviation that they cause) is added to the standard deviation.
        estimate.parameters.push(match found.lacked(i) {
            0.0 => one,
            lacked => one.widened_beyond_white(lacked),
        });
    };
    regressor.parameters().iter().enumerate().for_each(|(i, base)| push(base.into(), i));
    for (j, coordinate) in regressor.coordinates().iter().enumerate() {
        for (c, term) in found.shape.parameters().into_iter().enumerate() {
            let parameter = of_joint(regressor, j, ParameterId::friction(term, coordinate));
            push(parameter, found.layout.friction(j).start + c);
        }
    }
    estimate.rank = estimate.parameters.iter().filter(|p| p.value.is_some()).count();
    estimate.condition_number = Some(found.solution.condition_number);
    estimate.rows = data.spectra().iter().map(|s| s.rows.len()).sum();
    harmonic_residuals(estimate, regressor, &data, &found);
    estimate.remarks.push(describe(&found, regressor));
    judge(estimate, regressor, &found);
    remark_unidentifiable(estimate);
    Ok(found.solution.inverse)
}

/// Adds to an estimate chi^2 per degree of freedom with the measured noise, and remarks on the misfit of the model.
fn judge(estimate: &mut Estimate, regressor: &dyn Regressor, found: &HarmonicEstimate) {
    if found.misfit.total.is_finite() {
        estimate.chi_square_per_freedom = Some(found.misfit.total);
        estimate.remarks.extend(misfit_remarks(&found.misfit, found.cause.as_ref(), regressor));
    }
}

/// If the residual is larger than noise explains, inflates the standard deviations of the parameters and of the gains, which
/// [`with_gains`] has written to the estimate in this order.
fn inflate_by_gains(estimate: &mut Estimate, found: &HarmonicEstimate) {
    if found.misfit.by_experiment.is_empty() {
        return;
    }
    let lacked = found.layout.parameters().map(|i| found.lacked(i));
    let all = lacked.chain(found.misfit.gains_by_experiment.iter().copied());
    let parameters = std::mem::take(&mut estimate.parameters);
    estimate.parameters = parameters.into_iter().zip(all).map(|(p, lacked)| p.widened_beyond_white(lacked)).collect();
}

/// Friction that differs by more than this share from experiment to experiment is reported. The friction of a warm drive
/// differs from the friction of the cold drive by less than this share.
const LARGE_FRICTION_DRIFT: f64 = 0.3;

fn describe(found: &HarmonicEstimate, regressor: &dyn Regressor) -> String {
    let mut text = format!("friction of equation (5), its sign turning over {} rad/s", found.shape.rest_velocity);
    if found.shape.load {
        text.push_str(", growing with the load");
    }
    if let Some(speed) = found.shape.stribeck {
        text.push_str(&format!(", with a Stribeck term at {speed} rad/s"));
    }
    let percent = 100.0 * found.drift_spread;
    if found.drift_spread > LARGE_FRICTION_DRIFT {
        text.push_str(&format!(
            ", its columns scaled differently from experiment to experiment, by {percent:.0} %: no friction does that; they \
             take up something else that the model does not have"
        ));
    } else if found.drift_spread > 0.0 {
        text.push_str(&format!(", drifting by {percent:.1} % between experiments"));
    }
    for size in &found.effects {
        text.push_str("; ");
        text.push_str(&size_words(size, regressor, None, true));
    }
    text
}

fn with_gains(estimate: &mut Estimate, regressor: &dyn Regressor, found: &DriveGains) {
    for (i, base) in regressor.parameters().iter().enumerate() {
        let (x, s) = (found.parameters[i], found.deviation[i]);
        estimate.parameters.push(identified(base.into(), x, s, found.determined[i]));
    }
    for (j, coordinate) in regressor.coordinates().iter().enumerate() {
        let parameter = of_joint(regressor, j, ParameterId::drive_gain(coordinate));
        let determined = found.gain_determined[j];
        estimate.parameters.push(identified(parameter, found.gain[j], found.gain_deviation[j], determined));
    }
    let determined = || found.determined.iter().chain(&found.gain_determined);
    estimate.rank = determined().filter(|d| **d).count();
    estimate.condition_number = Some(found.condition_number);
    if found.steps.is_none() {
        estimate.remarks.push("the gains did not converge".into());
    }
}

/// Remark on the standard deviations of total least squares.
const TLS_DEVIATIONS: &str =
    "sigma is computed for the same equations by maximum likelihood; total least squares has none of its own";

/// Gains and parameters by total least squares. Every gain must be known or free.
///
/// Fails if a gain is only expected, or if the equations do not determine the scale.
fn by_total_least_squares(equations: &[JointEquations], gains: &[Gain]) -> Result<(Vec<f64>, Vec<f64>), Error> {
    if gains.iter().any(|gain| matches!(gain, Gain::Expected(..))) {
        return Err(Error::new("[method=tls] takes a gain as known or as free; an expected one needs [method=rist]"));
    }
    let open = "total least squares finds no gains: there are too few equations, or their scale stays open; plan more \
                experiments, or take [method=rist]";
    gains_by_total_least_squares(equations, gains, Scaling::Noise).ok_or_else(|| Error::new(open))
}

/// A sentence for the user if gains are unknown. The sentence names the source of the common scale of gains and parameters:
/// known gains or a load.
fn scale(regressor: &dyn Regressor, experiments: &[SpectralExperiment], gains: &[Gain]) -> String {
    let given = |(c, g): (&String, &Gain)| match g {
        Gain::Known(k) => Some(format!("the gain of {c}, {k} N m/A")),
        Gain::Expected(k, s) => Some(format!("the gain of {c}, expected to be {k} +- {s} N m/A")),
        Gain::Free => None,
    };
    let mut on: Vec<String> = regressor.coordinates().iter().zip(gains).filter_map(given).collect();
    let loaded = experiments.iter().filter(|e| !e.load.is_empty()).count();
    if loaded > 0 {
        on.push(format!("the known load of {loaded} of {} experiments", experiments.len()));
    }
    format!("all of it stands on {}: if that is wrong by a factor, everything is", on.join(", and on "))
}

/// Converts rows in currents into equations of each joint. Each row is divided by its standard deviation. `n`: number of joints.
fn paper_equations(blocks: &[EquationBlock], n: usize) -> Vec<JointEquations> {
    let mut equations = vec![JointEquations::default(); n];
    for b in blocks {
        for (i, d) in b.rows.iter().enumerate() {
            let e = &mut equations[b.joint[i]];
            e.rows.push(d.iter().map(|d| d / b.deviation[i]).collect());
            e.known.push(b.known[i] / b.deviation[i]);
            e.current.push(b.right[i] / b.deviation[i]);
        }
    }
    equations
}

/// Sets the residuals of an estimate from the rows of `blocks` and the parameters `x`. `gain`: N m per unit of the right-hand
/// sides.
fn paper_residuals(
    estimate: &mut Estimate,
    regressor: &dyn Regressor,
    blocks: &[EquationBlock],
    gain: &[f64],
    x: &[f64],
) {
    let mut squares = vec![Squares::default(); gain.len()];
    for b in blocks {
        for (i, d) in b.rows.iter().enumerate() {
            let y = gain[b.joint[i]] * b.right[i] - b.known[i];
            squares[b.joint[i]].add(y, y - dot(d, x));
        }
    }
    let found = Residuals::new(regressor, squares);
    (estimate.joints, estimate.total) = (found.joints, Some(found.total));
}

/// Sets two residuals of each joint in an estimate: the residual of the fit, and the residual of each experiment predicted from
/// the other experiments.
///
/// y = tau - (1 + u) C f - ends - effects is the torque of the bodies. u: drift of friction; C f: friction; ends: torque of the
/// jumps from the end of the record to its start. Drift and ends belong to one experiment, so they keep the values of the fit
/// to all experiments.
fn harmonic_residuals(
    estimate: &mut Estimate,
    regressor: &dyn Regressor,
    data: &HarmonicData,
    found: &HarmonicEstimate,
) {
    let (gain, at) = (&data.gain, &found.layout);
    let mut fitted = vec![Squares::default(); gain.len()];
    let mut predicted = fitted.clone();
    for (e, s) in data.spectra().iter().enumerate() {
        let friction = s.friction_rows(&found.shape, gain[s.joint]);
        let ends = s.end_columns();
        // Two residuals y - D X of each row: from the fit to all experiments, and from the fit without the experiment of the row.
        for r in 0..s.rows.len() {
            let torque = gain[s.joint] * s.current[r] - s.known[r];
            let of_bodies = |x: &[f64]| {
                let drift = x[at.drifts()].get(e).map_or(1.0, |u| 1.0 + u);
                let end = if e < at.ended_spectra { dot(&ends[r], &x[at.ends(e)]) } else { 0.0 };
                let effects = data.effect_rows.get(e).map_or(0.0, |rows| dot(&rows[r], &x[at.effects()]));
                torque - drift * dot(&friction[r], &x[at.friction(s.joint)]) - end - effects
            };
            let left = |x: &[f64]| of_bodies(x) - dot(&s.rows[r], &x[at.parameters()]);
            let all = &found.solution.x;
            fitted[s.joint].add(of_bodies(all), left(all));
            if let Some(others) = found.left_out.get(s.experiment) {
                predicted[s.joint].add(of_bodies(all), left(others));
            }
        }
    }
    let found = Residuals::new(regressor, fitted);
    (estimate.joints, estimate.total) = (found.joints, Some(found.total));
    let is_predicted = predicted.iter().any(|squares| squares.rows > 0);
    estimate.cross_validation = is_predicted.then(|| Residuals::new(regressor, predicted).total);
}
