//! Logs of a robot at work: slow and fast motion with reversals, pushes on a link, a load that is picked up and put down.
//!
//! The logs are for tests of `rist replay` (observer of external torques, contact, load, drift of friction).

use linear_model::standard_map::StandardMap;
use logs::{Log, LogSource};
use random::Random;
use rist::describe::evaluation::{Evaluation, ManyStates};
use rist::{KnownLoad, Model};

use crate::joint_log::even_log;

/// A push on a link.
#[derive(Clone, Debug)]
pub struct Push {
    /// Index of the pushed link, which is also the index of the joint that moves this link.
    pub link: usize,
    /// First and last time, s.
    pub from: f64,
    pub to: f64,
    /// A constant force that the link exerts on the environment, in the frame of the link, N.
    pub force: [f64; 3],
    /// If given, the force is scaled so that its largest joint torque at the beginning is this, N m.
    pub largest: Option<f64>,
}

/// A load that the last link carries from the time `from` to the time `to`, s.
#[derive(Clone, Debug)]
pub struct Carried {
    pub from: f64,
    pub to: f64,
    pub load: KnownLoad,
}

/// The robot, its motion, and the pushes and loads that are simulated.
#[derive(Clone)]
pub struct Scene<'a> {
    pub model: &'a Model,
    /// Base parameters X of the simulated robot.
    pub x: Vec<f64>,
    /// Viscous friction FV, Coulomb friction FS and offset OFF of each joint.
    pub friction: Vec<[f64; 3]>,
    pub seed: u64,
    pub seconds: f64,
    pub rate: f64,
    /// Standard deviation of white noise on the torques, N m, and on the velocities, rad/s.
    pub noise: f64,
    pub speed_noise: f64,
    /// Amplitude of the motion, rad.
    pub amplitude: f64,
    pub pushes: Vec<Push>,
    pub loads: Vec<Carried>,
}

/// Range of velocity within which the Coulomb friction of the simulated robot changes its sign, rad/s.
const REVERSAL: f64 = 0.003;

/// Distance of the point of a push from the origin of its link, along each axis, m.
const LEVER: f64 = 0.1;

/// One sine of a joint: amplitude, angular frequency, phase.
type Sine = [f64; 3];

impl Scene<'_> {
    /// The log, and for each push the largest external torque and its joint.
    pub fn log(&self) -> (Log, Vec<(f64, usize)>) {
        let n = self.model.regressor().coordinates().len();
        let mut random = Random::new(self.seed);
        let sines: Vec<Vec<Sine>> = (0..n)
            .map(|_| {
                let mut sine = || {
                    [
                        self.amplitude * (0.2 + 0.4 * random.uniform()),
                        0.4 + 2.0 * random.uniform(),
                        6.3 * random.uniform(),
                    ]
                };
                (0..4).map(|_| sine()).collect()
            })
            .collect();
        let count = (self.seconds * self.rate) as usize;
        let (mut q, mut dq, mut states) = (vec![Vec::new(); n], vec![Vec::new(); n], Vec::with_capacity(3 * n * count));
        for r in 0..count {
            let (at, rate, change) = clock(r as f64 / self.rate);
            let of = |f: &dyn Fn(f64, f64, f64) -> f64| -> Vec<f64> {
                sines.iter().map(|sines| sines.iter().map(|[a, w, phase]| f(*a, *w, w * at + phase)).sum()).collect()
            };
            let (position, slope) = (of(&|a, _, p| a * p.sin()), of(&|a, w, p| a * w * p.cos()));
            let bend = of(&|a, w, p| -a * w * w * p.sin());
            states.extend_from_slice(&position);
            states.extend(slope.iter().map(|s| s * rate));
            states.extend(slope.iter().zip(&bend).map(|(s, b)| s * change + b * rate * rate));
            for k in 0..n {
                q[k].push(position[k]);
                dq[k].push(slope[k] * rate);
            }
        }
        let (tau, largest) = self.torques(&states, &mut random);
        dq.iter_mut().flatten().for_each(|v| *v += self.speed_noise * random.normal());
        (even_log(self.model.regressor().coordinates(), 1.0 / self.rate, [q, dq, tau]), largest)
    }

    /// The log as a source for the library.
    pub fn source(&self) -> LogSource {
        LogSource::Held(self.log().0)
    }

    fn torques(&self, states: &[f64], random: &mut Random) -> (Vec<Vec<f64>>, Vec<(f64, usize)>) {
        let regressor = self.model.regressor();
        let (n, p) = (regressor.coordinates().len(), self.x.len());
        let map: StandardMap = self.model.standard_map();
        let added = self.loads.iter().map(|c| c.load.base_parameters(&self.model.robot, &map).unwrap());
        let added: Vec<Vec<f64>> = added.collect();
        let external: Vec<Evaluation> = self.pushes.iter().map(|push| self.external(push.link)).collect();
        let mut largest = vec![(0.0_f64, 0); self.pushes.len()];
        let mut scales: Vec<Option<f64>> = vec![None; self.pushes.len()];
        let mut tau = vec![Vec::new(); n];
        let mut y = vec![0.0; n * p];
        for (r, state) in states.chunks_exact(3 * n).enumerate() {
            let t = r as f64 / self.rate;
            regressor.fill(&state[..n], &state[n..2 * n], &state[2 * n..], &mut y);
            let mut x = self.x.clone();
            for (carried, added) in self.loads.iter().zip(&added).filter(|(c, _)| (c.from..c.to).contains(&t)) {
                assert!(carried.load.mass > 0.0);
                x.iter_mut().zip(added).for_each(|(x, added)| *x += added);
            }
            let mut pushed = vec![0.0; n];
            for (k, push) in self.pushes.iter().enumerate().filter(|(_, push)| (push.from..push.to).contains(&t)) {
                let [x, y, z] = push.force;
                // The force acts at LEVER (1, 1, 1), because the origin of a link may lie on the axes before it.
                let wrench = [x, y, z, LEVER * (z - y), LEVER * (x - z), LEVER * (y - x)];
                let mut torque = vec![0.0; n];
                let at = ManyStates { q: &state[..n], others: &[("wrench", &wrench)], ..ManyStates::default() };
                external[k].fill(self.model, &at, &mut torque).unwrap();
                let most = torque.iter().fold(1e-9, |most: f64, torque| most.max(torque.abs()));
                let scale = *scales[k].get_or_insert(push.largest.map_or(1.0, |largest| largest / most));
                for (j, torque) in torque.iter().map(|torque| scale * torque).enumerate() {
                    if torque.abs() > largest[k].0 {
                        largest[k] = (torque.abs(), j);
                    }
                    // The function `external-torque` takes the wrench that the link exerts, so the motors must supply its
                    // torques additionally.
                    pushed[j] += torque;
                }
            }
            for (k, row) in y.chunks_exact(p).enumerate() {
                let [viscous, coulomb, offset] = self.friction[k];
                let speed = state[n + k];
                let friction = viscous * speed + coulomb * (speed / REVERSAL).tanh() + offset;
                let body: f64 = row.iter().zip(&x).map(|(y, x)| y * x).sum();
                tau[k].push(body + friction + pushed[k] + self.noise * random.normal());
            }
        }
        (tau, largest)
    }

    fn external(&self, link: usize) -> Evaluation {
        let name = &self.model.robot.links[link].name;
        Evaluation::of_function(self.model, &format!("external-torque={name}")).unwrap()
    }
}

/// The motion is a function of its own time, which runs at a variable rate: within every twenty seconds, the robot moves at
/// full speed, slowly, and nearly stops. Returns the time of the motion (s), its rate, and the change of its rate at a time of
/// the log (s).
fn clock(t: f64) -> (f64, f64, f64) {
    let w = std::f64::consts::TAU / 20.0;
    (0.55 * t - 0.45 / w * (w * t).cos(), 0.55 + 0.45 * (w * t).sin(), 0.45 * w * (w * t).cos())
}
