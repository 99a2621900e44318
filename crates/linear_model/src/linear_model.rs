//! The observation equation of one sample: tau_j = (Y(q, dq, ddq))_j X + friction_j + coupling_j.
//!
//! The parameters are the base parameters, then the friction of each joint, then the couplings of the transmission. W is the
//! observation matrix: one row per sample and joint, one column per parameter.
//!
//! tau is the measured torque after the removal of known scales s and known springs k of the transmission:
//!
//! ```text
//! tau_measured = s (tau + k q)        N m (N); s without unit, k N m/rad (N/m)
//! ```
//! Relative errors are relative to the measured torque, so the removal of a spring does not change them.

use std::ops::Range;

use generated::Eight;
use numerics::row_block::{BLOCK_ROWS, RowBlock};

use crate::coupling::{Coupled, Coupling, Instant};
use crate::friction::terms::{FrictionTerm, columns_before};
use crate::label::Label;
use crate::parameter::{Parameter, ParameterId};
use crate::regressor::Regressor;
use crate::row_layout::RowLayout;
use crate::states::States;

/// The model of a robot: dynamics, friction and couplings, all torques that are linear in their parameters.
pub struct Model<'a> {
    /// The base regressor Y of the dynamics.
    pub regressor: &'a dyn Regressor,
    /// The friction terms of the joints.
    pub friction: &'a [FrictionTerm],
    /// Motors that also turn with other joints than their own, and elements between joints.
    pub couplings: Vec<Coupling>,
    /// Known scale s of the torque of each coordinate. Empty if all are 1.
    pub scales: Vec<f64>,
    /// Known stiffness k of the spring of each coordinate, N m/rad (N/m). Empty if there is no spring.
    pub springs: Vec<f64>,
    /// The parameter of each column of W.
    pub parameters: Vec<Parameter>,
    /// The position of each entry of a sample in a block of rows.
    pub layout: RowLayout,
}

impl<'a> Model<'a> {
    /// Makes a model. The columns of W are in the order: base parameters, friction joint by joint, couplings.
    pub fn new(regressor: &'a dyn Regressor, friction: &'a [FrictionTerm], couplings: &[Coupling]) -> Model<'a> {
        let mut parameters: Vec<Parameter> = regressor.parameters().iter().map(Parameter::from).collect();
        for (j, coordinate) in regressor.coordinates().iter().enumerate() {
            let is_prismatic = regressor.is_prismatic(j);
            for &term in friction.iter().flat_map(|t| t.parameters_of(j)) {
                parameters.push(Parameter {
                    id: ParameterId::friction(term, coordinate),
                    coordinates: vec![j],
                    is_prismatic,
                });
            }
        }
        for coupling in couplings {
            let (name, coordinates) = match &coupling.of {
                Coupled::Motor(motor) => (&regressor.coordinates()[*motor], vec![*motor]),
                Coupled::Element(name, _) => (name, coupling.rows().collect()),
            };
            let label = Label::of_coordinate(name);
            let is_prismatic = coordinates.first().is_some_and(|&k| regressor.is_prismatic(k));
            for &parameter in coupling.parameters() {
                let id = ParameterId::Coupling(parameter, label.clone());
                parameters.push(Parameter { id, coordinates: coordinates.clone(), is_prismatic });
            }
        }
        let layout = RowLayout::new(regressor, friction, couplings);
        let (scales, springs) = (Vec::new(), Vec::new());
        Model { regressor, friction, couplings: couplings.to_vec(), scales, springs, parameters, layout }
    }

    /// Number n of coordinates.
    #[inline]
    pub fn n(&self) -> usize {
        self.regressor.coordinates().len()
    }

    /// Known scale s of the torque of coordinate j; 1 if no scale is known.
    pub fn scale(&self, j: usize) -> f64 {
        self.scales.get(j).copied().unwrap_or(1.0)
    }

    /// Known spring torque k q of coordinate j at sample r, N m (N); 0 without a spring.
    pub fn spring(&self, states: &States, r: usize, j: usize) -> f64 {
        self.springs.get(j).map_or(0.0, |stiffness| stiffness * states.q[r * states.n + j])
    }

    /// Number p of parameters.
    #[inline]
    pub fn p(&self) -> usize {
        self.parameters.len()
    }

    /// Dry friction of each joint at standstill, N m (N): the friction torque with the direction set to 1, minus the friction
    /// torque with the direction set to 0. `x`: values of all parameters.
    pub fn dry_friction(&self, x: &[f64]) -> Vec<f64> {
        let (n, base) = (self.n(), self.regressor.parameters().len());
        let still = |direction: f64| {
            let (t, used) = (vec![0.0], vec![true; n]);
            let mut states = States { n, t, used, direction: vec![direction; n], ..States::default() };
            for x in [&mut states.q, &mut states.dq, &mut states.ddq, &mut states.tau] {
                x.resize(n, 0.0);
            }
            states.motor_direction = vec![direction; self.couplings.len()];
            let mut torque = vec![0.0; n];
            self.rows(&states, 0..1, |_, rows| {
                for (torque, row) in torque.iter_mut().zip(rows.chunks_exact(x.len())) {
                    *torque = row.iter().zip(x).skip(base).map(|(y, x)| y * x).sum();
                }
            });
            torque
        };
        still(1.0).iter().zip(still(0.0)).map(|(with, without): (&f64, f64)| (with - without).abs()).collect()
    }

    /// Calls `take(r, rows)` for each sample r of `range`. `rows`: the n rows of W for this sample, n x p, row by row.
    pub fn rows(&self, states: &States, range: Range<usize>, mut take: impl FnMut(usize, &mut [f64])) {
        let (n, p, base) = (self.n(), self.p(), self.regressor.parameters().len());
        let mut w = vec![0.0; n * p];
        let filtered = states.filtered(self.friction);
        let together = SAMPLES_PER_PASS.min(range.len()).max(1);
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
                self.fill(states, &filtered, first + i, &y[i * n * base..][..n * base], &mut w);
                take(first + i, &mut w);
            }
        }
    }

    /// Writes the n rows of W for sample r into `w` (n x p). `y`: base regressor at this sample; `filtered`: for each friction
    /// term, the filtered columns, or `None` if the columns of the term are computed from the sample.
    #[inline]
    fn fill(&self, states: &States, filtered: &[Option<&[f64]>], r: usize, y: &[f64], w: &mut [f64]) {
        let (n, p, base) = (self.n(), self.p(), self.regressor.parameters().len());
        w.fill(0.0);
        let mut c = base;
        for j in 0..n {
            let row = &mut w[j * p..(j + 1) * p];
            row[..base].copy_from_slice(&y[j * base..(j + 1) * base]);
            for (term, filtered) in self.friction.iter().zip(filtered) {
                let width = term.parameters_of(j).len();
                row[c..c + width].copy_from_slice(&self.friction_at(states, *term, *filtered, r, j)[..width]);
                c += width;
            }
        }
        let mut first = base + columns_before(self.friction, n);
        for (i, coupling) in self.couplings.iter().enumerate() {
            let at = self.at(states, r, i);
            coupling.columns(&at, |row, column, entry| w[coupling.joints[row].0 * p + first + column] = entry);
            first += coupling.parameters().len();
        }
    }

    /// The state of all joints at sample r, and the direction of the motor or element of coupling i.
    #[inline]
    fn at<'s>(&self, states: &'s States, r: usize, i: usize) -> Instant<'s> {
        let n = self.n();
        let at = r * n..(r + 1) * n;
        let direction = states.motor_direction[r * self.couplings.len() + i];
        Instant { q: &states.q[at.clone()], dq: &states.dq[at.clone()], ddq: &states.ddq[at], direction }
    }

    /// Calls `take(r, block)` for each block of up to [`BLOCK_ROWS`] samples of `range`; r is the first sample of the block. Only
    /// entries that are not always zero are stored, at the positions of `layout`.
    ///
    /// The measured torques are among the entries. Rows of joints at standstill are filled like other rows.
    pub fn blocks(&self, states: &States, range: Range<usize>, mut take: impl FnMut(usize, &mut RowBlock)) {
        self.each_block(states, range, &mut take);
    }

    /// Implements [`Model::blocks`] without a generic parameter, so that the code is compiled once.
    fn each_block(&self, states: &States, range: Range<usize>, take: &mut dyn FnMut(usize, &mut RowBlock)) {
        let n = self.n();
        let filtered = states.filtered(self.friction);
        let mut block = RowBlock::new(self.layout.entries);
        let mut inputs = Vec::with_capacity(BLOCK_ROWS * 3 * n);
        for first in range.clone().step_by(BLOCK_ROWS) {
            block.rows = BLOCK_ROWS.min(range.end - first);
            inputs.clear();
            // If the number of samples is no multiple of eight, the last SIMD lanes repeat the last sample.
            for r in (first..first + block.groups() * 8).map(|r| r.min(range.end - 1)) {
                for x in [&states.q, &states.dq, &states.ddq] {
                    inputs.extend_from_slice(&x[r * n..(r + 1) * n]);
                }
            }
            let stride = block.stride();
            self.regressor.fill_blocks(&inputs, stride, block.numbers());
            for (g, r) in (first..first + block.rows).step_by(8).enumerate() {
                let group = block.group(g);
                let lanes = (range.end - r).min(8);
                self.fill_group(states, &filtered, r..r + lanes, group);
                for eight in &mut group[..self.layout.entries] {
                    eight.0[lanes..].fill(0.0);
                }
            }
            take(first, &mut block);
        }
    }

    /// Writes the friction columns, coupling columns and torques of up to eight samples into `group`, one sample per SIMD lane.
    fn fill_group(&self, states: &States, filtered: &[Option<&[f64]>], samples: Range<usize>, group: &mut [Eight]) {
        let n = self.n();
        let of_group = samples.start * n..samples.end * n;
        for (j, joint) in self.layout.joints.iter().enumerate() {
            let of_joint = |all: &[f64], entry: &mut Eight| {
                let all = all[of_group.clone()].iter().skip(j).step_by(n);
                entry.0.iter_mut().zip(all).for_each(|(entry, x)| *entry = *x);
            };
            let mut place = joint.friction;
            for (term, filtered) in self.friction.iter().zip(filtered) {
                let width = term.parameters_of(j).len();
                let entries = &mut group[place..place + width];
                place += width;
                match (term, filtered, &mut *entries) {
                    // The columns of the standard terms are copied directly, because this is faster.
                    (FrictionTerm::Viscous, None, [entry]) => of_joint(&states.dq, entry),
                    (FrictionTerm::Coulomb, None, [entry]) => of_joint(&states.direction, entry),
                    (FrictionTerm::Offset, None, [entry]) => entry.0[..samples.len()].fill(1.0),
                    _ => {
                        for (lane, r) in samples.clone().enumerate() {
                            let columns = self.friction_at(states, *term, *filtered, r, j);
                            entries.iter_mut().zip(columns).for_each(|(entry, x)| entry.0[lane] = x);
                        }
                    }
                }
            }
            of_joint(&states.tau, &mut group[joint.torque_place()]);
        }
        for (i, (coupling, places)) in self.couplings.iter().zip(&self.layout.couplings).enumerate() {
            for (lane, r) in samples.clone().enumerate() {
                let at = self.at(states, r, i);
                coupling.columns(&at, |row, column, entry| group[places[row] + column].0[lane] = entry);
            }
        }
    }

    /// The entries of a friction term of joint j at sample r. A term has at most four columns.
    #[inline]
    fn friction_at(
        &self,
        states: &States,
        term: FrictionTerm,
        filtered: Option<&[f64]>,
        r: usize,
        j: usize,
    ) -> [f64; 4] {
        let (mut columns, width, at) = ([0.0; 4], term.parameters_of(j).len(), r * self.n() + j);
        match filtered {
            Some(all) => columns[..width].copy_from_slice(&all[at * width..][..width]),
            None => {
                let torque = states.torque_of_friction(term, r, j).unwrap_or(states.tau[at]);
                let (dq, ddq, direction) = (states.dq[at], states.ddq[at], states.direction[at]);
                term.fill(dq, ddq, torque, direction, &mut columns[..width]);
            }
        }
        columns
    }

    /// Residuals tau - W x of eight rows of joint j, N m (N). `group`: the entries of eight samples.
    #[inline]
    pub fn residual(&self, group: &[Eight], j: usize, x: &[f64]) -> [f64; 8] {
        let joint = &self.layout.joints[j];
        let mut residual = group[joint.torque_place()].0;
        for (&column, &place) in joint.columns.iter().zip(&joint.places) {
            let (entry, x) = (&group[place].0, x[column]);
            for lane in 0..8 {
                residual[lane] -= entry[lane] * x;
            }
        }
        residual
    }

    /// Calls `take(r, j, residual)` for each used row: sample r, joint j, residual tau - W x, N m (N).
    pub fn residuals(&self, states: &States, x: &[f64], mut take: impl FnMut(usize, usize, f64)) {
        let n = self.n();
        self.residual_groups(states, 0..states.len(), x, |group| {
            for (lane, r) in group.samples.clone().enumerate() {
                for j in (0..n).filter(|&j| states.used[r * n + j]) {
                    take(r, j, group.residuals[j][lane]);
                }
            }
        });
    }

    /// Calls `take` with the rows of the samples in `range` and their residuals tau - W x, eight samples at a time.
    pub fn residual_groups(
        &self,
        states: &States,
        range: Range<usize>,
        x: &[f64],
        mut take: impl FnMut(&ResidualGroup),
    ) {
        self.each_residual_group(states, range, x, &mut take);
    }

    /// Implements [`Model::residual_groups`] without a generic parameter, so that the code is compiled once.
    fn each_residual_group(
        &self,
        states: &States,
        range: Range<usize>,
        x: &[f64],
        take: &mut dyn FnMut(&ResidualGroup),
    ) {
        let mut residuals = vec![[0.0; 8]; self.n()];
        self.blocks(states, range, |first, block| {
            let end = first + block.rows;
            for (g, r) in (first..end).step_by(8).enumerate() {
                let entries = &*block.group(g);
                residuals.iter_mut().enumerate().for_each(|(j, e)| *e = self.residual(entries, j, x));
                take(&ResidualGroup { states, samples: r..end.min(r + 8), entries, residuals: &residuals });
            }
        });
    }
}

/// The rows and residuals of up to eight samples.
pub struct ResidualGroup<'a> {
    /// The states of the record.
    pub states: &'a States,
    /// Indices of the samples. The samples are in the SIMD lanes in this order, one per lane.
    pub samples: Range<usize>,
    /// The entries of the rows, at the positions of the layout of the model.
    pub entries: &'a [Eight],
    /// Residuals tau - W x of each joint for each sample, N m (N). Unused rows have residuals too.
    pub residuals: &'a [[f64; 8]],
}

/// Number of samples for which the regressor is computed in one call: eight groups of eight SIMD lanes.
const SAMPLES_PER_PASS: usize = 64;
