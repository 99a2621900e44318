//! The rank of robots whose loops no affine function closes, in a finite field.
//!
//! Passive coordinates are no free elements of a field: they must close the loops. A [`closed_point`] is found by algebra,
//! loop by loop ([`planar_loop`], [`orientation`], [`lengths`]); along a [`curve`] through it, every state is closed too, as
//! a power series ([`series`]). The rows of the regressor along such curves have the rank that almost every robot of this
//! structure has ([`closed_rank`]).

pub(crate) mod closed_point;
pub(crate) mod closed_rank;
pub(crate) mod curve;
pub(crate) mod lengths;
pub(crate) mod orientation;
pub(crate) mod planar_closing;
pub(crate) mod planar_loop;
pub(crate) mod pose;
pub(crate) mod reason;
pub(crate) mod series;
pub(crate) mod variables;
