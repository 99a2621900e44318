//! Draws two charts for README: the time of one call compared with Pinocchio (docs/benchmarks.md), and the torque error on
//! measured robots (docs/identification.md). The numbers are read from the tables of these pages, so the charts always agree with
//! them.

use super::canvas::{Anchor, Canvas, Ink};
use crate::cargo::root;

const CALLS: (&str, &str) = ("docs/benchmarks.md", "| one call, ns | Pinocchio | rist | ratio |");
const MEASURED: (&str, &str) =
    ("docs/identification.md", "| set | independent baseline | same recipe | recommended | recommended recipe |");
/// For each robot in the chart, the first words of its row in the table. The table has more rows.
const SETS: [&str; 5] = ["Panda,", "TX40,", "UR10e, id_30s -> id_40s", "cobot6,", "KR300,"];

/// The cells of the rows below the header `header` of a table in the file `page`.
fn table((page, header): (&str, &str)) -> Result<Vec<Vec<String>>, String> {
    let text = std::fs::read_to_string(root().join(page)).map_err(|e| format!("{page}: {e}"))?;
    let (_, rest) = text.split_once(header).ok_or(format!("{page} has no table `{header}`"))?;
    let rows = rest.lines().skip(2).take_while(|line| line.starts_with('|'));
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect();
    Ok(rows.map(cells).collect())
}

/// The number in cell `place` of a table row, counted from 0.
fn number(row: &[String], place: usize) -> Result<f64, String> {
    let text = row.get(place).map_or("", |cell| cell.as_str());
    text.parse().map_err(|_| format!("`{}`: `{text}` is no number", row.join(" | ")))
}

pub(crate) fn draw() -> Result<String, String> {
    let title = "Time of one call of the regressor, and error of torques on measured robots";
    let mut canvas = Canvas::new(760.0, 350.0, title);
    calls(&mut canvas)?;
    measured(&mut canvas)?;
    Ok(canvas.finish())
}

fn calls(canvas: &mut Canvas) -> Result<(), String> {
    canvas.heading((20.0, 28.0), "one call of the regressor, ns");
    let rows = table(CALLS)?;
    let all: Vec<f64> = rows.iter().map(|row| number(row, 1)).collect::<Result<_, _>>()?;
    let largest = all.into_iter().fold(1.0, f64::max);
    for (k, row) in rows.iter().enumerate() {
        let y = 58.0 + 66.0 * k as f64;
        canvas.words((20.0, y), Anchor::Start, Ink::Word, &row[0]);
        for (shift, name, place, ink) in [(8.0, "Pinocchio", 1, Ink::Orange), (26.0, "rist", 2, Ink::Blue)] {
            let ns = number(row, place)?;
            let width = 200.0 * ns / largest;
            canvas.bar((20.0, y + shift), width.max(1.0), 14.0, ink);
            canvas.words((28.0 + width, y + shift + 12.0), Anchor::Start, Ink::Word, &format!("{name} {ns}"));
        }
    }
    for (k, line) in ["Pinocchio: all standard columns; rist: the base", "columns, generated (docs/benchmarks.md)"]
        .iter()
        .enumerate()
    {
        canvas.words((20.0, 282.0 + 20.0 * k as f64), Anchor::Start, Ink::Word, line);
    }
    Ok(())
}

fn measured(canvas: &mut Canvas) -> Result<(), String> {
    canvas.heading((400.0, 28.0), "measured arms, a motion not fitted: error, %");
    let rows = table(MEASURED)?;
    let found =
        |set: &str| rows.iter().find(|row| row[0].starts_with(set)).ok_or(format!("{} has no {set}", MEASURED.0));
    let rows = SETS.map(found).into_iter().collect::<Result<Vec<_>, _>>()?;
    for (k, row) in rows.into_iter().enumerate() {
        let y = 58.0 + 44.0 * k as f64;
        let name = row[0].split(',').next().unwrap_or("");
        canvas.words((400.0, y + 12.0), Anchor::Start, Ink::Word, name);
        for (shift, what, place, ink) in [(-8.0, "baseline", 1, Ink::Orange), (8.0, "rist", 3, Ink::Blue)] {
            let percent = 100.0 * number(row, place)?;
            let width = 4.2 * percent;
            canvas.bar((460.0, y + shift), width, 14.0, ink);
            canvas.words((468.0 + width, y + shift + 12.0), Anchor::Start, Ink::Word, &format!("{what} {percent:.1}"));
        }
    }
    for (k, line) in ["baseline: weighted least squares, independent", "of rist (docs/identification.md, Measured)"]
        .iter()
        .enumerate()
    {
        canvas.words((400.0, 302.0 + 20.0 * k as f64), Anchor::Start, Ink::Word, line);
    }
    Ok(())
}
