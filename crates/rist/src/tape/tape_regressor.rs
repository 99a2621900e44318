//! Base regressor of any robot, evaluated by a tape (a list of arithmetic operations). No compiler is needed.
//!
//! tau = Y(q, dq, ddq) X. Y: base regressor; X: base parameters. For robots that are built in, compiled code is used instead of
//! a tape.

use expr::Function;
use linear_model::parameter::BaseParameter;
use linear_model::regressor::{Coordinate, Eight, Regressor};
use modeling::Closure;

use crate::tape::state_tape::StateTape;

/// The base regressor Y of tau = Y(q, dq, ddq) X (X: base parameters), evaluated by a tape (a list of arithmetic operations).
pub(crate) struct TapeRegressor {
    tape: StateTape,
    coordinates: Vec<String>,
    prismatic: Vec<bool>,
    parameters: Vec<BaseParameter>,
    non_zeros: Vec<(usize, usize)>,
    /// For each entry of Y that is not always zero: the index of this entry if Y is written row by row.
    places: Vec<usize>,
}

impl TapeRegressor {
    /// Makes the regressor from the function of Y. `closure`: the solver for passive joints, if the robot has some.
    pub(crate) fn new(
        base: &Function,
        closure: Option<Closure>,
        coordinates: Vec<Coordinate>,
        parameters: Vec<BaseParameter>,
    ) -> TapeRegressor {
        let (non_zeros, p) = (base.non_zeros(0), parameters.len());
        let places = non_zeros.iter().map(|(i, c)| i * p + c).collect();
        TapeRegressor {
            tape: StateTape::new(base, closure),
            prismatic: coordinates.iter().map(|c| c.is_prismatic).collect(),
            coordinates: coordinates.into_iter().map(|c| c.name).collect(),
            parameters,
            non_zeros,
            places,
        }
    }
}

impl Regressor for TapeRegressor {
    fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    fn parameters(&self) -> &[BaseParameter] {
        &self.parameters
    }

    fn is_prismatic(&self, k: usize) -> bool {
        self.prismatic[k]
    }

    fn non_zeros(&self) -> Vec<(usize, usize)> {
        self.non_zeros.clone()
    }

    fn fill(&self, q: &[f64], dq: &[f64], ddq: &[f64], y: &mut [f64]) {
        self.tape.fill(std::iter::once([q, dq, ddq]), &[], &[], y);
    }

    fn fill_many(&self, states: &[f64], y: &mut [f64]) {
        let n = self.coordinates.len();
        if !y.is_empty() {
            self.tape.fill(states.chunks_exact(3 * n).map(|s| [&s[..n], &s[n..2 * n], &s[2 * n..]]), &[], &[], y);
        }
    }

    fn fill_blocks(&self, states: &[f64], stride: usize, blocks: &mut [Eight]) {
        let n = self.coordinates.len();
        if self.non_zeros.is_empty() {
            return;
        }
        self.tape.lanes(states, n, &self.places, |g, e, values| blocks[g * stride + e] = Eight(values));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::model::{base_columns, coordinates};
    use modeling::Derivation;
    use std::path::Path;

    #[test]
    fn many_are_those_of_one() {
        for name in ["tree.yaml", "sr400.par"] {
            let path = format!("{}/../../models/{name}", env!("CARGO_MANIFEST_DIR"));
            let robot = robot::format::read(Path::new(&path)).unwrap();
            let mut derivation = Derivation::new(&robot).unwrap();
            let standard = derivation.regressor();
            let base = derivation.base_parameters(&standard).unwrap();
            let function = base.regressor(&standard).bound();
            let columns = base_columns(&robot, &base);
            let arm = TapeRegressor::new(&function, derivation.closure(), coordinates(&robot), columns);
            let (n, size) = (arm.coordinates.len(), arm.coordinates.len() * arm.parameters.len());
            for count in [0, 1, 77] {
                let states: Vec<f64> = (0..count * 3 * n).map(|i| (0.7 * i as f64).sin() * 1.3).collect();
                let mut many = vec![f64::INFINITY; count * size];
                arm.fill_many(&states, &mut many);
                for (s, many) in states.chunks_exact(3 * n).zip(many.chunks_exact(size)) {
                    let mut one = vec![0.0; size];
                    arm.fill(&s[..n], &s[n..2 * n], &s[2 * n..], &mut one);
                    assert!(one.iter().zip(many).all(|(a, b)| a.to_bits() == b.to_bits()), "{name}");
                }
                // Blocks of eight states are computed in SIMD lanes. The stride between blocks is one larger than a block, so one
                // entry per block is unused.
                let (entries, eights) = (arm.non_zeros(), count / 8);
                let stride = entries.len() + 1;
                let mut blocks = vec![Eight([f64::INFINITY; 8]); eights * stride];
                arm.fill_blocks(&states[..eights * 8 * 3 * n], stride, &mut blocks);
                for (r, many) in many.chunks_exact(size).take(8 * eights).enumerate() {
                    for (eight, (i, c)) in blocks[r / 8 * stride..].iter().zip(&entries) {
                        let expected = many[i * arm.parameters.len() + c];
                        assert_eq!(eight.0[r % 8].to_bits(), expected.to_bits(), "{name}");
                    }
                    assert!(blocks[r / 8 * stride + entries.len()].0[0].is_infinite(), "the gap stays");
                }
            }
        }
    }
}
