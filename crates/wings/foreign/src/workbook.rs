//! Reads a sheet of an Excel workbook as a log: the first sheet with numbers, converted to delimited text.
//!
//! Cells are read one by one, and each takes its memory from the budget of the file. So a single cell at the last row and column
//! of a sheet needs little memory. Dates become seconds since 1970.

use std::io::Cursor;

use calamine::{DataRef, Reader, Xlsx, XlsxError};
use logs::reading::{Budget, MAX_COLUMNS};
use logs::{Error, Table};

/// A file inside the zip archive of every workbook. It distinguishes a workbook from other zip archives.
pub(crate) const MEMBER: &[u8] = b"xl/workbook.xml";
/// Day 0 of Unix time as a day number of Excel.
const UNIX_EPOCH_DAY: f64 = 25_569.0;
/// Seconds of a day.
const DAY_S: f64 = 86_400.0;
/// Number of rows of a sheet that are searched for numbers.
const ROWS_LOOKED_AT: usize = 200;

/// Reads the first sheet with numbers as a table. Fails if the workbook is damaged, or if no sheet has numbers.
pub(crate) fn read(file: &str, bytes: &[u8], budget: &mut Budget) -> Result<Table, Error> {
    let failed = |e: String| Error::at(file, 0, format!("the workbook cannot be read: {e}"));
    let mut book = Xlsx::new(Cursor::new(bytes)).map_err(|e: XlsxError| failed(e.to_string()))?;
    let sheets = book.sheet_names();
    for sheet in &sheets {
        let text = text_of(&mut book, sheet, budget).map_err(failed)?;
        let has_numbers = |line: &str| line.split('\t').any(|cell| cell.parse::<f64>().is_ok());
        if !text.lines().take(ROWS_LOOKED_AT).any(has_numbers) {
            continue;
        }
        let mut table = Table::from_bytes(file, text.as_bytes())?;
        if sheets.len() > 1 {
            table.notes.push(format!("sheet `{sheet}` is read, the first of {} with numbers", sheets.len()));
        }
        return Ok(table);
    }
    Err(failed(format!("none of its {} sheets holds numbers", sheets.len())))
}

/// The cells of a sheet as text: one line per row, with tabs between the cells.
fn text_of(book: &mut Xlsx<Cursor<&[u8]>>, sheet: &str, budget: &mut Budget) -> Result<String, String> {
    let mut cells = book.worksheet_cells_reader(sheet).map_err(|e| e.to_string())?;
    let (mut text, mut row, mut column) = (String::new(), 0, 0);
    while let Some(cell) = cells.next_cell().map_err(|e| e.to_string())? {
        let (own_row, own_column) = cell.get_position();
        let shown = match cell.get_value() {
            DataRef::Empty => continue,
            DataRef::Float(x) => x.to_string(),
            DataRef::Int(x) => x.to_string(),
            DataRef::Bool(x) => u8::from(*x).to_string(),
            DataRef::DateTime(x) => {
                (DAY_S * (x.as_f64() - if x.is_duration() { 0.0 } else { UNIX_EPOCH_DAY })).to_string()
            }
            DataRef::String(_) | DataRef::SharedString(_) | DataRef::DateTimeIso(_) | DataRef::DurationIso(_) => {
                let text = match cell.get_value() {
                    DataRef::SharedString(text) => text,
                    DataRef::String(text) | DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => text.as_str(),
                    _ => "",
                };
                text.replace(['\t', '\n', '\r', '"'], " ")
            }
            DataRef::Error(_) => "nan".into(),
        };
        if own_column as usize >= MAX_COLUMNS {
            return Err(format!("more than {MAX_COLUMNS} columns"));
        }
        // Rows without cells are omitted.
        if own_row > row {
            text.push_str(if text.is_empty() { "" } else { "\n" });
            (row, column) = (own_row, 0);
        }
        let tabs = own_column.saturating_sub(column) as usize;
        budget.draw(tabs + shown.len() + 1)?;
        text.extend(std::iter::repeat_n('\t', tabs));
        column = own_column;
        text.push_str(&shown);
    }
    text.push('\n');
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A zip archive of these files (name and text), without compression.
    fn zip(files: &[(&str, &str)]) -> Vec<u8> {
        let (mut out, mut directory) = (Vec::new(), Vec::new());
        for (name, text) in files {
            let mut crc = flate2::Crc::new();
            crc.update(text.as_bytes());
            let (length, name_length) = ((text.len() as u32).to_le_bytes(), (name.len() as u16).to_le_bytes());
            let fields = [
                &[20, 0, 0, 0, 0, 0, 0, 0, 0, 0][..],
                &crc.sum().to_le_bytes(),
                &length,
                &length,
                &name_length,
                &[0, 0],
            ];
            let offset = (out.len() as u32).to_le_bytes();
            out.extend([&b"PK\x03\x04"[..], &fields.concat(), name.as_bytes(), text.as_bytes()].concat());
            let rest = [&[0; 10][..], &offset, name.as_bytes()].concat();
            directory.extend([&b"PK\x01\x02\x14\x00"[..], &fields.concat(), &rest].concat());
        }
        let count = (files.len() as u16).to_le_bytes();
        let sizes = [(directory.len() as u32).to_le_bytes(), (out.len() as u32).to_le_bytes()].concat();
        out.extend(directory);
        out.extend([&b"PK\x05\x06\0\0\0\0"[..], &count, &count, &sizes, &[0, 0]].concat());
        out
    }

    fn book(rows: &str) -> Vec<u8> {
        let main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
        let relations = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
        let package = "http://schemas.openxmlformats.org/package/2006/relationships";
        zip(&[
            ("[Content_Types].xml", "<Types/>"),
            (
                "_rels/.rels",
                &format!(
                    "<Relationships xmlns=\"{package}\"><Relationship Id=\"w\" Type=\"{relations}/officeDocument\" \
                     Target=\"xl/workbook.xml\"/></Relationships>"
                ),
            ),
            (
                "xl/workbook.xml",
                &format!(
                    "<workbook xmlns=\"{main}\" xmlns:r=\"{relations}\"><sheets><sheet name=\"note\" sheetId=\"1\" r:id=\"a\"/>\
                     <sheet name=\"log\" sheetId=\"2\" r:id=\"b\"/></sheets></workbook>"
                ),
            ),
            (
                "xl/_rels/workbook.xml.rels",
                &format!(
                    "<Relationships xmlns=\"{package}\"><Relationship Id=\"a\" Type=\"{relations}/worksheet\" \
                     Target=\"worksheets/s1.xml\"/><Relationship Id=\"b\" Type=\"{relations}/worksheet\" \
                     Target=\"worksheets/s2.xml\"/></Relationships>"
                ),
            ),
            (
                "xl/worksheets/s1.xml",
                &format!(
                    "<worksheet xmlns=\"{main}\"><sheetData><row r=\"1\"><c r=\"A1\" t=\"inlineStr\"><is><t>made by x</t></is></c></row></sheetData></worksheet>"
                ),
            ),
            ("xl/worksheets/s2.xml", &format!("<worksheet xmlns=\"{main}\"><sheetData>{rows}</sheetData></worksheet>")),
        ])
    }

    fn text(cell: &str, text: &str) -> String {
        format!("<c r=\"{cell}\" t=\"inlineStr\"><is><t>{text}</t></is></c>")
    }

    #[test]
    fn the_first_sheet_with_numbers_is_a_table() {
        let rows = format!(
            "<row r=\"1\">{}{}</row><row r=\"3\"><c r=\"A3\"><v>0</v></c><c r=\"B3\"><v>1.5</v></c></row>\
             <row r=\"4\"><c r=\"A4\"><v>0.1</v></c></row>",
            text("A1", "t"),
            text("B1", "q1")
        );
        let mut budget = Budget::of(1000);
        let table = read("x.xlsx", &book(&rows), &mut budget).unwrap();
        assert_eq!((table.header.join(" "), &table.columns[0]), ("t q1".into(), &vec![0.0, 0.1]));
        assert!(table.columns[1][0] == 1.5 && table.columns[1][1].is_nan());
        assert!(table.notes[0].contains("sheet `log` is read"), "{:?}", table.notes);
    }

    #[test]
    fn damage_and_far_cells_are_refused() {
        let refused = |bytes: &[u8]| read("x.xlsx", bytes, &mut Budget::of(1000)).unwrap_err().to_string();
        assert!(refused(&book("")).contains("none of its 2 sheets holds numbers"));
        let far = book("<row r=\"1048576\"><c r=\"XFD1048576\"><v>1</v></c></row>");
        assert!(refused(&far).contains("more than 10000 columns"), "{}", refused(&far));
        let whole = book("<row r=\"1\"><c r=\"A1\"><v>1</v></c></row>");
        for end in (0..whole.len()).step_by(7) {
            assert!(refused(&whole[..end]).contains("the workbook cannot be read"));
        }
    }
}
