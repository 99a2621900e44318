//! Linear relations between joint variables, which follow from closed loops, and their substitution into equations and joints.

use std::collections::BTreeMap;

use crate::linear_angle::LinearAngle;
use crate::polygon::COINCIDENCE_ROUNDING;
use crate::robot::{JointKind, ModifiedDh, Note, Robot};
use crate::value::{Affine, CoordinateId, Symbol, Value};

/// A linear relation that gives the variable with index `pivot`: x_pivot = constant - sum of (coefficient times variable) over
/// the other variables.
#[derive(Clone, Debug)]
pub(crate) struct Relation {
    pub pivot: usize,
    pub coefficients: Vec<f64>,
    pub constant: f64,
}

/// A linear expression for an equation or an angle: one coefficient for each variable, and a constant.
pub(crate) type Linear = (Vec<f64>, f64);

/// Substitutes the relations into a linear expression.
pub(crate) fn reduced(relations: &[Relation], (mut coefficients, mut constant): Linear) -> Linear {
    for relation in relations {
        let factor = coefficients[relation.pivot];
        if factor != 0.0 {
            for (c, r) in coefficients.iter_mut().zip(&relation.coefficients) {
                *c -= factor * r;
            }
            constant += factor * relation.constant;
        }
    }
    for c in &mut coefficients {
        if c.abs() < COINCIDENCE_ROUNDING {
            *c = 0.0;
        }
    }
    (coefficients, constant)
}

/// Substitutes the relations into the joints of a robot, and renumbers the passive coordinates that remain.
pub(crate) fn apply(robot: &mut Robot, relations: &[Relation], constants: &[(Value, bool)]) {
    let n = robot.n_coordinates();
    let total = robot.n_variables();
    // A passive variable without a relation stays. The passive variables that stay are renumbered.
    let remains: Vec<usize> = (n..total).filter(|k| relations.iter().all(|r| r.pivot != *k)).collect();
    let place = |k: usize| if k < n { k } else { n + remains.iter().position(|&r| r == k).unwrap_or_default() };
    let solution = |k: usize| -> (Affine, bool) {
        let Some(r) = relations.iter().position(|r| r.pivot == k) else {
            return (Affine::coordinate(CoordinateId(place(k))), true);
        };
        let others = (0..total).filter(|&i| i != k && relations[r].coefficients[i] != 0.0);
        let terms = others.map(|i| (CoordinateId(place(i)), -relations[r].coefficients[i])).collect();
        (Affine { terms, offset: constants[r].0.clone() }, constants[r].1)
    };
    let solutions: Vec<(Affine, bool)> = (0..total).map(solution).collect();

    // Adds a note for the user about each passive variable.
    let names: Vec<String> = (0..total).map(|k| robot.coordinate_name(CoordinateId(k)).to_string()).collect();
    let new_name = |k: CoordinateId| if k.0 < n { names[k.0].clone() } else { names[remains[k.0 - n]].clone() };
    for k in n..total {
        let (affine, exact) = &solutions[k];
        let text = if remains.contains(&k) {
            "follows from no affine relation: it is a passive coordinate, found numerically".to_string()
        } else {
            let how = if *exact { "" } else { ", a constant that holds at these lengths only" };
            format!("= {} by the loops{how}", affine.text(&Value::ZERO, &robot.symbols, &new_name))
        };
        robot.notes.push(Note { subject: names[k].clone(), text });
    }

    // The relations are substituted into the variables of all joints and loop frames.
    let symbols = robot.symbols.clone();
    let put_in = |geometry: &mut ModifiedDh, kind: JointKind, variable: &mut Affine| {
        substitute(&solutions, &symbols, geometry, kind, variable);
    };
    for link in &mut robot.links {
        put_in(&mut link.geometry, link.joint.kind, &mut link.joint.variable);
    }
    for one in &mut robot.loops {
        for frame in [&mut one.cut, &mut one.twin] {
            put_in(&mut frame.geometry, frame.kind, &mut frame.variable);
        }
    }
    robot.passive = remains.iter().map(|&k| robot.passive[k - n].clone()).collect();
}

/// Replaces the variables in a joint variable by their solutions. The linear terms stay in the joint variable. The constants
/// are added to theta (or r) of the geometry.
fn substitute(
    solutions: &[(Affine, bool)],
    symbols: &[Symbol],
    geometry: &mut ModifiedDh,
    kind: JointKind,
    variable: &mut Affine,
) {
    let mut coefficients: BTreeMap<CoordinateId, f64> = BTreeMap::new();
    for &(k, c) in &variable.terms {
        let solved = &solutions[k.0].0;
        for &(i, x) in &solved.terms {
            *coefficients.entry(i).or_default() += c * x;
        }
        if solved.offset != Value::ZERO {
            let slot = if kind == JointKind::Prismatic { &mut geometry.r } else { &mut geometry.theta };
            *slot = if c.fract() == 0.0 && kind == JointKind::Revolute {
                let mut sum = LinearAngle::default();
                sum.add(slot, 1, symbols);
                sum.add(&solved.offset, c as i64, symbols);
                sum.value()
            } else {
                let product = Value::Mul(Box::new(Value::Number(c)), Box::new(solved.offset.clone()));
                Value::Add(Box::new(slot.clone()), Box::new(product))
            };
        }
    }
    variable.terms = coefficients.into_iter().filter(|t| t.1.abs() > COINCIDENCE_ROUNDING).collect();
}
