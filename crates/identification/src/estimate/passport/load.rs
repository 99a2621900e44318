//! A load that the robot picks up or puts down during a log, or that the description does not have.
//!
//! With W the rows of the model, s(t) = 1 while the robot carries the load and else 0, and B_L the ten columns of the map B of
//! the link that carries it ([`crate::estimators::payload`]),
//! ```text
//! tau = W X + s(t) W B_L phi_L
//! ```
//! is solved for X and phi_L by normal equations, for instants of a grid at which s may change. It is named where it leaves less
//! than `NAMED_ERROR_RATIO` of the error that X alone leaves: ten columns during a part of a log explain nothing else so well.
//! A load all the time shows with X of the description alone, beside friction.

use linear_model::linear_model::Model;
use linear_model::standard_map::StandardMap;
use logs::Error;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::estimate::digits::percent;
use crate::estimate::hypothesis::OF_OPTIONS;
use crate::estimate::passport::Passport;
use crate::estimate::passport::finding::{Fault, Finding};
use crate::signals::records::Records;
use crate::signals::thinned::MOST_THINNED_SAMPLES;

/// Error without such a load up to which a log is explained.
const SMALL_ERROR: f64 = 0.02;
/// Error with it over that without, up to which it is named. A torque that grows steadily is explained down to a half by one
/// that steps.
const NAMED_ERROR_RATIO: f64 = 1.0 / 3.0;
/// Error that the wrong bodies of a description leave, none of which is a load.
const NOMINAL_ERROR: f64 = 0.3;
/// Error that a body at the last link may leave beside the description: errors of the other bodies are left, of tens of per cent of each,
/// and another robot is not one body away.
const DESCRIBED_ERROR: f64 = 0.1;
/// A load lies no farther from the frame of its link, m, and weighs more than the link does in the description; else it is an error
/// of the bodies.
const LARGEST_CENTRE_M: f64 = 0.5;
/// Parts of all logs between which a load may change.
const PARTS: usize = 100;
/// Entries of the matrices of all parts; a robot of some 800 parameters, whose parts would be too few, is not looked at.
const MOST_ENTRIES: usize = 4_000_000;
/// A load stays for so many parts at least.
const LEAST_PARTS: usize = 3;
/// Every so many ends of parts are tried first.
const COARSE: usize = 5;
/// Added to the diagonal of the normal matrix, relative to it: directions that the log leaves open stay at zero.
const RIDGE: f64 = 1e-10;
/// A mass beyond so many of its deviations is one.
const SIGNIFICANT_SIGMAS: f64 = 3.0;
/// Parameters of a body.
const TEN: usize = 10;
/// The place of the mass among them, behind the first moments.
const MASS: usize = 9;

impl Passport {
    /// Finds a load that changes, or else, where no other cause was found, one that the description (`described`: its base parameters)
    /// does not have. It is in place of findings whose cause is not identified. `bodies`: those of the map that may carry one, and the mass of each
    /// in the description, kg.
    ///
    /// Fails when a record cannot be read.
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

    /// Whether a load was found that changes.
    pub fn has_changed_load(&self) -> bool {
        self.findings.iter().any(|finding| matches!(finding.fault, Fault::ChangedLoad { .. }))
    }
}

/// The finding of a load, with the errors without it and with it.
fn finding(fault: Fault, link: &str, what: &str, errors: [f64; 2], remedy: &str) -> Finding {
    let [before, after] = errors.map(percent);
    let evidence = format!("{what} leaves a residual of {before}, with a body of its own for it {after}");
    let squares = Some(errors.map(|error| error * error));
    Finding { tried: squares, ..Finding::of(fault, vec![link.into()], evidence, remedy) }
}

/// [W tau]' [W tau] of all rows, and of parts of each record.
struct Sums {
    base: usize,
    rows: usize,
    all: DMatrix<f64>,
    records: Vec<Record>,
}

/// The sums of one record.
struct Record {
    /// Of which log, from 0.
    log: usize,
    /// When each part begins, s, and when the last ends.
    times: Vec<f64>,
    /// Of all parts before each.
    before: Vec<DMatrix<f64>>,
}

/// A load that was solved for.
struct Found {
    /// |tau - W X - s W B_L phi_L| / |tau|.
    error: f64,
    /// kg, where it is significant.
    mass: Option<f64>,
    /// How far its centre is from the frame of the link, m.
    centre: f64,
}

impl Sums {
    /// `None` where there are too many parameters.
    fn of<R: Records + ?Sized>(model: &Model, records: &R) -> Result<Option<Sums>, Error> {
        let (n, p) = (model.n(), model.p());
        let thinned = records.thinned(MOST_THINNED_SAMPLES)?;
        // Joints alike: each by the size of its torque.
        let mut squares = vec![0.0; n];
        for tau in thinned.records.iter().flat_map(|(_, states)| states.tau.chunks_exact(n)) {
            squares.iter_mut().zip(tau).for_each(|(square, tau)| *square += tau * tau);
        }
        let weights: Vec<f64> = squares.iter().map(|s| if *s > 0.0 { s.sqrt().recip() } else { 0.0 }).collect();
        let samples: usize = thinned.records.iter().map(|(_, states)| states.len()).sum();
        let parts = PARTS.min(MOST_ENTRIES / ((p + 1) * (p + 1)));
        if parts < 2 * LEAST_PARTS {
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
            let load = map.matrix.columns(*first, TEN).into_owned();
            for record in &self.records {
                let during = |from: usize, to: usize| {
                    let beside = Sums::beside(&(&record.before[to] - &record.before[from]), &load);
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
                best = Some((fault, link, record.longest_beside(from, to)));
            }
        }
        let (fault, link, (from, to)) = best?;
        let remedy = match self.records.as_slice() {
            // The window was tried: its rows alone have parameters that leave as little.
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
            let load = map.matrix.columns(*first, TEN).into_owned();
            let beside = Sums::beside(&self.all, &load);
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

    /// [W tau]' W B_L of the rows whose [W tau]' [W tau] these are.
    fn beside(rows: &DMatrix<f64>, load: &DMatrix<f64>) -> DMatrix<f64> {
        rows.columns(0, load.nrows()) * load
    }

    /// The error of parameters of these parts of a record alone.
    fn within(&self, record: &Record, from: usize, to: usize) -> Option<f64> {
        let all = &record.before[to] - &record.before[from];
        Sums { all, records: Vec::new(), ..*self }.parameters().map(|found| found.error())
    }

    /// The parameters alone.
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

    /// Friction alone, beside bodies of these base parameters: of tau - W X.
    fn friction(&self, described: &DVector<f64>) -> Option<Without> {
        let (p, base) = (self.all.ncols() - 1, self.base);
        let friction = p - base;
        let of_rest = self.of_rest(described);
        let tau = self.all[(p, p)];
        let square = of_rest[p] - of_rest.rows(0, base).dot(described);
        let normal = self.all.view((base, base), (friction, friction)).into();
        Without::of(normal, of_rest.rows(base, friction).into(), [square, tau], self.rows)
    }

    /// [W tau]' (tau - W X) with these base parameters X.
    fn of_rest(&self, described: &DVector<f64>) -> DVector<f64> {
        let p = self.all.ncols() - 1;
        self.all.column(p) - self.all.columns(0, self.base) * described
    }
}

/// Columns without a load, and what they explain: normal equations that are factored once.
struct Without {
    /// Of columns of unit length; one of zeros stays out.
    factor: Cholesky<f64, Dyn>,
    scale: DVector<f64>,
    /// The solution, in these units.
    x: DVector<f64>,
    rows: usize,
    /// The square of what they leave, and that of the torque.
    left: f64,
    tau: f64,
}

impl Without {
    /// `None` where there is no torque.
    fn of(normal: DMatrix<f64>, right: DVector<f64>, [square, tau]: [f64; 2], rows: usize) -> Option<Without> {
        let scale = normal.diagonal().map(|square| if square > 0.0 { square.sqrt().recip() } else { 0.0 });
        let of_unit = DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
            let open = f64::from(scale[i] == 0.0);
            scale[i] * normal[(i, j)] * scale[j] + if i == j { RIDGE + open } else { 0.0 }
        });
        let factor = Cholesky::new(of_unit)?;
        let right = right.component_mul(&scale);
        let x = factor.solve(&right);
        let left = (square - right.dot(&x)).max(0.0);
        (tau > 0.0).then_some(Without { factor, scale, x, rows, left, tau })
    }

    fn error(&self) -> f64 {
        (self.left / self.tau).sqrt()
    }

    /// With the ten columns of a load: `beside` are their products with the other columns, `own` those with each other, `right` those
    /// with what all explain.
    fn with(&self, beside: &DMatrix<f64>, own: &DMatrix<f64>, right: DVector<f64>) -> Option<Found> {
        let beside = DMatrix::from_fn(self.scale.len(), TEN, |i, j| self.scale[i] * beside[(i, j)]);
        // What the other columns leave of these.
        let left = own - beside.tr_mul(&self.factor.solve(&beside));
        let right = right - beside.tr_mul(&self.x);
        let scale = own.diagonal().map(|square| if square > 0.0 { square.sqrt().recip() } else { 0.0 });
        let of_unit = DMatrix::from_fn(TEN, TEN, |i, j| {
            let open = f64::from(scale[i] == 0.0);
            scale[i] * left[(i, j)] * scale[j] + if i == j { RIDGE + open } else { 0.0 }
        });
        let right = right.component_mul(&scale);
        let inverse = Cholesky::new(of_unit)?.inverse();
        let x = &inverse * &right;
        let residual = (self.left - right.dot(&x)).max(0.0);
        let variance =
            inverse[(MASS, MASS)] * residual / self.rows.saturating_sub(self.scale.len() + TEN).max(1) as f64;
        let load = x.component_mul(&scale);
        let is_significant = x[MASS].abs() > SIGNIFICANT_SIGMAS * variance.sqrt() && scale[MASS] > 0.0;
        Some(Found {
            error: (residual / self.tau).sqrt(),
            mass: is_significant.then_some(load[MASS]),
            centre: load.rows(MASS - 3, 3).norm() / load[MASS].abs(),
        })
    }
}

impl Record {
    fn parts(&self) -> usize {
        self.before.len() - 1
    }

    /// The parts during which the load stays as it is for the longest time, where it changes at these: a part away from them, since
    /// the instants of a change are as far apart.
    fn longest_beside(&self, from: usize, to: usize) -> (usize, usize) {
        let parts = self.parts();
        let pieces = [
            (0, from.saturating_sub(1)),
            (from + usize::from(from > 0), to - usize::from(to < parts)),
            ((to + 1).min(parts), parts),
        ];
        let length = |(a, b): &(usize, usize)| self.times[*b] - self.times[*a];
        pieces.into_iter().max_by(|x, y| length(x).total_cmp(&length(y))).unwrap_or((0, parts))
    }

    /// The parts during which a load explains most, with what it leaves: first where it begins, then where it ends, then where it
    /// begins again.
    fn carried(&self, solve: impl Fn(usize, usize) -> Option<Found>) -> Option<(usize, usize, Found)> {
        let parts = self.parts();
        let (mut from, mut to) = (0, parts);
        for begins in [true, false, true, false] {
            let range = if begins { 0..to.saturating_sub(LEAST_PARTS) + 1 } else { from + LEAST_PARTS..parts + 1 };
            let of = |part: usize| if begins { (part, to) } else { (from, part) };
            let error = |part: usize| {
                let (from, to) = of(part);
                // A load all the time is none that changes, nor is one that is missing for an instant.
                let is_change = to - from >= LEAST_PARTS && to - from + LEAST_PARTS <= parts;
                is_change.then(|| solve(from, to)).flatten().map_or(f64::INFINITY, |found| found.error)
            };
            let least = |parts: &mut dyn Iterator<Item = usize>| {
                parts.map(|part| (part, error(part))).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(part, _)| part)
            };
            let near = least(&mut range.clone().filter(|part| part % COARSE == 0 || *part == parts))?;
            let best = least(&mut range.filter(|part| part.abs_diff(near) < COARSE))?;
            (from, to) = of(best);
        }
        (to - from + LEAST_PARTS <= parts).then(|| solve(from, to)).flatten().map(|found| (from, to, found))
    }
}
