//! Gaps of a model. A gap is a pair with a least allowed distance: two bodies of the robot, or a body and a floor or wall. The
//! search and the proof of a motion use gaps.
//!
//! Input: the description with its collision shapes, the limits of the user, and the limits in the motion's own file.
//! Requirements for which no gap can be made are reported (`left_out`).

use claims::{LeftOut, LeftOutTopic};
use clearance::body_errors::BodyErrors;
use clearance::clearance::Clearance;
use clearance::gaps::{ClearanceRules, FloorRule, Situation};
use clearance::half_space::HalfSpace;
use clearance::nearby::InstantCache;
use experiments::excitation::error_margins::ErrorMargins;
use experiments::excitation::gap_proof::{Gap, GapCache, GapSize, Surroundings};
use experiments::excitation::limits::{AskedLimits, CoordinateLimits, LimitKind};
use experiments::excitation::motion::Motion;
use experiments::excitation::motion_claims::LowestPoint;
use experiments::excitation::space_limits::{Floor, SpaceLimits};
use experiments::excitation::trajectory::Trajectory;
use numerics::interruption::Interruption;
use random::Random;

use crate::describe::model::Model;
use crate::error::Error;
use crate::output::directory_of;

/// The gaps of a model. A gap is a pair with a least allowed distance: two bodies of the robot, or a body and a floor or wall.
pub(crate) struct RobotSurroundings {
    clearance: Clearance,
    /// The gaps, in a fixed order.
    pub(crate) gaps: Vec<Gap>,
    /// Requirements on distances, floor and regions for which no gap could be made, each with its reason.
    pub(crate) left_out: Vec<LeftOut>,
}

/// Number of random poses that decide which pairs of links always touch. Such pairs are not checked.
const SAMPLED_POSES: u64 = 1000;
/// Seed of the random poses that decide which pairs of links always touch. The poses depend only on the description, so a
/// motion file cannot change which pairs are checked.
const POSES_SEED: u64 = 39;
/// Positions of a coordinate without limits are drawn from minus this value to plus this value: rad for a revolute joint, m for
/// a prismatic joint.
const UNLIMITED_HALF_RANGE: (f64, f64) = (std::f64::consts::PI, 0.25);
/// Number of instants of a motion at which the lowest point is searched.
const LOWEST_POINT_INSTANTS: u32 = 2000;

impl RobotSurroundings {
    /// Builds the gaps that the user's limits `user` require. `own`: the limits in the motion's own file, which can only be
    /// stricter. `limits`: one per coordinate, already narrowed by `margins`.
    ///
    /// Fails if `user` names a link that does not exist, has a wall without direction, or asks for a distance that the robot
    /// cannot keep. Fails also if nothing bounds how far an error of a joint (`margins`) moves a body.
    pub(crate) fn new(
        model: &Model,
        user: &SpaceLimits,
        own: Option<&SpaceLimits>,
        limits: &[CoordinateLimits],
        margins: &ErrorMargins,
    ) -> Result<RobotSurroundings, Error> {
        RobotSurroundings::on_floor(model, user, (own, false), limits, margins)
    }

    /// Builds the gaps like [`RobotSurroundings::new`]. In addition, if `assumes_floor` is set and no file gives a floor, the
    /// floor is the plane of the base.
    pub(crate) fn on_floor(
        model: &Model,
        user: &SpaceLimits,
        (own, assumes_floor): (Option<&SpaceLimits>, bool),
        limits: &[CoordinateLimits],
        margins: &ErrorMargins,
    ) -> Result<RobotSurroundings, Error> {
        let refused = |what: String| Error::new(format_args!("{}: {what}", model.path.display()));
        if let Some(fault) = user.fault() {
            return Err(refused(fault));
        }
        let errors = body_errors(model, limits, margins).map_err(refused)?;
        let rules = ClearanceRules { errors, assumes_floor, ..rules(user, own).map_err(refused)? };
        let directory = directory_of(&model.path);
        let situation = situation(model, limits);
        let clearance = Clearance::new(&model.robot, directory, &rules, &situation).map_err(refused)?;
        let gap = |gap: &clearance::clearance::Gap| Gap {
            limit: if gap.is_own { LimitKind::Distance } else { LimitKind::Region },
            subject: gap.subject.clone(),
            bound: gap.bound,
            margin: gap.margin,
            reserve: gap.reserve,
            carriers: gap.carriers.clone(),
        };
        let gaps = clearance.gaps().iter().map(gap).collect();
        let asked = |out: &LeftOut| LeftOut { is_asked: is_asked(out.matter, user), ..out.clone() };
        let left_out = clearance.left_out().iter().map(asked).collect();
        Ok(RobotSurroundings { clearance, gaps, left_out })
    }

    /// A note that lists the meshes that are cut into convex pieces; `None` if no mesh is cut.
    pub(crate) fn note(&self) -> Option<String> {
        let of = |(link, shapes): &(String, usize)| format!("{link} into {shapes}");
        let all: Vec<String> = self.clearance.cut_bodies().iter().map(of).collect();
        (!all.is_empty()).then(|| {
            format!(
                "meshes are cut into convex pieces, since their hulls are too close to other links: {}",
                all.join(", ")
            )
        })
    }

    /// Largest distance by which a body exceeds the convex hull of its mesh, m, and the link of this body. `None` without
    /// meshes.
    pub(crate) fn mesh_error(&self) -> Option<(f64, String)> {
        self.clearance.mesh_error().map(|(error, link)| (error, link.to_string()))
    }

    /// Height of the floor, m; `None` if there is no floor.
    pub(crate) fn floor(&self) -> Option<f64> {
        self.clearance.floor()
    }

    /// The lowest point of the moving links along a motion, searched at discrete instants; `None` without such links.
    pub(crate) fn lowest(&self, motion: &Motion) -> Option<LowestPoint> {
        let at = |k: u32| {
            let time_s = motion.duration() * f64::from(k) / f64::from(LOWEST_POINT_INSTANTS);
            let q: Vec<f64> = motion.at(time_s).iter().map(|x| x[0]).collect();
            let (z_m, link) = self.clearance.lowest(&q)?;
            Some(LowestPoint { z_m, link: link.to_string(), time_s })
        };
        (0..=LOWEST_POINT_INSTANTS).filter_map(at).min_by(|a, b| a.z_m.total_cmp(&b.z_m))
    }

    /// The lowest point of the moving links along a trajectory, searched at discrete instants of every segment.
    pub(crate) fn lowest_of(&self, course: &dyn Trajectory) -> Option<LowestPoint> {
        let stretches = course.stretches();
        let instants = (LOWEST_POINT_INSTANTS as usize).div_ceil(stretches.len().max(1)).max(1);
        let at = |i: usize, k: usize| {
            let t = stretches[i].length * k as f64 / instants as f64;
            let (z_m, link) = self.clearance.lowest(&course.positions(i, t))?;
            Some(LowestPoint { z_m, link: link.to_string(), time_s: stretches[i].start + t })
        };
        let all = (0..stretches.len()).flat_map(|i| (0..=instants).map(move |k| (i, k)));
        all.filter_map(|(i, k)| at(i, k)).min_by(|a, b| a.z_m.total_cmp(&b.z_m))
    }

    /// The indices of the coordinates that change the gap with index `gap`.
    pub(crate) fn moved_by(&self, gap: usize) -> Vec<usize> {
        self.clearance.moved_by(gap)
    }

    /// Returns these surroundings for the proof of a motion; `None` if there are no gaps to keep.
    pub(crate) fn some(&self) -> Option<&dyn Surroundings> {
        (!self.gaps.is_empty()).then_some(self as &dyn Surroundings)
    }
}

impl Surroundings for RobotSurroundings {
    fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    fn rooms(&self, q: &[f64], spread: &[f64], which: &[usize]) -> Vec<GapSize> {
        let rooms = self.clearance.rooms(q, spread, which);
        rooms.into_iter().map(|room| GapSize { reached: room.reached, at_least: room.at_least }).collect()
    }

    fn near(&self, q: &[f64], within: f64, known: &mut GapCache, each: &mut dyn FnMut(usize, f64, &[f64])) {
        if let Some(known) = known.get_or_insert_with(|| Box::new(InstantCache::default())).downcast_mut() {
            self.clearance.near(q, within, known, each);
        }
    }
}

/// Poses for two decisions: the height of the default floor, and which pairs of links always touch. They are the rest pose and
/// the zero pose (moved into the limits), and random poses within the limits of the description.
fn situation(model: &Model, limits: &[CoordinateLimits]) -> Situation {
    let place = |k: usize| {
        let half = if model.regressor().is_prismatic(k) { UNLIMITED_HALF_RANGE.1 } else { UNLIMITED_HALF_RANGE.0 };
        let described = AskedLimits::of_description(&model.robot.coordinates[k].limits);
        described.position.filter(|(low, high)| low <= high).unwrap_or((-half, half))
    };
    let places: Vec<(f64, f64)> = (0..limits.len()).map(place).collect();
    let pose = |index: u64| {
        let mut random = Random::stream(POSES_SEED, index);
        places.iter().map(|(low, high)| random.between(*low, *high)).collect()
    };
    let rest = |l: &CoordinateLimits| l.locked.unwrap_or_else(|| 0.0_f64.clamp(l.position.0, l.position.1));
    Situation {
        rest: limits.iter().map(rest).collect(),
        zero: places.iter().map(|(low, high)| 0.0_f64.clamp(*low, *high)).collect(),
        moves: limits.iter().map(|l| l.locked.is_none()).collect(),
        poses: (0..SAMPLED_POSES).map(pose).collect(),
    }
}

/// Largest position error of each body if joints and bodies have the errors in `margins`. Fails if a sliding joint with a
/// margin has no limits of position.
fn body_errors(model: &Model, limits: &[CoordinateLimits], margins: &ErrorMargins) -> Result<BodyErrors, String> {
    let names = model.regressor().coordinates();
    let joints = margins.of_joints(names);
    let farthest: Vec<f64> = limits.iter().map(|l| l.position.0.abs().max(l.position.1.abs())).collect();
    let is_endless = |&k: &usize| model.regressor().is_prismatic(k) && !farthest[k].is_finite();
    if let Some(k) = (0..names.len()).find(is_endless).filter(|_| joints.iter().any(|by| *by > 0.0)) {
        return Err(format!("margins of joints need limits of position of {}, which slides", names[k]));
    }
    let farthest = farthest.into_iter().map(|x| if x.is_finite() { x } else { 0.0 }).collect();
    Ok(BodyErrors { joints, farthest, bodies: margins.of_bodies() })
}

/// Whether the user's limits `user` contain the requirement `matter`. The function is called for requirements that no gap
/// covers.
fn is_asked(matter: LeftOutTopic, user: &SpaceLimits) -> bool {
    match matter {
        LeftOutTopic::Distance => user.distance.is_some(),
        LeftOutTopic::Floor => matches!(user.floor, Some(Floor::At(_))),
        LeftOutTopic::Region => !user.walls.is_empty() || !user.boxes.is_empty(),
        _ => false,
    }
}

fn rules(user: &SpaceLimits, own: Option<&SpaceLimits>) -> Result<ClearanceRules, String> {
    let numbered = |what: &str, k: usize, count: usize| {
        if count == 1 { format!("the {what}") } else { format!("{what} {}", k + 1) }
    };
    // A limit in the motion's file counts only if it is at least as strict as the user's limit.
    let space = own.map_or_else(|| user.clone(), |own| own.held_to(user));
    let mut half_spaces = Vec::new();
    for (k, wall) in space.walls.iter().enumerate() {
        let plane = HalfSpace::beyond(numbered("wall", k, space.walls.len()), wall.point, wall.normal)?;
        half_spaces.push(HalfSpace { links: wall.links.clone(), ..plane });
    }
    for (k, cell) in space.boxes.iter().enumerate() {
        let sides = HalfSpace::sides_of_box(&numbered("box", k, space.boxes.len()), cell.low, cell.high)?;
        half_spaces.extend(sides.into_iter().map(|side| HalfSpace { links: cell.links.clone(), ..side }));
    }
    // The user's floor has priority. Otherwise the floor is the plane of the base, or the height that the motion's file gives.
    let floor = match space.floor {
        Some(Floor::At(height)) => FloorRule::At(height),
        Some(Floor::Word(_)) => FloorRule::Nowhere,
        None => FloorRule::OfBase(own.and_then(|own| own.floor).and_then(Floor::height)),
    };
    Ok(ClearanceRules {
        own_links: space.own_links,
        distance: space.distance,
        accepted: space.accepted(),
        floor,
        half_spaces,
        errors: BodyErrors::default(),
        spacing: space.spacing,
        assumes_floor: false,
        is_over: || Interruption::check().is_err(),
    })
}
