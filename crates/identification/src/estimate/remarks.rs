//! Makes the remarks of an estimate: sentences on parameters that are not identifiable, and on joints that move too little.
//!
//! A direction v is a combination of parameters. The direction is not identifiable if the torques do not change along v: W v =
//! 0 with the regressor W. The condition number is computed from the columns of W scaled to unit norm.

use linear_model::linear_model::Model;
use linear_model::parameter::Parameter;
use linear_model::pseudo_inertia::Ten;
use numerics::least_squares::Solution;

use crate::rows::observation::Observation;

/// A revolute joint has a short range of motion if its range is below this angle, rad. A short range is a reason for large
/// standard deviations, unless the joint is fast.
const SHORT_RANGE_RAD: f64 = 0.5;
/// A prismatic joint has a short range of motion if its range is below this length, m.
const SHORT_RANGE_M: f64 = 0.05;

/// A joint is slow if its largest speed is at most this share of the largest speed of all joints of the same kind (revolute or
/// prismatic).
const SLOW_JOINT_SPEED_SHARE: f64 = 0.2;

/// A remark names the weakest combination of parameters if the condition number of the scaled columns exceeds this value.
const REMARKABLE_CONDITION_NUMBER: f64 = 100.0;

/// A remark on a direction (combination of parameters) names a parameter if the entry of the parameter in the direction exceeds
/// this value. The largest entry is 1.
const SMALLEST_NAMED_ENTRY: f64 = 0.05;
/// Largest number of parameters that a sentence names for a direction.
const MAX_NAMED_MEMBERS: usize = 6;

/// Two turns, rad. Few joints of arms turn farther, so a larger angle is more likely a column in degrees.
pub(crate) const LARGEST_ARM_ANGLE_RAD: f64 = 4.0 * std::f64::consts::PI;

/// For each joint, whether it hardly moves: the range of the joint is short, and the joint is slow compared with the fastest
/// joint of the same kind.
pub(crate) fn little_motion(model: &Model, observation: &Observation) -> Vec<bool> {
    let kind = |k: usize| model.regressor.is_prismatic(k);
    let fastest =
        |k: usize| (0..model.n()).filter(|&j| kind(j) == kind(k)).map(|j| observation.speed[j]).fold(0.0, f64::max);
    (0..model.n())
        .map(|k| is_little(model, observation, k) && observation.speed[k] <= SLOW_JOINT_SPEED_SHARE * fastest(k))
        .collect()
}

fn is_little(model: &Model, observation: &Observation, k: usize) -> bool {
    let little = if model.regressor.is_prismatic(k) { SHORT_RANGE_M } else { SHORT_RANGE_RAD };
    observation.range[k].1 - observation.range[k].0 < little
}

fn unit(model: &Model, k: usize) -> &'static str {
    if model.regressor.is_prismatic(k) { "m" } else { "rad" }
}

/// Whether all joints of a parameter hardly move. `still`: for each joint, whether it hardly moves.
pub fn weak(parameter: &Parameter, still: &[bool]) -> bool {
    !parameter.coordinates.is_empty() && parameter.coordinates.iter().all(|&k| still[k])
}

/// A remark reports a body if its identified mass and its nominal mass differ by more than this factor.
const REMARKABLE_MASS_RATIO: f64 = 3.0;

/// A sentence on a body whose mass differs from its nominal mass by a large factor; `None` for other bodies. `known`: the
/// nominal parameters of the body.
pub fn exceeding_description((name, body): &(&str, Ten), known: &Ten) -> Option<String> {
    let (mass, given) = (body[9], known[9]);
    let ratio = mass / given;
    (given > 0.0 && !(1.0 / REMARKABLE_MASS_RATIO..REMARKABLE_MASS_RATIO).contains(&ratio)).then(|| {
        format!(
            "{name} comes out at {mass:.3} kg, {ratio:.1} times the {given:.3} kg of the description: the masses are not \
             in these data, or inertia that no body has (rotors, gears, drive gains) is put into bodies"
        )
    })
}

/// All remarks on rows and solution: parameters and combinations that are not or weakly identifiable, rows left out at
/// standstill, and joint ranges.
pub fn remarks(model: &Model, observation: &Observation, solution: &Solution) -> Vec<String> {
    let mut out = alone(model, observation, solution);
    if solution.rank < model.p() {
        out.extend(together(model, observation, solution));
    } else {
        out.extend(weakest(model, observation, solution));
    }
    out.extend(at_rest(model, observation));
    out.extend(far(model, observation));
    out.extend(hardly_moving(model, observation));
    out
}

/// Sentences on parameters that are not identifiable because their columns are zero in all rows.
fn alone(model: &Model, observation: &Observation, solution: &Solution) -> Vec<String> {
    let is_alone = |c: &usize| !solution.determined[*c] && solution.inverse[(*c, *c)] == 0.0;
    let sentence = |c: usize| {
        let name = &model.parameters[c].id;
        format!("{name} is not identifiable: no row depends on it{}", because(model, observation, &[c]))
    };
    (0..model.p()).filter(is_alone).map(sentence).collect()
}

/// Sentences on combinations of several parameters that are not identifiable: directions v of the parameter space with W v =
/// 0 (W: regressor).
fn together(model: &Model, observation: &Observation, solution: &Solution) -> Vec<String> {
    let mut out = Vec::new();
    for (_, direction) in solution.weak.iter().take(model.p() - solution.rank) {
        let members = members(model, direction);
        if members.len() < 2 {
            continue;
        }
        let names = combination(model, direction, &members);
        let why = because(model, observation, &members);
        let sentence =
            format!("not identifiable one by one, only in combination: a change along {names} changes no torque{why}");
        if !out.contains(&sentence) {
            out.push(sentence);
        }
    }
    out
}

/// A sentence on the least identifiable combination of parameters: the direction v with the smallest |W v| (W: regressor).
/// `None` if the condition number is small.
fn weakest(model: &Model, observation: &Observation, solution: &Solution) -> Option<String> {
    let (ratio, direction) =
        solution.weak.first().filter(|_| solution.condition_number > REMARKABLE_CONDITION_NUMBER)?;
    let members = members(model, direction);
    let names = combination(model, direction, &members);
    let why = because(model, observation, &members);
    Some(format!("weakest direction (1/{:.0} of the strongest): {names}{why}", 1.0 / ratio))
}

/// A sentence with the number of rows of each joint that were left out because the joint stands still; `None` if no rows were
/// left out.
fn at_rest(model: &Model, observation: &Observation) -> Option<String> {
    let at_rest = model.regressor.coordinates().iter().zip(&observation.still).filter(|(_, count)| **count > 0);
    let at_rest: Vec<String> = at_rest.map(|(name, count)| format!("{name} {count}")).collect();
    (!at_rest.is_empty()).then(|| {
        format!("rows left out because the joint stands still and stiction is not in the model: {}", at_rest.join(", "))
    })
}

/// Sentences on revolute joints with angles beyond [`LARGEST_ARM_ANGLE_RAD`], which may be degrees.
fn far(model: &Model, observation: &Observation) -> Vec<String> {
    let coordinates = model.regressor.coordinates().iter().zip(&observation.range).enumerate();
    let turning = coordinates.filter(|(k, _)| !model.regressor.is_prismatic(*k));
    let far = turning
        .map(|(_, (name, range))| (name, range.0.abs().max(range.1.abs())))
        .filter(|(_, far)| *far > LARGEST_ARM_ANGLE_RAD);
    let sentence = |(name, far): (&String, f64)| {
        format!(
            "{name} reaches {far:.1} rad, more than two turns: if its column is in degrees, say so in its header (q1_deg)"
        )
    };
    far.map(sentence).collect()
}

/// Sentences on joints that hardly move.
fn hardly_moving(model: &Model, observation: &Observation) -> Vec<String> {
    let still = little_motion(model, observation);
    let sentence = |(k, &(low, high)): (usize, &(f64, f64))| {
        let (name, unit) = (&model.regressor.coordinates()[k], unit(model, k));
        format!(
            "joint {} ({name}) moves {:.3} {unit} at up to {:.3} {unit}/s only: its parameters are not identifiable from this log, errors of the model decide them",
            k + 1,
            high - low,
            observation.speed[k]
        )
    };
    observation.range.iter().enumerate().filter(|(k, _)| still[*k]).map(sentence).collect()
}

/// Indices of the parameters with the largest entries in a direction of the parameter space, the largest first.
fn members(model: &Model, direction: &[f64]) -> Vec<usize> {
    let mut members: Vec<usize> = (0..model.p()).filter(|&c| direction[c].abs() > SMALLEST_NAMED_ENTRY).collect();
    members.sort_by(|&a, &b| direction[b].abs().total_cmp(&direction[a].abs()));
    members.truncate(MAX_NAMED_MEMBERS);
    members
}

fn combination(model: &Model, direction: &[f64], members: &[usize]) -> String {
    let term = |&c: &usize| format!("{:+.2} {}", direction[c], model.parameters[c].id);
    members.iter().map(term).collect::<Vec<_>>().join(" ")
}

/// A clause that gives a reason: the names of the joints that belong to the parameters `members` and have a short range of
/// motion. Empty if no such joint has a short range.
fn because(model: &Model, observation: &Observation, members: &[usize]) -> String {
    let mut joints: Vec<usize> =
        members.iter().flat_map(|&c| model.parameters[c].coordinates.iter().copied()).collect();
    joints.sort_unstable();
    joints.dedup();
    let still = joints.into_iter().filter(|&k| is_little(model, observation, k));
    let text = |k: usize| {
        let range = observation.range[k].1 - observation.range[k].0;
        format!("joint {} moves {range:.3} {}", k + 1, unit(model, k))
    };
    let texts: Vec<String> = still.map(text).collect();
    if texts.is_empty() { String::new() } else { format!(": {}", texts.join(", ")) }
}
