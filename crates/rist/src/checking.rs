//! Checks whether a motion keeps its limits, from the motion and the model alone.

use std::path::Path;

use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::fitting::Obligations;
use experiments::excitation::held_limits::{HeldLimit, alone_text, held};
use experiments::excitation::limits::{CoordinateLimits, LimitKind, LimitsFile, given};
use experiments::excitation::motion::Motion;
use experiments::excitation::proof::{CertificateRow, DescribedTorque, EnclosedTorque, Kept};

use crate::adapters::surroundings::RobotSurroundings;
use crate::described::torque_note;
use crate::error::Error;
use crate::exciting::KnownTorque;
use crate::model::Model;

/// A certificate made anew.
pub struct Checked {
    /// The limits with their proofs.
    pub certificate: Vec<CertificateRow>,
    /// What was not looked at, in sentences.
    pub notes: Vec<String>,
    /// The limits that the coordinates are checked against.
    pub limits: Vec<CoordinateLimits>,
    /// The same limits one by one, each with its origin.
    pub origins: Vec<HeldLimit>,
}

impl Checked {
    /// Whether every limit is proven to be kept.
    pub fn is_proven(&self) -> bool {
        self.certificate.iter().all(|r| r.kept == Kept::Proven)
    }

    /// The rows that speak against the motion.
    pub fn faults(&self) -> impl Iterator<Item = &CertificateRow> {
        self.certificate.iter().filter(|r| r.kept != Kept::Proven)
    }
}

/// Proves the limits of a motion anew. These are the limits that it was made with, but no looser than the description's
/// and those of `asked`, a limits file. `file` stands in messages. The certificate in the motion is not trusted.
///
/// Fails where the motion was made with another model or is none, and where the limits leave no room.
pub fn check(
    model: &Model,
    file: &Path,
    artefact: &ExcitingMotion,
    asked: Option<&LimitsFile>,
) -> Result<Checked, Error> {
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
    let known = KnownTorque::new(model, artefact.identified.as_ref());
    let friction = known.friction.clone();
    if friction.len() != names.len() || artefact.identified.is_some() && known.enclosure.is_none() {
        let (count, n) = (model.regressor().parameters().len(), names.len());
        let what = format!("identified: expected are {count} parameters, and friction of {n} joints");
        return Err(Error::new(format_args!("{}: {what}", file.display())));
    }
    known.check_power(names, &limits).map_err(|what| Error::new(format_args!("{}: {what}", file.display())))?;
    let torque = known.enclosure.as_ref().map(|torque| DescribedTorque {
        torque: torque as &dyn EnclosedTorque,
        friction,
        share: artefact.effort_share,
    });
    let space = match asked.and_then(|asked| asked.space.as_ref()) {
        Some(asked) => artefact.space.with(asked),
        None => artefact.space.clone(),
    };
    let surroundings = RobotSurroundings::new(model, &space, &limits)?;
    let obligations =
        Obligations { limits: &limits, names, torque: torque.as_ref(), surroundings: surroundings.some() };
    let mut notes: Vec<String> = torque_note(known.enclosure.is_some(), names, &limits).into_iter().collect();
    notes.extend_from_slice(surroundings.notes());
    if artefact.identified.is_some() {
        notes.push("torques are those of the identified parameters that stand in the motion's file".into());
    }
    let limits_drives = |row: &HeldLimit| matches!(row.limit, LimitKind::Effort | LimitKind::Power);
    if torque.is_some() && artefact.effort_share < 1.0 && origins.iter().any(limits_drives) {
        notes.push(format!(
            "effort and power are held to {} of their limits: this is the effort_share of the motion's file",
            artefact.effort_share
        ));
    }
    let is_room_own = asked.is_none_or(|asked| asked.space.is_none());
    notes.extend(alone_text(&origins, if is_room_own { &["distances, floors, walls and boxes"] } else { &[] }));
    Ok(Checked { certificate: obligations.certificate(&motion), notes, limits, origins })
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
