//! Whether a motion keeps its limits, found again from the motion and the model alone.

use std::path::Path;

use identification::experiments::excitation::artefact::ExcitingMotion;
use identification::experiments::excitation::limits::{CoordinateLimits, tightened};
use identification::experiments::excitation::proof::{
    CertificateRow, DescribedTorque, Kept, prove_motion, prove_torque,
};

use crate::error::Error;
use crate::exciting::{described_friction, torque_note};
use crate::model::Model;
use crate::torque_enclosure::TorqueEnclosure;

/// A certificate made anew.
pub struct Checked {
    /// The limits with what proves them.
    pub certificate: Vec<CertificateRow>,
    /// What was not looked at, in sentences.
    pub notes: Vec<String>,
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
    let mut certificate = prove_motion(&motion, &limits, names);
    if let Some(torque) = TorqueEnclosure::new(model) {
        let friction = described_friction(model);
        let described = DescribedTorque { torque: &torque, friction, share: artefact.effort_share };
        certificate.extend(prove_torque(&motion, &limits, names, &described));
    }
    let notes = torque_note(model, names, &limits).into_iter().collect();
    Ok(Checked { certificate, notes })
}
