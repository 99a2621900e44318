//! Checks whether a motion keeps its limits. The check uses only the coefficients in the motion's file and the model.
//!
//! The certificate has one row per limit: the proven bound of the motion and the limit. Limits come from three origins: the
//! description, the request of the user, and the motion's own file. A gap is a pair of bodies (or a body and a floor or wall)
//! with a least allowed distance. Error margins allow for tracking errors, wrong encoder zeros and inexact bodies.

use std::path::Path;

use claims::{LeftOut, LeftOutTopic};
use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::enforced_limits::{EnforcedLimit, enforced, kinds_of_motion_alone};
use experiments::excitation::error_margins::ErrorMargins;
use experiments::excitation::fitting::Obligations;
use experiments::excitation::gap_proof::Gap;
use experiments::excitation::limits::{CoordinateLimits, LimitKind, LimitsFile, given};
use experiments::excitation::margins::{self, Margins, with_margins};
use experiments::excitation::motion::Motion;
use experiments::excitation::motion_claims::{LowestPoint, MotionClaims};
use experiments::excitation::proof::{CertificateRow, EnclosedTorque, NominalTorque};
use experiments::excitation::space_limits::{Floor, SpaceLimits};

use crate::describe::adapters::surroundings::RobotSurroundings;
use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::exciting::identified_torque;
use crate::motion::known_torque::KnownTorque;
use crate::motion::nominal::torque_left_out;
use crate::request::CheckRequest;

/// The result of a check: the certificate, proved again.
pub struct Checked {
    /// The limits of the motion, each with its proof.
    pub certificate: Vec<CertificateRow>,
    /// Requirements that the certificate does not cover, with reasons.
    pub left_out: Vec<LeftOut>,
    /// Height of the floor, m; `None` if there is no floor.
    pub floor: Option<f64>,
    /// The lowest point of the moving links, searched at discrete instants; `None` without such links.
    pub lowest: Option<LowestPoint>,
    /// The error margins that the proof includes.
    pub margins: Margins,
    /// Further remarks, in sentences.
    pub notes: Vec<String>,
    /// The limits that the motion is checked against, one entry per coordinate.
    pub limits: Vec<CoordinateLimits>,
    /// For each single limit in `limits`, the origin of this limit (description, request or motion file).
    pub origins: Vec<EnforcedLimit>,
}

impl Checked {
    /// The certificate with the requirements that it does not cover.
    pub fn claims(&self) -> MotionClaims<'_> {
        let (rows, left_out) = (&self.certificate, &self.left_out);
        MotionClaims { rows, left_out, floor: self.floor, lowest: self.lowest.as_ref() }
    }

    /// Whether every row of the certificate is proven, and all requirements of the user are checked.
    pub fn is_proven(&self) -> bool {
        self.claims().is_kept()
    }

    /// The reasons why the motion is not accepted, as sentences; empty if it is accepted.
    pub fn faults(&self) -> Vec<String> {
        self.claims().faults()
    }
}

/// Proves the limits of a motion again. The file gives coefficients and times. Limits in the file count only if they are
/// stricter than the limits of the description and of the request. Torques come from the description, or from the estimate in
/// the request. `file` is named in messages.
///
/// Distances and the floor are checked by the current rules, even if the certificate in the file does not list them. A note
/// names the requirements that this certificate does not list.
///
/// Fails if the motion was made with another model, if the file holds no motion, or if the limits exclude every motion.
pub fn check(model: &Model, file: &Path, artefact: &ExcitingMotion, request: &CheckRequest) -> Result<Checked, Error> {
    let asked = request.limits.as_ref();
    model.check(file, &artefact.model)?;
    let motion = artefact.motion(&file.display().to_string())?;
    let names = model.regressor().coordinates();
    let theirs: Vec<&str> = artefact.joints.iter().map(|j| j.coordinate.as_str()).collect();
    if names.iter().map(String::as_str).ne(theirs.iter().copied()) {
        return Err(Error::new(format_args!(
            "{}: joints {}; the model has {}",
            file.display(),
            theirs.join(", "),
            names.join(", ")
        )));
    }
    let (limits, origins) = enforced_limits(model, file, artefact, &motion, asked)?;
    let errors = margins_of(artefact, file, names, asked)?;
    let limits =
        with_margins(&errors, names, &limits).map_err(|what| Error::new(format_args!("{}: {what}", file.display())))?;

    // Known torques of the robot, for limits of effort and power.
    let identified = request.after.as_ref().map(|estimate| identified_torque(model, names, estimate)).transpose()?;
    let known = KnownTorque::new(model, identified.as_ref()).with_payload(model, errors.payload.as_ref())?;
    let loaded = known.loaded.as_ref().map(|(loaded, _)| loaded as &dyn EnclosedTorque);
    let torque = known.enclosure.as_ref().map(|torque| NominalTorque {
        torque: torque as &dyn EnclosedTorque,
        friction: known.friction.clone(),
        share: artefact.effort_share,
        loaded,
    });

    // Bodies of the robot, for limits of distance, floor and walls.
    let nothing = SpaceLimits::default();
    let user = asked.and_then(|asked| asked.space.as_ref()).unwrap_or(&nothing);
    let surroundings = RobotSurroundings::new(model, user, Some(&artefact.space), &limits, &errors)?;
    let obligations =
        Obligations { limits: &limits, names, torque: torque.as_ref(), surroundings: surroundings.some() };
    let certificate = obligations.certificate(&motion);

    // Requirements that the proof does not cover, and assumptions on which the proof is based.
    let mut left_out = surroundings.left_out.clone();
    left_out.extend(torque_left_out(model, known.enclosure.is_some(), names, &limits, asked));
    left_out.extend(limits_of_file(&origins));
    left_out.extend(torques_of_file(artefact, request).filter(|_| torque.is_some()));
    left_out.push(LeftOut::approach());
    left_out.extend(margins::left_out(&errors));
    let file_notes =
        [artefact.checksum.note(file.display()), after_note(request), beyond_own_list(artefact, &surroundings.gaps)];
    let notes = file_notes.into_iter().flatten().chain(notes(artefact, torque.is_some(), &origins)).collect();
    let (floor, lowest) = (surroundings.floor(), surroundings.lowest(&motion));
    let margins = Margins::new(&motion, &certificate, &obligations, &errors, surroundings.mesh_error());
    Ok(Checked { certificate, left_out, floor, lowest, margins, notes, limits, origins })
}

/// The error margins of the user. If the motion's own file has a larger margin, the larger margin is used.
fn margins_of(
    artefact: &ExcitingMotion,
    file: &Path,
    names: &[String],
    asked: Option<&LimitsFile>,
) -> Result<ErrorMargins, Error> {
    let own = artefact.margins.as_ref().map(|margins| margins.errors.clone()).unwrap_or_default();
    own.fault(names).map_or(Ok(()), |fault| Err(Error::new(format_args!("{}: {fault}", file.display()))))?;
    Ok(asked.map_or(own.clone(), |asked| own.held_to(&asked.margins, names)))
}

/// A note if the file of the estimate `after`, which gives the torques, was changed after rist wrote it.
pub(crate) fn after_note(request: &CheckRequest) -> Option<String> {
    request.after.as_ref()?.checksum.note("[after]")
}

/// Notes on entries of the motion's own file that do not count as proof.
fn notes(artefact: &ExcitingMotion, knows_torque: bool, origins: &[EnforcedLimit]) -> Vec<String> {
    let mut notes = Vec::new();
    let space = &artefact.space;
    let is_lenient = !space.own_links || !space.accept.is_empty() || !space.ignored_pairs.is_empty();
    if is_lenient || space.floor == Some(Floor::NOWHERE) {
        notes.push(
            "the motion's own file leaves out pairs of links or the floor; what it leaves out counts only in [limits=FILE], a \
             file of yours"
                .into(),
        );
    }
    let limits_drives = |row: &EnforcedLimit| matches!(row.limit, LimitKind::Effort | LimitKind::Power);
    if knows_torque && artefact.effort_share < 1.0 && origins.iter().any(limits_drives) {
        notes.push(format!(
            "effort and power are held to {} of their limits: this is the effort_share of the motion's file",
            artefact.effort_share
        ));
    }
    notes
}

/// Reports kinds of limits that only the motion's file gives; `None` if there are no such limits.
fn limits_of_file(origins: &[EnforcedLimit]) -> Option<LeftOut> {
    let kinds = kinds_of_motion_alone(origins);
    let what =
        "a limit that stands nowhere else is as the motion's file has it, loosened or not ([limits=FILE] gives yours)";
    (!kinds.is_empty()).then(|| LeftOut::assumed(LeftOutTopic::Limit, kinds, what, "the motion's file"))
}

/// Reports that torques in the motion's file do not count as proof, since the author of the file can write any torque.
fn torques_of_file(artefact: &ExcitingMotion, request: &CheckRequest) -> Option<LeftOut> {
    let what = "the motion was made with torques of an estimate, which its file repeats; they prove nothing here \
                ([after=ESTIMATE] gives them)";
    let of = vec!["a robot with the torques of its description".into()];
    (artefact.identified.is_some() && request.after.is_none())
        .then(|| LeftOut::assumed(LeftOutTopic::Effort, of, what, "the description"))
}

/// A note on gaps (pairs of bodies with a least allowed distance) that the certificate in the motion's file does not list.
/// These gaps are proved too, because a file must not decide which requirements it has to meet.
fn beyond_own_list(artefact: &ExcitingMotion, gaps: &[Gap]) -> Option<String> {
    // Certificates of an earlier version name a gap by the link that carries the body.
    let is_listed = |gap: &Gap| {
        let [a, b] = &gap.carriers;
        let mut own = artefact.certificate.iter().filter(|row| row.limit == gap.limit).map(|row| row.subject.as_str());
        own.any(|own| match gap.limit {
            LimitKind::Distance => own == gap.subject || own == format!("{a} and {b}") || own == format!("{b} and {a}"),
            _ => own == gap.subject || Some(a.as_str()) == own.split(" at the ").next(),
        })
    };
    let unlisted: Vec<&str> = gaps.iter().filter(|gap| !is_listed(gap)).map(|gap| gap.subject.as_str()).collect();
    (!unlisted.is_empty()).then(|| {
        format!("the motion's own file did not look at these, and is held to them here: {}", unlisted.join(", "))
    })
}

/// The limits for the motion of each coordinate, and the origin of each limit.
fn enforced_limits(
    model: &Model,
    file: &Path,
    artefact: &ExcitingMotion,
    motion: &Motion,
    asked: Option<&LimitsFile>,
) -> Result<(Vec<CoordinateLimits>, Vec<EnforcedLimit>), Error> {
    let refused = |what: String| Error::new(format_args!("{}: {what}", model.path.display()));
    asked.map_or(Ok(()), |asked| asked.check_names(model.regressor().coordinates())).map_err(refused)?;
    let (mut limits, mut origins) = (Vec::new(), Vec::new());
    for ((joint, coordinate), coefficients) in artefact.joints.iter().zip(&model.robot.coordinates).zip(&motion.joints)
    {
        let name = &joint.coordinate;
        let of_file = asked.map(|asked| given(&coordinate.limits, &asked.of(name), &asked.all)).transpose();
        let of_file = of_file.map_err(|what| refused(format!("coordinate {name}: {what}")))?;
        let (mut own, rows) = enforced(name, &joint.limits, &coordinate.limits, of_file.as_ref())
            .map_err(|what| Error::new(format_args!("{}: joint {name}: {what}", file.display())))?;
        if let Some(place) = own.locked.filter(|q| stirs(coefficients, *q)) {
            // The motion moves a coordinate that should be locked. So the position limits of this coordinate enclose only the
            // locked position, and the bodies that it moves count as moving.
            own = CoordinateLimits {
                position: (place - LOCKED_MOTION_TOLERANCE, place + LOCKED_MOTION_TOLERANCE),
                locked: None,
                ..own
            };
        }
        limits.push(own);
        origins.extend(rows);
    }
    Ok((limits, origins))
}

/// A motion of a locked coordinate up to this amplitude counts as rounding, rad (m).
const LOCKED_MOTION_TOLERANCE: f64 = 1e-9;

/// Whether a locked coordinate moves, or rests at a position other than `locked`.
fn stirs(coefficients: &[f64], locked: f64) -> bool {
    let swing: f64 = coefficients.iter().skip(1).map(|x| x.abs()).sum();
    let centre = coefficients.first().copied().unwrap_or(locked);
    swing > LOCKED_MOTION_TOLERANCE || (centre - locked).abs() > LOCKED_MOTION_TOLERANCE
}
