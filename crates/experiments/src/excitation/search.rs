//! Many starts, each descended to the wall of the limits.
//!
//! A start draws a spectrum for each joint (for a spline, of its control points). It scales the spectrum into the
//! limits, which some scale always allows, and puts its centre where there is room. Its walls are then lowered in
//! steps, with a descent at each ([`crate::excitation::descent`]). Limits between the samples are settled
//! after it ([`crate::excitation::fitting`]).
//!
//! A third of the starts draws every joint. The others take the best motion so far and draw two of its joints anew.
//! Good motions lie near one another, so the best of as many starts is better that way (docs/benchmarks.md).
//! A start that is behind the best half way down is left there.
//!
//! A start depends on the seed, its number and the rounds before it alone, so the outcome is the same on any number of
//! threads.

use std::f64::consts::{PI, TAU};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use numerics::interruption::Interruption;
use random::Random;

use crate::excitation::descent::descend;
use crate::excitation::limits::LimitKind;
use crate::excitation::motion::Shape;
use crate::excitation::no_motion::{NoMotion, too_small};
use crate::excitation::problem::{Prepared, Problem};
use crate::excitation::space_wall::Seen;
use crate::excitation::walled::{RETURN_HEIGHT, Walled};
use crate::excitation::watched::Watched;
use processor::in_parallel;

/// How much is searched.
#[derive(Clone, Copy, Debug)]
pub struct SearchOptions {
    /// Starting points of the search.
    pub starts: usize,
    /// Most iterations at each height of the walls.
    pub iterations: usize,
    /// Seed of the starting points.
    pub seed: u64,
    /// Threads that share the starts; the result does not depend on them.
    pub threads: usize,
}

/// One start, done.
#[derive(Clone, Debug)]
pub struct Found {
    /// Its number.
    pub start: usize,
    /// By coordinate: its coefficients.
    pub joints: Vec<Vec<f64>>,
    /// J.
    pub criterion: f64,
    /// The least room of a kinematic limit over half its width, with its coordinate and limit.
    pub room: (f64, usize, LimitKind),
    /// The greatest torque or power over its bound with its coordinate and limit, where there are any.
    pub torque: Option<(f64, usize, LimitKind)>,
    /// The least room between bodies above its bound, m, with its gap, where any come near.
    pub nearest: Option<(f64, usize)>,
}

/// Heights of the walls. At the last one they cost the determinant less than a thousandth a limit. A start from a good
/// motion begins at the second.
const WALL_HEIGHTS: [f64; 6] = [3e-1, 5e-2, 1e-2, 2e-3, 3e-4, LAST_WALL_HEIGHT];
/// The last of [`WALL_HEIGHTS`].
const LAST_WALL_HEIGHT: f64 = 5e-5;
/// Gain of a step as a share of 1 + |J|, at the last height and at the ones before. Three smaller gains in turn end a
/// descent. What is left at one height is won at the next. 1e-7 at all heights gives motions that are 0.3 % better, in
/// a third more time (five seeds on UR5 and Panda).
const SMALLEST_DESCENT_GAIN: (f64, f64) = (1e-7, 1e-5);
/// Iterations after which peaks of torque between the instants are looked for again, where torques are near their bounds.
const ITERATIONS_BETWEEN_LOOKS: usize = 25;
/// The same where one is beyond its bound.
const ITERATIONS_BEYOND: usize = 10;
/// What bounds are times at least where a torque is far beyond its own.
const MUCH_RELIEF: f64 = 1.01;
/// Looks at high walls that are there for torques to come back within their bounds.
const MAX_RETURNING_LOOKS: usize = 12;
/// With more joints that move, a start takes half of its iterations at the heights above [`SIFTED_HEIGHT`]: an iteration
/// costs much, and what is left at one height is won at the next.
const FEW_JOINTS: usize = 8;
/// Gain of a step as a share of 1 + |J| that ends a descent among bodies at those heights, where it takes a third of its iterations
/// at the first and half at the others: two thirds of the evaluations. The best of twelve starts tells as much on the Panda (four
/// seeds) and 2 % less on the xarm7 (two); a robot of seven joints without bodies would lose 1 %, and takes them all.
const SMALLEST_GAIN_AMONG_BODIES: f64 = 1e-4;
/// The height at which starts are compared.
const SIFTED_HEIGHT: f64 = 2e-3;
/// A start whose J is behind the best at that height by this much, 3 % of det^(1/p), goes no further: what is left of the
/// descent is worth about as much to each.
const GIVEN_UP_BEHIND: f64 = 0.03;
/// Index of the height at which a start begins again with what is known, after a descent without it.
const HEIGHT_INDEX_AFTER_LONE_DESCENT: usize = 2;
/// Starts of a round that takes the best motion so far. Their number is the same for any number of threads.
const STARTS_PER_ROUND: usize = 4;
/// Joints of the best motion that a start of such a round draws anew.
const REDRAWN_JOINTS: usize = 2;
/// Draws for one start before it is given up.
const MAX_DRAWS_PER_START: usize = 60;
/// Times a drawn motion is made smaller before it is given up.
const MAX_SHRINKS_PER_DRAW: usize = 12;
/// Share of a torque's bound up to which a drawn motion is taken.
const MAX_DRAWN_TORQUE_SHARE: f64 = 0.95;
/// Centres drawn for a start whose robot has bodies, and draws about those that are free, before descents look for one: a robot
/// that needs more has hardly any free pose.
const MAX_CENTRES_PER_START: usize = 200;
const MAX_DRAWS_AMONG_BODIES: usize = 10;
/// Times that a motion about a centre that a descent found is made smaller: one that is smaller tells columns of many joints apart no
/// more, and no descent begins with it.
const MAX_SHRINKS_AFTER_DESCENT: usize = 9;
/// Descents of a start before it is given up.
const MAX_DESCENTS_PER_START: usize = 40;
/// Share of the room about a centre that a descent found up to which a motion swings.
const SHARE_OF_ROOM: f64 = 0.9;

/// All starts that found a motion, the best first. `progress`: as each is done, with how many are done.
///
/// Fails where no start keeps the limits, with what stands in the way. Interrupted, it gives what there is.
pub fn search(
    problem: &Problem,
    options: &SearchOptions,
    progress: &(dyn Fn(usize, Option<&Found>) + Sync),
) -> Result<Vec<Found>, NoMotion> {
    // A start has the threads that others leave.
    let threads_of_start = (options.threads / options.starts.max(1)).max(1);
    let prepared = Prepared::new(problem).with_threads(threads_of_start);
    if prepared.moving().is_empty() {
        return Err(NoMotion::AllLocked);
    }
    if prepared.p() == 0 {
        return Err(NoMotion::NothingToTell);
    }
    // Where much is known already the criterion is flat, and its slopes lead to poor motions. So a start goes first to
    // where the motion alone tells most.
    let alone = Problem { prior: &[], ..problem.clone() };
    let alone = (!problem.prior.is_empty()).then(|| Prepared::new(&alone).with_threads(threads_of_start));
    let (done, interruption) = (AtomicUsize::new(0), Interruption::here());
    let search = Searched { alone: alone.as_ref(), prepared: &prepared, problem, iterations: options.iterations };
    // Of those that are begun only the ones that may still win go on to the end.
    let mut promising = f64::INFINITY;
    let mut round = |starts: Range<usize>, best: Option<&[f64]>| {
        let begin = |start: usize| {
            let is_over = interruption.is_raised();
            (!is_over).then(|| (start, interruption.during(|| begun(&search, options.seed, start, best))))
        };
        let all = in_parallel(starts.collect(), options.threads, begin);
        let all: Vec<(usize, Result<Begun, NoMotion>)> = all.into_iter().flatten().collect();
        let values = all.iter().filter_map(|(_, begun)| begun.as_ref().ok());
        promising = values.map(|begun| begun.criterion).fold(promising, f64::min);
        let end = |(start, begun): (usize, Result<Begun, NoMotion>)| {
            let outcome = begun.and_then(|begun| {
                let goes_on = begun.criterion <= promising + GIVEN_UP_BEHIND;
                interruption.during(|| if goes_on { search.ended(begun) } else { search.found(&begun) })
            });
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, outcome.as_ref().ok());
            (start, outcome)
        };
        in_parallel(all, options.threads, end)
    };
    let starts = options.starts.max(1);
    let mut all = round(0..starts.div_ceil(3), None);
    while all.len() < starts && !interruption.is_raised() {
        let found = all.iter().filter_map(|(_, outcome)| outcome.as_ref().ok());
        let best = found.min_by(|a, b| a.criterion.total_cmp(&b.criterion)).map(|f| prepared.scaled(&f.joints));
        let next = all.len()..starts.min(all.len() + STARTS_PER_ROUND);
        all.extend(round(next, best.as_deref()));
    }
    let mut failed = NoMotion::NothingToTell;
    let mut found = Vec::new();
    for (_, outcome) in all {
        match outcome {
            Ok(motion) => found.push(motion),
            Err(why) => failed = why,
        }
    }
    found.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    if found.is_empty() { Err(failed) } else { Ok(found) }
}

/// What a search from this motion, by so many threads, finds within the walls of the problem; `None` where even a small motion
/// about the same centre is beyond one.
pub fn searched_on(problem: &Problem, iterations: usize, threads: usize, joints: &[Vec<f64>]) -> Option<Found> {
    let prepared = Prepared::new(problem).with_threads(threads);
    let (m, seen) = (problem.shape.size(), Seen::default());
    let mut x = prepared.scaled(joints);
    let is_inside = |x: &[f64]| {
        let is_weak = prepared.greatest_torque(x).is_none_or(|(share, ..)| share <= MAX_DRAWN_TORQUE_SHARE);
        is_weak && prepared.is_inside(prepared.nearest(&seen, x))
    };
    let mut shrinks = 0;
    while !is_inside(&x) {
        shrinks += 1;
        if shrinks > 2 * MAX_SHRINKS_PER_DRAW {
            return None;
        }
        x.chunks_exact_mut(m).for_each(|joint| joint[1..].iter_mut().for_each(|x| *x *= 0.9));
    }
    let search = Searched { alone: None, prepared: &prepared, problem, iterations };
    let begun = search.begun(0, x, seen, &WALL_HEIGHTS[1..]).ok()?;
    search.ended(begun).ok()
}

/// J of a motion, where it tells anything.
pub fn criterion_of(problem: &Problem, joints: &[Vec<f64>]) -> Option<f64> {
    let prepared = Prepared::new(problem);
    prepared.criterion(&prepared.scaled(joints))
}

/// What every start of a search shares.
struct Searched<'a> {
    /// The problem without what is known, where anything is.
    alone: Option<&'a Prepared<'a>>,
    prepared: &'a Prepared<'a>,
    problem: &'a Problem<'a>,
    iterations: usize,
}

/// A start that has come down to [`SIFTED_HEIGHT`].
struct Begun {
    start: usize,
    x: Vec<f64>,
    seen: Seen,
    watched: Watched,
    /// J there: of the motion alone, where something is known.
    criterion: f64,
}

/// One start down to [`SIFTED_HEIGHT`]: from a random motion, or from the best so far with some of its joints drawn anew.
fn begun(search: &Searched, seed: u64, start: usize, best: Option<&[f64]>) -> Result<Begun, NoMotion> {
    let (mut random, seen) = (Random::stream(seed, start as u64), Seen::default());
    let near = best.and_then(|best| near(search.prepared, search.problem, best, &mut random, &seen));
    let (x, heights) = match near {
        Some(x) => (x, &WALL_HEIGHTS[1..]),
        None => (first(search.prepared, search.problem, &mut random, &seen)?, &WALL_HEIGHTS[..]),
    };
    search.begun(start, x, seen, heights)
}

impl Searched<'_> {
    /// From a motion that is inside all walls down to [`SIFTED_HEIGHT`].
    fn begun(&self, start: usize, x: Vec<f64>, seen: Seen, heights: &[f64]) -> Result<Begun, NoMotion> {
        let prepared = self.alone.unwrap_or(self.prepared);
        let high = heights.iter().copied().filter(|height| *height >= SIFTED_HEIGHT);
        let mut watched = Watched::default();
        let x = self.descended(high.map(|height| (prepared, height)), x, &seen, &mut watched);
        let criterion = prepared.criterion(&x).ok_or_else(|| too_small(prepared, self.problem, &x))?;
        Ok(Begun { start, x, seen, watched, criterion })
    }

    /// The rest of the descent. Where something is known already: first without it, then with it, at ever lower walls.
    fn ended(&self, mut begun: Begun) -> Result<Found, NoMotion> {
        let low = || WALL_HEIGHTS.into_iter().filter(|height| *height < SIFTED_HEIGHT);
        let alone = self.alone.into_iter().flat_map(|alone| low().map(move |height| (alone, height)));
        let last = match self.alone {
            Some(_) => &WALL_HEIGHTS[HEIGHT_INDEX_AFTER_LONE_DESCENT..],
            None => &WALL_HEIGHTS[WALL_HEIGHTS.len() - low().count()..],
        };
        let all = alone.chain(last.iter().map(|height| (self.prepared, *height)));
        let x = self.descended(all, begun.x, &begun.seen, &mut begun.watched);
        self.found(&Begun { x, ..begun })
    }

    /// The descent at one height after the other.
    fn descended<'p>(
        &self,
        heights: impl Iterator<Item = (&'p Prepared<'p>, f64)>,
        from: Vec<f64>,
        seen: &Seen,
        watched: &mut Watched,
    ) -> Vec<f64> {
        let mut x = from;
        for (prepared, height) in heights {
            let (part, least) = match height {
                LAST_WALL_HEIGHT => (1, SMALLEST_DESCENT_GAIN.0),
                _ if height <= SIFTED_HEIGHT => (1, SMALLEST_DESCENT_GAIN.1),
                _ if prepared.space.is_some() => {
                    (if height == WALL_HEIGHTS[0] { 3 } else { 2 }, SMALLEST_GAIN_AMONG_BODIES)
                }
                _ => (if prepared.moving().len() > FEW_JOINTS { 2 } else { 1 }, SMALLEST_DESCENT_GAIN.1),
            };
            let mut left = self.iterations.div_ceil(part);
            let mut returning = MAX_RETURNING_LOOKS;
            while left > 0 && Interruption::check().is_ok() {
                let watching = watched.renewed(prepared, &x);
                let (is_pressed, relief) = (watched.is_pressed(), watched.relief());
                // Low walls hold a motion where it is: above them a torque that is far beyond its bound comes back.
                let height = if relief > MUCH_RELIEF { height.max(RETURN_HEIGHT) } else { height };
                let walled = Walled::new(watching.as_ref().unwrap_or(prepared), height, seen);
                let portion = match (is_pressed, relief > 1.0) {
                    (_, true) => left.min(ITERATIONS_BEYOND),
                    (true, false) => left.min(ITERATIONS_BETWEEN_LOOKS),
                    (false, false) => left,
                };
                let Some(found) = descend(&walled, &x, portion, least) else { break };
                x = found.x;
                match relief > 1.0 && height >= RETURN_HEIGHT && returning > 0 {
                    true => returning -= 1,
                    false => left -= portion,
                }
                if found.iterations < portion && relief == 1.0 {
                    break;
                }
            }
        }
        x
    }

    /// What was found, without the walls' part of the value.
    fn found(&self, Begun { start, x, seen, .. }: &Begun) -> Result<Found, NoMotion> {
        let prepared = self.prepared;
        let criterion = prepared.criterion(x).ok_or_else(|| too_small(prepared, self.problem, x))?;
        let (room, joint, limit) = prepared.barrier().least_room(x).ok_or(NoMotion::AllLocked)?;
        Ok(Found {
            start: *start,
            joints: prepared.joints(x),
            criterion,
            room: (room, prepared.moving()[joint], limit),
            torque: prepared.greatest_torque(x),
            nearest: prepared.nearest(seen, x),
        })
    }
}

/// A random motion about a random centre, a share of the limits wide.
fn drawn(prepared: &Prepared, problem: &Problem, random: &mut Random) -> Vec<f64> {
    let m = problem.shape.size();
    let barrier = prepared.barrier();
    let mut x = vec![0.0; m * prepared.moving().len()];
    for (j, &k) in prepared.moving().iter().enumerate() {
        draw_spectrum(&problem.shape, random, &mut x[j * m + 1..(j + 1) * m]);
        let limits = &problem.limits[k];
        let share = |kind: LimitKind| {
            let (low, high) = barrier.reached(j, &x, kind);
            match (kind, limits.bounds(kind)) {
                (LimitKind::Position, Some((a, b))) => (high - low) / (b - a),
                (_, Some((_, b))) => high.max(-low) / b,
                (_, None) => 0.0,
            }
        };
        let most = LimitKind::KINEMATIC.into_iter().map(share).fold(0.0, f64::max);
        let factor = random.between(0.4, 0.85) / most.max(f64::MIN_POSITIVE);
        x[j * m + 1..(j + 1) * m].iter_mut().for_each(|x| *x *= factor);
        let (least, greatest) = barrier.reached(j, &x, LimitKind::Position);
        let (low, high) = limits.position;
        let margin = 0.05 * (high - low);
        let room = (low + margin - least, high - margin - greatest);
        let (from, to) = if high - low > TAU { turn_about_zero(room) } else { room };
        let centre = random.between(from, to);
        x[j * m] = centre / (0.5 * (high - low));
    }
    x
}

/// The turn of a room that is nearest to zero: another tells the same, and winds up cables.
fn turn_about_zero((low, high): (f64, f64)) -> (f64, f64) {
    let middle = 0.0_f64.max(low).min(high);
    (low.max(middle - PI), high.min(middle + PI))
}

/// The best motion with some of its joints drawn anew, their swing as small as torques and distances ask; `None` where
/// that is not enough.
fn near(prepared: &Prepared, problem: &Problem, best: &[f64], random: &mut Random, seen: &Seen) -> Option<Vec<f64>> {
    let m = problem.shape.size();
    let other = drawn(prepared, problem, random);
    let mut x = best.to_vec();
    let anew: Vec<usize> = (0..REDRAWN_JOINTS).map(|_| random.index(prepared.moving().len())).collect();
    anew.iter().for_each(|&j| x[j * m..(j + 1) * m].copy_from_slice(&other[j * m..(j + 1) * m]));
    for _ in 0..MAX_SHRINKS_PER_DRAW {
        let is_weak = prepared.greatest_torque(&x).is_none_or(|(share, ..)| share <= MAX_DRAWN_TORQUE_SHARE);
        if is_weak && prepared.is_inside(prepared.nearest(seen, &x)) {
            return Some(x);
        }
        anew.iter().for_each(|&j| shrink(&mut x[j * m..(j + 1) * m]));
    }
    None
}

/// A joint with a smaller swing about its pose.
fn shrink(joint: &mut [f64]) {
    joint[1..].iter_mut().for_each(|x| *x *= 0.7);
}

/// The coefficients of a coordinate behind its pose, by a random spectrum of its velocity.
fn draw_spectrum(shape: &Shape, random: &mut Random, x: &mut [f64]) {
    for l in 0..x.len() / 2 {
        // The square leaves some harmonics nearly silent.
        let weight = random.uniform().powi(2);
        match shape {
            Shape::Fourier(_) => x[2 * l..2 * l + 2].fill_with(|| weight * random.normal()),
            Shape::Spline(spline) => {
                // Half-waves: they vanish at both ends. The amplitude of the position is that of the velocity over l.
                let (half_waves, amplitude) = ((l + 1) as f64, weight * random.normal());
                let turn = PI * half_waves / spline.spans as f64;
                let wave = |i: usize| amplitude / half_waves * libm::sin(turn * (i + 1) as f64);
                x.iter_mut().enumerate().for_each(|(i, x)| *x += wave(i));
            }
        }
    }
}

/// A motion within all limits: a random spectrum, scaled, about a random centre; where none of those is free, about one that a
/// descent frees, from the zero pose, the middle of the limits, and random poses.
fn first(prepared: &Prepared, problem: &Problem, random: &mut Random, seen: &Seen) -> Result<Vec<f64>, NoMotion> {
    let mut tried = Tried { weakest: (f64::INFINITY, 0, LimitKind::Effort), narrowest: None };
    let (centres, most) = match problem.surroundings {
        Some(_) => (MAX_CENTRES_PER_START, MAX_DRAWS_AMONG_BODIES),
        None => (MAX_DRAWS_PER_START, MAX_DRAWS_PER_START),
    };
    let mut draws = 0;
    for _ in 0..centres {
        if draws == most || Interruption::check().is_err() {
            break;
        }
        let x = drawn(prepared, problem, random);
        if tried.is_free(prepared, prepared.nearest_at_centre(&x)) {
            draws += 1;
            if let Some(x) = tried.small_enough(prepared, x, seen, MAX_SHRINKS_PER_DRAW) {
                return Ok(x);
            }
        }
    }
    for descent in 0..MAX_DESCENTS_PER_START {
        if Interruption::check().is_err() {
            break;
        }
        let mut x = drawn(prepared, problem, random);
        let centre = prepared.freed(&match descent {
            0 => prepared.home(),
            1 => prepared.middle(),
            _ => prepared.positions(&x, &[1.0]),
        });
        put_about(prepared, problem, &mut x, &centre);
        if tried.is_free(prepared, prepared.nearest_at_centre(&x))
            && let Some(x) = tried.small_enough(prepared, x, seen, MAX_SHRINKS_AFTER_DESCENT)
        {
            return Ok(x);
        }
    }
    Err(tried.why())
}

/// Whether any of two starts has a motion to begin with: far sooner told than by a search.
pub fn can_begin(problem: &Problem, seed: u64) -> bool {
    let prepared = Prepared::new(problem);
    let has_motion = |start| first(&prepared, problem, &mut Random::stream(seed, start), &Seen::default()).is_ok();
    prepared.moving().is_empty() || (0..2).any(has_motion)
}

/// What is nearest to being kept of all that was tried.
struct Tried {
    weakest: (f64, usize, LimitKind),
    narrowest: Option<(f64, usize)>,
}

impl Tried {
    /// Whether bodies are so far from each other; about a centre at which they meet there is no motion, however small.
    fn is_free(&mut self, prepared: &Prepared, nearest: Option<(f64, usize)>) -> bool {
        let is_free = prepared.is_inside(nearest);
        if let Some(near) = nearest.filter(|n| !is_free && self.narrowest.is_none_or(|best| n.0 > best.0)) {
            self.narrowest = Some(near);
        }
        is_free
    }

    /// The motion made smaller until it is within the limits of torques and bodies. Down to a tenth of the swing the torque may be
    /// that of the motion; below, it is that of gravity.
    fn small_enough(&mut self, prepared: &Prepared, mut x: Vec<f64>, seen: &Seen, shrinks: usize) -> Option<Vec<f64>> {
        let m = x.len() / prepared.moving().len();
        for _ in 0..shrinks {
            if Interruption::check().is_err() {
                return None;
            }
            let strong = prepared.greatest_torque(&x).filter(|strong| strong.0 > MAX_DRAWN_TORQUE_SHARE);
            if let Some(less) = strong.filter(|strong| strong.0 < self.weakest.0) {
                self.weakest = less;
            }
            if strong.is_none() && self.is_free(prepared, prepared.nearest(seen, &x)) {
                return Some(x);
            }
            x.chunks_exact_mut(m).for_each(shrink);
        }
        None
    }

    fn why(self) -> NoMotion {
        let (share, coordinate, limit) = self.weakest;
        match self.narrowest {
            Some((room, gap)) if share == f64::INFINITY => NoMotion::TooNarrow { gap, room },
            _ => NoMotion::TooWeak { coordinate, limit, share },
        }
    }
}

/// Puts a motion about another centre, its swings no greater than the room there.
fn put_about(prepared: &Prepared, problem: &Problem, x: &mut [f64], centre: &[f64]) {
    let m = problem.shape.size();
    for (j, &k) in prepared.moving().iter().enumerate() {
        let (low, high) = problem.limits[k].position;
        x[j * m] = centre[k] / (0.5 * (high - low));
        let (least, greatest) = prepared.barrier().reached(j, x, LimitKind::Position);
        let up = (high - centre[k]) / (greatest - centre[k]).max(f64::MIN_POSITIVE);
        let down = (centre[k] - low) / (centre[k] - least).max(f64::MIN_POSITIVE);
        let factor = (SHARE_OF_ROOM * up.min(down)).min(1.0);
        x[j * m + 1..(j + 1) * m].iter_mut().for_each(|x| *x *= factor);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::excitation::criterion::Aim;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::limits::CoordinateLimits;
    use crate::excitation::proof::DescribedFriction;
    use crate::excitation::quintic_spline::QuinticSpline;
    use crate::excitation::torque_wall::TorqueWall;
    use crate::pendulum::Pendulum;
    use linear_model::differentiable::{DifferentiableRegressor, DifferentiableTorques};
    use linear_model::friction::terms::FrictionTerm;
    use linear_model::regressor::Regressor;

    impl DifferentiableRegressor for Pendulum {
        fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]) {
            for ((s, w), g) in states.chunks_exact(3).zip(weights.chunks_exact(3)).zip(gradient.chunks_exact_mut(3)) {
                let (sine, cosine) = s[0].sin_cos();
                g.copy_from_slice(&[-9.81 * (w[1] * sine + w[2] * cosine), 0.0, w[0]]);
            }
        }

        fn torques(&self, parameters: &[f64]) -> Box<dyn DifferentiableTorques + '_> {
            Box::new(PendulumTorque(Pendulum::new(), parameters.to_vec()))
        }
    }

    struct PendulumTorque(Pendulum, Vec<f64>);

    impl DifferentiableTorques for PendulumTorque {
        fn fill_many(&self, states: &[f64], torques: &mut [f64]) {
            let mut y = vec![0.0; states.len()];
            self.0.fill_many(states, &mut y);
            let product = |y: &[f64]| y.iter().zip(&self.1).map(|(y, x)| y * x).sum::<f64>();
            torques.iter_mut().zip(y.chunks_exact(3)).for_each(|(tau, y)| *tau = product(y));
        }

        fn pull_back(&self, states: &[f64], weights: &[f64], gradient: &mut [f64]) {
            let weights: Vec<f64> = weights.iter().flat_map(|w| self.1.iter().map(move |x| w * x)).collect();
            self.0.pull_back(states, &weights, gradient);
        }
    }

    /// Limits of position, velocity, acceleration and jerk.
    pub(crate) fn limits(position: (f64, f64), [velocity, acceleration, jerk]: [f64; 3]) -> CoordinateLimits {
        let (effort, power, locked) = (None, None, None);
        CoordinateLimits { position, velocity, acceleration, jerk, effort, power, locked }
    }

    pub(crate) fn pendulum_limits() -> CoordinateLimits {
        CoordinateLimits { effort: Some(12.0), ..limits((-1.5, 2.0), [2.0, 8.0, 150.0]) }
    }

    pub(crate) fn pendulum_torque() -> TorqueWall {
        let friction = vec![DescribedFriction { viscous: 0.1, coulomb: 0.2, offset: 0.05 }];
        TorqueWall { parameters: vec![0.3, 0.8, -0.1], friction, share: 0.9 }
    }

    /// A pendulum that swings within limits and a torque.
    pub(crate) fn problem<'a>(arm: &'a Pendulum, limits: &'a [CoordinateLimits], wall: &'a TorqueWall) -> Problem<'a> {
        Problem {
            regressor: arm,
            friction: &[FrictionTerm::Viscous],
            limits,
            noise: &[0.1],
            aim: Aim::Determinant,
            torque: Some(wall),
            columns: &[true; 4],
            shape: Shape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 }),
            samples: 60,
            surroundings: None,
            prior: &[],
        }
    }

    #[test]
    fn the_same_motion_on_any_number_of_threads() {
        let (arm, limits, wall) = (Pendulum::new(), [pendulum_limits()], pendulum_torque());
        let series = problem(&arm, &limits, &wall);
        let shape = Shape::Spline(QuinticSpline { period: 5.0, spans: 9 });
        for problem in [Problem { shape, ..problem(&arm, &limits, &wall) }, series] {
            let run = |threads| {
                let options = SearchOptions { starts: 4, iterations: 20, seed: 7, threads };
                search(&problem, &options, &|_, _| ()).unwrap()
            };
            let (one, three) = (run(1), run(3));
            assert_eq!(one.len(), 4);
            for (a, b) in one.iter().zip(&three) {
                assert_eq!((a.start, &a.joints, a.criterion), (b.start, &b.joints, b.criterion));
            }
            assert!(one.iter().all(|f| f.room.0 > 0.0 && f.torque.unwrap().0 < 1.0));
            // The descent ends far above where random motions are.
            let prepared = Prepared::new(&problem);
            let random = first(&prepared, &problem, &mut Random::new(1), &Seen::default()).unwrap();
            assert!(one[0].criterion < prepared.criterion(&random).unwrap() - 0.5);
        }
    }

    #[test]
    fn what_cannot_move_says_why() {
        let (arm, mut limits, mut wall) = (Pendulum::new(), [pendulum_limits()], pendulum_torque());
        let options = SearchOptions { starts: 1, iterations: 5, seed: 1, threads: 1 };
        // Dry friction alone takes 0.2 N m, more than a hundredth of 12. (With 0.04 N m besides there is a motion near the edge of the
        // room, where gravity takes none.)
        wall.share = 0.01;
        let why = search(&problem(&arm, &limits, &wall), &options, &|_, _| ()).unwrap_err();
        let NoMotion::TooWeak { coordinate: 0, limit: LimitKind::Effort, share } = why else { panic!("{why:?}") };
        assert!(share > 1.0, "{share}");
        limits[0].locked = Some(0.0);
        let why = search(&problem(&arm, &limits, &wall), &options, &|_, _| ()).unwrap_err();
        assert_eq!(why, NoMotion::AllLocked);
    }
}
