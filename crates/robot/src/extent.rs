//! The extent of the shapes of a body (bounding box, volume and second moments), for a comparison with its inertial parameters.

use std::f64::consts::PI;

use crate::collision::{Collision, CollisionShape};
use crate::inertial::Pose;
use crate::principal::principal_axes;
use crate::vector::{Matrix3, Vector3, dot, minus, norm, plus_scaled, transposed};

/// The extent of the shapes of one body, in the frame of the body.
#[derive(Clone, Debug)]
pub(crate) struct Extent {
    /// Lowest corner of the bounding box, m.
    pub low: Vector3,
    /// Highest corner of the bounding box, m.
    pub high: Vector3,
    /// Sum of the volumes of the shapes, m^3; `None` if a shape is a mesh.
    pub volume: Option<f64>,
    /// Sum of the volumes of the shapes, m^3, where a mesh counts with the volume of its bounding box.
    pub outer_volume: f64,
    solids: Vec<Solid>,
}

/// One shape as a solid of constant density.
#[derive(Clone, Debug)]
struct Solid {
    pose: Pose,
    volume: f64,
    /// Mean of x^2, y^2 and z^2 over the solid, in the solid's own frame, m^2.
    second: Vector3,
}

/// A function that reads the vertices of the mesh of a shape (m) in the frame of the shape. It returns `None` if that is not
/// possible.
pub type MeshPoints<'a> = &'a dyn Fn(&Collision) -> Option<Vec<Vector3>>;

impl Extent {
    /// The extent of shapes in the frame of a body; `to_body`: pose of the frame of the link in the frame of the body. `None` if
    /// there is no shape, or if one could not be read.
    pub(crate) fn of(shapes: &[&Collision], to_body: &Pose, meshes: MeshPoints) -> Option<Extent> {
        let mut extent = Extent {
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
            volume: Some(0.0),
            outer_volume: 0.0,
            solids: vec![],
        };
        for shape in shapes {
            let pose = to_body.compose(&shape.pose);
            let (middle, half, second, volume) = primitive(&shape.shape).or_else(|| hull_box(&meshes(shape)?))?;
            if matches!(shape.shape, CollisionShape::Mesh { .. }) {
                extent.volume = None;
            }
            extent.volume = extent.volume.map(|sum| sum + volume);
            let at = |p: Vector3| pose.compose(&Pose { position: p, ..Pose::IDENTITY });
            for k in 0..8 {
                let corner =
                    at([0, 1, 2].map(|i| middle[i] + if k >> i & 1 == 1 { half[i] } else { -half[i] })).position;
                for i in 0..3 {
                    (extent.low[i], extent.high[i]) = (extent.low[i].min(corner[i]), extent.high[i].max(corner[i]));
                }
            }
            extent.solids.push(Solid { pose: at(middle), volume, second });
        }
        extent.outer_volume = extent.solids.iter().map(|s| s.volume).sum();
        (extent.outer_volume > 0.0).then_some(extent)
    }

    /// Length of the diagonal of the bounding box, m.
    pub(crate) fn diagonal(&self) -> f64 {
        norm(minus(self.high, self.low))
    }

    /// Distance of a point from the bounding box, m.
    pub(crate) fn distance(&self, point: Vector3) -> f64 {
        norm([0, 1, 2].map(|i| (self.low[i] - point[i]).max(point[i] - self.high[i]).max(0.0)))
    }

    /// Two matrices of second moments for constant density, divided by the mass, m^2. Both are about the common centre of all
    /// shapes. First: of the shapes themselves; second: of point masses at the centres of the shapes. Entries xx xy xz yy yz
    /// zz.
    pub(crate) fn uniform(&self) -> ([f64; 6], [f64; 6]) {
        let total = self.outer_volume;
        let centre = self.solids.iter().fold([0.0; 3], |sum, s| plus_scaled(sum, s.pose.position, s.volume / total));
        let (mut whole, mut apart) = ([0.0; 6], [0.0; 6]);
        for solid in &self.solids {
            let off = minus(solid.pose.position, centre);
            for (k, (i, j)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
                let rows = [solid.pose.rotation[i], solid.pose.rotation[j]];
                let own = dot([0, 1, 2].map(|n| rows[0][n] * solid.second[n]), rows[1]);
                apart[k] += solid.volume / total * off[i] * off[j];
                whole[k] += solid.volume / total * (own + off[i] * off[j]);
            }
        }
        (whole, apart)
    }
}

/// Centre and half edge lengths of the bounding box of a shape, its second moments and its volume.
type Measures = (Vector3, Vector3, Vector3, f64);

fn primitive(shape: &CollisionShape) -> Option<Measures> {
    let round =
        |r: f64, half: f64, volume| ([0.0; 3], [r, r, half], [r * r / 4.0, r * r / 4.0, half * half / 3.0], volume);
    Some(match *shape {
        CollisionShape::Box { size } => {
            let half = size.map(|x| x / 2.0);
            ([0.0; 3], half, half.map(|x| x * x / 3.0), size.iter().product())
        }
        CollisionShape::Cylinder { radius: r, length } => round(r, length / 2.0, PI * r * r * length),
        // The second moments of a capsule are approximated by the second moments of the cylinder around it. This is accurate
        // enough for a comparison.
        CollisionShape::Capsule { radius: r, length } => {
            round(r, length / 2.0 + r, PI * r * r * (length + 4.0 / 3.0 * r))
        }
        CollisionShape::Sphere { radius: r } => ([0.0; 3], [r; 3], [r * r / 5.0; 3], 4.0 / 3.0 * PI * r * r * r),
        CollisionShape::Mesh { .. } | CollisionShape::Unread { .. } => return None,
    })
}

/// The bounding box of the vertices of a mesh as a solid. Its volume is the smaller of two: the volume of this box, and the
/// volume of a box along the principal axes of the vertices, which is smaller for oblique links.
fn hull_box(points: &[Vector3]) -> Option<Measures> {
    let far = |axis: Vector3, sign: f64| points.iter().map(|p| sign * dot(*p, axis)).fold(f64::NEG_INFINITY, f64::max);
    let across = |axes: &Matrix3| axes.map(|axis| 0.5 * (far(axis, 1.0) + far(axis, -1.0)));
    let straight = Pose::IDENTITY.rotation;
    let half = across(&straight);
    let middle = straight.map(|axis| 0.5 * (far(axis, 1.0) - far(axis, -1.0)));
    let second = |(i, j): (usize, usize)| points.iter().map(|p| (p[i] - middle[i]) * (p[j] - middle[j])).sum::<f64>();
    let axes = principal_axes(&[(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(second)).1;
    let volume = [half, across(&transposed(&axes))].map(|half| 8.0 * half.iter().product::<f64>());
    let volume = volume[0].min(volume[1]);
    (volume.is_finite() && volume > 0.0).then_some((middle, half, half.map(|x| x * x / 3.0), volume))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(shape: CollisionShape, x: f64) -> Collision {
        Collision { link: "l".into(), pose: Pose { position: [x, 0.0, 0.0], ..Pose::IDENTITY }, shape }
    }

    #[test]
    fn two_cubes_apart_are_their_own_moments_and_their_distance() {
        let cubes = [0.0, 0.4].map(|x| shape(CollisionShape::Box { size: [0.06; 3] }, x));
        let extent = Extent::of(&[&cubes[0], &cubes[1]], &Pose::IDENTITY, &|_| None).unwrap();
        let (whole, apart) = extent.uniform();
        for (found, wanted) in [(whole[0], 0.0003 + 0.04), (whole[3], 0.0003), (apart[0], 0.04), (apart[3], 0.0)] {
            assert!((found - wanted).abs() < 1e-15, "{found} {wanted}");
        }
        assert!((extent.volume.unwrap() - 2.0 * 0.06f64.powi(3)).abs() < 1e-18);
    }

    #[test]
    fn a_mesh_has_a_box_and_no_volume_and_an_unread_shape_has_nothing() {
        let mesh = shape(CollisionShape::Mesh { file: "a.stl".into(), scale: [1.0; 3] }, 1.0);
        let points = vec![[0.0, 0.0, 0.0], [0.2, 0.1, 0.3]];
        let extent = Extent::of(&[&mesh], &Pose::IDENTITY, &|_| Some(points.clone())).unwrap();
        assert_eq!((extent.low, extent.volume), ([1.0, 0.0, 0.0], None));
        assert!(Extent::of(&[&mesh], &Pose::IDENTITY, &|_| None).is_none());
        assert!(Extent::of(&[], &Pose::IDENTITY, &|_| None).is_none());
    }
}
