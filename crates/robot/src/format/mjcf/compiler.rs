//! Reads `<compiler>`, which sets the units and the meaning of numbers; converts angles and orientations accordingly.

use std::f64::consts::PI;

use super::defaults::{ORIENTATIONS, View};
use super::element::MjcfElement;
use crate::angle_snap::{self, AngleSnapping};
use crate::error::Error;
use crate::kinematics::sin_cos;
use crate::robot::Note;
use crate::vector::{Matrix3, Vector3, cross, dot, norm, plus_scaled, product, rotation_by, scaled};

/// Whether the inertia of a body is computed from its shapes (`inertiafromgeom`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InertiaFromGeom {
    Never,
    Always,
    /// Only if the body has no `<inertial>`.
    Auto,
}

/// A quaternion has no direction if its squared norm is below this value.
const SMALLEST_QUATERNION_SQUARE: f64 = 1e-20;
/// A vector has no direction if its norm is below this value.
const SMALLEST_DIRECTION_NORM: f64 = 1e-9;
/// Two directions count as parallel if the sine of the angle between them is below this value.
const PARALLEL_SINE: f64 = 1e-10;

/// The settings of all `<compiler>` elements together; a later element replaces the settings of earlier ones.
#[derive(Clone, Debug)]
pub(super) struct Compiler {
    pub angles: AngleSnapping,
    degrees: bool,
    /// Sequence of three Euler axes. x y z: axes of the rotated frame; X Y Z: axes of the parent frame.
    euler: [char; 3],
    pub ranges_are_limits: bool,
    pub inertia_from_geom: InertiaFromGeom,
    /// Lowest and highest group number of the shapes that contribute to the mass.
    pub groups: (f64, f64),
    pub least_mass: f64,
    pub least_inertia: f64,
    pub balances: bool,
    pub total_mass: Option<f64>,
    pub mesh_folder: String,
    pub strips_path: bool,
}

impl Compiler {
    pub(super) fn new(root: &MjcfElement, angles: AngleSnapping) -> Result<Compiler, Error> {
        let mut compiler = Compiler {
            angles,
            degrees: true,
            euler: ['x', 'y', 'z'],
            ranges_are_limits: true,
            inertia_from_geom: InertiaFromGeom::Auto,
            groups: (0.0, 5.0),
            least_mass: 0.0,
            least_inertia: 0.0,
            balances: false,
            total_mass: None,
            mesh_folder: String::new(),
            strips_path: false,
        };
        for element in root.children("compiler") {
            compiler.take(View::bare(element))?;
        }
        Ok(compiler)
    }

    /// Reads one `<compiler>` element. Its values replace the values of earlier elements.
    fn take(&mut self, view: View) -> Result<(), Error> {
        if view.choice("coordinate", &["local", "global"])? == Some(1) {
            let message = "`coordinate=\"global\"` is not read, nor by MuJoCo since 2.3.4: save the model with an older \
                           MuJoCo, which writes local coordinates";
            return Err(view.element.error(message));
        }
        if let Some(which) = view.choice("angle", &["radian", "degree"])? {
            self.degrees = which == 1;
        }
        if let Some(text) = view.get("eulerseq") {
            let letters: Vec<char> = text.trim().chars().collect();
            self.euler = match <[char; 3]>::try_from(letters) {
                Ok(letters) if letters.iter().all(|l| "xyzXYZ".contains(*l)) => letters,
                _ => return Err(view.element.error("`eulerseq` is three of the letters x y z X Y Z")),
            };
        }
        if let Some(which) = view.choice("inertiafromgeom", &["false", "true", "auto"])? {
            self.inertia_from_geom = [InertiaFromGeom::Never, InertiaFromGeom::Always, InertiaFromGeom::Auto][which];
        }
        // A missing attribute keeps the value that an earlier element gave.
        self.ranges_are_limits = view.flag("autolimits")?.unwrap_or(self.ranges_are_limits);
        self.balances = view.flag("balanceinertia")?.unwrap_or(self.balances);
        self.strips_path = view.flag("strippath")?.unwrap_or(self.strips_path);
        if let Some([low, high]) = view.vector("inertiagrouprange")? {
            self.groups = (low, high);
        }
        self.least_mass = view.number("boundmass")?.unwrap_or(self.least_mass);
        self.least_inertia = view.number("boundinertia")?.unwrap_or(self.least_inertia);
        // A total of zero or less, such as the default -1 of MuJoCo, means that the masses are not scaled.
        if let Some(total) = view.number("settotalmass")? {
            self.total_mass = Some(total).filter(|total| *total > 0.0);
        }
        // `assetdir` is the folder of meshes and textures; `meshdir` is the folder of meshes alone, so it has priority.
        if let Some(folder) = view.get("assetdir").or(view.get("meshdir")) {
            self.mesh_folder = view.get("meshdir").unwrap_or(folder).to_string();
        }
        Ok(())
    }

    /// Converts an angle of the file to rad.
    pub(super) fn angle(&self, angle: f64) -> f64 {
        if self.degrees { angle * PI / 180.0 } else { angle }
    }

    /// Sine and cosine of an angle of the file. If the angle is a rounded multiple of pi, sine and cosine are the exact values
    /// of this multiple, and a note is added.
    fn turn(&self, view: View, angle: f64, snapped: &mut Vec<Note>) -> (f64, f64) {
        let given = self.angle(angle);
        let taken = angle_snap::given_angle(given, self.angles);
        snapped.extend(angle_snap::note_of(&view.element.called(), "an angle", given, &taken));
        sin_cos(&taken, &[])
    }

    /// The orientation of an element in its parent frame. Fails if the element gives its orientation in two forms.
    pub(super) fn orientation(&self, view: View, snapped: &mut Vec<Note>) -> Result<Matrix3, Error> {
        let own = |name: &&str| view.element.attribute(name).is_some();
        let mut given = ORIENTATIONS.iter().filter(|name| own(name));
        if let (Some(first), Some(second)) = (given.next(), given.next()) {
            let message = format!("{} has `{first}` and `{second}`: one of them", view.element.called());
            return Err(view.element.error(message));
        }
        let rotation = if let Some([angle_x, angle_y, angle_z]) = view.vector("euler")? {
            self.euler(view, [angle_x, angle_y, angle_z], snapped)
        } else if let Some([x, y, z, angle]) = view.vector("axisangle")? {
            let axis = direction(view, "axisangle", [x, y, z])?;
            rotation_by(axis, self.turn(view, angle, snapped))
        } else if let Some(six) = view.vector::<6>("xyaxes")? {
            let x = direction(view, "xyaxes", [six[0], six[1], six[2]])?;
            let y = [six[3], six[4], six[5]];
            let y = direction(view, "xyaxes", plus_scaled(y, x, -dot(x, y)))?;
            let z = cross(x, y);
            [0, 1, 2].map(|i| [x[i], y[i], z[i]])
        } else if let Some(z) = view.vector::<3>("zaxis")? {
            to_z(direction(view, "zaxis", z)?)
        } else if let Some(quaternion) = view.vector::<4>("quat")? {
            self.quaternion(view, quaternion)?
        } else {
            return Ok(crate::inertial::Pose::IDENTITY.rotation);
        };
        Ok(angle_snap::exact(&rotation))
    }

    fn euler(&self, view: View, angles: Vector3, snapped: &mut Vec<Note>) -> Matrix3 {
        let mut rotation = crate::inertial::Pose::IDENTITY.rotation;
        for (letter, angle) in self.euler.into_iter().zip(angles) {
            let k = match letter.to_ascii_lowercase() {
                'x' => 0,
                'y' => 1,
                _ => 2,
            };
            let axis = [0, 1, 2].map(|i| if i == k { 1.0 } else { 0.0 });
            let turn = rotation_by(axis, self.turn(view, angle, snapped));
            // A small letter means a rotation about the already rotated axis; a capital letter means a rotation about the
            // axis of the parent.
            rotation = if letter.is_lowercase() { product(&rotation, &turn) } else { product(&turn, &rotation) };
        }
        rotation
    }

    /// The rotation matrix of a quaternion w x y z. It is normalised first; fails if it is zero.
    pub(super) fn quaternion(&self, view: View, [w, x, y, z]: [f64; 4]) -> Result<Matrix3, Error> {
        let length = dot([x, y, z], [x, y, z]) + w * w;
        if length < SMALLEST_QUATERNION_SQUARE {
            return Err(view
                .element
                .error(format!("`quat` of {} is zero: it has no direction", view.element.called())));
        }
        let s = 2.0 / length;
        Ok([
            [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
        ])
    }
}

/// The unit vector along the vector of attribute `name`. Fails if the vector is zero.
pub(super) fn direction(view: View, name: &str, vector: Vector3) -> Result<Vector3, Error> {
    let length = norm(vector);
    if length < SMALLEST_DIRECTION_NORM {
        return Err(view.element.error(format!("`{name}` of {} names no direction", view.element.called())));
    }
    Ok(scaled(vector, 1.0 / length))
}

/// The smallest rotation that turns the z axis into the unit vector `z`.
pub(super) fn to_z(z: Vector3) -> Matrix3 {
    let across = cross([0.0, 0.0, 1.0], z);
    let sine = norm(across);
    // For the opposite direction the axis of rotation is arbitrary. MuJoCo uses x.
    let axis = if sine < PARALLEL_SINE { [1.0, 0.0, 0.0] } else { scaled(across, 1.0 / sine) };
    let sine = if sine < PARALLEL_SINE { 0.0 } else { sine };
    rotation_by(axis, (sine, z[2]))
}
