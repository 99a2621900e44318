//! Factors a symmetric matrix of expressions as L D L^T [Cholesky]. The inertia matrix is positive definite for physical
//! parameters, so no pivot is zero. A division takes about as long as ten products. So each pivot is inverted once, and every
//! division by the pivot becomes a product with the inverse.

use expr::{Expr, Graph};

/// A symmetric matrix factored as L D L^T. The rows and columns of the matrix are in reverse order. So the coordinate of a link
/// comes before the coordinates of the links that carry this link. Eliminating the carried links first preserves the zeros
/// between branches of a tree [Featherstone 2005].
pub(crate) struct Factor {
    n: usize,
    /// The factors in one n x n matrix, row by row: L^T above the diagonal, and D on the diagonal. The entries below the
    /// diagonal are not used.
    a: Vec<Expr>,
}

impl Factor {
    /// Factors the symmetric n x n matrix `a`, given row by row, as L D L^T.
    pub(crate) fn new(g: &mut Graph, mut a: Vec<Expr>, n: usize) -> Factor {
        a.reverse();
        // Elimination column by column: L^T replaces A above the diagonal, and D replaces the diagonal.
        for c in 0..n {
            for r in c + 1..n {
                let scaled = a[r * n + c];
                if scaled.is_zero() {
                    continue;
                }
                let l = over(g, scaled, a[c * n + c]);
                for k in c + 1..=r {
                    let product = g.mul(l, a[k * n + c]);
                    a[r * n + k] = g.sub(a[r * n + k], product);
                }
            }
            for r in c + 1..n {
                let l = if a[r * n + c].is_zero() { Expr::ZERO } else { over(g, a[r * n + c], a[c * n + c]) };
                a[c * n + r] = l;
            }
        }
        Factor { n, a }
    }

    /// The entry (r, c) of L, r > c. It is stored as the entry (c, r) of L^T.
    fn l(&self, r: usize, c: usize) -> Expr {
        self.a[c * self.n + r]
    }

    /// The solution x of A x = right, with the factored matrix A.
    pub(crate) fn solve(&self, g: &mut Graph, mut right: Vec<Expr>) -> Vec<Expr> {
        right.reverse();
        let mut x = self.solve_reversed(g, right);
        x.reverse();
        x
    }

    fn solve_reversed(&self, g: &mut Graph, mut right: Vec<Expr>) -> Vec<Expr> {
        let n = self.n;
        for c in 0..n {
            for r in c + 1..n {
                let carried = g.mul(self.l(r, c), right[c]);
                right[r] = g.sub(right[r], carried);
            }
        }
        for r in (0..n).rev() {
            let mut value = if right[r].is_zero() { Expr::ZERO } else { over(g, right[r], self.a[r * n + r]) };
            for k in r + 1..n {
                let product = g.mul(self.l(k, r), right[k]);
                value = g.sub(value, product);
            }
            right[r] = value;
        }
        right
    }

    /// The product A^-1 B with the factored matrix A, both matrices row by row.
    pub(crate) fn solve_columns(&self, g: &mut Graph, b: &[Expr]) -> Vec<Expr> {
        let n = self.n;
        let columns: Vec<Vec<Expr>> = (0..n).map(|c| self.solve(g, (0..n).map(|r| b[r * n + c]).collect())).collect();
        (0..n * n).map(|k| columns[k % n][k / n]).collect()
    }

    /// The inverse A^-1 = L^-T D^-1 L^-1 of the factored matrix, row by row. Entries above the diagonal follow from symmetry.
    pub(crate) fn inverse(&self, g: &mut Graph) -> Vec<Expr> {
        let n = self.n;
        let mut inverse = vec![Expr::ZERO; n * n];
        for c in (0..n).rev() {
            let unit = (0..n).map(|r| if r == c { Expr::ONE } else { Expr::ZERO }).collect();
            let column = self.solve_reversed(g, unit);
            for r in c..n {
                inverse[r * n + c] = column[r];
                inverse[c * n + r] = column[r];
            }
        }
        inverse.reverse();
        inverse
    }
}

/// The quotient x / pivot, computed as x times the inverse of the pivot. The expression graph shares equal expressions, so the
/// inverse is computed once.
fn over(g: &mut Graph, x: Expr, pivot: Expr) -> Expr {
    let inverse = g.div(Expr::ONE, pivot);
    g.mul(x, inverse)
}
