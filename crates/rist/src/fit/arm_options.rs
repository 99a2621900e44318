//! Completes the options of an identification or a log check by the column names, units, zeros and gains of a hobby arm. `rist
//! columns` proposes the same values, from the data of the servos. If the user gives a value, the value of the user is kept.
//!
//! A hobby arm is a small arm with servos, for example SO-101; its data are in `hobby_arms.yaml`.

use std::path::Path;

use identification::estimate::options::Options;
use robot::Robot;

use crate::error::Error;
use crate::fit::column_proposal::propose_columns;
use crate::request::{DoctorRequest, Request, SamplesRequest};

/// The options and gains for a log that follow from the data of an arm.
struct OfArm {
    options: Options,
    /// The gains as texts of a request, `joint=1.78+-0.36`.
    gains: Vec<String>,
    /// The lines of the proposal, with their reasons.
    said: String,
}

/// Completes options by the proposal for a log of the arm `name`.
///
/// Fails if the log cannot be read, if the arm is not known or does not fit the robot, or if the proposal is not complete.
fn of_arm(robot: &Robot, log: Option<&Path>, name: &str, options: Options) -> Result<OfArm, Error> {
    let log = log.ok_or_else(|| Error::new(format_args!("[arm={name}] needs a log that is a file")))?;
    let proposed = propose_columns(robot, log, options.columns.rate, Some(name))?;
    if !proposed.is_whole() {
        let missing = proposed.proposal.missing.join("; ");
        return Err(Error::new(format_args!("[arm={name}]: {}: {missing}", log.display())));
    }
    let text = proposed.to_string();
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    let of_arm = match lines.is_empty() {
        true => Options::default(),
        false => Options::parse("arm", &lines.join("\n"))?,
    };
    let gains = proposed.arm.gains.iter().flat_map(|gains| gains.value.split(',').map(String::from)).collect();
    let gain = proposed.arm.gains.iter().map(|gains| format!("# [gain={}] ({})\n", gains.value, gains.reason));
    let said = format!("# of the arm {name}\n{}\n{}", lines.join("\n"), gain.collect::<String>());
    Ok(OfArm { options: filled(options, of_arm), gains, said })
}

/// The options `own`, completed by the options of the arm for values that `own` does not give.
fn filled(mut own: Options, of: Options) -> Options {
    fn fill<T>(own: &mut Option<T>, of: Option<T>) {
        if own.is_none() {
            *own = of;
        }
    }
    let columns = &mut own.columns;
    let has_effort = columns.torque.is_some() || columns.current.is_some() || columns.goal.is_some();
    fill(&mut columns.time, of.columns.time);
    fill(&mut columns.rate, of.columns.rate);
    fill(&mut columns.episode, of.columns.episode);
    fill(&mut columns.position, of.columns.position);
    fill(&mut columns.velocity, of.columns.velocity);
    fill(&mut columns.acceleration, of.columns.acceleration);
    // One effort signal is enough. If the user names torques, currents or goals, the arm adds no other effort.
    if !has_effort {
        fill(&mut columns.torque, of.columns.torque);
        fill(&mut columns.current, of.columns.current);
        fill(&mut columns.goal, of.columns.goal);
    }
    let units = &mut columns.units;
    fill(&mut units.time, of.columns.units.time);
    fill(&mut units.position, of.columns.units.position);
    fill(&mut units.velocity, of.columns.units.velocity);
    fill(&mut units.torque, of.columns.units.torque);
    fill(&mut units.current, of.columns.units.current);
    fill(&mut units.goal, of.columns.units.goal);
    fill(&mut own.transmission.ratios, of.transmission.ratios);
    fill(&mut own.transmission.offsets, of.transmission.offsets);
    fill(&mut own.transmission.scales, of.transmission.scales);
    own
}

impl SamplesRequest {
    /// The request, completed by the options and gains of the arm that the request names. Also returns the printed lines with
    /// the values that are used for the arm. `log`: the path of the first log.
    ///
    /// Fails if the arm is not known, or does not fit the robot or the log.
    pub fn with_arm(mut self, robot: &Robot, log: Option<&Path>) -> Result<(SamplesRequest, String), Error> {
        let Some(arm) = self.arm.take() else { return Ok((self, String::new())) };
        let mut options = self.rows.signals.options.take().unwrap_or_default();
        options.columns.rate = self.rows.signals.rate.or(options.columns.rate);
        let found = of_arm(robot, log, &arm, options)?;
        self.rows.signals.options = Some(found.options);
        if self.gain.is_empty() {
            self.set_texts("gain", &found.gains)?;
        }
        Ok((self, found.said))
    }
}

impl DoctorRequest {
    /// The request, completed by the options and gains of the arm that the request names. Also returns the printed lines with
    /// the values that are used for the arm. `log`: the path of the first log.
    ///
    /// Fails if the arm is not known, or does not fit the robot or the log.
    pub fn with_arm(mut self, robot: &Robot, log: Option<&Path>) -> Result<(DoctorRequest, String), Error> {
        let Some(arm) = self.arm.take() else { return Ok((self, String::new())) };
        let mut options = self.options.take().unwrap_or_default();
        options.columns.rate = self.rate.or(options.columns.rate);
        let found = of_arm(robot, log, &arm, options)?;
        self.options = Some(found.options);
        if self.gain.is_empty() {
            let without_deviation = |gain: &String| gain.split("+-").next().unwrap_or_default().to_string();
            self.set_texts("gain", &found.gains.iter().map(without_deviation).collect::<Vec<_>>())?;
        }
        Ok((self, found.said))
    }
}
