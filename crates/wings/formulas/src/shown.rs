//! A function as the writers of all languages get it: name, description and listing.

use crate::listing::Listing;

/// A function ready for printing.
pub(crate) struct PrintedFunction<'a> {
    pub name: &'a str,
    pub doc: &'a [String],
    pub listing: Listing,
}
