//! Determines the rank, in a finite field, of robots whose loops are closed by a numeric search (not by affine relations).
//!
//! Passive variables are not free in the field: they must close the loops. A [`closed_point`] is found by algebra, loop by loop
//! ([`planar_loop`], [`orientation`], [`lengths`], [`conditions`]). Through a closed point goes a [`curve`], given as a power
//! series ([`series`]), on which every state is closed. The rows of the regressor along such curves have the rank of almost
//! every robot of this structure ([`closed_rank`]).

pub(crate) mod closed_point;
pub(crate) mod closed_rank;
pub(crate) mod conditions;
pub(crate) mod curve;
pub(crate) mod lengths;
pub(crate) mod orientation;
pub(crate) mod planar_closing;
pub(crate) mod planar_loop;
pub(crate) mod pose;
pub(crate) mod reason;
pub(crate) mod series;
pub(crate) mod variables;
