//! The verdict on a calibration: claims on the table, on what it determines, and on the error on postures that were left out.
//!
//! The error is compared with the spread of the measured points (angles: with 1 rad). Below 1 % it agrees with a robot of this
//! kind, above 5 % something is wrong. More parameters than zeros must predict better than zeros; else zeros are recommended.

use claims::{
    Claim, Figure, Need, Outcome, Purpose, Remedy, Subject, Topic, Trial, Trust, lowering, significant, worst,
};
use identification::estimate::topics::{LOG, PARAMETERS, ZERO, cannot_tell};
use identification::estimate::verdict::{sentence, what_mends};
use numerics::student::two_sided_quantile;

use crate::folds::PredictionError;
use crate::level::{Level, TestedGear, far_zeros, tested_gears};
use crate::measurement::Problem;
use crate::mistakes::{Mistake, spread};
use crate::parameter::ParameterNames;

/// The error on postures that were left out.
pub(crate) const PREDICTION: Topic = Topic("error on postures left out");
/// The scale of a joint.
const GEAR: Topic = Topic("gear scale");
/// Postures that are left out as wrong.
const OUTLIERS: Topic = Topic("postures");
/// Joints that stand still.
const MOTION: Topic = Topic("motion");

/// Largest error of a good calibration, relative to the spread of what is measured; above [`LARGE_SHARE`] it is a fault.
const SMALL_SHARE: f64 = 0.01;
const LARGE_SHARE: f64 = 0.05;
/// A joint stands still if its positions spread less than this, rad (m).
const STILL: f64 = 1e-4;
/// Level of the test of all gear scales together, and chance with which a fault of the printed size shows.
const GEAR_LEVEL: f64 = 0.01;
const POWER: f64 = 0.95;
/// A scale is not said to agree if only a larger error than this would show.
const LARGEST_GEAR: f64 = 0.1;

/// Whether a calibration can be used.
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

/// One number for the comparison of errors: lengths and angles relative to those of another fit.
fn relative(error: &PredictionError, to: &PredictionError) -> f64 {
    let ratio = |a: Option<f64>, b: Option<f64>| Some(a? / b?.max(f64::MIN_POSITIVE));
    let ratios: Vec<f64> =
        [ratio(error.length, to.length), ratio(error.angle, to.angle)].into_iter().flatten().collect();
    let product: f64 = ratios.iter().product();
    product.powf(1.0 / ratios.len().max(1) as f64)
}

fn figure(error: &PredictionError) -> Figure {
    match (error.length, error.angle) {
        (Some(length), _) => Figure::new(1e3 * length, "mm"),
        (None, angle) => Figure::new(1e3 * angle.unwrap_or(f64::NAN), "mrad"),
    }
}

/// The verdict on the last of the levels.
pub(crate) fn verdict(
    problem: &Problem,
    names: &ParameterNames,
    levels: &[Level],
    mistakes: &[Mistake],
) -> CalibrationVerdict {
    let recommended = best(levels);
    let Some(level) = levels.last() else {
        return CalibrationVerdict { trust: Trust::No, claims: vec![], reasons: vec![], next: None, recommended };
    };
    let mut claims: Vec<Claim> = mistakes.iter().map(of_mistake).collect();
    claims.push(of_prediction(problem, levels, recommended));
    claims.extend(of_motion(problem, names));
    claims.extend(of_parameters(names, problem, level));
    claims.extend(of_zeros(problem, names, level));
    claims.extend(of_outliers(problem, level));
    if mistakes.is_empty() {
        claims.extend(of_gears(problem, names, level));
    }
    let further = [LOG, PARAMETERS, ZERO, OUTLIERS, MOTION].map(|topic| Need::where_claimed(Subject::whole(topic)));
    let purpose = Purpose::new("poses of the robot", Need::new(Subject::whole(PREDICTION)));
    let purpose = further.into_iter().fold(purpose, Purpose::and).and(Need::uncontradicted(Subject::whole(GEAR)));
    let trust = worst(&claims, &purpose).trust();
    let lowered = lowering(&claims, &purpose);
    let of_it = |claim: &&&Claim| trust != Trust::No || claim.is_contradicted();
    let lowered: Vec<&Claim> = lowered.iter().filter(of_it).copied().collect();
    let (reasons, next) = (lowered.iter().map(|c| sentence(c)).collect(), lowered.first().map(|c| what_mends(c)));
    CalibrationVerdict { trust, reasons, next, recommended, claims }
}

/// The level with the smallest error on postures that were left out; of equal ones the first.
fn best(levels: &[Level]) -> usize {
    let Some(first) = levels.first() else { return 0 };
    let of = |k: &usize| relative(&levels[*k].left_out, &first.left_out);
    (0..levels.len()).min_by(|a, b| of(a).total_cmp(&of(b))).unwrap_or(0)
}

fn of_mistake(mistake: &Mistake) -> Claim {
    let [before, after] = mistake.shares.map(|x| Figure::new(100.0 * x, "% of the spread"));
    let trial = Trial::Tried { quantity: "median error".into(), before, after };
    let remedy = Remedy::new("calibrate", format!("in the file of [options]: {}", mistake.corrections));
    Claim::new(Subject::whole(LOG), Outcome::Contradicted { fault: mistake.fault.clone(), remedy, trial })
}

fn of_prediction(problem: &Problem, levels: &[Level], recommended: usize) -> Claim {
    let subject = Subject::whole(PREDICTION);
    let last = levels.len() - 1;
    let (level, best) = (&levels[last], &levels[recommended]);
    if recommended != last {
        // A fit of frames alone has no errors of the robot: then the description is as good.
        let (advice, remedy) = match best.what {
            "zeros" => ("calibrate zeros alone", Remedy::new("calibrate", "[what=zeros]").with("what", "zeros")),
            _ => ("keep the description", Remedy::new("calibrate", "keep the description, or measure more postures")),
        };
        let fault = format!(
            "{} predicts worse than {} on postures that were left out ({} against {}): {advice}",
            level.what,
            best.what,
            shown(&level.left_out),
            shown(&best.left_out)
        );
        let (before, after) = (figure(&level.left_out), figure(&best.left_out));
        let trial = Trial::Tried { quantity: "error".into(), before, after };
        return Claim::new(subject, Outcome::Contradicted { fault, remedy, trial });
    }
    let of_length = level.left_out.length.map_or(0.0, |x| x / spread(problem));
    let share = of_length.max(level.left_out.angle.unwrap_or(0.0));
    if share <= SMALL_SHARE {
        return Claim::new(subject, Outcome::Agrees { smallest: figure(&level.left_out) });
    }
    let why = format!(
        "the error on postures left out is {}, {} % of the spread",
        shown(&level.left_out),
        significant(100.0 * share, 2)
    );
    if share <= LARGE_SHARE {
        return cannot_tell(subject, why, "better measurements, or more postures");
    }
    let remedy = Remedy::new("calibrate", "look at the joints, the link that is measured, and the columns");
    let trial = Trial::NotTried { why: "no unit, order, sign or inverse of the table explains it".into() };
    Claim::new(subject, Outcome::Contradicted { fault: why, remedy, trial })
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

/// Base parameters that the postures do not determine, although other postures would.
fn of_parameters(names: &ParameterNames, problem: &Problem, level: &Level) -> Option<Claim> {
    let all: Vec<String> = level.undetermined.iter().map(|&k| names.of(problem.parameters[k]).to_string()).collect();
    let why = format!("these postures do not determine {}", all.join(", "));
    (!all.is_empty()).then(|| cannot_tell(Subject::whole(PARAMETERS), why, "postures that differ in more joints"))
}

/// Zeros that are so far off that another sign or order of the joints may be the reason.
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

/// For each gear scale, whether it differs from 1, and the smallest error that would have shown.
fn of_gears(problem: &Problem, names: &ParameterNames, level: &Level) -> Vec<Claim> {
    let gears = tested_gears(problem, level);
    let freedom = level.fit.freedom;
    let limit = two_sided_quantile(GEAR_LEVEL / gears.len().max(1) as f64, freedom);
    let power = limit + two_sided_quantile(2.0 * (1.0 - POWER), freedom);
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
                cannot_tell(subject, why, "postures over the whole range of the joint")
            }
            Some((_, sigma)) => {
                Claim::new(subject, Outcome::Agrees { smallest: Figure::new(100.0 * power * sigma, "%") })
            }
        }
    };
    gears.iter().map(claim).collect()
}
