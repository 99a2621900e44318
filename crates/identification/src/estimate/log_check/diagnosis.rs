//! Derives the findings (faults with their evidence) of a log check from its numbers. The checks have a fixed order, and each
//! check has its own thresholds.
//!
//! The first checks need no inertials (inertial parameters of the robot description): dead or saturated torques, a log that is
//! too short, velocities that are not the derivatives of the positions, negative friction. If the description has inertials,
//! slopes are computed (regression of measured on nominal torque). The slopes show faults of all torques (wrong unit, currents
//! instead of torques, wrong signs), faults of one or two joints, faults of gravity (`search`), and delays. If measured and
//! nominal torques disagree and no fault explains the difference, the log is attributed to another robot.

use linear_model::regressor::Regressor;
use logs::Suspect;

use crate::estimate::digits::significant;
use crate::estimate::hypothesis::Hypothesis::*;
use crate::estimate::log_check::absolute::{are_without_sign, without_sign};
use crate::estimate::log_check::change::{Change, Description};
use crate::estimate::log_check::delay::{Lag, common_lag};
use crate::estimate::log_check::finding::{COMMON_FACTORS, Fault, Finding, NOMINAL_INERTIAL_SLOPES};
use crate::estimate::log_check::free_bodies::FreeBodies;
use crate::estimate::log_check::regression::{COUNTED_SLOPE_SHARE, Partial};
use crate::estimate::log_check::report::{ExplainedMistake, LogCheck};
use crate::estimate::log_check::samples::Samples;
use crate::estimate::log_check::search::{ChangeSearch, Explanation, LIKELY_MISFIT_SHARE, Suspicion, counts};
use crate::estimate::log_check::trial::{FOREIGN_ROBOT_MISFIT, OTHER_ROBOT};
use crate::estimate::log_check::trials::Trials;

pub(super) struct DiagnosisInput<'a> {
    pub samples: &'a Samples,
    /// Indices of the kept samples that are examined.
    pub rows: &'a [usize],
    pub suspects: &'a [Suspect],
    pub regressor: &'a dyn Regressor,
    pub description: Option<&'a Description<'a>>,
}

/// Torques tau count as computed, not measured, if |tau - T| / |tau| is below this value. T: nominal torques without friction.
/// Torques of a real machine always contain friction.
const COMPUTED_TORQUE_RESIDUAL: f64 = 2e-3;

/// Remedy if gravity was subtracted from the logged torques.
const TORQUES_WITH_GRAVITY: &str = "log the torques before gravity is taken out of them";

/// In a short motion, a fault is reported only if undoing the fault multiplies the misfit (error of the description) by less
/// than this factor.
const SHORT_MISFIT_SHARE: f64 = 0.1;

/// Slopes of joints count as equal if their relative distance from the median is below this value.
const EQUAL_SLOPES_TOLERANCE: f64 = 0.15;

/// A scale of the torques counts as a power of ten if its decimal logarithm is within this distance of an integer.
const POWER_OF_TEN_TOLERANCE: f64 = 0.2;

impl DiagnosisInput<'_> {
    /// Writes the findings, and the checks that were not possible, into `log_check`. `slopes`: for each joint, the regression
    /// of measured on nominal torque; `None` if the description has no inertials.
    pub(super) fn diagnose(&self, slopes: Option<&[Partial]>, log_check: &mut LogCheck) {
        log_check.findings = self.unreadable();
        if !log_check.findings.is_empty() {
            return;
        }
        let mut findings = self.dead_and_saturated();
        let is_dead = findings.iter().any(|f| matches!(f.fault, Fault::DeadTorque | Fault::Nothing(_)));
        // If the motion is too short, columns and units cannot be checked.
        let short = self.short();
        let is_dead = is_dead || short.is_some();
        findings.extend(short);
        findings.extend(self.degrees());
        let velocities = self.velocities();
        let explanations =
            slopes.filter(|_| !is_dead).map(|slopes| self.explanations_of_slopes(slopes, &velocities, log_check));
        if slopes.is_none() {
            let why =
                "the description has no inertials: units, zeros, swapped columns and another robot cannot be checked";
            log_check.not_checked.push(why.into());
        }
        let explanations = explanations.unwrap_or_else(|| vec![Vec::new()]).into_iter();
        let mut all: Vec<Vec<Finding>> =
            explanations.map(|found| self.together(&findings, &velocities, found, log_check)).collect();
        let mut findings = if all.is_empty() { findings } else { all.remove(0) };
        let is_foreign = matches!(findings.as_slice(), [f] if f.fault == Fault::OtherRobot);
        if findings.is_empty() || is_foreign {
            // A long delay can cause a misfit (error of the description) as large as the misfit of a log of another robot.
            let lag = self.delay().filter(|lag| !is_foreign || lag.share > SMALLEST_DELAY_SHARE_IF_FOREIGN);
            if let Some(lag) = lag {
                findings = vec![late(&lag)];
            }
        }
        findings.sort_by_key(|f| !f.fault.is_gross());
        log_check.findings = findings;
        log_check.others = all;
    }

    /// Combines the findings from the signals with `found`, the findings of one explanation of the torques.
    fn together(
        &self,
        signals: &[Finding],
        velocities: &[(usize, Option<usize>, Finding)],
        found: Vec<Finding>,
        log_check: &LogCheck,
    ) -> Vec<Finding> {
        let mut findings = signals.to_vec();
        // If position or velocity columns are exchanged, velocities also do not fit their positions. Then only the exchange is
        // reported.
        let is_exchange = |f: &Finding| matches!(f.fault, Fault::Of(SwappedPositions(..) | SwappedVelocities(..), _));
        if !found.iter().any(is_exchange) {
            findings.extend(velocities.iter().map(|v| v.2.clone()));
        }
        findings.extend(found);
        let motion = |f: &Finding| !matches!(f.fault, Fault::Saturated(_) | Fault::Of(Late(_), _));
        if velocities.is_empty() && !findings.iter().any(|f| motion(f) && f.joints.is_empty()) {
            findings.extend(self.friction(log_check, &findings));
        }
        findings
    }

    /// The name of a coordinate.
    pub(super) fn name(&self, k: usize) -> String {
        self.regressor.coordinates()[k].clone()
    }

    pub(super) fn n(&self) -> usize {
        self.samples.kept.n
    }

    /// Range of motion of joint k, rad (m).
    pub(super) fn range(&self, k: usize) -> f64 {
        self.samples.range[k].1 - self.samples.range[k].0
    }

    /// Finds explanations of the torques from the slopes (regression of measured on nominal torque). Only one of these
    /// explanations can be right; each is a list of findings.
    fn explanations_of_slopes(
        &self,
        slopes: &[Partial],
        velocities: &[(usize, Option<usize>, Finding)],
        log_check: &mut LogCheck,
    ) -> Vec<Vec<Finding>> {
        let Some(description) = self.description else { return Vec::new() };
        if let Some(finding) = self.computed(description) {
            return vec![vec![finding]];
        }
        let torques = description.torques(&self.samples.kept, self.rows, &[]);
        if are_without_sign(&self.samples.kept, self.rows, &torques) {
            return vec![vec![without_sign()]];
        }
        // A slope is meaningful only if the description explains the torque of the joint.
        let meaningful: Vec<f64> =
            slopes.iter().filter(|p| p.share() > COUNTED_SLOPE_SHARE).map(Partial::slope).collect();
        let mut common = Vec::new();
        let negative = meaningful.iter().filter(|s| **s < 0.0).count();
        let all_signs = meaningful.len() >= 2 && 4 * negative >= 3 * meaningful.len();
        let scale = self.common_scale(&meaningful);
        let text = |p: &Partial| if p.share() > COUNTED_SLOPE_SHARE { significant(p.slope()) } else { "-".into() };
        let list = format!(
            "measured over nominal torque, by joint: {}",
            slopes.iter().map(text).collect::<Vec<_>>().join(" ")
        );
        // A median slope far from 1 means another unit. If three quarters of the slopes are negative, either all torques have
        // the wrong sign, or the zero of a joint near the base is wrong.
        let is_nominal = NOMINAL_INERTIAL_SLOPES.contains(&scale);
        if !is_nominal {
            common.push(self.unit(scale, slopes, list.clone()));
        }
        let trials = Trials::new(description, &self.samples.kept, self.rows);
        let size = if is_nominal { 1.0 } else { scale };
        let velocities = &suspicions(velocities);
        let signs: &[f64] = if all_signs { &[-1.0, 1.0] } else { &[1.0] };
        let mut all = Vec::new();
        for sign in signs {
            let scale = sign * size;
            let mut common = common.clone();
            if *sign < 0.0 {
                common.push(self.all_signs(list.clone()));
            }
            // Faults of all joints are undone before faults of single joints are searched.
            let (samples, rows, trials) = (self.samples, self.rows, &trials);
            let search = ChangeSearch { samples, rows, trials, description, scale, velocities };
            let explanations = search.best(slopes);
            all.extend(
                explanations.into_iter().map(|one| self.explained(&search, one, slopes, &common, &list, log_check)),
            );
        }
        // If at least one explanation has findings, explanations without findings are dropped. The explanation with the fewest
        // findings comes first.
        let is_needed = |found: &Vec<Finding>| !found.is_empty();
        if all.iter().any(is_needed) {
            all.retain(is_needed);
        }
        all.sort_by_key(Vec::len);
        if meaningful.is_empty() && all.iter().all(Vec::is_empty) {
            log_check
                .not_checked
                .push("no joint's torque follows the description: units and signs cannot be checked".into());
        }
        if all.iter().all(Vec::is_empty) {
            all = vec![self.common_factor(&meaningful, list).into_iter().collect()];
        }
        all
    }

    /// The findings of one explanation of the log. The list starts with `common`, the findings that concern all joints.
    fn explained(
        &self,
        search: &ChangeSearch,
        (mut changes, misfits): Explanation,
        slopes: &[Partial],
        common: &[Finding],
        list: &str,
        log_check: &mut LogCheck,
    ) -> Vec<Finding> {
        let mut found = common.to_vec();
        let is_plain = changes.is_empty();
        // In a short motion, an explanation that removes only a part of the misfit (error of the description) may be chance.
        if log_check.is_short {
            let runs_back = |change: &Change| {
                let of_sign = matches!(change.of, TorqueSign(_) | MotionSign(_));
                of_sign && change.of.joint().is_some_and(|k| log_check.joints[k].runs_back())
            };
            let is_sure =
                |one: &Suspicion| one.after < SHORT_MISFIT_SHARE * one.before || one.changes.iter().all(runs_back);
            changes.retain(is_sure);
        }
        // Drive gains differ between joints, so scales of single joints are not tested if the efforts are currents.
        if !common.iter().any(|f| f.fault == Fault::NoTorque) {
            changes.extend(search.scaled(&changes, slopes));
        }
        found.extend(self.findings_of_suspicions(&changes, list, log_check));
        if is_plain {
            let exchanged: Vec<Suspicion> = search.exchanged(slopes, &log_check.hidden_exchanges).into_iter().collect();
            found.extend(self.findings_of_suspicions(&exchanged, list, log_check));
            // If no fault was found: tests exchanged columns, and whether the log is of another robot.
            found.extend(self.other_robot(&misfits, slopes, search.scale, log_check, list.into()));
        }
        found
    }

    /// Findings of the suspected faults that are needed: the log cannot be explained without the fault, even with other bodies
    /// (inertial parameters). Suspicions that are not needed are added to `log_check.explained`.
    fn findings_of_suspicions(&self, changes: &[Suspicion], slopes: &str, log_check: &mut LogCheck) -> Vec<Finding> {
        let free = FreeBodies { regressor: self.regressor, samples: self.samples, joints: &log_check.joints };
        let needed = free.needed(changes);
        let of = |is_needed: bool| -> Vec<Suspicion> {
            let all = changes.iter().zip(&needed).filter(|(_, needed)| **needed == is_needed);
            all.map(|(change, _)| change.clone()).collect()
        };
        let [needed, explained] = [of(true), of(false)];
        for change in explained {
            let finding = self.changed(&change, slopes);
            let is_new = log_check.explained.iter().all(|known| known.finding.joints != finding.joints);
            let is_likely = change.after < LIKELY_MISFIT_SHARE * change.before;
            log_check.explained.extend(is_new.then_some(ExplainedMistake { finding, is_likely }));
        }
        let needed = free.with_scales(needed);
        let is_new = |change: &&Suspicion| change.fault() != Fault::Of(Degrees, 0.0) || self.degrees().is_none();
        needed.iter().filter(is_new).map(|change| self.changed(change, slopes)).collect()
    }

    /// The finding that all torques are wrong by a common factor, which the slopes of all joints show; `None` without a common
    /// factor. `meaningful`: slopes of measured on nominal torque.
    fn common_factor(&self, meaningful: &[f64], evidence: String) -> Option<Finding> {
        let middle = self.common_scale(meaningful);
        // A load or other bodies would change only some slopes, or change them in different directions.
        let is_off =
            meaningful.iter().all(|s| *s > COMMON_FACTORS.end) || meaningful.iter().all(|s| *s < COMMON_FACTORS.start);
        let is_alike = |s: &&f64| (*s / middle - 1.0).abs() < EQUAL_SLOPES_TOLERANCE;
        let alike = 4 * meaningful.iter().filter(is_alike).count() >= 3 * meaningful.len();
        let remedy = format!(
            "the unit, the gains or the gear ratios of the torques are wrong, or all masses of the description are; if \
             the torques are: divide their columns by {}",
            significant(middle)
        );
        let rated = significant(100.0 / middle);
        let evidence = format!(
            "{evidence}; torques in per cent of a rated torque of {rated} N m are so: `torque: percent({rated} N m)`"
        );
        (meaningful.len() >= 2 && is_off && alike && NOMINAL_INERTIAL_SLOPES.contains(&middle))
            .then(|| self.all_scaled(Finding::of_all(Fault::Factor(middle), evidence, remedy), middle))
    }

    /// The common scale of the torques: the median magnitude of the meaningful slopes. The scale is 1 if there are too few
    /// slopes, because then a single joint may be wrong. The scale is also 1 if less than two thirds of the slopes are near the
    /// median.
    fn common_scale(&self, meaningful: &[f64]) -> f64 {
        let mut sizes: Vec<f64> = meaningful.iter().map(|s| s.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let are_enough = sizes.len() >= self.n().min(2);
        let middle = sizes.get(sizes.len() / 2).filter(|_| are_enough).copied().unwrap_or(1.0);
        let is_near = |s: &&f64| NOMINAL_INERTIAL_SLOPES.contains(&(*s / middle));
        if 3 * sizes.iter().filter(is_near).count() >= 2 * sizes.len() { middle } else { 1.0 }
    }

    /// The finding that the torques were computed; `None` if they differ from the nominal torques without friction.
    fn computed(&self, description: &Description) -> Option<Finding> {
        let torques = description.torques(&self.samples.kept, self.rows, &[]);
        let n = self.n();
        let measured = self.rows.iter().flat_map(|&r| &self.samples.kept.tau[r * n..(r + 1) * n]);
        let left: f64 = measured.clone().zip(&torques).map(|(a, b)| (a - b).powi(2)).sum();
        let whole: f64 = measured.map(|x| x * x).sum();
        let relative = (left / whole).sqrt();
        let evidence = format!("the description predicts them with {relative:.1e} of themselves, without any friction");
        let remedy = "log measured torques or currents; an estimate from these gives the description back";
        (relative < COMPUTED_TORQUE_RESIDUAL).then(|| Finding::of_all(Fault::Computed, evidence, remedy))
    }

    fn unit(&self, scale: f64, slopes: &[Partial], evidence: String) -> Finding {
        let power = scale.log10().round();
        if power.abs() >= 2.0 && (scale.log10() - power).abs() < POWER_OF_TEN_TOLERANCE {
            let word = match power as i32 {
                3 => "name the columns tau1_mNm, .. (1 N mm = 1 mN m)".to_string(),
                2 => "name the columns tau1_Ncm, ..".into(),
                -3 => "name the columns tau1_kNm, ..".into(),
                power => format!("divide the torque columns by 1e{power}"),
            };
            let finding = Finding::of_all(Fault::TorqueUnit(power as i32), evidence, word);
            return self.all_scaled(finding, 10f64.powf(power));
        }
        let meaningful = slopes.iter().enumerate().filter(|(_, p)| p.share() > COUNTED_SLOPE_SHARE);
        let gains = meaningful.map(|(k, p)| format!("{}={}", self.name(k), significant(1.0 / p.slope().abs())));
        let remedy = format!(
            "name the columns as currents (i1, ..) and give the torque per ampere, by the description about [gain={}]; \
             or the ratios of the gears ([options.transmission.ratios])",
            gains.collect::<Vec<_>>().join(",")
        );
        let scaled = slopes.iter().enumerate().filter(|(_, p)| p.share() > COUNTED_SLOPE_SHARE);
        let undo = scaled.map(|(k, p)| Change { of: Scale(k), size: p.slope().abs() - 1.0 }).collect();
        Finding::of_all(Fault::NoTorque, evidence, remedy).undone_by(undo)
    }

    /// Adds changes to the finding that divide the torques of all joints by `factor`.
    fn all_scaled(&self, finding: Finding, factor: f64) -> Finding {
        let change = |k: usize| Change { of: Scale(k), size: factor - 1.0 };
        finding.undone_by((0..self.n()).map(change).collect())
    }

    fn changed(&self, found: &Suspicion, slopes: &str) -> Finding {
        let evidence = format!(
            "corrected, the nominal residual is {:.0} % of the torques instead of {:.0} % (joints alike); {slopes}",
            100.0 * found.after,
            100.0 * found.before
        );
        let changed = found.joints(self.n());
        let evidence = match changed.len() {
            0..=2 => evidence,
            _ => {
                let source = |&k: &usize| format!("{} is logged as {}", self.name(k), self.name(found.source(k)));
                format!("{}; {evidence}", changed.iter().map(source).collect::<Vec<_>>().join(", "))
            }
        };
        let mut joints: Vec<String> = changed.into_iter().map(|k| self.name(k)).collect();
        if found.fault() == Fault::Of(Degrees, 0.0) {
            joints.push("all joints".into());
        }
        let finding = Finding::of(found.fault(), joints, evidence, TORQUES_WITH_GRAVITY);
        // If gravity was subtracted from the torques, no change of the log can restore gravity, so such a finding has no
        // changes.
        let is_in_log = found.changes.iter().all(|change| change.of != GravityCompensated);
        if is_in_log { finding.undone_by(found.changes.clone()) } else { finding }
    }

    fn other_robot(
        &self,
        misfits: &[f64],
        slopes: &[Partial],
        scale: f64,
        log_check: &LogCheck,
        list: String,
    ) -> Option<Finding> {
        let is_heavy = |k: &usize| counts(&slopes[*k], scale, HEAVY_JOINT_SHARE);
        let heavy: Vec<usize> = (0..self.n()).filter(is_heavy).collect();
        let mean = heavy.iter().map(|&k| misfits[k]).sum::<f64>() / heavy.len().max(1) as f64;
        // The torque of a joint is noise if even a fit of this joint alone does not explain the torque.
        let noisy = |k: usize| log_check.joints[k].friction.is_some_and(|f| f.residual > NOISY_TORQUE_RESIDUAL);
        let clear = heavy.iter().any(|&k| !noisy(k));
        let evidence = format!(
            "the nominal residual is {:.0} % of the torques at the joints where it should be smallest; {list}",
            100.0 * mean
        );
        (heavy.len() >= 2 && clear && mean > FOREIGN_ROBOT_MISFIT)
            .then(|| Finding::of_all(Fault::OtherRobot, evidence, OTHER_ROBOT))
    }

    /// The common delay of the torques of all joints; `None` if no delay is found.
    fn delay(&self) -> Option<Lag> {
        common_lag(self.regressor, self.samples, self.rows)
    }
}

/// A delay replaces the finding "another robot" only if it explains more than this share of the squared residual.
const SMALLEST_DELAY_SHARE_IF_FOREIGN: f64 = 0.5;

fn late(lag: &Lag) -> Finding {
    let evidence = format!("it explains {:.0} % of the residual", 100.0 * lag.share);
    let remedy = format!("[delay=auto], which is exact; [delay={:.4}] is right to a third", lag.seconds);
    Finding::of_all(Fault::Of(Late(None), lag.seconds), evidence, remedy)
}

fn suspicions(velocities: &[(usize, Option<usize>, Finding)]) -> Vec<(usize, usize)> {
    velocities.iter().filter_map(|v| Some((v.0, v.1?))).collect()
}

/// The finding "another robot" uses only joints for which the ratio squared nominal torque / squared measured torque exceeds
/// this value.
const HEAVY_JOINT_SHARE: f64 = 0.2;

/// The torque of a joint counts as noise if |residual| / |torque| of a fit of this joint alone exceeds this value.
const NOISY_TORQUE_RESIDUAL: f64 = 0.5;
