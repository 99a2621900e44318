//! Computes how an error that is common to a cluster of rows changes the parameters. All cluster-robust standard deviations
//! follow from this change.
//!
//! W: all weighted rows, A = W'W. W_g, e_g: rows and residuals of cluster g, A_g = W_g' W_g. Then
//!   S_g = (A - k A_g)^-1 W_g' e_g
//! is the part of the error of the estimate x (X: true parameters) that comes from the error of cluster g. With k = 1 the cluster
//! is left out: x - S_g is the fit without it, and (G - 1)/G sum_g S_g^2 is the jackknife for G clusters [Miller 1974]. A smaller
//! k corrects only partly for the error that the fit has absorbed [Liang, Zeger 1986; Bell, McCaffrey 2002].
//!
//! | module | clusters | k (share of A_g that is subtracted) |
//! |---|---|---|
//! | `replicate_deviation`, `drive_gains::replicates` | blocks of a record; bands of speed and of position | 19/20; 1/2 |
//! | `block_deviation` | logs, or blocks of a single log | 1 |
//! | `spectrum::rist_mh::misfit` | the rows of one joint in one experiment | 19/20 |

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use numerics::triangle::Triangle;

/// Ridge that is added to A - k A_g, relative to the diagonal of A. The ridge keeps the matrix invertible if A - k A_g contains
/// only rounding errors.
pub(crate) const REMAINDER_ROUNDING_SHARE: f64 = 1e-12;

/// A cluster: rows that have a common error (for example, all rows of one block of a record).
pub struct Cluster {
    /// The columns that have non-zero entries in the rows of the cluster.
    columns: Vec<usize>,
    /// `gram`: A_g = W_g' W_g. `score`: W_g' e_g. Both contain only the entries of `columns`. W_g, e_g: weighted rows and
    /// residuals of the cluster.
    gram: DMatrix<f64>,
    score: DVector<f64>,
}

impl Cluster {
    /// The cluster of all rows of a triangle (R of QR, with the right-hand side z): A_g = R'R, and W_g' e_g = R'(z - R x) at
    /// the solution x.
    pub fn of(rows: &Triangle, x: &[f64]) -> Cluster {
        let p = rows.columns();
        let r = upper(rows);
        let left = DVector::from_fn(p, |i, _| rows.at(i, p) - (i..p).map(|c| rows.at(i, c) * x[c]).sum::<f64>());
        Cluster { columns: (0..p).collect(), gram: r.tr_mul(&r), score: r.tr_mul(&left) }
    }

    /// Joins clusters to one cluster, for p parameters.
    pub fn sum<'a>(p: usize, clusters: impl IntoIterator<Item = &'a Cluster>) -> Cluster {
        let (mut gram, mut score) = (DMatrix::<f64>::zeros(p, p), DVector::<f64>::zeros(p));
        for cluster in clusters {
            for (b, &column) in cluster.columns.iter().enumerate() {
                score[column] += cluster.score[b];
                cluster.columns.iter().enumerate().for_each(|(a, &row)| gram[(row, column)] += cluster.gram[(a, b)]);
            }
        }
        Cluster { columns: (0..p).collect(), gram, score }
    }

    /// Makes a cluster from the sums of products of its rows. `columns`: the m non-zero columns; the residual is the last
    /// column.
    ///
    /// The product of columns i <= j is at index j (m + 1) + i.
    pub fn of_products(columns: Vec<usize>, products: &[f64]) -> Cluster {
        let m = columns.len();
        let at = |i: usize, j: usize| products[i.max(j) * (m + 1) + i.min(j)];
        Cluster { columns, gram: DMatrix::from_fn(m, m, at), score: DVector::from_fn(m, |i, _| at(i, m)) }
    }
}

impl Cluster {
    /// A_g = W_g' W_g and W_g' e_g of the cluster. W_g, e_g: weighted rows and residuals of the cluster.
    pub fn parts(&self) -> (&DMatrix<f64>, &DVector<f64>) {
        (&self.gram, &self.score)
    }
}

fn upper(rows: &Triangle) -> DMatrix<f64> {
    let p = rows.columns();
    DMatrix::from_fn(p, p, |i, j| if i <= j { rows.at(i, j) } else { 0.0 })
}

/// The normal matrix A = W'W of all weighted rows, with the columns of W scaled to unit norm.
pub struct FullNormalMatrix {
    scale: Vec<f64>,
    gram: DMatrix<f64>,
}

impl FullNormalMatrix {
    /// The matrix A of all rows of a triangle.
    pub fn of(rows: &Triangle) -> FullNormalMatrix {
        let r = upper(rows);
        let norms = (0..rows.columns()).map(|c| rows.column_norm(c));
        FullNormalMatrix::scaled(r.tr_mul(&r), norms.collect())
    }

    /// The normal matrix A = W'W from clusters that together contain all rows of W.
    pub fn of_clusters<'a>(p: usize, clusters: impl IntoIterator<Item = &'a Cluster>) -> FullNormalMatrix {
        let gram = Cluster::sum(p, clusters).gram;
        let norms = gram.diagonal().iter().map(|d| d.max(0.0).sqrt()).collect();
        FullNormalMatrix::scaled(gram, norms)
    }

    fn scaled(gram: DMatrix<f64>, norms: Vec<f64>) -> FullNormalMatrix {
        let scale: Vec<f64> = norms.iter().map(|&n| if n > 0.0 { 1.0 / n } else { 0.0 }).collect();
        let p = scale.len();
        FullNormalMatrix { gram: DMatrix::from_fn(p, p, |i, j| scale[i] * gram[(i, j)] * scale[j]), scale }
    }

    /// The Cholesky factor of A - k A_g. `out`: cluster g and k; `None` gives A. `held`: ridge on the scaled diagonal. Returns
    /// `None` if the matrix is not positive definite or has NaN.
    fn without(&self, out: Option<(&Cluster, f64)>, held: f64) -> Option<Cholesky<f64, Dyn>> {
        let mut left = self.gram.clone();
        if let Some((cluster, share)) = out {
            for (b, &column) in cluster.columns.iter().enumerate() {
                for (a, &row) in cluster.columns.iter().enumerate() {
                    left[(row, column)] -= share * self.scale[row] * self.scale[column] * cluster.gram[(a, b)];
                }
            }
        }
        // A parameter with a zero column gets a unit diagonal, so that the change of this parameter is 0.
        (0..self.scale.len()).for_each(|c| left[(c, c)] += if self.scale[c] > 0.0 { held } else { 1.0 });
        left.cholesky()
    }

    /// The change of the parameters by cluster g, S_g = (A - k A_g)^-1 W_g' e_g, with k = `share` and the ridge `held`. `None` if
    /// A - k A_g is not positive definite.
    pub fn moved(&self, cluster: &Cluster, share: f64, held: f64) -> Option<Vec<f64>> {
        let mut score = DVector::zeros(self.scale.len());
        for (b, &column) in cluster.columns.iter().enumerate() {
            score[column] = self.scale[column] * cluster.score[b];
        }
        let found = self.without(Some((cluster, share)), held)?.solve(&score);
        Some(self.scale.iter().zip(found.iter()).map(|(scale, x)| scale * x).collect())
    }

    /// The variance sum_g S_g^2 of each parameter, with S_g from `moved`. A cluster for which S_g cannot be computed adds
    /// nothing.
    pub fn variance(&self, clusters: &[Cluster], share: f64, held: f64) -> Vec<f64> {
        let mut variance = vec![0.0; self.scale.len()];
        for moved in clusters.iter().filter_map(|cluster| self.moved(cluster, share, held)) {
            variance.iter_mut().zip(moved).for_each(|(v, s)| *v += s * s);
        }
        variance
    }

    /// Partial leverage of each cluster g on each parameter c: the share (A^-1 A_g A^-1)_cc / (A^-1)_cc of the information on c
    /// that comes from g. `held`: ridge on A. Each cluster must have all columns.
    pub fn information_shares<'a>(&'a self, clusters: &'a [Cluster], held: f64) -> impl Iterator<Item = Vec<f64>> + 'a {
        let p = self.scale.len();
        let inverse = self.without(None, held).map_or(DMatrix::zeros(p, p), |factor| factor.inverse());
        clusters.iter().map(move |cluster| {
            let entry = |i: usize, j: usize| self.scale[i] * cluster.gram[(i, j)] * self.scale[j];
            let product = DMatrix::from_fn(p, p, entry) * &inverse;
            (0..p).map(|c| inverse.column(c).dot(&product.column(c)) / inverse[(c, c)]).collect()
        })
    }
}
