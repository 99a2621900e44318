//! The bodies of a model among floors, walls and each other, as the search and the proof of a motion see them.

use claims::{LeftOut, Matter};
use clearance::body_errors::BodyErrors;
use clearance::clearance::Clearance;
use clearance::gaps::{FloorRule, Rules, Situation};
use clearance::half_space::HalfSpace;
use clearance::nearby::Remembered;
use experiments::excitation::course::Course;
use experiments::excitation::error_margins::ErrorMargins;
use experiments::excitation::gap_proof::{Gap, Known, Room, Surroundings};
use experiments::excitation::ledger::LowestPoint;
use experiments::excitation::limits::{AskedLimits, CoordinateLimits, LimitKind};
use experiments::excitation::motion::Motion;
use experiments::excitation::space_limits::{Floor, SpaceLimits};
use numerics::interruption::Interruption;
use random::Random;

use crate::describe::model::Model;
use crate::error::Error;
use crate::output::directory_of;

/// The gaps of a model's bodies.
pub(crate) struct RobotSurroundings {
    clearance: Clearance,
    /// In a fixed order.
    pub(crate) gaps: Vec<Gap>,
    /// What the gaps do not cover.
    pub(crate) left_out: Vec<LeftOut>,
}

/// Poses by which it is told which links always touch.
const SAMPLED_POSES: u64 = 1000;
/// Their seed. They depend on the description alone, so that no file chooses which pairs are looked at.
const POSES_SEED: u64 = 39;
/// Where a coordinate without limits is sampled: half a turn to either side, rad, or m where it slides.
const UNLIMITED: (f64, f64) = (std::f64::consts::PI, 0.25);
/// Instants of a motion at which the lowest point is looked for.
const LOWEST_INSTANTS: u32 = 2000;

impl RobotSurroundings {
    /// The gaps that `user` asks of the model; what the file of a motion asks for, `own`, may make them tighter. `limits`:
    /// one per coordinate, narrowed by `margins`.
    ///
    /// Fails where `user` names a link that is not there, has a wall without direction, or asks for what the robot
    /// cannot reach, and where nothing bounds how far margins of joints move a body.
    pub(crate) fn new(
        model: &Model,
        user: &SpaceLimits,
        own: Option<&SpaceLimits>,
        limits: &[CoordinateLimits],
        margins: &ErrorMargins,
    ) -> Result<RobotSurroundings, Error> {
        RobotSurroundings::on_floor(model, user, (own, false), limits, margins)
    }

    /// The same; and whether the plane of the base is a floor of a robot that stands on it, where nobody says.
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
        let rules = Rules { errors, assumes_floor, ..rules(user, own).map_err(refused)? };
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

    /// What is to be said of meshes that are cut, where any is.
    pub(crate) fn note(&self) -> Option<String> {
        let of = |(link, shapes): &(String, usize)| format!("{link} into {shapes}");
        let all: Vec<String> = self.clearance.cut_bodies().iter().map(of).collect();
        (!all.is_empty()).then(|| {
            format!(
                "meshes are cut into convex pieces, since their hulls leave other links little room: {}",
                all.join(", ")
            )
        })
    }

    /// How much larger a body may be than the hull of its mesh, m, and whose it is.
    pub(crate) fn mesh_error(&self) -> Option<(f64, String)> {
        self.clearance.mesh_error().map(|(error, link)| (error, link.to_string()))
    }

    /// Height of the floor, m.
    pub(crate) fn floor(&self) -> Option<f64> {
        self.clearance.floor()
    }

    /// The lowest point of the links that move along a motion, as far as instants show.
    pub(crate) fn lowest(&self, motion: &Motion) -> Option<LowestPoint> {
        let at = |k: u32| {
            let time_s = motion.duration() * f64::from(k) / f64::from(LOWEST_INSTANTS);
            let q: Vec<f64> = motion.at(time_s).iter().map(|x| x[0]).collect();
            let (z_m, link) = self.clearance.lowest(&q)?;
            Some(LowestPoint { z_m, link: link.to_string(), time_s })
        };
        (0..=LOWEST_INSTANTS).filter_map(at).min_by(|a, b| a.z_m.total_cmp(&b.z_m))
    }

    /// The same along a course, at instants of every stretch.
    pub(crate) fn lowest_of(&self, course: &dyn Course) -> Option<LowestPoint> {
        let stretches = course.stretches();
        let instants = (LOWEST_INSTANTS as usize).div_ceil(stretches.len().max(1)).max(1);
        let at = |i: usize, k: usize| {
            let t = stretches[i].length * k as f64 / instants as f64;
            let (z_m, link) = self.clearance.lowest(&course.positions(i, t))?;
            Some(LowestPoint { z_m, link: link.to_string(), time_s: stretches[i].start + t })
        };
        let all = (0..stretches.len()).flat_map(|i| (0..=instants).map(move |k| (i, k)));
        all.filter_map(|(i, k)| at(i, k)).min_by(|a, b| a.z_m.total_cmp(&b.z_m))
    }

    /// The coordinates that change a gap.
    pub(crate) fn moved_by(&self, gap: usize) -> Vec<usize> {
        self.clearance.moved_by(gap)
    }

    /// The surroundings; `None` where there are no gaps.
    pub(crate) fn some(&self) -> Option<&dyn Surroundings> {
        (!self.gaps.is_empty()).then_some(self as &dyn Surroundings)
    }
}

impl Surroundings for RobotSurroundings {
    fn gaps(&self) -> &[Gap] {
        &self.gaps
    }

    fn rooms(&self, q: &[f64], spread: &[f64], which: &[usize]) -> Vec<Room> {
        let rooms = self.clearance.rooms(q, spread, which);
        rooms.into_iter().map(|room| Room { reached: room.reached, at_least: room.at_least }).collect()
    }

    fn near(&self, q: &[f64], within: f64, known: &mut Known, each: &mut dyn FnMut(usize, f64, &[f64])) {
        if let Some(known) = known.get_or_insert_with(|| Box::new(Remembered::default())).downcast_mut() {
            self.clearance.near(q, within, known, each);
        }
    }
}

/// Rest, zero, and poses all over the limits of the description.
fn situation(model: &Model, limits: &[CoordinateLimits]) -> Situation {
    let place = |k: usize| {
        let size = if model.regressor().is_prismatic(k) { UNLIMITED.1 } else { UNLIMITED.0 };
        let described = AskedLimits::of_description(&model.robot.coordinates[k].limits);
        described.position.filter(|(low, high)| low <= high).unwrap_or((-size, size))
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

/// What margins of joints and bodies mean for the bodies. A joint that slides without end has no place from which its reach
/// is told.
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

/// Whether the user asked for what is left out.
fn is_asked(matter: Matter, user: &SpaceLimits) -> bool {
    match matter {
        Matter::Distance => user.distance.is_some(),
        Matter::Floor => matches!(user.floor, Some(Floor::At(_))),
        Matter::Region => !user.walls.is_empty() || !user.boxes.is_empty(),
        _ => false,
    }
}

fn rules(user: &SpaceLimits, own: Option<&SpaceLimits>) -> Result<Rules, String> {
    let numbered = |what: &str, k: usize, count: usize| {
        if count == 1 { format!("the {what}") } else { format!("{what} {}", k + 1) }
    };
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
    let floor = match space.floor {
        Some(Floor::At(height)) => FloorRule::At(height),
        Some(Floor::Word(_)) => FloorRule::Nowhere,
        None => FloorRule::OfBase(own.and_then(|own| own.floor).and_then(Floor::height)),
    };
    Ok(Rules {
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
