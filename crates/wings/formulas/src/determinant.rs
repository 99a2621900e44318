//! Writes the determinant of the Jacobian of a link as a formula.
//!
//! The determinant does not depend on the axes and the reference point in which the velocities are expressed. So the axes and
//! the point with the shortest formula are used. For an arm with a spherical wrist, this reference point is the intersection of
//! the wrist axes: the determinant is then the product of a determinant for the wrist and a determinant for the arm. If the
//! robot has other than six coordinates, the result is the determinant of J^T J or J J^T (J: Jacobian in the frame of the
//! link), the square of the manipulability [Yoshikawa 1985].

use std::collections::HashMap;

use expr::{Expr, Function, Graph, Output};
use robot::LinkId;

use modeling::Derivation;
use modeling::LinkFrame;
use modeling::ReferenceFrame;
use modeling::building::{NULL, add, cross};

/// Determinant of the 6 x 6 Jacobian J of a link. With fewer than six coordinates, of J^T J; with more, of J J^T. Input `q`,
/// output `det`.
pub fn jacobian_determinant(derivation: &mut Derivation, frame: impl Into<LinkFrame>) -> Function {
    let frame = &frame.into();
    let n = derivation.robot().n_coordinates();
    let inputs = derivation.configuration();
    let made = |g: &Graph, entry: Expr| {
        let output = Output { name: "det".into(), rows: 1, columns: 1, entries: vec![entry] };
        let name = frame.function("jacobian_determinant");
        Function::new(&name, g, inputs.clone(), vec![output])
    };
    if n != 6 || !derivation.closes_by_relations() {
        let rows = derivation.jacobian_rows(frame);
        let g = derivation.graph();
        let square = if n == 6 { rows } else { product(g, &rows, n < 6) };
        let entry = Determinant::of(g, square);
        return made(derivation.graph(), entry);
    }
    let chain = std::iter::successors(Some(frame.link), |j| derivation.robot().link(*j).antecedent).collect::<Vec<_>>();
    let functions = chain.into_iter().map(|at| {
        let rows = seen_from(derivation, frame.link, at);
        let entry = Determinant::of(derivation.graph(), rows);
        let function = made(derivation.graph(), entry);
        let count = function.bound().count();
        (count.mul + count.add, function)
    });
    let least = functions.reduce(|a, b| if b.0 < a.0 { b } else { a });
    least.map_or_else(|| made(derivation.graph(), Expr::ONE), |(_, function)| function)
}

/// The Jacobian of `link`, expressed in the axes of the link `at`, which is nearer to the base. The reference point of the
/// velocity is the point of `link` that is at the origin of `at`.
fn seen_from(derivation: &mut Derivation, link: LinkId, at: LinkId) -> Vec<Vec<Expr>> {
    let reference = ReferenceFrame::Link(LinkFrame::from(at));
    let robot = derivation.robot();
    let columns: Vec<Vec<Expr>> = (0..robot.n_variables())
        .map(|k| {
            let between = std::iter::successors(Some(link), |j| robot.link(*j).antecedent).take_while(|j| *j != at);
            let moved: Vec<LinkId> =
                between.filter(|j| robot.link(*j).joint.variable.terms.iter().any(|t| t.0.0 == k)).collect();
            // `moved`: the joints between `at` and `link` that coordinate k moves. If there are none, `at` and `link` have the
            // same twist. If there is only one and k does not move `at`, the formula is shortest in the frame of this joint.
            let from = match moved[..] {
                [] => at,
                [joint] if derivation.twist(at, k).is_none() => joint,
                _ => link,
            };
            let Some(twist) = derivation.twist(from, k) else { return vec![Expr::ZERO; 6] };
            if from == at {
                return [twist.d, twist.z].concat();
            }
            let origin = derivation.at_place_of(NULL, from, &reference);
            let z = derivation.in_axes_of(twist.z, from, &reference);
            let d = derivation.in_axes_of(twist.d, from, &reference);
            // Moves the reference point: adds the velocity that the rotation causes at the distance between the two origins.
            let g = derivation.graph();
            let lever = cross(g, z, origin.map(|x| -x));
            [add(g, d, lever), z].concat()
        })
        .collect();
    (0..6).map(|r| columns.iter().map(|column| column[r]).collect()).collect()
}

/// The matrix J^T J if `columns_first`, otherwise J J^T. `rows`: J row by row.
fn product(g: &mut Graph, rows: &[Vec<Expr>], columns_first: bool) -> Vec<Vec<Expr>> {
    let columns: Vec<Vec<Expr>> =
        (0..rows.first().map_or(0, Vec::len)).map(|c| rows.iter().map(|row| row[c]).collect()).collect();
    let vectors = if columns_first { &columns } else { rows };
    let mut dot = |a: &[Expr], b: &[Expr]| {
        a.iter().zip(b).fold(Expr::ZERO, |sum, (&x, &y)| {
            let term = g.mul(x, y);
            g.add(sum, term)
        })
    };
    vectors.iter().map(|a| vectors.iter().map(|b| dot(a, b)).collect()).collect()
}

/// Computes the determinant of a matrix. If the zeros of the matrix form blocks, the determinant is the product of two smaller
/// determinants. Otherwise it is expanded along the row with the most zeros. Each minor is computed once.
struct Determinant<'a> {
    g: &'a mut Graph,
    rows: Vec<Vec<Expr>>,
    known: HashMap<(u32, u32), Expr>,
}

impl Determinant<'_> {
    fn of(g: &mut Graph, rows: Vec<Vec<Expr>>) -> Expr {
        let all = (1_u32 << rows.len()) - 1;
        Determinant { g, rows, known: HashMap::new() }.minor(all, all)
    }

    fn minor(&mut self, rows: u32, columns: u32) -> Expr {
        if rows == 0 {
            return Expr::ONE;
        }
        if let Some(known) = self.known.get(&(rows, columns)) {
            return *known;
        }
        let found = match self.block(rows, columns) {
            Some((r, c)) => {
                let sign = (places(r, rows) + places(c, columns)) % 2 == 1;
                let (a, b) = (self.minor(r, c), self.minor(rows & !r, columns & !c));
                let product = self.g.mul(a, b);
                if sign { -product } else { product }
            }
            None => self.along_a_row(rows, columns),
        };
        self.known.insert((rows, columns), found);
        found
    }

    /// Finds k rows that are zero outside of k columns: returns these rows and columns as bit sets. `None` if there is no such
    /// block.
    fn block(&self, rows: u32, columns: u32) -> Option<(u32, u32)> {
        let mut subset = (rows - 1) & rows;
        while subset != 0 {
            let read = bits(subset).fold(0, |read, r| read | self.read(r, columns));
            if read.count_ones() <= subset.count_ones() {
                // The k rows are zero outside of fewer than k columns, so the determinant is zero. Any other columns are added to
                // complete the block.
                let missing = bits(columns & !read).take((subset.count_ones() - read.count_ones()) as usize);
                return Some((subset, missing.fold(read, |read, c| read | 1 << c)));
            }
            subset = (subset - 1) & rows;
        }
        None
    }

    /// The columns in which a row is not zero, as a bit set.
    fn read(&self, row: usize, columns: u32) -> u32 {
        bits(columns).filter(|&c| !self.rows[row][c].is_zero()).fold(0, |read, c| read | 1 << c)
    }

    fn along_a_row(&mut self, rows: u32, columns: u32) -> Expr {
        let row = bits(rows).min_by_key(|&r| self.read(r, columns).count_ones()).unwrap_or(0);
        let mut sum = Expr::ZERO;
        for c in bits(self.read(row, columns)) {
            let sign = (places(1 << row, rows) + places(1 << c, columns)) % 2 == 1;
            let minor = self.minor(rows & !(1 << row), columns & !(1 << c));
            let term = self.g.mul(self.rows[row][c], minor);
            sum = self.g.add(sum, if sign { -term } else { term });
        }
        sum
    }
}

fn bits(set: u32) -> impl Iterator<Item = usize> {
    (0..32).filter(move |k| set >> k & 1 == 1)
}

/// Number of exchanges of neighbours that bring the elements of `subset` to the front of `set`. An odd number changes the sign
/// of a minor.
fn places(subset: u32, set: u32) -> usize {
    let place = |k: usize| (set & ((1 << k) - 1)).count_ones() as usize;
    bits(subset).enumerate().map(|(front, k)| place(k) - front).sum()
}
