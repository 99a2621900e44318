//! The matrix B from standard parameters phi to base parameters X = B phi. Standard parameters: ten inertial parameters of each
//! link, and rotor inertias. Base parameters: the linear combinations of them that the torques determine.

use nalgebra::DMatrix;

/// The map from the standard parameters of a robot's links to its base parameters.
#[derive(Clone, Debug)]
pub struct StandardMap {
    /// Names of the standard parameters.
    pub standard: Vec<String>,
    /// The matrix B of X = B phi: one row per base parameter, one column per standard parameter.
    pub matrix: DMatrix<f64>,
    /// Name and first column of each link. A link has ten columns: XX XY XZ YY YZ ZZ MX MY MZ M.
    pub bodies: Vec<(String, usize)>,
    /// The columns of the rotor inertias IA, which cannot be negative.
    pub rotors: Vec<usize>,
}

impl StandardMap {
    /// Makes a map from the non-zero entries of B: (row of the base parameter, column of the standard parameter, coefficient).
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
