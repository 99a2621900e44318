//! Detects, counts and reports faults of a log.
//!
//! Each file examines one property of the signals. The report (`account`) collects the results.

pub(crate) mod account;
pub(crate) mod clock;
pub(crate) mod goals;
pub(crate) mod publishers;
pub(crate) mod raw_words;
pub(crate) mod refresh;
pub(crate) mod rest;
pub(crate) mod suspects;
pub(crate) mod turns;
pub(crate) mod undriven;
