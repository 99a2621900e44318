//! Pairs of bodies with little clearance. Their meshes are cut into convex pieces if this gives them more clearance.
//!
//! One convex hull per mesh is enough for most bodies, and makes a proof fastest. But the hull of a bent link also contains
//! the space inside the bend, through which other bodies may pass.

use std::collections::BTreeSet;
use std::path::Path;

use robot::{Collision, CollisionShape, Pose, Robot};

use crate::bodies::{BodyShape, FileLink, solid};
use crate::clearance::{Against, Clearance, Gap};
use crate::mesh::{mesh_path, triangles};
use crate::pieces::{Triangle, pieces};
use crate::sampled_room::SampledRoom;
use crate::solid::Solid;

/// A pair of bodies with little clearance.
pub(crate) struct Crowded {
    gap: Gap,
    found: SampledRoom,
    /// Threshold, m: a pair with at least this clearance is not crowded (its clearance is not little).
    enough: f64,
}

/// Least ratio of the clearance after a cut to the clearance before the cut. If the ratio is smaller, the cut is undone,
/// because more shapes slow down every proof.
const MIN_ROOM_RATIO: f64 = 1.25;

impl Crowded {
    /// Returns the pair if it is crowded. A pair is crowded if its clearance is below `enough` (m) or if its bodies touch in
    /// nearly every pose although several joints are between them.
    pub(crate) fn of(gap: &Gap, found: SampledRoom, enough: f64) -> Option<Crowded> {
        let is_it = match found {
            SampledRoom::Room(room) => room < enough,
            SampledRoom::AlwaysTouching | SampledRoom::AlwaysNear => gap.joints.iter().flatten().count() > 1,
        };
        is_it.then(|| Crowded { gap: gap.clone(), found, enough })
    }

    fn bodies(&self) -> impl Iterator<Item = usize> {
        let other = match self.gap.against {
            Against::Body(other) => Some(other),
            Against::HalfSpace(_) => None,
        };
        std::iter::once(self.gap.body).chain(other)
    }

    fn is_bettered_by(&self, found: SampledRoom) -> bool {
        match (self.found, found) {
            (SampledRoom::Room(before), SampledRoom::Room(now)) => now > MIN_ROOM_RATIO * before,
            (_, now) => matches!(now, SampledRoom::Room(_)),
        }
    }
}

impl Clearance {
    /// Cuts the meshes of these pairs into convex pieces, and keeps a cut if it gives a pair more clearance. Returns whether any
    /// cut is kept.
    pub(crate) fn cut_meshes_of(
        &mut self,
        robot: &Robot,
        directory: &Path,
        crowded: &[Crowded],
        sampled: &[Vec<Pose>],
    ) -> bool {
        let bodies: BTreeSet<usize> = crowded.iter().flat_map(|pair| pair.bodies()).collect();
        let cut = |b: usize| Some((b, cut_shapes(robot, directory, &self.bodies[b])?));
        let cut: Vec<(usize, Vec<BodyShape>)> = bodies.into_iter().filter_map(cut).collect();
        let whole: Vec<(usize, Vec<BodyShape>)> =
            cut.into_iter().map(|(b, shapes)| (b, std::mem::replace(&mut self.bodies[b].shapes, shapes))).collect();
        let has_more_room = |pair: &&Crowded| {
            let gap = Gap { shapes: (0..self.bodies[pair.gap.body].shapes.len()).collect(), ..pair.gap.clone() };
            pair.is_bettered_by(self.sampled_room(&gap, sampled, pair.enough).0)
        };
        let bettered: BTreeSet<usize> = crowded.iter().filter(has_more_room).flat_map(|pair| pair.bodies()).collect();
        for (b, shapes) in whole {
            match bettered.contains(&b) {
                true => self.cut_bodies.push((self.bodies[b].name.clone(), self.bodies[b].shapes.len())),
                false => self.bodies[b].shapes = shapes,
            }
        }
        !self.cut_bodies.is_empty()
    }
}

/// The convex shapes of a body after its meshes are cut. `None` if no mesh is cut into several pieces, or if its faces cannot be
/// read.
fn cut_shapes(robot: &Robot, directory: &Path, body: &FileLink) -> Option<Vec<BodyShape>> {
    let given = body.link.map_or(&robot.base.collisions, |j| &robot.links[j].collisions);
    let mut shapes = Vec::new();
    for collision in given.iter().filter(|c| c.link == body.name) {
        let solids = cut_mesh(collision, directory).or_else(|| Some(vec![solid(collision, directory).ok()?]))?;
        shapes.extend(solids.into_iter().map(|solid| BodyShape::new(solid, collision.pose)));
    }
    (shapes.len() > body.shapes.len()).then_some(shapes)
}

/// Cuts a mesh into pieces and returns the convex hull of each. `None` if no cut makes the total volume of the hulls much
/// smaller.
fn cut_mesh(collision: &Collision, directory: &Path) -> Option<Vec<Solid>> {
    let CollisionShape::Mesh { file, scale } = &collision.shape else { return None };
    let triangles = triangles(&mesh_path(file, directory).ok()?).ok()?;
    let sized: Vec<Triangle> = triangles.iter().map(|t| t.map(|p| [0, 1, 2].map(|k| scale[k] * p[k]))).collect();
    let pieces = pieces(sized);
    if pieces.len() == 1 {
        return None;
    }
    pieces.iter().map(|piece| Solid::around(piece.as_flattened())).collect()
}

#[cfg(test)]
mod tests {
    use crate::clearance::Clearance;
    use crate::gaps::{ClearanceRules, Situation};
    use crate::pieces::tests::fork;

    #[test]
    fn what_moves_in_a_notch_has_its_room() {
        let folder = std::env::temp_dir().join(format!("rist-fork-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let corners: String = fork().iter().flatten().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        let faces: String =
            (0..fork().len()).map(|k| format!("f {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3)).collect();
        std::fs::write(folder.join("fork.obj"), corners + &faces).unwrap();
        let text = r#"<robot name="fork"><link name="fork"><collision><geometry><mesh filename="fork.obj"/></geometry></collision></link>
  <joint name="q1" type="prismatic"><parent link="fork"/><child link="slide"/><axis xyz="0 1 0"/>
    <limit lower="-0.02" upper="0.02" velocity="1" effort="1"/></joint>
  <link name="slide"><collision><origin xyz="0.25 0.05 0.6"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="q2" type="prismatic"><parent link="slide"/><child link="rod"/><axis xyz="1 0 0"/>
    <limit lower="-0.02" upper="0.02" velocity="1" effort="1"/></joint>
  <link name="rod"><collision><origin xyz="0.25 0.05 0.2"/><geometry><box size="0.1 0.02 0.1"/></geometry></collision></link>
</robot>"#;
        let robot = robot::format::read_urdf(text, "fork.urdf").unwrap();
        let poses =
            (0..100).map(|k| vec![0.02 * (f64::from(k) / 50.0 - 1.0), 0.02 * (f64::from(k % 7) / 3.0 - 1.0)]).collect();
        let situation = Situation { rest: vec![0.0; 2], zero: vec![0.0; 2], moves: vec![true; 2], poses };
        let clearance = Clearance::new(&robot, &folder, &ClearanceRules::default(), &situation).unwrap();
        assert_eq!(clearance.cut_bodies(), [("fork".to_string(), 3)]);
        let pair = clearance.gaps().iter().position(|gap| gap.subject == "rod and fork").unwrap();
        let room = clearance.rooms(&[0.0, 0.01], &[0.0; 2], &[pair])[0];
        // The plate ends at a height of 0.06 m and the rod starts at 0.15 m, so the distance is 0.09 m. The posts are farther
        // away.
        assert!((room.reached - 0.09).abs() < 1e-6, "{room:?}");
        assert!(clearance.left_out().iter().all(|out| !out.of.contains(&"rod and fork".to_string())));
        std::fs::remove_dir_all(&folder).ok();
    }
}
