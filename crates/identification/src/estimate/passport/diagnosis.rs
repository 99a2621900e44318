//! From the numbers of a passport to its findings: the checks in their order, each with its thresholds.
//!
//! Checks that need no inertials come first: dead and saturated torques, a log too short, velocities that are not the
//! slopes of their positions, and friction that drives. With inertials, the slopes then tell of all torques (unit,
//! currents, signs), of one joint or two and of gravity (`search`), and of the clock. What nothing explains is another
//! robot.

use linear_model::regressor::Regressor;
use logs::Suspect;

use crate::estimate::digits::significant;
use crate::estimate::hypothesis::Hypothesis::{Degrees, Late, SwappedPositions, SwappedVelocities};
use crate::estimate::passport::change::Description;
use crate::estimate::passport::delay::{Lag, common_lag};
use crate::estimate::passport::finding::{COMMON_FACTORS, Fault, Finding, NOMINAL_INERTIAL_SLOPES, OTHER_TORQUE_SIGN};
use crate::estimate::passport::free_bodies::FreeBodies;
use crate::estimate::passport::regression::Partial;
use crate::estimate::passport::report::{COUNTED_SLOPE_SHARE, Explained, Passport};
use crate::estimate::passport::samples::Samples;
use crate::estimate::passport::search::{LIKELY_MISFIT_SHARE, Search, Suspicion, counts};
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
        findings.extend(self.short());
        findings.extend(self.degrees());
        let velocities = self.velocities();
        let wrong_velocities = !velocities.is_empty();
        let found = slopes.filter(|_| !is_dead).map(|slopes| self.described(slopes, &velocities, passport));
        let found = found.unwrap_or_default();
        if slopes.is_none() {
            let why =
                "the description has no inertials: units, zeros, swapped columns and another robot cannot be told";
            passport.untold.push(why.into());
        }
        // Columns that are exchanged are no slopes of their own positions.
        let is_exchange = |f: &Finding| matches!(f.fault, Fault::Of(SwappedPositions(..) | SwappedVelocities(..), _));
        if !found.iter().any(is_exchange) {
            findings.extend(velocities.into_iter().map(|v| v.2));
        }
        findings.extend(found);
        let motion = |f: &Finding| !matches!(f.fault, Fault::Saturated(_) | Fault::Of(Late(_), _));
        if !wrong_velocities && !findings.iter().any(|f| motion(f) && f.joints.is_empty()) {
            findings.extend(self.friction(passport, &findings));
        }
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

    /// What the slopes of the description say.
    fn described(
        &self,
        slopes: &[Partial],
        velocities: &[(usize, Option<usize>, Finding)],
        passport: &mut Passport,
    ) -> Vec<Finding> {
        let Some(description) = self.description else { return Vec::new() };
        if let Some(finding) = self.computed(description) {
            return vec![finding];
        }
        // Only joints whose torque the description explains have a slope that says something.
        let telling: Vec<f64> = slopes.iter().filter(|p| p.share() > COUNTED_SLOPE_SHARE).map(Partial::slope).collect();
        let mut found = Vec::new();
        let negative = telling.iter().filter(|s| **s < 0.0).count();
        let all_signs = telling.len() >= 2 && 4 * negative >= 3 * telling.len();
        let scale = self.common_scale(&telling);
        let list = || {
            let text = |p: &Partial| if p.share() > COUNTED_SLOPE_SHARE { significant(p.slope()) } else { "-".into() };
            let texts: Vec<String> = slopes.iter().map(text).collect();
            format!("slopes of the description {}", texts.join(" "))
        };
        // The median slope tells a unit; three quarters of negative slopes tell signs.
        if !NOMINAL_INERTIAL_SLOPES.contains(&scale) {
            found.push(self.unit(scale, slopes, list()));
        }
        if all_signs {
            found.push(Finding::of_all(Fault::TorqueSigns, list(), OTHER_TORQUE_SIGN));
        }
        // The search for single mistakes begins where those of all joints are undone. A description is as nominal with
        // the signs of all torques changed as without.
        let size = if NOMINAL_INERTIAL_SLOPES.contains(&scale) { 1.0 } else { scale };
        let scale = if all_signs { -size } else { size };
        let trials = Trials::new(description, &self.samples.kept, self.rows);
        let search = Search {
            samples: self.samples,
            rows: self.rows,
            trials: &trials,
            description,
            scale,
            velocities: &suspicions(velocities),
        };
        let (changes, misfits) = search.best(slopes);
        found.extend(self.judged(&changes, &list(), passport));
        if changes.is_empty() {
            let exchanged: Vec<Suspicion> = search.exchanged(slopes, &passport.hidden_exchanges).into_iter().collect();
            found.extend(self.judged(&exchanged, &list(), passport));
        }
        // What nothing explains: another robot, a common factor, or nothing that can be told.
        if changes.is_empty() {
            found.extend(self.other_robot(&misfits, slopes, scale, passport, list()));
        }
        if found.is_empty() {
            found.extend(self.common_factor(&telling, list()));
        }
        if telling.is_empty() && found.is_empty() {
            passport.untold.push("no joint's torque follows the description: units and signs cannot be told".into());
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
        let explained = explained.iter().map(|change| Explained {
            finding: self.changed(change, &explained, slopes),
            is_likely: change.after < LIKELY_MISFIT_SHARE * change.before,
        });
        passport.explained.extend(explained);
        let is_new = |change: &&Suspicion| change.fault() != Fault::Of(Degrees, 0.0) || self.degrees().is_none();
        needed.iter().filter(is_new).map(|change| self.changed(change, &needed, slopes)).collect()
    }

    /// A factor that all slopes share.
    fn common_factor(&self, telling: &[f64], evidence: String) -> Option<Finding> {
        let middle = self.common_scale(telling);
        // A load, or other bodies, move some joints and not all of them to one side.
        let is_off =
            telling.iter().all(|s| *s > COMMON_FACTORS.end) || telling.iter().all(|s| *s < COMMON_FACTORS.start);
        let alike = telling.iter().all(|s| (s / middle - 1.0).abs() < ALIKE_SLOPES);
        let remedy = format!(
            "the unit, the gains or the gear ratios of the torques are wrong, or all masses of the description are; if \
             the torques are: divide their columns by {}",
            significant(middle)
        );
        (telling.len() >= 2 && is_off && alike && NOMINAL_INERTIAL_SLOPES.contains(&middle))
            .then(|| Finding::of_all(Fault::Factor(middle), evidence, remedy))
    }

    /// The median size of the slopes that tell; 1 where there are too few, because one joint of several may be wrong by
    /// itself.
    fn common_scale(&self, telling: &[f64]) -> f64 {
        let mut sizes: Vec<f64> = telling.iter().map(|s| s.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let are_enough = sizes.len() >= self.n().min(2);
        sizes.get(sizes.len() / 2).filter(|_| are_enough).copied().unwrap_or(1.0)
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
            return Finding::of_all(Fault::TorqueUnit(power as i32), evidence, word);
        }
        let telling = slopes.iter().enumerate().filter(|(_, p)| p.share() > COUNTED_SLOPE_SHARE);
        let gains = telling.map(|(k, p)| format!("{}={}", self.name(k), significant(1.0 / p.slope().abs())));
        let remedy = format!(
            "name the columns as currents (i1, ..) and give the torque per ampere, by the description about [gain={}]; \
             or the ratios of the gears ([options.transmission.ratios])",
            gains.collect::<Vec<_>>().join(",")
        );
        Finding::of_all(Fault::NoTorque, evidence, remedy)
    }

    fn changed(&self, found: &Suspicion, all: &[Suspicion], slopes: &str) -> Finding {
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
        let remedy = found.remedy(self.n(), all);
        Finding { fault: found.fault(), joints, evidence, remedy }
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
        let remedy = "no single sign, zero, unit or exchange of columns mends it: look for another model, another tool or \
                      mounting (gravity), or several mistakes at once";
        (heavy.len() >= 2 && clear && mean > FOREIGN_ROBOT_MISFIT)
            .then(|| Finding::of_all(Fault::OtherRobot, evidence, remedy))
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

/// Mean misfit of these joints from which on the robot is another.
const FOREIGN_ROBOT_MISFIT: f64 = 0.6;

/// |residual| / |torque| of the joint's own row above which its torque is noise.
const NOISY_TORQUE_RESIDUAL: f64 = 0.5;
