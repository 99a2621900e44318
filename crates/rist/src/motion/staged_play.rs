//! Prepares a motion for playing on a robot: slows it down, adds paths from the robot's pose and back, samples it at the rate
//! of the controller, and proves all limits.
//!
//! s: speed factor, 0 < s <= 1. The slowed motion has the same positions but takes 1/s of the time: velocities are multiplied
//! by s, accelerations by s^2. The paths are straight lines in joint space from rest to rest, x(u) = 10 u^3 - 15 u^4 + 6 u^5
//! (u: share of the duration). Their durations follow from the limits of the slowed motion.

use std::path::Path;

use claims::LeftOutTopic;
use experiments::excitation::artefact::ExcitingMotion;
use experiments::excitation::motion::Motion;
use experiments::motion::point_trajectory::{Interpolation, PointTrajectory};
use experiments::motion::reference_motion::Reference;
use experiments::motion::servo_script::servo_script;
use experiments::motion::trajectory_file::{TrajectoryFormat, trajectory_file};

use crate::describe::model::Model;
use crate::error::Error;
use crate::motion::checking::{Checked, check};
use crate::motion::checking_trajectories::check_points;
use crate::motion::play::{UR_CB3_HZ, UR_E_SERIES_HZ};
use crate::motion::play_advice::{advice, jumps};
use crate::request::{CheckRequest, PlayRequest, PlayTarget, Request};

/// A motion prepared for a controller, with its proofs.
pub struct StagedPlay {
    /// The text of the file for the controller.
    pub text: String,
    /// The header line of a log of this motion, with the columns that an identification needs.
    pub template: String,
    /// The proofs of the path to the first pose, of the motion, and of the path back, each with the name of the segment.
    pub parts: Vec<(&'static str, Checked)>,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

/// Rate of the control loop of libfranka, Hz.
const FRANKA_HZ: f64 = 1000.0;
/// Largest velocity, acceleration and jerk of x(u) with length 1 and duration 1 s: x'(1/2), x''(1/2 - sqrt(3)/6), x'''(0).
const PATH_PEAKS: [f64; 3] = [1.875, 5.773_502_691_896_258, 60.0];
/// Factor on the duration that the limits allow, as a reserve for rounding.
const PATH_DURATION_FACTOR: f64 = 1.001;
/// Shortest duration of a path to or from the motion, s.
const SHORTEST_PATH_S: f64 = 1.0;

/// Writes the file with which a controller plays a motion. `file` is named in messages.
///
/// Fails if a number of the request is out of range, if it names an unknown coordinate, or if the request asks for URScript and
/// the robot does not have six turning joints; fails like [`check`]. The result has the proofs, which may show that a limit is
/// not kept.
pub fn staged_play(
    model: &Model,
    file: &Path,
    motion: &ExcitingMotion,
    request: &PlayRequest,
) -> Result<StagedPlay, Error> {
    request.check()?;
    let names = model.regressor().coordinates();
    let (n, slides) = (names.len(), (0..names.len()).any(|k| model.regressor().is_prismatic(k)));
    if matches!(request.controller, PlayTarget::UrE | PlayTarget::UrCb3) && (n != 6 || slides) {
        return Err(Error::new(format_args!(
            "[controller]: URScript plays robots with six joints that turn; {} has {n} coordinates",
            model.robot.name
        )));
    }
    if let Some((unknown, _)) = request.from.iter().find(|(name, _)| !names.contains(name)) {
        let all = names.join(", ");
        return Err(Error::new(format_args!("[from]: there is no coordinate `{unknown}`; there are {}", all)));
    }
    let slow = slowed(motion, request);
    let asked = CheckRequest { limits: request.limits.clone(), after: request.after.clone() };
    let mut parts = vec![("motion", check(model, file, &slow, &asked)?)];
    let played = slow.motion(&file.display().to_string())?;
    let mut reference = played.reference();
    let ends = [0.0, played.duration()].map(|t| played.at(t).iter().map(|x| x[0]).collect::<Vec<f64>>());
    if request.from.is_empty() && !jumps(&reference, names).is_empty() {
        let back = Segment::new(&ends[1], &ends[0], &slow, request.speed);
        let checked = back.check(model, file, &of_segments(&asked, motion))?;
        // If the path back is not proven, this path is not played, and the advice warns of the jump.
        if checked.faults().is_empty() {
            parts.push(("way back", checked));
            reference = joined(&reference, &back.reference(played.rate));
        }
    } else if !request.from.is_empty() {
        let stands: Vec<f64> = names
            .iter()
            .zip(&ends[0])
            .map(|(name, first)| request.from.iter().find(|(given, _)| given == name).map_or(*first, |(_, q)| *q))
            .collect();
        let there = Segment::new(&stands, &ends[0], &slow, request.speed);
        let back = Segment::new(&ends[1], &stands, &slow, request.speed);
        let asked = of_segments(&asked, motion);
        parts.insert(0, ("way there", there.check(model, file, &asked)?));
        parts.push(("way back", back.check(model, file, &asked)?));
        // The paths to and from the motion are proved here, so the remark that the approach is not checked is removed.
        parts.iter_mut().for_each(|(_, checked)| checked.left_out.retain(|out| out.matter != LeftOutTopic::Approach));
        reference = joined(&joined(&there.reference(played.rate), &reference), &back.reference(played.rate));
    }
    let advice = advice(&played, &reference, &parts, names);
    let text = match request.controller {
        PlayTarget::UrE | PlayTarget::UrCb3 => comments(&advice) + &servo_script(&reference),
        PlayTarget::Franka => trajectory_file(&reference, names, played.rate, TrajectoryFormat::Csv),
        PlayTarget::Ros2 => {
            comments(&advice) + &trajectory_file(&reference, names, played.rate, TrajectoryFormat::RosYaml)
        }
    };
    let notes = notes(request, &reference, &played).into_iter().chain(advice).collect();
    Ok(StagedPlay { text, template: template(names), parts, notes })
}

/// Writes sentences as comments for URScript and YAML. Names of options are replaced by words that the reader of the file
/// understands.
fn comments(sentences: &[String]) -> String {
    let spelled =
        |line: &String| line.replace("[limits=FILE]", "a limits file").replace("[from]", "a pose to start from");
    sentences.iter().map(|line| format!("# {}\n", spelled(line))).collect()
}

/// The request for checking the paths. Margins come from the motion. Limits of acceleration and jerk come from the motion too,
/// if neither the description nor the user gives such limits.
fn of_segments(asked: &CheckRequest, motion: &ExcitingMotion) -> CheckRequest {
    let mut limits = asked.limits.clone().unwrap_or_default();
    if let Some(margins) = &motion.margins {
        let names: Vec<String> = motion.joints.iter().map(|joint| joint.coordinate.clone()).collect();
        limits.margins = margins.errors.held_to(&limits.margins, &names);
    }
    for joint in &motion.joints {
        let (all, own) = (&limits.all, limits.coordinates.entry(joint.coordinate.clone()).or_default());
        if all.slowed.or(own.slowed).is_none() {
            own.acceleration = own.acceleration.or(all.acceleration).or(Some(joint.limits.acceleration));
            own.jerk = own.jerk.or(all.jerk).or(Some(joint.limits.jerk));
        }
    }
    CheckRequest { limits: Some(limits), after: asked.after.clone() }
}

/// Slows the motion down by the request's speed factor, and sets the rate of the controller.
fn slowed(motion: &ExcitingMotion, request: &PlayRequest) -> ExcitingMotion {
    let mut slow = motion.clone();
    slow.period_s /= request.speed;
    slow.blend_s = slow.blend_s.map(|blend| blend / request.speed);
    // Coefficients of sine and cosine are amplitudes of velocity, so these coefficients are scaled. Control points of a spline
    // are positions, so they stay unchanged.
    let amplitudes = slow.joints.iter_mut().flat_map(|joint| joint.cosine.iter_mut().chain(&mut joint.sine));
    amplitudes.for_each(|x| *x *= request.speed);
    slow.rate_hz = match request.controller {
        PlayTarget::UrE => UR_E_SERIES_HZ,
        PlayTarget::UrCb3 => UR_CB3_HZ,
        PlayTarget::Franka => FRANKA_HZ,
        PlayTarget::Ros2 => motion.rate_hz,
    };
    slow
}

/// A straight path in joint space, from rest to rest.
struct Segment<'a> {
    from: &'a [f64],
    to: &'a [f64],
    /// Duration, s.
    duration: f64,
}

impl<'a> Segment<'a> {
    /// The fastest path within the limits of the slowed motion. Each joint needs T_k = (peak_k length / (limit_k
    /// speed^k))^(1/k), with k = 1, 2, 3 for velocity, acceleration, jerk. The largest T_k of all joints is the duration.
    fn new(from: &'a [f64], to: &'a [f64], motion: &ExcitingMotion, speed: f64) -> Segment<'a> {
        let needed = |((from, to), joint): ((&f64, &f64), &experiments::excitation::artefact::MotionJoint)| {
            let (length, limits) = ((to - from).abs(), &joint.limits);
            let powers = [limits.velocity, limits.acceleration, limits.jerk].into_iter().zip(PATH_PEAKS).zip(1..);
            let one = |((limit, peak), k): ((f64, f64), i32)| {
                (peak * length / (limit * speed.powi(k))).powf(1.0 / f64::from(k))
            };
            powers.map(one).fold(0.0, f64::max)
        };
        let longest = from.iter().zip(to).zip(&motion.joints).map(needed).fold(0.0, f64::max);
        // The duration is rounded up to a whole number of samples.
        let samples = (PATH_DURATION_FACTOR * longest.max(SHORTEST_PATH_S) * motion.rate_hz).ceil();
        Segment { from, to, duration: samples / motion.rate_hz }
    }

    fn check(&self, model: &Model, file: &Path, asked: &CheckRequest) -> Result<Checked, Error> {
        let still = vec![vec![0.0; 2]; self.from.len()];
        let positions = self.from.iter().zip(self.to).map(|(from, to)| vec![*from, *to]).collect();
        let names = model.regressor().coordinates().to_vec();
        let points = PointTrajectory::new(names, vec![0.0, self.duration], positions, Some(still.clone()), Some(still));
        let points = points.map_err(|what| Error::new(format_args!("[from]: {what}")))?;
        check_points(model, file, points, Some(Interpolation::Quintic), asked)
    }

    fn reference(&self, rate: f64) -> Reference {
        let count = (self.duration * rate).round() as usize;
        let of = |shape: &dyn Fn(f64) -> f64, offset: bool| -> Vec<Vec<f64>> {
            let one = |(from, to): (&f64, &f64)| {
                let at = |i: usize| shape(i as f64 / count as f64) * (to - from) + if offset { *from } else { 0.0 };
                (0..=count).map(at).collect()
            };
            self.from.iter().zip(self.to).map(one).collect()
        };
        let t = self.duration;
        Reference {
            sample_time: 1.0 / rate,
            q: of(&|u| u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u), true),
            dq: of(&|u| 30.0 * (u * (1.0 - u)).powi(2) / t, false),
            ddq: of(&|u| 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (t * t), false),
            windows: vec![],
        }
    }
}

/// Appends the motion `then` to `first`. The motion `then` starts where `first` ends, so the first sample of `then` is dropped.
fn joined(first: &Reference, then: &Reference) -> Reference {
    let series = |of: fn(&Reference) -> &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let one = |(a, b): (&Vec<f64>, &Vec<f64>)| [a, &b[1..]].concat();
        of(first).iter().zip(of(then)).map(one).collect()
    };
    let before = first.q.first().map_or(0, |q| q.len() - 1);
    let later = then.windows.iter().map(|w| w.start + before..w.end + before);
    Reference {
        sample_time: first.sample_time,
        q: series(|r| &r.q),
        dq: series(|r| &r.dq),
        ddq: series(|r| &r.ddq),
        windows: first.windows.iter().cloned().chain(later).collect(),
    }
}

/// The header line of a log: columns for time, positions, torques.
fn template(names: &[String]) -> String {
    let columns = ["q", "tau"].iter().flat_map(|what| names.iter().map(move |name| format!("{what}_{name}")));
    let cells: Vec<String> = std::iter::once("t".to_string()).chain(columns).collect();
    cells.join(",") + "\n"
}

fn notes(request: &PlayRequest, reference: &Reference, motion: &Motion) -> Vec<String> {
    let mut notes = vec![
        "not tried on a controller: play it in a simulator first, then slowly ([speed=0.3])".to_string(),
        "this is a proof of planning and no safety function: limits and stops of the controller stay what they are"
            .into(),
    ];
    if request.from.is_empty() {
        notes.push(
            "where the robot stands is not given ([from]): the way to the first pose, and from the last set point, is not played"
                .into(),
        );
    }
    if let Some(window) = reference.windows.first() {
        let h = reference.sample_time;
        notes.push(format!(
            "the {} periods to identify from are those from {:.3} s to {:.3} s",
            motion.repetitions,
            window.start as f64 * h,
            window.end as f64 * h
        ));
    }
    notes
}
