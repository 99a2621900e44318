//! Draws the verdict on the estimate of the UR5 in the README: residuals with nominal and with identified parameters, and the
//! level of trust for each use. The numbers are read from the program output in README.md. A test compares this output with the
//! program.

use super::canvas::{Anchor, Canvas, Ink};
use crate::cargo::root;

const PAGE: &str = "README.md";
/// The first words of the table of uses in the output.
const USES: &str = "use  ";
/// Distance between rows, pixels.
const ROW_PX: f64 = 34.0;
/// Length of the longest bar, pixels.
const LONGEST_BAR_PX: f64 = 210.0;

pub(super) fn draw() -> Result<String, String> {
    let page = std::fs::read_to_string(root().join(PAGE)).map_err(|e| format!("{PAGE}: {e}"))?;
    // Line breaks are removed, because a sentence of the output may extend over two lines.
    let text = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let nominal = percent(&text, "relative residual of this log: ")?;
    let identified = percent(&text, "with the nominal parameters, ")?;
    let other = percent(&text, "relative residual of logs that were not fitted: ")?;
    let uses: Vec<[&str; 3]> = page
        .lines()
        .skip_while(|line| !line.starts_with(USES))
        .skip(1)
        .map_while(|line| {
            let cells: Vec<&str> = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
            cells.try_into().ok()
        })
        .collect();
    if uses.is_empty() {
        return Err(format!("{PAGE}: no line below `{USES}..` has a use, its trust and its uncertainty"));
    }
    let mut canvas =
        Canvas::new(760.0, 190.0, "A UR5 with an unknown gripper: residual before and after, and trust by use");
    canvas.heading((16.0, 28.0), "Relative residual of the torques");
    let bars = [
        ("nominal parameters", nominal, Ink::Orange),
        ("identified", identified, Ink::Blue),
        ("another log", other, Ink::Blue),
    ];
    for (k, (name, value, ink)) in bars.into_iter().enumerate() {
        let y = 62.0 + ROW_PX * k as f64;
        canvas.words((16.0, y), Anchor::Start, Ink::Word, name);
        canvas.bar((150.0, y - 12.0), LONGEST_BAR_PX * value / nominal, 15.0, ink);
        canvas.words((158.0 + LONGEST_BAR_PX * value / nominal, y), Anchor::Start, Ink::Word, &format!("{value} %"));
    }
    canvas.heading((450.0, 28.0), "Trust, and torque uncertainty");
    for (k, [name, trust, uncertainty]) in uses.into_iter().enumerate() {
        let (y, ink) = (62.0 + ROW_PX * k as f64, if trust == "yes" { Ink::Green } else { Ink::Orange });
        canvas.dot((458.0, y - 5.0), 6.0, ink);
        canvas.words((472.0, y), Anchor::Start, ink, trust);
        canvas.words((505.0, y), Anchor::Start, Ink::Word, name);
        canvas.words((744.0, y), Anchor::End, Ink::Word, uncertainty);
    }
    canvas.words(
        (16.0, 172.0),
        Anchor::Start,
        Ink::Faint,
        "rist identify models/ur5.urdf docs/ur5/log.csv --validate docs/ur5/other.csv",
    );
    Ok(canvas.finish())
}

/// The percentage after the words `before`. Fails if there is none.
fn percent(text: &str, before: &str) -> Result<f64, String> {
    let rest = text.split_once(before).map(|(_, rest)| rest);
    let number = rest.and_then(|rest| rest.split_once(" %")).and_then(|(number, _)| number.parse().ok());
    number.ok_or_else(|| format!("{PAGE}: a percentage is expected behind `{before}`"))
}
