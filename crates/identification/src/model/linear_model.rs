//! The observation equation of one instant: tau_j = (Y(q, dq, ddq))_j X + friction_j + coupling_j.
//!
//! The parameters are those of the regressor, then the friction of each joint, then the couplings of the transmission.

use std::ops::Range;

use crate::algebra::vector::dot;
use crate::model::coupling::Coupling;
use crate::model::friction::terms::FrictionTerm;
use crate::model::label::Label;
use crate::model::parameter::{CouplingParameter, Parameter, ParameterId};
use crate::model::regressor::Regressor;
use crate::model::states::States;

/// Dynamics, friction and couplings together: everything that is linear in its parameters.
pub struct Model<'a> {
    /// The base regressor.
    pub regressor: &'a dyn Regressor,
    /// Friction columns of every joint.
    pub friction: &'a [FrictionTerm],
    /// Motors that turn with a joint beside their own.
    pub couplings: &'a [Coupling],
    /// In the order of the columns.
    pub parameters: Vec<Parameter>,
}

impl<'a> Model<'a> {
    /// The columns in their order: base parameters, friction joint by joint, couplings.
    pub fn new(regressor: &'a dyn Regressor, friction: &'a [FrictionTerm], couplings: &'a [Coupling]) -> Model<'a> {
        let mut parameters: Vec<Parameter> = regressor.parameters().iter().map(Parameter::from).collect();
        for (j, coordinate) in regressor.coordinates().iter().enumerate() {
            let is_prismatic = regressor.is_prismatic(j);
            for &term in friction.iter().flat_map(|t| t.parameters()) {
                parameters.push(Parameter {
                    id: ParameterId::friction(term, coordinate),
                    coordinates: vec![j],
                    is_prismatic,
                });
            }
        }
        for coupling in couplings {
            let motor = coupling.motor;
            let label = Label::of_coordinate(&regressor.coordinates()[motor]);
            for parameter in CouplingParameter::ALL {
                let id = ParameterId::Coupling(parameter, label.clone());
                let is_prismatic = regressor.is_prismatic(motor);
                parameters.push(Parameter { id, coordinates: vec![motor], is_prismatic });
            }
        }
        Model { regressor, friction, couplings, parameters }
    }

    /// Number of coordinates.
    pub fn n(&self) -> usize {
        self.regressor.coordinates().len()
    }

    /// Number of parameters.
    pub fn p(&self) -> usize {
        self.parameters.len()
    }

    /// The n x p rows of the samples of a range, in turn: `take(r, rows)`, row by row.
    pub fn rows(&self, states: &States, range: Range<usize>, mut take: impl FnMut(usize, &mut [f64])) {
        let (n, p, base) = (self.n(), self.p(), self.regressor.parameters().len());
        let mut w = vec![0.0; n * p];
        let together = TOGETHER.min(range.len()).max(1);
        let mut inputs = vec![0.0; together * 3 * n];
        let mut y = vec![0.0; together * n * base];
        for first in range.clone().step_by(together) {
            let count = together.min(range.end - first);
            for (input, r) in inputs.chunks_exact_mut(3 * n).zip(first..first + count) {
                input[..n].copy_from_slice(&states.q[r * n..][..n]);
                input[n..2 * n].copy_from_slice(&states.dq[r * n..][..n]);
                input[2 * n..].copy_from_slice(&states.ddq[r * n..][..n]);
            }
            self.regressor.fill_many(&inputs[..count * 3 * n], &mut y[..count * n * base]);
            for i in 0..count {
                self.fill(states, first + i, &y[i * n * base..][..n * base], &mut w);
                take(first + i, &mut w);
            }
        }
    }

    /// The rows of sample r from its regressor `y`.
    fn fill(&self, states: &States, r: usize, y: &[f64], w: &mut [f64]) {
        let (n, p, base) = (self.n(), self.p(), self.regressor.parameters().len());
        let at = r * n..(r + 1) * n;
        let (dq, ddq) = (&states.dq[at.clone()], &states.ddq[at.clone()]);
        let (tau, direction) = (&states.tau[at.clone()], &states.direction[at]);
        w.fill(0.0);
        let per_joint: usize = self.friction.iter().map(|t| t.parameters().len()).sum();
        for j in 0..n {
            let row = &mut w[j * p..(j + 1) * p];
            row[..base].copy_from_slice(&y[j * base..(j + 1) * base]);
            let mut c = base + j * per_joint;
            for term in self.friction {
                let width = term.parameters().len();
                term.fill(dq[j], ddq[j], tau[j], direction[j], &mut row[c..c + width]);
                c += width;
            }
        }
        for (i, coupling) in self.couplings.iter().enumerate() {
            let motor = states.motor_direction[r * self.couplings.len() + i];
            coupling.fill(dq, ddq, motor, w, p, base + n * per_joint + i * CouplingParameter::ALL.len());
        }
    }

    /// tau - W x of the used rows of a range, in turn: `take(r, j, residual)`.
    pub fn residuals(&self, states: &States, x: &[f64], mut take: impl FnMut(usize, usize, f64)) {
        let (n, p) = (self.n(), self.p());
        self.rows(states, 0..states.len(), |r, w| {
            for j in (0..n).filter(|&j| states.used[r * n + j]) {
                take(r, j, states.tau[r * n + j] - dot(&w[j * p..(j + 1) * p], x));
            }
        });
    }
}

/// Samples whose regressors are computed together: eight for each lane of the widest processor.
const TOGETHER: usize = 64;
