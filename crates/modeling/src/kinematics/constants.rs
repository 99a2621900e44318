//! The robot's lengths and angles as expressions: zeros and quarter turns are exact numbers, all others are named constants.
//!
//! A symbol of the robot is a named constant of the expression graph. A length or an angle that is given as a number is a named
//! constant too; its name is its place in the robot's file (`d3`, `r4`, `alpha5`). Equal numbers at several places share one
//! constant of the graph. In the regrouping rule of a link, this constant has the name of its place at this link
//! ([`Constants::places`]). The value of a symbol matters only if it is exactly zero or an exact multiple of pi/2: then this
//! number replaces the symbol.

use std::collections::BTreeMap;

use expr::{Expr, Graph, Node, SymbolKind};
use robot::{Robot, SymbolId, Value};

use crate::kinematics::angle::Angle;
use crate::kinematics::vector::Vector;

/// Creates the named constants of a robot in an expression graph. Each constant is created only once.
pub(crate) struct Constants<'a> {
    robot: &'a Robot,
    symbols: Vec<Option<Expr>>,
    numbers: Vec<Number>,
}

/// A length or an angle that the robot's file gives as a number.
struct Number {
    kind: ConstantKind,
    magnitude: f64,
    /// The named constant in the expression graph for the magnitude of this number.
    constant: Expr,
    /// The places in the file that use this number: `d3`, `d7`.
    places: Vec<String>,
}

/// Whether two positive numbers are equal within rounding. This program computes some angles of loops from angles of the file,
/// which adds rounding errors.
fn is_one(a: f64, b: f64) -> bool {
    (a - b).abs() <= 4.0 * f64::EPSILON * a
}

/// The kind of a number: a length in m and an angle in rad with equal values are different constants.
#[derive(Clone, Copy, PartialEq)]
enum ConstantKind {
    Length,
    Angle,
}

impl<'a> Constants<'a> {
    pub(crate) fn new(robot: &'a Robot) -> Constants<'a> {
        Constants { robot, symbols: vec![None; robot.symbols.len()], numbers: Vec::new() }
    }

    /// Minus gravity in the base frame, m/s^2, as expressions: the apparent acceleration of the base.
    pub(crate) fn weight(&mut self, g: &mut Graph) -> Vector {
        [(0, "gx"), (1, "gy"), (2, "gz")].map(|(i, name)| -self.length(g, &self.robot.gravity[i], name))
    }

    /// The expression of a length, m. A number without a name gets the name `place`, such as `d3`.
    pub(crate) fn length(&mut self, g: &mut Graph, value: &Value, place: &str) -> Expr {
        match value {
            Value::Number(x) => self.number(g, ConstantKind::Length, *x, place),
            Value::Neg(a) => -self.length(g, a, place),
            _ => self.expression(g, value),
        }
    }

    fn number(&mut self, g: &mut Graph, kind: ConstantKind, x: f64, place: &str) -> Expr {
        if x == 0.0 {
            return Expr::ZERO;
        }
        let mut name = place.to_string();
        while self.robot.symbols.iter().any(|s| s.name == name) {
            name.push('_');
        }
        let constant = match self.numbers.iter_mut().find(|n| n.kind == kind && is_one(n.magnitude, x.abs())) {
            Some(number) => {
                if !number.places.contains(&name) {
                    number.places.push(name);
                }
                number.constant
            }
            None => {
                let constant = g.symbol(&name, SymbolKind::Constant(x.abs()));
                self.numbers.push(Number { kind, magnitude: x.abs(), constant, places: vec![name] });
                constant
            }
        };
        if x < 0.0 { -constant } else { constant }
    }

    /// The constants that occur at several places in the robot's file: name in the expression graph -> names of the places,
    /// such as `d3` -> `d3`, `d7`.
    pub(crate) fn places(&self, g: &Graph) -> BTreeMap<String, Vec<String>> {
        let several = self.numbers.iter().filter(|n| n.places.len() > 1);
        several
            .filter_map(|n| match g.node(n.constant) {
                Node::Symbol(s) => Some((g.symbols()[s.0 as usize].0.clone(), n.places.clone())),
                _ => None,
            })
            .collect()
    }

    fn symbol(&mut self, g: &mut Graph, s: SymbolId) -> Expr {
        if let Some(e) = self.symbols[s.0] {
            return e;
        }
        let symbol = &self.robot.symbols[s.0];
        let x = symbol.value.number(&self.robot.symbols);
        // A symbol that is defined by other symbols is replaced by its definition. A symbol defined by a number is a named
        // constant.
        let e = if x == 0.0 {
            Expr::ZERO
        } else if symbol.value.has_symbol() {
            self.expression(g, &symbol.value)
        } else {
            g.symbol(&symbol.name, SymbolKind::Constant(x))
        };
        self.symbols[s.0] = Some(e);
        e
    }

    fn expression(&mut self, g: &mut Graph, value: &Value) -> Expr {
        match value {
            Value::Number(x) => g.constant(*x),
            Value::Pi => g.constant(std::f64::consts::PI),
            Value::Symbol(s) => self.symbol(g, *s),
            Value::Coordinate(_) => unreachable!("a length of the geometry is free of coordinates"),
            Value::Neg(a) => -self.expression(g, a),
            Value::Add(a, b) => {
                let (a, b) = (self.expression(g, a), self.expression(g, b));
                g.add(a, b)
            }
            Value::Sub(a, b) => {
                let (a, b) = (self.expression(g, a), self.expression(g, b));
                g.sub(a, b)
            }
            Value::Mul(a, b) => {
                let (a, b) = (self.expression(g, a), self.expression(g, b));
                g.mul(a, b)
            }
            Value::Div(a, b) => {
                let (a, b) = (self.expression(g, a), self.expression(g, b));
                g.div(a, b)
            }
            Value::Sqrt(a) => {
                let a = self.expression(g, a);
                g.sqrt(a)
            }
            Value::Sin(a) => {
                let angle = self.angle(g, a, "angle");
                angle.turn(g).sin
            }
            Value::Cos(a) => {
                let angle = self.angle(g, a, "angle");
                angle.turn(g).cos
            }
            // The inverse tangent becomes a named constant, because the expression graph has no such function.
            Value::Atan2(..) => self.number(g, ConstantKind::Angle, value.number(&self.robot.symbols), "atan"),
        }
    }

    /// An angle, rad, as a combination of symbols and quarter turns. A number without a name gets the name `place`, such as
    /// `alpha5`.
    pub(crate) fn angle(&mut self, g: &mut Graph, value: &Value, place: &str) -> Angle {
        if let Some((n, d)) = value.as_multiple_of_pi(&self.robot.symbols)
            && (2 * n) % d == 0
        {
            return Angle { quarter_turns: 2 * n / d, terms: Vec::new() };
        }
        match value {
            Value::Neg(a) => self.angle(g, a, place).negated(),
            Value::Add(a, b) => self.angle(g, a, place).plus(&self.angle(g, b, place)),
            Value::Sub(a, b) => self.angle(g, a, place).plus(&self.angle(g, b, place).negated()),
            Value::Mul(a, b) if integer(a).is_some() => self.angle(g, b, place).times(integer(a).unwrap_or(0)),
            Value::Mul(a, b) if integer(b).is_some() => self.angle(g, a, place).times(integer(b).unwrap_or(0)),
            Value::Symbol(s) if self.robot.symbols[s.0].value.has_symbol() => {
                self.angle(g, &self.robot.symbols[s.0].value.clone(), place)
            }
            Value::Symbol(s) => {
                let symbol = self.symbol(g, *s);
                Angle { quarter_turns: 0, terms: vec![(symbol, 1)] }
            }
            // Any other angle becomes a named constant, with the name of its place in the file (`alpha5`).
            _ => {
                let symbol = self.number(g, ConstantKind::Angle, value.number(&self.robot.symbols), place);
                let sign = if symbol.is_negative() { -1 } else { 1 };
                Angle { quarter_turns: 0, terms: vec![(symbol.abs(), sign)] }
            }
        }
    }
}

fn integer(value: &Value) -> Option<i64> {
    match value {
        Value::Number(x) if x.fract() == 0.0 && x.abs() < 64.0 => Some(*x as i64),
        _ => None,
    }
}
