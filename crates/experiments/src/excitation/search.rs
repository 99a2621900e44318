//! Searches an exciting motion with many starts; each start is a descent within the barriers of the limits.
//!
//! A start draws a random spectrum for each joint (for a spline: a spectrum of the control points). It scales the spectrum down
//! until the limits are kept, which is always possible, and places the centre where the limits allow. Then the weight of the
//! barriers is lowered in steps, with a descent at each weight ([`crate::excitation::descent`]). Limits between the samples are
//! enforced afterwards ([`crate::excitation::fitting`]).
//!
//! A third of the starts draws the motions of all joints at random. The other starts take the best motion found so far and
//! redraw two of its joints. Good motions are near one another, so this gives better results for the same number of starts
//! (docs/benchmarks.md). A start that is worse than the best one after half of the weights ends there.
//!
//! A start depends only on the seed, its number and the rounds before it. The number of threads does not change the result.

use std::f64::consts::{PI, TAU};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use numerics::interruption::Interruption;
use random::Random;

use crate::excitation::descent::descend;
use crate::excitation::distance_barrier::Seen;
use crate::excitation::limits::LimitKind;
use crate::excitation::motion::MotionShape;
use crate::excitation::no_motion::{NoMotion, too_small};
use crate::excitation::problem::{Prepared, Problem};
use crate::excitation::watched::Watched;
use crate::excitation::with_barriers::{RETURN_HEIGHT, WithBarriers};
use processor::in_parallel;

/// Number of starts, iterations and threads of a search.
#[derive(Clone, Copy, Debug)]
pub struct SearchOptions {
    /// Number of starts of the search. Each start is an independent descent from its own initial motion.
    pub starts: usize,
    /// Greatest number of iterations of a descent at each weight of the barriers.
    pub iterations: usize,
    /// Seed of the random numbers of all starts.
    pub seed: u64,
    /// Number of threads that share the starts; it does not change the result.
    pub threads: usize,
}

/// The motion that one start (descent from one initial motion) of a search found.
#[derive(Clone, Debug)]
pub struct StartResult {
    /// Number of the start, from zero.
    pub start: usize,
    /// Coefficients of the motion for each coordinate, the centre first.
    pub joints: Vec<Vec<f64>>,
    /// Optimality criterion J of the motion, without barriers; smaller is better.
    pub criterion: f64,
    /// The least distance to a kinematic limit, divided by half the width of this limit; with the coordinate and the kind of
    /// limit.
    pub room: (f64, usize, LimitKind),
    /// The greatest ratio of a torque or power to its bound, with the coordinate and the kind of limit. `None`: they are not
    /// limited.
    pub torque: Option<(f64, usize, LimitKind)>,
    /// The pair of bodies nearest to its bound: distance minus bound (m) and index of the pair (gap). `None`: no bodies are
    /// near each other.
    pub nearest: Option<(f64, usize)>,
}

/// Weights of the barriers in the successive descents of a start (descent from one initial motion), from first to last. At the
/// last weight, each limit reduces the determinant by less than a thousandth. A start from a good motion skips the first weight.
const BARRIER_WEIGHTS: [f64; 6] = [3e-1, 5e-2, 1e-2, 2e-3, 3e-4, LAST_BARRIER_WEIGHT];
/// The last barrier weight of a start, the smallest in [`BARRIER_WEIGHTS`].
const LAST_BARRIER_WEIGHT: f64 = 5e-5;
/// Least decrease of the criterion J in an iteration, as a share of 1 + |J|: at the last barrier weight, and at the weights
/// before. A descent ends after three consecutive smaller decreases; the remaining decrease follows at the next weight. 1e-7 at
/// all weights gives motions that are 0.3 % better, in a third more time (five seeds on UR5 and Panda).
const SMALLEST_DESCENT_GAIN: (f64, f64) = (1e-7, 1e-5);
/// If torques are near their bounds, the torque peaks between the instants are searched again after this number of iterations.
const ITERATIONS_PER_PEAK_SEARCH: usize = 25;
/// If a torque exceeds its bound, the torque peaks between the instants are searched again after this number of iterations.
const ITERATIONS_PER_PEAK_SEARCH_BEYOND: usize = 10;
/// A torque counts as far above its bound if its temporary bound is raised by more than this factor.
const LARGE_RELIEF: f64 = 1.01;
/// Greatest number of descents, per barrier weight, that bring torques back below their bounds. They use a higher weight.
const MAX_RETURN_DESCENTS: usize = 12;
/// Up to this number of moving joints, a start uses all iterations at the barrier weights above [`SELECTION_WEIGHT`]. With more
/// joints it uses half, because an iteration is expensive and the remaining decrease follows at the next weight.
const MAX_JOINTS_FOR_ALL_ITERATIONS: usize = 8;
/// For a robot with bodies: least decrease of the criterion J in an iteration at barrier weights above [`SELECTION_WEIGHT`], as
/// a share of `1 + |J|`. With this value a descent ends after a third of the iterations at the first weight, and after half of
/// them at the others; this saves a third of the evaluations. The best of twelve starts is then equally good on the Panda (four
/// seeds) and 2 % worse on the xarm7 (two seeds). A robot of seven joints without bodies would lose 1 %, so its descents do not
/// end early.
const SMALLEST_GAIN_AMONG_BODIES: f64 = 1e-4;
/// At this barrier weight, the values of the criterion J of all starts are compared, and poor starts are ended.
const SELECTION_WEIGHT: f64 = 2e-3;
/// A start ends at [`SELECTION_WEIGHT`] if its criterion J is worse than the best J at this weight by more than this margin (3
/// % of det^(1/p)). The further decrease is about the same for every start.
const SELECTION_MARGIN: f64 = 0.03;
/// A start first descends through all barrier weights without prior information. Then it descends with the prior information,
/// from the barrier weight with this index on.
const WEIGHT_INDEX_WITH_PRIOR: usize = 2;
/// Number of starts in a round. All starts of a round after the first redraw joints of the motion that was the best before the
/// round. The number is the same for any number of threads.
const STARTS_PER_ROUND: usize = 4;
/// Number of joints that a start of a later round replaces in the best motion by randomly drawn ones.
const REDRAWN_JOINTS: usize = 2;
/// Greatest number of motions that are drawn at random for one start of a robot without bodies.
const MAX_DRAWS_PER_START: usize = 60;
/// Greatest number of times that a drawn motion is scaled down.
const MAX_SHRINKS_PER_DRAW: usize = 12;
/// A drawn motion is accepted only if the ratio of each torque or power to its bound is at most this value.
const MAX_DRAWN_TORQUE_SHARE: f64 = 0.95;
/// For a start of a robot with bodies. This number limits both the random centres that are tested and the motions that are
/// tried about collision-free centres. After that, a descent searches the centre, because such a robot has hardly any
/// collision-free pose.
const MAX_CENTRES_PER_START: usize = 200;
const MAX_DRAWS_AMONG_BODIES: usize = 10;
/// Greatest number of times that a motion about a centre found by descent is scaled down. A smaller motion cannot separate the
/// columns of many joints, and no descent can start from it.
const MAX_SHRINKS_AFTER_DESCENT: usize = 9;
/// Greatest number of descents with which a start searches a collision-free centre.
const MAX_DESCENTS_PER_START: usize = 40;
/// Share of the position range about a centre found by descent that the swing (deviation from the centre) of a motion may use.
const SWING_RANGE_SHARE: f64 = 0.9;
/// Factor of one step that scales down the swing (deviation from the centre) of a motion drawn at random.
const SHRINK_FACTOR: f64 = 0.7;
/// Factor of one step that scales down the swing (deviation from the centre) of a given motion.
const FINE_SHRINK_FACTOR: f64 = 0.9;
/// Least and greatest share of the kinematic limits that a drawn motion uses; the share is random between them.
const DRAWN_LIMIT_SHARES: (f64, f64) = (0.4, 0.85);
/// Share of the position range that a drawn motion keeps free at each end.
const DRAWN_RANGE_MARGIN: f64 = 0.05;

/// Searches an exciting motion and gives the results of all successful starts, the best first. `progress` is called at the end of
/// each start with the number of ended starts and the result of this start (`None`: it failed).
///
/// Fails with the reason if no start keeps the limits. If the search is interrupted, it gives the results so far.
pub fn search(
    problem: &Problem,
    options: &SearchOptions,
    progress: &(dyn Fn(usize, Option<&StartResult>) + Sync),
) -> Result<Vec<StartResult>, NoMotion> {
    // If there are more threads than starts, each start uses several threads.
    let threads_of_start = (options.threads / options.starts.max(1)).max(1);
    let prepared = Prepared::new(problem).with_threads(threads_of_start);
    if prepared.moving().is_empty() {
        return Err(NoMotion::AllLocked);
    }
    if prepared.p() == 0 {
        return Err(NoMotion::NothingToTell);
    }
    // With much prior information the criterion is flat, and its gradient leads to poor motions. Therefore a start first descends
    // to the best motion without prior information, then with it.
    let alone = Problem { prior: &[], ..problem.clone() };
    let alone = (!problem.prior.is_empty()).then(|| Prepared::new(&alone).with_threads(threads_of_start));
    let (done, interruption) = (AtomicUsize::new(0), Interruption::here());
    let search = SharedSearch { alone: alone.as_ref(), prepared: &prepared, problem, iterations: options.iterations };
    // Only starts whose criterion J is close to the best J so far continue to the last barrier weight.
    let mut promising = f64::INFINITY;
    let mut round = |starts: Range<usize>, best: Option<&[f64]>| {
        let begin = |start: usize| {
            let is_over = interruption.is_raised();
            (!is_over).then(|| (start, interruption.during(|| candidate_start(&search, options.seed, start, best))))
        };
        let all = in_parallel(starts.collect(), options.threads, begin);
        let all: Vec<(usize, Result<CandidateStart, NoMotion>)> = all.into_iter().flatten().collect();
        let values = all.iter().filter_map(|(_, begun)| begun.as_ref().ok());
        promising = values.map(|begun| begun.criterion).fold(promising, f64::min);
        let end = |(start, begun): (usize, Result<CandidateStart, NoMotion>)| {
            let outcome = begun.and_then(|begun| {
                let goes_on = begun.criterion <= promising + SELECTION_MARGIN;
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

/// Searches a motion by one descent from a given motion, on `threads` threads. `None` if even a small motion about the same
/// centre violates a limit of torques or distances.
pub fn searched_on(problem: &Problem, iterations: usize, threads: usize, joints: &[Vec<f64>]) -> Option<StartResult> {
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
        x.chunks_exact_mut(m).for_each(|joint| joint[1..].iter_mut().for_each(|x| *x *= FINE_SHRINK_FACTOR));
    }
    let search = SharedSearch { alone: None, prepared: &prepared, problem, iterations };
    let begun = search.begun(0, x, seen, &BARRIER_WEIGHTS[1..]).ok()?;
    search.ended(begun).ok()
}

/// Criterion J of a motion with these coefficients of each coordinate. `None` if its regressor rows do not have full rank.
pub fn criterion_of(problem: &Problem, joints: &[Vec<f64>]) -> Option<f64> {
    let prepared = Prepared::new(problem);
    prepared.criterion(&prepared.scaled(joints))
}

struct SharedSearch<'a> {
    /// The search problem without prior information. `None` if there is no prior information.
    alone: Option<&'a Prepared<'a>>,
    prepared: &'a Prepared<'a>,
    problem: &'a Problem<'a>,
    iterations: usize,
}

/// The state of a start (descent from one initial motion) after the barrier weights down to [`SELECTION_WEIGHT`].
struct CandidateStart {
    start: usize,
    x: Vec<f64>,
    seen: Seen,
    watched: Watched,
    /// Criterion J of the motion with the scaled coefficients `x`, without prior information and without barriers.
    criterion: f64,
}

/// Runs start number `start` down to [`SELECTION_WEIGHT`]: from a random motion, or from the best motion with some joints
/// redrawn.
fn candidate_start(
    search: &SharedSearch,
    seed: u64,
    start: usize,
    best: Option<&[f64]>,
) -> Result<CandidateStart, NoMotion> {
    let (mut random, seen) = (Random::stream(seed, start as u64), Seen::default());
    let near = best.and_then(|best| near(search.prepared, search.problem, best, &mut random, &seen));
    let (x, heights) = match near {
        Some(x) => (x, &BARRIER_WEIGHTS[1..]),
        None => (first(search.prepared, search.problem, &mut random, &seen)?, &BARRIER_WEIGHTS[..]),
    };
    search.begun(start, x, seen, heights)
}

impl SharedSearch<'_> {
    /// Descends inside all barriers from the motion with the scaled coefficients `x`. `heights`: the barrier weights, of which
    /// those down to [`SELECTION_WEIGHT`] are used.
    fn begun(&self, start: usize, x: Vec<f64>, seen: Seen, heights: &[f64]) -> Result<CandidateStart, NoMotion> {
        let prepared = self.alone.unwrap_or(self.prepared);
        let high = heights.iter().copied().filter(|height| *height >= SELECTION_WEIGHT);
        let mut watched = Watched::default();
        let x = self.descended(high.map(|height| (prepared, height)), x, &seen, &mut watched);
        let criterion = prepared.criterion(&x).ok_or_else(|| too_small(prepared, self.problem, &x))?;
        Ok(CandidateStart { start, x, seen, watched, criterion })
    }

    /// Completes a start with the descents at the remaining barrier weights. If there is prior information, all these descents
    /// run twice: first without the prior information, then with it.
    fn ended(&self, mut begun: CandidateStart) -> Result<StartResult, NoMotion> {
        let low = || BARRIER_WEIGHTS.into_iter().filter(|height| *height < SELECTION_WEIGHT);
        let alone = self.alone.into_iter().flat_map(|alone| low().map(move |height| (alone, height)));
        let last = match self.alone {
            Some(_) => &BARRIER_WEIGHTS[WEIGHT_INDEX_WITH_PRIOR..],
            None => &BARRIER_WEIGHTS[BARRIER_WEIGHTS.len() - low().count()..],
        };
        let all = alone.chain(last.iter().map(|height| (self.prepared, *height)));
        let x = self.descended(all, begun.x, &begun.seen, &mut begun.watched);
        self.found(&CandidateStart { x, ..begun })
    }

    /// Descends from a motion at one barrier weight (`heights`) after the other and gives the last motion.
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
                LAST_BARRIER_WEIGHT => (1, SMALLEST_DESCENT_GAIN.0),
                _ if height <= SELECTION_WEIGHT => (1, SMALLEST_DESCENT_GAIN.1),
                _ if prepared.space.is_some() => {
                    (if height == BARRIER_WEIGHTS[0] { 3 } else { 2 }, SMALLEST_GAIN_AMONG_BODIES)
                }
                _ => (
                    if prepared.moving().len() > MAX_JOINTS_FOR_ALL_ITERATIONS { 2 } else { 1 },
                    SMALLEST_DESCENT_GAIN.1,
                ),
            };
            let mut left = self.iterations.div_ceil(part);
            let mut returning = MAX_RETURN_DESCENTS;
            while left > 0 && Interruption::check().is_ok() {
                let watching = watched.renewed(prepared, &x);
                let (is_pressed, relief) = (watched.is_pressed(), watched.relief());
                // A low barrier weight hardly moves a motion, so a torque far above its bound is brought back at a higher weight.
                let height = if relief > LARGE_RELIEF { height.max(RETURN_HEIGHT) } else { height };
                let barriers = WithBarriers::new(watching.as_ref().unwrap_or(prepared), height, seen);
                let portion = match (is_pressed, relief > 1.0) {
                    (_, true) => left.min(ITERATIONS_PER_PEAK_SEARCH_BEYOND),
                    (true, false) => left.min(ITERATIONS_PER_PEAK_SEARCH),
                    (false, false) => left,
                };
                let Some(found) = descend(&barriers, &x, portion, least) else { break };
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

    /// The result of a start whose motion is x. The criterion J in the result does not contain the barriers.
    fn found(&self, CandidateStart { start, x, seen, .. }: &CandidateStart) -> Result<StartResult, NoMotion> {
        let prepared = self.prepared;
        let criterion = prepared.criterion(x).ok_or_else(|| too_small(prepared, self.problem, x))?;
        let (room, joint, limit) = prepared.barrier().least_room(x).ok_or(NoMotion::AllLocked)?;
        Ok(StartResult {
            start: *start,
            joints: prepared.joints(x),
            criterion,
            room: (room, prepared.moving()[joint], limit),
            torque: prepared.greatest_torque(x),
            nearest: prepared.nearest(seen, x),
        })
    }
}

/// Draws a random motion about a random centre, scaled to a random share of the kinematic limits; gives its scaled coefficients.
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
        let factor = random.between(DRAWN_LIMIT_SHARES.0, DRAWN_LIMIT_SHARES.1) / most.max(f64::MIN_POSITIVE);
        x[j * m + 1..(j + 1) * m].iter_mut().for_each(|x| *x *= factor);
        let (least, greatest) = barrier.reached(j, &x, LimitKind::Position);
        let (low, high) = limits.position;
        let margin = DRAWN_RANGE_MARGIN * (high - low);
        let room = (low + margin - least, high - margin - greatest);
        let (from, to) = if high - low > TAU { turn_about_zero(room) } else { room };
        let centre = random.between(from, to);
        x[j * m] = centre / (0.5 * (high - low));
    }
    x
}

/// Cuts the range of a centre (rad) to one turn about zero. Other turns give the same torques, but wind up cables.
fn turn_about_zero((low, high): (f64, f64)) -> (f64, f64) {
    let middle = 0.0_f64.max(low).min(high);
    (low.max(middle - PI), high.min(middle + PI))
}

/// The best motion with some joints replaced by randomly drawn ones. The swing (deviation from the centre) of these joints is
/// reduced until torques and distances are within their limits. `None` if no tried swing is small enough.
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

/// Scales the swing (deviation from the centre) of one joint down by [`SHRINK_FACTOR`]; its centre stays.
fn shrink(joint: &mut [f64]) {
    joint[1..].iter_mut().for_each(|x| *x *= SHRINK_FACTOR);
}

/// Draws random coefficients of a coordinate's motion, without the centre, from a random spectrum of the velocity.
fn draw_spectrum(shape: &MotionShape, random: &mut Random, x: &mut [f64]) {
    for l in 0..x.len() / 2 {
        // The square of a uniform random number gives some harmonics a very small amplitude.
        let weight = random.uniform().powi(2);
        match shape {
            MotionShape::Fourier(_) => x[2 * l..2 * l + 2].fill_with(|| weight * random.normal()),
            MotionShape::Spline(spline) => {
                // Half-waves vanish at both ends of the spline. The amplitude of the position is the amplitude of the velocity
                // divided by the number of half-waves.
                let (half_waves, amplitude) = ((l + 1) as f64, weight * random.normal());
                let turn = PI * half_waves / spline.spans as f64;
                let wave = |i: usize| amplitude / half_waves * libm::sin(turn * (i + 1) as f64);
                x.iter_mut().enumerate().for_each(|(i, x)| *x += wave(i));
            }
        }
    }
}

/// A random motion within all limits, about a random centre. If no tried centre is free of collisions, descents find the centre:
/// from the zero pose, from the middle of the limits, and from random poses.
fn first(prepared: &Prepared, problem: &Problem, random: &mut Random, seen: &Seen) -> Result<Vec<f64>, NoMotion> {
    let mut tried = NearestAttempt { weakest: (f64::INFINITY, 0, LimitKind::Effort), narrowest: None };
    let (centres, most) = match problem.surroundings {
        Some(_) => (MAX_CENTRES_PER_START, MAX_DRAWS_AMONG_BODIES),
        None => (MAX_DRAWS_PER_START, MAX_DRAWS_PER_START),
    };
    let mut draws = 0;
    // Random centres are tried first, because testing one is cheap.
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
    // A descent to a centre is more expensive, but it finds narrow collision-free regions.
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

/// Whether one of two random starts finds an initial motion within the limits. It is much faster than a search.
pub fn can_begin(problem: &Problem, seed: u64) -> bool {
    let prepared = Prepared::new(problem);
    let has_motion = |start| first(&prepared, problem, &mut Random::stream(seed, start), &Seen::default()).is_ok();
    prepared.moving().is_empty() || (0..2).any(has_motion)
}

/// The violated limits that came nearest to their bounds over all tried motions of a start: one of the torques (`weakest`) and
/// one of the distances (`narrowest`).
struct NearestAttempt {
    weakest: (f64, usize, LimitKind),
    narrowest: Option<(f64, usize)>,
}

impl NearestAttempt {
    /// Whether the distances of bodies are large enough for a start. `nearest`: the nearest pair of bodies of a pose or motion.
    /// If bodies collide at the centre, even the smallest motion collides.
    fn is_free(&mut self, prepared: &Prepared, nearest: Option<(f64, usize)>) -> bool {
        let is_free = prepared.is_inside(nearest);
        if let Some(near) = nearest.filter(|n| !is_free && self.narrowest.is_none_or(|best| n.0 > best.0)) {
            self.narrowest = Some(near);
        }
        is_free
    }

    /// Scales the motion down until it keeps the limits of torques and distances. `None` if `shrinks` steps do not suffice. The
    /// reason is then a gravity torque, which a smaller motion does not reduce.
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

/// Moves a motion (scaled coefficients x) to the pose `centre`. Reduces the swing (deviation from the centre) of each joint to
/// the position range that remains there.
fn put_about(prepared: &Prepared, problem: &Problem, x: &mut [f64], centre: &[f64]) {
    let m = problem.shape.size();
    for (j, &k) in prepared.moving().iter().enumerate() {
        let (low, high) = problem.limits[k].position;
        x[j * m] = centre[k] / (0.5 * (high - low));
        let (least, greatest) = prepared.barrier().reached(j, x, LimitKind::Position);
        let up = (high - centre[k]) / (greatest - centre[k]).max(f64::MIN_POSITIVE);
        let down = (centre[k] - low) / (centre[k] - least).max(f64::MIN_POSITIVE);
        let factor = (SWING_RANGE_SHARE * up.min(down)).min(1.0);
        x[j * m + 1..(j + 1) * m].iter_mut().for_each(|x| *x *= factor);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::excitation::criterion::SearchObjective;
    use crate::excitation::fourier_series::FourierSeries;
    use crate::excitation::limits::CoordinateLimits;
    use crate::excitation::proof::NominalFriction;
    use crate::excitation::quintic_spline::QuinticSpline;
    use crate::excitation::torque_barrier::TorqueBarrier;
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

    /// Kinematic limits of one coordinate, without limits of effort and power.
    pub(crate) fn limits(position: (f64, f64), [velocity, acceleration, jerk]: [f64; 3]) -> CoordinateLimits {
        let (effort, power, locked) = (None, None, None);
        CoordinateLimits { position, velocity, acceleration, jerk, effort, power, locked }
    }

    pub(crate) fn pendulum_limits() -> CoordinateLimits {
        CoordinateLimits { effort: Some(12.0), ..limits((-1.5, 2.0), [2.0, 8.0, 150.0]) }
    }

    pub(crate) fn pendulum_torque() -> TorqueBarrier {
        let friction = vec![NominalFriction { viscous: 0.1, coulomb: 0.2, offset: 0.05 }];
        TorqueBarrier { parameters: vec![0.3, 0.8, -0.1], friction, share: 0.9 }
    }

    /// A search problem of a pendulum with kinematic limits and a torque limit.
    pub(crate) fn problem<'a>(
        arm: &'a Pendulum,
        limits: &'a [CoordinateLimits],
        wall: &'a TorqueBarrier,
    ) -> Problem<'a> {
        Problem {
            regressor: arm,
            friction: &[FrictionTerm::Viscous],
            limits,
            noise: &[0.1],
            aim: SearchObjective::Determinant,
            torque: Some(wall),
            columns: &[true; 4],
            shape: MotionShape::Fourier(FourierSeries { period: 5.0, blend: 1.0, harmonics: 3 }),
            samples: 60,
            surroundings: None,
            prior: &[],
        }
    }

    #[test]
    fn the_same_motion_on_any_number_of_threads() {
        let (arm, limits, wall) = (Pendulum::new(), [pendulum_limits()], pendulum_torque());
        let series = problem(&arm, &limits, &wall);
        let shape = MotionShape::Spline(QuinticSpline { period: 5.0, spans: 9 });
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
            // The criterion J after the descent is far better than J of a random motion.
            let prepared = Prepared::new(&problem);
            let random = first(&prepared, &problem, &mut Random::new(1), &Seen::default()).unwrap();
            assert!(one[0].criterion < prepared.criterion(&random).unwrap() - 0.5);
        }
    }

    #[test]
    fn what_cannot_move_says_why() {
        let (arm, mut limits, mut wall) = (Pendulum::new(), [pendulum_limits()], pendulum_torque());
        let options = SearchOptions { starts: 1, iterations: 5, seed: 1, threads: 1 };
        // Coulomb friction alone takes 0.2 N m, but a share of 0.01 of the limit of 12 N m is 0.12. (With friction of 0.04 N m
        // there is a motion near the end of the range, where the gravity torque is zero.)
        wall.share = 0.01;
        let why = search(&problem(&arm, &limits, &wall), &options, &|_, _| ()).unwrap_err();
        let NoMotion::TooWeak { coordinate: 0, limit: LimitKind::Effort, share } = why else { panic!("{why:?}") };
        assert!(share > 1.0, "{share}");
        limits[0].locked = Some(0.0);
        let why = search(&problem(&arm, &limits, &wall), &options, &|_, _| ()).unwrap_err();
        assert_eq!(why, NoMotion::AllLocked);
    }
}
