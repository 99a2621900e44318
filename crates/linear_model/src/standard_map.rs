//! The numerical map from standard parameters to base parameters: X = B phi.

use nalgebra::DMatrix;

/// The map from the standard parameters of a robot's links to its base parameters.
#[derive(Clone, Debug)]
pub struct StandardMap {
    /// Names of the standard parameters.
    pub standard: Vec<String>,
    /// B of X = B phi: number of base parameters x number of standard parameters.
    pub matrix: DMatrix<f64>,
    /// Name and first column of each link; a link has ten columns, in the order XX XY XZ YY YZ ZZ MX MY MZ M.
    pub bodies: Vec<(String, usize)>,
    /// Columns that cannot be negative: the rotor inertias IA.
    pub rotors: Vec<usize>,
}

impl StandardMap {
    /// A map from the entries (base, standard, coefficient) of B.
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
