//! Error margins: bounds of the errors between the robot and its description or planned motion. The user gives them, and a proof
//! covers them.
//!
//! | margin | greatest error | the proof |
//! |---|---|---|
//! | `encoder_zero`, `tracking` | of a joint's position with respect to the motion, rad (m); both add up to e | narrows the position limits by e at both ends; lowers a distance by the sum of e R over its joints |
//! | `calibration` | of the position of a body point in the base frame, computed from joint positions and description, m | lowers the distance to a plane by the margin, of two links by twice the margin |
//! | `mesh` | of a body's surface outside its collision shape, m | lowers distances like `calibration` |
//! | `payload` | an additional body on a link; its mass may have any value from zero to the given mass | covers efforts and powers with the whole body and without it, and so all masses in between (both are linear in the mass) |
//!
//! R is a bound of the velocity of the bodies per velocity of the joint, m/rad. A margin that is not given is zero, and the
//! report says so. Not here: velocities and torques that tracking errors add.

use std::collections::BTreeMap;

use linear_model::known_load::KnownLoad;
use serde::{Deserialize, Serialize};

/// A margin for position errors, rad (m): one for all joints, or one for each named joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum JointMargin {
    /// The same margin for every joint.
    Each(f64),
    /// Margins of single joints, by name of the coordinate; zero for all other joints.
    Named(BTreeMap<String, f64>),
}

impl JointMargin {
    fn of(&self, coordinate: &str) -> f64 {
        match self {
            JointMargin::Each(x) => *x,
            JointMargin::Named(all) => all.get(coordinate).copied().unwrap_or(0.0),
        }
    }

    fn numbers(&self) -> Vec<f64> {
        match self {
            JointMargin::Each(x) => vec![*x],
            JointMargin::Named(all) => all.values().copied().collect(),
        }
    }
}

/// The error margins of a robot. `None`: the margin is not given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ErrorMargins {
    /// Greatest error of the zero position of an encoder, rad (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoder_zero: Option<JointMargin>,
    /// Greatest tracking error: distance of a joint's position from its set point, rad (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tracking: Option<JointMargin>,
    /// Greatest calibration error: distance of a body point from the position computed from the description, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibration: Option<f64>,
    /// Greatest distance by which a body's surface exceeds its collision shape, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<f64>,
    /// A payload that the robot may carry during the motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<KnownLoad>,
}

/// A joint whose position range is smaller than this value (rad or m) counts as locked, so its range is not narrowed.
const LOCKED_RANGE: f64 = 1e-6;
/// Greatest accepted margin, rad or m: larger than any robot needs.
const LARGEST_MARGIN: f64 = 10.0;

impl ErrorMargins {
    /// Describes the first margin that is out of range or names an unknown coordinate. `None` if all margins are valid.
    pub fn fault(&self, names: &[String]) -> Option<String> {
        let joints = [("encoder_zero", &self.encoder_zero), ("tracking", &self.tracking)];
        let of_joints = joints.iter().flat_map(|(key, x)| x.iter().flat_map(|x| x.numbers()).map(|x| (*key, x)));
        let bodies = [("calibration", self.calibration), ("mesh", self.mesh)];
        let mut all = of_joints.chain(bodies.into_iter().filter_map(|(key, x)| Some((key, x?))));
        if let Some((key, x)) = all.find(|(_, x)| !(0.0..=LARGEST_MARGIN).contains(x)) {
            return Some(format!("margins: {key} is {x}; expected is 0 to {LARGEST_MARGIN} (rad or m)"));
        }
        for (key, margin) in joints {
            let Some(JointMargin::Named(named)) = margin else { continue };
            if let Some(unknown) = named.keys().find(|name| !names.contains(name)) {
                let known = names.join(", ");
                return Some(format!("margins: {key}: there is no coordinate `{unknown}`; there are {known}"));
            }
        }
        let fault = self.payload.as_ref().and_then(KnownLoad::fault)?;
        Some(format!("margins: payload: {fault}"))
    }

    /// Greatest position error of each joint, encoder zero plus tracking, rad (m).
    pub fn of_joints(&self, names: &[String]) -> Vec<f64> {
        names.iter().map(|name| self.of_joint(name)).collect()
    }

    /// Greatest position error of one joint, encoder zero plus tracking, rad (m).
    pub fn of_joint(&self, name: &str) -> f64 {
        [&self.encoder_zero, &self.tracking].into_iter().flatten().map(|margin| margin.of(name)).sum()
    }

    /// The tracking margin of a joint, rad (m). `None` if it is not given.
    pub fn tracking_of(&self, name: &str) -> Option<f64> {
        self.tracking.as_ref().map(|margin| margin.of(name))
    }

    /// Greatest position error of a point on a body, calibration plus mesh, m.
    pub fn of_bodies(&self) -> f64 {
        self.calibration.unwrap_or(0.0) + self.mesh.unwrap_or(0.0)
    }

    /// The margins for the check of a motion: for each error the greater of two margins. `self`: margins in the motion's file;
    /// `user`: margins in the user's limits file. The payload is the user's, if given.
    pub fn held_to(&self, user: &ErrorMargins, names: &[String]) -> ErrorMargins {
        let joints = |own: &Option<JointMargin>, asked: &Option<JointMargin>| match (own, asked) {
            (Some(own), Some(asked)) => {
                let greater = |name: &String| (name.clone(), own.of(name).max(asked.of(name)));
                Some(if own == asked { own.clone() } else { JointMargin::Named(names.iter().map(greater).collect()) })
            }
            (own, asked) => asked.as_ref().or(own.as_ref()).cloned(),
        };
        let greater = |own: Option<f64>, asked: Option<f64>| own.into_iter().chain(asked).reduce(f64::max);
        ErrorMargins {
            encoder_zero: joints(&self.encoder_zero, &user.encoder_zero),
            tracking: joints(&self.tracking, &user.tracking),
            calibration: greater(self.calibration, user.calibration),
            mesh: greater(self.mesh, user.mesh),
            payload: user.payload.as_ref().or(self.payload.as_ref()).cloned(),
        }
    }

    /// The name of each margin with its value and unit in words; `None` if the margin is not given.
    pub fn words(&self) -> [(&'static str, Option<String>); 5] {
        let joints = |margin: &Option<JointMargin>| match margin {
            Some(JointMargin::Each(x)) => Some(format!("{x} rad (m)")),
            Some(JointMargin::Named(all)) => {
                let one = |(name, x): (&String, &f64)| format!("{name} {x}");
                Some(format!("{} rad (m)", all.iter().map(one).collect::<Vec<_>>().join(", ")))
            }
            None => None,
        };
        let metres = |x: Option<f64>| x.map(|x| format!("{x} m"));
        let payload = self.payload.as_ref().map(|load| format!("none to {} kg on {}", load.mass, load.link));
        [
            ("encoder zero", joints(&self.encoder_zero)),
            ("tracking", joints(&self.tracking)),
            ("calibration", metres(self.calibration)),
            ("mesh", metres(self.mesh)),
            ("payload", payload),
        ]
    }
}

/// Position limits of a joint, narrowed at both ends by its greatest position error `by`, rad (m). The limits of a locked joint
/// are unchanged.
///
/// Fails if no position range remains.
pub fn narrowed((low, high): (f64, f64), by: f64) -> Result<(f64, f64), String> {
    if by == 0.0 || high - low <= LOCKED_RANGE {
        return Ok((low, high));
    }
    let found = (low + by, high - by);
    match found.0 < found.1 {
        true => Ok(found),
        false => Err(format!(
            "the margins of encoder zero and tracking, {by} rad (m) at either end, take all of the positions from {low} to {high}"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use linear_model::yaml;

    fn read(text: &str) -> ErrorMargins {
        yaml::read(text).unwrap()
    }

    fn names() -> Vec<String> {
        ["q1", "q2"].map(String::from).to_vec()
    }

    #[test]
    fn margins_add_up_and_narrow() {
        let margins = read("{encoder_zero: 0.01, tracking: {q2: 0.02}, calibration: 0.001, mesh: 0.002}");
        assert_eq!((margins.of_joints(&names()), margins.of_bodies()), (vec![0.01, 0.03], 0.003));
        assert_eq!(narrowed((-1.0, 2.0), 0.5), Ok((-0.5, 1.5)));
        assert_eq!(narrowed((1.0, 1.0 + 1e-9), 0.5), Ok((1.0, 1.0 + 1e-9)));
        assert!(narrowed((-1.0, 1.0), 1.0).unwrap_err().contains("take all of the positions from -1 to 1"));
        assert_eq!(narrowed((f64::NEG_INFINITY, 1.0), 0.5), Ok((f64::NEG_INFINITY, 0.5)));
    }

    #[test]
    fn the_greater_margin_counts() {
        let own = read("{encoder_zero: 0.01, mesh: 0.002, tracking: 0.1}");
        let user = read("{encoder_zero: {q1: 0.02}, mesh: 0.001, calibration: 0.003}");
        let held = own.held_to(&user, &names());
        assert_eq!(held.of_joints(&names()), vec![0.02 + 0.1, 0.01 + 0.1]);
        assert_eq!((held.mesh, held.calibration), (Some(0.002), Some(0.003)));
        assert_eq!(own.held_to(&own, &names()), own);
    }

    #[test]
    fn what_no_robot_has_is_refused() {
        for (text, says) in [
            ("encoder_zero: -0.1", "margins: encoder_zero is -0.1; expected is 0 to 10"),
            ("tracking: {q1: 11}", "margins: tracking is 11;"),
            ("calibration: 1e9", "margins: calibration is 1000000000"),
            ("tracking: {q7: 0.1}", "margins: tracking: there is no coordinate `q7`; there are q1, q2"),
            ("payload: {link: q, mass: -1, centre_of_mass: [0, 0, 0]}", "margins: payload: no body has"),
        ] {
            let fault = read(text).fault(&names()).unwrap();
            assert!(fault.starts_with(says), "{text}: {fault}");
        }
        assert_eq!(read("{tracking: 0.1, mesh: 0}").fault(&names()), None);
    }
}
