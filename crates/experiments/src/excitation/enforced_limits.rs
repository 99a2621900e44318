//! The limits against which `rist check` tests a motion, with the source of each limit.
//!
//! The file of a motion contains the limits of its search, but a user can edit it and loosen them. Therefore the limits of the
//! description and of the user's limits file always apply. If neither has a limit, it comes from the motion's file alone, and the
//! report says so.

use std::fmt;

use robot::Limits;
use serde::Serialize;

use crate::excitation::limits::{AskedLimits, CoordinateLimits, LimitKind};

/// The file from which a limit comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitOrigin {
    /// The description of the robot.
    Description,
    /// The limits file of the user.
    LimitsFile,
    /// The motion's file. The description or the limits file also has this limit, but a looser one.
    MotionTighter,
    /// The motion's file. No other file has this limit.
    MotionAlone,
}

impl fmt::Display for LimitOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            LimitOrigin::Description => "the description",
            LimitOrigin::LimitsFile => "the limits file",
            LimitOrigin::MotionTighter => "the motion's file, tighter than the others",
            LimitOrigin::MotionAlone => "the motion's file alone",
        })
    }
}

/// A limit of one coordinate that a motion must keep, with its source.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EnforcedLimit {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Kind of the limit.
    pub limit: LimitKind,
    /// Least and greatest allowed value, in the unit of the limit.
    pub bounds: (f64, f64),
    /// The file from which the limit comes.
    pub origin: LimitOrigin,
}

/// The tightest of three limits of one coordinate: of the motion's file (`made_with`), of the description, and of the limits
/// file; with their sources.
///
/// `asked`: the combined limits of limits file and description ([`crate::excitation::limits::given`]); `None`: there is no limits
/// file. Fails if no position range remains.
pub fn enforced(
    coordinate: &str,
    made_with: &CoordinateLimits,
    described: &Limits,
    asked: Option<&AskedLimits>,
) -> Result<(CoordinateLimits, Vec<EnforcedLimit>), String> {
    let described = AskedLimits::of_description(described);
    let nothing = AskedLimits::default();
    let asked = asked.unwrap_or(&nothing);
    let others = [(LimitOrigin::Description, &described), (LimitOrigin::LimitsFile, asked)];
    // The tightest limit of the three sources. Effort and power may have no limit in any source.
    let least = |own: f64, of: &dyn Fn(&AskedLimits) -> Option<f64>| {
        others.iter().filter_map(|(_, other)| of(other)).fold(own, f64::min)
    };
    let optional = |own: Option<f64>, of: &dyn Fn(&AskedLimits) -> Option<f64>| {
        let all = own.into_iter().chain(others.iter().filter_map(|(_, other)| of(other)));
        all.reduce(f64::min)
    };
    let positions = others.iter().filter_map(|(_, other)| other.position);
    let limits = CoordinateLimits {
        position: positions.fold(made_with.position, |(a, b), (low, high)| (a.max(low), b.min(high))),
        velocity: least(made_with.velocity, &|l| l.velocity),
        acceleration: least(made_with.acceleration, &|l| l.acceleration),
        jerk: least(made_with.jerk, &|l| l.jerk),
        effort: optional(made_with.effort, &|l| l.effort),
        power: optional(made_with.power, &|l| l.power),
        locked: asked.locked.or(described.locked).or(made_with.locked),
    };
    if let Some(fault) = limits.fault() {
        return Err(fault);
    }
    // If sources have the same limit, the description or the limits file is named instead of the motion's file.
    let origin = |kind: LimitKind, bounds: (f64, f64)| {
        let given = others.iter().filter_map(|(origin, other)| Some((*origin, other.bounds(kind)?)));
        let (same, other): (Vec<_>, Vec<_>) = given.partition(|(_, theirs)| *theirs == bounds);
        match (same.first(), other.is_empty()) {
            (Some((origin, _)), _) => *origin,
            (None, false) => LimitOrigin::MotionTighter,
            (None, true) => LimitOrigin::MotionAlone,
        }
    };
    let row = |kind: LimitKind| {
        let bounds = limits.bounds(kind)?;
        Some(EnforcedLimit { coordinate: coordinate.into(), limit: kind, bounds, origin: origin(kind, bounds) })
    };
    let rows = LimitKind::OF_A_COORDINATE.into_iter().filter_map(row).collect();
    Ok((limits, rows))
}

/// The sources of the limits as text, one line per kind of limit. Coordinates are named if their sources differ.
pub fn origins_text(rows: &[EnforcedLimit]) -> String {
    let mut text = String::new();
    for kind in LimitKind::OF_A_COORDINATE {
        let own: Vec<&EnforcedLimit> = rows.iter().filter(|row| row.limit == kind).collect();
        let mut origins: Vec<(LimitOrigin, Vec<&str>)> = Vec::new();
        for row in &own {
            match origins.iter_mut().find(|(origin, _)| *origin == row.origin) {
                Some((_, names)) => names.push(&row.coordinate),
                None => origins.push((row.origin, vec![&row.coordinate])),
            }
        }
        let named = |(origin, names): &(LimitOrigin, Vec<&str>)| match names.len() == own.len() {
            true => origin.to_string(),
            false => format!("{origin} ({})", names.join(", ")),
        };
        if !own.is_empty() {
            let all: Vec<String> = origins.iter().map(named).collect();
            text.push_str(&format!("{kind:<13} as in {}\n", all.join("; ")));
        }
    }
    text
}

/// The kinds of limits that come from the motion's file alone, in words, such as `velocity`.
pub fn kinds_of_motion_alone(rows: &[EnforcedLimit]) -> Vec<String> {
    let is_own = |kind: &LimitKind| rows.iter().any(|row| row.limit == *kind && row.origin == LimitOrigin::MotionAlone);
    LimitKind::OF_A_COORDINATE.into_iter().filter(is_own).map(|kind| kind.to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::search::tests::limits;

    fn described() -> Limits {
        Limits { position: Some((-2.0, 2.0)), velocity: Some(3.0), acceleration: None, effort: Some(10.0) }
    }

    fn made_with() -> CoordinateLimits {
        CoordinateLimits { effort: Some(10.0), ..limits((-2.0, 2.0), [3.0, 10.0, 200.0]) }
    }

    #[test]
    fn a_motion_cannot_loosen_the_description() {
        let loose = CoordinateLimits { position: (-9.0, 1.0), velocity: 9.0, effort: None, ..made_with() };
        let (held, _) = enforced("q1", &loose, &described(), None).unwrap();
        assert_eq!((held.position, held.velocity, held.effort), ((-2.0, 1.0), 3.0, Some(10.0)));
        let away = CoordinateLimits { position: (3.0, 9.0), ..loose };
        assert!(enforced("q1", &away, &described(), None).is_err());
    }

    /// Of three limits, the tightest one applies and is reported. If the limit of the description is equally tight, the
    /// description is named as the source.
    #[test]
    fn every_limit_is_told_with_its_place() {
        let origins =
            |made_with: &CoordinateLimits, asked: Option<&AskedLimits>| -> (CoordinateLimits, Vec<LimitOrigin>) {
                let (limits, rows) = enforced("q1", made_with, &described(), asked).unwrap();
                (limits, rows.iter().map(|row| row.origin).collect())
            };
        use LimitOrigin::*;
        let (_, found) = origins(&made_with(), None);
        assert_eq!(found, [Description, Description, MotionAlone, MotionAlone, Description]);
        let slower = CoordinateLimits { velocity: 1.0, power: Some(5.0), ..made_with() };
        let (_, found) = origins(&slower, None);
        assert_eq!(found, [Description, MotionTighter, MotionAlone, MotionAlone, Description, MotionAlone]);
        let asked = AskedLimits { velocity: Some(0.5), jerk: Some(50.0), power: Some(9.0), ..AskedLimits::default() };
        let (limits, found) = origins(&slower, Some(&asked));
        assert_eq!((limits.velocity, limits.jerk, limits.power), (0.5, 50.0, Some(5.0)));
        assert_eq!(found, [Description, LimitsFile, MotionAlone, LimitsFile, Description, MotionTighter]);
        let (_, rows) = enforced("q1", &slower, &described(), Some(&asked)).unwrap();
        assert!(origins_text(&rows).contains("jerk          as in the limits file\n"), "{}", origins_text(&rows));
        assert_eq!(kinds_of_motion_alone(&rows), ["acceleration"]);
        let (_, rows) = enforced("q1", &made_with(), &described(), None).unwrap();
        assert_eq!(kinds_of_motion_alone(&rows), ["acceleration", "jerk"]);
    }
}
