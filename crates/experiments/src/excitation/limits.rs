//! The limits of each coordinate: from the description, tightened by the user's limits file, or assumed if neither has the limit.
//!
//! | limit | in the description | assumed value (sliding joints) |
//! |---|---|---|
//! | position | yes, up to 1000 | +-1.5 rad (+-0.25 m) |
//! | velocity | yes, up to 10 000 | 1 rad/s (0.25 m/s) |
//! | acceleration | only in YAML descriptions | reaches the velocity in 0.3 s |
//! | jerk | no | reaches the acceleration in 0.05 s |
//! | effort | yes | unknown: not checked |
//! | power | no | none |
//!
//! A limits file can only tighten the limits of the description. Not here: limits of bodies, such as boxes, floors and
//! self-collision ([`crate::excitation::space_limits`]).

use std::collections::BTreeMap;

use linear_model::yaml;
use robot::{DEGREES_LIMIT_RAD, Limits};
use serde::{Deserialize, Serialize};

use crate::excitation::error_margins::ErrorMargins;
pub use crate::excitation::limit_kind::LimitKind;
use crate::excitation::space_limits::SpaceLimits;

/// The limits of the motion of one coordinate, in rad (m if the joint is prismatic), s, N m (N) and W.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoordinateLimits {
    /// Smallest and largest position, rad (m).
    pub position: (f64, f64),
    /// Greatest velocity, rad/s (m/s).
    pub velocity: f64,
    /// Greatest acceleration, rad/s^2 (m/s^2).
    pub acceleration: f64,
    /// Greatest jerk, rad/s^3 (m/s^3).
    pub jerk: f64,
    /// Greatest effort, N m (N). None: unknown, not checked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
    /// Greatest power of the drive, driving and braking, W. None: not limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<f64>,
    /// Constant position of a locked coordinate, rad (m). `None`: the coordinate moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub locked: Option<f64>,
}

impl CoordinateLimits {
    /// Least and greatest allowed value of a quantity of this coordinate. `None` if the quantity is not limited.
    pub fn bounds(&self, kind: LimitKind) -> Option<(f64, f64)> {
        let symmetric = |x: f64| Some((-x, x));
        match kind {
            LimitKind::Position => Some(self.position),
            LimitKind::Velocity => symmetric(self.velocity),
            LimitKind::Acceleration => symmetric(self.acceleration),
            LimitKind::Jerk => symmetric(self.jerk),
            LimitKind::Effort => self.effort.and_then(symmetric),
            LimitKind::Power => self.power.and_then(symmetric),
            // Distances are limits of links, not of a coordinate.
            LimitKind::Distance | LimitKind::Region => None,
        }
    }

    /// The greatest velocity that the joint can reach within its position range and acceleration limit, rad/s (m/s). The result
    /// is at most the velocity limit, which may be ten times the reachable velocity for a gripper. The result is at least a
    /// twentieth of the velocity limit, because a slower joint identifies nothing.
    pub fn reachable_velocity(&self) -> f64 {
        let (low, high) = self.position;
        (self.acceleration * (high - low)).sqrt().clamp(LEAST_VELOCITY_SHARE * self.velocity, self.velocity)
    }

    /// The reason why no motion can keep these limits; `None` if a motion can.
    pub fn fault(&self) -> Option<String> {
        let (low, high) = self.position;
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Some(format!("the limits of position are empty: from {low} to {high}"));
        }
        let positive = [
            (LimitKind::Velocity, Some(self.velocity)),
            (LimitKind::Acceleration, Some(self.acceleration)),
            (LimitKind::Jerk, Some(self.jerk)),
            (LimitKind::Effort, self.effort),
            (LimitKind::Power, self.power),
        ];
        let mut given = positive.into_iter().filter_map(|(kind, x)| Some((kind, x?)));
        let is_slow = |kind, x: f64| kind == LimitKind::Velocity && x > 0.0 && x < MIN_VELOCITY_LIMIT;
        if let Some((kind, x)) = given.find(|(kind, x)| !(x.is_finite() && *x > 0.0) || is_slow(*kind, *x)) {
            let expected = if is_slow(kind, x) { "at least 1e-6" } else { "a positive number" };
            return Some(format!(
                "the limit of {kind} allows no motion: {x}; expected is {expected} (locked: holds still)"
            ));
        }
        let locked = self.locked.filter(|q| !(*q >= low && *q <= high));
        locked.map(|q| format!("locked at {q}, outside its limits of position, {low} to {high}"))
    }
}

/// Limits that a user's limits file requests for one coordinate, or for all coordinates. `None`: not requested.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AskedLimits {
    /// Smallest and largest position, rad (m).
    pub position: Option<(f64, f64)>,
    /// Greatest velocity, rad/s (m/s).
    pub velocity: Option<f64>,
    /// Greatest acceleration, rad/s^2 (m/s^2).
    pub acceleration: Option<f64>,
    /// Greatest jerk, rad/s^3 (m/s^3).
    pub jerk: Option<f64>,
    /// Greatest effort, N m (N).
    pub effort: Option<f64>,
    /// Greatest power of the drive, W.
    pub power: Option<f64>,
    /// Position at which the coordinate is to be locked, rad (m).
    pub locked: Option<f64>,
    /// Slow-down factor s, 0 < s <= 1: multiplies the limits of velocity by s, of acceleration by s^2, of jerk by s^3.
    pub slowed: Option<f64>,
}

/// Smallest accepted limit of velocity, rad/s (m/s). With a smaller limit, a turn takes 70 days and a search does not end.
const MIN_VELOCITY_LIMIT: f64 = 1e-6;

/// A position limit beyond this value (rad or m) counts as no limit: some files use 1e16 for a missing limit.
pub const FARTHEST_POSITION: f64 = 1e3;
/// A velocity limit above this value (rad/s or m/s) counts as no limit, because products with such a velocity lose the gravity
/// terms to rounding.
pub const FASTEST_VELOCITY: f64 = 1e4;
/// Half the position range that a locked joint gets, rad (m); it covers rounding errors.
const LOCKED_HALF_RANGE: f64 = 1e-9;
/// The reachable velocity of a joint is assumed to be at least this share of its velocity limit.
const LEAST_VELOCITY_SHARE: f64 = 0.05;
/// The assumed acceleration limit accelerates a joint from rest to its velocity limit in this time, s.
const ACCELERATING_TIME_S: f64 = 0.3;
/// The assumed jerk limit accelerates a joint from zero acceleration to its acceleration limit in this time, s.
const JERK_TIME_S: f64 = 0.05;

/// Whether a joint is continuous: a lower or upper position limit is beyond [`FARTHEST_POSITION`].
fn is_unlimited((low, high): (f64, f64)) -> bool {
    low < -FARTHEST_POSITION || high > FARTHEST_POSITION
}

impl AskedLimits {
    /// Locks the joint if its lower and upper position limit are equal.
    fn with_still_joint(self) -> AskedLimits {
        match self.position {
            Some((low, high)) if low == high => {
                let position = Some((low - LOCKED_HALF_RANGE, low + LOCKED_HALF_RANGE));
                AskedLimits { position, locked: self.locked.or(Some(low)), ..self }
            }
            _ => self,
        }
    }

    /// The usable limits in a robot's description. Position limits beyond [`FARTHEST_POSITION`] are ignored. A joint with two
    /// equal position limits is locked there.
    pub fn of_description(described: &Limits) -> AskedLimits {
        let positive = |x: Option<f64>| x.filter(|x| x.is_finite() && *x > 0.0);
        let found = AskedLimits {
            position: described.position.filter(|limits| !is_unlimited(*limits)),
            velocity: positive(described.velocity).filter(|velocity| *velocity <= FASTEST_VELOCITY),
            acceleration: positive(described.acceleration),
            effort: positive(described.effort),
            ..AskedLimits::default()
        };
        found.with_still_joint()
    }

    /// Least and greatest requested value of a quantity. `None` if no limit is requested.
    pub fn bounds(&self, kind: LimitKind) -> Option<(f64, f64)> {
        let size = match kind {
            LimitKind::Position => return self.position,
            LimitKind::Velocity => self.velocity,
            LimitKind::Acceleration => self.acceleration,
            LimitKind::Jerk => self.jerk,
            LimitKind::Effort => self.effort,
            LimitKind::Power => self.power,
            // Distances are limits of links, not of a coordinate.
            LimitKind::Distance | LimitKind::Region => None,
        };
        size.map(|x| (-x, x))
    }
}

/// The contents of the user's limits file (option `--limits`).
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LimitsFile {
    /// Limits for every coordinate. Limits of a coordinate in `coordinates` take precedence.
    pub all: AskedLimits,
    /// Limits for single coordinates, by name of the coordinate.
    pub coordinates: BTreeMap<String, AskedLimits>,
    /// Limits of the bodies in space: floor, walls, boxes and distances. `None`: the defaults.
    pub space: Option<SpaceLimits>,
    /// Error margins: bounds of the errors between the robot and its description or planned motion.
    pub margins: ErrorMargins,
}

impl LimitsFile {
    /// Reads the limits file from its text. `file`: name of the file, for error messages.
    pub fn from_yaml(file: &str, text: &str) -> Result<LimitsFile, logs::Error> {
        let expected = "expected `coordinates: {NAME: {position: [LOW, HIGH], velocity, acceleration, jerk, effort, \
                        power, locked, slowed}}`, `all: {..}` of the same, `space: {floor, walls: [{point, normal, links}], \
                        boxes: [{low, high, links}], distance, own_links, accept: [[LINK, LINK, REASON]]}`, or `margins: \
                        {encoder_zero, tracking, calibration, mesh, payload}`";
        yaml::read(text).map_err(|e| logs::Error::at(file, 0, format!("these are no limits: {e}; {expected}")))
    }

    /// Fails if the limits file names an unknown coordinate or has a margin out of range. `names`: all coordinates of the robot.
    pub fn check_names(&self, names: &[String]) -> Result<(), String> {
        if let Some(unknown) = self.coordinates.keys().find(|name| !names.contains(name)) {
            return Err(format!("limits: there is no coordinate `{unknown}`; there are {}", names.join(", ")));
        }
        self.margins.fault(names).map_or(Ok(()), Err)
    }

    /// The limits that the file requests for this coordinate alone, without the limits for all coordinates.
    pub fn of(&self, coordinate: &str) -> AskedLimits {
        self.coordinates.get(coordinate).cloned().unwrap_or_default()
    }
}

/// The limits of all coordinates for the search of a motion, and one sentence for each kind of limit that had to be assumed.
///
/// Fails if the limits file names an unknown coordinate or is looser than the description, or if no position range remains.
pub fn motion_limits(
    names: &[String],
    is_prismatic: impl Fn(usize) -> bool,
    described: &[Limits],
    file: &LimitsFile,
) -> Result<(Vec<CoordinateLimits>, Vec<String>), String> {
    if let Some(fault) = file.space.as_ref().and_then(SpaceLimits::fault) {
        return Err(fault);
    }
    file.check_names(names)?;
    let mut assumed: Vec<(String, Vec<&str>)> = Vec::new();
    let mut limits = Vec::new();
    for (k, (name, described)) in names.iter().zip(described).enumerate() {
        let own = file.of(name);
        let mut assume = |text: String| match assumed.iter_mut().find(|a| a.0 == text) {
            Some(a) => a.1.push(name),
            None => assumed.push((text, vec![name])),
        };
        let found = one(is_prismatic(k), described, &own, &file.all, &mut assume);
        let found = found.map_err(|what| format!("coordinate {name}: {what}"))?;
        limits.push(found);
    }
    let sentence = |(text, names): (String, Vec<&str>)| format!("{}: {text}", names.join(", "));
    Ok((limits, assumed.into_iter().map(sentence).collect()))
}

/// Assumed limits of a coordinate without limits: greatest distance from zero (rad or m) and greatest velocity (rad/s or m/s).
pub(crate) fn assumed(is_prismatic: bool) -> (f64, f64) {
    if is_prismatic { (0.25, 0.25) } else { (1.5, 1.0) }
}

/// The limit of the user's limits file (`asked`), or else of the description; `None` if both have none.
///
/// Fails if the limit of the limits file is looser.
fn chosen(kind: LimitKind, described: Option<f64>, asked: Option<f64>) -> Result<Option<f64>, String> {
    match (described, asked) {
        (Some(d), Some(a)) if a > d => {
            Err(format!("{kind} {a} of the limits file is above {d} of the description, which a file can only tighten"))
        }
        (described, asked) => Ok(asked.or(described)),
    }
}

/// Combines the limits of one coordinate: from the limits file (`own`, or `all` where `own` has none) and from the description.
/// Slows them down if the file requests it. No limit is assumed.
pub fn given(described: &Limits, own: &AskedLimits, all: &AskedLimits) -> Result<AskedLimits, String> {
    let described = AskedLimits::of_description(described);
    let asked_position = own.position.or(all.position);
    let still = AskedLimits { position: asked_position, ..AskedLimits::default() }.with_still_joint();
    // The limits file may narrow the position range of the description, not extend it.
    let position = match (described.position, still.position) {
        (Some((low, high)), Some((a, b))) if a < low - LOCKED_HALF_RANGE || b > high + LOCKED_HALF_RANGE => {
            return Err(format!(
                "position {a} to {b} of the limits file exceeds {low} to {high} of the description, which a file can \
                 only tighten"
            ));
        }
        (described, asked) => asked.or(described),
    };
    // Slowing a motion down by the factor s multiplies the velocity by s, the acceleration by s^2, the jerk by s^3.
    let slowed = own.slowed.or(all.slowed);
    let factor = slowed.unwrap_or(1.0);
    if !(factor > 0.0 && factor <= 1.0) {
        return Err(format!("slowed is a factor above 0 and at most 1, not {factor}"));
    }
    let scaled = |x: Option<f64>, power: i32| x.map(|x| x * factor.powi(power));
    let velocity = chosen(LimitKind::Velocity, described.velocity, own.velocity.or(all.velocity))?;
    let asked = own.acceleration.or(all.acceleration);
    let acceleration = chosen(LimitKind::Acceleration, described.acceleration, asked)?;
    Ok(AskedLimits {
        position,
        velocity: scaled(velocity, 1),
        acceleration: scaled(acceleration, 2),
        jerk: scaled(own.jerk.or(all.jerk), 3),
        effort: chosen(LimitKind::Effort, described.effort, own.effort.or(all.effort))?,
        power: own.power.or(all.power),
        locked: own.locked.or(all.locked).or(still.locked).or(described.locked),
        slowed,
    })
}

fn one(
    is_prismatic: bool,
    described: &Limits,
    own: &AskedLimits,
    all: &AskedLimits,
    assume: &mut dyn FnMut(String),
) -> Result<CoordinateLimits, String> {
    if let Some((low, high)) = described.position.filter(|(low, high)| low.is_nan() || high.is_nan() || low > high) {
        return Err(format!("the description limits its position from {low} to {high}: the first must be the smaller"));
    }
    let given = given(described, own, all)?;
    let factor = given.slowed.unwrap_or(1.0);
    let endless = described.velocity.filter(|velocity| *velocity > FASTEST_VELOCITY);
    let mut or_assumed = |kind: LimitKind, given: Option<f64>, otherwise: f64, power: i32| {
        given.unwrap_or_else(|| {
            let size = if otherwise < 1e-3 { format!("{otherwise:.3e}") } else { format!("{otherwise:.4}") };
            let unit = kind.unit(is_prismatic);
            assume(match endless.filter(|_| kind == LimitKind::Velocity) {
                Some(velocity) => format!("a velocity of {velocity:e} {unit} is no limit, {size} {unit} assumed"),
                None => format!("no limit of {kind} given, {size} {unit} assumed"),
            });
            otherwise * factor.powi(power)
        })
    };
    let (far, fast) = assumed(is_prismatic);
    // An assumed limit is computed from limits before slowing down, and then slowed down itself.
    let velocity = or_assumed(LimitKind::Velocity, given.velocity, fast, 1);
    let quick = velocity / factor / ACCELERATING_TIME_S;
    let acceleration = or_assumed(LimitKind::Acceleration, given.acceleration, quick, 2);
    let jerk = or_assumed(LimitKind::Jerk, given.jerk, acceleration / factor.powi(2) / JERK_TIME_S, 3);
    let position = given.position.unwrap_or_else(|| {
        let unit = LimitKind::Position.unit(is_prismatic);
        assume(match described.position {
            Some((low, high)) => {
                format!("positions from {low:e} to {high:e} {unit} are no limits, +-{far} {unit} assumed")
            }
            None => format!("no limits of position given, +-{far} {unit} assumed"),
        });
        (-far, far)
    });
    if !is_prismatic && position.0.abs().max(position.1.abs()) > DEGREES_LIMIT_RAD {
        assume(format!(
            "positions from {} to {} rad are more than two turns: are degrees meant?",
            position.0, position.1
        ));
    }
    let AskedLimits { effort, power, locked, .. } = given;
    let limits = CoordinateLimits { position, velocity, acceleration, jerk, effort, power, locked };
    match limits.fault() {
        None => Ok(limits),
        Some(fault) => Err(fault),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described() -> Limits {
        Limits { position: Some((-2.0, 2.0)), velocity: Some(3.0), acceleration: None, effort: Some(10.0) }
    }

    fn found(text: &str) -> Result<(Vec<CoordinateLimits>, Vec<String>), String> {
        let file = LimitsFile::from_yaml("limits.yaml", text).map_err(|e| e.to_string())?;
        motion_limits(&["q1".into(), "q2".into()], |k| k == 1, &[described(), Limits::default()], &file)
    }

    #[test]
    fn description_file_assumption() {
        let (limits, notes) =
            found("coordinates: {q1: {velocity: 1.5, slowed: 0.5}, q2: {locked: 0.1, effort: 7}}").unwrap();
        assert_eq!((limits[0].position, limits[0].velocity, limits[0].effort), ((-2.0, 2.0), 0.75, Some(10.0)));
        // The acceleration is 1.5 / 0.3 = 5, times 0.5^2; the jerk is 5 / 0.05 = 100, times 0.5^3.
        assert!((limits[0].acceleration - 1.25).abs() < 1e-12 && (limits[0].jerk - 12.5).abs() < 1e-12);
        assert_eq!((limits[1].position, limits[1].locked, limits[1].effort), ((-0.25, 0.25), Some(0.1), Some(7.0)));
        assert!(notes.iter().any(|n| n == "q2: no limits of position given, +-0.25 m assumed"), "{notes:?}");
    }

    #[test]
    fn odd_positions_of_a_description() {
        let of = |position: (f64, f64)| {
            let described = Limits { position: Some(position), ..described() };
            motion_limits(&["q1".into()], |_| false, &[described], &LimitsFile::default())
        };
        for position in [(-1e16, 1e16), (f64::NEG_INFINITY, f64::INFINITY), (0.0, 1001.0)] {
            let (limits, notes) = of(position).unwrap();
            assert_eq!((limits[0].position, limits[0].locked), ((-1.5, 1.5), None));
            assert!(notes.iter().any(|n| n.contains(" are no limits, +-1.5 rad assumed")), "{notes:?}");
        }
        let (limits, notes) = of((-1000.0, 1000.0)).unwrap();
        assert!(limits[0].position == (-1000.0, 1000.0) && notes.iter().all(|n| !n.contains("no limits")), "{notes:?}");
        let (limits, _) = of((0.5, 0.5)).unwrap();
        assert_eq!(limits[0].locked, Some(0.5));
        assert!(limits[0].position.0 < 0.5 && limits[0].position.1 > 0.5 && limits[0].fault().is_none());
        for position in [(1.0, -1.0), (f64::NAN, 1.0), (0.0, f64::NAN)] {
            let refused = of(position).unwrap_err();
            assert!(refused.starts_with("coordinate q1: the description limits its position from "), "{refused}");
        }
        let (limits, _) = found("coordinates: {q2: {position: [0.1, 0.1]}}").unwrap();
        assert_eq!(limits[1].locked, Some(0.1));
    }

    #[test]
    fn what_leaves_no_room_is_refused_with_its_coordinate() {
        for (text, words) in [
            ("coordinates: {q9: {velocity: 1}}", "no coordinate `q9`; there are q1, q2"),
            ("coordinates: {q1: {velocity: 4}}", "coordinate q1: velocity 4 of the limits file is above 3"),
            ("coordinates: {q1: {position: [-3, 1]}}", "exceeds -2 to 2"),
            ("coordinates: {q2: {position: [0.2, 0.1]}}", "coordinate q2: the limits of position are empty"),
            ("all: {acceleration: 0}", "the limit of acceleration allows no motion: 0"),
            ("all: {velocity: 1e-9}", "the limit of velocity allows no motion: 0.000000001; expected is at least 1e-6"),
            ("coordinates: {q1: {power: -5}}", "coordinate q1: the limit of power allows no motion: -5"),
            ("coordinates: {q1: {locked: 5}}", "locked at 5, outside"),
            ("coordinates: {q1: {slowed: 2}}", "slowed is a factor"),
            ("coordinates: {q1: {speed: 2}}", "these are no limits"),
            ("space: {distance: -0.1}", "space: distance is -0.1; expected are metres"),
            ("space: {walls: [{point: [0, 0, 0]}]}", "these are no limits"),
        ] {
            let error = found(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
