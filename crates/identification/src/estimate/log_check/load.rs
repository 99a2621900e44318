//! Finds a load that the robot picks up or puts down during a log, or that the robot description does not contain.
//!
//! ```text
//! tau = W X + s(t) W B_L phi_L
//! ```
//! W: rows of the model; X: its parameters; s(t): 1 while the robot carries the load, otherwise 0; phi_L: the ten parameters
//! of the load on link L; B_L: the ten columns of the map from standard to base parameters of this link
//! ([`crate::estimators::payload`]). The equation is solved for X and phi_L by normal equations, for many intervals with s =
//! 1.
//!
//! The load is reported if the fit with the load has a relative error below `NAMED_ERROR_RATIO` times the error without the
//! load. No other fault is explained so well by the ten columns of a load during an interval. To test a load that the robot
//! carries during the whole log, X has the nominal values, and only friction and the load are fitted.

use linear_model::linear_model::Model;
use linear_model::standard_map::StandardMap;
use logs::Error;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::estimate::digits::percent;
use crate::estimate::hypothesis::OF_OPTIONS;
use crate::estimate::log_check::LogCheck;
use crate::estimate::log_check::finding::{Fault, Finding};
use crate::signals::records::Records;
use crate::signals::thinned::MOST_THINNED_SAMPLES;

/// No load is searched if the relative error without a load is below this value.
const SMALL_ERROR: f64 = 0.02;
/// A load is reported only if it multiplies the relative error by at most this factor. So a drift of the torque is not reported
/// as a load: a load that is fitted to a drift only halves the error.
const NAMED_ERROR_RATIO: f64 = 1.0 / 3.0;
/// No constant load is searched if the relative error of the description (with fitted friction) is below this value, because
/// wrong nominal bodies explain such an error.
const NOMINAL_ERROR: f64 = 0.3;
/// A load explains the error of the description only if the relative error with the load is below this value. Otherwise the
/// nominal bodies are wrong, or the log belongs to another robot.
const DESCRIBED_ERROR: f64 = 0.1;
/// Largest accepted distance of the centre of mass of a load from the frame of its link, m. A load must also exceed the
/// nominal mass of the link. Otherwise the error is attributed to the nominal bodies.
const LARGEST_CENTRE_M: f64 = 0.5;
/// Number of blocks into which all logs together are divided. A load can change only between two blocks.
const LOAD_BLOCKS: usize = 100;
/// Largest number of entries of the normal matrices of all blocks. This number limits the number of blocks; with about 800
/// parameters there are too few blocks for the search.
const MOST_MATRIX_ENTRIES: usize = 4_000_000;
/// Least number of blocks of an interval with a load.
const LEAST_LOAD_BLOCKS: usize = 3;
/// Step, in blocks, of the coarse search for the start and the end of a load.
const COARSE_BLOCK_STEP: usize = 5;
/// Ridge on the unit diagonal of the scaled normal matrix. The ridge keeps undetermined parameters at zero.
const RELATIVE_RIDGE: f64 = 1e-10;
/// The mass of a load is significant if it exceeds this many standard deviations.
const SIGNIFICANT_MASS_SIGMAS: f64 = 3.0;
/// Number of parameters of a body: six inertias, three first moments, mass.
const BODY_PARAMETERS: usize = 10;
/// Index of the mass among the ten parameters of a body; the three first moments are directly before it.
const MASS_INDEX: usize = 9;

impl LogCheck {
    /// Finds a load that changes during the log. If no load changes and no other fault was identified, finds a constant load
    /// that the description does not contain. A load replaces findings without an identified cause. `described`: nominal base
    /// parameters; `bodies`: for each body of the map that may carry a load, its index and nominal mass, kg.
    ///
    /// Fails if a record cannot be read.
    pub fn look_for_load<R: Records + ?Sized>(
        &mut self,
        model: &Model,
        records: &R,
        (map, described): (&StandardMap, Option<&[f64]>),
        bodies: &[(usize, f64)],
    ) -> Result<(), Error> {
        let is_unidentified = |finding: &Finding| matches!(finding.fault, Fault::OtherRobot | Fault::Unidentified);
        let Some(sums) = Sums::of(model, records)? else { return Ok(()) };
        let described = described.filter(|_| self.findings.iter().all(is_unidentified));
        let changed = sums.changed_load(map, bodies);
        self.load = changed.is_none().then(|| sums.other_load(described?, map, bodies)).flatten();
        if changed.is_some() || self.load.is_some() {
            self.findings.retain(|finding| !is_unidentified(finding));
            self.findings.extend(changed);
        }
        Ok(())
    }

    /// Whether the log check found a load that changes during the log.
    pub fn has_changed_load(&self) -> bool {
        self.findings.iter().any(|finding| matches!(finding.fault, Fault::ChangedLoad { .. }))
    }
}

/// Makes the finding of a load on a link. `errors`: relative errors of the fit [without the load, with the load].
fn finding(fault: Fault, link: &str, what: &str, errors: [f64; 2], remedy: &str) -> Finding {
    let [before, after] = errors.map(percent);
    let evidence = format!("the residual of {what} is {before}, with a body of its own for it {after}");
    let squares = Some(errors.map(|error| error * error));
    Finding { tried: squares, ..Finding::of(fault, vec![link.into()], evidence, remedy) }
}

/// Products [W tau]' [W tau] of the weighted rows W and torques tau. `all`: summed over all rows; `records`: summed over the
/// blocks of each record.
struct Sums {
    base: usize,
    rows: usize,
    all: DMatrix<f64>,
    records: Vec<Record>,
}

/// Products [W tau]' [W tau] of one record, summed over its blocks.
struct Record {
    /// Number of the log of the record, from 0.
    log: usize,
    /// Start time of each block and, last, the end time of the last block, s.
    times: Vec<f64>,
    /// Entry b: sum of the products of all blocks before block b. The last entry is the sum of all blocks.
    before: Vec<DMatrix<f64>>,
}

/// A load that was fitted to a log.
struct SolvedLoad {
    /// Relative residual |residual| / |tau| with the load.
    error: f64,
    /// Mass of the load, kg; `None` if not significant.
    mass: Option<f64>,
    /// Distance of the centre of mass of the load from the frame of its link, m.
    centre: f64,
}

impl Sums {
    /// Sums the products [W tau]' [W tau] over all records; `None` if there are too many parameters.
    fn of<R: Records + ?Sized>(model: &Model, records: &R) -> Result<Option<Sums>, Error> {
        let (n, p) = (model.n(), model.p());
        let thinned = records.thinned(MOST_THINNED_SAMPLES)?;
        // The rows of each joint are weighted by 1 / |torque|.
        let mut squares = vec![0.0; n];
        for tau in thinned.records.iter().flat_map(|(_, states)| states.tau.chunks_exact(n)) {
            squares.iter_mut().zip(tau).for_each(|(square, tau)| *square += tau * tau);
        }
        let weights: Vec<f64> = squares.iter().map(|s| if *s > 0.0 { s.sqrt().recip() } else { 0.0 }).collect();
        let samples: usize = thinned.records.iter().map(|(_, states)| states.len()).sum();
        let parts = LOAD_BLOCKS.min(MOST_MATRIX_ENTRIES / ((p + 1) * (p + 1)));
        if parts < 2 * LEAST_LOAD_BLOCKS {
            return Ok(None);
        }
        let part = samples.div_ceil(parts).max(1);
        let mut sums = Sums {
            base: model.regressor.parameters().len(),
            rows: n * samples,
            all: DMatrix::zeros(p + 1, p + 1),
            records: Vec::new(),
        };
        for (_, states) in &thinned.records {
            let mut total = DMatrix::zeros(p + 1, p + 1);
            let mut record = Record { log: states.log, times: Vec::new(), before: Vec::new() };
            let mut rows = DMatrix::zeros(n * part, p + 1);
            for first in (0..states.len()).step_by(part) {
                record.times.push(states.t[first]);
                record.before.push(total.clone());
                rows.fill(0.0);
                model.rows(states, first..states.len().min(first + part), |r, w| {
                    for (j, weight) in weights.iter().enumerate() {
                        let row = (r - first) * n + j;
                        (0..p).for_each(|c| rows[(row, c)] = weight * w[j * p + c]);
                        rows[(row, p)] = weight * states.tau[r * n + j];
                    }
                });
                total += rows.tr_mul(&rows);
            }
            record.times.extend(states.t.last());
            record.before.push(total.clone());
            sums.all += total;
            sums.records.push(record);
        }
        Ok(Some(sums))
    }

    fn changed_load(&self, map: &StandardMap, bodies: &[(usize, f64)]) -> Option<Finding> {
        let (p, parameters) = (self.all.ncols() - 1, self.parameters()?);
        let without = parameters.error();
        if without < SMALL_ERROR {
            return None;
        }
        let (mut least, mut best) = (NAMED_ERROR_RATIO * without, None);
        for (link, first) in bodies.iter().map(|(body, _)| &map.bodies[*body]) {
            let load = map.matrix.columns(*first, BODY_PARAMETERS).into_owned();
            for record in &self.records {
                let during = |from: usize, to: usize| {
                    let beside = Sums::products_with_load(&(&record.before[to] - &record.before[from]), &load);
                    let own = load.tr_mul(&beside.rows(0, self.base));
                    parameters.with(&beside, &own, beside.row(p).transpose())
                };
                let Some((from, to, found)) = record.carried(during).filter(|found| found.2.error < least) else {
                    continue;
                };
                least = found.error;
                let time = |part: usize| (part > 0 && part < record.parts()).then(|| record.times[part]);
                let log = self.records.iter().any(|other| other.log != record.log).then_some(record.log + 1);
                let fault = Fault::ChangedLoad { log, from: time(from), to: time(to), mass: found.mass };
                best = Some((fault, link, record.longest_constant_interval(from, to)));
            }
        }
        let (fault, link, (from, to)) = best?;
        let remedy = match self.records.as_slice() {
            // A time window is proposed as remedy only if a fit to the rows inside this window also has a small error.
            [record] if self.within(record, from, to).is_some_and(|error| error < NAMED_ERROR_RATIO * without) => {
                let [from, to] = [from, to].map(|part| record.times[part]);
                format!("{OF_OPTIONS} signal: {{window: {{seconds: [{from:.2}, {to:.2}]}}}}")
            }
            _ => "log each load by itself, and give the log of the second as [loaded]".into(),
        };
        Some(finding(fault, link, "one set of parameters", [without, least], &remedy))
    }

    fn other_load(&self, described: &[f64], map: &StandardMap, bodies: &[(usize, f64)]) -> Option<Finding> {
        let described = DVector::from_column_slice(described);
        let friction = self.friction(&described)?;
        let without = friction.error();
        if without < NOMINAL_ERROR {
            return None;
        }
        let (p, of_rest) = (self.all.ncols() - 1, self.of_rest(&described));
        let one = |(body, described_mass): &(usize, f64)| {
            let (link, first) = &map.bodies[*body];
            let load = map.matrix.columns(*first, BODY_PARAMETERS).into_owned();
            let beside = Sums::products_with_load(&self.all, &load);
            let own = load.tr_mul(&beside.rows(0, self.base));
            let of_friction = beside.rows(self.base, p - self.base).into_owned();
            let right = load.tr_mul(&of_rest.rows(0, self.base));
            Some((link, *described_mass, friction.with(&of_friction, &own, right)?))
        };
        let all = bodies.iter().filter_map(one).filter(|(_, described_mass, found)| {
            let is_body = found.mass.is_some_and(|mass| mass > *described_mass) && found.centre < LARGEST_CENTRE_M;
            is_body && found.error < DESCRIBED_ERROR.min(NAMED_ERROR_RATIO * without)
        });
        let (link, _, found) = all.min_by(|a, b| a.2.error.total_cmp(&b.2.error))?;
        let remedy = "is part of the parameters";
        let fault = Fault::OtherLoad(found.mass);
        Some(finding(fault, link, "the description", [without, found.error], remedy))
    }

    /// Products [W tau]' W B_L with the columns W B_L of a load. `rows`: products [W tau]' [W tau] of the same rows; `load`:
    /// B_L, ten columns of the map from standard to base parameters.
    fn products_with_load(rows: &DMatrix<f64>, load: &DMatrix<f64>) -> DMatrix<f64> {
        rows.columns(0, load.nrows()) * load
    }

    /// Relative residual of a fit, without a load, to the rows of the blocks from `from` to `to` of a record.
    fn within(&self, record: &Record, from: usize, to: usize) -> Option<f64> {
        let all = &record.before[to] - &record.before[from];
        Sums { all, records: Vec::new(), ..*self }.parameters().map(|found| found.error())
    }

    /// Fits all parameters of the model, without a load.
    fn parameters(&self) -> Option<Without> {
        let p = self.all.ncols() - 1;
        let tau = self.all[(p, p)];
        Without::of(
            self.all.view((0, 0), (p, p)).into(),
            self.all.view((0, p), (p, 1)).column(0).into(),
            [tau, tau],
            self.rows,
        )
    }

    /// Fits friction to tau - Y X. Y X: torques of the bodies with the base parameters `described`.
    fn friction(&self, described: &DVector<f64>) -> Option<Without> {
        let (p, base) = (self.all.ncols() - 1, self.base);
        let friction = p - base;
        let of_rest = self.of_rest(described);
        let tau = self.all[(p, p)];
        let square = of_rest[p] - of_rest.rows(0, base).dot(described);
        let normal = self.all.view((base, base), (friction, friction)).into();
        Without::of(normal, of_rest.rows(base, friction).into(), [square, tau], self.rows)
    }

    /// The vector [W tau]' (tau - Y X). Y X: torques of the bodies with the base parameters `described`.
    fn of_rest(&self, described: &DVector<f64>) -> DVector<f64> {
        let p = self.all.ncols() - 1;
        self.all.column(p) - self.all.columns(0, self.base) * described
    }
}

/// A fit without a load. The normal equations of this fit are factorised once; the columns of many loads are then added.
struct Without {
    /// Cholesky factor of the normal matrix, with columns scaled to unit norm. `scale`: factor of each column; 0 for a column
    /// of zeros.
    factor: Cholesky<f64, Dyn>,
    scale: DVector<f64>,
    /// Solution for the scaled columns.
    x: DVector<f64>,
    rows: usize,
    /// Squared norm of the residual. `tau`: squared norm of the torque.
    residual_square: f64,
    tau: f64,
}

impl Without {
    /// Solves the normal equations; `None` if there is no torque. `square`, `tau`: squared norms of the right-hand side and
    /// of the torque.
    fn of(normal: DMatrix<f64>, right: DVector<f64>, [square, tau]: [f64; 2], rows: usize) -> Option<Without> {
        let scale = normal.diagonal().map(|square| if square > 0.0 { square.sqrt().recip() } else { 0.0 });
        let of_unit = DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
            let open = f64::from(scale[i] == 0.0);
            scale[i] * normal[(i, j)] * scale[j] + if i == j { RELATIVE_RIDGE + open } else { 0.0 }
        });
        let factor = Cholesky::new(of_unit)?;
        let right = right.component_mul(&scale);
        let x = factor.solve(&right);
        let left = (square - right.dot(&x)).max(0.0);
        (tau > 0.0).then_some(Without { factor, scale, x, rows, residual_square: left, tau })
    }

    fn error(&self) -> f64 {
        (self.residual_square / self.tau).sqrt()
    }

    /// Adds the ten columns of a load to the fit. `beside`: products of these columns with the other columns of the fit; `own`:
    /// products of these columns with one another; `right`: products of these columns with the right-hand side.
    fn with(&self, beside: &DMatrix<f64>, own: &DMatrix<f64>, right: DVector<f64>) -> Option<SolvedLoad> {
        let beside = DMatrix::from_fn(self.scale.len(), BODY_PARAMETERS, |i, j| self.scale[i] * beside[(i, j)]);
        // Schur complement: products of the load's columns after projection onto the complement of the other columns.
        let left = own - beside.tr_mul(&self.factor.solve(&beside));
        let right = right - beside.tr_mul(&self.x);
        let scale = own.diagonal().map(|square| if square > 0.0 { square.sqrt().recip() } else { 0.0 });
        let of_unit = DMatrix::from_fn(BODY_PARAMETERS, BODY_PARAMETERS, |i, j| {
            let open = f64::from(scale[i] == 0.0);
            scale[i] * left[(i, j)] * scale[j] + if i == j { RELATIVE_RIDGE + open } else { 0.0 }
        });
        let right = right.component_mul(&scale);
        let inverse = Cholesky::new(of_unit)?.inverse();
        let x = &inverse * &right;
        let residual = (self.residual_square - right.dot(&x)).max(0.0);
        let free = self.rows.saturating_sub(self.scale.len() + BODY_PARAMETERS).max(1) as f64;
        let variance = inverse[(MASS_INDEX, MASS_INDEX)] * residual / free;
        let load = x.component_mul(&scale);
        let is_significant = x[MASS_INDEX].abs() > SIGNIFICANT_MASS_SIGMAS * variance.sqrt() && scale[MASS_INDEX] > 0.0;
        Some(SolvedLoad {
            error: (residual / self.tau).sqrt(),
            mass: is_significant.then_some(load[MASS_INDEX]),
            centre: load.rows(MASS_INDEX - 3, 3).norm() / load[MASS_INDEX].abs(),
        })
    }
}

impl Record {
    fn parts(&self) -> usize {
        self.before.len() - 1
    }

    /// The longest interval of blocks with a constant load, if the load changes at the blocks `from` and `to`. The times of the
    /// changes are known only with an error of up to one block, so one block next to each change is left out.
    fn longest_constant_interval(&self, from: usize, to: usize) -> (usize, usize) {
        let parts = self.parts();
        let pieces = [
            (0, from.saturating_sub(1)),
            (from + usize::from(from > 0), to - usize::from(to < parts)),
            ((to + 1).min(parts), parts),
        ];
        let length = |(a, b): &(usize, usize)| self.times[*b] - self.times[*a];
        pieces.into_iter().max_by(|x, y| length(x).total_cmp(&length(y))).unwrap_or((0, parts))
    }

    /// The interval of blocks (start, end) in which a load reduces the residual most, and this load. The search alternates: it
    /// finds the start, then the end, then both once more.
    fn carried(&self, solve: impl Fn(usize, usize) -> Option<SolvedLoad>) -> Option<(usize, usize, SolvedLoad)> {
        let parts = self.parts();
        let (mut from, mut to) = (0, parts);
        for begins in [true, false, true, false] {
            let range =
                if begins { 0..to.saturating_sub(LEAST_LOAD_BLOCKS) + 1 } else { from + LEAST_LOAD_BLOCKS..parts + 1 };
            let of = |part: usize| if begins { (part, to) } else { (from, part) };
            let error = |part: usize| {
                let (from, to) = of(part);
                // A load during nearly all blocks is no change of the load.
                let is_change = to - from >= LEAST_LOAD_BLOCKS && to - from + LEAST_LOAD_BLOCKS <= parts;
                is_change.then(|| solve(from, to)).flatten().map_or(f64::INFINITY, |found| found.error)
            };
            let least = |parts: &mut dyn Iterator<Item = usize>| {
                parts.map(|part| (part, error(part))).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(part, _)| part)
            };
            let near = least(&mut range.clone().filter(|part| part % COARSE_BLOCK_STEP == 0 || *part == parts))?;
            let best = least(&mut range.filter(|part| part.abs_diff(near) < COARSE_BLOCK_STEP))?;
            (from, to) = of(best);
        }
        (to - from + LEAST_LOAD_BLOCKS <= parts).then(|| solve(from, to)).flatten().map(|found| (from, to, found))
    }
}
