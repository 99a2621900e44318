//! The form of a function that all language writers receive.

use crate::listing::Listing;

/// A function ready for printing.
pub(crate) struct PrintedFunction<'a> {
    pub name: &'a str,
    pub doc: &'a [String],
    pub listing: Listing,
}
