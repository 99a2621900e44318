//! The first rows of a text, from which its shape is determined.
//!
//! The shape is the arrangement of the numbers, for example one row per sample or one row per signal (`text_shapes`).

use crate::formats::delimited::delimiter;
use crate::formats::rows::Dialect;

/// Number of first bytes of a text that determine its shape.
pub(crate) const HEAD_BYTES: usize = 1 << 16;
/// Number of rows at the start of a text that are examined.
pub(super) const HEAD_ROWS: usize = 200;

/// A function that decides from the first rows of a text whether the text has a certain shape.
pub type IsShape = fn(&TextHead) -> bool;

/// The first rows of a text.
pub struct TextHead<'a> {
    /// The first bytes, without a byte order mark of UTF-8.
    pub bytes: &'a [u8],
    /// The complete lines, without blank lines and comments.
    pub lines: Vec<&'a str>,
    /// The first lines, divided into cells.
    pub rows: Vec<Vec<String>>,
    /// The delimiter of the cells; `None`: blanks.
    pub delimiter: Option<u8>,
}

impl TextHead<'_> {
    /// Analyses the first bytes of a text, at most 64 KiB.
    pub fn of(bytes: &[u8]) -> TextHead<'_> {
        let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
        let is_cut = bytes.len() >= HEAD_BYTES - 3;
        let whole = if is_cut { memchr::memrchr(b'\n', bytes).map_or(bytes.len(), |end| end + 1) } else { bytes.len() };
        let text = std::str::from_utf8(&bytes[..whole]).unwrap_or_default();
        let lines: Vec<&str> =
            text.lines().filter(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#')).collect();
        let delimiter = TextHead::delimiter_of(bytes);
        let rows = rows(text.as_bytes(), delimiter).take(HEAD_ROWS).map(|(_, row)| row).collect();
        TextHead { bytes, lines, rows, delimiter }
    }

    /// The delimiter of the cells of a text, determined from its first line that is neither blank nor a comment.
    pub fn delimiter_of(bytes: &[u8]) -> Option<u8> {
        let mut lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
        lines.find(|line| !line.is_empty() && !line.starts_with(b"#")).and_then(delimiter)
    }
}

/// The rows of a text, divided into cells. Each has the number of the line at which it ends.
pub fn rows(bytes: &[u8], delimiter: Option<u8>) -> impl Iterator<Item = (usize, Vec<String>)> {
    let dialect = Dialect { delimiter, wanted: Vec::new() };
    let (mut at, mut ends) = (0, 0);
    std::iter::from_fn(move || {
        let row = dialect.first_row(&bytes[at..])?;
        at += row.bytes;
        ends += row.ends;
        // The last row may lack a line end.
        let line = ends + usize::from(!bytes[..at].ends_with(b"\n") && !bytes[..at].ends_with(b"\r"));
        Some((line, row.cells.iter().map(|cell| String::from_utf8_lossy(cell).into_owned()).collect()))
    })
}
