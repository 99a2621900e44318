//! What a replay starts from: the cycles of the model, the noise without contact, and the settings that follow from it.
//!
//! The noise is measured in logs without contact (`reference`).

use std::path::Path;

use identification::estimate::artefact::Estimate;
use logs::LogSource;
use online::Order;

use crate::describe::model::Model;
use crate::error::Error;
use crate::fit::verdict::refuse_estimate;
use crate::replay::cycles::CycleModel;
use crate::replay::inputs::{HOLD_S, covariance, last_link};
use crate::replay::noise::Noise;
use crate::replay::run::Settings;
use crate::request::{ObserverOrder, ReplayRequest, Request};

/// All that a replay needs before its first cycle.
pub(super) struct Start<'a> {
    pub(super) cycles: CycleModel<'a>,
    pub(super) noise: Noise,
    pub(super) settings: Settings,
    /// The link that carries a load.
    pub(super) link: String,
}

impl<'a> Start<'a> {
    /// Prepares a replay. Takes the arguments of [`crate::replay()`], and fails like [`crate::replay()`]. The settings do not
    /// contain the period yet; the caller must set it.
    pub(super) fn new(
        model: &'a Model,
        (file, estimate): (&Path, &'a Estimate),
        reference: &[LogSource],
        request: &ReplayRequest,
    ) -> Result<Start<'a>, Error> {
        request.check()?;
        model.check_estimate(file, estimate)?;
        refuse_estimate(file, estimate, request.anyway, "not replayed ([anyway=true] replays it)")?;
        let gain = request.observer_gain;
        let order = match request.order {
            ObserverOrder::First => Order::First(gain),
            ObserverOrder::Second => Order::Second(gain),
        };
        let link = request.load_on.clone().unwrap_or_else(|| last_link(model));
        let mut cycles = CycleModel::new(model, estimate, &link, gain)?;
        if let Some(link) = &request.wrench_on {
            cycles.evaluate_jacobian(link)?;
        }
        let covariance = covariance(&cycles.linear, estimate);
        // The noise is measured through the observer of the replay, because its order and gain determine the noise.
        let noise = Noise::measure(&mut cycles, reference, covariance.as_ref(), (order, gain), HOLD_S)?;
        let settings = Settings {
            order,
            gain,
            period: f64::INFINITY,
            threshold: noise.peaks.threshold(request.alarms),
            significant: noise.peaks.significant(),
            hold: HOLD_S,
            largest_load: request.largest_load,
        };
        Ok(Start { cycles, noise, settings, link })
    }
}
