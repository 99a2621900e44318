//! A function in the form that the writers of all languages get: name, description and listing (assignments and entries).

use crate::listing::Listing;

/// A function ready for printing.
pub(crate) struct PrintedFunction<'a> {
    pub name: &'a str,
    pub doc: &'a [String],
    pub listing: Listing,
}
