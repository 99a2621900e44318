//! An identification with unknowns beside the parameters: mount, zeros, scales, springs.
//!
//! Gauss-Newton: the model and the options hold a guess, a step of
//! [`step`](identification::estimate::ledger::unknowns::step) says by how much it is wrong, and the logs are looked at
//! again with the guess mended, until no step is above a tenth of its deviation. The identification behind it is an
//! ordinary one with what was found, and its deviations allow for those of the unknowns.
//!
//! The mount is the direction of gravity seen from the base, a unit vector with two steps across it ([`axes`]): roll and pitch
//! have a pole at an arm on a wall. They are derived, and rounded to what is printed, so that the printed line makes the very
//! model. A spring is taken where it is [`FOUND_FAULT_SIGMAS`] of its deviations from nothing: the least of the others is left
//! out, and the rest is looked at again.

use identification::estimate::digits::significant;
use identification::estimate::ledger::hypotheses::{FOUND_FAULT_SIGMAS, Hypothesis, Open};
use identification::estimate::ledger::unknowns::{Step, ZERO_PRIOR_RAD, step};
use identification::signals::records::SourceRecords;
use logs::LogSource;
use nalgebra::{Rotation3, Vector3};

use crate::describe::description::{rounded_rpy, turn_base};
use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::candidates::delay::delay;
use crate::fit::candidates::gains::gains;
use crate::fit::candidates::rates::rates;
use crate::fit::candidates::rotors::rotors;
use crate::fit::drive_gains::drive_gains;
use crate::fit::gravity_direction::{base, gravity, mounted};
use crate::fit::mount::axes;
use crate::fit::search::{Asked, Candidate, Kept, Tried, search};
use crate::fit::unspoken::with_open;
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

/// What is decided before a fit that unknowns are tested beside.
pub(crate) const BEFORE_THE_FIT: [Candidate; 4] = [gains, rates, rotors, delay];

/// What is held for true until the next step.
struct Guess {
    /// Gravity in the frame of the base, m/s^2.
    gravity: Vector3<f64>,
    zeros: Vec<f64>,
    scales: Vec<f64>,
    springs: Vec<f64>,
    /// Springs that are told too little to be taken, and how much that is.
    no_springs: Vec<(Hypothesis, String)>,
}

impl Guess {
    /// That of the options, or that nothing is wrong.
    fn of(model: &Model, request: &SamplesRequest) -> Guess {
        let n = model.robot.n_coordinates();
        let transmission = request.options().transmission;
        Guess {
            gravity: model.robot.gravity_number().into(),
            zeros: transmission.offsets.unwrap_or_else(|| vec![0.0; n]),
            scales: transmission.scales.unwrap_or_else(|| vec![1.0; n]),
            springs: transmission.springs.unwrap_or_else(|| vec![0.0; n]),
            no_springs: Vec::new(),
        }
    }

    /// Mends it by steps; `gravity`: with that they were made.
    fn take(&mut self, steps: &[Step], gravity: Vector3<f64>) {
        let mut turn = Vector3::zeros();
        for Step { of, told, .. } in steps {
            let Some((by, _)) = *told else { continue };
            let angle = by.clamp(-LARGEST_ANGLE_STEP, LARGEST_ANGLE_STEP);
            match *of {
                Hypothesis::Zero(k) => self.zeros[k] += angle,
                Hypothesis::Scale(k) => self.scales[k] *= 1.0 + by.clamp(-LARGEST_SCALE_STEP, LARGEST_SCALE_STEP),
                Hypothesis::Spring(k) => self.springs[k] += by,
                Hypothesis::Mount(of) => {
                    turn += axes(&gravity)
                        .iter()
                        .filter(|(axis, _)| *axis == of)
                        .map(|(_, e)| e * angle)
                        .sum::<Vector3<f64>>();
                }
                _ => {}
            }
        }
        self.gravity = Rotation3::from_scaled_axis(turn) * gravity;
    }

    /// Takes back the spring that is told least, where that is no spring.
    fn leave_a_spring_out(&mut self, model: &Model, steps: &[Step]) -> bool {
        let sigmas = |step: &Step| match (&step.of, step.told) {
            (Hypothesis::Spring(k), Some((_, deviation))) => self.springs[*k].abs() / deviation,
            _ => f64::INFINITY,
        };
        let least = steps.iter().min_by(|a, b| sigmas(a).total_cmp(&sigmas(b)));
        let Some(step) = least.filter(|step| sigmas(step) < FOUND_FAULT_SIGMAS) else { return false };
        self.no_springs.push((step.of, shown(model, self, step)));
        step.of.joint().into_iter().for_each(|k| self.springs[k] = 0.0);
        true
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
            transmission.springs = self.springs.iter().any(|k| *k != 0.0).then(|| self.springs.clone());
        }
        let mut request = SamplesRequest { unknowns: Vec::new(), ..request.clone() };
        request.rows.signals.options = Some(options);
        request
    }

    /// Roll, pitch and yaw of the base, rad, as they are printed.
    fn rpy(&self, model: &Model) -> [f64; 3] {
        rounded_rpy(&base(model, &self.gravity), 7)
    }

    /// Steps until one changes nothing: the last one, and whether that was so. `described`: the zeros of the description.
    ///
    /// Fails where a log cannot be read.
    fn settle(
        &mut self,
        model: &Model,
        logs: &[LogSource],
        request: &SamplesRequest,
        described: &[f64],
    ) -> Result<(Vec<Step>, bool), Error> {
        let turns = request.unknowns.contains(&Unknown::Mount);
        let mut steps = Vec::new();
        for _ in 0..MOST_STEPS {
            let turned = turns.then(|| self.model(model)).transpose()?;
            let turned = turned.as_ref().unwrap_or(model);
            let away: Vec<f64> = self.zeros.iter().zip(described).map(|(guess, of_file)| guess - of_file).collect();
            let is_wanted = |of: &Hypothesis| {
                kind(of).is_some_and(|kind| request.unknowns.contains(&kind))
                    && self.no_springs.iter().all(|(no, _)| no != of)
            };
            steps = one_step(turned, logs, &self.request(request), &away, &is_wanted)?;
            self.take(&steps, turned.robot.gravity_number().into());
            if steps.iter().all(|step| self.is_settled(step)) {
                return Ok((steps, true));
            }
        }
        Ok((steps, false))
    }

    /// The model whose base is mounted so.
    fn model(&self, model: &Model) -> Result<Model, Error> {
        let rpy = self.rpy(model);
        model.changed(|robot| turn_base(robot, rpy), |description| description.base = Some(rpy))
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
    /// Whether the last step changed nothing.
    pub is_settled: bool,
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
        if turns {
            // A step is good for small turns: a base that hangs begins where gravity points by the description's bodies.
            let mut options = guess.request(request).options();
            drive_gains(model, logs, &request.gain, &mut options)?;
            let records = SourceRecords::new(model.regressor(), logs, &options.preparation())?;
            guess.gravity = gravity(model, &records)?;
        }
        let described = guess.zeros.clone();
        let (mut steps, mut is_settled) = guess.settle(model, logs, request, &described)?;
        while guess.leave_a_spring_out(model, &steps) {
            (steps, is_settled) = guess.settle(model, logs, request, &described)?;
        }
        let mut remarks = remarks(model, &guess, &steps, &request.unknowns);
        if !is_settled {
            remarks.insert(0, format!("the unknowns do not settle within {MOST_STEPS} steps: ask for fewer of them"));
        }
        let model = turns.then(|| guess.model(model)).transpose()?;
        Ok(Unknowns { model, request: guess.request(request), steps, is_settled, remarks })
    }
}

fn one_step(
    model: &Model,
    logs: &[LogSource],
    request: &SamplesRequest,
    zeros: &[f64],
    is_wanted: &dyn Fn(&Hypothesis) -> bool,
) -> Result<Vec<Step>, Error> {
    let asked = Asked { logs, request, kept: Kept::All };
    let end = |mut tried: Tried<'_>| {
        let (model, options) = (tried.model, tried.options.clone());
        let linear = options.linear_model(model.regressor());
        let looked = tried.looked()?;
        let fit = looked.fit(model, logs)?;
        let look = |open: Open| step(&linear, &looked.records, fit.point(), open, zeros, is_wanted);
        Ok(with_open(model, Some(&fit.solution.x), look)?)
    };
    Ok(search(model, asked, request.options(), &BEFORE_THE_FIT, &end)?.end)
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
        // Of turns of gravity that are told the direction is shown.
        let is_shown = |s: &&Step| kind(&s.of) == Some(unknown) && (unknown != Unknown::Mount || s.told.is_none());
        let mut shown: Vec<String> = steps.iter().filter(is_shown).map(|s| shown(model, guess, s)).collect();
        let holds = match unknown {
            _ if !steps.iter().any(|s| kind(&s.of) == Some(unknown)) => None,
            Unknown::Mount => {
                shown.insert(0, direction(model, guess, steps));
                Some(mounted(guess.rpy(model)))
            }
            Unknown::Zeros => Some(option("offsets", &guess.zeros)),
            Unknown::Scales => Some(option("scales", &guess.scales)),
            Unknown::Springs if guess.springs.iter().all(|k| *k == 0.0) => None,
            Unknown::Springs => Some(option("springs", &guess.springs)),
        };
        let no_springs: Vec<&str> = guess.no_springs.iter().map(|(_, spring)| spring.as_str()).collect();
        let not_taken =
            format!("not taken, because less than {FOUND_FAULT_SIGMAS} deviations: {}", no_springs.join(", "));
        let not_taken = Some(not_taken).filter(|_| unknown == Unknown::Springs && !no_springs.is_empty());
        let parts = [shown.join(", ")].into_iter().chain(holds).chain(not_taken).filter(|part| !part.is_empty());
        match parts.collect::<Vec<_>>().join("; ") {
            none if none.is_empty() => format!("{}: this robot has none that a log tells", unknown.word()),
            parts => format!("{}: {parts}", unknown.word()),
        }
    };
    unknowns.iter().map(|&unknown| of_kind(unknown)).collect()
}

fn option(name: &str, values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|x| significant(*x)).collect();
    format!("in the file of [options]: transmission: {{{name}: [{}]}}", values.join(", "))
}

/// `gravity along (-0.02, 1.00, 0.05) of the base +- 0.13 deg: roll 87.1 deg, pitch 1.2 deg`.
fn direction(model: &Model, guess: &Guess, steps: &[Step]) -> String {
    let along: Vec<String> = guess.gravity.normalize().iter().map(|x| format!("{x:.3}")).collect();
    let of_mount = steps.iter().filter(|step| matches!(step.of, Hypothesis::Mount(_)));
    // Where a turn cannot be told, no deviation of the direction is known.
    let squares: Option<Vec<f64>> =
        of_mount.map(|step| step.told.map(|(_, deviation)| deviation * deviation)).collect();
    let deviation = squares.map_or(String::new(), |squares| {
        format!(" +- {} deg", significant(squares.iter().sum::<f64>().sqrt().to_degrees()))
    });
    let [roll, pitch, _] = guess.rpy(model).map(|angle| significant(angle.to_degrees()));
    format!("gravity along ({}) of the base{deviation}: roll {roll} deg, pitch {pitch} deg", along.join(", "))
}

/// `q2 6.82 deg +- 0.13 deg`.
fn shown(model: &Model, guess: &Guess, step: &Step) -> String {
    let name = |k: usize| model.regressor().coordinates()[k].clone();
    let stiffness = |k: usize| if model.regressor().is_prismatic(k) { "N/m" } else { "N m/rad" };
    let (what, value, factor, unit) = match step.of {
        Hypothesis::Zero(k) => (name(k), guess.zeros[k].to_degrees(), 1f64.to_degrees(), "deg"),
        Hypothesis::Scale(k) => (name(k), guess.scales[k], guess.scales[k], ""),
        Hypothesis::Spring(k) => (name(k), guess.springs[k], 1.0, stiffness(k)),
        Hypothesis::Mount(axis) => (format!("its turn about {} of the base", ["x", "y", "z"][axis]), 0.0, 1.0, "deg"),
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
        None => format!("{what} cannot be told and stays as it was"),
    }
}
