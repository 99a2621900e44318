//! Writes named columns as the bytes of a Parquet file. Without the feature `parquet`, this fails.

use crate::error::Error;
use crate::formats::cells::Cells;

/// The bytes of a Parquet file with these named columns. All columns must have the same length.
///
/// Fails if a name occurs twice, if the lengths differ, or if the feature `parquet` is missing.
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
