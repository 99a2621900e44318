//! How the base parameters follow from the standard ones, in numbers: X = B phi.

use nalgebra::DMatrix;

/// How the base parameters of a robot follow from the standard ones of its links.
#[derive(Clone, Debug)]
pub struct StandardMap {
    /// Names of the standard parameters.
    pub standard: Vec<String>,
    /// X = B phi: base x standard.
    pub matrix: DMatrix<f64>,
    /// A link's name and its first column; ten in the order XX XY XZ YY YZ ZZ MX MY MZ M.
    pub bodies: Vec<(String, usize)>,
    /// Columns that no motor can have negative: IA.
    pub rotors: Vec<usize>,
}

impl StandardMap {
    /// From the entries (base, standard, coefficient) of B.
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
