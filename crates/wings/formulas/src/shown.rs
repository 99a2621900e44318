//! A function as every language gets it.

use crate::listing::Listing;

/// A function as its language prints it.
pub(crate) struct Shown<'a> {
    pub name: &'a str,
    pub doc: &'a [String],
    pub listing: Listing,
}
