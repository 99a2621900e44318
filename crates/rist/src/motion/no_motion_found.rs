//! Explains why a search found no motion: which requirements random poses violate, and which changes of the request would help.
//!
//! A remedy is a changed request, for example with a smaller distance between bodies or with a locked joint; it is printed only
//! if a short search with it finds a proven motion. A gap is a pair of bodies, or a body and a floor or wall, with a least
//! allowed distance.

use clearance::shown_length::shown_length;
use experiments::excitation::centre::{Obstacle, ViolatedLimit, broken_at_poses};
use experiments::excitation::error_margins::ErrorMargins;
use experiments::excitation::gap_proof::Gap;
use experiments::excitation::limits::{AskedLimits, CoordinateLimits, LimitKind, LimitsFile};
use experiments::excitation::no_motion::NoMotion;
use experiments::excitation::problem::Problem;
use experiments::excitation::space_limits::SpaceLimits;
use numerics::interruption::Interruption;
use random::Random;

use crate::describe::adapters::surroundings::RobotSurroundings;
use crate::describe::model::Model;
use crate::error::Error;
use crate::request::ExciteRequest;

/// Number of random poses that are tested for violated requirements.
const TESTED_POSES: usize = 300;
/// Number of violations that the message lists, the most frequent first.
const NAMED_VIOLATIONS: usize = 5;
/// A remedy allows a pair of links to touch only if the pair is too close in at least this share of the poses.
const ACCEPTED_PAIR_SHARE: f64 = 0.95;
/// Largest number of coordinates that a remedy may lock.
const MOST_LOCKED: usize = 2;
/// Number of starts of the search that tests a remedy. This search needs any proven motion, not the best motion.
const TRIAL_STARTS: usize = 2;
/// Iterations of the search that tests a remedy.
const TRIAL_ITERATIONS: usize = 10;

/// Seed of the random poses among which a pose that separates a pair of links is searched.
const POSES_SEED: u64 = 41;

/// The reason why no motion was found, and possible remedies.
pub(crate) struct Refusal {
    message: String,
    /// Changed requests that may help. The message prints only their differences from the original request.
    candidates: Vec<ExciteRequest>,
}

/// The inputs of the search that found no motion.
pub(crate) struct SearchedSpace<'a> {
    pub model: &'a Model,
    pub request: &'a ExciteRequest,
    pub names: &'a [String],
    pub limits: &'a [CoordinateLimits],
    pub surroundings: &'a RobotSurroundings,
}

impl SearchedSpace<'_> {
    /// The reason why no motion was found, with remedies.
    pub(crate) fn refused(&self, why: NoMotion, problem: &Problem) -> Refusal {
        let (path, names) = (self.model.path.display(), self.names);
        let message = match why {
            NoMotion::AllLocked => format!("{path}: every coordinate is locked: unlock one in the limits file"),
            NoMotion::NothingToTell => format!(
                "{path}: no motion of the coordinates that are not locked identifies any parameter: unlock more of them"
            ),
            NoMotion::TooSmall { coordinate, limit, swing, speed } => {
                let slides = self.model.regressor().is_prismatic(coordinate);
                let unit = |kind: LimitKind| kind.unit(slides);
                format!(
                    "{path}: no motion found separates the parameters: {}, the slowest, swings by {swing:.1e} {} with {speed:.1e} \
                     {} at most; nearest is its limit of {limit}: raise it, choose another [period], or lock the coordinate",
                    names[coordinate],
                    unit(LimitKind::Position),
                    unit(LimitKind::Velocity)
                )
            }
            NoMotion::TooWeak { coordinate, limit, share } if problem.surroundings.is_none() => format!(
                "{path}: no motion keeps the {limit} limit of {}: even a tiny one takes {:.0} % of what is allowed; within the limits of position no pose is light enough, the {limit} limit or [effort_share] is too small, \
                 or the inertial parameters are too great",
                names[coordinate],
                100.0 * share
            ),
            NoMotion::TooWeak { .. } | NoMotion::TooNarrow { .. } => return self.no_free_pose(problem),
        };
        // Remedies: the default share of the effort limits, or locking the slowest coordinate.
        let candidates = match why {
            NoMotion::TooWeak { .. } => self.with_more_effort(),
            NoMotion::TooSmall { coordinate, .. } => vec![self.locking(coordinate)],
            _ => vec![],
        };
        Refusal { message, candidates }
    }

    /// The request with coordinate `k` locked in the middle of its range.
    fn locking(&self, k: usize) -> ExciteRequest {
        let mut limits = self.request.limits.clone().unwrap_or_default();
        let (low, high) = self.limits[k].position;
        let own = limits.coordinates.entry(self.names[k].clone()).or_default();
        *own = AskedLimits { locked: Some((0.5e3 * (low + high)).round() / 1e3), ..AskedLimits::default() };
        ExciteRequest { limits: Some(limits), ..self.request.clone() }
    }

    /// The request with the default share of the effort limits; empty if the request already has this share or a larger share.
    fn with_more_effort(&self) -> Vec<ExciteRequest> {
        let usual = ExciteRequest::default().effort_share;
        let request = ExciteRequest { effort_share: usual, ..self.request.clone() };
        if self.request.effort_share < usual { vec![request] } else { vec![] }
    }

    /// The refusal if all random poses violate a requirement. It lists the most frequent violations, with remedies.
    fn no_free_pose(&self, problem: &Problem) -> Refusal {
        // Violations are sorted by frequency, the most frequent first.
        let (free, broken) = broken_at_poses(problem, TESTED_POSES);
        let gaps = &self.surroundings.gaps;
        let sentence = |broken: &ViolatedLimit| match broken.what {
            Obstacle::Gap(gap) => format!("{} in {}", gaps[gap].in_words(), broken.poses),
            Obstacle::Effort(k) => format!("effort of {} at rest in {}", self.names[k], broken.poses),
        };
        let all: Vec<String> = broken.iter().take(NAMED_VIOLATIONS).map(sentence).collect();
        let errors = match self.request.limits.as_ref().is_some_and(|limits| limits.margins != ErrorMargins::default())
        {
            true => " with room for the errors of margins",
            false => "",
        };
        let more = match broken.len().saturating_sub(NAMED_VIOLATIONS) {
            0 => String::new(),
            more => format!("; {more} more in fewer"),
        };
        let message = format!(
            "{}: no motion was found: of {TESTED_POSES} poses within the limits {free} keep all of them{errors}; broken are {}{more}; descents \
             from the zero pose, the middle of the limits and random poses led to none about which a small motion does: either the limits of position leave no place that is free, or the limit is too tight, \
             or the search is not enough",
            self.model.path.display(),
            all.join(", ")
        );
        // Remedies: other limits in space; the default share of effort, if effort limits are violated.
        let of_limits = |limits: LimitsFile| ExciteRequest { limits: Some(limits), ..self.request.clone() };
        let mut candidates: Vec<ExciteRequest> = self.candidates(&broken).into_iter().map(of_limits).collect();
        if broken.iter().any(|broken| matches!(broken.what, Obstacle::Effort(_))) {
            candidates.extend(self.with_more_effort());
        }
        Refusal { message, candidates }
    }

    /// Changed limits that may help: limits without the required distance; limits with joints locked in a pose that separates
    /// the worst pair; limits that allow pairs to touch that are too close in nearly all poses.
    fn candidates(&self, broken: &[ViolatedLimit]) -> Vec<LimitsFile> {
        let asked = self.request.limits.clone().unwrap_or_default();
        let mut found = Vec::new();
        if let Some(space) = asked.space.clone().filter(|space| space.distance.is_some()) {
            let space = SpaceLimits { distance: None, ..space };
            found.push(LimitsFile { space: Some(space), ..asked.clone() });
        }
        let pairs = broken.iter().filter_map(|broken| match broken.what {
            Obstacle::Gap(gap) if self.surroundings.gaps[gap].limit == LimitKind::Distance => Some((gap, broken.poses)),
            _ => None,
        });
        let pairs: Vec<(usize, usize)> = pairs.collect();
        let Some(&(worst, _)) = pairs.first() else { return found };
        found.extend(self.holding(worst, &asked));
        let hardly = pairs.iter().filter(|(_, poses)| *poses as f64 >= ACCEPTED_PAIR_SHARE * TESTED_POSES as f64);
        let hardly: Vec<&Gap> = hardly.map(|(gap, _)| &self.surroundings.gaps[*gap]).collect();
        let accepted = if hardly.is_empty() { vec![&self.surroundings.gaps[worst]] } else { hardly };
        let mut space = asked.space.clone().unwrap_or_default();
        for (a, b) in accepted.iter().filter_map(|gap| gap.subject.split_once(" and ")) {
            space.accept.push(vec![a.into(), b.into(), "REASON".into()]);
        }
        found.push(LimitsFile { space: Some(space), ..asked });
        found
    }

    /// The joints that change the gap `gap` are locked in the random pose with the largest distance. Returns the limits with
    /// these joints locked; `None` if more than `MOST_LOCKED` joints change the gap.
    fn holding(&self, gap: usize, asked: &LimitsFile) -> Option<LimitsFile> {
        let moved_by = self.surroundings.moved_by(gap);
        let free = |k: &usize| self.limits[*k].locked.is_none();
        let moved_by: Vec<usize> = moved_by.into_iter().filter(free).collect();
        if moved_by.is_empty() || moved_by.len() > MOST_LOCKED || moved_by.len() == self.names.len() {
            return None;
        }
        let pose = |index: u64| {
            let mut random = Random::stream(POSES_SEED, index);
            let place = |l: &CoordinateLimits| l.locked.unwrap_or_else(|| random.between(l.position.0, l.position.1));
            self.limits.iter().map(place).collect::<Vec<f64>>()
        };
        let room = |q: &Vec<f64>| {
            let surroundings = self.surroundings.some()?;
            surroundings.rooms(q, &vec![0.0; q.len()], &[gap]).first().map(|room| room.reached)
        };
        let poses = (0..TESTED_POSES as u64).map(pose);
        let best = poses.max_by(|a, b| room(a).unwrap_or(0.0).total_cmp(&room(b).unwrap_or(0.0)))?;
        let mut file = asked.clone();
        for k in moved_by {
            let shown = (1e3 * best[k]).round() / 1e3;
            let own = file.coordinates.entry(self.names[k].clone()).or_default();
            *own = AskedLimits { locked: Some(shown), ..own.clone() };
        }
        Some(file)
    }
}

impl Refusal {
    /// The refusal as an error, with the first remedy that gives a proven motion. `proves`: searches with a request and returns
    /// whether a motion is proven.
    pub(crate) fn with_remedies(self, request: &ExciteRequest, proves: impl Fn(&ExciteRequest) -> bool) -> Error {
        let helps = |candidate: &&ExciteRequest| {
            let candidate =
                ExciteRequest { starts: TRIAL_STARTS, iterations: TRIAL_ITERATIONS, ..(*candidate).clone() };
            proves(&candidate) && Interruption::check().is_ok()
        };
        let remedy = self.candidates.iter().find(helps).map(|candidate| words(candidate, request));
        if Interruption::check().is_err() {
            return Error::new("interrupted before there was a motion");
        }
        match remedy {
            Some(remedy) => Error::new(format_args!("{}; tried, and a motion is proven: {remedy}", self.message)),
            None => Error::new(self.message),
        }
    }
}

/// The difference between the request `candidate` and the original `request`, in words.
fn words(candidate: &ExciteRequest, request: &ExciteRequest) -> String {
    if candidate.effort_share != request.effort_share {
        return format!("[effort_share={}]", candidate.effort_share);
    }
    let [limits, asked] = [candidate, request].map(|one| one.limits.clone().unwrap_or_default());
    let (limits, asked) = (&limits, &asked);
    let distance = |limits: &LimitsFile| limits.space.as_ref().and_then(|space| space.distance);
    if let Some(distance) = distance(asked).filter(|_| distance(limits).is_none()) {
        return format!("space without `distance: {}`", shown_length(distance));
    }
    let locked = limits.coordinates.iter().filter_map(|(name, own)| Some((name, own.locked?)));
    let locked: Vec<String> = locked
        .filter(|(name, _)| asked.coordinates.get(*name).is_none_or(|own| own.locked.is_none()))
        .map(|(name, place)| format!("{name}: {{locked: {place}}}"))
        .collect();
    if !locked.is_empty() {
        return format!("coordinates: {{{}}} in [limits=FILE]", locked.join(", "));
    }
    let before = asked.space.as_ref().map_or(0, |space| space.accept.len());
    let accepted = limits.space.iter().flat_map(|space| &space.accept[before..]);
    let accepted: Vec<String> = accepted.map(|pair| format!("[{}]", pair.join(", "))).collect();
    format!("for links that may meet, sign the pair: space: {{accept: [{}]}} in [limits=FILE]", accepted.join(", "))
}
