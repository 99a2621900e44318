//! Computes sums over rows and their residuals e = tau - W x, several kinds of sums in one pass.
//!
//! A record is cut into blocks that do not depend on the number of threads. Each block is summed separately, and the sums
//! are appended in the order of the blocks.

use std::convert::Infallible;
use std::ops::Range;

use linear_model::linear_model::{Model, ResidualGroup};
use linear_model::states::States;
use logs::Error;
use processor::{in_order, threads};

use crate::signals::records::Records;

/// A sum over rows and their residuals, such as squares or products.
pub trait ResidualSum: Clone + Send + Sync {
    /// Adds a group of up to eight samples with their residuals.
    fn add(&mut self, model: &Model, group: &ResidualGroup);

    /// Appends `next`, the sum over the samples that follow. Blocks are appended in the order of time.
    fn append(&mut self, next: Self);

    /// Ends a record. This function is called after all samples of the record have been added.
    fn end_record(&mut self, _states: &States) {}
}

impl<A: ResidualSum, B: ResidualSum> ResidualSum for (A, B) {
    fn add(&mut self, model: &Model, group: &ResidualGroup) {
        self.0.add(model, group);
        self.1.add(model, group);
    }

    fn append(&mut self, next: Self) {
        self.0.append(next.0);
        self.1.append(next.1);
    }

    fn end_record(&mut self, states: &States) {
        self.0.end_record(states);
        self.1.end_record(states);
    }
}

/// Approximate number of samples of a block. Each block is summed separately.
const SAMPLES_PER_BLOCK: usize = 8192;

/// Computes the sums over all records with the residuals of parameters `x`, starting from `empty`.
///
/// Fails when a record cannot be read.
pub fn residual_sums<R: Records + ?Sized, S: ResidualSum>(
    model: &Model,
    records: &R,
    x: &[f64],
    empty: S,
) -> Result<S, Error> {
    let mut all = empty.clone();
    records.each(&mut |states| {
        add_record(&mut all, model, states, x, &empty);
        all.end_record(states);
    })?;
    Ok(all)
}

/// Adds the sums over one record to `all`. `empty`: sums without rows.
pub fn add_record<S: ResidualSum>(all: &mut S, model: &Model, states: &States, x: &[f64], empty: &S) {
    let (len, count) = (states.len(), states.len().div_ceil(SAMPLES_PER_BLOCK).max(1));
    let parts: Vec<Range<usize>> = (0..count).map(|k| k * len / count..(k + 1) * len / count).collect();
    let sum = |_, part: &Range<usize>| {
        let mut sum = empty.clone();
        model.residual_groups(states, part.clone(), x, |group| sum.add(model, group));
        sum
    };
    let Ok(()) = in_order(&parts, threads(), sum, |_, sum| {
        all.append(sum);
        Ok::<(), Infallible>(())
    });
}
