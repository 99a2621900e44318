//! A replay (observer, load and drift of friction) that takes one sample at a time, for example from a running robot.
//!
//! Each sample gives one cycle: external torques, contact, load.
//!
//! `period` is the time between samples, s.

use std::path::Path;

use identification::estimate::artefact::Estimate;
use logs::LogSource;
use online::Load;

use crate::describe::model::Model;
use crate::error::Error;
use crate::replay::artefact::{CarriedLoad, ContactInterval, ReplayedCycle};
use crate::replay::cycles::{CycleModel, RecordMemory};
use crate::replay::run::{Run, Settings};
use crate::replay::start::Start;
use crate::request::ReplayRequest;

/// Observer, load and drift, with the state of all samples so far.
pub struct SampledReplay<'a> {
    cycles: CycleModel<'a>,
    run: Run,
    memory: RecordMemory,
    /// Time between samples, s.
    period: f64,
}

impl<'a> SampledReplay<'a> {
    /// Starts without contact and without a load.
    /// `period`: time between samples, s. All other arguments are those of [`crate::replay()`], and it fails for the same
    /// reasons.
    pub fn new(
        model: &'a Model,
        (file, estimate): (&Path, &'a Estimate),
        period: f64,
        reference: &[LogSource],
        request: &ReplayRequest,
    ) -> Result<SampledReplay<'a>, Error> {
        if !(period > 0.0 && period.is_finite()) {
            return Err(Error::new(format_args!(
                "the time between samples is {period} s: a positive number is expected"
            )));
        }
        let Start { cycles, noise, settings, .. } = Start::new(model, (file, estimate), reference, request)?;
        let run = Run::new(&cycles, noise, String::new(), Settings { period, ..settings });
        Ok(SampledReplay { cycles, run, memory: RecordMemory::default(), period })
    }

    /// Takes a sample. `t`: s; `q`, `dq`, `tau`: position, velocity and torque of the motor of each coordinate, SI units.
    ///
    /// Returns the cycle; `None` if the sample is not used: a number is NaN or infinite, or the time does not increase. The
    /// observers then start again with the next sample, as after a gap of five periods. Fails if a length differs from the number
    /// of coordinates.
    pub fn step(&mut self, t: f64, [q, dq, tau]: [&[f64]; 3]) -> Result<Option<&ReplayedCycle>, Error> {
        for (name, values) in [("q", q), ("dq", dq), ("tau", tau)] {
            let (found, expected) = (values.len(), self.cycles.n());
            if found != expected {
                return Err(Error::new(format_args!(
                    "{name} has {found} numbers: {expected} are expected, one a joint"
                )));
            }
        }
        // The cycle of the previous sample is removed, even if the present sample is not used.
        self.run.replay.series.clear();
        let is_usable = t.is_finite() && [q, dq, tau].concat().iter().all(|x| x.is_finite());
        if !is_usable || !self.memory.is_before(t) {
            self.memory = RecordMemory::default();
            return Ok(None);
        }
        let run = &mut self.run;
        self.cycles.sample((t, self.period), [q, dq, tau], &mut self.memory, &mut |cycle| run.step(cycle))?;
        Ok(self.run.replay.series.last())
    }

    /// The changes of the load so far, in the order of time. The last one has the parameters of the load that is carried.
    pub fn loads(&self) -> &[CarriedLoad] {
        &self.run.replay.loads
    }

    /// The load that would explain the present contact, before it is decided whether it is a load; see
    /// [`online::LoadMonitor::candidate`].
    pub fn candidate(&self) -> Option<&Load<f64>> {
        self.run.candidate()
    }

    /// The present contact, since it began; `None` without contact, and after it turned out to be a load.
    pub fn contact(&self) -> Option<&ContactInterval> {
        self.run.contact().filter(|_| !self.run.replay.series.is_empty())
    }

    /// Names of the coordinates, in the order of `q`.
    pub fn coordinates(&self) -> &[String] {
        &self.run.replay.coordinates
    }
}
