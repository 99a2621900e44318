//! Checks two kinds of trajectories: points from another program (a CSV or a JointTrajectory), and the experiments of a plan.
//!
//! The user gives the interpolation between the points ([`Interpolation`]); otherwise rist chooses the smoothest one that the
//! points allow. A note names the interpolation. The proof covers the motion at the points and between them. A limit is not
//! checked if neither the description nor the limits file of the user gives it. The result lists such limits.
//!
//! The certificate has one row per limit: the proven bound of the trajectory and the limit. A gap is a pair of bodies (or a
//! body and a floor or wall) with a least allowed distance. The D-efficiency of a plan is (det F)^(1/p), divided by its value
//! for the best plan of the same number of experiments (F: information matrix; p: number of parameters).

use std::path::Path;

use claims::{LeftOut, LeftOutTopic};
use experiments::excitation::enforced_limits::{EnforcedLimit, LimitOrigin};
use experiments::excitation::error_margins::ErrorMargins;
use experiments::excitation::fitting::Obligations;
use experiments::excitation::limits::{AskedLimits, CoordinateLimits, LimitKind, LimitsFile, given};
use experiments::excitation::margins::{self, Margins, asked_with_margins};
use experiments::excitation::polynomial_trajectory::PolynomialTrajectory;
use experiments::excitation::proof::KINEMATIC_PROOF_TOLERANCE;
use experiments::excitation::space_limits::SpaceLimits;
use experiments::excitation::trajectory::Trajectory;
use experiments::motion::point_trajectory::{Interpolation, PointTrajectory};
use experiments::plan::exciting_trajectory::ExcitingTrajectory;
use experiments::plan::experiment_plan::ExperimentPlan;
use experiments::plan::planned_experiment::PlannedExperiment;
use experiments::plan::proof_check;

use crate::describe::adapters::surroundings::RobotSurroundings;
use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::checking::{Checked, after_note};
use crate::motion::exciting::identified_torque;
use crate::motion::known_torque::KnownTorque;
use crate::motion::nominal::torque_left_out;
use crate::request::CheckRequest;

/// The lowest derivative of a trajectory that has no bound, because the derivative below it jumps at points.
struct Discontinuity {
    /// The lowest derivative without bound. All higher derivatives have no bound either.
    from: LimitKind,
    why: &'static str,
    would_tell: &'static str,
    /// Share of a limit up to which an excess counts as rounding.
    slack: f64,
}

/// A plan uses its limits fully. An excess over a limit counts as rounding if it is at most this share of the limit.
const PLAN_ROUNDING_SHARE: f64 = 1e-9;
/// A motion of a locked coordinate up to this amplitude counts as rounding, rad (m).
const LOCKED_TOLERANCE: f64 = 1e-9;

/// Proves the limits of a motion through points from another source, with the given interpolation. If none is given, the
/// smoothest interpolation that the points allow is used. Limits come from the description and the request. Efforts and powers
/// may use these limits fully.
///
/// Fails if the file moves an unknown coordinate, or does not give the position of a coordinate; if the points lack derivatives
/// that the interpolation needs; or if the limits exclude every motion.
pub fn check_points(
    model: &Model,
    file: &Path,
    points: PointTrajectory,
    interpolation: Option<Interpolation>,
    request: &CheckRequest,
) -> Result<Checked, Error> {
    let refused = |what: String| Error::new(format_args!("{}: {what}", file.display()));
    let names = model.regressor().coordinates();
    let asked = limits_of_request(model, request.limits.as_ref())?;
    let points = points.of_coordinates(names, &|k| asked[k].locked).map_err(refused)?;
    let interpolation = points.interpolation(interpolation).map_err(refused)?;
    // Linear: dq jumps at the points, so ddq has no bound. Cubic: ddq jumps, so the jerk has no bound.
    let jumps = match interpolation {
        Interpolation::Linear => Discontinuity {
            from: LimitKind::Acceleration,
            why: "between points it goes straight, so that its velocity jumps at each",
            would_tell: "velocities at the points, and accelerations",
            slack: 0.0,
        },
        Interpolation::Cubic => Discontinuity {
            from: LimitKind::Jerk,
            why: "between points it is cubic, so that its acceleration jumps at each",
            would_tell: "accelerations at the points",
            slack: 0.0,
        },
        Interpolation::Quintic => Discontinuity { from: LimitKind::Effort, why: "", would_tell: "", slack: 0.0 },
    };
    // If the points start or end exactly at a position limit, this limit is extended by the tolerance of the proof.
    let course = PolynomialTrajectory::through(&points, interpolation);
    let mut held = CourseCheck::new(model, request, asked, jumps)?;
    held.let_stand_at_ends(&points);
    let checked = held.course(&course);
    let mut notes = checked.notes;
    notes.push(format!(
        "{} points over {:.3} s, {} between them; efforts and powers are held to their whole limits",
        points.times().len(),
        points.times().last().zip(points.times().first()).map_or(0.0, |(last, first)| last - first),
        interpolation.word()
    ));
    if !points.rests_at_its_ends() {
        notes.push("it does not begin and end at rest: what the robot does before and after is not looked at".into());
    }
    Ok(Checked { notes, ..checked })
}

/// Proves the limits of each experiment of a plan, with the acceleration profiles of the plan; returns the name and the result of
/// each.
///
/// Fails if the plan was made with another model, or if one of its experiments is no motion.
pub fn check_experiments(
    model: &Model,
    file: &Path,
    plan: &ExperimentPlan,
    request: &CheckRequest,
) -> Result<Vec<(String, Checked)>, Error> {
    model.check(file, &plan.model)?;
    let held = CourseCheck::of_plans(model, request)?;
    let experiments = plan.trajectories(&file.display().to_string())?;
    let one = |(planned, experiment): (&PlannedExperiment, &ExcitingTrajectory)| {
        (planned.name.clone(), held.experiment(experiment))
    };
    Ok(plan.experiments.iter().zip(&experiments).map(one).collect())
}

/// A lower bound of the D-efficiency of a plan, computed again from the proof and the candidates in the plan's file, and from
/// the model. `None` if the plan has no proof.
///
/// Fails if the plan was made with another model, or if the proof proves nothing.
pub fn efficiency_again(model: &Model, file: &Path, plan: &ExperimentPlan) -> Result<Option<f64>, Error> {
    model.check(file, &plan.model)?;
    if plan.proof.is_none() {
        return Ok(None);
    }
    let find = proof_check::registered()
        .map_err(|why| Error::new(format_args!("{}: its proof cannot be found again: {why}", file.display())))?;
    Ok(find(plan, model.regressor(), &file.display().to_string())?)
}

/// The limits of description and request, one per coordinate, reduced by the margins of the joints.
pub(crate) fn limits_of_request(model: &Model, file: Option<&LimitsFile>) -> Result<Vec<AskedLimits>, Error> {
    let refused = |what: String| Error::new(format_args!("{}: {what}", model.path.display()));
    let (nothing, names) = (Default::default(), model.regressor().coordinates());
    let file = file.unwrap_or(&nothing);
    file.check_names(names).map_err(refused)?;
    let one = |(name, coordinate): (&String, &robot::Coordinate)| {
        let found = given(&coordinate.limits, &file.of(name), &file.all)
            .and_then(|found| asked_with_margins(found, file.margins.of_joint(name)));
        found.map_err(|what| refused(format!("coordinate {name}: {what}")))
    };
    names.iter().zip(&model.robot.coordinates).map(one).collect()
}

/// The limits for a proof. A limit is infinite if no limit is given, or if jumps leave the quantity without a bound.
fn bounds(asked: &AskedLimits, jumps: &Discontinuity) -> CoordinateLimits {
    let unlimited = f64::INFINITY;
    let is_bounded = |kind: LimitKind| {
        let place = |kind| LimitKind::KINEMATIC.iter().position(|k| *k == kind).unwrap_or(LimitKind::KINEMATIC.len());
        place(kind) < place(jumps.from)
    };
    let with_slack = |x: f64| x * (1.0 + jumps.slack);
    let of = |kind: LimitKind, given: Option<f64>| given.filter(|_| is_bounded(kind)).map_or(unlimited, with_slack);
    let position = match asked.locked {
        Some(q) => (q - LOCKED_TOLERANCE, q + LOCKED_TOLERANCE),
        None => asked.position.map_or((-unlimited, unlimited), |(low, high)| {
            let slack = jumps.slack * (high - low);
            (low - slack, high + slack)
        }),
    };
    let drives = jumps.from != LimitKind::Acceleration;
    CoordinateLimits {
        position,
        velocity: of(LimitKind::Velocity, asked.velocity),
        acceleration: of(LimitKind::Acceleration, asked.acceleration),
        jerk: of(LimitKind::Jerk, asked.jerk),
        effort: asked.effort.filter(|_| drives),
        power: asked.power.filter(|_| drives),
        locked: None,
    }
}

/// The requirements for trajectories: limits of coordinates, torques and bodies.
pub(crate) struct CourseCheck<'a> {
    model: &'a Model,
    request: &'a CheckRequest,
    /// The limits of description and request, one per coordinate.
    pub(crate) asked: Vec<AskedLimits>,
    jumps: Discontinuity,
    limits: Vec<CoordinateLimits>,
    /// The known torques of the robot.
    pub(crate) known: KnownTorque<'a>,
    /// The gaps (pairs with a least allowed distance): of two bodies, or of a body and a floor or wall.
    pub(crate) surroundings: RobotSurroundings,
    errors: ErrorMargins,
}

impl<'a> CourseCheck<'a> {
    /// Prepares the checks. Fails if the bodies cannot meet the requirements on distances, floor and walls.
    fn new(
        model: &'a Model,
        request: &'a CheckRequest,
        asked: Vec<AskedLimits>,
        jumps: Discontinuity,
    ) -> Result<Self, Error> {
        let limits: Vec<CoordinateLimits> = asked.iter().map(|asked| bounds(asked, &jumps)).collect();
        let names = model.regressor().coordinates();
        let identified =
            request.after.as_ref().map(|estimate| identified_torque(model, names, estimate)).transpose()?;
        let errors = request.limits.as_ref().map(|limits| limits.margins.clone()).unwrap_or_default();
        let known = KnownTorque::new(model, identified.as_ref()).with_payload(model, errors.payload.as_ref())?;
        let nothing = SpaceLimits::default();
        let user = request.limits.as_ref().and_then(|limits| limits.space.as_ref()).unwrap_or(&nothing);
        let surroundings = RobotSurroundings::new(model, user, None, &limits, &errors)?;
        Ok(CourseCheck { model, request, asked, jumps, limits, known, surroundings, errors })
    }

    /// The requirements for the experiments of plans.
    pub(crate) fn of_plans(model: &'a Model, request: &'a CheckRequest) -> Result<CourseCheck<'a>, Error> {
        let asked = limits_of_request(model, request.limits.as_ref())?;
        // The motions of a plan are swings and sweeps. Their acceleration jumps at ramps and corners, so the jerk has no bound.
        let jumps = Discontinuity {
            from: LimitKind::Jerk,
            why: "the acceleration of a bang-bang swing and of a sweep jumps",
            would_tell: "a smooth profile",
            slack: PLAN_ROUNDING_SHARE,
        };
        CourseCheck::new(model, request, asked, jumps)
    }

    /// Extends a position limit by the tolerance of the proof, if the points start or end exactly at this limit, as for a
    /// folded arm. The proof is not more accurate than this tolerance.
    fn let_stand_at_ends(&mut self, points: &PointTrajectory) {
        for (limits, q) in self.limits.iter_mut().zip(points.positions()) {
            let (low, high) = limits.position;
            let stands_at = |end: f64| [q.first(), q.last()].into_iter().flatten().any(|q| *q == end);
            let rounding = |end: f64| if stands_at(end) { KINEMATIC_PROOF_TOLERANCE * (high - low) } else { 0.0 };
            limits.position = (low - rounding(low), high + rounding(high));
        }
    }

    /// Proves the limits of one experiment.
    pub(crate) fn experiment(&self, experiment: &ExcitingTrajectory) -> Checked {
        self.course(&PolynomialTrajectory::of_experiment(experiment))
    }

    fn course(&self, course: &dyn Trajectory) -> Checked {
        let (names, limits) = (self.model.regressor().coordinates(), &self.limits);
        let torque = self.known.nominal_enclosure(1.0, limits);
        let surroundings = self.surroundings.some();
        let obligations = Obligations { limits, names, torque: torque.as_ref(), surroundings };
        let certificate = obligations.certificate(course);
        Checked {
            margins: Margins::new(course, &certificate, &obligations, &self.errors, self.surroundings.mesh_error()),
            certificate,
            left_out: self.left_out(),
            floor: self.surroundings.floor(),
            lowest: self.surroundings.lowest_of(course),
            notes: after_note(self.request).into_iter().collect(),
            limits: limits.clone(),
            origins: origins(self.model, names, &self.asked, limits),
        }
    }

    /// Requirements that no row of the certificate covers, for any trajectory, with reasons.
    pub(crate) fn left_out(&self) -> Vec<LeftOut> {
        let (names, asked) = (self.model.regressor().coordinates(), &self.asked);
        let mut left_out = self.surroundings.left_out.clone();
        if self.jumps.from == LimitKind::Acceleration {
            let of = names.iter().zip(asked).filter(|(_, a)| a.effort.is_some() || a.power.is_some());
            let of: Vec<String> = of.map(|(name, _)| name.clone()).collect();
            if !of.is_empty() {
                left_out.push(LeftOut::not_looked_at(LeftOutTopic::Effort, of, self.jumps.why, self.jumps.would_tell));
            }
        } else {
            let file = self.request.limits.as_ref();
            left_out.extend(torque_left_out(self.model, self.known.enclosure.is_some(), names, &self.limits, file));
        }
        left_out.extend(unbounded(names, asked, &self.limits, &self.jumps, self.request));
        left_out.push(LeftOut::approach());
        left_out.extend(margins::left_out(&self.errors));
        left_out
    }
}

/// Reports kinds of limits that the certificate does not cover. Either no limit is given, or jumps leave the quantity without a
/// bound.
fn unbounded(
    names: &[String],
    asked: &[AskedLimits],
    limits: &[CoordinateLimits],
    jumps: &Discontinuity,
    request: &CheckRequest,
) -> Vec<LeftOut> {
    let mut found = Vec::new();
    for kind in LimitKind::KINEMATIC {
        let is_unbounded =
            |l: &CoordinateLimits| l.bounds(kind).is_none_or(|(low, high)| low.is_infinite() || high.is_infinite());
        let open: Vec<usize> = (0..names.len()).filter(|&k| is_unbounded(&limits[k])).collect();
        let (jumping, missing): (Vec<usize>, Vec<usize>) =
            open.into_iter().partition(|&k| asked[k].bounds(kind).is_some());
        let of = |all: &[usize]| {
            vec![format!("{kind} of {}", all.iter().map(|&k| names[k].as_str()).collect::<Vec<_>>().join(", "))]
        };
        if !jumping.is_empty() {
            // A limit that the user gives must not be ignored, even if the description gives this limit too.
            let is_asked = |&k: &usize| {
                request.limits.as_ref().is_some_and(|f| f.of(&names[k]).bounds(kind).or(f.all.bounds(kind)).is_some())
            };
            let out = LeftOut::not_looked_at(LeftOutTopic::Limit, of(&jumping), jumps.why, jumps.would_tell);
            found.push(LeftOut { is_asked: jumping.iter().any(is_asked), ..out });
        }
        if !missing.is_empty() {
            let why = "neither the description nor a limits file gives a limit";
            found.push(LeftOut::not_looked_at(LeftOutTopic::Limit, of(&missing), why, "a limit ([limits=FILE])"));
        }
    }
    found
}

/// Each limit as a row with its origin (description or request).
fn origins(model: &Model, names: &[String], asked: &[AskedLimits], limits: &[CoordinateLimits]) -> Vec<EnforcedLimit> {
    let kinds = [LimitKind::KINEMATIC.as_slice(), &[LimitKind::Effort, LimitKind::Power]].concat();
    let mut rows = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let described = AskedLimits::of_description(&model.robot.coordinates[k].limits);
        for &kind in &kinds {
            let held = limits[k].bounds(kind).filter(|(low, high)| low.is_finite() && high.is_finite());
            let (Some(_), Some(given)) = (held, asked[k].bounds(kind).or(held)) else { continue };
            let is_described = described.bounds(kind) == Some(given);
            let origin = if is_described { LimitOrigin::Description } else { LimitOrigin::LimitsFile };
            rows.push(EnforcedLimit { coordinate: name.clone(), limit: kind, bounds: given, origin });
        }
    }
    rows
}
