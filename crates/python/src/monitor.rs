//! The class `rist.Monitor`: observer, load and drift, a sample at a time.
//!
//! The state borrows from model and estimate, so a thread owns all three. It answers one sample after another and ends with the
//! object.

use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rist::replay::{ContactInterval, ReplayedCycle, SampledReplay, reference_logs};
use rist::request::ReplayRequest;

use crate::arrays::{RowMajor, array};
use crate::call::Call;
use crate::error::OrError;
use crate::estimate::Estimate;
use crate::model::Model;
use crate::work::work;

/// Time, s; q, dq and tau of each coordinate.
type Sample = (f64, [Vec<f64>; 3]);

/// The answer to a sample that was used.
struct Answer {
    cycle: ReplayedCycle,
    contact: Option<ContactInterval>,
    load: Option<rist::replay::CarriedLoad>,
    /// Mass of the candidate and its standard deviation, kg.
    candidate: Option<(f64, f64)>,
    changes: usize,
}

type Answers = Receiver<Result<Option<Answer>, rist::Error>>;

/// Observer of the external torque, load and drift of friction. It takes one sample at a time, as on a robot.
///
/// model, estimate: as for `replay`. period: time between samples, s.
///
/// >>> monitor = rist.Monitor("arm.urdf", estimate, period=0.002)
/// >>> for cycle in (monitor.step(t, q, dq, tau) for t, q, dq, tau in robot): ...
///
/// Options:
/// - reference: Logs without contact, from which the noise of the observer is measured [default: the logs of the
///   estimate]
/// - alarms: Accepted number of false alarms per hour [default: 1.0]
/// - observer_gain: Gain of the observer of external torques, 1/s [default: 50.0]
/// - order: Filter of the observer of external torques [default: 'first']
/// - load_on: Link or frame that carries a load [default: the last link]
/// - largest_load: Largest possible mass of a load, kg [default: 10.0]
/// - wrench_on: Link or frame for the force and the moment of each contact: both are computed at the origin and
///   in the axes of this frame
/// - anyway: Use the estimate even if its verdict is no. Otherwise the estimate is refused [default: False]
#[pyclass(frozen, module = "rist")]
pub struct Monitor {
    coordinates: Vec<String>,
    ends: Mutex<(Sender<Sample>, Answers)>,
}

#[pymethods]
impl Monitor {
    #[new]
    #[pyo3(signature = (model, estimate, period, **options), text_signature = "(model, estimate, period, *, reference=None, alarms=1.0, observer_gain=50.0, order='first', load_on=None, largest_load=10.0, wrench_on=None, anyway=False)")]
    fn new(
        model: &Bound<'_, PyAny>,
        estimate: &Estimate,
        period: f64,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Monitor> {
        let request: ReplayRequest = Call::new("replay", &[], options)?.request()?;
        let used = Model::for_estimate(model, estimate)?;
        let (held, estimate) = (used.get().inner.clone(), estimate.inner.clone());
        let (send, samples) = channel::<Sample>();
        let (answers, receive) = channel();
        let (started, start) = channel();
        std::thread::spawn(move || {
            let file = Path::new("the estimate");
            let reference = reference_logs(&held, file, &estimate, &request.reference);
            let replay =
                reference.and_then(|logs| SampledReplay::new(&held, (file, &estimate), period, &logs, &request));
            let mut replay = match replay {
                Ok(replay) => replay,
                Err(e) => return drop(started.send(Err(e))),
            };
            // From here on, `new` can return: it waits for the result of the start, which is the names or an error.
            let _ = started.send(Ok(replay.coordinates().to_vec()));
            for (t, [q, dq, tau]) in samples {
                let cycle = replay.step(t, [&q, &dq, &tau]).map(Option::<&ReplayedCycle>::cloned);
                let answer = cycle.map(|cycle| {
                    let (contact, loads) = (replay.contact().cloned(), replay.loads());
                    let candidate = replay.candidate().map(|load| (load.parameters[9], load.sigma[9]));
                    let (load, changes) = (loads.last().cloned(), loads.len());
                    cycle.map(|cycle| Answer { cycle, contact, load, candidate, changes })
                });
                // Sending fails when the object no longer exists. Then the thread ends.
                if answers.send(answer).is_err() {
                    break;
                }
            }
        });
        let coordinates = work(model.py(), None, move |_| start.recv().unwrap_or_else(|_| Err(ended())))?;
        Ok(Monitor { coordinates, ends: Mutex::new((send, receive)) })
    }

    /// Takes a sample. t: time, s. q, dq, tau: position, velocity and torque of the motor of each coordinate, SI units.
    ///
    /// Returns a dict. t: time, s. torque: the external torque; beyond: the external torque without the torque of the load;
    /// band: the limit of beyond without contact; these are arrays in N m (N). contact: whether there is contact. last_joint:
    /// the link of this joint, or a later link, is touched. wrench: force and moment on `wrench_on`, None for a component that
    /// is not determined. mass: mass of the load, kg; sigma: its standard deviation. parameters: of the load. changes: how
    /// often the load has changed. candidate: mass and its standard deviation if the present contact is a load, kg; else None.
    /// Returns None if the sample is not used, because it has NaN or its time does not increase.
    fn step<'py>(
        &self,
        py: Python<'py>,
        t: f64,
        q: &Bound<'py, PyAny>,
        dq: &Bound<'py, PyAny>,
        tau: &Bound<'py, PyAny>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let numbers = |name, x| Ok::<_, PyErr>(RowMajor::new(name, x)?.numbers()?.to_vec());
        let sample = (t, [numbers("q", q)?, numbers("dq", dq)?, numbers("tau", tau)?]);
        // Other Python threads run while this thread waits for the answer. One lock covers the ends of both channels, so the
        // answer belongs to the sample that was sent.
        let answer = py.detach(|| {
            let ends = self.ends.lock().unwrap_or_else(PoisonError::into_inner);
            ends.0.send(sample).map_err(|_| ended())?;
            ends.1.recv().map_err(|_| ended())?
        });
        let Some(Answer { cycle, contact, load, candidate, changes }) = answer.or_error()? else { return Ok(None) };
        let dict = PyDict::new(py);
        dict.set_item("t", cycle.t)?;
        for (name, values) in [("torque", &cycle.torque), ("beyond", &cycle.beyond), ("band", &cycle.band)] {
            dict.set_item(name, array(py, &[values.len()], values)?)?;
        }
        dict.set_item("contact", cycle.is_contact)?;
        dict.set_item("last_joint", contact.as_ref().map(|contact| self.coordinates[contact.last_joint].as_str()))?;
        let wrench = contact.and_then(|contact| contact.wrench);
        dict.set_item("wrench", wrench.map(|wrench| PyList::new(py, wrench.components)).transpose()?)?;
        // If the load was put down, the last entry has no significant mass. Then the mass is reported as zero.
        let load = load.filter(rist::replay::CarriedLoad::is_held);
        dict.set_item("mass", load.as_ref().map_or(0.0, |load| load.mass().0))?;
        dict.set_item("sigma", load.as_ref().map(|load| load.mass().1))?;
        dict.set_item("parameters", load.map(|load| PyList::new(py, load.load.parameters)).transpose()?)?;
        dict.set_item("changes", changes)?;
        dict.set_item("candidate", candidate)?;
        Ok(Some(dict))
    }

    /// Names of the coordinates, in the order of q.
    #[getter]
    fn coordinates(&self) -> Vec<String> {
        self.coordinates.clone()
    }
}

/// The thread has ended: only a defect of rist does that.
fn ended() -> rist::Error {
    rist::Error::new("the monitor has ended; make a new one")
}
