//! What is wrong with a log, counted and said.

pub mod account;
pub mod suspects;
