//! Counts and reports what is wrong with a log.

pub mod account;
pub mod suspects;
