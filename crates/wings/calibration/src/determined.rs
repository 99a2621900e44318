//! Finds out what the postures determine. A parameter is determined if its interval is narrow. Predicted poses are accurate
//! enough if their errors, from the covariance of the parameters, are small at all postures within the joint limits.
//!
//! N: information matrix of the fitted parameters, the inverse of their covariance. More postures with the Jacobian J and the
//! noise s give the information matrix N + J' J / s^2. So the intervals after more postures are known before these postures
//! are measured. A component of a predicted pose with the row j of the Jacobian has the variance j N^-1 j'.
//!
//! Result: claims, each with a remedy, for example a number of further postures. A claim is one statement with its evidence.
//! The spread is the root mean square distance of the measured points from their mean. A prior is a standard deviation that the
//! errors of the geometry are assumed to have. A level is one fit with a certain set of parameters.

use claims::{Claim, Figure, Outcome, Subject, Topic, significant};
use identification::estimate::topics::{PARAMETERS, cannot_tell};
use nalgebra::DMatrix;
use numerics::student::two_sided_quantile;
use robot::Robot;

use crate::base_geometry::{GeometricBase, random_postures};
use crate::fit::inverse;
use crate::folds::components;
use crate::level::Level;
use crate::measurement::{Linearised, Problem, ResidualKind};
use crate::mistakes::{spread, spread_of_links};
use crate::parameter::{Parameter, ParameterGroup, ParameterNames};

/// Lengths at postures that were not measured.
pub(crate) const OTHER_LENGTHS: Topic = Topic("lengths within the limits of the joints");
/// Angles at postures that were not measured.
pub(crate) const OTHER_ANGLES: Topic = Topic("angles within the limits of the joints");

/// A parameter is determined if a change by its 95 % interval turns the robot by at most this angle, rad, or moves it by at
/// most this share of the spread of the measured points. Descriptions have errors of this size.
const WIDE: f64 = 0.02;
/// Largest 95 % interval of a predicted pose, rad, or as a share of the spread of the postures.
const WIDE_POSE: f64 = 0.01;
/// The prior determines a parameter more than the data do if the variance after the fit is larger than this share of the prior
/// variance.
const HELD: f64 = 0.5;
/// Level of the intervals.
const LEVEL: f64 = 0.95;
/// Number of random postures at which poses are predicted.
const ELSEWHERE: usize = 100;
/// Numbers of further postures that are tried.
const FURTHER: [usize; 4] = [10, 30, 100, 300];
/// Joints that move over a smaller share of their range than this are named.
const LITTLE_MOTION: f64 = 0.25;
/// Largest number of names in a sentence.
const NAMES: usize = 6;

/// A fit of a calibration. The methods find out which parameters the postures of this fit determine.
pub(crate) struct Determination<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The postures.
    pub problem: &'a Problem,
    /// The names of the parameters.
    pub names: &'a ParameterNames,
    /// The fit.
    pub level: &'a Level,
}

/// The first names of a list, and the number of the others.
fn listed(names: &[String]) -> String {
    let first = names[..names.len().min(NAMES)].join(", ");
    if names.len() > NAMES { format!("{first} and {} others", names.len() - NAMES) } else { first }
}

/// The advice to measure this number of further postures; `None`: no number suffices.
fn more_postures(count: Option<usize>) -> String {
    match count {
        Some(count) => format!("{count} more postures at random within the limits of the joints"),
        None => "whole poses instead of points or distances, or an instrument with less noise".into(),
    }
}

impl Determination<'_> {
    fn quantile(&self) -> f64 {
        two_sided_quantile(1.0 - LEVEL, self.level.fit.freedom)
    }

    /// The largest motion of the robot by one unit of a parameter, rad (m).
    fn effect(&self, parameter: Parameter) -> f64 {
        let place = |coordinate: usize| self.problem.chain.coordinates.iter().position(|k| *k == coordinate);
        let largest = |of: &dyn Fn(&crate::measurement::Posture) -> f64| {
            self.problem.postures.iter().map(|p| of(p).abs()).fold(0.0, f64::max)
        };
        match parameter {
            Parameter::Gear { coordinate } => place(coordinate).map_or(1.0, |k| largest(&|p| p.q[k])),
            Parameter::Compliance { coordinate } => place(coordinate).map_or(1.0, |k| largest(&|p| p.torque[k])),
            _ => 1.0,
        }
    }

    /// Whether one unit of a parameter times [`Determination::effect`] is a length.
    fn is_length(&self, parameter: Parameter) -> bool {
        match parameter {
            Parameter::Gear { coordinate } | Parameter::Compliance { coordinate } => self.names.slides[coordinate],
            _ => self.names.unit(parameter) == "m",
        }
    }

    /// The fitted parameters of the robot whose intervals are too wide. For each: its index in the fit, and by how much a
    /// change of the parameter by half of its interval moves the robot, rad (m). `covariance`: covariance of the fitted
    /// parameters.
    fn wide(&self, covariance: &DMatrix<f64>) -> Vec<(usize, f64)> {
        let spread = spread(self.problem);
        let of = |(place, k): (usize, &usize)| {
            let parameter = self.problem.parameters[*k];
            let size = self.quantile() * covariance[(place, place)].max(0.0).sqrt() * self.effect(parameter);
            let limit = if self.is_length(parameter) { WIDE * spread } else { WIDE };
            (parameter.group() != ParameterGroup::Frames && size > limit).then_some((place, size))
        };
        self.level.fit.active.iter().enumerate().filter_map(of).collect()
    }

    /// The errors of the geometry that the prior determines more than the data do, as indices in the fit.
    fn held(&self, covariance: &DMatrix<f64>) -> Vec<usize> {
        let Some(deviation) = self.level.deviation else { return Vec::new() };
        let prior = |k: usize| {
            let grouped = self.level.base.grouped.iter();
            let grouped = grouped.filter(|(g, _)| self.problem.parameters[*g].group() == ParameterGroup::Geometry);
            let terms = grouped.flat_map(|(_, terms)| terms).filter(|(of, _)| *of == k);
            deviation * deviation * (1.0 + terms.map(|(_, x)| x * x).sum::<f64>())
        };
        let is_held = |(place, k): (usize, &usize)| {
            let is_geometry = self.problem.parameters[*k].group() == ParameterGroup::Geometry;
            (is_geometry && covariance[(place, place)] > HELD * prior(*k)).then_some(place)
        };
        self.level.fit.active.iter().enumerate().filter_map(is_held).collect()
    }

    /// Random postures within the joint limits, with the kind of measurement of the first posture, linearised at the fit.
    fn elsewhere(&self, count: usize) -> Option<(Problem, Linearised)> {
        let like = self.problem.postures.first()?;
        let there = self.problem.with(random_postures(self.robot, self.problem, like, count));
        let rows = there.linearised(&self.level.fit.unknowns);
        Some((there, rows))
    }

    /// The covariance after this number of further random postures.
    fn after(&self, count: usize) -> Option<DMatrix<f64>> {
        let fit = &self.level.fit;
        let (_, rows) = self.elsewhere(count)?;
        let mut jacobian = rows.jacobian.select_columns(&fit.active);
        let noise = |kind: ResidualKind| if kind == ResidualKind::Length { fit.noise.length } else { fit.noise.angle };
        jacobian.row_iter_mut().zip(&rows.kinds).for_each(|(mut row, kind)| row /= noise(*kind));
        Some(inverse(&(inverse(&fit.covariance) + jacobian.tr_mul(&jacobian))))
    }

    fn name(&self, place: usize) -> String {
        self.names.of(self.problem.parameters[self.level.fit.active[place]]).to_string()
    }

    /// Text of a parameter, for example `zero q3 (+- 158 mrad)`: the number is the motion of the robot that corresponds to half
    /// of the interval.
    fn with_size(&self, (place, size): (usize, f64)) -> String {
        let is_length = self.is_length(self.problem.parameters[self.level.fit.active[place]]);
        let unit = if is_length { "mm" } else { "mrad" };
        format!("{} (+- {} {unit})", self.name(place), significant(1e3 * size, 3))
    }

    /// The advice how many further postures are needed. `is_open`: whether parameters are undetermined with a given
    /// covariance. The smallest number of further postures after which none is undetermined is named, if there is one.
    fn what_would_tell(&self, is_open: impl Fn(&DMatrix<f64>) -> bool) -> String {
        let suffices = |count: &usize| self.after(*count).is_some_and(|covariance| !is_open(&covariance));
        more_postures(FURTHER.into_iter().find(suffices))
    }

    /// Number of base parameters that these and further random postures determine.
    fn rank_after(&self, count: usize) -> Option<usize> {
        let (there, _) = self.elsewhere(count)?;
        let all = self.problem.postures.iter().chain(&there.postures).cloned().collect();
        let rows = self.problem.with(all).linearised(&self.level.fit.unknowns);
        Some(GeometricBase::of(&rows.jacobian, &self.level.base.kept).ok()?.kept.len())
    }

    /// The joints that move over a small part of their range: `q3 (2 %)`.
    fn little_motion(&self) -> String {
        let range = |k: usize| {
            let limits = self.robot.coordinates[k].limits.position.map(|(low, high)| high - low);
            let whole = std::f64::consts::TAU;
            if self.names.slides[k] { limits } else { Some(limits.map_or(whole, |range| range.min(whole))) }
        };
        let share = |(place, &k): (usize, &usize)| {
            let all = self.problem.postures.iter().map(|p| p.q[place]);
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            let share = (high - low) / range(k).filter(|range| *range > 0.0)?;
            let text = || format!("{} ({} %)", self.names.coordinates[k], significant(100.0 * share, 2));
            (share < LITTLE_MOTION).then(text)
        };
        let all: Vec<String> = self.problem.chain.coordinates.iter().enumerate().filter_map(share).collect();
        if all.is_empty() { String::new() } else { format!("; of its range moves {}", all.join(", ")) }
    }

    /// Claims on three kinds of parameters: parameters that these postures do not determine, although other postures would;
    /// parameters with wide intervals; parameters that the prior determines more than the data do.
    pub(crate) fn of_parameters(&self) -> Vec<Claim> {
        let fit = &self.level.fit;
        let mut claims = Vec::new();
        let mut add = |why: String, tells: String| claims.push(cannot_tell(Subject::whole(PARAMETERS), why, tells));
        let name = |k: &usize| self.names.of(self.problem.parameters[*k]).to_string();
        let without: Vec<String> = self.level.undetermined.iter().map(name).collect();
        if !without.is_empty() {
            let why = format!("these postures do not determine {}{}", listed(&without), self.little_motion());
            let is_whole = |count: &usize| self.rank_after(*count) == Some(self.level.base.kept.len());
            add(why, more_postures(FURTHER.into_iter().find(is_whole)));
        }
        let wide = self.wide(&fit.covariance);
        if !wide.is_empty() {
            let names: Vec<String> = wide.iter().map(|one| self.with_size(*one)).collect();
            let why = format!("these postures hardly determine {}{}", listed(&names), self.little_motion());
            add(why, self.what_would_tell(|covariance| !self.wide(covariance).is_empty()));
        }
        let held = self.held(&fit.covariance);
        if !held.is_empty() {
            let names: Vec<String> = held.iter().map(|place| self.name(*place)).collect();
            let why = format!("the prior decides {} more than these postures", listed(&names));
            add(why, self.what_would_tell(|covariance| !self.held(covariance).is_empty()));
        }
        claims
    }

    /// Half of the 95 % interval of predicted lengths (m) or angles (rad) at random postures within the limits, root mean square;
    /// `None` if the kind is not measured. `covariance`: of the fitted parameters.
    fn interval(&self, rows: &Linearised, covariance: &DMatrix<f64>, kind: ResidualKind) -> Option<f64> {
        let jacobian = rows.jacobian.select_columns(&self.level.fit.active);
        let of_kind: Vec<usize> = (0..rows.kinds.len()).filter(|r| rows.kinds[*r] == kind).collect();
        let variance = |r: &usize| (jacobian.row(*r) * covariance * jacobian.row(*r).transpose())[(0, 0)];
        let each = if kind == ResidualKind::Length { components(self.problem) } else { 3.0 };
        let sum: f64 = of_kind.iter().map(variance).sum();
        let sigma = (each * sum / of_kind.len() as f64).max(0.0).sqrt();
        (!of_kind.is_empty()).then(|| self.quantile() * sigma)
    }

    /// Claims whether poses are accurate anywhere within the joint limits, and not only near the measured postures.
    pub(crate) fn of_other_postures(&self) -> Vec<Claim> {
        let Some((there, rows)) = self.elsewhere(ELSEWHERE) else { return Vec::new() };
        let size = spread(self.problem).max(spread_of_links(&there));
        let near = self.level.left_out_on(self.problem, &self.level.fit.used);
        let kinds = [
            (ResidualKind::Length, OTHER_LENGTHS, "mm", WIDE_POSE * size, near.length),
            (ResidualKind::Angle, OTHER_ANGLES, "mrad", WIDE_POSE, near.angle),
        ];
        let claim = |(kind, topic, unit, limit, near): (ResidualKind, Topic, &str, f64, Option<f64>)| {
            let interval = self.interval(&rows, &self.level.fit.covariance, kind)?;
            let subject = Subject::whole(topic);
            if interval <= limit {
                return Some(Claim::new(subject, Outcome::Agrees { smallest: Figure::new(1e3 * interval, unit) }));
            }
            let why = format!(
                "at any posture within the limits of the joints, the pose is known to {} {unit}, although the error on postures \
                 left out is {} {unit}{}",
                significant(1e3 * interval, 3),
                significant(1e3 * near.unwrap_or(0.0), 3),
                self.little_motion()
            );
            let is_open = |covariance: &DMatrix<f64>| {
                self.interval(&rows, covariance, kind).is_none_or(|interval| interval > limit)
            };
            Some(cannot_tell(subject, why, self.what_would_tell(is_open)))
        };
        kinds.into_iter().filter_map(claim).collect()
    }
}

#[cfg(test)]
mod tests {
    use claims::Trust;
    use random::Random;

    use super::*;
    use crate::calibrate::Calibration;
    use crate::chain::Convention;
    use crate::corrections::TableCorrections;
    use crate::laws::calibrated;
    use crate::measurement::MeasurementKind;
    use crate::request::Calibrated;
    use crate::simulated::{arm, measured, problem, truth};

    /// A calibration of an arm whose joints 5 and 6 move over this range, rad, with noise in m (rad), and `more` random postures.
    fn found(range: f64, kind: MeasurementKind, noise: f64, more: usize) -> Calibration {
        let (robot, mut random) = (arm(), Random::new(5));
        let mut near = problem(&robot, Convention::Dh, kind, 60, &mut random);
        near.postures.iter_mut().for_each(|p| (4..6).for_each(|k| p.q[k] *= range / 4.0));
        let far = random_postures(&robot, &near, &near.postures[0], more);
        near.postures.extend(far);
        let truth = truth(&near, 0.02, 5e-4, &mut random);
        let problem = measured(&near, &truth, [noise; 2], &mut random);
        calibrated(&robot, &problem, TableCorrections::default(), Calibrated::Geometry)
    }

    fn said(found: &Calibration, topic: Topic) -> Vec<&Claim> {
        found
            .verdict
            .claims
            .iter()
            .filter(|c| c.subject().topic == topic && !matches!(c.outcome(), Outcome::Agrees { .. }))
            .collect()
    }

    /// Postures over the whole range determine all parameters: no claim names a parameter, and the answer is yes.
    #[test]
    fn what_is_determined_is_not_doubted() {
        let found = found(4.0, MeasurementKind::Pose, 1e-4, 0);
        for topic in [PARAMETERS, OTHER_LENGTHS, OTHER_ANGLES] {
            assert!(said(&found, topic).is_empty(), "{found}");
        }
        assert_eq!(found.verdict.trust, Trust::Yes, "{found}");
    }

    /// If joints hardly move, the error on postures left out is small, but the answer is not yes. The claims give a number of
    /// further postures. With this number of further postures, all parameters are determined.
    #[test]
    fn what_is_not_determined_is_named_with_what_determines_it() {
        let little = found(0.04, MeasurementKind::Points(1), 3e-4, 0);
        assert!(little.level().left_out.length.unwrap() < 1e-3, "{little}");
        assert_eq!(little.verdict.trust, Trust::WithCare, "{little}");
        let claims = said(&little, PARAMETERS);
        let text = claims.iter().map(|claim| claim.to_string()).collect::<Vec<_>>().join("\n");
        assert!(
            text.contains("hardly determine") && text.contains("; of its range moves q5 (0.62 %), q6 (0.61 %);"),
            "{text}"
        );
        assert!(!said(&little, OTHER_LENGTHS).is_empty(), "{little}");
        let count = |claim: &&Claim| {
            let text = claim.to_string();
            text.split("; ").find_map(|part| part.split(' ').next()?.parse::<usize>().ok()).unwrap_or(0)
        };
        let more = claims.iter().chain(&said(&little, OTHER_LENGTHS)).map(count).max().unwrap();
        assert!(more > 0, "{text}");
        let cured = found(0.04, MeasurementKind::Points(1), 3e-4, more);
        for topic in [PARAMETERS, OTHER_LENGTHS] {
            assert!(said(&cured, topic).is_empty(), "{more} {cured}");
        }
    }

    /// If the prior determines a parameter more than the data do, a claim names this parameter.
    #[test]
    fn a_prior_that_decides_is_named() {
        let found = found(4.0, MeasurementKind::Points(1), 2e-3, 0);
        assert!(found.level().deviation.is_some(), "{found}");
        assert!(found.to_string().contains("the prior decides"), "{found}");
        assert_ne!(found.verdict.trust, Trust::Yes, "{found}");
    }
}
