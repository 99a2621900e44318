//! Checks whether a motion keeps its limits, from its coefficients and the model alone.

use std::path::Path;

use claims::{LeftOut, Matter};
use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::error_margins::ErrorMargins;
use experiments::excitation::fitting::Obligations;
use experiments::excitation::gap_proof::Gap;
use experiments::excitation::held_limits::{HeldLimit, held, kinds_of_motion_alone};
use experiments::excitation::ledger::{LowestPoint, MotionLedger};
use experiments::excitation::limits::{CoordinateLimits, LimitKind, LimitsFile, given};
use experiments::excitation::margins::{self, Margins, with_margins};
use experiments::excitation::motion::Motion;
use experiments::excitation::proof::{CertificateRow, DescribedTorque, EnclosedTorque};
use experiments::excitation::space_limits::{Floor, SpaceLimits};

use crate::describe::adapters::surroundings::RobotSurroundings;
use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::described::torque_left_out;
use crate::motion::exciting::identified_torque;
use crate::motion::known_torque::KnownTorque;
use crate::request::CheckRequest;

/// A certificate made anew.
pub struct Checked {
    /// The limits with their proofs.
    pub certificate: Vec<CertificateRow>,
    /// What the certificate leaves out.
    pub left_out: Vec<LeftOut>,
    /// Height of the floor, m.
    pub floor: Option<f64>,
    /// The lowest point of the links that move, as far as instants show.
    pub lowest: Option<LowestPoint>,
    /// What the proof has in hand.
    pub margins: Margins,
    /// What else is to be known, in sentences.
    pub notes: Vec<String>,
    /// The limits that the coordinates are checked against.
    pub limits: Vec<CoordinateLimits>,
    /// The same limits one by one, each with its origin.
    pub origins: Vec<HeldLimit>,
}

impl Checked {
    /// The certificate with what it leaves out.
    pub fn ledger(&self) -> MotionLedger<'_> {
        let (rows, left_out) = (&self.certificate, &self.left_out);
        MotionLedger { rows, left_out, floor: self.floor, lowest: self.lowest.as_ref() }
    }

    /// Whether every row is proven, and all that the user asked for is looked at.
    pub fn is_proven(&self) -> bool {
        self.ledger().is_kept()
    }

    /// What speaks against the motion, in sentences.
    pub fn faults(&self) -> Vec<String> {
        self.ledger().faults()
    }
}

/// Proves the limits of a motion anew. Of its file only the coefficients and times are taken, and limits where they are
/// tighter than those of the description and of the request. Torques are those of the description or of the estimate in
/// the request. `file` stands in messages.
///
/// A motion is held to the distances and the floor of today's rules, whatever its own certificate lists; a note names what
/// that does not.
///
/// Fails where the motion was made with another model or is none, and where the limits leave no room.
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
    let (limits, origins) = held_limits(model, file, artefact, &motion, asked)?;
    let errors = margins_of(artefact, file, names, asked)?;
    let limits =
        with_margins(&errors, names, &limits).map_err(|what| Error::new(format_args!("{}: {what}", file.display())))?;

    // Torques.
    let identified = request.after.as_ref().map(|estimate| identified_torque(model, names, estimate)).transpose()?;
    let known = KnownTorque::new(model, identified.as_ref()).with_payload(model, errors.payload.as_ref())?;
    let loaded = known.loaded.as_ref().map(|(loaded, _)| loaded as &dyn EnclosedTorque);
    let torque = known.enclosure.as_ref().map(|torque| DescribedTorque {
        torque: torque as &dyn EnclosedTorque,
        friction: known.friction.clone(),
        share: artefact.effort_share,
        loaded,
    });

    // Bodies.
    let nothing = SpaceLimits::default();
    let user = asked.and_then(|asked| asked.space.as_ref()).unwrap_or(&nothing);
    let surroundings = RobotSurroundings::new(model, user, Some(&artefact.space), &limits, &errors)?;
    let obligations =
        Obligations { limits: &limits, names, torque: torque.as_ref(), surroundings: surroundings.some() };
    let certificate = obligations.certificate(&motion);

    // What is left out.
    let mut left_out = surroundings.left_out.clone();
    left_out.extend(torque_left_out(model, known.enclosure.is_some(), names, &limits, asked));
    left_out.extend(limits_of_file(&origins));
    left_out.extend(torques_of_file(artefact, request).filter(|_| torque.is_some()));
    left_out.push(LeftOut::approach());
    left_out.extend(margins::left_out(&errors));
    let seals =
        [artefact.seal.note(file.display()), after_note(request), beyond_own_list(artefact, &surroundings.gaps)];
    let notes = seals.into_iter().flatten().chain(notes(artefact, torque.is_some(), &origins)).collect();
    let (floor, lowest) = (surroundings.floor(), surroundings.lowest(&motion));
    let margins = Margins::new(&motion, &certificate, &obligations, &errors, surroundings.mesh_error());
    Ok(Checked { certificate, left_out, floor, lowest, margins, notes, limits, origins })
}

/// The margins of the user, and what the motion's own file has more.
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

/// Where the estimate that tells the torques is not as it was written.
pub(crate) fn after_note(request: &CheckRequest) -> Option<String> {
    request.after.as_ref()?.seal.note("[after]")
}

/// What the motion's own file says that proves nothing.
fn notes(artefact: &ExcitingMotion, knows_torque: bool, origins: &[HeldLimit]) -> Vec<String> {
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
    let limits_drives = |row: &HeldLimit| matches!(row.limit, LimitKind::Effort | LimitKind::Power);
    if knows_torque && artefact.effort_share < 1.0 && origins.iter().any(limits_drives) {
        notes.push(format!(
            "effort and power are held to {} of their limits: this is the effort_share of the motion's file",
            artefact.effort_share
        ));
    }
    notes
}

/// The kinds of limits that stand in the motion's file alone.
fn limits_of_file(origins: &[HeldLimit]) -> Option<LeftOut> {
    let kinds = kinds_of_motion_alone(origins);
    let what =
        "a limit that stands nowhere else is as the motion's file has it, loosened or not ([limits=FILE] gives yours)";
    (!kinds.is_empty()).then(|| LeftOut::assumed(Matter::Limit, kinds, what, "the motion's file"))
}

/// Torques that the motion's file brings along prove nothing: whoever writes the file writes them.
fn torques_of_file(artefact: &ExcitingMotion, request: &CheckRequest) -> Option<LeftOut> {
    let what = "the motion was made with torques of an estimate, which its file repeats; they prove nothing here \
                ([after=ESTIMATE] gives them)";
    let of = vec!["a robot with the torques of its description".into()];
    (artefact.identified.is_some() && request.after.is_none())
        .then(|| LeftOut::assumed(Matter::Effort, of, what, "the description"))
}

/// What the certificate of the motion's own file is not about. It is proved here all the same: a file does not say what it
/// is held to.
fn beyond_own_list(artefact: &ExcitingMotion, gaps: &[Gap]) -> Option<String> {
    // Certificates of an earlier version name links by those that carry them.
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

/// The limits of each coordinate, and their origins.
fn held_limits(
    model: &Model,
    file: &Path,
    artefact: &ExcitingMotion,
    motion: &Motion,
    asked: Option<&LimitsFile>,
) -> Result<(Vec<CoordinateLimits>, Vec<HeldLimit>), Error> {
    let refused = |what: String| Error::new(format_args!("{}: {what}", model.path.display()));
    asked.map_or(Ok(()), |asked| asked.check_names(model.regressor().coordinates())).map_err(refused)?;
    let (mut limits, mut origins) = (Vec::new(), Vec::new());
    for ((joint, coordinate), coefficients) in artefact.joints.iter().zip(&model.robot.coordinates).zip(&motion.joints)
    {
        let name = &joint.coordinate;
        let of_file = asked.map(|asked| given(&coordinate.limits, &asked.of(name), &asked.all)).transpose();
        let of_file = of_file.map_err(|what| refused(format!("coordinate {name}: {what}")))?;
        let (mut own, rows) = held(name, &joint.limits, &coordinate.limits, of_file.as_ref())
            .map_err(|what| Error::new(format_args!("{}: joint {name}: {what}", file.display())))?;
        if let Some(place) = own.locked.filter(|q| stirs(coefficients, *q)) {
            // The motion moves a locked coordinate. Its limits of position are then the locked position, and its bodies
            // count as moving.
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

/// rad (m): how far rounding may move a locked coordinate.
const LOCKED_MOTION_TOLERANCE: f64 = 1e-9;

/// Whether a coordinate that is locked moves, or stands elsewhere.
fn stirs(coefficients: &[f64], locked: f64) -> bool {
    let swing: f64 = coefficients.iter().skip(1).map(|x| x.abs()).sum();
    let centre = coefficients.first().copied().unwrap_or(locked);
    swing > LOCKED_MOTION_TOLERANCE || (centre - locked).abs() > LOCKED_MOTION_TOLERANCE
}
