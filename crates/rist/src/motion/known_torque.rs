//! Known torques of a robot, from the description or an identification, with a possible payload. Search and proof use them.
//!
//! An enclosure gives interval bounds of the torques over a time interval of a motion. Effort is torque (force for a sliding
//! joint). Dry friction is the friction at standstill.

use experiments::excitation::limits::CoordinateLimits;
use experiments::excitation::proof::{EnclosedTorque, IdentifiedTorque, NominalFriction, NominalTorque};
use experiments::excitation::torque_barrier::TorqueBarrier;
use linear_model::known_load::KnownLoad;

use crate::describe::adapters::torque_enclosure::TorqueEnclosure;
use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::nominal::nominal_friction;

/// The torques of a robot as known from the description or from an identification.
pub(crate) struct KnownTorque<'a> {
    /// Bounds of the torques; `None` if no torque is known.
    pub(crate) enclosure: Option<TorqueEnclosure<'a>>,
    /// The base parameters from which the torques are computed; `None` if no base parameters are known.
    pub(crate) parameters: Option<Vec<f64>>,
    /// Bounds of the torques with a possible payload, and the base parameters with this payload; `None` without a payload.
    pub(crate) loaded: Option<(TorqueEnclosure<'a>, Vec<f64>)>,
    /// The friction of each coordinate.
    pub(crate) friction: Vec<NominalFriction>,
}

impl<'a> KnownTorque<'a> {
    /// The identified torques, or else the nominal torques of the description.
    pub(crate) fn new(model: &'a Model, identified: Option<&IdentifiedTorque>) -> KnownTorque<'a> {
        match identified {
            Some(IdentifiedTorque { parameters, friction }) => KnownTorque {
                enclosure: TorqueEnclosure::identified(model, parameters),
                parameters: Some(parameters.clone()),
                loaded: None,
                friction: friction.clone(),
            },
            None => KnownTorque {
                enclosure: TorqueEnclosure::new(model),
                parameters: model.nominal_parameters(),
                loaded: None,
                friction: nominal_friction(model),
            },
        }
    }

    /// Adds a possible payload. Fails if the robot has no link that carries it.
    pub(crate) fn with_payload(self, model: &'a Model, payload: Option<&KnownLoad>) -> Result<KnownTorque<'a>, Error> {
        let Some(payload) = payload else { return Ok(self) };
        let added = model.added_by(payload).map_err(|e| Error::new(format_args!("margins: payload: {e}")))?;
        let Some(parameters) = &self.parameters else { return Ok(self) };
        let both: Vec<f64> = parameters.iter().zip(&added).map(|(own, added)| own + added).collect();
        let loaded = TorqueEnclosure::identified(model, &both).map(|enclosure| (enclosure, both));
        Ok(KnownTorque { loaded, ..self })
    }

    /// Fails if a power limit is given but no torque is known, because power needs the torque.
    pub(crate) fn check_power(&self, names: &[String], limits: &[CoordinateLimits]) -> Result<(), String> {
        let limited = names.iter().zip(limits).find(|(_, l)| l.power.is_some() && self.enclosure.is_none());
        limited.map_or(Ok(()), |(name, _)| {
            Err(format!(
                "the limit of power of {name} needs the torque, which the description does not determine: give it inertial \
                 parameters, or an estimate ([after]), or leave that limit out"
            ))
        })
    }

    /// Fails if the dry friction of a joint alone exceeds the allowed share of its effort limit.
    pub(crate) fn check_friction(
        &self,
        names: &[String],
        limits: &[CoordinateLimits],
        share: f64,
    ) -> Result<(), String> {
        let is_taken = |(name, l, dry): (&String, &CoordinateLimits, f64)| {
            let effort = l.effort.filter(|effort| share * effort <= dry)?;
            // The message advises a larger share only if the full effort limit exceeds the friction.
            let or_share = if effort > dry { " or [effort_share]" } else { "" };
            Some(format!(
                "the effort limit of {name} is {effort}, of which [effort_share] allows {:.4}, and its dry friction alone takes \
                 {dry}: raise the limit{or_share}, or correct the friction",
                share * effort
            ))
        };
        let all = names.iter().zip(limits).zip(&self.friction);
        match self
            .enclosure
            .as_ref()
            .and_then(|_| all.map(|((name, l), f)| (name, l, f.coulomb.abs())).find_map(is_taken))
        {
            Some(fault) => Err(fault),
            None => Ok(()),
        }
    }

    /// The torques for a proof; `None` if there are no limits of effort or power, or no known torques. A motion may use the
    /// share `share` of these limits.
    pub(crate) fn nominal_enclosure(&self, share: f64, limits: &[CoordinateLimits]) -> Option<NominalTorque<'_>> {
        limits.iter().find(|l| l.effort.is_some() || l.power.is_some())?;
        let torque: &dyn EnclosedTorque = self.enclosure.as_ref()?;
        let loaded = self.loaded.as_ref().map(|(loaded, _)| loaded as &dyn EnclosedTorque);
        Some(NominalTorque { torque, friction: self.friction.clone(), share, loaded })
    }

    /// The barrier that keeps the search within the effort limits. It includes a possible payload, which usually needs more
    /// torque.
    pub(crate) fn torque_barrier(&self, share: f64) -> Option<TorqueBarrier> {
        let parameters = self.loaded.as_ref().map(|(_, parameters)| parameters).or(self.parameters.as_ref())?;
        Some(TorqueBarrier { parameters: parameters.clone(), friction: self.friction.clone(), share })
    }
}
