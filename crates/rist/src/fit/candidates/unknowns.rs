//! Identifies unknowns in addition to the parameters: mount (orientation) of the base, encoder zeros, torque scales, springs.
//!
//! Method: Gauss-Newton. The model and the options hold a guess of the unknowns. A step of
//! [`step`](identification::estimate::claims::unknowns::step) estimates the error of the guess, and the logs are evaluated
//! again with the corrected guess. Steps are repeated until each step is below a tenth of its standard deviation. Then an
//! ordinary identification uses the unknowns that were found. The standard deviations of this identification include the
//! uncertainty of the unknowns.
//!
//! The mount is given by the direction of gravity in the frame of the base: a unit vector. The unknowns are two small rotations
//! about axes perpendicular to gravity ([`axes`]), because roll and pitch are singular for an arm on a wall. Roll and pitch are
//! computed from the direction and rounded to the printed digits, so that the printed option gives exactly this model. A spring
//! is kept if it is at least [`FOUND_FAULT_SIGMAS`] standard deviations from zero. Otherwise the least significant spring is
//! removed, and the search is repeated.

use identification::estimate::claims::hypotheses::{FOUND_FAULT_SIGMAS, Hypothesis, UndeterminedMechanics};
use identification::estimate::claims::unknowns::{UnknownStep, ZERO_PRIOR_RAD, step};
use identification::estimate::digits::significant;
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
use crate::fit::search::{FitQuestion, KeptParameters, TriedVariant, VariantProposer, search};
use crate::fit::undetermined::with_undetermined;
use crate::request::{SamplesRequest, UnknownKind, WordChoice};

/// Largest number of Gauss-Newton steps. Initial errors of 30 degrees took five.
const MOST_STEPS: usize = 12;
/// A step below this share of its standard deviation counts as zero. If all steps count as zero, the iteration ends.
const SETTLED_SHARE: f64 = 0.1;
/// For a log without noise: a step counts as zero if it is below this share of the unknown (of 1, or of the spring's
/// stiffness), because derivatives by differences have rounding errors.
const ROUNDED_STEP_SHARE: f64 = 1e-6;
/// Largest step of an angle for which the linearisation is good enough, rad. Larger steps are reduced to this value.
const LARGEST_ANGLE_STEP_RAD: f64 = 0.5;
/// Largest relative step of a scale for which the linearisation is good enough. Larger steps are reduced to this value.
const LARGEST_SCALE_STEP: f64 = 0.5;

/// The decisions before the fit that are also made before unknowns are identified.
pub(crate) const BEFORE_THE_FIT: [VariantProposer; 4] = [gains, rates, rotors, delay];

/// The assumed values of the unknowns, which each Gauss-Newton step corrects.
struct Guess {
    /// Gravity in the frame of the base, m/s^2.
    gravity: Vector3<f64>,
    zeros: Vec<f64>,
    scales: Vec<f64>,
    springs: Vec<f64>,
    /// Springs that were removed as not significant, with their values as text.
    no_springs: Vec<(Hypothesis, String)>,
}

impl Guess {
    /// The initial guess: the values in the options; if these give none, offsets of 0, scales of 1 and no springs.
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

    /// Corrects the guess by `steps`. `gravity`: the gravity vector with which the steps were computed, m/s^2 in the frame of
    /// the base.
    fn take(&mut self, steps: &[UnknownStep], gravity: Vector3<f64>) {
        let mut turn = Vector3::zeros();
        for UnknownStep { of, identified, .. } in steps {
            let Some((by, _)) = *identified else { continue };
            let angle = by.clamp(-LARGEST_ANGLE_STEP_RAD, LARGEST_ANGLE_STEP_RAD);
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

    /// Removes the least significant spring, if it is less than [`FOUND_FAULT_SIGMAS`] standard deviations from zero. Returns
    /// whether a spring was removed.
    fn leave_a_spring_out(&mut self, model: &Model, steps: &[UnknownStep]) -> bool {
        let sigmas = |step: &UnknownStep| match (&step.of, step.identified) {
            (Hypothesis::Spring(k), Some((_, deviation))) => self.springs[*k].abs() / deviation,
            _ => f64::INFINITY,
        };
        let least = steps.iter().min_by(|a, b| sigmas(a).total_cmp(&sigmas(b)));
        let Some(step) = least.filter(|step| sigmas(step) < FOUND_FAULT_SIGMAS) else { return false };
        self.no_springs.push((step.of, shown(model, self, step)));
        step.of.joint().into_iter().for_each(|k| self.springs[k] = 0.0);
        true
    }

    /// Whether a step is below a tenth of its standard deviation, or below rounding.
    fn is_settled(&self, step: &UnknownStep) -> bool {
        let Some((by, deviation)) = step.identified else { return true };
        let scale = if let Hypothesis::Spring(k) = step.of { self.springs[k].abs() } else { 1.0 };
        by.abs() < (SETTLED_SHARE * deviation).max(ROUNDED_STEP_SHARE * scale)
    }

    /// The request whose options contain the guessed zeros, scales and springs.
    fn request(&self, request: &SamplesRequest) -> SamplesRequest {
        let mut options = request.rows.signals.options.clone().unwrap_or_default();
        let transmission = &mut options.transmission;
        let wants = |unknown: UnknownKind| request.unknowns.contains(&unknown);
        if wants(UnknownKind::Zeros) {
            transmission.offsets = Some(self.zeros.clone());
        }
        if wants(UnknownKind::Scales) {
            transmission.scales = Some(self.scales.clone());
        }
        if wants(UnknownKind::Springs) {
            transmission.springs = self.springs.iter().any(|k| *k != 0.0).then(|| self.springs.clone());
        }
        let mut request = SamplesRequest { unknowns: Vec::new(), ..request.clone() };
        request.rows.signals.options = Some(options);
        request
    }

    /// Roll, pitch and yaw of the base, rad, rounded to the printed digits.
    fn rpy(&self, model: &Model) -> [f64; 3] {
        rounded_rpy(&base(model, &self.gravity), 7)
    }

    /// Repeats Gauss-Newton steps until the steps are negligible. Returns the last step of each unknown, and whether this step
    /// was negligible. `described`: the encoder zeros of the description, rad or m.
    ///
    /// Fails if a log cannot be read.
    fn settle(
        &mut self,
        model: &Model,
        logs: &[LogSource],
        request: &SamplesRequest,
        described: &[f64],
    ) -> Result<(Vec<UnknownStep>, bool), Error> {
        let turns = request.unknowns.contains(&UnknownKind::Mount);
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

    /// The model whose base is mounted as in the guess.
    fn model(&self, model: &Model) -> Result<Model, Error> {
        let rpy = self.rpy(model);
        model.changed(|robot| turn_base(robot, rpy), |description| description.base = Some(rpy))
    }
}

/// The identified unknowns of a request.
pub(crate) struct Unknowns {
    /// The model with the identified mount; `None` if the mount was not an unknown.
    pub model: Option<Model>,
    /// The request whose options contain the values of the other unknowns. It asks for no unknowns any more.
    pub request: SamplesRequest,
    /// The last step of each unknown.
    pub steps: Vec<UnknownStep>,
    /// Whether the last steps were negligible, so that the iteration converged.
    pub is_settled: bool,
    /// A sentence on each kind of unknown.
    pub remarks: Vec<String>,
}

impl Unknowns {
    /// Finds the unknowns that the request asks for.
    ///
    /// Fails if a log cannot be read, or if the robot has more than 12 coordinates.
    pub(crate) fn find(model: &Model, logs: &[LogSource], request: &SamplesRequest) -> Result<Unknowns, Error> {
        let turns = request.unknowns.contains(&UnknownKind::Mount);
        let mut guess = Guess::of(model, request);
        if turns {
            // A Gauss-Newton step is accurate only for small rotations. Therefore the guess starts at the direction of gravity
            // with which the described bodies fit best.
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
) -> Result<Vec<UnknownStep>, Error> {
    let asked = FitQuestion { logs, request, kept: KeptParameters::All };
    let end = |mut tried: TriedVariant<'_>| {
        let (model, options) = (tried.model, tried.options.clone());
        let linear = options.linear_model(model.regressor());
        let looked = tried.looked()?;
        let fit = looked.fit(model, logs)?;
        let look = |open: UndeterminedMechanics| step(&linear, &looked.records, fit.point(), open, zeros, is_wanted);
        Ok(with_undetermined(model, Some(&fit.solution.x), look)?)
    };
    Ok(search(model, asked, request.options(), &BEFORE_THE_FIT, &end)?.end)
}

fn kind(of: &Hypothesis) -> Option<UnknownKind> {
    match of {
        Hypothesis::Zero(_) => Some(UnknownKind::Zeros),
        Hypothesis::Scale(_) => Some(UnknownKind::Scales),
        Hypothesis::Spring(_) => Some(UnknownKind::Springs),
        Hypothesis::Mount(_) => Some(UnknownKind::Mount),
        _ => None,
    }
}

/// A sentence on each kind of unknown: the values found, and the option that sets them.
fn remarks(model: &Model, guess: &Guess, steps: &[UnknownStep], unknowns: &[UnknownKind]) -> Vec<String> {
    let of_kind = |unknown: UnknownKind| {
        // Identifiable rotations of gravity are printed as one direction, so the rotations are not listed one by one.
        let is_shown = |s: &&UnknownStep| {
            kind(&s.of) == Some(unknown) && (unknown != UnknownKind::Mount || s.identified.is_none())
        };
        let mut shown: Vec<String> = steps.iter().filter(is_shown).map(|s| shown(model, guess, s)).collect();
        let holds = match unknown {
            _ if !steps.iter().any(|s| kind(&s.of) == Some(unknown)) => None,
            UnknownKind::Mount => {
                shown.insert(0, direction(model, guess, steps));
                Some(mounted(guess.rpy(model)))
            }
            UnknownKind::Zeros => Some(option("offsets", &guess.zeros)),
            UnknownKind::Scales => Some(option("scales", &guess.scales)),
            UnknownKind::Springs if guess.springs.iter().all(|k| *k == 0.0) => None,
            UnknownKind::Springs => Some(option("springs", &guess.springs)),
        };
        let no_springs: Vec<&str> = guess.no_springs.iter().map(|(_, spring)| spring.as_str()).collect();
        let not_taken = format!("not taken, because below {FOUND_FAULT_SIGMAS} sigma: {}", no_springs.join(", "));
        let not_taken = Some(not_taken).filter(|_| unknown == UnknownKind::Springs && !no_springs.is_empty());
        let parts = [shown.join(", ")].into_iter().chain(holds).chain(not_taken).filter(|part| !part.is_empty());
        match parts.collect::<Vec<_>>().join("; ") {
            none if none.is_empty() => format!("{}: this robot has none that a log identifies", unknown.word()),
            parts => format!("{}: {parts}", unknown.word()),
        }
    };
    unknowns.iter().map(|&unknown| of_kind(unknown)).collect()
}

fn option(name: &str, values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|x| significant(*x)).collect();
    format!("in the file of [options]: transmission: {{{name}: [{}]}}", values.join(", "))
}

/// Text of the mount: `gravity along (-0.02, 1.00, 0.05) of the base +- 0.13 deg: roll 87.1 deg, pitch 1.2 deg`.
fn direction(model: &Model, guess: &Guess, steps: &[UnknownStep]) -> String {
    let along: Vec<String> = guess.gravity.normalize().iter().map(|x| format!("{x:.3}")).collect();
    let of_mount = steps.iter().filter(|step| matches!(step.of, Hypothesis::Mount(_)));
    // If a rotation is not identifiable, the standard deviation of the direction is unknown.
    let squares: Option<Vec<f64>> =
        of_mount.map(|step| step.identified.map(|(_, deviation)| deviation * deviation)).collect();
    let deviation = squares.map_or(String::new(), |squares| {
        format!(" +- {} deg", significant(squares.iter().sum::<f64>().sqrt().to_degrees()))
    });
    let [roll, pitch, _] = guess.rpy(model).map(|angle| significant(angle.to_degrees()));
    format!("gravity along ({}) of the base{deviation}: roll {roll} deg, pitch {pitch} deg", along.join(", "))
}

/// Text of one unknown: `q2 6.82 deg +- 0.13 deg`.
fn shown(model: &Model, guess: &Guess, step: &UnknownStep) -> String {
    let name = |k: usize| model.regressor().coordinates()[k].clone();
    let stiffness = |k: usize| if model.regressor().is_prismatic(k) { "N/m" } else { "N m/rad" };
    let (what, value, factor, unit) = match step.of {
        Hypothesis::Zero(k) => (name(k), guess.zeros[k].to_degrees(), 1f64.to_degrees(), "deg"),
        Hypothesis::Scale(k) => (name(k), guess.scales[k], guess.scales[k], ""),
        Hypothesis::Spring(k) => (name(k), guess.springs[k], 1.0, stiffness(k)),
        Hypothesis::Mount(axis) => (format!("its turn about {} of the base", ["x", "y", "z"][axis]), 0.0, 1.0, "deg"),
        _ => (String::new(), 0.0, 1.0, ""),
    };
    match step.identified {
        Some(_) if step.is_prior => {
            let held = significant(ZERO_PRIOR_RAD.to_degrees());
            format!("{what} is not identifiable and stays within {held} {unit} of what it was")
        }
        Some((_, deviation)) => {
            let text = format!("{what} {} +- {} {unit}", significant(value), significant(factor * deviation));
            text.trim_end().to_string()
        }
        None => format!("{what} is not identifiable and stays as it was"),
    }
}
