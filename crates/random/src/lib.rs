//! Random numbers from a seed: the same numbers at every run and on every machine. Not for cryptography.
//!
//! [`SplitMix`] is a small generator with 64 bits of state, for the few draws of a derivation or a test. [`Random`] is for
//! thousands of draws: it also gives normally distributed numbers, and an independent stream for each index of an enumeration.

#![warn(missing_docs)]

mod random;
mod split_mix;

pub use crate::random::Random;
pub use crate::split_mix::SplitMix;
