//! Derives the rates of the passive joints of loops that are solved numerically, from the Jacobian of each loop.
//!
//! In a closed loop the two cut frames have the same motion. The columns of J_a and J_p are the difference of the twists of
//! these frames, per unit rate of each coordinate (J_a) and of each passive variable (J_p). Then
//!
//! ```text
//! J_p dq_p + J_a dq = 0            dq_p  = G dq,             G = -J_p^-1 J_a
//! J_p ddq_p + J_a ddq + c = 0      ddq_p = G ddq - J_p^-1 c
//! ```
//! c is the relative acceleration of the frames at ddq = ddq_p = 0. A loop has six equations; as many independent equations are
//! used as there are passive coordinates. The equations and the order of elimination are chosen at closed configurations. By
//! virtual work, the torques of the coordinates are tau + G^T tau_p; tau_p: torques of the passive joints.

use expr::{Expr, Function, Graph, Output};
use nalgebra::DMatrix;
use robot::{Drive, Joint, Link, LinkId, LoopFrame, Robot, Value};

use crate::kinematics::closure::Closure;
use crate::kinematics::constants::Constants;
use crate::kinematics::links::{JointVariables, LinkMotion, MotionInput, link_motions};
use crate::kinematics::vector::{NULL, Vector, add, dot, sum};
use random::SplitMix;

/// The m passive coordinates of a robot with n coordinates, as expressions: their rates, accelerations and closure equations.
pub(crate) struct Implicit {
    /// The matrix G, m x n, with dq_p = G dq: rates of the passive coordinates per unit of the rates of the coordinates.
    pub G: Vec<Vec<Expr>>,
    /// Accelerations of the passive coordinates at ddq = 0.
    pub coast: Vec<Expr>,
    /// The function of the closure error e and its Jacobian J_p by the passive coordinates: inputs `q`, `passive`.
    pub function: Function,
    /// The closure error e of all loops: m and rad, six entries per loop.
    gaps: Vec<Expr>,
    /// The rows of the loop Jacobian [J_a J_p] (by coordinates and by passive coordinates), six per loop.
    equations: Vec<Vec<Expr>>,
}

impl Implicit {
    /// The constraint equations e = 0, J_a dq + J_p dq_p = 0 and dq_p = G dq as a function: inputs `q`, `passive`; outputs `e` (6
    /// per loop), `ja` (6 per loop, n columns), `jp` (6 per loop, m columns) and `g` (m x n).
    pub(crate) fn constraint_equations(&self, g: &Graph, motion: &JointVariables) -> Function {
        let n = motion.n;
        let matrix = |name: &str, columns: usize, rows: Vec<Vec<Expr>>| Output {
            name: name.into(),
            rows: rows.len(),
            columns,
            entries: rows.concat(),
        };
        let part = |of: std::ops::Range<usize>| self.equations.iter().map(|row| row[of.clone()].to_vec()).collect();
        let outputs = vec![
            matrix("e", 1, self.gaps.iter().map(|e| vec![*e]).collect()),
            matrix("ja", n, part(0..n)),
            matrix("jp", motion.q.len() - n, part(n..motion.q.len())),
            matrix("g", n, self.G.clone()),
        ];
        let inputs = vec![motion.input(MotionInput::Q), motion.input(MotionInput::Passive)];
        Function::new("constraint_equations", g, inputs, outputs)
    }
}

/// Derives the rates and accelerations of the passive coordinates from the loops and writes them into `motion`.
///
/// `None` if no configuration was found that closes the loops.
pub(crate) fn implicit(
    g: &mut Graph,
    robot: &Robot,
    constants: &mut Constants,
    motion: &mut JointVariables,
) -> Option<Implicit> {
    let (n, m) = (robot.n_coordinates(), robot.passive.len());
    let loops: Vec<OpenLoop> = open_loops(robot);
    let still = JointVariables { dq: vec![Expr::ZERO; n + m], ddq: vec![Expr::ZERO; n + m], ..motion.clone() };
    let (gaps, equations) = loop_equations(g, &loops, constants, &still);
    let function = closure_function(g, motion, gaps.clone(), &equations);

    let start = robot.passive.iter().map(|p| p.start).collect();
    let order = elimination_order(&mut Closure::new(&function, start), n, m)?;
    let solver = PassiveSolver::new(g, &equations, n, order);

    // G = -J_p^-1 J_a, and the rates dq_p = G dq of the passive coordinates.
    let columns: Vec<Vec<Expr>> = (0..n).map(|k| solver.solve(g, |row| -equations[row][k])).collect();
    let G: Vec<Vec<Expr>> = (0..m).map(|p| columns.iter().map(|c| c[p]).collect()).collect();
    for p in 0..m {
        motion.dq[n + p] = combination(g, &G[p], &motion.dq[..n]);
    }
    // Accelerations of the passive coordinates: ddq_p = G ddq - J_p^-1 c. c: relative acceleration of the cut frames at ddq =
    // ddq_p = 0.
    let c = relative_accelerations(g, &loops, constants, motion);
    let coast = solver.solve(g, |row| -c[row]);
    for p in 0..m {
        let driven = combination(g, &G[p], &motion.ddq[..n]);
        motion.ddq[n + p] = g.add(driven, coast[p]);
    }
    Some(Implicit { G, coast, function, gaps, equations })
}

/// The closure error e and the loop Jacobian [J_a J_p], six rows per loop: the twist of the twin frame minus the twist of the cut
/// frame, per unit rate of every joint variable. In a closed loop these two frames coincide. `still`: joint variables with zero
/// rates.
fn loop_equations(
    g: &mut Graph,
    loops: &[OpenLoop],
    constants: &mut Constants,
    still: &JointVariables,
) -> (Vec<Expr>, Vec<Vec<Expr>>) {
    let mut equations: Vec<Vec<Expr>> = Vec::new();
    let mut gaps = Vec::new();
    for OpenLoop { robot, cut, twin } in loops {
        let links = link_motions(g, robot, constants, still);
        for row in 0..6 {
            let entry = |j: LinkId, k: usize| {
                links[j.0].jacobian[k].map_or(Expr::ZERO, |t| if row < 3 { t.d[row] } else { t.z[row - 3] })
            };
            equations.push((0..robot.n_variables()).map(|k| g.sub(entry(*twin, k), entry(*cut, k))).collect());
        }
        gaps.extend(gap(g, robot, &links, *cut, *twin));
    }
    (gaps, equations)
}

/// The closure equations as a function: inputs `q` and `passive`, outputs the closure error e and its Jacobian J_p by `passive`.
fn closure_function(g: &Graph, motion: &JointVariables, gaps: Vec<Expr>, equations: &[Vec<Expr>]) -> Function {
    let n = motion.n;
    let jacobian: Vec<Expr> = equations.iter().flat_map(|row| row[n..].to_vec()).collect();
    let output =
        |name: &str, columns, entries: Vec<Expr>| Output { name: name.into(), rows: equations.len(), columns, entries };
    let inputs = vec![motion.input(MotionInput::Q), motion.input(MotionInput::Passive)];
    let outputs = vec![output("e", 1, gaps), output("j", motion.q.len() - n, jacobian)];
    Function::new("closure", g, inputs, outputs)
}

/// The relative acceleration c of the two cut frames of each loop at ddq = ddq_p = 0, six numbers per loop.
fn relative_accelerations(
    g: &mut Graph,
    loops: &[OpenLoop],
    constants: &mut Constants,
    motion: &JointVariables,
) -> Vec<Expr> {
    let coasting = JointVariables { ddq: vec![Expr::ZERO; motion.ddq.len()], ..motion.clone() };
    let mut rest: Vec<Expr> = Vec::new();
    for OpenLoop { robot, cut, twin } in loops {
        let links = link_motions(g, robot, constants, &coasting);
        for row in 0..6 {
            let entry = |j: LinkId| if row < 3 { links[j.0].a[row] } else { links[j.0].angular_motion.dw[row - 3] };
            rest.push(g.sub(entry(*twin), entry(*cut)));
        }
    }
    rest
}

/// Solves J_p x = right with m independent equations of the loops, for the m passive coordinates.
struct PassiveSolver {
    /// The pivots, as (equation, passive coordinate), in the order of elimination.
    order: Vec<(usize, usize)>,
    elimination: Elimination,
}

impl PassiveSolver {
    /// Prepares the solution. `equations`: rows of [J_a J_p]; n: number of columns of J_a; `order`: the pivots, in the order of
    /// elimination.
    fn new(g: &mut Graph, equations: &[Vec<Expr>], n: usize, order: Vec<(usize, usize)>) -> PassiveSolver {
        let J_p: Vec<Vec<Expr>> =
            order.iter().map(|&(row, _)| order.iter().map(|&(_, c)| equations[row][n + c]).collect()).collect();
        PassiveSolver { elimination: Elimination::new(g, J_p), order }
    }

    /// The solution x, in the order of the passive coordinates. `right(row)`: the right-hand side of an equation.
    fn solve(&self, g: &mut Graph, right: impl Fn(usize) -> Expr) -> Vec<Expr> {
        let x = self.elimination.solve(g, self.order.iter().map(|&(row, _)| right(row)).collect());
        let mut ordered = vec![Expr::ZERO; x.len()];
        for (x, &(_, column)) in x.into_iter().zip(&self.order) {
            ordered[column] = x;
        }
        ordered
    }
}

/// The rows (such as torques) of the n coordinates, from the rows r of all joint variables: r_k + sum_p G_pk r_p, by virtual
/// work.
pub(crate) fn reduced(g: &mut Graph, G: &[Vec<Expr>], rows: &[Vec<Expr>]) -> Vec<Vec<Expr>> {
    let n = rows.len() - G.len();
    (0..n)
        .map(|k| {
            (0..rows[k].len())
                .map(|c| {
                    let passive: Vec<Expr> = (0..G.len()).map(|p| g.mul(G[p][k], rows[n + p][c])).collect();
                    passive.into_iter().fold(rows[k][c], |sum, term| g.add(sum, term))
                })
                .collect()
        })
        .collect()
}

fn combination(g: &mut Graph, row: &[Expr], x: &[Expr]) -> Expr {
    let terms: Vec<Expr> = row.iter().zip(x).map(|(&a, &b)| g.mul(a, b)).collect();
    sum(g, &terms)
}

/// A robot that consists only of the two branches of a loop, without gravity. Its base is the last link that carries both
/// branches. In the full robot, the motion of this link moves both branches equally, so the variables of that motion are not in
/// the equations of the loop.
pub(crate) struct OpenLoop {
    pub robot: Robot,
    pub cut: LinkId,
    pub twin: LinkId,
}

/// Makes an [`OpenLoop`] for each loop that is solved numerically.
pub(crate) fn open_loops(robot: &Robot) -> Vec<OpenLoop> {
    let implicit = robot.loops.iter().enumerate().filter(|(_, one)| robot.is_implicit(one));
    implicit
        .map(|(i, one)| {
            let [cut, twin] = [&one.cut, &one.twin].map(|frame| {
                let mut path: Vec<LinkId> =
                    std::iter::successors(frame.antecedent, |&j| robot.link(j).antecedent).collect();
                path.reverse();
                path
            });
            let common = cut.iter().zip(&twin).take_while(|(a, b)| a == b).count();
            let gravity = [Value::ZERO, Value::ZERO, Value::ZERO];
            let mut open = Robot { links: Vec::new(), loops: Vec::new(), massless: 0, gravity, ..robot.clone() };
            let cut = side(robot, &mut open, &cut[common..], &one.cut, &format!("_cut{}", i + 1));
            let twin = side(robot, &mut open, &twin[common..], &one.twin, &format!("_twin{}", i + 1));
            OpenLoop { robot: open, cut, twin }
        })
        .collect()
}

/// Adds the links of a branch to `open`, and the branch's loop frame as the last link. Returns the index of the loop frame.
fn side(robot: &Robot, open: &mut Robot, path: &[LinkId], frame: &LoopFrame, label: &str) -> LinkId {
    let mut antecedent = None;
    for &j in path {
        open.links.push(Link { antecedent, ..robot.link(j).clone() });
        antecedent = Some(LinkId(open.links.len() - 1));
    }
    let joint = Joint::bare(label.into(), frame.kind, Drive::Passive, frame.variable.clone());
    open.links.push(Link::bare(label.into(), antecedent, frame.geometry.clone(), joint));
    LinkId(open.links.len() - 1)
}

/// The closure error of a loop: position of twin frame T in cut frame C, m, and the vector part of the rotation from C to T. Six
/// numbers, all zero if the loop is closed.
fn gap(g: &mut Graph, robot: &Robot, links: &[LinkMotion], cut: LinkId, twin: LinkId) -> [Expr; 6] {
    let frame = |g: &mut Graph, j: LinkId| -> ([Vector; 3], Vector) {
        let unit = |i: usize| std::array::from_fn(|r| if r == i { Expr::ONE } else { Expr::ZERO });
        let (mut axes, mut p, mut at) = ([unit(0), unit(1), unit(2)], NULL, Some(j));
        while let Some(k) = at {
            let placement = &links[k.0].placement;
            axes = axes.map(|v| placement.to_antecedent(g, v));
            p = placement.to_antecedent(g, p);
            p = add(g, p, placement.p);
            at = robot.link(k).antecedent;
        }
        (axes, p)
    };
    let ((c, p_c), (t, p_t)) = (frame(g, cut), frame(g, twin));
    let offset = add(g, p_t, p_c.map(|x| -x));
    let position = c.map(|axis| dot(g, axis, offset));
    let half = g.constant(0.5);
    let mut turn = |i: usize, j: usize| {
        let (a, b) = (dot(g, c[j], t[i]), dot(g, c[i], t[j]));
        let difference = g.sub(a, b);
        g.mul(half, difference)
    };
    // The vector part of the rotation is half of R_CT - R_CT^T; entry (k, l) of R_CT is c_k . t_l, with the axes c_k of C and t_l
    // of T.
    let rotation = [turn(1, 2), turn(2, 0), turn(0, 1)];
    [position[0], position[1], position[2], rotation[0], rotation[1], rotation[2]]
}

/// Number of closed configurations at which different orders of elimination are compared.
const TRIED_CONFIGURATIONS: usize = 5;

/// Seed of the closed configurations at which orders of elimination are compared.
const CONFIGURATION_SEED: u64 = 7;

/// The order of elimination of J_p: pivots (equation, passive coordinate). Complete pivoting at each of several closed
/// configurations gives one order. The smallest pivot of each order over all configurations is compared, and the order with the
/// largest value is taken. `None` if J_p is singular or no loop closes.
fn elimination_order(closure: &mut Closure, n: usize, m: usize) -> Option<Vec<(usize, usize)>> {
    let samples = closure.sample(n, TRIED_CONFIGURATIONS, &mut SplitMix(CONFIGURATION_SEED));
    let mut best: Option<(f64, Vec<(usize, usize)>)> = None;
    let jacobians: Vec<DMatrix<f64>> =
        samples.iter().map(|(q, p)| closure.at(q, &nalgebra::DVector::from_column_slice(p)).1).collect();
    for chosen_at in &jacobians {
        let order = complete_pivots(chosen_at.clone(), m)?;
        // The quality of an order of elimination is the smallest pivot over all sampled configurations.
        let worst = jacobians.iter().map(|j| smallest_pivot(j, &order)).fold(f64::INFINITY, f64::min);
        if best.as_ref().is_none_or(|b| worst > b.0) {
            best = Some((worst, order));
        }
    }
    best.map(|b| b.1)
}

/// An entry of J_p below this value counts as zero and cannot be a pivot. Entries are of order one (rad/rad or m/rad), closed
/// configurations are accurate to 1e-11, and samples stay away from singular configurations.
const VANISHING_ENTRY: f64 = 1e-9;

fn complete_pivots(mut a: DMatrix<f64>, m: usize) -> Option<Vec<(usize, usize)>> {
    let mut order: Vec<(usize, usize)> = Vec::new();
    for _ in 0..m {
        let free = |&(r, c): &(usize, usize)| order.iter().all(|&(row, column)| row != r && column != c);
        let places = (0..a.nrows()).flat_map(|r| (0..m).map(move |c| (r, c))).filter(free);
        let (r, c) = places.max_by(|x, y| a[*x].abs().total_cmp(&a[*y].abs()))?;
        if a[(r, c)].abs() < VANISHING_ENTRY {
            return None;
        }
        for row in (0..a.nrows()).filter(|&row| row != r && order.iter().all(|o| o.0 != row)) {
            let factor = a[(row, c)] / a[(r, c)];
            for k in 0..m {
                a[(row, k)] -= factor * a[(r, k)];
            }
        }
        order.push((r, c));
    }
    Some(order)
}

fn smallest_pivot(j: &DMatrix<f64>, order: &[(usize, usize)]) -> f64 {
    let mut a = DMatrix::from_fn(order.len(), order.len(), |r, c| j[(order[r].0, order[c].1)]);
    let mut smallest = f64::INFINITY;
    for k in 0..order.len() {
        smallest = smallest.min(a[(k, k)].abs());
        for r in k + 1..order.len() {
            let factor = a[(r, k)] / a[(k, k)];
            for c in k..order.len() {
                a[(r, c)] -= factor * a[(k, c)];
            }
        }
    }
    smallest
}

/// The factors L and U of a square matrix of expressions, stored in one matrix. The pivots are on the diagonal.
struct Elimination {
    rows: Vec<Vec<Expr>>,
}

impl Elimination {
    fn new(g: &mut Graph, mut rows: Vec<Vec<Expr>>) -> Elimination {
        let m = rows.len();
        for k in 0..m {
            for r in k + 1..m {
                if rows[r][k].is_zero() {
                    continue;
                }
                let factor = g.div(rows[r][k], rows[k][k]);
                for c in k + 1..m {
                    let product = g.mul(factor, rows[k][c]);
                    rows[r][c] = g.sub(rows[r][c], product);
                }
                rows[r][k] = factor;
            }
        }
        Elimination { rows }
    }

    fn solve(&self, g: &mut Graph, mut x: Vec<Expr>) -> Vec<Expr> {
        let m = self.rows.len();
        for r in 0..m {
            for k in 0..r {
                let product = g.mul(self.rows[r][k], x[k]);
                x[r] = g.sub(x[r], product);
            }
        }
        for r in (0..m).rev() {
            for k in r + 1..m {
                let product = g.mul(self.rows[r][k], x[k]);
                x[r] = g.sub(x[r], product);
            }
            if !x[r].is_zero() {
                x[r] = g.div(x[r], self.rows[r][r]);
            }
        }
        x
    }
}
