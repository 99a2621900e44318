//! An identification with unknowns beside the parameters: mount, zeros, scales, springs.
//!
//! Gauss-Newton: the model and the options hold a guess, a step of
//! [`step`](identification::estimate::ledger::unknowns::step) says by how much it is wrong, and the logs are looked at
//! again with the guess mended, until no step is above a tenth of its deviation. The identification behind it is an
//! ordinary one with what was found, and its deviations allow for those of the unknowns.

use identification::estimate::digits::significant;
use identification::estimate::ledger::hypotheses::Hypothesis;
use identification::estimate::ledger::unknowns::{Step, ZERO_PRIOR_RAD, step};
use identification::signals::records::SourceRecords;
use logs::LogSource;
use nalgebra::{Rotation3, Vector3};

use crate::chosen::{Looked, choose, with_open};
use crate::description::{turn_base, turn_of_rpy};
use crate::drive_gains::drive_gains;
use crate::error::Error;
use crate::gravity_direction::{gravity, mounted, turn};
use crate::model::Model;
use crate::request::{SamplesRequest, Unknown, Words};

/// Steps until the search is given up; errors of 30 degrees took five.
const MOST_STEPS: usize = 12;
/// A step below this share of its deviation changes nothing.
const SETTLED_SHARE: f64 = 0.1;
/// The same of a step beside what was found, where the log has no noise: of a derivative by differences.
const ROUNDING: f64 = 1e-6;
/// Larger steps leave what the linearisation is good for, rad.
const LARGEST_ANGLE_STEP: f64 = 0.5;
/// The same of a scale, less one.
const LARGEST_SCALE_STEP: f64 = 0.5;

/// What is held for true until the next step.
struct Guess {
    /// The base, as a turn from the frame that gravity of the description is given in.
    base: Rotation3<f64>,
    zeros: Vec<f64>,
    scales: Vec<f64>,
    springs: Vec<f64>,
}

impl Guess {
    /// That of the options, or that nothing is wrong.
    fn of(model: &Model, request: &SamplesRequest) -> Guess {
        let n = model.robot.n_coordinates();
        let base = model.description.as_ref().and_then(|d| d.base).unwrap_or_default();
        let transmission = request.options().transmission;
        Guess {
            base: turn_of_rpy(base),
            zeros: transmission.offsets.unwrap_or_else(|| vec![0.0; n]),
            scales: transmission.scales.unwrap_or_else(|| vec![1.0; n]),
            springs: transmission.springs.unwrap_or_else(|| vec![0.0; n]),
        }
    }

    fn take(&mut self, steps: &[Step]) {
        for Step { of, told, .. } in steps {
            let Some((by, _)) = *told else { continue };
            let angle = by.clamp(-LARGEST_ANGLE_STEP, LARGEST_ANGLE_STEP);
            match *of {
                Hypothesis::Zero(k) => self.zeros[k] += angle,
                Hypothesis::Scale(k) => self.scales[k] *= 1.0 + by.clamp(-LARGEST_SCALE_STEP, LARGEST_SCALE_STEP),
                Hypothesis::Spring(k) => self.springs[k] += by,
                // Gravity turns by e x g seen from the base, so the base turns the other way.
                Hypothesis::Mount(axis) => {
                    let axis = if axis == 0 { Vector3::x_axis() } else { Vector3::y_axis() };
                    self.base *= Rotation3::from_axis_angle(&axis, -angle);
                }
                _ => {}
            }
        }
    }

    /// Whether a step changes nothing that counts.
    fn is_settled(&self, step: &Step) -> bool {
        let Some((by, deviation)) = step.told else { return true };
        let size = if let Hypothesis::Spring(k) = step.of { self.springs[k].abs() } else { 1.0 };
        by.abs() < (SETTLED_SHARE * deviation).max(ROUNDING * size)
    }

    /// The request with what is held for true of the joints.
    fn request(&self, request: &SamplesRequest) -> SamplesRequest {
        let mut options = request.rows.signals.options.clone().unwrap_or_default();
        let transmission = &mut options.transmission;
        let wants = |unknown: Unknown| request.unknowns.contains(&unknown);
        if wants(Unknown::Zeros) {
            transmission.offsets = Some(self.zeros.clone());
        }
        if wants(Unknown::Scales) {
            transmission.scales = Some(self.scales.clone());
        }
        if wants(Unknown::Springs) {
            transmission.springs = Some(self.springs.clone());
        }
        let mut request = SamplesRequest { unknowns: Vec::new(), ..request.clone() };
        request.rows.signals.options = Some(options);
        request
    }

    /// Roll, pitch and yaw of the base, rad.
    fn rpy(&self) -> [f64; 3] {
        let (roll, pitch, yaw) = self.base.euler_angles();
        [roll, pitch, yaw]
    }

    /// The model whose base is mounted so.
    fn model(&self, model: &Model) -> Result<Model, Error> {
        let before = turn_of_rpy(model.description.as_ref().and_then(|d| d.base).unwrap_or_default());
        let turn = before.inverse() * self.base;
        model.changed(|robot| turn_base(robot, &turn), |description| description.base = Some(self.rpy()))
    }
}

/// What was found of the unknowns of a request.
pub(crate) struct Unknowns {
    /// The model whose base is mounted so, where the mount is one of them.
    pub model: Option<Model>,
    /// The request that holds the others, without unknowns.
    pub request: SamplesRequest,
    /// The last step.
    pub steps: Vec<Step>,
    /// A sentence on each kind.
    pub remarks: Vec<String>,
}

impl Unknowns {
    /// Finds the unknowns of the request.
    ///
    /// Fails where a log cannot be read, and for robots of more than 12 coordinates.
    pub(crate) fn find(model: &Model, logs: &[LogSource], request: &SamplesRequest) -> Result<Unknowns, Error> {
        let turns = request.unknowns.contains(&Unknown::Mount);
        let mut guess = Guess::of(model, request);
        let described = guess.zeros.clone();
        if turns {
            // A step is good for small turns: a base that hangs begins where gravity points by the description's bodies.
            let options = guess.request(request).options();
            let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
            if let Some((gravity, _)) = gravity(model, &records)? {
                guess.base *= turn(model, &gravity);
            }
        }
        let mut steps = Vec::new();
        let mut is_settled = false;
        for _ in 0..MOST_STEPS {
            let turned = turns.then(|| guess.model(model)).transpose()?;
            let away: Vec<f64> =
                guess.zeros.iter().zip(&described).map(|(guess, described)| guess - described).collect();
            steps =
                one_step(turned.as_ref().unwrap_or(model), logs, &guess.request(request), &request.unknowns, &away)?;
            guess.take(&steps);
            is_settled = steps.iter().all(|step| guess.is_settled(step));
            if is_settled {
                break;
            }
        }
        let mut remarks = remarks(model, &guess, &steps, &request.unknowns);
        if !is_settled {
            remarks.insert(0, format!("the unknowns do not settle within {MOST_STEPS} steps: ask for fewer of them"));
        }
        let model = turns.then(|| guess.model(model)).transpose()?;
        Ok(Unknowns { model, request: guess.request(request), steps, remarks })
    }
}

fn one_step(
    model: &Model,
    logs: &[LogSource],
    request: &SamplesRequest,
    unknowns: &[Unknown],
    zeros: &[f64],
) -> Result<Vec<Step>, Error> {
    let mut options = request.options();
    drive_gains(model, logs, &request.gain, &mut options)?;
    let chosen = choose(model, logs, request, &mut options)?;
    let model = chosen.model.as_ref().unwrap_or(model);
    let looked = Looked::again(chosen.looked, model, logs, &options)?;
    let fit = looked.fit(model, logs)?;
    let linear = options.linear_model(model.regressor());
    let is_wanted = |of: &Hypothesis| kind(of).is_some_and(|kind| unknowns.contains(&kind));
    let steps = with_open(model, |open| step(&linear, &looked.records, fit.point(), open, zeros, is_wanted));
    Ok(steps?)
}

fn kind(of: &Hypothesis) -> Option<Unknown> {
    match of {
        Hypothesis::Zero(_) => Some(Unknown::Zeros),
        Hypothesis::Scale(_) => Some(Unknown::Scales),
        Hypothesis::Spring(_) => Some(Unknown::Springs),
        Hypothesis::Mount(_) => Some(Unknown::Mount),
        _ => None,
    }
}

/// A sentence on each kind: what was found, and what holds it.
fn remarks(model: &Model, guess: &Guess, steps: &[Step], unknowns: &[Unknown]) -> Vec<String> {
    let of_kind = |unknown: Unknown| {
        let shown: Vec<String> =
            steps.iter().filter(|s| kind(&s.of) == Some(unknown)).map(|s| shown(model, guess, s)).collect();
        let holds = match unknown {
            Unknown::Mount => mounted(guess.rpy()),
            Unknown::Zeros => option("offsets", &guess.zeros),
            Unknown::Scales => option("scales", &guess.scales),
            Unknown::Springs => option("springs", &guess.springs),
        };
        match shown.is_empty() {
            true => format!("{}: this robot has none that a log tells", unknown.word()),
            false => format!("{}: {}; {holds}", unknown.word(), shown.join(", ")),
        }
    };
    unknowns.iter().map(|&unknown| of_kind(unknown)).collect()
}

fn option(name: &str, values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|x| significant(*x)).collect();
    format!("in the file of [options]: transmission: {{{name}: [{}]}}", values.join(", "))
}

/// `q2 6.82 deg +- 0.13 deg`.
fn shown(model: &Model, guess: &Guess, step: &Step) -> String {
    let name = |k: usize| model.regressor().coordinates()[k].clone();
    let stiffness = |k: usize| if model.regressor().is_prismatic(k) { "N/m" } else { "N m/rad" };
    let (what, value, factor, unit) = match step.of {
        Hypothesis::Zero(k) => (name(k), guess.zeros[k].to_degrees(), 1f64.to_degrees(), "deg"),
        Hypothesis::Scale(k) => (name(k), guess.scales[k], guess.scales[k], ""),
        Hypothesis::Spring(k) => (name(k), guess.springs[k], 1.0, stiffness(k)),
        Hypothesis::Mount(axis) => {
            let angle = guess.rpy()[axis].to_degrees();
            (["roll", "pitch"][axis].to_string(), angle, 1f64.to_degrees(), "deg")
        }
        _ => (String::new(), 0.0, 1.0, ""),
    };
    match step.told {
        Some(_) if step.is_prior => {
            let held = significant(ZERO_PRIOR_RAD.to_degrees());
            format!("{what} cannot be told and is held to what it was, within {held} {unit}")
        }
        Some((_, deviation)) => {
            let text = format!("{what} {} +- {} {unit}", significant(value), significant(factor * deviation));
            text.trim_end().to_string()
        }
        None => format!("{what} cannot be told"),
    }
}
