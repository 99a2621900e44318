//! Selects every m-th sample of records, for computations that are too slow for all samples. m is the smallest number with
//! which at most a given number of samples is selected.

use std::cell::{Cell, RefCell};

use linear_model::states::{FilteredFriction, States};
use logs::Error;

/// Largest number of thinned samples.
pub const MOST_THINNED_SAMPLES: usize = 3000;

/// Every m-th sample of records, counted over all records in their order.
#[derive(Clone, Debug, Default)]
pub struct ThinnedSamples {
    /// Number of samples of all records before thinning.
    pub count: usize,
    /// Decimation m: every m-th sample is selected.
    pub every: usize,
    /// For each record: the number of samples of all records before it, and its thinned samples.
    pub records: Vec<(usize, States)>,
}

impl ThinnedSamples {
    /// Selects at most `most` samples in two passes, one for counting and one for thinning. `each`: iterates over the states of
    /// all records.
    pub(crate) fn of(
        each: impl Fn(&mut dyn FnMut(&States)) -> Result<(), Error>,
        most: usize,
    ) -> Result<ThinnedSamples, Error> {
        let (mut count, mut before) = (0, 0);
        each(&mut |states| count += states.len())?;
        let mut found = ThinnedSamples::new(count, most);
        each(&mut |states| {
            found.add(states, before);
            before += states.len();
        })?;
        Ok(found)
    }

    /// Makes an empty selection for at most `most` of `count` samples.
    fn new(count: usize, most: usize) -> ThinnedSamples {
        ThinnedSamples { count, every: count.div_ceil(most.max(1)).max(1), records: Vec::new() }
    }

    /// Adds the thinned samples of the next record; `before`: number of samples of all records before it.
    fn add(&mut self, states: &States, before: usize) {
        let first = (self.every - before % self.every) % self.every;
        self.records.push((before, some(states, first, self.every)));
    }
}

/// Selects samples for records that are computed again in every pass. The first pass counts the samples, and the second pass
/// keeps at most [`MOST_THINNED_SAMPLES`] of them.
#[derive(Default)]
pub(crate) struct SecondReader {
    count: Cell<Option<usize>>,
    thinned: RefCell<Option<ThinnedSamples>>,
}

impl SecondReader {
    /// Runs one pass. `each`: iterates over the states of all records; `take`: receives these states.
    pub(crate) fn pass(
        &self,
        each: impl FnOnce(&mut dyn FnMut(&States)) -> Result<(), Error>,
        take: &mut dyn FnMut(&States),
    ) -> Result<(), Error> {
        let is_thinned = self.thinned.borrow().is_some();
        let count = self.count.get().filter(|_| !is_thinned);
        let (mut before, mut thinned) = (0, count.map(|count| ThinnedSamples::new(count, MOST_THINNED_SAMPLES)));
        each(&mut |states| {
            take(states);
            if let Some(thinned) = &mut thinned {
                thinned.add(states, before);
            }
            before += states.len();
        })?;
        self.count.set(Some(before));
        if thinned.is_some() {
            *self.thinned.borrow_mut() = thinned;
        }
        Ok(())
    }

    /// The selected samples. `None` if no pass has collected them yet, or if `most` is not [`MOST_THINNED_SAMPLES`].
    pub(crate) fn found(&self, most: usize) -> Option<ThinnedSamples> {
        self.thinned.borrow().clone().filter(|_| most == MOST_THINNED_SAMPLES)
    }
}

/// Every `every`-th sample of states, from index `first` on.
fn some(states: &States, first: usize, every: usize) -> States {
    let (n, chosen) = (states.n, (first..states.len()).step_by(every));
    let series = |x: &[f64], width: usize| -> Vec<f64> {
        chosen.clone().flat_map(|r| x[r * width..(r + 1) * width].iter().copied()).collect()
    };
    // The number of couplings is not a field of the states, so it follows from the lengths.
    let motors = states.motor_direction.len() / states.len().max(1);
    let friction = |of: &FilteredFriction| FilteredFriction {
        term: of.term,
        columns: series(&of.columns, of.term.parameters().len() * n),
    };
    States {
        n,
        log: states.log,
        t: series(&states.t, 1),
        q: series(&states.q, n),
        dq: series(&states.dq, n),
        ddq: series(&states.ddq, n),
        tau: series(&states.tau, n),
        direction: series(&states.direction, n),
        motor_direction: series(&states.motor_direction, motors),
        // An empty load means that there is no load-dependent friction. The field then stays empty.
        load: match states.load.is_empty() {
            true => Vec::new(),
            false => series(&states.load, n),
        },
        used: chosen.clone().flat_map(|r| states.used[r * n..(r + 1) * n].iter().copied()).collect(),
        friction: states.friction.iter().map(friction).collect(),
        cutoff: states.cutoff,
        ..States::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three records. Each signal of a sample equals the index of the sample.
    fn records() -> Vec<States> {
        let of = |range: std::ops::Range<usize>| {
            let t: Vec<f64> = range.map(|r| r as f64).collect();
            States {
                n: 1,
                q: t.clone(),
                dq: t.clone(),
                ddq: t.clone(),
                tau: t.clone(),
                direction: t.clone(),
                used: vec![true; t.len()],
                t,
                ..States::default()
            }
        };
        vec![of(0..3001), of(3001..3003), of(3003..9001)]
    }

    #[test]
    fn every_fourth_sample_of_all() {
        let all = records();
        let each = |take: &mut dyn FnMut(&States)| {
            all.iter().for_each(take);
            Ok(())
        };
        let expected = ThinnedSamples::of(each, MOST_THINNED_SAMPLES).unwrap();
        assert_eq!((expected.count, expected.every), (9001, 4));
        let taken = |found: &ThinnedSamples| {
            let states = found.records.iter().map(|(first, states)| (*first, states.t.clone(), states.tau.clone()));
            states.collect::<Vec<_>>()
        };
        let places: Vec<f64> = expected.records.iter().flat_map(|(_, states)| states.t.clone()).collect();
        assert_eq!(places, (0..9001).step_by(4).map(|r| r as f64).collect::<Vec<f64>>());
        let beside = SecondReader::default();
        let mut seen = 0;
        for passes in 0..3 {
            assert_eq!(beside.found(MOST_THINNED_SAMPLES).is_some(), passes == 2);
            beside.pass(each, &mut |states| seen += states.len()).unwrap();
        }
        assert_eq!((seen, taken(&beside.found(MOST_THINNED_SAMPLES).unwrap())), (3 * 9001, taken(&expected)));
        assert!(beside.found(10).is_none());
    }
}
