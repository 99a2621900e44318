//! Units, zeros and gains of hobby arms, from the data of their servos (`hobby_arms.yaml`, with the sources).
//!
//! For a joint with k servos of stall torque T (N m) at the stall current I (A), current I_0 (A) without load, and c A per count:
//! ```text
//! gain = k T / (I - I_0)                          N m/A; I_0 = 0 where it is not published
//! gain = k T / 1000 / c                           of a load in 0.1 % of T, in the counts of a current
//! q = (x - zero) 2 pi / counts                    of counts x
//! q = (l + u) / 2 + x (u - l) / 200               of x from -100 to 100, l and u: limits of the joint
//! q = l + x (u - l) / 100                         of a gripper from 0 to 100
//! ```
//! A stall torque is a short peak, and the current without load is seldom published. So a gain has the relative standard
//! deviation [`GAIN_DEVIATION`].

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use gate::suggestion::did_you_mean;
use logs::{Columns, Proposal, Proposed, Quantity, Table};
use robot::Robot;
use serde::Deserialize;

use crate::error::Error;

/// Relative standard deviation of a gain from a data sheet.
const GAIN_DEVIATION: f64 = 0.2;
/// The names of joints identify an arm only if the robot has at least this number of joints.
const MIN_NAMED_JOINTS: usize = 4;
/// Positions that are whole numbers are counts of an encoder if at least one of them reaches this value.
const MIN_COUNT: f64 = 300.0;
/// Largest magnitude of a normalised position, per cent, with an allowance for rounding. Larger positions are degrees.
const MAX_PERCENT: f64 = 100.5;
/// Factor of the sum of two position limits that gives their mean, which is the position 0 of a normalised joint.
const HALF: f64 = 0.5;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HobbyArms {
    servos: BTreeMap<String, Servo>,
    arms: BTreeMap<String, Arm>,
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Servo {
    counts: f64,
    zero: f64,
    #[serde(rename = "gear")]
    _gear: f64,
    stall_nm: f64,
    stall_a: Option<f64>,
    #[serde(default)]
    no_load_a: f64,
    current_ma: Option<f64>,
    #[serde(default)]
    load: bool,
    source: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Arm {
    #[serde(default)]
    normalised: bool,
    source: String,
    joints: Vec<(String, String, f64)>,
}

/// Three results: the servo of each coordinate with the number of servos that turn it, whether positions may be normalised, and
/// the source of the data.
type ArmServos = (Vec<(Servo, f64)>, bool, String);

/// The form in which an arm writes positions.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Counts,
    Degrees,
    Normalised,
    Radians,
}

/// The part of a proposal of columns that follows from the data of an arm.
#[derive(Clone, Debug, Default)]
pub struct DriveProposal {
    /// Proposed lines for the transmission (ratios, offsets, scales), each a list with one number per joint.
    pub transmission: Vec<Proposed>,
    /// The gains as a field of a request, with the reason; `None` if the torques need no gains, or if no source gives gains.
    pub gains: Option<Proposed>,
}

/// Completes the proposal for a log from the data of the arm `name`. The name is for example `so101` or, with the form of the
/// positions, `so101:degrees`. The name of a servo stands for an arm with this servo in each joint.
///
/// Fails if the arm or the form is unknown, or if the robot does not fit the arm. Properties that no value determines are added
/// to `proposal.missing`.
pub(super) fn complete(
    robot: &Robot,
    table: &Table,
    name: &str,
    proposal: &mut Proposal,
) -> Result<DriveProposal, Error> {
    let data: HobbyArms = linear_model::yaml::read(include_str!("hobby_arms.yaml")).map_err(Error::new)?;
    let (arm, form) = name.split_once(':').map_or((name, None), |(arm, form)| (arm, Some(form)));
    let (servos, is_normalised, source) = servos_of(robot, &data, arm)?;
    let mut found = DriveProposal::default();
    // Units and gains follow from the values in the columns. Without a mapping, these columns are not known.
    let Some(mapping) = proposal.mapping.clone() else { return Ok(found) };
    let form = match form.map(form_of).transpose()? {
        Some(form) => form,
        None => match seen_form(table, &mapping, is_normalised) {
            Some(form) => form,
            None => {
                proposal.missing.push(format!(
                    "positions within -100 and 100 are degrees or normalised: name the arm `{arm}:degrees` or \
                     `{arm}:normalised`"
                ));
                proposal.mapping = None;
                return Ok(found);
            }
        },
    };
    // Normalised positions get the unit rad, because the ratios of the transmission convert per cent to rad.
    let unit = match form {
        Form::Counts => format!("ticks({})", servos[0].0.counts),
        Form::Degrees => "deg".into(),
        Form::Normalised | Form::Radians => "rad".into(),
    };
    let reason = match form {
        Form::Normalised => format!("of {arm}, normalised over the limits of the joints; see `transmission`"),
        _ => format!("positions of {arm}: {source}"),
    };
    put_unit(proposal, Quantity::Position, unit, reason);
    found.transmission = transmission(robot, &servos, form)?;
    found.gains = gains(robot, table, &servos, &mapping, proposal);
    // The mapping is found again, because the units of the proposal have changed.
    let coordinates: Vec<String> = robot.coordinates.iter().map(|coordinate| coordinate.name.clone()).collect();
    proposal.mapping =
        Some(Columns::find(table, &coordinates, &proposal.names).map_err(|e| Error::new(e.to_string()))?);
    Ok(found)
}

/// A sentence that proposes the data of the hobby arms whose joints have the names of this robot; `None` if there are none.
pub fn proposed_arm(robot: &Robot) -> Option<String> {
    let arms = arms_like(robot);
    let first = arms.first()?;
    Some(format!(
        "robot and joints have the names of {}: [arm={first}] takes the units, zeros and gains of the servos",
        arms.join(", ")
    ))
}

/// The names of the known arms that the robot may be. An arm is chosen if the name of the robot contains the name of the arm.
/// If no arm is chosen so, an arm is chosen if the robot has at least four coordinates, and if the name of each coordinate
/// contains the name of a joint of the arm. Joint names that end with a number are not compared, since many robots have them.
fn arms_like(robot: &Robot) -> Vec<String> {
    let Ok(data) = linear_model::yaml::read::<HobbyArms>(include_str!("hobby_arms.yaml")) else { return Vec::new() };
    let letters =
        |text: &str| text.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect::<String>();
    let names: Vec<String> = robot.coordinates.iter().map(|coordinate| coordinate.name.to_lowercase()).collect();
    let is_of = |name: &String, arm: &Arm| {
        let is_named = |joint: &(String, String, f64)| !joint.0.ends_with(char::is_numeric) && name.contains(&joint.0);
        arm.joints.iter().any(is_named)
    };
    let has_its_joints = |arm: &Arm| names.len() >= MIN_NAMED_JOINTS && names.iter().all(|name| is_of(name, arm));
    let is_named = |key: &String| letters(&robot.name).contains(&letters(key));
    let by_name: Vec<String> = data.arms.keys().filter(|key| is_named(key)).cloned().collect();
    match by_name.is_empty() {
        true => data.arms.iter().filter(|(_, arm)| has_its_joints(arm)).map(|(name, _)| name.clone()).collect(),
        false => by_name,
    }
}

fn form_of(word: &str) -> Result<Form, Error> {
    match word {
        "counts" => Ok(Form::Counts),
        "degrees" => Ok(Form::Degrees),
        "normalised" => Ok(Form::Normalised),
        "radians" => Ok(Form::Radians),
        _ => Err(Error::new(format_args!(
            "the form of an arm's positions is counts, degrees, normalised or radians, not `{}`",
            gate::shown::line(word)
        ))),
    }
}

/// Three results: the servo of each coordinate with the number of servos that turn it, whether the positions may be normalised,
/// and the source of the data.
fn servos_of(robot: &Robot, data: &HobbyArms, arm: &str) -> Result<ArmServos, Error> {
    let n = robot.coordinates.len();
    if let Some(servo) = data.servos.get(arm) {
        return Ok((vec![(servo.clone(), 1.0); n], false, servo.source.clone()));
    }
    let Some(found) = data.arms.get(arm) else {
        let known: Vec<&str> = data.arms.keys().chain(data.servos.keys()).map(String::as_str).collect();
        return Err(Error::new(format_args!(
            "the arm `{}` is not known{}; known are {}",
            gate::shown::line(arm),
            did_you_mean(arm, known.iter().copied()),
            known.join(", ")
        )));
    };
    if n > found.joints.len() {
        return Err(Error::new(format_args!(
            "the arm `{arm}` has {} joints, and the description has {n}: [lock] those that are not of the arm",
            found.joints.len()
        )));
    }
    // A joint of the arm is found by its name. A coordinate with another name belongs to the joint with the same number.
    let servo = |k: usize| {
        let name = robot.coordinates[k].name.to_lowercase();
        let joint = found.joints.iter().find(|joint| name.contains(&joint.0)).unwrap_or(&found.joints[k]);
        data.servos.get(&joint.1).map(|servo| (servo.clone(), joint.2))
    };
    let servos: Option<Vec<(Servo, f64)>> = (0..n).map(servo).collect();
    let servos = servos.ok_or_else(|| Error::new(format_args!("the arm `{arm}` has a servo without data")))?;
    Ok((servos, found.normalised, found.source.clone()))
}

/// The form of the positions, from their values; `None` if the positions may be degrees or normalised.
fn seen_form(table: &Table, mapping: &Columns, is_normalised: bool) -> Option<Form> {
    let columns: Vec<&[f64]> = mapping.position.iter().map(|source| table.columns[source.column].as_slice()).collect();
    let largest = columns.iter().flat_map(|column| column.iter()).fold(0.0, |most: f64, x| most.max(x.abs()));
    let is_whole = columns.iter().all(|column| column.iter().all(|x| x.fract() == 0.0));
    match () {
        () if is_whole && largest >= MIN_COUNT => Some(Form::Counts),
        () if largest <= TAU => Some(Form::Radians),
        () if largest > MAX_PERCENT || !is_normalised => Some(Form::Degrees),
        () => None,
    }
}

/// The lines for the transmission (ratios, offsets, scales) that follow from the form in which the arm writes positions.
fn transmission(robot: &Robot, servos: &[(Servo, f64)], form: Form) -> Result<Vec<Proposed>, Error> {
    let list = |key: &'static str, numbers: Vec<f64>, reason: &str| {
        // Six decimals are finer than one count of an encoder.
        let each: Vec<String> = numbers.iter().map(|x| format!("{x:.6}")).collect();
        Proposed { key, value: format!("[{}]", each.join(", ")), reason: reason.into() }
    };
    match form {
        Form::Counts => {
            let offsets = servos.iter().map(|(servo, _)| -servo.zero * TAU / servo.counts).collect();
            Ok(vec![list("offsets", offsets, "the middle of a turn is the angle 0; `rist doctor` tests it")])
        }
        Form::Normalised => {
            let of = |coordinate: &robot::Coordinate| {
                let (low, high) = coordinate.limits.position.unwrap_or_default();
                let is_limited = high > low && (high - low).is_finite();
                let is_gripper = coordinate.name.to_lowercase().contains("gripper");
                let zero = if is_gripper { low } else { HALF * (low + high) };
                let percent = if is_gripper { 100.0 } else { 200.0 };
                is_limited.then_some((percent / (high - low), zero)).ok_or_else(|| {
                    let name = &coordinate.name;
                    Error::new(format_args!("normalised positions need the limits of {name} in the description"))
                })
            };
            let all: Vec<(f64, f64)> = robot.coordinates.iter().map(of).collect::<Result<_, _>>()?;
            let (ratios, offsets): (Vec<f64>, Vec<f64>) = all.into_iter().unzip();
            Ok(vec![
                list("ratios", ratios.clone(), "per cent per radian, from the limits of the description"),
                list("offsets", offsets, "the middle of the range; of a gripper its lower limit"),
                list("scales", ratios, "so that the ratios count for positions alone"),
            ])
        }
        Form::Degrees | Form::Radians => Ok(Vec::new()),
    }
}

/// Sets the unit of the efforts, and returns the gains of currents.
fn gains(
    robot: &Robot,
    table: &Table,
    servos: &[(Servo, f64)],
    mapping: &Columns,
    proposal: &mut Proposal,
) -> Option<Proposed> {
    // Efforts that are all whole numbers are register values of the servo, not values in SI units.
    let is_raw = mapping.effort.iter().all(|source| table.columns[source.column].iter().all(|x| x.fract() == 0.0));
    // If a unit was proposed with a word type (`int16`, `signbit(10)`), the new unit keeps this type, because it tells how the
    // sign is stored.
    let word = |unit: &Option<String>| {
        let first = unit.as_deref().and_then(|unit| unit.split_whitespace().next());
        first.filter(|word| word.starts_with("int") || word.starts_with("signbit")).map(|word| format!("{word} "))
    };
    match mapping.effort_is {
        Quantity::Torque if is_raw => {
            let stalls: Vec<f64> = servos.iter().map(|(servo, number)| number * servo.stall_nm).collect();
            if stalls.iter().any(|stall| *stall != stalls[0]) {
                let why =
                    "a load in 0.1 % of the stall torque, which differs by joint: name the columns `current` instead";
                proposal.missing.push(why.into());
                return None;
            }
            let unit = format!("{}permille({} N m)", word(&proposal.names.units.torque).unwrap_or_default(), stalls[0]);
            let reason = format!("0.1 % of the stall torque: {}", servos[0].0.source);
            put_unit(proposal, Quantity::Torque, unit, reason);
            None
        }
        Quantity::Current => {
            let count_ma = servos.iter().find_map(|(servo, _)| servo.current_ma).unwrap_or(1.0);
            if is_raw {
                let unit = format!("{}counts({count_ma} mA)", word(&proposal.names.units.current).unwrap_or_default());
                put_unit(proposal, Quantity::Current, unit, "of the servo's register".into());
            }
            // The two gains of the file's head: k T / (I - I_0) for a current, k T / 1000 / c for a load in the counts of a
            // current, with c = count_ma / 1000.
            let gain = |(servo, number): &(Servo, f64)| match servo.stall_a {
                Some(stall_a) if !servo.load => Some(number * servo.stall_nm / (stall_a - servo.no_load_a)),
                _ if servo.load && is_raw => Some(number * servo.stall_nm / count_ma),
                _ => None,
            };
            let each = robot.coordinates.iter().zip(servos).filter_map(|(coordinate, servo)| {
                let gain = gain(servo)?;
                Some(format!("{}={gain:.3}+-{:.3}", coordinate.name, GAIN_DEVIATION * gain))
            });
            let value = each.collect::<Vec<String>>().join(",");
            let reason = "stall torque over stall current, with a standard deviation of 20 %".into();
            (!value.is_empty()).then_some(Proposed { key: "gain", value, reason })
        }
        _ => None,
    }
}

/// Puts a unit in place of the proposed one.
fn put_unit(proposal: &mut Proposal, quantity: Quantity, unit: String, reason: String) {
    let units = &mut proposal.names.units;
    let (key, place) = match quantity {
        Quantity::Position => ("position", &mut units.position),
        Quantity::Torque => ("torque", &mut units.torque),
        _ => ("current", &mut units.current),
    };
    *place = Some(unit.clone());
    proposal.units.retain(|line| line.key != key);
    proposal.units.push(Proposed { key, value: format!("\"{unit}\""), reason });
}
