//! Mass properties of shapes at unit density: volume, and inertia about the centre of mass.
//!
//! Sizes are half lengths and radii, as in MJCF. With a density rho, mass and inertia are rho times these values. A capsule of
//! radius r is a cylinder (volume V_c) of half length h with a half ball at each end (together V_b):
//!
//! ```text
//! I_zz = V_c r^2/2 + 2/5 V_b r^2
//! I_xx = V_c (3 r^2 + 4 h^2)/12 + 2/5 V_b r^2 + V_b h (3 r + 4 h)/4
//! ```

use std::f64::consts::PI;

use crate::inertial::{Part, Pose};
use crate::vector::{Matrix3, Vector3, cross, dot, minus, norm, plus};

/// A body of unit density in its own frame: volume, centre of mass, and xx xy xz yy yz zz about the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Volume {
    pub volume: f64,
    pub centre: Vector3,
    pub inertia: [f64; 6],
}

impl Volume {
    fn of(volume: f64, [xx, yy, zz]: Vector3) -> Volume {
        Volume { volume, centre: [0.0; 3], inertia: [xx, 0.0, 0.0, yy, 0.0, zz] }
    }

    pub(super) fn sphere(r: f64) -> Volume {
        Volume::ellipsoid([r, r, r])
    }

    pub(super) fn ellipsoid([a, b, c]: Vector3) -> Volume {
        let volume = 4.0 / 3.0 * PI * a * b * c;
        Volume::of(volume, [b * b + c * c, a * a + c * c, a * a + b * b].map(|x| volume * x / 5.0))
    }

    pub(super) fn cuboid([a, b, c]: Vector3) -> Volume {
        let volume = 8.0 * a * b * c;
        Volume::of(volume, [b * b + c * c, a * a + c * c, a * a + b * b].map(|x| volume * x / 3.0))
    }

    pub(super) fn cylinder(r: f64, h: f64) -> Volume {
        let volume = 2.0 * PI * r * r * h;
        let across = volume * (3.0 * r * r + 4.0 * h * h) / 12.0;
        Volume::of(volume, [across, across, volume * r * r / 2.0])
    }

    pub(super) fn capsule(r: f64, h: f64) -> Volume {
        let (cylinder, balls) = (Volume::cylinder(r, h), Volume::sphere(r));
        let across = cylinder.inertia[0] + balls.inertia[0] + balls.volume * h * (3.0 * r + 4.0 * h) / 4.0;
        let along = cylinder.inertia[5] + balls.inertia[5];
        Volume::of(cylinder.volume + balls.volume, [across, across, along])
    }

    /// The inertial of this body with a density, kg/m^3. `pose`: pose of the body's frame in the frame of the link.
    pub(super) fn part(&self, pose: &Pose, density: f64) -> Part {
        let own = Pose { position: self.centre, ..Pose::IDENTITY };
        Part {
            name: String::new(),
            pose: pose.compose(&own),
            mass: density * self.volume,
            inertia: self.inertia.map(|x| density * x),
        }
    }
}

/// The method by which the volume inside a surface is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Enclosure {
    /// Sum over tetrahedra with signed volumes: correct for any closed surface whose faces are oriented outward.
    Exact,
    /// Sum over tetrahedra with absolute volumes: MuJoCo's default. The volume is too large if the mesh is not convex.
    Legacy,
    /// The mass is on the faces themselves; the inside is empty.
    Shell,
}

/// Volume, centre of mass and inertia of the solid inside triangles. For a shell, the area replaces the volume.
///
/// ```text
/// V = sum V_t,  V_t = det(a, b, c)/6     c V = sum V_t (a + b + c)/4
/// sum x_i x_j = sum V_t/20 ((a+b+c)(a+b+c)' + aa' + bb' + cc')
/// ```
/// V_t: volume of the tetrahedron between a triangle and a reference point; a, b, c: corners of the triangle relative to this
/// point. To compute the centre, the reference point is the mean of the faces. To compute volume and inertia, the reference
/// point is the centre. MuJoCo uses the same points; with absolute volumes the result depends on the choice of these points.
/// Fails if no volume is enclosed.
pub(super) fn enclosed(triangles: &[[Vector3; 3]], how: Enclosure) -> Result<Volume, String> {
    let inside = face_centre(triangles);
    let (volume, first) = first_moments(triangles, inside, how);
    if volume.is_nan() || volume <= 0.0 {
        return Err("it encloses no volume".into());
    }
    let centre = [0, 1, 2].map(|i| inside[i] + first[i] / volume);
    let (volume, second) = second_moments(triangles, centre, how);
    let trace = second[0][0] + second[1][1] + second[2][2];
    let entry = |i: usize, j: usize| if i == j { trace } else { 0.0 } - second[i][j];
    let inertia = [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)];
    Ok(Volume { volume, centre, inertia })
}

/// The tetrahedron between a triangle and a point: its corners relative to the point, the sum of these corners, and its
/// volume. For a shell, the area of the triangle replaces the volume.
fn tetrahedron(corners: &[Vector3; 3], point: Vector3, how: Enclosure) -> ([Vector3; 3], Vector3, f64) {
    let [a, b, c] = corners.map(|p| minus(p, point));
    let size = match how {
        Enclosure::Exact => dot(a, cross(b, c)) / 6.0,
        Enclosure::Legacy => (dot(a, cross(b, c)) / 6.0).abs(),
        Enclosure::Shell => norm(cross(minus(b, a), minus(c, a))) / 2.0,
    };
    ([a, b, c], plus(a, plus(b, c)), size)
}

/// Volume and first moment of the tetrahedra between triangles and a point; the moment is about this point.
fn first_moments(triangles: &[[Vector3; 3]], point: Vector3, how: Enclosure) -> (f64, Vector3) {
    let parts = if matches!(how, Enclosure::Shell) { 3.0 } else { 4.0 };
    let (mut volume, mut first) = (0.0, [0.0; 3]);
    for corners in triangles {
        let (_, sum, size) = tetrahedron(corners, point, how);
        volume += size;
        first = [0, 1, 2].map(|i| first[i] + size * sum[i] / parts);
    }
    (volume, first)
}

/// Volume and second moment of the tetrahedra between triangles and a point; the moment is about this point.
fn second_moments(triangles: &[[Vector3; 3]], point: Vector3, how: Enclosure) -> (f64, Matrix3) {
    let parts = if matches!(how, Enclosure::Shell) { 12.0 } else { 20.0 };
    let (mut volume, mut upper) = (0.0, [0.0; 6]);
    for corners in triangles {
        let ([a, b, c], sum, size) = tetrahedron(corners, point, how);
        volume += size;
        let entry = |i: usize, j: usize| size * (sum[i] * sum[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]) / parts;
        let own = [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)];
        upper.iter_mut().zip(own).for_each(|(sum, x)| *sum += x);
    }
    let [xx, xy, xz, yy, yz, zz] = upper;
    (volume, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
}

/// The mean of the centres of triangles, weighted by area.
fn face_centre(triangles: &[[Vector3; 3]]) -> Vector3 {
    let (mut sum, mut area) = ([0.0; 3], 0.0);
    for [a, b, c] in triangles {
        let size = norm(cross(minus(*b, *a), minus(*c, *a))) / 2.0;
        area += size;
        for i in 0..3 {
            sum[i] += size * (a[i] + b[i] + c[i]) / 3.0;
        }
    }
    if area > 0.0 { sum.map(|x| x / area) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: &Volume, b: &Volume) {
        let of = |v: &Volume| [&[v.volume][..], &v.centre, &v.inertia].concat();
        for (x, y) in of(a).iter().zip(of(b)) {
            // Allowance for the rounding of about thirty operations.
            assert!((x - y).abs() < 1e-13, "{a:?} {b:?}");
        }
    }

    /// The twelve triangles of a cuboid with half lengths a and centre m.
    fn cuboid(a: Vector3, m: Vector3) -> Vec<[Vector3; 3]> {
        let corner = |k: usize| [0, 1, 2].map(|i| m[i] + if k >> i & 1 == 1 { a[i] } else { -a[i] });
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        faces.iter().flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]].map(|t| t.map(corner))).collect()
    }

    #[test]
    fn a_mesh_of_a_cuboid_is_the_cuboid() {
        let (a, m) = ([0.1, 0.2, 0.3], [0.4, -0.5, 0.6]);
        let wanted = Volume { centre: m, ..Volume::cuboid(a) };
        for how in [Enclosure::Exact, Enclosure::Legacy] {
            close(&enclosed(&cuboid(a, m), how).unwrap(), &wanted);
        }
        let shell = enclosed(&cuboid(a, m), Enclosure::Shell).unwrap();
        assert!((shell.volume - 8.0 * (0.02 + 0.03 + 0.06)).abs() < 1e-15);
        // Expected mean square of x, times the area: two faces are normal to x at a distance of 0.1; on the other four faces x is
        // uniformly distributed between -0.1 and 0.1.
        let xx = 2.0 * 0.24 * 0.01 + (2.0 * 0.12 + 2.0 * 0.08) * 0.01 / 3.0;
        let found = (shell.inertia[3] + shell.inertia[5] - shell.inertia[0]) / 2.0;
        assert!((found - xx).abs() < 1e-15, "{found} {xx}");
        assert!(enclosed(&[], Enclosure::Exact).is_err());
    }

    /// A capsule is compared with a sum over thin slices along z (midpoint rule).
    #[test]
    fn a_capsule_is_the_sum_of_its_slices() {
        let (r, h) = (0.3, 0.7);
        let n = 200_000;
        let (mut volume, mut xx, mut zz) = (0.0, 0.0, 0.0);
        let dz = 2.0 * (r + h) / f64::from(n);
        for k in 0..n {
            let z = -(r + h) + (f64::from(k) + 0.5) * dz;
            let beyond = (z.abs() - h).max(0.0);
            let area = PI * (r * r - beyond * beyond) * dz;
            let square = area / PI / dz;
            volume += area;
            zz += area * square / 2.0;
            xx += area * (square / 4.0 + z * z);
        }
        let capsule = Volume::capsule(r, h);
        for (found, wanted) in [(capsule.volume, volume), (capsule.inertia[0], xx), (capsule.inertia[5], zz)] {
            assert!((found / wanted - 1.0).abs() < 1e-9, "{found} {wanted}");
        }
        assert_eq!(Volume::sphere(0.5), Volume::ellipsoid([0.5; 3]));
        assert!((Volume::capsule(r, 0.0).inertia[0] / Volume::sphere(r).inertia[0] - 1.0).abs() < 1e-15);
    }
}
