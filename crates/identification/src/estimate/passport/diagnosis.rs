//! From the numbers of a passport to its findings: the checks in their order, each with its thresholds.
//!
//! Checks that need no inertials come first: dead and saturated torques, a log too short, velocities that are not the
//! slopes of their positions, and friction that drives. With inertials, the slopes then tell of all torques (unit,
//! currents, signs), of one joint or two and of gravity (`search`), and of the clock. What nothing explains is another
//! robot.

use linear_model::regressor::Regressor;
use logs::Suspect;

use crate::estimate::digits::significant;
use crate::estimate::hypothesis::Hypothesis::*;
use crate::estimate::passport::change::{Change, Description};
use crate::estimate::passport::delay::{Lag, common_lag};
use crate::estimate::passport::finding::{COMMON_FACTORS, Fault, Finding, NOMINAL_INERTIAL_SLOPES};
use crate::estimate::passport::free_bodies::FreeBodies;
use crate::estimate::passport::regression::{COUNTED_SLOPE_SHARE, Partial};
use crate::estimate::passport::report::{Explained, Passport};
use crate::estimate::passport::samples::Samples;
use crate::estimate::passport::search::{Explanation, LIKELY_MISFIT_SHARE, Search, Suspicion, counts};
use crate::estimate::passport::trial::{FOREIGN_ROBOT_MISFIT, OTHER_ROBOT};
use crate::estimate::passport::trials::Trials;

/// What a diagnosis looks at.
pub(super) struct Look<'a> {
    pub samples: &'a Samples,
    /// The kept samples that are looked at.
    pub rows: &'a [usize],
    pub suspects: &'a [Suspect],
    pub regressor: &'a dyn Regressor,
    pub description: Option<&'a Description<'a>>,
}

/// |tau - T| / |tau| without friction below which torques are computed, because no machine moves without friction.
const COMPUTED_TORQUE_RESIDUAL: f64 = 2e-3;

/// What to do about torques without gravity.
const TORQUES_WITH_GRAVITY: &str = "log the torques before gravity is taken out of them";

/// Misfit that a mistake leaves, of that of the log as it is, in squares, below which it is said of a short motion.
const SHORT_MISFIT_SHARE: f64 = 0.1;

/// Slopes within this share of their median are alike.
const ALIKE_SLOPES: f64 = 0.15;

/// Exponents that differ by more than this from a whole number are no power of ten.
const POWER_OF_TEN_TOLERANCE: f64 = 0.2;

impl Look<'_> {
    /// Appends the findings, and what cannot be told.
    pub(super) fn diagnose(&self, slopes: Option<&[Partial]>, passport: &mut Passport) {
        passport.findings = self.unreadable();
        if !passport.findings.is_empty() {
            return;
        }
        let mut findings = self.dead_and_saturated();
        let is_dead = findings.iter().any(|f| matches!(f.fault, Fault::DeadTorque | Fault::Nothing(_)));
        // So little of a motion says nothing of columns and units.
        let short = self.short();
        let is_dead = is_dead || short.is_some();
        findings.extend(short);
        findings.extend(self.degrees());
        let velocities = self.velocities();
        let explanations = slopes.filter(|_| !is_dead).map(|slopes| self.described(slopes, &velocities, passport));
        if slopes.is_none() {
            let why =
                "the description has no inertials: units, zeros, swapped columns and another robot cannot be told";
            passport.untold.push(why.into());
        }
        let explanations = explanations.unwrap_or_else(|| vec![Vec::new()]).into_iter();
        let mut all: Vec<Vec<Finding>> =
            explanations.map(|found| self.together(&findings, &velocities, found, passport)).collect();
        let mut findings = if all.is_empty() { findings } else { all.remove(0) };
        let is_foreign = matches!(findings.as_slice(), [f] if f.fault == Fault::OtherRobot);
        if findings.is_empty() || is_foreign {
            // Torques that come very late fit their motion as little as those of another robot do.
            let lag = self.delay().filter(|lag| !is_foreign || lag.share > SMALLEST_DELAY_SHARE_IF_FOREIGN);
            if let Some(lag) = lag {
                findings = vec![late(&lag)];
            }
        }
        findings.sort_by_key(|f| !f.fault.is_gross());
        passport.findings = findings;
        passport.others = all;
    }

    /// The findings of the signals, and those of one explanation of the torques.
    fn together(
        &self,
        signals: &[Finding],
        velocities: &[(usize, Option<usize>, Finding)],
        found: Vec<Finding>,
        passport: &Passport,
    ) -> Vec<Finding> {
        let mut findings = signals.to_vec();
        // Columns that are exchanged are no slopes of their own positions.
        let is_exchange = |f: &Finding| matches!(f.fault, Fault::Of(SwappedPositions(..) | SwappedVelocities(..), _));
        if !found.iter().any(is_exchange) {
            findings.extend(velocities.iter().map(|v| v.2.clone()));
        }
        findings.extend(found);
        let motion = |f: &Finding| !matches!(f.fault, Fault::Saturated(_) | Fault::Of(Late(_), _));
        if velocities.is_empty() && !findings.iter().any(|f| motion(f) && f.joints.is_empty()) {
            findings.extend(self.friction(passport, &findings));
        }
        findings
    }

    /// The name of a coordinate.
    pub(super) fn name(&self, k: usize) -> String {
        self.regressor.coordinates()[k].clone()
    }

    /// Number of coordinates.
    pub(super) fn n(&self) -> usize {
        self.samples.kept.n
    }

    /// Distance between the ends of a joint's motion, rad (m).
    pub(super) fn range(&self, k: usize) -> f64 {
        self.samples.range[k].1 - self.samples.range[k].0
    }

    /// What the slopes of the description say: explanations, of which one is so.
    fn described(
        &self,
        slopes: &[Partial],
        velocities: &[(usize, Option<usize>, Finding)],
        passport: &mut Passport,
    ) -> Vec<Vec<Finding>> {
        let Some(description) = self.description else { return Vec::new() };
        if let Some(finding) = self.computed(description) {
            return vec![vec![finding]];
        }
        // Only joints whose torque the description explains have a slope that says something.
        let telling: Vec<f64> = slopes.iter().filter(|p| p.share() > COUNTED_SLOPE_SHARE).map(Partial::slope).collect();
        let mut common = Vec::new();
        let negative = telling.iter().filter(|s| **s < 0.0).count();
        let all_signs = telling.len() >= 2 && 4 * negative >= 3 * telling.len();
        let scale = self.common_scale(&telling);
        let text = |p: &Partial| if p.share() > COUNTED_SLOPE_SHARE { significant(p.slope()) } else { "-".into() };
        let list = format!("slopes of the description {}", slopes.iter().map(text).collect::<Vec<_>>().join(" "));
        // The median slope tells a unit; three quarters of negative slopes tell signs, or the zero of a joint before them.
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
            // The search for single mistakes begins where those of all joints are undone.
            let (samples, rows, trials) = (self.samples, self.rows, &trials);
            let search = Search { samples, rows, trials, description, scale, velocities };
            let explanations = search.best(slopes);
            all.extend(
                explanations.into_iter().map(|one| self.explained(&search, one, slopes, &common, &list, passport)),
            );
        }
        // An explanation that bodies make needless explains nothing. The fewest mistakes come first.
        let is_needed = |found: &Vec<Finding>| !found.is_empty();
        if all.iter().any(is_needed) {
            all.retain(is_needed);
        }
        all.sort_by_key(Vec::len);
        if telling.is_empty() && all.iter().all(Vec::is_empty) {
            passport.untold.push("no joint's torque follows the description: units and signs cannot be told".into());
        }
        if all.iter().all(Vec::is_empty) {
            all = vec![self.common_factor(&telling, list).into_iter().collect()];
        }
        all
    }

    /// The findings of one explanation, behind those that all joints share.
    fn explained(
        &self,
        search: &Search,
        (mut changes, misfits): Explanation,
        slopes: &[Partial],
        common: &[Finding],
        list: &str,
        passport: &mut Passport,
    ) -> Vec<Finding> {
        let mut found = common.to_vec();
        let is_plain = changes.is_empty();
        // Of a short motion, what explains a part of it is chance.
        if passport.is_short {
            let runs_back = |change: &Change| {
                let of_sign = matches!(change.of, TorqueSign(_) | MotionSign(_));
                of_sign && change.of.joint().is_some_and(|k| passport.joints[k].runs_back())
            };
            let is_sure =
                |one: &Suspicion| one.after < SHORT_MISFIT_SHARE * one.before || one.changes.iter().all(runs_back);
            changes.retain(is_sure);
        }
        // Gains of motors are unlike.
        if !common.iter().any(|f| f.fault == Fault::NoTorque) {
            changes.extend(search.scaled(&changes, slopes));
        }
        found.extend(self.judged(&changes, list, passport));
        if is_plain {
            let exchanged: Vec<Suspicion> = search.exchanged(slopes, &passport.hidden_exchanges).into_iter().collect();
            found.extend(self.judged(&exchanged, list, passport));
            // What nothing explains: another robot, a common factor, or nothing that can be told.
            found.extend(self.other_robot(&misfits, slopes, search.scale, passport, list.into()));
        }
        found
    }

    /// The suspicions that the log needs as findings; those that other bodies explain as well go to the passport.
    fn judged(&self, changes: &[Suspicion], slopes: &str, passport: &mut Passport) -> Vec<Finding> {
        let free = FreeBodies { regressor: self.regressor, samples: self.samples, joints: &passport.joints };
        let needed = free.needed(changes);
        let of = |is_needed: bool| -> Vec<Suspicion> {
            let all = changes.iter().zip(&needed).filter(|(_, needed)| **needed == is_needed);
            all.map(|(change, _)| change.clone()).collect()
        };
        let [needed, explained] = [of(true), of(false)];
        for change in explained {
            let finding = self.changed(&change, slopes);
            let is_new = passport.explained.iter().all(|known| known.finding.joints != finding.joints);
            let is_likely = change.after < LIKELY_MISFIT_SHARE * change.before;
            passport.explained.extend(is_new.then_some(Explained { finding, is_likely }));
        }
        let needed = free.with_scales(needed);
        let is_new = |change: &&Suspicion| change.fault() != Fault::Of(Degrees, 0.0) || self.degrees().is_none();
        needed.iter().filter(is_new).map(|change| self.changed(change, slopes)).collect()
    }

    /// A factor that all slopes share.
    fn common_factor(&self, telling: &[f64], evidence: String) -> Option<Finding> {
        let middle = self.common_scale(telling);
        // A load, or other bodies, move some joints and not all of them to one side.
        let is_off =
            telling.iter().all(|s| *s > COMMON_FACTORS.end) || telling.iter().all(|s| *s < COMMON_FACTORS.start);
        let is_alike = |s: &&f64| (*s / middle - 1.0).abs() < ALIKE_SLOPES;
        let alike = 4 * telling.iter().filter(is_alike).count() >= 3 * telling.len();
        let remedy = format!(
            "the unit, the gains or the gear ratios of the torques are wrong, or all masses of the description are; if \
             the torques are: divide their columns by {}",
            significant(middle)
        );
        (telling.len() >= 2 && is_off && alike && NOMINAL_INERTIAL_SLOPES.contains(&middle))
            .then(|| self.all_scaled(Finding::of_all(Fault::Factor(middle), evidence, remedy), middle))
    }

    /// The median size of the slopes that tell; 1 where there are too few, because one joint of several may be wrong by
    /// itself, and where most are of other sizes.
    fn common_scale(&self, telling: &[f64]) -> f64 {
        let mut sizes: Vec<f64> = telling.iter().map(|s| s.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let are_enough = sizes.len() >= self.n().min(2);
        let middle = sizes.get(sizes.len() / 2).filter(|_| are_enough).copied().unwrap_or(1.0);
        let is_near = |s: &&f64| NOMINAL_INERTIAL_SLOPES.contains(&(*s / middle));
        if 3 * sizes.iter().filter(is_near).count() >= 2 * sizes.len() { middle } else { 1.0 }
    }

    /// Torques that are the description's to rounding, with no friction at all.
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
        let telling = slopes.iter().enumerate().filter(|(_, p)| p.share() > COUNTED_SLOPE_SHARE);
        let gains = telling.map(|(k, p)| format!("{}={}", self.name(k), significant(1.0 / p.slope().abs())));
        let remedy = format!(
            "name the columns as currents (i1, ..) and give the torque per ampere, by the description about [gain={}]; \
             or the ratios of the gears ([options.transmission.ratios])",
            gains.collect::<Vec<_>>().join(",")
        );
        let scaled = slopes.iter().enumerate().filter(|(_, p)| p.share() > COUNTED_SLOPE_SHARE);
        let undo = scaled.map(|(k, p)| Change { of: Scale(k), size: p.slope().abs() - 1.0 }).collect();
        Finding::of_all(Fault::NoTorque, evidence, remedy).undone_by(undo)
    }

    /// The same of a finding that all torques are so many times too large.
    fn all_scaled(&self, finding: Finding, factor: f64) -> Finding {
        let change = |k: usize| Change { of: Scale(k), size: factor - 1.0 };
        finding.undone_by((0..self.n()).map(change).collect())
    }

    fn changed(&self, found: &Suspicion, slopes: &str) -> Finding {
        let evidence = format!(
            "with that undone the description leaves {:.0} % of the torques (joints alike), as it is {:.0} %; {slopes}",
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
        // No column of a log has the torque of gravity.
        let is_in_log = found.changes.iter().all(|change| change.of != GravityCompensated);
        if is_in_log { finding.undone_by(found.changes.clone()) } else { finding }
    }

    fn other_robot(
        &self,
        misfits: &[f64],
        slopes: &[Partial],
        scale: f64,
        passport: &Passport,
        list: String,
    ) -> Option<Finding> {
        let is_heavy = |k: &usize| counts(&slopes[*k], scale, HEAVY_JOINT_SHARE);
        let heavy: Vec<usize> = (0..self.n()).filter(is_heavy).collect();
        let mean = heavy.iter().map(|&k| misfits[k]).sum::<f64>() / heavy.len().max(1) as f64;
        // Where the joint's own row cannot explain the torque either, it is noise and not another robot.
        let noisy = |k: usize| passport.joints[k].friction.is_some_and(|f| f.residual > NOISY_TORQUE_RESIDUAL);
        let clear = heavy.iter().any(|&k| !noisy(k));
        let evidence = format!(
            "the description leaves {:.0} % of the torques of the joints where it should explain most; {list}",
            100.0 * mean
        );
        (heavy.len() >= 2 && clear && mean > FOREIGN_ROBOT_MISFIT)
            .then(|| Finding::of_all(Fault::OtherRobot, evidence, OTHER_ROBOT))
    }

    /// A delay on which the joints agree.
    fn delay(&self) -> Option<Lag> {
        common_lag(self.regressor, self.samples, self.rows)
    }
}

/// Share of what is left that a delay explains where the description alone would say that this is another robot.
const SMALLEST_DELAY_SHARE_IF_FOREIGN: f64 = 0.5;

fn late(lag: &Lag) -> Finding {
    let evidence = format!("it explains {:.0} % of what the model leaves of the torques", 100.0 * lag.share);
    let remedy = format!("[delay=auto], which is exact; [delay={:.4}] is right to a third", lag.seconds);
    Finding::of_all(Fault::Of(Late(None), lag.seconds), evidence, remedy)
}

fn suspicions(velocities: &[(usize, Option<usize>, Finding)]) -> Vec<(usize, usize)> {
    velocities.iter().filter_map(|v| Some((v.0, v.1?))).collect()
}

/// Another robot is judged by joints where the description's torque is more than this share of the measured one, in
/// squares.
const HEAVY_JOINT_SHARE: f64 = 0.2;

/// |residual| / |torque| of the joint's own row above which its torque is noise.
const NOISY_TORQUE_RESIDUAL: f64 = 0.5;
