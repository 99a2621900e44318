//! A motion that another program planned: points in time, and the interpolation between them.
//!
//! Not here: reading files of points.

/// The interpolation that a controller uses between given points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines between positions; the velocity jumps at points.
    Linear,
    /// Cubic polynomials that match positions and velocities; the acceleration jumps at points.
    Cubic,
    /// Quintic polynomials that match positions, velocities and accelerations; the jerk jumps at points.
    Quintic,
}

impl Interpolation {
    /// All interpolations with their names.
    pub const ALL: [(Interpolation, &str); 3] =
        [(Interpolation::Linear, "linear"), (Interpolation::Cubic, "cubic"), (Interpolation::Quintic, "quintic")];

    /// The name of the interpolation, as in [`Interpolation::ALL`].
    pub fn word(self) -> &'static str {
        Interpolation::ALL.into_iter().find(|(i, _)| *i == self).map_or("", |(_, word)| word)
    }
}

/// A trajectory given by points: times, and one series of values per coordinate, all of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct PointTrajectory {
    coordinates: Vec<String>,
    times: Vec<f64>,
    positions: Vec<Vec<f64>>,
    velocities: Option<Vec<Vec<f64>>>,
    accelerations: Option<Vec<Vec<f64>>>,
}

/// Greatest number of points of a trajectory: 400 s at 1 kHz. The proof of a longer one would take too long.
const MAX_TRAJECTORY_POINTS: usize = 400_000;
/// Greatest accepted magnitude of a number, in SI units. It is larger than any robot needs, and a proof does not overflow.
const LARGEST_NUMBER: f64 = 1e6;

impl PointTrajectory {
    /// Makes a trajectory from times (s), positions (rad or m) and their derivatives.
    ///
    /// Fails if there are fewer than two points or too many, if time does not increase, or if a number is not finite or too
    /// large.
    pub fn new(
        coordinates: Vec<String>,
        times: Vec<f64>,
        positions: Vec<Vec<f64>>,
        velocities: Option<Vec<Vec<f64>>>,
        accelerations: Option<Vec<Vec<f64>>>,
    ) -> Result<PointTrajectory, String> {
        // The numbers may come from a file, so each error message names the wrong number.
        let count = times.len();
        if !(2..=MAX_TRAJECTORY_POINTS).contains(&count) {
            return Err(format!("it has {count} points; expected are 2 to {MAX_TRAJECTORY_POINTS}"));
        }
        if let Some(i) = (1..count).find(|&i| times[i] <= times[i - 1]) {
            return Err(format!(
                "time does not go on from point {i} ({} s) to the next ({} s)",
                times[i - 1],
                times[i]
            ));
        }
        // Each series must have one finite number per joint and point.
        let all = [Some(&positions), velocities.as_ref(), accelerations.as_ref()];
        for (what, series) in ["positions", "velocities", "accelerations"].iter().zip(all) {
            let Some(series) = series else { continue };
            if series.len() != coordinates.len() || series.iter().any(|x| x.len() != count) {
                return Err(format!("{what}: expected is one number per joint and point"));
            }
            for (name, x) in coordinates.iter().zip(series) {
                if let Some(i) = x.iter().position(|x| x.is_nan() || x.abs() > LARGEST_NUMBER) {
                    return Err(format!("{what} of {name} at point {}: {:e} is of no robot", i + 1, x[i]));
                }
            }
        }
        if let Some(t) = times.iter().find(|t| t.is_nan() || t.abs() > LARGEST_NUMBER) {
            return Err(format!("a point is at {t} s"));
        }
        Ok(PointTrajectory { coordinates, times, positions, velocities, accelerations })
    }

    /// Orders the points like the coordinates of a model. `stands(k)`: constant position of coordinate k (rad or m) if the
    /// trajectory does not move it.
    ///
    /// Fails if the trajectory moves an unknown joint, or if the position of a coordinate is not known.
    pub fn of_coordinates(
        self,
        names: &[String],
        stands: &dyn Fn(usize) -> Option<f64>,
    ) -> Result<PointTrajectory, String> {
        if let Some(unknown) = self.coordinates.iter().find(|c| !names.contains(c)) {
            return Err(format!("there is no coordinate `{unknown}`; there are {}", names.join(", ")));
        }
        let count = self.times.len();
        let place = |name: &String| self.coordinates.iter().position(|c| c == name);
        let mut positions = Vec::new();
        for (k, name) in names.iter().enumerate() {
            positions.push(match (place(name), stands(k)) {
                (Some(place), _) => self.positions[place].clone(),
                (None, Some(q)) => vec![q; count],
                (None, None) => {
                    return Err(format!(
                        "it does not say where {name} stands: give `coordinates: {{{name}: {{locked: POSITION}}}}` in [limits]"
                    ));
                }
            });
        }
        let still = |series: Option<Vec<Vec<f64>>>| {
            let series = series?;
            Some(names.iter().map(|name| place(name).map_or(vec![0.0; count], |k| series[k].clone())).collect())
        };
        let (velocities, accelerations) = (still(self.velocities.clone()), still(self.accelerations.clone()));
        Ok(PointTrajectory { coordinates: names.to_vec(), times: self.times, positions, velocities, accelerations })
    }

    /// The interpolation `asked`, or for `None` the smoothest one that the points allow.
    ///
    /// Fails if the points lack the derivatives that the requested interpolation needs.
    pub fn interpolation(&self, asked: Option<Interpolation>) -> Result<Interpolation, String> {
        let needs =
            |what: &str| format!("an interpolation of this kind needs {what} at the points, and the file has none");
        match (asked, &self.velocities, &self.accelerations) {
            (Some(Interpolation::Linear), ..) | (None, None, _) => Ok(Interpolation::Linear),
            (Some(Interpolation::Cubic), Some(_), _) | (None, Some(_), None) => Ok(Interpolation::Cubic),
            (Some(Interpolation::Quintic) | None, Some(_), Some(_)) => Ok(Interpolation::Quintic),
            (Some(_), None, _) => Err(needs("velocities")),
            (Some(_), _, None) => Err(needs("accelerations")),
        }
    }

    /// Names of the coordinates, in the order of the series.
    pub fn coordinates(&self) -> &[String] {
        &self.coordinates
    }

    /// Times of the points, s.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Positions of the points, rad (m), one series per coordinate.
    pub fn positions(&self) -> &[Vec<f64>] {
        &self.positions
    }

    /// Velocities at the points, rad/s (m/s), one series per coordinate. `None` if the file has none.
    pub fn velocities(&self) -> Option<&[Vec<f64>]> {
        self.velocities.as_deref()
    }

    /// Accelerations at the points, rad/s^2 (m/s^2), one series per coordinate. `None` if the file has none.
    pub fn accelerations(&self) -> Option<&[Vec<f64>]> {
        self.accelerations.as_deref()
    }

    /// Whether all velocities are zero at the first and the last point; true if the file has no velocities.
    pub fn rests_at_its_ends(&self) -> bool {
        let last = self.times.len() - 1;
        self.velocities.as_ref().is_none_or(|v| v.iter().all(|v| v[0] == 0.0 && v[last] == 0.0))
    }
}
