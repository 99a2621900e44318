//! A second-order model of log det F about a design, and the best step of this model between bounds.
//!
//! x: number of runs of each candidate; F(x) = sum x_i F_i: information matrix. With T = F(x)^-1, g_i = tr(F_i T) and
//! H_ij = tr(F_i T F_j T),
//!
//! log det F(x + d) = log det F(x) + g'd - d'Hd/2 + third order, sum d = 0.
//!
//! A step consists of moves. Each move shifts runs from the worst candidate to the best, by the number of runs that maximises the
//! model, and costs one pass over the candidates. The exchange of [Fedorov 1972] uses log det F itself, so each move costs a
//! factorisation.
//!
//! Only some candidates are members of the model: those that are run, and those with the greatest g. The other candidates would
//! not be run, and the cost grows with the square of the number of members. H_ij is the sum of the squares of the products of the
//! whitened rows of i and j.

use numerics::information_matrix::{InformationFactor, WeightedRows};

/// If the slopes of two candidates differ by less than this share of the greater slope, the difference is only rounding, and the
/// ascent ends.
const RELATIVE_SLOPE_ROUNDING: f64 = 1e-12;
/// If a remainder of a number of runs is below this value, it is only rounding, because the sum of the runs is a whole number.
const RUN_ROUNDING: f64 = 1e-9;
/// A second-order model of log det F at a design (number of runs of each candidate). F: information matrix. Candidates that are
/// not members of the model keep their number of runs.
#[derive(Clone, Debug)]
pub struct QuadraticModel {
    /// Indices of the candidates that are members of the model, ascending.
    members: Vec<usize>,
    /// Slopes g_i = d log det F / dx_i, one per member; x_i: number of runs.
    gain: Vec<f64>,
    /// Matrix H (negative second derivatives of log det F), row by row, one row per member.
    curvature: Vec<f64>,
}

/// The allowed range of the step (change of the number of runs) of each candidate, from the current design.
#[derive(Clone, Debug)]
pub struct StepBounds {
    /// Least step of each candidate; zero or negative if the design is within its bounds.
    pub least: Vec<f64>,
    /// Greatest step of each candidate; zero or positive if the design is within its bounds.
    pub most: Vec<f64>,
}

impl QuadraticModel {
    /// Makes the model with these members at a design. `factor`: factorisation of the information matrix F of the design;
    /// `blocks`: regressor rows of each candidate.
    pub fn new(blocks: &[WeightedRows], members: Vec<usize>, factor: &InformationFactor) -> QuadraticModel {
        let p = blocks.first().map_or(0, WeightedRows::width);
        let (mut rows, mut ends) = (Vec::new(), vec![0]);
        let mut out = vec![0.0; p];
        for &member in &members {
            for row in blocks[member].iter() {
                factor.whiten(row, &mut out);
                rows.extend_from_slice(&out);
            }
            ends.push(rows.len() / p.max(1));
        }
        let row = |r: usize| &rows[r * p..(r + 1) * p];
        let dot = |a: usize, b: usize| row(a).iter().zip(row(b)).map(|(x, y)| x * y).sum::<f64>();
        let count = members.len();
        let mut curvature = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..=i {
                let pairs = (ends[i]..ends[i + 1]).flat_map(|a| (ends[j]..ends[j + 1]).map(move |b| (a, b)));
                let sum: f64 = pairs.map(|(a, b)| dot(a, b).powi(2)).sum();
                (curvature[i * count + j], curvature[j * count + i]) = (sum, sum);
            }
        }
        let gain = (0..count).map(|i| (ends[i]..ends[i + 1]).map(|a| dot(a, a)).sum()).collect();
        QuadraticModel { members, gain, curvature }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.curvature[i * self.gain.len()..(i + 1) * self.gain.len()]
    }

    /// The best step within the bounds `room`, one entry per candidate, and the increase of the model by this step. It is found
    /// by at most `moves` moves, each of which shifts runs from one candidate to another.
    pub fn step(&self, room: &StepBounds, moves: usize) -> (Vec<f64>, f64) {
        let mut own = vec![0.0; self.members.len()];
        let gained = self.ascend(&mut own, &self.own(room), moves);
        let mut step = vec![0.0; room.least.len()];
        self.members.iter().zip(own).for_each(|(member, by)| step[*member] = by);
        (step, gained)
    }

    fn own(&self, room: &StepBounds) -> StepBounds {
        let of = |x: &[f64]| self.members.iter().map(|&i| x[i]).collect();
        StepBounds { least: of(&room.least), most: of(&room.most) }
    }

    /// Improves `step` (one entry per member) by at most `moves` moves, which shift runs between two members. Returns the
    /// increase of the model by the resulting step.
    fn ascend(&self, step: &mut [f64], room: &StepBounds, moves: usize) -> f64 {
        let count = step.len();
        let mut slope = self.gain.clone();
        for i in (0..count).filter(|&i| step[i] != 0.0) {
            slope.iter_mut().zip(self.row(i)).for_each(|(s, h)| *s -= step[i] * h);
        }
        for _ in 0..moves {
            let (mut grows, mut shrinks) = (None, None);
            for i in 0..count {
                if step[i] < room.most[i] && grows.is_none_or(|g: usize| slope[i] > slope[g]) {
                    grows = Some(i);
                }
                if step[i] > room.least[i] && shrinks.is_none_or(|s: usize| slope[i] < slope[s]) {
                    shrinks = Some(i);
                }
            }
            let (Some(grows), Some(shrinks)) = (grows, shrinks) else { break };
            let rise = slope[grows] - slope[shrinks];
            // `rise`, the difference of both slopes, is the increase of the model per run that is moved.
            if rise <= RELATIVE_SLOPE_ROUNDING * slope[grows].abs() {
                break;
            }
            let (g, s) = (self.row(grows), self.row(shrinks));
            let bend = g[grows] + s[shrinks] - 2.0 * g[shrinks];
            let most = (room.most[grows] - step[grows]).min(step[shrinks] - room.least[shrinks]);
            let by = if bend > 0.0 { most.min(rise / bend) } else { most };
            step[grows] = if by == room.most[grows] - step[grows] { room.most[grows] } else { step[grows] + by };
            step[shrinks] =
                if by == step[shrinks] - room.least[shrinks] { room.least[shrinks] } else { step[shrinks] - by };
            slope.iter_mut().zip(g.iter().zip(s)).for_each(|(x, (g, s))| *x -= by * (g - s));
        }
        // The increase of the model is g'd - d'Hd/2; it is computed with slope = g - H d.
        step.iter().zip(self.gain.iter().zip(&slope)).map(|(d, (g, s))| 0.5 * d * (g + s)).sum()
    }

    /// The decrease of the model if the runs of `candidate` change by `by` and are then fixed, while the runs of the others are
    /// optimised. Infinite if the bounds of the others do not allow this; zero if the candidate is not a member.
    pub fn loss(&self, room: &StepBounds, candidate: usize, by: f64, moves: usize) -> f64 {
        let Ok(candidate) = self.members.binary_search(&candidate) else { return 0.0 };
        let (count, room) = (self.gain.len(), self.own(room));
        let mut step = vec![0.0; count];
        let mut order: Vec<usize> = (0..count).filter(|&i| i != candidate).collect();
        // The other candidates compensate for the step, in the order of their slopes: first those that increase the model most or
        // decrease it least.
        let key = |i: usize| if by < 0.0 { -self.gain[i] } else { self.gain[i] };
        order.sort_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        let mut left = by.abs();
        for i in order {
            let taken = left.min(if by < 0.0 { room.most[i] } else { -room.least[i] }.max(0.0));
            step[i] = if by < 0.0 { taken } else { -taken };
            left -= taken;
        }
        // A remainder is left if the bounds of the other candidates do not allow the step.
        if left > RUN_ROUNDING {
            return f64::INFINITY;
        }
        step[candidate] = by;
        let mut held = room;
        (held.least[candidate], held.most[candidate]) = (by, by);
        (-self.ascend(&mut step, &held, moves)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::information_matrix::InformationMatrix;
    use random::Random;

    /// Checks that the model agrees with log det F up to third-order terms, and that fixing a candidate at its best step causes
    /// no loss.
    #[test]
    fn the_model_is_of_second_order() {
        let mut random = Random::new(2);
        let mut block = |_| {
            let mut rows = WeightedRows::new(3);
            (0..2).for_each(|_| rows.push(&[random.normal(), random.normal(), random.normal()]));
            rows
        };
        let blocks: Vec<WeightedRows> = (0..5).map(&mut block).collect();
        let factor = |x: &[f64]| InformationMatrix::sum(3, 0.0, blocks.iter().zip(x.iter().copied())).factor().unwrap();
        let x = [0.5; 5];
        let model = QuadraticModel::new(&blocks, vec![0, 1, 3, 4], &factor(&x));
        let near = |by: f64| {
            let room = StepBounds { least: vec![-by; 5], most: vec![by; 5] };
            let (step, gained) = model.step(&room, 100);
            assert!(step[2] == 0.0 && step.iter().sum::<f64>().abs() < 1e-12 && gained > 0.0, "{step:?}");
            let moved: Vec<f64> = x.iter().zip(&step).map(|(x, d)| x + d).collect();
            (gained - (factor(&moved).log_det - factor(&x).log_det)).abs()
        };
        // The error is of third order: a step of a tenth of the length has a thousandth of the error.
        assert!(near(1e-2) < 1e-4 && near(1e-3) < 2e-3 * near(1e-2), "{} {}", near(1e-2), near(1e-3));
        let room = StepBounds { least: vec![-0.5; 5], most: vec![0.5; 5] };
        let (best, gained) = model.step(&room, 1000);
        // Fixing a candidate at its best step causes no loss.
        assert!((model.loss(&room, 0, best[0], 1000) - (-gained).max(0.0)).abs() < 1e-9);
        let none = StepBounds { least: vec![0.0; 5], most: vec![0.0; 5] };
        assert_eq!(model.loss(&none, 1, 0.25, 10), f64::INFINITY);
    }
}
