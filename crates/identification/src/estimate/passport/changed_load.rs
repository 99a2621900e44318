//! A load that the robot picks up or puts down during a log.
//!
//! With W the rows of the model, s(t) = 1 while the robot carries the load and else 0, and B_L the ten columns of the map B of
//! the link that carries it ([`crate::estimators::payload`]),
//! ```text
//! tau = W X + s(t) W B_L phi_L
//! ```
//! is solved for X and phi_L by normal equations, for instants of a grid at which s may change. It is named where it leaves less
//! than `NAMED_ERROR_RATIO` of the error that X alone leaves: ten columns during a part of a log explain nothing else so well.

use linear_model::linear_model::Model;
use linear_model::standard_map::StandardMap;
use logs::Error;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::estimate::digits::percent;
use crate::estimate::passport::Passport;
use crate::estimate::passport::finding::{Fault, Finding};
use crate::signals::records::Records;
use crate::signals::thinned::MOST_THINNED_SAMPLES;

/// Error without such a load up to which a log is explained.
const SMALL_ERROR: f64 = 0.02;
/// Error with it over that without, up to which it is named. A torque that grows steadily is explained down to a half by one
/// that steps.
const NAMED_ERROR_RATIO: f64 = 1.0 / 3.0;
/// Parts of all logs between which a load may change.
const PARTS: usize = 100;
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

impl Passport {
    /// Finds the load that explains far more than the parameters alone, if there is one; it is in place of findings whose cause is not
    /// identified. `bodies`: those of the map that may carry one.
    ///
    /// Fails when a record cannot be read.
    pub fn look_for_changed_load<R: Records + ?Sized>(
        &mut self,
        model: &Model,
        records: &R,
        map: &StandardMap,
        bodies: &[usize],
    ) -> Result<(), Error> {
        if let Some(finding) = changed_load(model, records, map, bodies)? {
            self.findings.retain(|finding| !matches!(finding.fault, Fault::OtherRobot | Fault::Unidentified));
            self.findings.push(finding);
        }
        Ok(())
    }

    /// Whether it found one.
    pub fn has_changed_load(&self) -> bool {
        self.findings.iter().any(|finding| matches!(finding.fault, Fault::ChangedLoad { .. }))
    }
}

fn changed_load<R: Records + ?Sized>(
    model: &Model,
    records: &R,
    map: &StandardMap,
    bodies: &[usize],
) -> Result<Option<Finding>, Error> {
    let sums = Sums::of(model, records)?;
    let without = sums.solve(None).map_or(0.0, |found| found.error);
    if without < SMALL_ERROR {
        return Ok(None);
    }
    let (mut least, mut best) = (NAMED_ERROR_RATIO * without, None);
    for (link, first) in bodies.iter().map(|body| &map.bodies[*body]) {
        let load = map.matrix.columns(*first, TEN).into_owned();
        for record in &sums.records {
            let Some((from, to, found)) = record.carried(|from, to| sums.solve(Some((record, from, to, &load)))) else {
                continue;
            };
            if found.error < least {
                least = found.error;
                let time = |part: usize| (part > 0 && part < record.parts()).then(|| record.times[part]);
                let fault = Fault::ChangedLoad { from: time(from), to: time(to), mass: found.mass };
                best = Some((fault, link.clone()));
            }
        }
    }
    Ok(best.map(|(fault, link)| {
        let [before, after] = [without, least].map(percent);
        let evidence =
            format!("one set of parameters leaves a residual of {before}, with a body of its own for it {after}");
        let remedy = "log each load by itself, and give the log of the second as [loaded]";
        Finding {
            tried: Some([without, least].map(|error| error * error)),
            ..Finding::of(fault, vec![link], evidence, remedy)
        }
    }))
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
    /// When each part begins, s, and when the last ends.
    times: Vec<f64>,
    /// Of all parts before each.
    before: Vec<DMatrix<f64>>,
}

/// A solution of normal equations.
struct Found {
    error: f64,
    mass: Option<f64>,
}

impl Sums {
    fn of<R: Records + ?Sized>(model: &Model, records: &R) -> Result<Sums, Error> {
        let (n, p) = (model.n(), model.p());
        let thinned = records.thinned(MOST_THINNED_SAMPLES)?;
        // Joints alike: each by the size of its torque.
        let mut squares = vec![0.0; n];
        for tau in thinned.records.iter().flat_map(|(_, states)| states.tau.chunks_exact(n)) {
            squares.iter_mut().zip(tau).for_each(|(square, tau)| *square += tau * tau);
        }
        let weights: Vec<f64> = squares.iter().map(|s| if *s > 0.0 { s.sqrt().recip() } else { 0.0 }).collect();
        let samples: usize = thinned.records.iter().map(|(_, states)| states.len()).sum();
        let part = samples.div_ceil(PARTS).max(1);
        let mut sums = Sums {
            base: model.regressor.parameters().len(),
            rows: n * samples,
            all: DMatrix::zeros(p + 1, p + 1),
            records: Vec::new(),
        };
        for (_, states) in &thinned.records {
            let mut total = DMatrix::zeros(p + 1, p + 1);
            let mut record = Record { times: Vec::new(), before: Vec::new() };
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
        Ok(sums)
    }

    /// The error of the parameters, and of a load of the columns B_L in the parts `from..to` of a record; `None` where the equations
    /// have no solution.
    fn solve(&self, load: Option<(&Record, usize, usize, &DMatrix<f64>)>) -> Option<Found> {
        let (p, base) = (self.all.ncols() - 1, self.base);
        let m = p + if load.is_some() { TEN } else { 0 };
        let mut normal = DMatrix::zeros(m, m);
        let mut right = DVector::zeros(m);
        normal.view_mut((0, 0), (p, p)).copy_from(&self.all.view((0, 0), (p, p)));
        right.rows_mut(0, p).copy_from(&self.all.view((0, p), (p, 1)));
        if let Some((record, from, to, load)) = load {
            let during = &record.before[to] - &record.before[from];
            // W'W B_L, and B_L'W'W B_L.
            let beside = during.view((0, 0), (p, base)) * load;
            normal.view_mut((0, p), (p, TEN)).copy_from(&beside);
            normal.view_mut((p, 0), (TEN, p)).copy_from(&beside.transpose());
            normal.view_mut((p, p), (TEN, TEN)).copy_from(&load.tr_mul(&beside.rows(0, base)));
            right.rows_mut(p, TEN).copy_from(&load.tr_mul(&during.view((0, p), (base, 1))));
        }
        // Columns of unit length; one of zeros stays out.
        let scale = normal.diagonal().map(|square| if square > 0.0 { square.sqrt().recip() } else { 0.0 });
        let scaled = DMatrix::from_fn(m, m, |i, j| scale[i] * normal[(i, j)] * scale[j] + f64::from(i == j) * RIDGE);
        let scaled = &scaled + DMatrix::from_diagonal(&scale.map(|s| f64::from(s == 0.0)));
        let factor: Cholesky<f64, Dyn> = Cholesky::new(scaled)?;
        let right = right.component_mul(&scale);
        let x = factor.solve(&right);
        let (torque, residual) = (self.all[(p, p)], (self.all[(p, p)] - right.dot(&x)).max(0.0));
        let mass = load.and_then(|_| {
            let mut unit = DVector::zeros(m);
            unit[m - 1] = 1.0;
            let variance = factor.solve(&unit)[m - 1] * residual / (self.rows.saturating_sub(m)).max(1) as f64;
            let is_significant = x[m - 1].abs() > SIGNIFICANT_SIGMAS * variance.sqrt() && scale[m - 1] > 0.0;
            is_significant.then(|| x[m - 1] * scale[m - 1])
        });
        Some(Found { error: (residual / torque).sqrt(), mass })
    }
}

impl Record {
    fn parts(&self) -> usize {
        self.before.len() - 1
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
