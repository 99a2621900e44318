//! Counts and reports what is wrong with a log.

pub(crate) mod account;
pub(crate) mod suspects;
