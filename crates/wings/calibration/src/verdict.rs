//! Makes the verdict on a calibration: claims on the table of postures, on the parameters that the table determines, and on
//! the error on postures that were left out of the fit.
//!
//! The error is divided by the spread of the measured points (angles: by 1 rad). If the result is below 1 %, the fit agrees
//! with the measurements. If it is above 5 %, something is wrong. A fit with more parameters than the zeros must not predict
//! worse than the fit of the zeros. If it predicts worse, by a test of the squared errors of all postures, the verdict
//! recommends the fit of the zeros.
//!
//! A claim is one statement with its evidence. A level is one fit: of the frames of base and tool alone, with zeros, with the
//! geometry or the compliances. The spread of the measurements is the root mean square distance of the measured points from
//! their mean.

use claims::{
    Claim, Figure, Need, Outcome, Purpose, Remedy, Subject, Topic, Trial, Trust, lowering, significant, worst,
};
use identification::estimate::topics::{LOG, PARAMETERS, ZERO, cannot_tell};
use identification::estimate::verdict::{sentence, what_mends};
use robot::Robot;

use crate::determined::{Determination, OTHER_ANGLES, OTHER_LENGTHS};
use crate::folds::{PredictionError, paired};
use crate::gears::{GEAR, of_gears};
use crate::level::{Level, far_zeros};
use crate::measurement::Problem;
use crate::mistakes::{ANGLE_SPREAD, Mistake, spread, spread_of_links};
use crate::parameter::ParameterNames;

/// Topic of claims on the error of lengths, on postures that were left out of the fit.
const LENGTHS: Topic = Topic("error of lengths on postures left out");
/// Topic of claims on the error of angles, on postures that were left out of the fit.
const ANGLES: Topic = Topic("error of angles on postures left out");
/// Topic of claims on the comparison of the fits, on postures that were left out.
const COMPARISON: Topic = Topic("comparison of the fits");
/// Topic of claims on postures that are left out because they seem wrong.
const OUTLIERS: Topic = Topic("postures");
/// Topic of claims on joints whose position follows from loops.
const LOOPS: Topic = Topic("loops");
/// Topic of claims on joints that stand still.
const MOTION: Topic = Topic("motion");

/// Largest error of a good calibration, relative to the spread of the measurements. An error above [`LARGE_SHARE`] is a fault.
const SMALL_SHARE: f64 = 0.01;
const LARGE_SHARE: f64 = 0.05;
/// Two errors count as equal if their ratio is below this value.
const SAME: f64 = 1.01;
/// Quantile of a one-sided test of 95 %.
const ONE_SIDED: f64 = 1.645;
/// The measured points count as being at rest if their spread is below this share of the spread of the last link.
const AT_REST: f64 = 0.02;
/// A joint stands still if its positions spread less than this, rad (m).
const STILL: f64 = 1e-4;

/// The verdict on a calibration: the trust in it, with the claims and the reasons.
pub struct CalibrationVerdict {
    /// Level of trust in the fit that was asked for.
    pub trust: Trust,
    /// All claims.
    pub claims: Vec<Claim>,
    /// For each claim that lowers the trust, a sentence.
    pub reasons: Vec<String>,
    /// The remedy of the first claim that lowers the trust.
    pub next: Option<String>,
    /// Index of the level with the smallest error on postures that were left out.
    pub recommended: usize,
}

/// An error as a text: `1.23 mm, 0.45 mrad`.
pub(crate) fn shown(error: &PredictionError) -> String {
    let part = |x: Option<f64>, unit: &str| x.map(|x| format!("{} {unit}", significant(1e3 * x, 3)));
    part(error.length, "mm").into_iter().chain(part(error.angle, "mrad")).collect::<Vec<_>>().join(", ")
}

/// The verdict on the last level, which is the fit that the user asked for.
pub(crate) fn verdict(
    robot: &Robot,
    problem: &Problem,
    names: &ParameterNames,
    levels: &[Level],
    mistakes: &[Mistake],
) -> CalibrationVerdict {
    let recommended = best(problem, levels);
    let Some(level) = levels.last() else {
        return CalibrationVerdict { trust: Trust::No, claims: vec![], reasons: vec![], next: None, recommended };
    };
    let mut claims: Vec<Claim> = mistakes.iter().map(of_mistake).collect();
    claims.extend(of_comparison(problem, levels, recommended));
    claims.extend(of_prediction(problem, levels));
    claims.extend(of_motion(problem, names));
    // A mistake in the table makes the parameters wrong. So claims on them are made only for a table without mistakes.
    if mistakes.is_empty() {
        let determination = Determination { robot, problem, names, level };
        claims.extend(determination.of_parameters());
        claims.extend(determination.of_other_postures());
        claims.extend(of_gears(problem, names, level));
    }
    claims.extend(of_zeros(problem, names, level));
    claims.extend(of_outliers(problem, level));
    claims.extend(of_loops(robot, problem));
    // Trust needs a claim on the error on left-out postures. The other topics count only if a claim on them exists.
    let measured = if level.left_out.length.is_some() { LENGTHS } else { ANGLES };
    let purpose = Purpose::new("poses of the robot", Need::new(Subject::whole(measured)));
    let others = [OTHER_LENGTHS, OTHER_ANGLES, PARAMETERS, ZERO, OUTLIERS, LOOPS, MOTION];
    let further = [LOG, COMPARISON, LENGTHS, ANGLES].into_iter().chain(others);
    let further = further.map(|topic| Need::where_claimed(Subject::whole(topic)));
    let purpose = further.fold(purpose, Purpose::and).and(Need::uncontradicted(Subject::whole(GEAR)));
    let trust = worst(&claims, &purpose).trust();
    let lowered = lowering(&claims, &purpose);
    // If the trust is `No`, only the contradicted claims are named as reasons.
    let of_it = |claim: &&&Claim| trust != Trust::No || claim.is_contradicted();
    let lowered: Vec<&Claim> = lowered.iter().filter(of_it).copied().collect();
    let (reasons, next) = (lowered.iter().map(|c| sentence(c)).collect(), lowered.first().map(|c| what_mends(c)));
    CalibrationVerdict { trust, reasons, next, recommended, claims }
}

/// The error of each level on postures that were left out in turn. Postures that the last level leaves out as wrong do not
/// count.
pub(crate) fn errors(problem: &Problem, levels: &[Level]) -> Vec<PredictionError> {
    let Some(last) = levels.last() else { return Vec::new() };
    levels.iter().map(|level| level.left_out_on(problem, &last.fit.used)).collect()
}

/// The level with the smallest error on postures that were left out. If several levels have this error, the first of them.
fn best(problem: &Problem, levels: &[Level]) -> usize {
    let errors = errors(problem, levels);
    let Some(first) = errors.first() else { return 0 };
    let of = |k: &usize| errors[*k].relative(first);
    (0..errors.len()).min_by(|a, b| of(a).total_cmp(&of(b))).unwrap_or(0)
}

fn of_mistake(mistake: &Mistake) -> Claim {
    let [before, after] = mistake.shares.map(|x| Figure::new(100.0 * x, "% of the spread"));
    let trial = Trial::Tried { quantity: "median error".into(), before, after };
    let remedy = match &mistake.tip {
        Some(tip) => Remedy::new("calibrate", format!("name the link that was measured: [tip={tip}]")).with("tip", tip),
        None => Remedy::new("calibrate", format!("in the file of [options]: {}", mistake.corrections)),
    };
    Claim::new(Subject::whole(LOG), Outcome::Contradicted { fault: mistake.fault.clone(), remedy, trial })
}

/// A claim on the comparison: whether another fit predicts better than the fit that the user asked for.
fn of_comparison(problem: &Problem, levels: &[Level], recommended: usize) -> Option<Claim> {
    let level = levels.last()?;
    let errors = errors(problem, levels);
    let (own, least) = (errors.last()?, errors.get(recommended)?);
    let best = levels.get(recommended).filter(|_| recommended + 1 < levels.len())?;
    // If the fit of the frames alone predicts best, the advice is to use the description unchanged.
    let (advice, remedy) = match best.what {
        "zeros" => ("calibrate zeros alone", Remedy::new("calibrate", "[what=zeros]").with("what", "zeros")),
        _ => ("keep the description", Remedy::new("calibrate", "keep the description, or measure more postures")),
    };
    let fault = format!(
        "{} predicts worse than {} on postures that were left out ({} against {}): {advice}",
        level.what,
        best.what,
        shown(own),
        shown(least)
    );
    let is_clear = own.relative(least) > SAME && paired(&level.each, &best.each, &level.fit.used) > ONE_SIDED;
    if !is_clear {
        return None;
    }
    let (before, after) = own.compared(least);
    let trial = Trial::Tried { quantity: "error".into(), before, after };
    Some(Claim::new(Subject::whole(COMPARISON), Outcome::Contradicted { fault, remedy, trial }))
}

/// Claims on the errors of lengths and of angles on postures that were left out, relative to the spread of the measurements.
fn of_prediction(problem: &Problem, levels: &[Level]) -> Vec<Claim> {
    let errors = errors(problem, levels);
    let (Some(first), Some(last)) = (errors.first(), errors.last()) else { return Vec::new() };
    // A root mean square of n errors has the relative standard deviation 1 / sqrt(2 n).
    let sure = (1.0 - ONE_SIDED / (2.0 * problem.postures.len() as f64).sqrt()).max(0.5);
    let spread = spread(problem);
    let kinds =
        [(LENGTHS, first.length, last.length, spread, "mm"), (ANGLES, first.angle, last.angle, ANGLE_SPREAD, "mrad")];
    let claim = |(topic, before, after, scale, unit): (Topic, Option<f64>, Option<f64>, f64, &str)| {
        let (before, after, subject) = (before?, after?, Subject::whole(topic));
        if after <= SMALL_SHARE * scale {
            let smallest = Figure::new(1e3 * SMALL_SHARE * scale / sure, unit);
            return Some(Claim::new(subject, Outcome::Agrees { smallest }));
        }
        let shown = |x: f64| significant(1e3 * x, 3);
        let why = format!(
            "on postures left out the error is {} {unit}, and {} {unit} by the description alone; at most {} {unit} is expected \
             of a robot of this size",
            shown(after),
            shown(before),
            shown(SMALL_SHARE * scale)
        );
        if after <= LARGE_SHARE * scale {
            return Some(cannot_tell(subject, why, "better measurements, or more postures"));
        }
        let of_links = spread_of_links(problem);
        if topic == LENGTHS && spread < AT_REST * of_links {
            return Some(at_rest(subject, spread, of_links));
        }
        let remedy = Remedy::new("calibrate", "look at the joints, the link that is measured, and the columns");
        let trial = Trial::NotTried { why: "no unit, order, sign, inverse or other link explains the table".into() };
        Some(Claim::new(subject, Outcome::Contradicted { fault: why, remedy, trial }))
    };
    kinds.into_iter().filter_map(claim).collect()
}

/// The fault that the measured points do not move with the robot.
fn at_rest(subject: Subject, spread: f64, of_links: f64) -> Claim {
    let fault = format!(
        "what is measured moves by {} mm (root mean square) and the last link by {} mm: it is not on the robot that moves",
        significant(1e3 * spread, 3),
        significant(1e3 * of_links, 3)
    );
    let remedy =
        Remedy::new("calibrate", "measure a marker on the last link, and look at which pose is in the columns");
    let trial = Trial::NotTried { why: "it needs other measurements".into() };
    Claim::new(subject, Outcome::Contradicted { fault, remedy, trial })
}

fn of_motion(problem: &Problem, names: &ParameterNames) -> Vec<Claim> {
    let still = |k: &usize| {
        let all = problem.postures.iter().map(|p| p.q[*k]);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low < STILL
    };
    let name = |k: usize| names.coordinates[problem.chain.coordinates[k]].clone();
    let claim = |k: usize| {
        let why = format!("joint {} never moves in these postures", name(k));
        cannot_tell(Subject::of(MOTION, [name(k)]), why, format!("postures in which {} moves", name(k)))
    };
    (0..problem.chain.coordinates.len()).filter(still).map(claim).collect()
}

/// A claim on zeros that are so large that a wrong sign or order of the joints may be the cause.
fn of_zeros(problem: &Problem, names: &ParameterNames, level: &Level) -> Vec<Claim> {
    let claim = |k: usize| {
        let name = &names.coordinates[problem.chain.coordinates[k]];
        let why = format!(
            "the zero of {name} is {} rad (m) off, which a sign of another joint may explain too",
            significant(level.fit.unknowns.chain[k], 3)
        );
        cannot_tell(Subject::of(ZERO, [name]), why, "the sign of each joint on the robot")
    };
    far_zeros(problem, &level.fit.unknowns).into_iter().map(claim).collect()
}

fn of_outliers(problem: &Problem, level: &Level) -> Option<Claim> {
    let out = problem.postures.iter().zip(&level.fit.used).filter(|(_, used)| !**used);
    let lines: Vec<String> = out.map(|(posture, _)| posture.line.to_string()).collect();
    let what = format!("the postures of the lines {} are wrong, and are left out of the fit", lines.join(", "));
    (!lines.is_empty()).then(|| Claim::new(Subject::whole(OUTLIERS), Outcome::Assumed { what, by: "the fit".into() }))
}

/// A claim on the joints of the chain that follow from several coordinates (joints of a parallelogram): the lengths of their
/// loop keep the nominal values, because they are not calibrated.
fn of_loops(robot: &Robot, problem: &Problem) -> Option<Claim> {
    let follows = |j: &&robot::LinkId| robot.link(**j).joint.variable.terms.len() > 1;
    let joints = problem.chain.links.iter().filter(follows).map(|j| robot.link(*j).joint.name.clone());
    let joints: Vec<String> = joints.collect();
    let what = format!("the loop that moves {} has its nominal lengths", joints.join(", "));
    let subject = Subject::of(LOOPS, joints.clone());
    (!joints.is_empty()).then(|| Claim::new(subject, Outcome::Assumed { what, by: "the description".into() }))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use random::Random;

    use super::*;
    use crate::chain::{Chain, Convention, Placed};
    use crate::corrections::TableCorrections;
    use crate::laws::calibrated;
    use crate::measurement::MeasurementKind;
    use crate::request::{CalibrateRequest, Calibrated};
    use crate::simulated::{arm, measured, problem, truth};

    fn of_workspace(path: &str) -> Robot {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../..").join(path);
        rist::read_robot(&path, &rist::ModelOptions::default()).unwrap()
    }

    /// A calibration of 60 poses, with noise of this size, m (rad), and errors of the geometry.
    fn found(robot: &Robot, noise: f64) -> crate::calibrate::Calibration {
        let mut random = Random::new(31);
        let problem = problem(robot, Convention::Dh, MeasurementKind::Pose, 60, &mut random);
        let truth = truth(&problem, 0.02, 5e-4, &mut random);
        let problem = measured(&problem, &truth, [noise; 2], &mut random);
        calibrated(robot, &problem, TableCorrections::default(), Calibrated::Geometry)
    }

    /// The error on postures left out is printed for the description alone and for the calibrated robot. The claim "agrees"
    /// states another number: the smallest error that would have been detected. With noise of 1 % of the spread, the verdict is
    /// "with care", and with 10 % it is "no".
    #[test]
    fn the_error_on_postures_left_out_is_what_was_measured() {
        let good = found(&arm(), 1e-4);
        let [before, after] = [0, 2].map(|k| shown(&good.levels[k].left_out));
        let line = format!("error on postures left out: {before} by the description alone, {after} calibrated\n");
        assert!(good.to_string().contains(&line), "{good}");
        let smallest = |topic: Topic| {
            let of = good.verdict.claims.iter().find(|claim| claim.subject().topic == topic).map(Claim::outcome);
            if let Some(Outcome::Agrees { smallest }) = of { smallest.value } else { panic!("{good}") }
        };
        let spread = 1e3 * spread(&good.problem);
        // The smallest error is 1 % of the spread or of 1 rad, plus an allowance for the random error of a root mean square of
        // 60 errors.
        assert!((0.01..0.013).contains(&(smallest(LENGTHS) / spread)) && (10.0..13.0).contains(&smallest(ANGLES)));
        for (noise, trust) in [(1e-4, Trust::Yes), (1e-2, Trust::WithCare), (0.1, Trust::No)] {
            let found = found(&arm(), noise);
            assert_eq!(found.verdict.trust, trust, "{noise} {found}");
            let is_said = found.to_string().contains("on postures left out the error is");
            assert_eq!(is_said, trust != Trust::Yes, "{found}");
        }
    }

    /// A fit of the geometry that predicts as well as the fit of the zeros is no fault.
    #[test]
    fn a_fit_that_predicts_as_well_is_no_fault() {
        let poor = found(&arm(), 1e-2);
        assert!(poor.recommended().what == "zeros" && !poor.to_string().contains("predicts worse than"), "{poor}");
        assert!(!found(&arm(), 1e-4).to_string().contains("predicts worse than"));
    }

    /// The zeros of the description are correct. With few noisy postures, fitted zeros predict worse than fitted frames alone,
    /// and the program says so. With many postures, it does not.
    #[test]
    fn a_fit_that_predicts_worse_is_named() {
        let of = |count: usize, seed: u64| {
            let mut random = Random::new(seed);
            let problem = problem(&arm(), Convention::Dh, MeasurementKind::Points(1), count, &mut random);
            let truth = truth(&problem, 0.0, 0.0, &mut random);
            let problem = measured(&problem, &truth, [5e-3; 2], &mut random);
            calibrated(&arm(), &problem, TableCorrections::default(), Calibrated::Zeros)
        };
        let few = of(12, 1);
        assert!(few.verdict.trust == Trust::No && few.to_string().contains("predicts worse than frames"), "{few}");
        assert_eq!(few.recommended().what, "frames");
        let many = of(200, 1);
        assert!(!many.to_string().contains("predicts worse"), "{many}");
    }

    /// A parallelogram moves joint 3 of the SR400. The chain has the same poses as the robot, and a claim says that the lengths
    /// of the parallelogram are assumed. A robot whose joints follow from numerically solved loops is refused.
    #[test]
    fn loops_are_assumed_or_refused() {
        let robot = of_workspace("models/sr400.par");
        let tip = robot.link_ids().nth(5).unwrap();
        let chain = Chain::new(&robot, tip, Convention::Dh).unwrap();
        let q: Vec<f64> = (0..robot.n_coordinates()).map(|k| 0.3 + 0.2 * k as f64).collect();
        let own: Vec<f64> = chain.coordinates.iter().map(|k| q[*k]).collect();
        let pose = chain.pose(&own, &vec![0.0; own.len()], &vec![0.0; chain.parameters.len()]);
        // Rounding of about fifty products of lengths of 1 m.
        assert!((pose.position - Placed::of(&robot.link_poses(&q)[5]).position).norm() < 1e-13);
        let problem = Problem::new(chain, MeasurementKind::Pose, vec![]);
        let claim = of_loops(&robot, &problem).unwrap().to_string();
        assert!(claim.contains("assumed by the description: the loop that moves"), "{claim}");
        let plain = Chain::new(&arm(), arm().link_ids().last().unwrap(), Convention::Dh).unwrap();
        assert!(of_loops(&arm(), &Problem::new(plain, MeasurementKind::Pose, vec![])).is_none());

        let robot = of_workspace("tests/data/loops/four_bars_in_series.yaml");
        let request = CalibrateRequest::default();
        let refused = crate::calibrate::chain_of(&robot, &request).err().unwrap().to_string();
        assert!(
            refused.contains("follows from a loop that is solved numerically") && refused.contains("[tip]"),
            "{refused}"
        );
    }
}
