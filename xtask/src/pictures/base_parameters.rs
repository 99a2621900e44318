//! Draws which standard parameters of a two-link arm are identifiable from torques, and their combinations (base parameters).
//!
//! Standard parameters are the ten inertial parameters of each link, and rotor inertias.

use modeling::Derivation;
use robot::StandardParameter;

use super::canvas::{Anchor, Canvas, Ink};
use crate::cargo::root;

const MODEL: &str = "models/planar2r_vertical.yaml";
/// Distance between rows, pixels.
const ROW_PX: f64 = 19.0;

pub(crate) fn draw() -> Result<String, String> {
    let robot = robot::format::read(&root().join(MODEL)).map_err(|e| e.to_string())?;
    let standard = StandardParameter::all(&robot);
    let mut derivation = Derivation::new(&robot).map_err(|e| e.to_string())?;
    let regressor = derivation.regressor();
    let parameters = derivation.base_parameters(&regressor).map_err(|e| e.to_string())?;
    let lines = parameters.rule_lines();
    let title = "22 standard parameters of a two-link arm, and the 7 sums of them that are identifiable from torques";
    let mut canvas = Canvas::new(760.0, 90.0 + ROW_PX * standard.len() as f64, title);
    canvas.heading((20.0, 28.0), &format!("{} standard parameters", standard.len()));
    canvas.heading((400.0, 28.0), &format!("{} base parameters: identifiable from torques", lines.len()));
    // Standard parameters are on the left, base parameters on the right. A line connects each base parameter with each of its
    // terms.
    let left = |k: usize| (110.0, 58.0 + ROW_PX * k as f64);
    let step = ROW_PX * standard.len() as f64 / lines.len() as f64;
    let right = |b: usize| (400.0, 58.0 + step * (b as f64 + 0.35));
    let mut is_identifiable = vec![false; standard.len()];
    for (b, parameter) in parameters.base.iter().enumerate() {
        for (k, term) in parameter.terms.iter().enumerate() {
            let ((x, y), (end, height)) = (left(term.parameter), right(b));
            is_identifiable[term.parameter] = true;
            let ink = if k == 0 { Ink::Blue } else { Ink::Orange };
            canvas.line((x + 8.0, y - 5.0), (end - 8.0, height - 5.0), ink, if k == 0 { 1.8 } else { 1.4 });
        }
        canvas.words(right(b), Anchor::Start, Ink::Word, &lines[b]);
    }
    // A parameter that belongs to no base parameter has no effect on any torque; it is drawn in grey.
    for (k, parameter) in standard.iter().enumerate() {
        let ink = if is_identifiable[k] { Ink::Word } else { Ink::Faint };
        canvas.words(left(k), Anchor::End, ink, &parameter.display(&robot).to_string());
    }
    let foot = 76.0 + ROW_PX * standard.len() as f64;
    canvas.words((20.0, foot), Anchor::Start, Ink::Faint, "grey: no torque of this arm ever shows it");
    canvas.words((400.0, foot), Anchor::Start, Ink::Orange, "orange: acts only together with another one");
    Ok(canvas.finish())
}
