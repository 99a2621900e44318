//! Writes a regrouping rule as text. The rule gives a base parameter as a sum of standard parameters. Parameters with
//! coefficients of equal magnitude share a parenthesis.

use crate::base::coefficient::Coefficient;

/// A coefficient of a rule as text: a sign and a magnitude.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Factor {
    negative: bool,
    /// Text of the coefficient without sign: `1`, `D2^2`, `cos(2*DEL)`.
    magnitude: String,
}

impl Factor {
    pub(crate) fn one() -> Factor {
        Factor { negative: false, magnitude: "1".into() }
    }

    /// The summands of a coefficient, each as text; `name` gives the name of a symbol index.
    pub(crate) fn summands(c: &Coefficient, name: &dyn Fn(u32) -> String) -> Vec<Factor> {
        let factor = |c: Coefficient| {
            let text = c.display(name).to_string();
            match text.strip_prefix('-') {
                Some(rest) => Factor { negative: true, magnitude: rest.to_string() },
                None => Factor { negative: false, magnitude: text },
            }
        };
        c.summands().into_iter().map(factor).collect()
    }

    pub(crate) fn number(x: f64) -> Factor {
        Factor { negative: x < 0.0, magnitude: rounded(x.abs()).to_string() }
    }
}

/// The decimal number of eleven significant digits nearest to x. A numeric coefficient of the scan has no more valid digits.
pub(crate) fn rounded(x: f64) -> f64 {
    format!("{x:.10e}").parse().unwrap_or(x)
}

/// The text of a rule, `XXR2 = XX2 - YY2 - D2^2*(M3 + M4)`. `left`: name of the base parameter; `terms`: pairs (parameter,
/// factor); the first pair belongs to the parameter that gives the base parameter its name.
pub(crate) fn text(left: &str, terms: &[(usize, Factor)], name: &impl Fn(usize) -> String) -> String {
    // Parameters with coefficients of equal magnitude share a parenthesis.
    let mut groups: Vec<(&str, Vec<(bool, usize)>)> = Vec::new();
    for (parameter, factor) in terms {
        match groups.iter_mut().find(|g| g.0 == factor.magnitude) {
            Some(g) => g.1.push((factor.negative, *parameter)),
            None => groups.push((&factor.magnitude, vec![(factor.negative, *parameter)])),
        }
    }
    let mut text = format!("{left} =");
    for (i, (magnitude, members)) in groups.iter().enumerate() {
        let sum = |flip: bool| {
            let mut sum = String::new();
            for (m, &(negative, parameter)) in members.iter().enumerate() {
                let sign = match (negative != flip, m) {
                    (false, 0) => "",
                    (true, 0) => "-",
                    (false, _) => " + ",
                    (true, _) => " - ",
                };
                sum += &format!("{sign}{}", name(parameter));
            }
            sum
        };
        // The sign of the first member stands before the parenthesis; a minus inverts all signs inside.
        let negative = members[0].0;
        let sign = match (i, negative) {
            (0, false) => " ",
            (0, true) => " -",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        text += sign;
        text += &match (*magnitude, members.len()) {
            ("1", _) => sum(negative),
            (_, 1) => format!("{magnitude}*{}", sum(negative)),
            _ => format!("{magnitude}*({})", sum(negative)),
        };
    }
    text
}
