//! A tree of links in other parameters: base to standard, and a robot of given base parameters.

use identification::model::regressor::Regressor;
use identification::model::standard_map::StandardMap;

use crate::tree_robot::{LETTERS, Link, TreeRobot};

fn rebuilt(robot: &TreeRobot, links: Vec<Link>) -> TreeRobot {
    let names: Vec<&str> = robot.coordinates().iter().map(String::as_str).collect();
    TreeRobot::new(links, robot.gravity, &names)
}

fn empty(robot: &TreeRobot) -> Vec<Link> {
    robot.links.iter().map(|link| Link { standard: [0.0; 11], ..link.clone() }).collect()
}

/// X = B phi of a robot without rotors: column c of B are the base parameters of a robot that has the c-th standard
/// parameter only.
pub fn standard_map(robot: &TreeRobot) -> StandardMap {
    let (mut names, mut terms, mut bodies) = (Vec::new(), Vec::new(), Vec::new());
    for j in 0..robot.links.len() {
        bodies.push((format!("link {}", j + 1), 10 * j));
        for c in 0..10 {
            let mut links = empty(robot);
            links[j].standard[c] = 1.0;
            let base = rebuilt(robot, links).truth;
            terms.extend(base.into_iter().enumerate().map(|(k, b)| (k, 10 * j + c, b)));
            names.push(format!("{}{}", LETTERS[c], j + 1));
        }
    }
    StandardMap::new(names, robot.truth.len(), &terms, bodies, Vec::new())
}

/// The robot with base parameters `x`: they are its standard ones, the others are zero.
pub fn with_base(robot: &TreeRobot, x: &[f64]) -> TreeRobot {
    let mut links = empty(robot);
    for (name, &x) in robot.parameters().iter().zip(x) {
        let of = |(j, c): &(usize, usize)| name.name.to_string() == format!("{}{}", LETTERS[*c], j + 1);
        let places = (0..links.len()).flat_map(|j| (0..LETTERS.len()).map(move |c| (j, c)));
        if let Some((j, c)) = places.into_iter().find(of) {
            links[j].standard[c] = x;
        }
    }
    rebuilt(robot, links)
}

/// The robot with every standard parameter of a link multiplied by that link's factor.
pub fn with_scaled_links(robot: &TreeRobot, factors: &[f64]) -> TreeRobot {
    let scaled = |(link, f): (&Link, &f64)| Link { standard: link.standard.map(|x| f * x), ..link.clone() };
    rebuilt(robot, robot.links.iter().zip(factors).map(scaled).collect())
}
