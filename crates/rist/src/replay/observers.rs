//! The observers of the external torques of all joints. The columns of a load and of friction pass the same filter, so that
//! they can be compared with the external torques.
//!
//! A column of a regressor is the torque per unit of one parameter. H: filtered columns of the load, so that a load with the
//! parameters x causes the external torque -H x. Slowness: 1 at standstill, 0 at speed.

use online::{Observer, Order};

use crate::replay::cycles::Cycle;

/// Filtered signals of one joint.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    /// External torque of the observer, N m (N).
    pub(crate) torque: f64,
    /// Row of H. A load with the parameters x causes the external torque -H x.
    pub(crate) load: [f64; 10],
    /// Speed and direction of the joint, after the filter that a torque passes in the observer.
    pub(crate) friction: [f64; 2],
    /// Slowness of the joint, after the same filter.
    pub(crate) slowness: f64,
}

/// The observers of one joint.
struct JointObservers {
    torque: Observer<f64>,
    load: [Observer<f64>; 10],
    friction: [Observer<f64>; 2],
    slowness: Observer<f64>,
}

/// The observers of all joints.
pub(crate) struct Observers {
    joints: Vec<JointObservers>,
    pub(crate) seen: Vec<Seen>,
}

impl Observers {
    pub(crate) fn new(n: usize, order: Order<f64>) -> Observers {
        let one = Observer::new(order);
        let joint = || JointObservers { torque: one, load: [one; 10], friction: [one; 2], slowness: one };
        let none = Seen { torque: 0.0, load: [0.0; 10], friction: [0.0; 2], slowness: 0.0 };
        Observers { joints: (0..n).map(|_| joint()).collect(), seen: vec![none; n] }
    }

    /// Takes a cycle. At the first cycle of a record all observers start again.
    pub(crate) fn step(&mut self, cycle: &Cycle) {
        for ((observers, joint), seen) in self.joints.iter_mut().zip(cycle.joints).zip(&mut self.seen) {
            let JointObservers { torque, load, friction, slowness } = observers;
            if cycle.period <= 0.0 {
                [&mut *torque, &mut *slowness]
                    .into_iter()
                    .chain(&mut *load)
                    .chain(&mut *friction)
                    .for_each(Observer::reset);
            }
            seen.torque = torque.step(joint.momentum, joint.known, cycle.period);
            let [momenta, rates] = &joint.load;
            for (k, observer) in load.iter_mut().enumerate() {
                seen.load[k] = observer.step(momenta[k], rates[k], cycle.period);
            }
            for (k, column) in [joint.speed, joint.direction].into_iter().enumerate() {
                // The observer filters the column if its inputs are a momentum of zero and the negative column as known torque.
                seen.friction[k] = friction[k].step(0.0, -column, cycle.period);
            }
            // The filter of second order overshoots, but an interval is not negative.
            seen.slowness = slowness.step(0.0, -joint.slowness, cycle.period).max(0.0);
        }
    }
}
