//! Whether a motion keeps its limits, found again from the motion and the model alone.

use std::path::Path;

use identification::experiments::excitation::artefact::ExcitingMotion;
use identification::experiments::excitation::fitting::Obligations;
use identification::experiments::excitation::limits::{CoordinateLimits, tightened};
use identification::experiments::excitation::proof::{CertificateRow, DescribedTorque, EnclosedTorque, Kept};

use crate::described::torque_note;
use crate::error::Error;
use crate::exciting::KnownTorque;
use crate::model::Model;
use crate::surroundings::RobotSurroundings;

/// A certificate made anew.
pub struct Checked {
    /// The limits with what proves them.
    pub certificate: Vec<CertificateRow>,
    /// What was not looked at, in sentences.
    pub notes: Vec<String>,
    /// What the coordinates are held to.
    pub limits: Vec<CoordinateLimits>,
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

/// Proves the limits of a motion anew: those it was made with, no looser than the description's; `file` stands in
/// messages. The certificate in the motion is not believed.
///
/// Fails where the motion was made with another model or is none.
pub fn check(model: &Model, file: &Path, artefact: &ExcitingMotion) -> Result<Checked, Error> {
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
    let limits = artefact.joints.iter().zip(&model.robot.coordinates).map(|(joint, c)| {
        tightened(&joint.limits, &c.limits)
            .map_err(|what| Error::new(format_args!("{}: joint {}: {what}", file.display(), joint.coordinate)))
    });
    let limits: Vec<CoordinateLimits> = limits.collect::<Result<_, _>>()?;
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
    let surroundings = RobotSurroundings::new(model, &artefact.space, &limits)?;
    let obligations =
        Obligations { limits: &limits, names, torque: torque.as_ref(), surroundings: surroundings.some() };
    let mut notes: Vec<String> = torque_note(known.enclosure.is_some(), names, &limits).into_iter().collect();
    notes.extend_from_slice(surroundings.notes());
    Ok(Checked { certificate: obligations.certificate(&motion), notes, limits })
}
