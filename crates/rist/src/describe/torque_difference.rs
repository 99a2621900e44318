//! Computes the largest torque difference between two descriptions of one robot.
//!
//! ```text
//! max over states of  |tau_a - tau_b|_inf / |tau_a|_inf
//! ```
//! over a few random states. tau_a and tau_b are computed with the inertial parameters of each description; a body without
//! inertial parameters counts as a body of 1 kg in its frame of the file. The result shows values that a reader rounded or a
//! writer lost.

use expr::Tape;
use modeling::{Closure, Derivation};
use robot::{Inertial, Robot, StandardParameter, transform_inertial};

/// Number of random states. Few are enough, because almost every difference shows at any random state.
const N_STATES: usize = 5;

/// Rotor inertia of a joint whose description gives none, kg m^2.
const DEFAULT_ROTOR_INERTIA: f64 = 0.1;

/// Inertial parameters of a body of 1 kg in the frame that the file gives the body: XX XY XZ YY YZ ZZ (kg m^2), MX MY MZ (kg
/// m), M (kg).
const UNIT_BODY: [f64; 10] = [0.06, 0.01, -0.01, 0.05, 0.01, 0.07, 0.1, -0.05, 0.08, 1.0];

/// The largest relative difference of the torques. `None` if the numbers of coordinates differ, if a loop does not close, or if
/// a symbol has no value.
pub fn torque_difference(a: &Robot, b: &Robot) -> Option<f64> {
    let n = a.n_coordinates();
    if n == 0 || n != b.n_coordinates() || a.symbols.iter().chain(&b.symbols).any(|s| s.generic) {
        return None;
    }
    // Coordinates are paired by name if all names agree. Otherwise they are paired by order, because a writer may have to
    // rename coordinates.
    let place = |k: usize| b.coordinates.iter().position(|c| c.name == a.coordinates[k].name);
    let order: Vec<usize> = (0..n).map(place).collect::<Option<_>>().unwrap_or_else(|| (0..n).collect());
    let (mut of_a, mut of_b) = (Torque::new(a)?, Torque::new(b)?);
    let mut largest = 0.0_f64;
    for s in 0..N_STATES {
        let state: Vec<[f64; 3]> = (0..n).map(|k| [0, 1, 2].map(|order| motion(s, k, order))).collect();
        let mut moved = vec![[0.0; 3]; n];
        order.iter().zip(&state).for_each(|(&k, x)| moved[k] = *x);
        let (tau_a, tau_b) = (of_a.at(&state)?, of_b.at(&moved)?);
        let norm = tau_a.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let off = order.iter().zip(&tau_a).fold(0.0_f64, |m, (&k, x)| m.max((x - tau_b[k]).abs()));
        largest = largest.max(if norm > 0.0 { off / norm } else { off });
    }
    largest.is_finite().then_some(largest)
}

/// q, dq or ddq (`order` = 0, 1, 2) of a coordinate in state number `state`: quasi-random numbers between -1 and 1.
fn motion(state: usize, coordinate: usize, order: usize) -> f64 {
    let x = (1 + state) as f64 * 0.754_877_666 + (1 + coordinate) as f64 * 0.569_840_291 + order as f64 * 0.337_521_5;
    2.0 * (x - x.floor()) - 1.0
}

struct Torque {
    tape: Tape,
    closure: Option<Closure>,
    x: Vec<f64>,
}

impl Torque {
    fn new(robot: &Robot) -> Option<Torque> {
        let mut derivation = Derivation::new(robot).ok()?;
        let torque = derivation.torque().bound();
        let value = |p: StandardParameter| {
            let link = robot.link(p.link);
            let body = || link.inertial.unwrap_or_else(|| transform_inertial(&UNIT_BODY, &link.file_frame));
            match p.inertial {
                Inertial::Ia => p.value(robot).unwrap_or(DEFAULT_ROTOR_INERTIA),
                inertial => body()[inertial as usize],
            }
        };
        let x = StandardParameter::all(robot).into_iter().map(value).collect();
        Some(Torque { tape: Tape::new(&torque), closure: derivation.closure(), x })
    }

    fn at(&mut self, state: &[[f64; 3]]) -> Option<Vec<f64>> {
        let q: Vec<f64> = state.iter().map(|x| x[0]).collect();
        let passive = match &mut self.closure {
            Some(closure) => closure.passive(&q).ok()?,
            None => Vec::new(),
        };
        let rates = [1, 2].into_iter().flat_map(|order| state.iter().map(move |x| x[order]));
        let inputs: Vec<f64> = q.iter().copied().chain(passive).chain(rates).chain(self.x.iter().copied()).collect();
        let mut tau = vec![0.0; self.tape.n_outputs()];
        self.tape.evaluate(&inputs, &mut self.tape.workspace(), &mut tau);
        Some(tau)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilt_shows_and_an_order_does_not() {
        let robot = |alpha: &str| {
            let text = format!(
                "convention: khalil-kleinfinger\nname: two\nlinks:\n  - {{link: 1, antecedent: base, theta: q1}}\n  - \
                 {{link: 2, antecedent: 1, alpha: {alpha}, d: 0.5, theta: q2}}\n"
            );
            robot::format::read_yaml(&text, "two.yaml").unwrap()
        };
        let straight = robot("pi/2");
        assert_eq!(torque_difference(&straight, &straight), Some(0.0));
        let tilted = torque_difference(&straight, &robot("pi/2 + 0.001")).unwrap();
        assert!(tilted > 1e-5 && tilted < 1e-1, "{tilted}");
        let mut turned = straight.clone();
        turned.coordinates.swap(0, 1);
        for link in &mut turned.links {
            link.joint.variable.terms[0].0.0 ^= 1;
        }
        assert!(torque_difference(&straight, &turned).unwrap() < 1e-14);
    }
}
