//! The bodies of a model among floors, walls and each other, as the search and the proof of a motion see them.

use std::path::Path;

use clearance::clearance::Clearance;
use clearance::gaps::{Rules, Situation};
use clearance::half_space::HalfSpace;
use experiments::excitation::gap_proof::{Gap, Room, Surroundings};
use experiments::excitation::limits::{CoordinateLimits, LimitKind};
use experiments::excitation::space_limits::SpaceLimits;

use crate::error::Error;
use crate::model::Model;

/// The gaps of a model's bodies.
pub(crate) struct RobotSurroundings {
    clearance: Clearance,
    gaps: Vec<Gap>,
}

impl RobotSurroundings {
    /// The gaps that `space` asks of the model; `limits`: one a coordinate.
    ///
    /// Fails where `space` names a link that is not there, has a wall without direction, or asks for what the robot
    /// cannot reach.
    pub(crate) fn new(
        model: &Model,
        space: &SpaceLimits,
        limits: &[CoordinateLimits],
    ) -> Result<RobotSurroundings, Error> {
        let refused = |what: String| Error::new(format_args!("{}: {what}", model.path.display()));
        if let Some(fault) = space.fault() {
            return Err(refused(fault));
        }
        let rules = rules(space).map_err(refused)?;
        let rest = |l: &CoordinateLimits| l.locked.unwrap_or_else(|| 0.0_f64.clamp(l.position.0, l.position.1));
        let situation = Situation {
            rest: limits.iter().map(rest).collect(),
            moves: limits.iter().map(|l| l.locked.is_none()).collect(),
        };
        let directory = model.path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let clearance = Clearance::new(&model.robot, directory, &rules, &situation).map_err(refused)?;
        let gap = |gap: &clearance::clearance::Gap| Gap {
            limit: if gap.is_own { LimitKind::Distance } else { LimitKind::Region },
            subject: gap.subject.clone(),
            bound: gap.bound,
        };
        let gaps = clearance.gaps().iter().map(gap).collect();
        Ok(RobotSurroundings { clearance, gaps })
    }

    /// What is not looked at, in sentences.
    pub(crate) fn notes(&self) -> &[String] {
        self.clearance.notes()
    }

    /// The gaps, in a fixed order.
    pub(crate) fn gaps(&self) -> &[Gap] {
        &self.gaps
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

    fn near(&self, q: &[f64], within: f64, each: &mut dyn FnMut(usize, f64, &[f64])) {
        self.clearance.near(q, within, each);
    }
}

fn rules(space: &SpaceLimits) -> Result<Rules, String> {
    let numbered = |what: &str, k: usize, count: usize| {
        if count == 1 { format!("the {what}") } else { format!("{what} {}", k + 1) }
    };
    let mut half_spaces = Vec::new();
    if let Some(height) = space.floor {
        half_spaces.push(HalfSpace::beyond("the floor".into(), [0.0, 0.0, height], [0.0, 0.0, 1.0])?);
    }
    for (k, wall) in space.walls.iter().enumerate() {
        let plane = HalfSpace::beyond(numbered("wall", k, space.walls.len()), wall.point, wall.normal)?;
        half_spaces.push(HalfSpace { links: wall.links.clone(), ..plane });
    }
    for (k, cell) in space.boxes.iter().enumerate() {
        let sides = HalfSpace::sides_of_box(&numbered("box", k, space.boxes.len()), cell.low, cell.high)?;
        half_spaces.extend(sides.into_iter().map(|side| HalfSpace { links: cell.links.clone(), ..side }));
    }
    Ok(Rules {
        distance: space.own_links.then_some(space.distance),
        ignored_pairs: space.ignored_pairs.clone(),
        half_spaces,
    })
}
