//! Random robots with planar loops, joints that follow other joints, and equal lengths. The rank of their regressor is computed
//! by mechanics that share no code with `modeling`.
//!
//! A robot is a tree of some links. Each loop has a crank, which a coordinate moves, and a four-bar, a parallelogram, a crossed
//! four-bar or a slider. All loops are cut open, so that the passive joints p are coordinates of a tree. e(q, p): gap of each
//! loop, as a complex number. The velocities of p and the regressor D of the closed robot are
//!
//! ```text
//! dp = G dq          G = -(de/dp)^-1 de/dq
//! D  = [1 G'] D_open(q, p, dq, G dq, ddq, G ddq + c)
//! ```
//! D_open: regressor of the tree, computed by the Newton-Euler recursion ([`crate::recursion`]), column by column; c:
//! acceleration of p for ddq = 0.

use expr::Tape;
use modeling::Derivation;
use nalgebra::{DMatrix, Matrix2, Vector2};
use robot::{Robot, format};

use crate::planar_loop::{PlanarLoop, Third, drawn_loop};
use crate::random::{Random, State};
use crate::recursion;

/// A column is independent of the other columns if the part of it that they do not explain exceeds this fraction of the largest
/// column. Rounding gives about 1e-13; for lengths and angles with two digits, an independent column gives more than 1e-6.
const STANDS_OUT: f64 = 1e-9;

pub struct Structure {
    /// The YAML description with its loops.
    pub text: String,
    /// The YAML description of the tree in which the loops are cut open. The passive joints are coordinates after the others.
    open: String,
    loops: Vec<PlanarLoop>,
    /// The kinds of structures in the robot: `tree`, `ratio`, `crossed`, ...
    pub kinds: Vec<&'static str>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numbers {
    /// Right angles, and few lengths that occur repeatedly.
    Special,
    General,
}

impl Numbers {
    fn angle(self, random: &mut Random) -> String {
        match self {
            Numbers::Special => ["0", "pi/2", "-pi/2", "pi", "pi/3", "-pi/4"][random.below(6)].into(),
            Numbers::General => format!("{:.3}", 3.0 * random.unit()),
        }
    }

    fn length(self, random: &mut Random) -> String {
        match self {
            Numbers::Special => ["0", "0.25", "0.25", "0.4"][random.below(4)].into(),
            Numbers::General => format!("{:.3}", random.unit()),
        }
    }
}

/// Ratios between a joint that follows and the joint that it follows, as in gears and robot hands.
const RATIOS: [&str; 8] = ["1.5", "4/3", "0.5", "-0.35", "2", "-1", "0.8024", "-2/3"];

/// A description to which links are added one by one. It is written twice: with its loops (`links`, `cuts`), and with loops cut
/// open.
#[derive(Default)]
struct Draft {
    links: String,
    open: String,
    cuts: String,
    names: Vec<String>,
    coordinates: Vec<String>,
    passive: Vec<String>,
    loops: Vec<PlanarLoop>,
    kinds: Vec<&'static str>,
}

pub fn structure(seed: u64) -> Structure {
    let random = &mut Random(seed);
    let numbers = if seed.is_multiple_of(2) { Numbers::Special } else { Numbers::General };
    let gravity = ["[0, 0, -9.81]", "[1.2, -3.4, -9.1]", "[0, 0, 0]"][random.below(3)];
    let head = format!("convention: khalil-kleinfinger\nname: seed {seed}\nrotor_inertia: none\ngravity: {gravity}\n");
    let n_loops = [0, 1, 1, 2][random.below(4)];
    let n_plain = 1 + random.below(if n_loops == 2 { 2 } else { 4 });
    let mut order: Vec<bool> = (0..n_loops).map(|_| true).chain((0..n_plain).map(|_| false)).collect();
    for i in (1..order.len()).rev() {
        order.swap(i, random.below(i + 1));
    }
    let mut draft = Draft::default();
    for is_loop in order {
        let antecedent = match random.below(draft.names.len() + 1) {
            0 => "base".to_string(),
            i => draft.names[i - 1].clone(),
        };
        if is_loop {
            draft.add_loop(random, numbers, &antecedent)
        } else {
            draft.add_link(random, numbers, &antecedent)
        }
    }
    let Draft { links, open, cuts, coordinates, passive, loops, mut kinds, .. } = draft;
    let listed = |of: &[String]| format!("coordinates: [{}]\n", of.join(", "));
    let tail = if cuts.is_empty() { String::new() } else { format!("loops:\n{cuts}") };
    kinds.sort_unstable();
    kinds.dedup();
    Structure {
        text: format!("{head}{}links:\n{links}{tail}", listed(&coordinates)),
        open: format!("{head}{}links:\n{open}", listed(&[coordinates.clone(), passive].concat())),
        loops,
        kinds,
    }
}

impl Draft {
    /// Adds a loop: a crank, a rod and a third link, with a cut joint between rod and third link.
    fn add_loop(&mut self, random: &mut Random, numbers: Numbers, antecedent: &str) {
        let k = self.loops.len() + 1;
        let (one, kind) = drawn_loop(random, self.coordinates.len());
        let (q, a, b, c) = (format!("qa{k}"), format!("a{k}"), format!("b{k}"), format!("c{k}"));
        let [p1, p2] = [format!("pb{k}"), format!("pc{k}")];
        let PlanarLoop { crank, crank_length, rod, start, .. } = one;
        let place = match one.third {
            Third::Slider => "b: 0".to_string(),
            Third::Rocker { .. } => {
                let [gamma, alpha] = [numbers.angle(random), numbers.angle(random)];
                format!("gamma: {gamma}, b: {}, alpha: {alpha}", numbers.length(random))
            }
        };
        let crank_link = format!("  - {{link: {a}, antecedent: {antecedent}, {place}, theta: {q} + {crank}}}\n");
        let rod_link = |variable: &str| format!("  - {{link: {b}, antecedent: {a}, d: {crank_length}, {variable}}}\n");
        let (joint, key, third, twin) = match one.third {
            Third::Rocker { base, length } => {
                ("joint: revolute, ", "theta", format!("{place}, d: {base}"), format!("d: {length}"))
            }
            Third::Slider => ("", "r", "joint: prismatic, gamma: pi/2, alpha: pi/2".into(), "alpha: -pi/2".into()),
        };
        let third_link = |variable: &str| format!("  - {{link: {c}, antecedent: {antecedent}, {third}, {variable}}}\n");
        self.links += &crank_link;
        self.links += &rod_link(&format!("joint: revolute, drive: passive, start: {:.7}", start[0]));
        self.links += &third_link(&format!("{joint}drive: passive, start: {:.7}", start[1]));
        self.open += &(crank_link + &rod_link(&format!("theta: {p1}")) + &third_link(&format!("{key}: {p2}")));
        self.cuts += &format!("  - cut: {{antecedent: {b}, joint: revolute, d: {rod}, start: 0.1}}\n");
        self.cuts += &format!("    twin: {{antecedent: {c}, {twin}}}\n");
        self.coordinates.push(q);
        self.passive.extend([p1, p2]);
        self.names.extend([a, b, c]);
        self.loops.push(one);
        self.kinds.push(kind);
    }

    /// Adds a link whose joint has its own coordinate, or follows other joints.
    fn add_link(&mut self, random: &mut Random, numbers: Numbers, antecedent: &str) {
        let j = self.names.len() + 1;
        let (alpha, d) = (numbers.angle(random), numbers.length(random));
        let (angle, length) = (numbers.angle(random), numbers.length(random));
        let kind = if self.coordinates.is_empty() { 0 } else { random.below(6) };
        let follow = |random: &mut Random| {
            let ratio = RATIOS[random.below(RATIOS.len())];
            format!("{ratio}*{}", self.coordinates[random.below(self.coordinates.len())])
        };
        let joint = match kind {
            1 => format!("joint: prismatic, theta: {angle}, r: q{j}"),
            2 => format!("drive: passive, theta: {} + 0.3, r: {length}", follow(random)),
            3 => format!("drive: passive, theta: {} + {}, r: {length}", follow(random), follow(random)),
            4 => format!("joint: prismatic, drive: passive, theta: {angle}, r: {}", follow(random)),
            _ => format!("theta: q{j}, r: {length}"),
        };
        match kind {
            2 | 4 => self.kinds.push("ratio"),
            3 => self.kinds.push("two coordinates"),
            _ => self.coordinates.push(format!("q{j}")),
        }
        let link = format!("  - {{link: l{j}, antecedent: {antecedent}, alpha: {alpha}, d: {d}, {joint}}}\n");
        self.links += &link;
        self.open += &link;
        self.names.push(format!("l{j}"));
    }
}

/// A state in which all loops are closed, with the values of the passive joints.
pub struct ClosedState {
    /// q, dq, ddq of the coordinates.
    pub state: State,
    /// For each loop, the passive variables p_1 and p_2, and the angle of its cut joint.
    passive: Vec<f64>,
    /// The regressor D from the recursion, row by row.
    pub regressor: DMatrix<f64>,
}

impl Structure {
    /// The robot, read from its description.
    ///
    /// Fails with the error message of the reader.
    pub fn robot(&self) -> Result<Robot, String> {
        format::read_yaml(&self.text, "structure.yaml").map_err(|e| e.to_string())
    }

    /// Random states in which all loops are closed. The crank angles are between 0.1 and 2.5 rad, and no loop is near a singular
    /// configuration.
    pub fn states(&self, count: usize, random: &mut Random) -> Vec<ClosedState> {
        let open = format::read_yaml(&self.open, "open.yaml").unwrap_or_else(|e| panic!("{}{e}", self.open));
        (0..count).map(|_| self.state(&open, random)).collect()
    }

    fn state(&self, open: &Robot, random: &mut Random) -> ClosedState {
        let m = 2 * self.loops.len();
        let n = open.n_coordinates() - m;
        let mut q = random.vector(n, std::f64::consts::PI);
        self.loops.iter().for_each(|one| q[one.coordinate] = 1.3 + 1.2 * random.unit() - one.crank);
        let (dq, ddq) = (random.vector(n, 2.0), random.vector(n, 4.0));
        let (mut p, mut dp, mut ddp) = (vec![0.0; m], vec![0.0; m], vec![0.0; m]);
        let mut passive = Vec::with_capacity(3 * self.loops.len());
        let mut rates_of = DMatrix::<f64>::zeros(m, n);
        for (l, one) in self.loops.iter().enumerate() {
            let k = one.coordinate;
            let at = one.closed(q[k]);
            let (e, slopes, _) = one.gap(q[k], at, 0.0, [0.0; 2]);
            assert!(e[0].hypot(e[1]) < 1e-13, "the loop does not close: {e:?}\n{}", self.text);
            let j = Matrix2::from_columns(&[slopes[1].into(), slopes[2].into()]).lu();
            let solve = |right: [f64; 2]| j.solve(&Vector2::from(right)).expect("a loop that is not singular");
            let g = -solve(slopes[0]);
            let rates = [g[0] * dq[k], g[1] * dq[k]];
            let coast = -solve(one.gap(q[k], at, dq[k], rates).2);
            // In a loop with a slider, the second frame of the cut is rotated by a right angle.
            let turn = if matches!(one.third, Third::Slider) { std::f64::consts::FRAC_PI_2 } else { at[1] };
            passive.extend([at[0], at[1], turn - at[0] - q[k] - one.crank]);
            for i in 0..2 {
                rates_of[(2 * l + i, k)] = g[i];
                (p[2 * l + i], dp[2 * l + i]) = (at[i], rates[i]);
                ddp[2 * l + i] = g[i] * ddq[k] + coast[i];
            }
        }
        let whole = State { q: [&q[..], &p].concat(), dq: [&dq[..], &dp].concat(), ddq: [&ddq[..], &ddp].concat() };
        let columns = crate::standard_names(open).len();
        let mut d_open = DMatrix::zeros(n + m, columns);
        let mut unit = vec![0.0; columns];
        for c in 0..columns {
            unit[c] = 1.0;
            d_open.column_mut(c).copy_from_slice(&recursion::torque(open, &whole, &unit));
            unit[c] = 0.0;
        }
        let regressor = d_open.rows(0, n) + rates_of.transpose() * d_open.rows(n, m);
        ClosedState { state: State { q, dq, ddq }, passive, regressor }
    }
}

impl ClosedState {
    /// The inputs q, passive, dq, ddq for functions of `robot`. Some passive joints may be missing in `robot`, because their
    /// affine relation to the coordinates was found.
    pub fn inputs(&self, robot: &Robot) -> Vec<f64> {
        let passive = robot.passive.iter().map(|p| {
            // The names of passive joints contain the link name: `theta_b1`, `r_c2`. The joint `theta_cut1` moves no link.
            let link = p.name.rsplit('_').next().unwrap_or_default();
            let number: usize = link.trim_start_matches(|c: char| c.is_alphabetic()).parse().expect("a link of a loop");
            let of_loop = |i: usize| self.passive[3 * (number - 1) + i];
            of_loop(if link.starts_with("cut") { 2 } else { usize::from(link.starts_with('c')) })
        });
        let State { q, dq, ddq } = &self.state;
        q.iter().copied().chain(passive).chain(dq.iter().chain(ddq).copied()).collect()
    }
}

/// The rank of the regressors of all states together, and the ratio of singular values at this rank (see [`rank_of`]).
fn rank(states: &[ClosedState]) -> (usize, f64) {
    let rows: usize = states.iter().map(|s| s.regressor.nrows()).sum();
    let columns = states.first().map_or(0, |s| s.regressor.ncols());
    let mut observed = DMatrix::zeros(rows, columns);
    let mut at = 0;
    for state in states {
        observed.rows_mut(at, state.regressor.nrows()).copy_from(&state.regressor);
        at += state.regressor.nrows();
    }
    rank_of(observed)
}

/// The rank of a matrix, by the singular values of its scaled columns; and the ratio between the last singular value that counts
/// and the next one.
pub fn rank_of(mut observed: DMatrix<f64>) -> (usize, f64) {
    let largest = observed.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
    for mut column in observed.column_iter_mut() {
        let norm = column.norm();
        if norm > STANDS_OUT * largest {
            column /= norm;
        } else {
            column.fill(0.0);
        }
    }
    let mut values: Vec<f64> = observed.singular_values().iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    let first = values.first().copied().unwrap_or(0.0);
    let rank = values.iter().filter(|v| **v > STANDS_OUT * first).count();
    let gap = if rank == 0 || rank == values.len() { f64::INFINITY } else { values[rank - 1] / values[rank] };
    (rank, gap)
}

/// Tolerance relative to the largest entry of a regressor. The passive joints are closed to 1e-13, and about a thousand
/// operations follow.
const AGREES: f64 = 1e-9;

pub enum Outcome {
    /// Regressor, rank and base parameters agree with the independent mechanics.
    Right,
    /// The program refuses to determine base parameters. The text is the reason.
    Refused(String),
    Wrong(String),
}

pub fn outcome(seed: u64) -> Outcome {
    wrong(seed).map_or(
        Outcome::Right,
        |(is_refused, why)| {
            if is_refused { Outcome::Refused(why) } else { Outcome::Wrong(why) }
        },
    )
}

fn wrong(seed: u64) -> Option<(bool, String)> {
    let drawn = structure(seed);
    let robot = match drawn.robot() {
        Ok(robot) => robot,
        Err(e) => return Some((false, e)),
    };
    let mut derivation = match Derivation::new(&robot) {
        Ok(derivation) => derivation,
        Err(e) => return Some((true, e.to_string())),
    };
    let regressor = derivation.regressor();
    let (n, p) = (robot.n_coordinates(), regressor.outputs[0].columns);
    let states = drawn.states(2 * p / n + 8, &mut Random(seed + 1_000_000));
    let tape = Tape::new(&regressor);
    for state in &states {
        let mut y = vec![0.0; n * p];
        tape.evaluate(&state.inputs(&robot), &mut tape.workspace(), &mut y);
        let y = DMatrix::from_row_slice(n, p, &y);
        let (apart, largest) = ((&y - &state.regressor).amax(), state.regressor.amax());
        if apart.is_nan() || apart > AGREES * (1.0 + largest) {
            return Some((false, format!("the regressor differs by {apart:e} of {largest:e}")));
        }
    }
    let base = match derivation.base_parameters(&regressor) {
        Ok(base) => base,
        Err(e) => return Some((true, e.to_string())),
    };
    let (found, gap) = rank(&states);
    if base.len() != found {
        let why = format!("{} base parameters, the independent rank is {found} (gap {gap:.0e})", base.len());
        return Some((false, why));
    }
    // The kept columns are independent, and represent all torques: D_base X_base = D X.
    let x = Random(seed + 2_000_000).vector(p, 1.0);
    let x_base = base.values(&x);
    for state in &states {
        let kept = DMatrix::from_fn(n, base.len(), |i, k| state.regressor[(i, base.base[k].column)]);
        let tau = &state.regressor * DMatrix::from_column_slice(p, 1, &x);
        let tau_base = kept * DMatrix::from_column_slice(x_base.len(), 1, &x_base);
        let apart = (&tau - tau_base).amax();
        // The coefficients of the base parameters are numbers with the rounding error of the rank computation, so the tolerance
        // is larger.
        if apart.is_nan() || apart > AGREES * 10.0 * (1.0 + state.regressor.amax()) {
            return Some((false, format!("D_base X_base is off by {apart:e} of {:e}", tau.amax())));
        }
    }
    None
}
