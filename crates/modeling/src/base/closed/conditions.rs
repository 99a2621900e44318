//! Fits random constants of loops to the conditions of closure. The numbers of a robot's file fulfil these conditions already.

use expr::{Function, Node, SymbolKind};

use crate::base::closed::closed_point::{ClosedPoint, ClosedPoints};
use crate::base::closed::lengths::random_zero;
use crate::base::closed::reason::NoCertificate;
use crate::base::closed::variables::State;
use crate::base::exact_rank::Echelon;
use crate::base::field::{Assignment, Residue, turned, twelfth_turn};
use random::SplitMix;

impl ClosedPoints {
    /// Changes the lengths normal to the plane of each planar loop so that the two ends of the loop lie in one plane.
    pub(crate) fn fit_planes(&self, constants: &mut [Assignment], random: &mut SplitMix) -> Result<(), NoCertificate> {
        self.fit_angles(constants);
        let offsets = |constants: &[Assignment]| -> Vec<Residue> {
            self.planar_loops(constants).into_iter().flatten().map(|l| l.offset).collect()
        };
        if offsets(constants).iter().all(|x| *x == Residue::ZERO) {
            return Ok(());
        }
        let lengths = self.lengths_of(&self.chains.placements);
        let f = |x: &[Residue]| {
            let mut constants = constants.to_vec();
            lengths.iter().zip(x).for_each(|(&s, &x)| constants[s].length = x);
            Some(offsets(&constants))
        };
        let x = random_zero(lengths.len(), f, random).ok_or(NoCertificate::OtherForm)?;
        if x.contains(&Residue::ZERO) {
            return Err(NoCertificate::EqualLengths);
        }
        lengths.iter().zip(x).for_each(|(&s, x)| constants[s].length = x);
        Ok(())
    }

    /// Changes the constant angles of planar loops so that orientations close. If the orientation of a loop depends on no
    /// variable, the constant angles of the loop must add up to zero. In the robot's file, plain numbers (not symbols) ensure
    /// this sum, such as the constant of a relation between passive angles. One of these numbers is changed.
    pub(crate) fn fit_angles(&self, constants: &mut [Assignment]) {
        let none = State::unknown(self.variables.len());
        let whole = (Residue::ONE, Residue::ZERO);
        let defects = |constants: &[Assignment]| -> Vec<Option<(Residue, Residue)>> {
            self.planar_loops(constants).iter().map(|l| l.as_ref().and_then(|l| l.defect(&none))).collect()
        };
        let graph = self.chains.placements.graph();
        let n_bad = |defects: &[Option<(Residue, Residue)>]| defects.iter().flatten().filter(|d| **d != whole).count();
        let mut found = defects(constants);
        while let Some((c, s)) = found.iter().flatten().copied().find(|d| *d != whole) {
            let before = n_bad(&found);
            let candidates = (0..constants.len())
                .rev()
                .filter(|&k| matches!(graph.symbols()[k].1, SymbolKind::Constant(x) if twelfth_turn(x).is_none()));
            let fitted = candidates.flat_map(|k| [(k, (c, s)), (k, (c, -s))]).find_map(|(k, by)| {
                let mut trial = constants.to_vec();
                (trial[k].cos, trial[k].sin) = turned((trial[k].cos, trial[k].sin), by);
                let found = defects(&trial);
                (n_bad(&found) < before).then_some((trial, found))
            });
            let Some((trial, left)) = fitted else { return };
            constants.copy_from_slice(&trial);
            found = left;
        }
    }

    /// The constants that a function uses as lengths (outside sines and cosines), as indices of the symbols of these constants.
    pub(crate) fn lengths_of(&self, function: &Function) -> Vec<usize> {
        let graph = function.graph();
        let mut is_length = vec![false; graph.symbols().len()];
        let symbol = |e: expr::Expr| match graph.node(e) {
            Node::Symbol(s) if matches!(graph.symbols()[s.0 as usize].1, SymbolKind::Constant(_)) => Some(s.0 as usize),
            _ => None,
        };
        let not_in_an_angle = graph.nodes().iter().filter(|n| !matches!(n, Node::Sin(_) | Node::Cos(_)));
        let read = not_in_an_angle.flat_map(|&n| expr::operands(n)).chain(function.outputs[0].entries.iter().copied());
        read.filter_map(symbol).for_each(|s| is_length[s] = true);
        (0..is_length.len()).filter(|&s| is_length[s]).collect()
    }

    /// Whether the loops can stay closed when the lengths change. Passive variables must compensate each change of the closure
    /// error e, except changes of the offsets normal to planar loops, which no variable changes.
    pub(crate) fn lengths_are_free(&self, point: &ClosedPoint, lengths: &[usize]) -> bool {
        let offsets = |constants: &[Assignment]| -> Vec<Residue> {
            self.planar_loops(constants).into_iter().flatten().map(|l| l.offset).collect()
        };
        // Changes of the closure error e by passive variables (columns of J_p), then by lengths; changes of the offsets by
        // lengths.
        let Some((e, j)) = self.closure_at(point) else { return false };
        let (mut of_passive, mut of_offsets) = (Echelon::default(), Echelon::default());
        let m = self.variables.len() - self.variables.n;
        let column = |p: usize| j.iter().skip(p).step_by(m).copied().collect();
        let n_passive = (0..m).filter(|&p| of_passive.add(column(p))).count();
        let still = offsets(&point.constants);
        for &s in lengths {
            let mut moved = point.clone();
            moved.constants[s].length = moved.constants[s].length + Residue::ONE;
            let Some((next, _)) = self.closure_at(&moved) else { return false };
            let difference = |a: &[Residue], b: &[Residue]| a.iter().zip(b).map(|(a, b)| *a - *b).collect::<Vec<_>>();
            of_passive.add(difference(&next, &e));
            of_offsets.add(difference(&offsets(&moved.constants), &still));
        }
        of_passive.columns().len() == n_passive + of_offsets.columns().len()
    }
}
