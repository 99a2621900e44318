//! The map from the standard parameters to the base parameters in numbers: X = B phi.

use nalgebra::DMatrix;

/// The map from the standard parameters of a robot's links to its base parameters.
#[derive(Clone, Debug)]
pub struct StandardMap {
    /// Names of the standard parameters.
    pub standard: Vec<String>,
    /// X = B phi: base x standard.
    pub matrix: DMatrix<f64>,
    /// Each link's name and first column; a link has ten, in the order XX XY XZ YY YZ ZZ MX MY MZ M.
    pub bodies: Vec<(String, usize)>,
    /// Columns that cannot be negative: the rotor inertias IA.
    pub rotors: Vec<usize>,
}

impl StandardMap {
    /// Makes the map from the entries (base, standard, coefficient) of B.
    pub fn new(
        standard: Vec<String>,
        base: usize,
        terms: &[(usize, usize, f64)],
        bodies: Vec<(String, usize)>,
        rotors: Vec<usize>,
    ) -> StandardMap {
        let mut matrix = DMatrix::zeros(base, standard.len());
        for &(k, c, coefficient) in terms {
            matrix[(k, c)] += coefficient;
        }
        StandardMap { standard, matrix, bodies, rotors }
    }
}
