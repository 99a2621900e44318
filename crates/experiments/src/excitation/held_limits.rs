//! The limits that a checked motion is held to, and where each of them stands.
//!
//! The file of a motion has the limits that it was made with, and anybody can loosen them there. The limits of the
//! description and of a limits file of the user hold whatever the motion's file says. A limit that neither of them has
//! stands in the motion's file alone, and whoever reads a proof must know that.

use std::fmt;

use robot::Limits;
use serde::Serialize;

use crate::excitation::limits::{AskedLimits, CoordinateLimits, LimitKind};

/// Where a limit stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// In the description.
    Description,
    /// In the limits file of the user.
    LimitsFile,
    /// In the motion's file, which is tighter than the others.
    MotionTighter,
    /// In the motion's file alone.
    MotionAlone,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Origin::Description => "the description",
            Origin::LimitsFile => "the limits file",
            Origin::MotionTighter => "the motion's file, tighter than the others",
            Origin::MotionAlone => "the motion's file alone",
        })
    }
}

/// A limit of a coordinate with its origin.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldLimit {
    /// Name of the coordinate.
    pub coordinate: String,
    /// Which limit.
    pub limit: LimitKind,
    /// Least and greatest value.
    pub bounds: (f64, f64),
    /// Where it stands.
    pub origin: Origin,
}

/// The tightest of the limits that a motion was made with, of the description, and of a limits file; with their origins.
///
/// `asked`: what file and description give ([`crate::excitation::limits::given`]), where there is a file.
/// Fails where they leave no room.
pub fn held(
    coordinate: &str,
    made_with: &CoordinateLimits,
    described: &Limits,
    asked: Option<&AskedLimits>,
) -> Result<(CoordinateLimits, Vec<HeldLimit>), String> {
    let described = AskedLimits::of_description(described);
    let nothing = AskedLimits::default();
    let asked = asked.unwrap_or(&nothing);
    let others = [(Origin::Description, &described), (Origin::LimitsFile, asked)];
    // The tightest limit of the three; effort and power may have none.
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
    // Where a limit stands: the user's description and file count before the motion's own file.
    let origin = |kind: LimitKind, bounds: (f64, f64)| {
        let given = others.iter().filter_map(|(origin, other)| Some((*origin, other.bounds(kind)?)));
        let (same, other): (Vec<_>, Vec<_>) = given.partition(|(_, theirs)| *theirs == bounds);
        match (same.first(), other.is_empty()) {
            (Some((origin, _)), _) => *origin,
            (None, false) => Origin::MotionTighter,
            (None, true) => Origin::MotionAlone,
        }
    };
    let row = |kind: LimitKind| {
        let bounds = limits.bounds(kind)?;
        Some(HeldLimit { coordinate: coordinate.into(), limit: kind, bounds, origin: origin(kind, bounds) })
    };
    let rows = LimitKind::OF_A_COORDINATE.into_iter().filter_map(row).collect();
    Ok((limits, rows))
}

/// Where the limits stand, kind by kind, with the coordinates where that differs.
pub fn origins_text(rows: &[HeldLimit]) -> String {
    let mut text = String::new();
    for kind in LimitKind::OF_A_COORDINATE {
        let own: Vec<&HeldLimit> = rows.iter().filter(|row| row.limit == kind).collect();
        let mut origins: Vec<(Origin, Vec<&str>)> = Vec::new();
        for row in &own {
            match origins.iter_mut().find(|(origin, _)| *origin == row.origin) {
                Some((_, names)) => names.push(&row.coordinate),
                None => origins.push((row.origin, vec![&row.coordinate])),
            }
        }
        let named = |(origin, names): &(Origin, Vec<&str>)| match names.len() == own.len() {
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

/// The kinds of limits that stand in the motion's own file alone, in words.
pub fn kinds_of_motion_alone(rows: &[HeldLimit]) -> Vec<String> {
    let is_own = |kind: &LimitKind| rows.iter().any(|row| row.limit == *kind && row.origin == Origin::MotionAlone);
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
        let (held, _) = held("q1", &loose, &described(), None).unwrap();
        assert_eq!((held.position, held.velocity, held.effort), ((-2.0, 1.0), 3.0, Some(10.0)));
        let away = CoordinateLimits { position: (3.0, 9.0), ..loose };
        assert!(super::held("q1", &away, &described(), None).is_err());
    }

    /// The tightest of the three holds, and is told; what is as tight in the description as elsewhere is the description's.
    #[test]
    fn every_limit_is_told_with_its_place() {
        let origins = |made_with: &CoordinateLimits, asked: Option<&AskedLimits>| -> (CoordinateLimits, Vec<Origin>) {
            let (limits, rows) = held("q1", made_with, &described(), asked).unwrap();
            (limits, rows.iter().map(|row| row.origin).collect())
        };
        use Origin::*;
        let (_, found) = origins(&made_with(), None);
        assert_eq!(found, [Description, Description, MotionAlone, MotionAlone, Description]);
        let slower = CoordinateLimits { velocity: 1.0, power: Some(5.0), ..made_with() };
        let (_, found) = origins(&slower, None);
        assert_eq!(found, [Description, MotionTighter, MotionAlone, MotionAlone, Description, MotionAlone]);
        let asked = AskedLimits { velocity: Some(0.5), jerk: Some(50.0), power: Some(9.0), ..AskedLimits::default() };
        let (limits, found) = origins(&slower, Some(&asked));
        assert_eq!((limits.velocity, limits.jerk, limits.power), (0.5, 50.0, Some(5.0)));
        assert_eq!(found, [Description, LimitsFile, MotionAlone, LimitsFile, Description, MotionTighter]);
        let (_, rows) = held("q1", &slower, &described(), Some(&asked)).unwrap();
        assert!(origins_text(&rows).contains("jerk          as in the limits file\n"), "{}", origins_text(&rows));
        assert_eq!(kinds_of_motion_alone(&rows), ["acceleration"]);
        let (_, rows) = held("q1", &made_with(), &described(), None).unwrap();
        assert_eq!(kinds_of_motion_alone(&rows), ["acceleration", "jerk"]);
    }
}
