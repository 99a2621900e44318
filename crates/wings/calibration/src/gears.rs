//! Tests the scales of joints (gear ratios) that are not fitted. If a scale has a significant error, the fit is repeated with
//! this scale.
//!
//! The estimate of a scale and its standard deviation follow from the derivative of the residuals by the scale, after the part
//! that the fitted parameters explain is projected out. An error of a scale is named as a fault only if errors of the geometry
//! are fitted too, and if the fit of the scale reduces the error on postures that were left out. Without fitted errors of the
//! geometry, a scale might only imitate an error of the geometry.
//!
//! A claim is one statement with its evidence. It "agrees" if no error is found, and then states the smallest error that would
//! have been found; it is "contradicted" if an error is significant.

use claims::{Claim, Figure, Outcome, Remedy, Subject, Topic, Trial, significant};
use identification::estimate::topics::cannot_tell;
use numerics::student::two_sided_quantile;

use crate::fit::{Fit, Fitter};
use crate::folds::{PredictionError, error_of};
use crate::level::Level;
use crate::measurement::Problem;
use crate::parameter::{Parameter, ParameterNames};

/// Topic of claims on the scale of a joint.
pub(crate) const GEAR: Topic = Topic("gear scale");

/// `GEAR_LEVEL`: error probability of the test of all gear scales together. `POWER`: probability with which the test detects
/// an error of the printed size.
const GEAR_LEVEL: f64 = 0.01;
const POWER: f64 = 0.95;
/// A claim that a scale agrees is made only if an error of this size, or a smaller one, would be detected.
const LARGEST_GEAR: f64 = 0.1;
/// Fitted scales must reduce the error on postures left out to this fraction.
const CURED: f64 = 0.8;

/// A gear scale that was tested: the coordinate, its estimate with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TestedGear {
    /// Index of the coordinate.
    coordinate: usize,
    /// Index of the parameter.
    parameter: usize,
    /// Estimate and standard deviation; `None` if the postures do not determine it.
    estimate: Option<(f64, f64)>,
}

/// Scales that were fitted together: parameter, estimate and standard deviation of each, and the error on postures left out.
struct FittedGears {
    all: Vec<(usize, f64, f64)>,
    left_out: PredictionError,
}

/// Tests each gear scale that is not fitted.
fn tested(problem: &Problem, level: &Level) -> Vec<TestedGear> {
    let fit = &level.fit;
    let all: Vec<usize> = (0..problem.postures.len()).collect();
    let fitter = Fitter { problem, active: &fit.active, prior: None, rows: &all };
    let of = |(k, parameter): (usize, &Parameter)| match parameter {
        Parameter::Gear { coordinate } if !fit.active.contains(&k) => {
            Some(TestedGear { coordinate: *coordinate, parameter: k, estimate: fitter.one_more(fit, k) })
        }
        _ => None,
    };
    problem.parameters.iter().enumerate().filter_map(of).collect()
}

/// Fits the scales `gears` too. If the errors of some of these scales are below `limit` standard deviations, the fit is
/// repeated with the other scales.
fn fitted(problem: &Problem, level: &Level, gears: &[usize], limit: f64) -> Option<FittedGears> {
    let with = |gears: &[usize]| {
        let mut active: Vec<usize> = level.fit.active.iter().chain(gears).copied().collect();
        active.sort_unstable();
        active
    };
    let estimate = |fit: &Fit, k: usize| -> Option<(usize, f64, f64)> {
        let place = fit.active.iter().position(|active| *active == k)?;
        let sigma = fit.covariance[(place, place)].max(0.0).sqrt();
        Some((k, fit.unknowns.chain[k - problem.frames()], sigma))
    };
    let (start, noise) = (&level.fit.unknowns, level.fit.noise);
    let mut gears = gears.to_vec();
    // The first round fits all scales, the second only those that were significant in the first. If one of these is no longer
    // significant, there is no result.
    for _ in 0..2 {
        let active = with(&gears);
        let candidate = level.candidate(problem, &active);
        let fit = candidate.chosen(start, noise).0;
        let all: Vec<_> = gears.iter().filter_map(|k| estimate(&fit, *k)).collect();
        let clear: Vec<_> = all.iter().filter(|(_, x, sigma)| x.abs() > limit * sigma).copied().collect();
        if clear.is_empty() {
            return None;
        }
        if clear.len() == gears.len() {
            // Only postures that the fit without these scales uses count, so that the errors of both fits can be compared.
            let each = candidate.left_out(start, noise);
            let left_out = error_of(problem, &each, |r| level.fit.used[r]);
            return Some(FittedGears { all: clear, left_out });
        }
        gears = clear.iter().map(|one| one.0).collect();
    }
    None
}

/// For each gear scale that is not fitted, whether it differs from 1, and the smallest error that would have shown.
pub(crate) fn of_gears(problem: &Problem, names: &ParameterNames, level: &Level) -> Vec<Claim> {
    let gears = tested(problem, level);
    let freedom = level.fit.freedom;
    let limit = two_sided_quantile(GEAR_LEVEL / gears.len().max(1) as f64, freedom);
    let power = limit + two_sided_quantile(2.0 * (1.0 - POWER), freedom);
    let is_off = |gear: &&TestedGear| {
        gear.estimate.is_some_and(|(x, sigma)| power * sigma <= LARGEST_GEAR && x.abs() > limit * sigma)
    };
    let off: Vec<usize> = gears.iter().filter(is_off).map(|gear| gear.parameter).collect();
    let may_be_fault = level.what == "geometry" && !off.is_empty();
    let found = may_be_fault.then(|| fitted(problem, level, &off, limit)).flatten();
    let fault = found.and_then(|found| of_fault(problem, names, level, &found));
    let claim = |gear: &TestedGear| {
        let name = &names.coordinates[gear.coordinate];
        let subject = Subject::of(GEAR, [name]);
        match gear.estimate {
            Some((_, sigma)) if power * sigma > LARGEST_GEAR => {
                let size = significant(100.0 * power * sigma, 2);
                let why = format!("only an error of {size} % of the scale of {name} would show");
                cannot_tell(subject, why, "postures over the whole range of the joint")
            }
            None => {
                cannot_tell(subject, format!("these postures do not determine the scale of {name}"), "more postures")
            }
            Some((value, sigma)) if value.abs() > limit * sigma => {
                let why = format!(
                    "an error of {} +- {} % of the scale of {name} would explain the residuals better, as may other errors",
                    significant(100.0 * value, 3),
                    significant(100.0 * sigma, 2)
                );
                let tells = match level.what {
                    "geometry" => "postures over the whole range of the joint",
                    _ => "a fit of errors of the geometry too ([what=geometry])",
                };
                cannot_tell(subject, why, tells)
            }
            Some((_, sigma)) => {
                Claim::new(subject, Outcome::Agrees { smallest: Figure::new(100.0 * power * sigma, "%") })
            }
        }
    };
    // An error of one scale also disturbs the tests of other scales. So if there is a fault, the scales that were fitted with
    // it get no claims of their own.
    let is_beside = |gear: &&TestedGear| fault.is_none() || !off.contains(&gear.parameter);
    let others: Vec<Claim> = gears.iter().filter(is_beside).map(claim).collect();
    fault.into_iter().chain(others).collect()
}

/// The fault of scales that were fitted, if they reduce the error on postures left out.
fn of_fault(problem: &Problem, names: &ParameterNames, level: &Level, found: &FittedGears) -> Option<Claim> {
    let without = level.left_out_on(problem, &level.fit.used);
    if found.left_out.relative(&without) > CURED {
        return None;
    }
    let name = |k: usize| match problem.parameters[k] {
        Parameter::Gear { coordinate } => names.coordinates[coordinate].clone(),
        _ => String::new(),
    };
    let joints: Vec<String> = found.all.iter().map(|one| name(one.0)).collect();
    let one = |(k, x, sigma): &(usize, f64, f64)| {
        format!("of {} by {} +- {} %", name(*k), significant(100.0 * x, 3), significant(100.0 * sigma, 2))
    };
    let sizes: Vec<String> = found.all.iter().map(one).collect();
    let fault = format!("the scale (gear ratio) is off: {}", sizes.join(", "));
    let remedy = Remedy::new("calibrate", format!("fit the scales too: [gears={}]", joints.join(",")));
    let remedy = remedy.with("gears", format_args!("[{}]", joints.join(", ")));
    let (before, after) = without.compared(&found.left_out);
    let trial = Trial::Tried { quantity: "error on postures left out".into(), before, after };
    Some(Claim::new(Subject::of(GEAR, joints), Outcome::Contradicted { fault, remedy, trial }))
}

#[cfg(test)]
mod tests {
    use claims::Trust;
    use random::Random;

    use super::*;
    use crate::calibrate::{Calibration, calibrate_table};
    use crate::chain::Convention;
    use crate::laws::table;
    use crate::measurement::MeasurementKind;
    use crate::request::{CalibrateRequest, Calibrated};
    use crate::simulated::{arm, measured, problem, truth};
    use crate::zeros_table;

    /// A calibration of an arm whose joint 3 has this error of its scale.
    fn found(scale: f64, what: Calibrated, gears: &[&str]) -> Calibration {
        let (robot, mut random) = (arm(), Random::new(8));
        let problem = problem(&robot, Convention::Dh, MeasurementKind::Pose, 60, &mut random);
        let mut truth = truth(&problem, 0.02, 5e-4, &mut random);
        let place = problem.chain.parameters.iter().position(|p| *p == Parameter::Gear { coordinate: 2 });
        truth.chain[place.unwrap()] = scale;
        let problem = measured(&problem, &truth, [1e-4; 2], &mut random);
        let gears = gears.iter().map(|name| name.to_string()).collect();
        let request = CalibrateRequest { what, gears, ..CalibrateRequest::default() };
        calibrate_table(&robot, &table(&problem, &robot), &request, None).unwrap()
    }

    fn claim(found: &Calibration) -> Option<&Claim> {
        found.verdict.claims.iter().find(|c| *c.subject() == Subject::of(GEAR, ["q3"]))
    }

    /// A correct scale gives the claim "agrees", with the smallest error that would have been detected; an error of this size
    /// is detected. If a wrong scale is fitted, the claim is gone and the scale is found.
    #[test]
    fn a_wrong_scale_is_named_with_its_cure() {
        let right = found(0.0, Calibrated::Geometry, &[]);
        let Some(Outcome::Agrees { smallest }) = claim(&right).map(Claim::outcome) else { panic!("{right}") };
        assert!(smallest.unit == "%" && smallest.value < 0.1, "{right}");
        let shown = found(0.01 * smallest.value, Calibrated::Geometry, &[]);
        assert!(!matches!(claim(&shown).map(Claim::outcome), Some(Outcome::Agrees { .. })), "{shown}");

        let wrong = found(5e-3, Calibrated::Geometry, &[]);
        assert_eq!(wrong.verdict.trust, Trust::No, "{wrong}");
        let Some(Outcome::Contradicted { remedy, .. }) = claim(&wrong).map(Claim::outcome) else { panic!("{wrong}") };
        assert_eq!(remedy.fields, [("gears".into(), "[q3]".into())]);
        let cured = found(5e-3, Calibrated::Geometry, &["q3"]);
        assert_eq!((cured.verdict.trust, claim(&cured)), (Trust::Yes, None), "{cured}");
        let scale = cured.parameters(cured.level()).into_iter().find(|p| p.name == "gear q3").unwrap();
        // The limit is twice the 95 % interval. One draw in 10 000 lies outside.
        assert!((scale.value - 5e-3).abs() < 2.0 * scale.interval && scale.interval < 1e-3, "{cured}");
        let zeros = zeros_table(&cured, cured.level());
        assert!(
            zeros.starts_with("joint,zero,interval,unit,scale,scale_interval\n") && zeros.contains("\nq1,,,rad,,\n"),
            "{zeros}"
        );
        assert!(
            zeros.lines().any(|line| line.starts_with("q3,") && line.contains(&format!(",rad,{}", scale.value))),
            "{zeros}"
        );
    }

    /// If errors of the geometry are not fitted, a scale may imitate them. So the scale is no fault, and the claim says that a
    /// fit of the geometry would decide.
    #[test]
    fn a_scale_without_a_geometry_is_no_fault() {
        let wrong = found(5e-3, Calibrated::Zeros, &[]);
        let text = claim(&wrong).map(ToString::to_string).unwrap_or_default();
        assert!(text.contains("may other errors") && text.contains("[what=geometry]"), "{wrong}");
    }

    #[test]
    fn an_unknown_joint_is_refused() {
        let (robot, mut random) = (arm(), Random::new(8));
        let problem = problem(&robot, Convention::Dh, MeasurementKind::Pose, 20, &mut random);
        let request = CalibrateRequest { gears: vec!["q9".into()], ..CalibrateRequest::default() };
        let refused = calibrate_table(&robot, &table(&problem, &robot), &request, None).err().unwrap().to_string();
        assert_eq!(refused, "[gears]: no joint `q9` moves the measured link; these do: q1, q2, q3, q4, q5, q6");
    }
}
