//! Tables as files.

use crate::error::Error;
use crate::formats::cells::Cells;

/// The bytes of a Parquet file of these named columns, which have the same length.
///
/// Fails where a name occurs twice or the lengths differ, and without the feature `parquet`.
pub fn parquet_bytes(columns: &[(String, Cells<'_>)]) -> Result<Vec<u8>, Error> {
    #[cfg(feature = "parquet")]
    let written = crate::formats::parquet::write::written(columns).map_err(|e| e.to_string());
    #[cfg(not(feature = "parquet"))]
    let written = {
        let _ = columns;
        Err(format!("{}; or write it as .csv", crate::formats::content::NO_PARQUET))
    };
    written.map_err(|e| Error::new(format!("the table cannot be written as Parquet: {e}")))
}
