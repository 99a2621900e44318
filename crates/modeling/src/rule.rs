//! A regrouping rule as people write it: equal coefficients share a parenthesis.

use expr::Graph;

use crate::coefficient::Coefficient;

/// A coefficient as text: a sign and what stands behind it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Factor {
    negative: bool,
    /// `1`, `D2^2`, `(D4 - D2)`.
    magnitude: String,
}

impl Factor {
    pub fn one() -> Factor {
        Factor { negative: false, magnitude: "1".into() }
    }

    pub fn exact(c: &Coefficient, graph: &Graph) -> Factor {
        let text = c.display(graph).to_string();
        match text.strip_prefix('-') {
            Some(rest) if !is_sum(rest) => Factor { negative: true, magnitude: rest.to_string() },
            _ if is_sum(&text) => {
                let minus = c.negated().display(graph).to_string();
                // The sign that lets the same sum serve both ways.
                if minus < text {
                    Factor { negative: true, magnitude: format!("({minus})") }
                } else {
                    Factor { negative: false, magnitude: format!("({text})") }
                }
            }
            _ => Factor { negative: false, magnitude: text },
        }
    }

    pub fn number(x: f64) -> Factor {
        Factor { negative: x < 0.0, magnitude: format!("{}", x.abs()) }
    }

    pub fn text(&self) -> String {
        format!("{}{}", if self.negative { "-" } else { "" }, self.magnitude)
    }
}

fn is_sum(text: &str) -> bool {
    text.contains(" + ") || text.contains(" - ")
}

/// `XXR2 = XX2 - YY2 - D2^2*(M3 + M4)` from parameters with their factors, own first.
pub(crate) fn text(left: &str, terms: &[(usize, Factor)], name: &impl Fn(usize) -> String) -> String {
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
