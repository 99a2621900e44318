//! Robots drawn at random, with planar loops, joints that follow others by ratios, and equal lengths; and their rank by
//! mechanics that share no code with `modeling`.
//!
//! A robot is a tree of some links. Each loop is a crank that a coordinate turns, with a four-bar, a parallelogram, a crossed
//! four-bar or a slider behind it. As a tree it is cut open, with the passive joints as coordinates p. With e(q, p) the open
//! end of each loop as a complex number,
//!
//! ```text
//! dp = G dq          G = -(de/dp)^-1 de/dq
//! D  = [1 G'] D_open(q, p, dq, G dq, ddq, G ddq + c)
//! ```
//! where D_open comes from the recursion of Newton and Euler ([`crate::recursion`]), column by column.

use expr::Tape;
use modeling::Derivation;
use nalgebra::{DMatrix, Matrix2, Vector2};
use robot::{Robot, format};

use crate::random::{Random, State};
use crate::recursion;

/// A column counts where it stands out of the others by more than this share of the largest: far above the rounding of
/// the columns, 1e-13, and below what lengths and angles of two digits leave of one, 1e-6.
const STANDS_OUT: f64 = 1e-9;

/// A robot, whole and cut open.
pub struct Structure {
    /// The description with its loops.
    pub text: String,
    /// The same tree, its passive joints coordinates behind the others.
    open: String,
    loops: Vec<PlanarLoop>,
    /// What it has: `tree`, `ratio`, `crossed`, ...
    pub kinds: Vec<&'static str>,
}

/// L1 exp(i (q + crank)) + L2 exp(i (q + crank + p_1)) = the third side, from the origin of the crank's joint.
struct PlanarLoop {
    /// Index of the crank's coordinate.
    coordinate: usize,
    /// rad, where the coordinate is zero.
    crank: f64,
    crank_length: f64,
    rod: f64,
    third: Third,
    /// p_1 and p_2 where the coordinate is zero.
    start: [f64; 2],
}

#[derive(Clone, Copy)]
enum Third {
    /// L0 + L3 exp(i p_2).
    Rocker { base: f64, length: f64 },
    /// p_2.
    Slider,
}

impl PlanarLoop {
    /// e, its slopes by q, p_1 and p_2, and its acceleration at rates dq, dp with no accelerations.
    fn gap(&self, q: f64, p: [f64; 2], dq: f64, dp: [f64; 2]) -> ([f64; 2], [[f64; 2]; 3], [f64; 2]) {
        let at = |angle: f64, length: f64| [length * angle.cos(), length * angle.sin()];
        let across = |v: [f64; 2]| [-v[1], v[0]];
        let (phi, d_phi) = (q + self.crank, dq);
        let (crank, rod) = (at(phi, self.crank_length), at(phi + p[0], self.rod));
        let (third, by_third, third_bend) = match self.third {
            Third::Rocker { base, length } => {
                let side = at(p[1], length);
                ([base + side[0], side[1]], across(side), side.map(|x| -x * dp[1] * dp[1]))
            }
            Third::Slider => ([p[1], 0.0], [1.0, 0.0], [0.0, 0.0]),
        };
        let rate = d_phi + dp[0];
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let plus = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let e = minus(plus(crank, rod), third);
        let by_rod = across(rod);
        let slopes = [plus(across(crank), by_rod), by_rod, by_third.map(|x| -x)];
        let bend = plus(crank.map(|x| -x * d_phi * d_phi), rod.map(|x| -x * rate * rate));
        (e, slopes, minus(bend, third_bend))
    }

    /// p where the coordinate is q, followed from the start.
    fn closed(&self, q: f64) -> [f64; 2] {
        let mut p = self.start;
        let steps = (q.abs() / 0.02).ceil().max(1.0) as usize;
        for step in 0..=steps {
            let q = q * step as f64 / steps as f64;
            for _ in 0..20 {
                let (e, slopes, _) = self.gap(q, p, 0.0, [0.0; 2]);
                let j = Matrix2::from_columns(&[slopes[1].into(), slopes[2].into()]);
                let Some(x) = j.lu().solve(&Vector2::from(e)) else { break };
                p = [p[0] - x[0], p[1] - x[1]];
            }
        }
        p
    }
}

/// The numbers of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numbers {
    /// Right angles, few lengths that occur again and again.
    Special,
    /// Any.
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

/// Ratios as gears and hands have them.
const RATIOS: [&str; 8] = ["1.5", "4/3", "0.5", "-0.35", "2", "-1", "0.8024", "-2/3"];

/// The robot of this number.
pub fn structure(seed: u64) -> Structure {
    let random = &mut Random(seed);
    let numbers = if seed.is_multiple_of(2) { Numbers::Special } else { Numbers::General };
    let gravity = ["[0, 0, -9.81]", "[1.2, -3.4, -9.1]", "[0, 0, 0]"][random.below(3)];
    let head = format!("convention: khalil-kleinfinger\nname: seed {seed}\nrotor_inertia: none\ngravity: {gravity}\n");
    let (mut links, mut open, mut cuts) = (String::new(), String::new(), String::new());
    let (mut names, mut coordinates, mut passive): (Vec<String>, Vec<String>, Vec<String>) = Default::default();
    let (mut loops, mut kinds) = (Vec::new(), vec![]);
    let n_loops = [0, 1, 1, 2][random.below(4)];
    let n_plain = 1 + random.below(if n_loops == 2 { 2 } else { 4 });
    let mut order: Vec<bool> = (0..n_loops).map(|_| true).chain((0..n_plain).map(|_| false)).collect();
    for i in (1..order.len()).rev() {
        order.swap(i, random.below(i + 1));
    }
    for is_loop in order {
        let below = |random: &mut Random| match random.below(names.len() + 1) {
            0 => "base".to_string(),
            i => names[i - 1].clone(),
        };
        let antecedent = below(random);
        if is_loop {
            let k = loops.len() + 1;
            let (one, kind) = drawn_loop(random, coordinates.len());
            kinds.push(kind);
            let (q, a, b, c) = (format!("qa{k}"), format!("a{k}"), format!("b{k}"), format!("c{k}"));
            let [p1, p2] = [format!("pb{k}"), format!("pc{k}")];
            let PlanarLoop { crank, crank_length, rod, start, .. } = one;
            let plane = if matches!(one.third, Third::Slider) { "0".into() } else { numbers.angle(random) };
            let place = format!("gamma: {}, b: {}, alpha: {plane}", numbers.angle(random), numbers.length(random));
            let place = if matches!(one.third, Third::Slider) { String::from("b: 0") } else { place };
            let crank_link = format!("  - {{link: {a}, antecedent: {antecedent}, {place}, theta: {q} + {crank}}}\n");
            let rod_link =
                |variable: &str| format!("  - {{link: {b}, antecedent: {a}, d: {crank_length}, {variable}}}\n");
            let third_link = |variable: &str| match one.third {
                Third::Rocker { base, .. } => {
                    format!("  - {{link: {c}, antecedent: {antecedent}, {place}, d: {base}, {variable}}}\n")
                }
                Third::Slider => format!(
                    "  - {{link: {c}, antecedent: {antecedent}, joint: prismatic, gamma: pi/2, alpha: pi/2, {variable}}}\n"
                ),
            };
            let (sliding, twin) = match one.third {
                Third::Rocker { length, .. } => (false, format!("d: {length}")),
                Third::Slider => (true, "alpha: -pi/2".into()),
            };
            let key = if sliding { "r" } else { "theta" };
            links += &crank_link;
            links += &rod_link(&format!("joint: revolute, drive: passive, start: {:.7}", start[0]));
            let joint = if sliding { "" } else { "joint: revolute, " };
            links += &third_link(&format!("{joint}drive: passive, start: {:.7}", start[1]));
            open += &(crank_link + &rod_link(&format!("theta: {p1}")) + &third_link(&format!("{key}: {p2}")));
            cuts += &format!("  - cut: {{antecedent: {b}, joint: revolute, d: {rod}, start: 0.1}}\n");
            cuts += &format!("    twin: {{antecedent: {c}, {twin}}}\n");
            coordinates.push(q);
            passive.extend([p1, p2]);
            names.extend([a, b, c]);
            loops.push(one);
        } else {
            let j = names.len() + 1;
            let (alpha, d) = (numbers.angle(random), numbers.length(random));
            let (angle, length) = (numbers.angle(random), numbers.length(random));
            let kind = if coordinates.is_empty() { 0 } else { random.below(6) };
            let follow = |random: &mut Random| {
                format!("{}*{}", RATIOS[random.below(RATIOS.len())], coordinates[random.below(coordinates.len())])
            };
            let joint = match kind {
                1 => format!("joint: prismatic, theta: {angle}, r: q{j}"),
                2 => format!("drive: passive, theta: {} + 0.3, r: {length}", follow(random)),
                3 => format!("drive: passive, theta: {} + {}, r: {length}", follow(random), follow(random)),
                4 => format!("joint: prismatic, drive: passive, theta: {angle}, r: {}", follow(random)),
                _ => format!("theta: q{j}, r: {length}"),
            };
            match kind {
                2 | 4 => kinds.push("ratio"),
                3 => kinds.push("two coordinates"),
                _ => coordinates.push(format!("q{j}")),
            }
            let link = format!("  - {{link: l{j}, antecedent: {antecedent}, alpha: {alpha}, d: {d}, {joint}}}\n");
            (links, open) = (links + &link, open + &link);
            names.push(format!("l{j}"));
        }
    }
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

fn drawn_loop(random: &mut Random, coordinate: usize) -> (PlanarLoop, &'static str) {
    let crank = 0.7 + 0.2 * (100.0 * random.unit()).round() / 100.0;
    let two_digits = |low: f64, high: f64, random: &mut Random| {
        let x = low + (high - low) * (random.unit() + 1.0) / 2.0;
        (100.0 * x).round() / 100.0
    };
    let crank_length = two_digits(0.15, 0.2, random);
    let rod = two_digits(0.5, 0.55, random);
    let kind = ["four-bar", "parallelogram", "crossed", "slider"][random.below(4)];
    if kind == "slider" {
        let [x, y] = [crank_length * crank.cos(), crank_length * crank.sin()];
        // The rod reaches down to the rail.
        let fall = -(y / rod).asin();
        let start = [fall - crank, x + rod * fall.cos()];
        return (PlanarLoop { coordinate, crank, crank_length, rod, third: Third::Slider, start }, kind);
    }
    let (base, length) = match kind {
        "four-bar" => (two_digits(0.45, 0.5, random), two_digits(0.4, 0.45, random)),
        _ => (rod, crank_length),
    };
    // From the rocker's joint to the crank's tip, and the triangle that rod and rocker make with it.
    let [x, y] = [crank_length * crank.cos() - base, crank_length * crank.sin()];
    let apart = x.hypot(y);
    let inner = ((apart * apart + length * length - rod * rod) / (2.0 * apart * length)).clamp(-1.0, 1.0).acos();
    let candidates = [1.0, -1.0].map(|side| {
        let p2 = y.atan2(x) + side * inner;
        let end = [base + length * p2.cos() - crank_length * crank.cos(), length * p2.sin() - y];
        [end[1].atan2(end[0]) - crank, p2]
    });
    // The rocker of a parallelogram stands as the crank does.
    let parallel = |p: &[f64; 2]| ((p[1] - crank).sin().abs() + (1.0 - (p[1] - crank).cos())).abs();
    let [near, far] = if parallel(&candidates[0]) < parallel(&candidates[1]) {
        [candidates[0], candidates[1]]
    } else {
        [candidates[1], candidates[0]]
    };
    let start = if kind == "crossed" { far } else { near };
    (PlanarLoop { coordinate, crank, crank_length, rod, third: Third::Rocker { base, length }, start }, kind)
}

/// A closed state, with the values of the passive joints.
pub struct ClosedState {
    /// q, dq, ddq of the coordinates.
    pub state: State,
    /// p_1 and p_2 of each loop, and the angle of its cut.
    passive: Vec<f64>,
    /// D by the recursion, row by row.
    pub regressor: DMatrix<f64>,
}

impl Structure {
    /// The robot as its description is read.
    ///
    /// Fails with the text of the refusal.
    pub fn robot(&self) -> Result<Robot, String> {
        format::read_yaml(&self.text, "structure.yaml").map_err(|e| e.to_string())
    }

    /// As many closed states as asked for, the cranks between 0.1 and 2.5 rad, where no loop is near a singular configuration.
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
            // The twin of a slider is turned by a right angle.
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
    /// The inputs of the functions of `robot`, which may solve some passive joints by affine relations: q, passive, dq, ddq.
    pub fn inputs(&self, robot: &Robot) -> Vec<f64> {
        let passive = robot.passive.iter().map(|p| {
            // `theta_b1`, `r_c2`: the names of the links behind the letters of the joint variable; `theta_cut1` turns no link.
            let link = p.name.rsplit('_').next().unwrap_or_default();
            let number: usize = link.trim_start_matches(|c: char| c.is_alphabetic()).parse().expect("a link of a loop");
            let of_loop = |i: usize| self.passive[3 * (number - 1) + i];
            of_loop(if link.starts_with("cut") { 2 } else { usize::from(link.starts_with('c')) })
        });
        let State { q, dq, ddq } = &self.state;
        q.iter().copied().chain(passive).chain(dq.iter().chain(ddq).copied()).collect()
    }
}

/// The rank of stacked regressors, by singular values of their scaled columns; and the gap behind it.
pub fn rank(states: &[ClosedState]) -> (usize, f64) {
    let rows: usize = states.iter().map(|s| s.regressor.nrows()).sum();
    let columns = states.first().map_or(0, |s| s.regressor.ncols());
    let mut observed = DMatrix::zeros(rows, columns);
    let mut at = 0;
    for state in states {
        observed.rows_mut(at, state.regressor.nrows()).copy_from(&state.regressor);
        at += state.regressor.nrows();
    }
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

/// Relative to the largest entry of a regressor: the passive joints are closed to 1e-13, and some thousand operations follow.
const AGREES: f64 = 1e-9;

/// What becomes of a robot.
pub enum Outcome {
    /// Regressor, rank and regrouping are those of the independent mechanics.
    Right,
    /// No base parameters are given, with the reason.
    Refused(String),
    /// Something is false.
    Wrong(String),
}

/// What becomes of the robot of this number.
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
        if !(apart <= AGREES * (1.0 + largest)) {
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
    // The kept columns are independent, and nothing is lost: D_base X_base = D X.
    let x = Random(seed + 2_000_000).vector(p, 1.0);
    let x_base = base.values(&x);
    for state in &states {
        let kept = DMatrix::from_fn(n, base.len(), |i, k| state.regressor[(i, base.base[k].column)]);
        let tau = &state.regressor * DMatrix::from_column_slice(p, 1, &x);
        let tau_base = kept * DMatrix::from_column_slice(x_base.len(), 1, &x_base);
        let apart = (&tau - tau_base).amax();
        // Numeric coefficients carry the rounding of the scan.
        if !(apart <= AGREES * 10.0 * (1.0 + state.regressor.amax())) {
            return Some((false, format!("D_base X_base is off by {apart:e} of {:e}", tau.amax())));
        }
    }
    None
}
