//! Random numbers from a seed: equal seeds give equal numbers at every run and on every machine. They are not suited for
//! cryptography.
//!
//! [`SplitMix`] is a small generator with 64 bits of state, for a derivation or a test that needs few numbers. [`Random`] is for
//! thousands of numbers: it also gives normally distributed numbers, and an independent stream for each index, such as the number
//! of a start of a search.

#![warn(missing_docs)]

mod random;
mod split_mix;

pub use crate::random::Random;
pub use crate::split_mix::SplitMix;
