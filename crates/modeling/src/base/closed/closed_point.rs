//! Finds closed points: values of all constants and variables in a finite field for which the loops of a robot are closed.
//!
//! There are two methods, tried in this order:
//!
//! - constants first, for planar loops: all constants are drawn at random, then the variables, loop by loop. In each loop some
//!   variables are drawn, and two or three are solved for ([`crate::base::closed::planar_loop`]). All of them may be
//!   coordinates or passive variables, because closure does not depend on which joints are driven. Lengths with the same symbol
//!   stay equal;
//! - angles first: all angles are drawn, except the angles that close the orientation of each loop
//!   ([`crate::base::closed::orientation`]). The position equations are then affine in the lengths
//!   ([`crate::base::closed::lengths`]), and a random solution is taken.
//!
//! A quadratic equation has roots in the field for half of the draws. If there is no root, another draw is taken.

use std::collections::BTreeMap;

use expr::{Function, Node, Symbol};

use crate::base::angles::GraphAngles;
use crate::base::closed::lengths::random_zero;
use crate::base::closed::orientation::Orientation;
use crate::base::closed::planar_closing::Closing;
use crate::base::closed::planar_loop::PlanarLoop;
use crate::base::closed::pose::Pose;
use crate::base::closed::reason::NoCertificate;
use crate::base::closed::series::{CurveInput, SeriesAlgebra, TaylorSeries};
use crate::base::closed::variables::{State, Variables};
use crate::base::exact_rank::assigned;
use crate::base::field::{Assignment, Residue};
use crate::derivation::Derivation;
use crate::kinematics::loop_chain::{LoopChains, PLACEMENT};
use random::SplitMix;

/// Largest number of draws of all constants of a robot. With k quadratic equations, about one of 2^k draws has a closed point.
const DRAWS_OF_CONSTANTS: usize = 400;
/// Largest number of failures of the constants-first method, missing roots not counted. A few failures may be chance, because
/// roots may coincide.
const MAX_FAILED_DRAWS: usize = 24;
/// Largest number of failures of the angles-first method, missing roots not counted. The number is small, because random angles
/// never coincide.
const MAX_FAILED_ANGLE_DRAWS: usize = 4;
/// Largest number of draws of all variables when the constants of the loops are given.
const DRAWS_OF_A_STATE: usize = 60;
/// Largest number of draws of the free variables of one loop when all other variables are given.
const DRAWS_OF_A_LOOP: usize = 8;
/// Largest number of sets of variables for which the equations of one loop are solved.
const MAX_CLOSING_CHOICES: usize = 200;

/// Values of the constants and variables in the finite field for which all loops are closed.
#[derive(Clone, Debug)]
pub(crate) struct ClosedPoint {
    /// The field elements of each constant, indexed by the symbol of the constant.
    pub constants: Vec<Assignment>,
    pub state: State,
}

/// Finds closed points of one robot. The fields are the functions and data that the search needs.
pub(crate) struct ClosedPoints {
    pub chains: LoopChains,
    pub variables: Variables,
    /// The function whose outputs are the closure error e and its Jacobian J_p by the passive variables.
    pub closure: Function,
    pub closure_angles: GraphAngles,
    placement_angles: GraphAngles,
    /// The symbol of each variable in the closure function, coordinates first.
    pub symbols: Vec<Symbol>,
}

impl ClosedPoints {
    pub(crate) fn new(derivation: &mut Derivation, closure: Function) -> Result<ClosedPoints, NoCertificate> {
        let Derivation { robot, graph, constants, .. } = derivation;
        let chains = LoopChains::new(graph, robot, constants);
        let variables = Variables::new(robot.n_coordinates(), robot.n_variables(), &chains.joints);
        let symbol = |e: &expr::Expr| match closure.graph().node(*e) {
            Node::Symbol(s) => Some(s),
            _ => None,
        };
        let symbols: Option<Vec<Symbol>> = closure.inputs.iter().flat_map(|i| &i.entries).map(symbol).collect();
        Ok(ClosedPoints {
            variables: variables.ok_or(NoCertificate::Ratio)?,
            closure_angles: GraphAngles::of(closure.graph()),
            placement_angles: GraphAngles::of(chains.placements.graph()),
            symbols: symbols.ok_or(NoCertificate::OtherForm)?,
            chains,
            closure,
        })
    }

    /// Finds a closed point by random draws of constants, variables and roots. With `other_roots`, the other root of each
    /// quadratic equation is taken. So the same draws, with the other roots, give another assembly of the loops (for example,
    /// elbow up instead of elbow down).
    pub(crate) fn point(&self, random: &mut SplitMix, other_roots: bool) -> Result<ClosedPoint, NoCertificate> {
        let first = self.attempts(MAX_FAILED_DRAWS, random, |random| self.constants_first(random, other_roots));
        first
            .or_else(|_| self.attempts(MAX_FAILED_ANGLE_DRAWS, random, |random| self.angles_first(random, other_roots)))
    }

    fn attempts(
        &self,
        most_failures: usize,
        random: &mut SplitMix,
        mut draw: impl FnMut(&mut SplitMix) -> Result<Option<ClosedPoint>, NoCertificate>,
    ) -> Result<ClosedPoint, NoCertificate> {
        let mut failures = 0;
        let mut reason = NoCertificate::OtherForm;
        for _ in 0..DRAWS_OF_CONSTANTS {
            match draw(random) {
                // All closure equations must hold at the point, whichever method found it.
                Ok(Some(point)) if self.is_closed(&point) => return Ok(point),
                Ok(None) => {}
                Ok(Some(_)) => failures += 1,
                Err(why) => {
                    reason = why;
                    failures += 1;
                }
            }
            if failures == most_failures {
                break;
            }
        }
        Err(reason)
    }

    /// Finds a closed point with given constants. `None` if a loop is not planar or no draw closes the loops.
    pub(crate) fn point_at(&self, constants: &[Assignment], random: &mut SplitMix) -> Option<ClosedPoint> {
        for _ in 0..DRAWS_OF_A_STATE {
            if let Some(state) = self.state_at(constants, random, false).ok()? {
                let point = ClosedPoint { constants: constants.to_vec(), state };
                return self.is_closed(&point).then_some(point);
            }
        }
        None
    }

    /// Draws random constants with which planar loops can be closed.
    pub(crate) fn constants(&self, random: &mut SplitMix) -> Result<Vec<Assignment>, NoCertificate> {
        let mut constants = self.assigned(random);
        self.fit_planes(&mut constants, random)?;
        Ok(constants)
    }

    /// Makes one attempt by the constants-first method. `None` if a root is not in the field.
    fn constants_first(&self, random: &mut SplitMix, other_roots: bool) -> Result<Option<ClosedPoint>, NoCertificate> {
        let constants = self.constants(random)?;
        let state = self.state_at(&constants, random, other_roots)?;
        Ok(state.map(|state| ClosedPoint { constants, state }))
    }

    /// Makes one attempt to find the variables of a closed point with given constants. `None` if a root is not in the field.
    fn state_at(
        &self,
        constants: &[Assignment],
        random: &mut SplitMix,
        other_roots: bool,
    ) -> Result<Option<State>, NoCertificate> {
        let loops = self.planar_loops(constants).into_iter().collect::<Option<Vec<_>>>();
        let mut open = loops.ok_or(NoCertificate::OtherForm)?;
        let mut state = State::unknown(self.variables.len());
        self.draw(&mut state, random, |k| {
            !self.variables.may_be_solved_as_angle(k) && !self.variables.may_be_solved_as_length(k)
        });
        while let Some(next) = (0..open.len()).min_by_key(|&l| open[l].unknown(&state).len()) {
            let one = open.remove(next);
            let mut unknown = one.unknown(&state);
            // Solving for passive variables is preferred to solving for coordinates.
            unknown.reverse();
            let close = |state: &mut State, by: &[usize], other| one.close(&self.variables, state, by, other);
            let count = one.n_solved(&state);
            match self.closed_by(&mut state, random, &unknown, count, other_roots, close) {
                Closing::Closed => {}
                Closing::NoRoot => return Ok(None),
                Closing::OtherForm => return Err(NoCertificate::OtherForm),
            }
        }
        self.draw(&mut state, random, |_| true);
        Ok(Some(state))
    }

    /// Closes a loop: solves for `count` of the unknown variables of the loop with the function `close`, and draws the other
    /// unknown variables. Of the possible sets of `count` variables, the first set for which this succeeds is taken.
    fn closed_by(
        &self,
        state: &mut State,
        random: &mut SplitMix,
        unknown: &[usize],
        count: usize,
        other_roots: bool,
        close: impl Fn(&mut State, &[usize], bool) -> Closing,
    ) -> Closing {
        // One of the two roots is taken at random, so that several points together cover every assembly of the loops.
        let other_root = (random.bits() & 1 == 1) != other_roots;
        // The other variables of the loop are drawn until the equation of the loop has a root in the field.
        for by in choices(unknown, count).into_iter().take(MAX_CLOSING_CHOICES) {
            let mut outcome = Closing::OtherForm;
            for _ in 0..DRAWS_OF_A_LOOP {
                let mut trial = state.clone();
                unknown.iter().filter(|k| !by.contains(k)).for_each(|&k| trial.draw(k, random));
                outcome = close(&mut trial, &by, other_root);
                if outcome == Closing::Closed {
                    *state = trial;
                    return outcome;
                }
                if outcome == Closing::OtherForm || by.len() == unknown.len() {
                    break;
                }
            }
            if outcome == Closing::NoRoot {
                return outcome;
            }
        }
        Closing::OtherForm
    }

    /// Makes one attempt by the angles-first method. `None` if a root is not in the field.
    fn angles_first(&self, random: &mut SplitMix, other_roots: bool) -> Result<Option<ClosedPoint>, NoCertificate> {
        let mut constants = self.assigned(random);
        self.fit_angles(&mut constants);
        let placements = self.placements(&constants)?;
        let word = |branches| Orientation::new(&self.variables, &placements, &self.chains.joints, branches);
        let mut open: Vec<Orientation> = self.chains.loops.iter().map(word).collect();
        let mut state = State::unknown(self.variables.len());
        let slides = |k: usize| self.variables.may_be_solved_as_length(k);
        self.draw(&mut state, random, |k| !self.variables.may_be_solved_as_angle(k) && !slides(k));
        while let Some(next) = (0..open.len()).min_by_key(|&l| open[l].unknown(&state).len()) {
            let one = open.remove(next);
            let mut unknown = one.unknown(&state);
            if unknown.is_empty() {
                if !one.is_closed(&state) {
                    return Err(NoCertificate::OtherForm);
                }
                continue;
            }
            // Solving for angles that belong only to this loop is preferred to solving for angles that other loops share.
            let shared: Vec<usize> = open.iter().flat_map(|l| l.unknown(&state)).collect();
            unknown.sort_by_key(|k| (shared.contains(k), std::cmp::Reverse(*k)));
            let close = |state: &mut State, by: &[usize], other| one.close(&self.variables, state, by, other);
            let mut by = |count| self.closed_by(&mut state, random, &unknown, count, other_roots, close);
            match (1..=3).map(&mut by).find(|outcome| *outcome != Closing::OtherForm).unwrap_or(Closing::OtherForm) {
                Closing::Closed => {}
                Closing::NoRoot => return Ok(None),
                Closing::OtherForm => return Err(NoCertificate::OtherForm),
            }
        }
        // All angles are known now, so the closure error e is affine in the lengths: a random zero of e closes the loops.
        self.draw(&mut state, random, |k| !slides(k));
        let free: Vec<usize> = (0..self.variables.len()).rev().filter(|&k| slides(k)).collect();
        let lengths = self.lengths_of(&self.closure);
        let f = |x: &[Residue]| {
            let (mut state, mut constants) = (state.clone(), constants.clone());
            free.iter().zip(x).for_each(|(&k, &x)| state.set_length(k, x));
            lengths.iter().zip(&x[free.len()..]).for_each(|(&s, &x)| constants[s].length = x);
            self.closure_at(&ClosedPoint { constants, state }).map(|at| at.0)
        };
        let x = random_zero(free.len() + lengths.len(), f, random).ok_or(NoCertificate::OtherForm)?;
        if x[free.len()..].contains(&Residue::ZERO) {
            return Err(NoCertificate::EqualLengths);
        }
        free.iter().zip(&x).for_each(|(&k, &x)| state.set_length(k, x));
        lengths.iter().zip(&x[free.len()..]).for_each(|(&s, &x)| constants[s].length = x);
        let point = ClosedPoint { constants, state };
        if self.lengths_are_free(&point, &lengths) { Ok(Some(point)) } else { Err(NoCertificate::Overconstrained) }
    }

    fn draw(&self, state: &mut State, random: &mut SplitMix, which: impl Fn(usize) -> bool) {
        for k in (0..self.variables.len()).filter(|&k| which(k)) {
            if !state.knows(k) {
                state.draw(k, random);
            }
        }
    }

    fn assigned(&self, random: &mut SplitMix) -> Vec<Assignment> {
        assigned(self.chains.placements.graph(), random)
    }

    fn placements(&self, constants: &[Assignment]) -> Result<Vec<Pose>, NoCertificate> {
        let graph = self.chains.placements.graph();
        let inputs = BTreeMap::new();
        let mut algebra = SeriesAlgebra::new(graph, &self.placement_angles, constants, &inputs, 0);
        let entries = self.chains.placements.evaluate_in(&mut algebra).swap_remove(0);
        let entries: Vec<Residue> = entries.iter().map(|x| x.at(0)).collect();
        if algebra.broken {
            Err(NoCertificate::OtherForm)
        } else {
            Ok(entries.chunks(PLACEMENT).map(Pose::placement).collect())
        }
    }

    pub(crate) fn planar_loops(&self, constants: &[Assignment]) -> Vec<Option<PlanarLoop>> {
        let Ok(placements) = self.placements(constants) else { return vec![None] };
        let planar = |branches| PlanarLoop::new(&self.variables, &placements, &self.chains.joints, branches);
        self.chains.loops.iter().map(planar).collect()
    }

    /// The values of the variables, as inputs for a function along a curve on which the variables do not change: each series
    /// has only its constant term.
    pub(crate) fn inputs(&self, state: &State) -> BTreeMap<Symbol, CurveInput> {
        let moving = |k: usize| CurveInput {
            point: state.points[k].unwrap_or_default(),
            denominator: self.variables.denominators[k],
            value: TaylorSeries::number(state.lengths[k].unwrap_or_default()),
        };
        self.symbols.iter().enumerate().map(|(k, &s)| (s, moving(k))).collect()
    }

    /// The closure error e and its Jacobian J_p by the passive variables, row by row, at a point. `None` if e or J_p is not
    /// defined in the field (a division by zero).
    pub(crate) fn closure_at(&self, point: &ClosedPoint) -> Option<(Vec<Residue>, Vec<Residue>)> {
        let inputs = self.inputs(&point.state);
        let graph = self.closure.graph();
        let mut algebra = SeriesAlgebra::new(graph, &self.closure_angles, &point.constants, &inputs, 0);
        let values = self.closure.evaluate_in(&mut algebra);
        let numbers = |k: usize| values[k].iter().map(|x| x.at(0)).collect();
        (!algebra.broken).then(|| (numbers(0), numbers(1)))
    }

    fn is_closed(&self, point: &ClosedPoint) -> bool {
        self.closure_at(point).is_some_and(|(e, _)| e.iter().all(|x| *x == Residue::ZERO))
    }
}

/// All subsets of `of` with `count` members, in lexicographic order, at most [`MAX_CLOSING_CHOICES`].
fn choices(of: &[usize], count: usize) -> Vec<Vec<usize>> {
    if count == 0 {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for (i, &first) in of.iter().enumerate() {
        for rest in choices(&of[i + 1..], count - 1) {
            all.push([&[first], rest.as_slice()].concat());
            if all.len() == MAX_CLOSING_CHOICES {
                return all;
            }
        }
    }
    all
}
