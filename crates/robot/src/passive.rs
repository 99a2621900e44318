//! Expresses the passive joints of closed loops as affine functions of the coordinates, if this is possible.
//!
//! A planar loop is a closed polygon of vectors ([`crate::polygon`]). Its orientation (sum of angles) gives one linear
//! equation. The loop may give more equations: if relations found before keep some sides at constant angles to each other,
//! these sides form a group and are added up to one vector. Equations follow if the groups are
//!
//! - two vectors: they are opposite;
//! - four vectors with equal opposite lengths: if the loop nearest to the start values is a parallelogram, v_1 = -v_3 and v_2 =
//!   -v_4. The other possible assembly of these sides is the crossed four-bar ([`crate::assembly`]). The lengths must be equal
//!   at every value of the symbols. If the lengths are equal only at the values of the file, the loop is a general four-bar.
//!
//! The loops are treated repeatedly as long as one of them gives a new relation, because parallelograms with common links are
//! resolved one after the other. To make the constants of the relations exact, their changes with each symbol are computed: they
//! show an integer combination of symbols and a multiple of pi/12. A joint without a relation stays a passive coordinate.
//!
//! General and crossed four-bars, slider-cranks and spatial loops are not resolved, because no affine relation describes them.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::angle_snap::computed_angle;
use crate::assembly::{Linkage, linkage};
use crate::linear_angle::{LinearAngle, wrapped};
use crate::polygon::{COINCIDENCE_ROUNDING, Polygon, Side, polygon};
use crate::relation::{Linear, Relation, apply, reduced};
use crate::robot::{Note, Robot};
use crate::value::{SymbolId, Value};

/// Finds affine relations for the passive coordinates [`Robot::passive`] and applies them: their joints follow the
/// coordinates, and the constants are added to the geometry. Each relation gets a note. Fails if a loop cannot close, or if
/// it relates coordinates to each other.
pub(crate) fn resolve(robot: &mut Robot) -> Result<(), String> {
    if robot.passive.is_empty() {
        return Ok(());
    }
    let (mut steps, mut notes) = (Vec::new(), Vec::new());
    let relations = settle(robot, &mut steps, &mut notes)?;
    robot.notes.append(&mut notes);
    let constants = exact_constants(robot, &steps, &relations);
    apply(robot, &relations, &constants);
    Ok(())
}

/// How an equation was found. This is stored so that the equation can be formed again at other values of the symbols.
#[derive(Clone, Debug)]
enum EquationOrigin {
    /// The equation follows from the orientation of the loop with this index.
    Turn(usize),
    /// The equation states that the sums of two groups of sides of a loop are opposite vectors: index of the loop, and indices of
    /// the sides of each group.
    Opposite(usize, Vec<usize>, Vec<usize>),
}

/// Finds the relations between the joint variables of all loops. Adds the origins of their equations to `steps`, and notes on
/// assumed linkages to `notes`.
fn settle(robot: &Robot, steps: &mut Vec<EquationOrigin>, notes: &mut Vec<Note>) -> Result<Vec<Relation>, String> {
    let symbols = &robot.symbols;
    let mut relations: Vec<Relation> = Vec::new();
    // Each planar loop with passive coordinates is converted to a polygon.
    let mut polygons = Vec::with_capacity(robot.loops.len());
    for (l, one) in robot.loops.iter().enumerate() {
        let named = |e: String| format!("loop {} cannot close: {e}", l + 1);
        let planar = if robot.is_implicit(one) { polygon(robot, symbols, one).map_err(named)? } else { None };
        polygons.push(planar);
    }
    // The equations from the orientation of each loop are tried first. Then the equations from groups of sides are tried.
    let mut tried: Vec<EquationOrigin> =
        (0..polygons.len()).filter(|&l| polygons[l].is_some()).map(EquationOrigin::Turn).collect();
    let mut first = true;
    loop {
        let mut news = false;
        for step in tried.drain(..) {
            let equation = equation(&polygons, &relations, &step);
            if add(robot, &mut relations, equation, &step)? {
                steps.push(step);
                news = true;
            }
        }
        if !news && !first {
            return Ok(relations);
        }
        first = false;
        // New relations may give other sides constant angles, so every loop is checked again.
        for (l, polygon) in polygons.iter().enumerate() {
            if let Some(polygon) = polygon {
                tried.extend(opposite(robot, l, polygon, &relations, steps, notes)?);
            }
        }
        if tried.is_empty() {
            return Ok(relations);
        }
    }
}

/// The pairs of groups of sides of loop l whose sums must be opposite vectors. A group has sides that the relations found so far
/// keep at constant angles to each other.
fn opposite(
    robot: &Robot,
    l: usize,
    polygon: &Polygon,
    relations: &[Relation],
    steps: &[EquationOrigin],
    notes: &mut Vec<Note>,
) -> Result<Vec<EquationOrigin>, String> {
    // Groups of sides that keep constant angles to each other. Each group has: coefficients of the angle Phi of the group, sum of
    // its vectors, and indices of its sides.
    let mut groups: Vec<(Vec<f64>, [f64; 2], Vec<usize>)> = Vec::new();
    for (k, side) in polygon.sides.iter().enumerate() {
        let (turn, angle) = reduced(relations, (side.turn.clone(), 0.0));
        let vector = rotated(side.vector, angle);
        let alike = |g: &&mut (Vec<f64>, [f64; 2], Vec<usize>)| {
            g.0.iter().zip(&turn).all(|(a, b)| (a - b).abs() < COINCIDENCE_ROUNDING)
        };
        match groups.iter_mut().find(alike) {
            Some(group) => {
                group.1 = [group.1[0] + vector[0], group.1[1] + vector[1]];
                group.2.push(k);
            }
            None => groups.push((turn, vector, vec![k])),
        }
    }
    let length = |g: &(Vec<f64>, [f64; 2], Vec<usize>)| g.1[0].hypot(g.1[1]);
    groups.retain(|g| length(g) > COINCIDENCE_ROUNDING);
    let equal = |i: usize, j: usize| (length(&groups[i]) - length(&groups[j])).abs() <= COINCIDENCE_ROUNDING;
    let step = |i: usize, j: usize| EquationOrigin::Opposite(l, groups[i].2.clone(), groups[j].2.clone());
    match groups.len() {
        1 => Err(format!("loop {} cannot close: its ends stay {:.3e} m apart", l + 1, length(&groups[0]))),
        2 if equal(0, 1) => Ok(vec![step(0, 1)]),
        2 => {
            let [a, b] = [length(&groups[0]), length(&groups[1])];
            Err(format!("loop {} cannot close: {a:.6} m on one side never meets {b:.6} m on the other", l + 1))
        }
        4 if equal(0, 2) && equal(1, 3) => {
            let sides = [0, 1, 2, 3].map(|i| groups[i].2.as_slice());
            let (is_parallelogram, text) = parallelogram(robot, l, polygon, relations, steps, sides);
            let note = text.map(|text| Note { subject: format!("loop {}", l + 1), text });
            notes.extend(note.filter(|note| !notes.contains(note)));
            Ok(if is_parallelogram { vec![step(0, 2), step(1, 3)] } else { Vec::new() })
        }
        _ => Ok(Vec::new()),
    }
}

/// Whether four sums of sides form a parallelogram. The caller checked that opposite sums have equal lengths at the values of the
/// file. Also returns a note for the user on what was assumed.
fn parallelogram(
    robot: &Robot,
    l: usize,
    polygon: &Polygon,
    relations: &[Relation],
    steps: &[EquationOrigin],
    sides: [&[usize]; 4],
) -> (bool, Option<String>) {
    let by_chance = lengths_by_chance(robot, l, steps, sides);
    if !by_chance.is_empty() {
        let names = by_chance.join(", ");
        let text = format!(
            "its opposite sides are equal at the values of {names} only, so it is no parallelogram but a four-bar solved \
             numerically; if they are meant to be equal, give equal lengths one symbol"
        );
        return (false, Some(text));
    }
    let n = robot.n_coordinates();
    let start: Vec<f64> = vec![0.0; n].into_iter().chain(robot.passive.iter().map(|p| p.start)).collect();
    // The relations found so far are substituted into the polygon, so that only variables without a relation remain in it.
    let settled = |(turn, angle): Linear| reduced(relations, (turn, angle));
    let side = |side: &Side| {
        let (turn, angle) = settled((side.turn.clone(), 0.0));
        Side { vector: rotated(side.vector, angle), turn }
    };
    let (turn, angle) = settled((polygon.turn.clone(), 0.0));
    let reduced = Polygon { sides: polygon.sides.iter().map(side).collect(), turn, angle: polygon.angle - angle };
    match linkage(&reduced, sides, &start, n) {
        Linkage::Parallelogram => (true, None),
        Linkage::Crossed => {
            let text = "its opposite sides are equal, and next to the start of its passive joints it is the crossed linkage, \
                        not the parallelogram: it is solved numerically";
            (false, Some(text.into()))
        }
        Linkage::Stretched => {
            let text = "at the start of its passive joints all its sides lie along one line, where parallelogram and crossed \
                        linkage meet; it is taken for the parallelogram (for the crossed one, give a start away from there)";
            (true, Some(text.into()))
        }
        Linkage::NoStart => {
            let text = "its opposite sides are equal; without a start of its passive joints it is taken for the parallelogram, \
                        not for the crossed linkage";
            (true, Some(text.into()))
        }
    }
}

/// The symbols of which a change alone makes the lengths of opposite sides unequal. Empty if the lengths are equal at every
/// value of the symbols.
fn lengths_by_chance(robot: &Robot, l: usize, steps: &[EquationOrigin], sides: [&[usize]; 4]) -> Vec<String> {
    /// Lengths count as unequal if they differ by more than this value, m. The change of a symbol changes a length by about
    /// 0.01 m, and rounding changes it by 1e-15 m.
    const DIFFERENT_LENGTHS_M: f64 = 1e-7;
    let free = free_symbols(robot);
    let differ = |amounts: &dyn Fn(usize) -> f64| {
        // At the changed values the loop may be no polygon. Then nothing can be said about its sides.
        let Some((polygons, relations)) = again(robot, &free, steps, amounts) else { return false };
        let Some(polygon) = &polygons[l] else { return false };
        let length = |sides: &[usize]| {
            let sum = sides.iter().fold([0.0, 0.0], |sum, &k| {
                let (_, angle) = reduced(&relations, (polygon.sides[k].turn.clone(), 0.0));
                let [x, y] = rotated(polygon.sides[k].vector, angle);
                [sum[0] + x, sum[1] + y]
            });
            sum[0].hypot(sum[1])
        };
        let lengths = sides.map(length);
        (lengths[0] - lengths[2]).abs() > DIFFERENT_LENGTHS_M || (lengths[1] - lengths[3]).abs() > DIFFERENT_LENGTHS_M
    };
    if !differ(&together) {
        return Vec::new();
    }
    let alone = free.iter().filter(|&&s| differ(&|k| if k == s { SINGLE_SYMBOL_STEP } else { 0.0 }));
    alone.map(|&s| robot.symbols[s].name.clone()).collect()
}

/// Change of a symbol, m or rad, in a trial where only this symbol changes.
const SINGLE_SYMBOL_STEP: f64 = 0.0137;
/// Mean change of the symbols, m or rad, in a trial where all symbols change.
const COMMON_STEP: f64 = 0.05;
/// In a trial where all symbols change, their changes differ from the mean change by up to this value, m or rad.
const COMMON_STEP_VARIATION: f64 = 0.031;
/// In this trial, the changes follow a sine over the index of the symbol, with this phase from one symbol to the next, rad.
const COMMON_STEP_PHASE: f64 = 1.7;

/// Change of symbol s in a trial where all symbols change, m or rad. It is different for each symbol.
fn together(s: usize) -> f64 {
    COMMON_STEP + COMMON_STEP_VARIATION * (s as f64 * COMMON_STEP_PHASE).sin()
}

/// Indices of the symbols with a number as value, not an expression of other symbols.
fn free_symbols(robot: &Robot) -> Vec<usize> {
    (0..robot.symbols.len()).filter(|&s| is_number(&robot.symbols[s].value)).collect()
}

/// Forms the polygons and the relations of `steps` again, with the free symbols changed by `amounts`. `None` if an equation
/// cannot be formed or contradicts the others.
fn again(
    robot: &Robot,
    free: &[usize],
    steps: &[EquationOrigin],
    amounts: &dyn Fn(usize) -> f64,
) -> Option<(Vec<Option<Polygon>>, Vec<Relation>)> {
    let mut symbols = robot.symbols.clone();
    for &s in free {
        let value = symbols[s].value.number(&robot.symbols) + amounts(s);
        symbols[s].value = Value::Number(value);
    }
    let polygons: Vec<Option<Polygon>> =
        robot.loops.iter().map(|one| polygon(robot, &symbols, one).unwrap_or(None)).collect();
    let mut relations: Vec<Relation> = Vec::new();
    for step in steps {
        let equation = equation(&polygons, &relations, step);
        if !matches!(add(robot, &mut relations, equation, step), Ok(true)) {
            return None;
        }
    }
    Some((polygons, relations))
}

/// The equation with this origin; `None` if its loop is not a polygon.
fn equation(polygons: &[Option<Polygon>], relations: &[Relation], step: &EquationOrigin) -> Option<Linear> {
    match step {
        EquationOrigin::Turn(l) => polygons[*l].as_ref().map(|p| (p.turn.clone(), p.angle)),
        EquationOrigin::Opposite(l, one, other) => {
            let polygon = polygons[*l].as_ref()?;
            // Two results for a group of sides: the coefficients of the angle Phi of its first side (see `polygon`), and the
            // angle of the sum of the sides at Phi = 0.
            let sum = |sides: &[usize]| -> Linear {
                let lead = reduced(relations, (polygon.sides[sides[0]].turn.clone(), 0.0));
                let mut total = [0.0; 2];
                for &k in sides {
                    let (_, angle) = reduced(relations, (polygon.sides[k].turn.clone(), 0.0));
                    let v = rotated(polygon.sides[k].vector, angle - lead.1);
                    total = [total[0] + v[0], total[1] + v[1]];
                }
                (polygon.sides[sides[0]].turn.clone(), total[1].atan2(total[0]))
            };
            let (a, b) = (sum(one), sum(other));
            Some((a.0.iter().zip(&b.0).map(|(x, y)| x - y).collect(), PI + b.1 - a.1))
        }
    }
}

/// Adds an equation to the relations. Returns false if the equation gives no new relation for a passive variable. Fails if it
/// contradicts the relations, or relates coordinates to each other.
fn add(
    robot: &Robot,
    relations: &mut Vec<Relation>,
    equation: Option<Linear>,
    step: &EquationOrigin,
) -> Result<bool, String> {
    let Some((coefficients, constant)) = equation else { return Ok(false) };
    // The equation is `sum coefficient x = constant`. The substitution adds a constant on the left; this constant is moved to
    // the right-hand side.
    let (coefficients, moved) = reduced(relations, (coefficients, 0.0));
    let constant = constant - moved;
    let (EquationOrigin::Turn(l) | EquationOrigin::Opposite(l, ..)) = step;
    let n = robot.n_coordinates();
    let Some(pivot) =
        (n..coefficients.len()).rev().find(|&k| (coefficients[k].abs() - 1.0).abs() < COINCIDENCE_ROUNDING)
    else {
        if coefficients[n..].iter().any(|c| *c != 0.0) {
            return Ok(false);
        }
        let tied: Vec<&str> =
            (0..n).filter(|&k| coefficients[k] != 0.0).map(|k| robot.coordinates[k].name.as_str()).collect();
        if !tied.is_empty() {
            let message = format!(
                "loop {} ties the coordinates {} together: one of their joints must be passive",
                l + 1,
                tied.join(", ")
            );
            return Err(message);
        }
        let gap = wrapped(constant).abs();
        if gap > COINCIDENCE_ROUNDING {
            return Err(format!("loop {} cannot close: its ends stay {gap:.3e} rad apart", l + 1));
        }
        return Ok(false);
    };
    let sign = coefficients[pivot].signum();
    let coefficients: Vec<f64> = coefficients.iter().map(|c| sign * c).collect();
    let new = Relation { pivot, coefficients, constant: wrapped(sign * constant) };
    for old in relations.iter_mut() {
        let factor = old.coefficients[pivot];
        if factor != 0.0 {
            for (c, r) in old.coefficients.iter_mut().zip(&new.coefficients) {
                *c -= factor * r;
            }
            old.constant = wrapped(old.constant - factor * new.constant);
        }
    }
    relations.push(new);
    Ok(true)
}

/// A slope (change of an angle per change of a symbol) counts as an integer if it differs from the nearest integer by at most
/// this tolerance. Angles are accurate to 1e-15, so a slope over a step of 0.01 has an error of 1e-13. A slope that depends on
/// lengths is not that close to an integer.
const INTEGER_SLOPE_TOLERANCE: f64 = 1e-9;

/// The constants of the relations, each with a flag: whether it is an exact expression of the symbols. If not, it is a number
/// that holds only at the present values of the symbols.
fn exact_constants(robot: &Robot, steps: &[EquationOrigin], relations: &[Relation]) -> Vec<(Value, bool)> {
    let free = free_symbols(robot);
    // The constants of the relations, with each free symbol changed by its amount.
    let moved = |amounts: &dyn Fn(usize) -> f64| -> Option<Vec<f64>> {
        again(robot, &free, steps, amounts).map(|(_, relations)| relations.iter().map(|r| r.constant).collect())
    };
    let singly: Vec<Option<Vec<f64>>> =
        free.iter().map(|&s| moved(&|k| if k == s { SINGLE_SYMBOL_STEP } else { 0.0 })).collect();
    let all = moved(&together);
    let constant = |r: usize| -> (Value, bool) {
        let at = relations[r].constant;
        let inexact = (computed_angle(at), false);
        let (mut rest, mut expected) = (at, at);
        let mut terms: BTreeMap<usize, i64> = BTreeMap::new();
        for (&s, constants) in free.iter().zip(&singly) {
            let Some(constants) = constants else { return inexact };
            let slope = wrapped(constants[r] - at) / SINGLE_SYMBOL_STEP;
            if (slope - slope.round()).abs() > INTEGER_SLOPE_TOLERANCE {
                return inexact;
            }
            if slope.round() != 0.0 {
                terms.insert(s, slope.round() as i64);
                rest -= slope.round() * robot.symbols[s].value.number(&robot.symbols);
                expected += slope.round() * together(s);
            }
        }
        match &all {
            Some(constants) if wrapped(constants[r] - expected).abs() < COINCIDENCE_ROUNDING => {
                let mut sum = LinearAngle::default();
                terms.into_iter().for_each(|(s, m)| sum.add_symbol(SymbolId(s), m));
                sum.add(&computed_angle(wrapped(rest)), 1, &robot.symbols);
                (sum.value(), true)
            }
            _ => inexact,
        }
    };
    (0..relations.len()).map(constant).collect()
}

fn is_number(value: &Value) -> bool {
    !matches!(value, Value::Symbol(_) | Value::Coordinate(_)) && value.operands().all(is_number)
}

fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (s, c) = angle.sin_cos();
    [c * x - s * y, s * x + c * y]
}
