//! Converts the signals of a log into states: filtered positions, velocities, accelerations and torques.
//!
//! q and tau are filtered with a zero-phase low-pass (`butterworth`). dq is the measured velocity with the same filter, or the
//! central difference of q. ddq is the central difference of dq. Then every `decimate`-th sample is kept, except near the ends.
//! The equation tau = Y(q, dq, ddq) X stays true to first order, because the filter is equal on both sides [Gautier 1997].
//!
//! Friction columns jump with sign(dq). The low-pass smooths the jumps of the torques, so these columns are filtered too.
//! Before this filter, they are computed from a velocity that is filtered with a higher cut-off (`reversals`).
//!
//! `cutoff` gives the default cut-off. Not here: transmissions (`transmission`), friction (`linear_model::friction`).

use linear_model::coupling::Coupling;
use linear_model::friction::terms::{FrictionTerm, sign};
use linear_model::states::{FilteredFriction, States};
use logs::{Error, Log, Window};

use crate::signals::butterworth::Butterworth;
use crate::signals::cutoff;
use crate::signals::cutoff::{FrequencyContent, MotionEnergy};
use crate::signals::differences::Differences;
use crate::signals::resample::{interpolate, uniform_clock};
use crate::signals::reversals::{columns, directions};
use crate::signals::seldom::{are_seldom, at_places, changes, sample_period};
use crate::signals::signal_options::{REVERSAL_CUTOFF_RATIO, Signal, Velocity, possible_delay};
use crate::signals::standstill::{rest, standstill};
use crate::signals::velocity_check::check_velocity;

/// The signals of a log at the joints, after the transmission between log and joints was applied.
pub struct JointSignals {
    /// The log from which the signals come. Only its time is used; the other series were moved into the fields below.
    pub log: Log,
    /// Positions, rad (m), one series per coordinate.
    pub q: Vec<Vec<f64>>,
    /// Measured velocities, rad/s (m/s). `None`: not in the log.
    pub dq: Option<Vec<Vec<f64>>>,
    /// Measured accelerations, rad/s^2 (m/s^2). `None`: not in the log.
    pub ddq: Option<Vec<Vec<f64>>>,
    /// Torques of the joints, N m (N), one series per coordinate.
    pub tau: Vec<Vec<f64>>,
    /// Motors that turn with several joints, and elastic or dissipative elements between joints.
    pub couplings: Vec<Coupling>,
}

impl JointSignals {
    /// Resamples the signals to the requested clock and compensates the delay of the torques. Returns the times of the clock, s.
    fn on_clock(&mut self, signal: &Signal) -> Result<Vec<f64>, Error> {
        let [motion, effort] = self.own_places(signal);
        let t = match clock(&self.log, signal, motion.as_deref())? {
            None => self.log.t.clone(),
            Some(clock) => clock,
        };
        let own = &self.log.t;
        let is_own = t == *own;
        let bring = |x: &mut Vec<f64>, places: &Option<Vec<usize>>| match places {
            Some(places) => *x = interpolate(&at_places(own, places), &at_places(x, places), &t),
            None if is_own => {}
            None => *x = interpolate(own, x, &t),
        };
        let motions = [Some(&mut self.q), self.dq.as_mut(), self.ddq.as_mut()];
        motions.into_iter().flatten().flatten().for_each(|x| bring(x, &motion));
        self.tau.iter_mut().for_each(|x| bring(x, &effort));
        let delay = possible_delay(signal.delay).map_err(|message| Error::at(&self.log.name, 0, message))?;
        if delay != 0.0 {
            let later: Vec<f64> = t.iter().map(|t| t + delay).collect();
            for x in &mut self.tau {
                *x = interpolate(&t, x, &later);
            }
        }
        Ok(t)
    }

    /// The rows that are samples of the motion, and the rows that are samples of the torques; all other rows only repeat the
    /// previous value. `None`: every row is a sample.
    fn own_places(&self, signal: &Signal) -> [Option<Vec<usize>>; 2] {
        let [motion, effort] = are_seldom(&self.log).map(|is_seldom| is_seldom && !signal.own_clock);
        let rates = self.dq.iter().chain(&self.ddq).flatten();
        let moving: Vec<&[f64]> = self.q.iter().chain(rates).map(Vec::as_slice).collect();
        let torques: Vec<&[f64]> = self.tau.iter().map(Vec::as_slice).collect();
        [changes(&moving, motion), changes(&torques, effort)]
    }

    /// Converts the signals into states: filters, differentiates and decimates them.
    ///
    /// `friction`: terms whose columns are computed first and then filtered. `content`: frequency content of all logs that are
    /// fitted together; `None`: the content of this log. Fails if a cut-off is not below half the sampling rate, or if a
    /// requested measured signal is absent.
    pub fn states(
        mut self,
        signal: &Signal,
        friction: &[FrictionTerm],
        content: Option<&FrequencyContent>,
    ) -> Result<States, Error> {
        let t = self.on_clock(signal)?;
        let period = step(&t);
        // If the rows come from two sources, velocity and position may not belong together. The log check reports such rows.
        let is_of_one = self.log.report.suspect.iter().all(|suspect| suspect.foreign_rows == 0);
        if let Some(dq) = self.dq.as_ref().filter(|_| is_of_one && signal.velocity != Velocity::Differentiated) {
            check_velocity(&self.log.name, &self.log.coordinates, &t, &self.q, dq, period)?;
        }
        let content = content.cloned().unwrap_or_else(|| cutoff::rule(&self.q, period));
        let differentiated = self.dq.is_none() || signal.velocity == Velocity::Differentiated;
        let filters = Filters::new(signal, content.cutoff, period, differentiated)
            .map_err(|message| Error::at(&self.log.name, 0, message))?;
        let decimate = signal.decimation(filters.cutoff, period);
        let border = signal.border_of(filters.cutoff, differentiated);
        let chosen = chosen_samples(&self.log, &t, border, signal, decimate);
        let JointSignals { log, q, dq, ddq, tau, couplings } = self;
        // Load-dependent friction is computed from torques that pass the same low-pass as the velocity for reversals.
        let load = friction.contains(&FrictionTerm::Load).then(|| filters.reversal.pass(tau.clone()));
        let differences = Differences::new(&t);
        // Without a filter, the direction of motion is the sign of the velocity at the sample.
        let rounded = signal.filtered_sign && signal.order > 0;
        let wide = match &dq {
            _ if !rounded => None,
            Some(dq) if !differentiated => Some(dq.clone()),
            _ => Some(q.iter().map(|q| differences.of(q)).collect()),
        };
        let filtering =
            Filtering { signal, filters: &filters, friction, load, differences: &differences, period, chosen: &chosen };
        let motion = || filtering.motion(q, dq, ddq);
        let torques = || filtering.rounded(tau);
        let directions = || wide.map(|wide| filtering.directions(filters.reversal.pass(wide), &couplings));
        let (motion, tau, directions) = match t.len() < MIN_SAMPLES_FOR_SECOND_THREAD {
            true => (motion(), torques(), directions()),
            false => std::thread::scope(|scope| {
                let (torques, directions) = (scope.spawn(torques), scope.spawn(directions));
                let motion = motion();
                (motion, joined(torques), joined(directions))
            }),
        };
        let motion = motion.map_err(|message| Error::at(&log.name, 0, message))?;
        let directions = directions.unwrap_or_else(|| signs(&motion.dq, &couplings, log.coordinates.len()));
        Ok(States {
            n: log.coordinates.len(),
            t: chosen.iter().map(|&r| t[r]).collect(),
            tau,
            cutoff: filters.cutoff,
            effort_cutoff: filters.effort_cutoff,
            period: period * decimate as f64,
            f95: content.f95,
            direction: directions.direction,
            motor_direction: directions.motor_direction,
            friction: directions.friction,
            ..motion
        })
    }
}

/// A low-pass, or no filter.
struct Pass(Option<Butterworth>);

impl Pass {
    fn new(order: usize, cutoff: f64, period: f64) -> Result<Pass, String> {
        let rate = 1.0 / period;
        match order {
            0 => Ok(Pass(None)),
            _ => Butterworth::low_pass(order, cutoff, rate).map(|f| Pass(Some(f))).ok_or_else(|| {
                format!("a low-pass of order {order} at {cutoff} Hz: the order is 1 to 20 and the cut-off between 0 and half the rate, {:.3} Hz", 0.5 * rate)
            }),
        }
    }

    fn pass(&self, x: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        match &self.0 {
            Some(f) => f.zero_phase(x),
            None => x,
        }
    }

    /// The filtered samples with the indices `chosen`, sample by sample.
    fn pass_at(&self, x: Vec<Vec<f64>>, chosen: &[usize]) -> Vec<f64> {
        match &self.0 {
            Some(f) => f.zero_phase_at(&x, chosen),
            None => chosen_rows(chosen, &x),
        }
    }
}

/// Largest default cut-off of the low-pass before sign(dq), divided by the sampling rate, if dq is differentiated from
/// positions. The default cut-off is never below the cut-off of the torques. The noise of dq grows with f^(3/2); with a higher
/// cut-off, encoder steps would change the sign many times.
const MAX_REVERSAL_CUTOFF_SHARE: f64 = 0.2;
/// The velocity is not filtered if the cut-off of the low-pass before sign(dq) is above this share of the sampling rate.
const HIGHEST_FILTER_CUTOFF_SHARE: f64 = 0.45;

/// The low-passes for the signals of a log.
struct Filters {
    /// The low-pass for positions, velocities and accelerations.
    motion: Pass,
    /// The low-pass for torques and friction columns.
    effort: Pass,
    /// The low-pass for the velocity from which friction columns are computed.
    reversal: Pass,
    /// Cut-off of `motion`, Hz, then of `effort`, Hz; 0: no filter.
    cutoff: f64,
    effort_cutoff: f64,
}

impl Filters {
    /// Makes the low-passes for these options. `rule`: default cut-off, Hz; `period`: time between samples, s; `differentiated`:
    /// whether the velocity is differentiated from positions. Fails if a cut-off or the order is invalid.
    fn new(signal: &Signal, rule: f64, period: f64, differentiated: bool) -> Result<Filters, String> {
        let cutoff = if signal.order == 0 { 0.0 } else { signal.cutoff.unwrap_or(rule) };
        let effort_cutoff = if signal.order == 0 { 0.0 } else { signal.effort_cutoff.unwrap_or(cutoff) };
        let pass = |cutoff: f64| Pass::new(signal.order, cutoff, period);
        let (motion, effort) = (pass(cutoff)?, pass(effort_cutoff)?);
        let wide = signal.reversal_cutoff.unwrap_or_else(|| match differentiated {
            true => (REVERSAL_CUTOFF_RATIO * effort_cutoff).min(MAX_REVERSAL_CUTOFF_SHARE / period).max(effort_cutoff),
            false => REVERSAL_CUTOFF_RATIO * effort_cutoff,
        });
        // If the sampling rate is too low for the cut-off `wide`, the velocity is not filtered.
        let reversal = if wide < HIGHEST_FILTER_CUTOFF_SHARE / period { pass(wide)? } else { Pass(None) };
        Ok(Filters { motion, effort, reversal, cutoff, effort_cutoff })
    }
}

/// Waits for a thread and returns its result. A panic of the thread is raised again here.
fn joined<T>(thread: std::thread::ScopedJoinHandle<T>) -> T {
    thread.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause))
}

/// The samples with the indices `chosen` of all series, sample by sample.
fn chosen_rows<T: Copy>(chosen: &[usize], x: &[Vec<T>]) -> Vec<T> {
    let mut rows = Vec::with_capacity(chosen.len() * x.len());
    chosen.iter().for_each(|&r| rows.extend(x.iter().map(|x| x[r])));
    rows
}

/// The filters and options with which the motion and the torques of a log are converted.
struct Filtering<'a> {
    signal: &'a Signal,
    filters: &'a Filters,
    friction: &'a [FrictionTerm],
    /// Torques after the low-pass of the velocity for reversals, N m (N). `None`: no friction term needs them.
    load: Option<Vec<Vec<f64>>>,
    differences: &'a Differences<'a>,
    period: f64,
    chosen: &'a [usize],
}

impl Filtering<'_> {
    /// The states without torques and friction: filtered q, dq and ddq at the chosen samples, and whether each row is used.
    fn motion(&self, q: Vec<Vec<f64>>, dq: CoordinateSeries, ddq: CoordinateSeries) -> Result<States, String> {
        let signal = self.signal;
        let q = self.filters.motion.pass(q);
        let still = signal.standstill.is_none().then(|| {
            let moves = |q: &Vec<f64>| standstill(q, self.period).into_iter().map(|still| !still).collect();
            chosen_rows(self.chosen, &q.iter().map(moves).collect::<Vec<Vec<bool>>>())
        });
        let dq = match self.measured(signal.velocity, dq, "velocity")? {
            Some(dq) => dq,
            None => q.iter().map(|q| self.differences.of(q)).collect(),
        };
        let n = q.len();
        let mut q = chosen_rows(self.chosen, &q);
        let mut ddq = match self.measured(signal.acceleration, ddq, "acceleration")? {
            Some(ddq) => chosen_rows(self.chosen, &ddq),
            None => self.chosen.iter().flat_map(|&r| dq.iter().map(move |dq| self.differences.at(dq, r))).collect(),
        };
        let mut dq = chosen_rows(self.chosen, &dq);
        let used = match (signal.standstill, still) {
            (Some(speed), _) => dq.iter().map(|dq| dq.abs() > speed || speed == 0.0).collect(),
            (None, still) => rest(still.unwrap_or_default(), n, &mut q, [&mut dq, &mut ddq]),
        };
        Ok(States { q, dq, ddq, used, ..States::default() })
    }

    /// The measured signal, filtered; `None` if it must be differentiated. Fails if a requested signal is absent.
    fn measured(&self, wish: Velocity, measured: CoordinateSeries, name: &str) -> Result<CoordinateSeries, String> {
        match (wish, measured) {
            (Velocity::Measured, None) => Err(format!("the log has no measured {name}; differentiate it instead")),
            (Velocity::Differentiated, _) | (_, None) => Ok(None),
            (_, Some(x)) => Ok(Some(self.filters.motion.pass(x))),
        }
    }

    /// The chosen samples of the series, after the low-pass of the torques.
    fn rounded(&self, x: Vec<Vec<f64>>) -> Vec<f64> {
        self.filters.effort.pass_at(x, self.chosen)
    }

    /// The directions of motion and the friction columns. Both are computed from the velocities `wide`, one series per joint,
    /// which are filtered with a higher cut-off; then they are filtered like the torques.
    fn directions(&self, wide: Vec<Vec<f64>>, couplings: &[Coupling]) -> Directions {
        let motor = |c: &Coupling| {
            let speed = |r: usize| c.speed(|k| wide[k][r]);
            directions(&(0..wide.first().map_or(0, Vec::len)).map(speed).collect::<Vec<f64>>())
        };
        let none = Vec::new();
        let of_term = |&term: &FrictionTerm| {
            let torque = |j: usize| self.load.as_ref().map_or(&none, |load| &load[j]);
            let of_joint = |(j, v): (usize, &Vec<f64>)| columns(term, v, torque(j));
            FilteredFriction { term, columns: self.rounded(wide.iter().enumerate().flat_map(of_joint).collect()) }
        };
        let friction = self.friction.iter().map(of_term).collect();
        let motor_direction = self.rounded(couplings.iter().map(motor).collect());
        // The memory of each velocity is freed as soon as the direction is computed.
        let direction = self.rounded(wide.into_iter().map(|v| directions(&v)).collect());
        Directions { direction, motor_direction, friction }
    }
}

/// One series per coordinate. `None`: not measured.
type CoordinateSeries = Option<Vec<Vec<f64>>>;

/// Direction of motion and friction columns of a record, in the shapes of the fields of [`States`] with these names.
struct Directions {
    direction: Vec<f64>,
    motor_direction: Vec<f64>,
    friction: Vec<FilteredFriction>,
}

/// The directions if no filter is used: the signs of the velocities of the n joints and of the coupled motors, sample by sample.
fn signs(dq: &[f64], couplings: &[Coupling], n: usize) -> Directions {
    let motors = |dq: &[f64]| couplings.iter().map(|c| sign(c.speed(|k| dq[k]))).collect::<Vec<f64>>();
    Directions {
        direction: dq.iter().map(|&v| sign(v)).collect(),
        motor_direction: dq.chunks(n.max(1)).flat_map(motors).collect(),
        friction: Vec::new(),
    }
}

/// Least number of samples for a second thread. With fewer samples, starting the thread takes longer than the thread saves.
const MIN_SAMPLES_FOR_SECOND_THREAD: usize = 20_000;

/// The times of the uniform clock to which the signals are resampled, s. `None`: the signals keep their own clock. `places`: rows
/// that are samples of the motion, if not every row is a sample. Fails if the clock is unusable.
fn clock(log: &Log, signal: &Signal, places: Option<&[usize]>) -> Result<Option<Vec<f64>>, Error> {
    let is_seldom = are_seldom(log)[0] && !signal.own_clock;
    if (log.report.clock.uniform || signal.own_clock) && signal.rate.is_none() && !is_seldom {
        return Ok(None);
    }
    let period = sample_period(&log.report, signal);
    let clock = log.t.first().zip(log.t.last()).and_then(|(&start, &end)| {
        // The clock starts a whole number of periods before the first new value.
        let first = places.and_then(<[usize]>::first).map_or(start, |&r| log.t[r]);
        uniform_clock(&[first - period * ((first - start) / period).floor(), end], period)
    });
    clock.map(Some).ok_or_else(|| {
        let duration = log.report.clock.duration;
        let message = format!("a clock of {:.3} Hz over {duration:.3} s is not usable", 1.0 / period);
        Error::at(&log.name, 0, message)
    })
}

/// Adds the motion of a log to `energy`. `q`: joint positions, rad (m), one series per coordinate. A row that repeats all
/// positions of the previous row is a missed sample; its positions are interpolated first.
pub(crate) fn add_motion(
    log: &Log,
    mut q: Vec<Vec<f64>>,
    signal: &Signal,
    energy: &mut MotionEnergy,
) -> Result<(), Error> {
    let t = &log.t;
    let [motion, effort] = are_seldom(log);
    let positions: Vec<&[f64]> = q.iter().map(Vec::as_slice).collect();
    let seldom = changes(&positions, motion && !signal.own_clock);
    let clock = clock(log, signal, seldom.as_deref())?;
    let is_fresh = |&r: &usize| r == 0 || q.iter().any(|q| q[r] != q[r - 1]);
    if !(0..t.len()).all(|r| is_fresh(&r)) {
        let fresh = seldom.unwrap_or_else(|| (0..t.len()).filter(is_fresh).collect());
        let at = at_places(t, &fresh);
        for q in &mut q {
            *q = interpolate(&at, &at_places(q, &fresh), clock.as_ref().unwrap_or(t));
        }
    } else if let Some(clock) = &clock {
        for q in &mut q {
            *q = interpolate(t, q, clock);
        }
    }
    energy.push(&q, step(clock.as_ref().unwrap_or(t)));
    if effort {
        energy.sample_efforts(log.report.refresh.effort);
    }
    Ok(())
}

/// Mean time between the samples at times t, s.
fn step(t: &[f64]) -> f64 {
    (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64
}

/// The indices of every `decimate`-th sample inside the windows, at least `border` s away from both ends, and not left out.
fn chosen_samples(log: &Log, t: &[f64], border: f64, signal: &Signal, decimate: usize) -> Vec<usize> {
    let (mut first, mut last) = (t[0] + border, t[t.len() - 1] - border);
    for window in log.window.into_iter().chain(signal.window) {
        match window {
            Window::Seconds(a, b) => (first, last) = (first.max(a), last.min(b)),
            Window::Rows(a, b) => {
                let inside = |row: &usize| (a..=b).contains(row);
                match (log.rows.iter().position(inside), log.rows.iter().rposition(inside)) {
                    (Some(a), Some(b)) => (first, last) = (first.max(log.t[a]), last.min(log.t[b])),
                    _ => return Vec::new(),
                }
            }
        }
    }
    let inside = (0..t.len()).filter(|&r| t[r] >= first && t[r] <= last).step_by(decimate);
    inside.filter(|&r| !signal.leaves_out(&log.name, t[r])).collect()
}
