//! Chooses between two forms of the regressor's entries for first moments and masses, so that all entries together take the
//! fewest operations.
//!
//! ```text
//! by the twist                   z . n + d . f      d of every coordinate is transformed outward from link to link
//! about an axis intersection     z . (n + c x f)    all axes through the point share c and the moment n + c x f
//! ```
//! (z, d): twist of link j per unit rate of coordinate k; (f, n): force and moment on link j per unit of the parameter; c:
//! vector from the axis intersection to the origin of link j. [`crate::kinematics::axis_intersections`] finds the points. In a
//! shoulder of three axes, the shared moment saves operations. For two axes, the better form depends on the joints between the
//! intersection and the link.

use expr::{Expr, FormChange, Graph, fewest_operations};
use robot::LinkId;

use crate::kinematics::links::{LinkMotion, Twist};
use crate::kinematics::vector::{Vector, dot, plus_cross, plus_dot};

/// The regressor column of a parameter: the index of the column, the link of the parameter, and force f and moment n on this
/// link per unit of the parameter.
pub(crate) struct WrenchColumn {
    pub place: usize,
    pub link: LinkId,
    pub f: Vector,
    pub n: Vector,
}

/// A set of regressor entries that change together from one form (by the twist, about an axis intersection) to the other.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum FormGroup {
    /// All entries that have a form about one axis intersection. The link is the link of the first axis through the
    /// intersection.
    Pole(LinkId),
    /// The entries that have a form about one axis intersection, but only in the columns of one link. Fields: this link, and
    /// the link of the first axis through the intersection.
    AtLink(LinkId, LinkId),
}

/// The entries of the regressor, their forms (by the twist, about an axis intersection), and the changes of form to try.
#[derive(Default)]
struct Choices {
    /// Row and column of each entry in the regressor.
    places: Vec<(usize, usize)>,
    forms: Vec<Vec<Expr>>,
    start: Vec<usize>,
    groups: std::collections::BTreeMap<FormGroup, Vec<FormChange>>,
}

/// (row, column, entry) of all entries of the regressor columns `columns`, in the forms with the fewest operations. `fixed`:
/// other expressions of the function; operations that an entry shares with these expressions are not counted.
pub(crate) fn fewest(
    g: &mut Graph,
    links: &[LinkMotion],
    columns: &[WrenchColumn],
    fixed: &[Expr],
) -> Vec<(usize, usize, Expr)> {
    let mut choices = Choices::default();
    for column in columns {
        choices.add(g, links, column);
    }
    let Choices { places, forms: ways, start, groups } = choices;
    // The changes to try: all entries of an axis intersection change to the form by the twist; the entries of one link change to
    // the form by the twist, or to the form about the intersection.
    let mut moves: Vec<Vec<FormChange>> = Vec::new();
    for (group, entries) in &groups {
        let back = entries.iter().map(|&(entry, _)| (entry, 0)).collect();
        match group {
            FormGroup::Pole(_) => moves.push(back),
            FormGroup::AtLink(..) => moves.extend([back, entries.clone()]),
        }
    }
    let chosen = fewest_operations(g, fixed, &ways, start, &moves);
    places.iter().zip(ways.iter().zip(chosen)).map(|(&(row, column), (ways, way))| (row, column, ways[way])).collect()
}

impl Choices {
    fn add(&mut self, g: &mut Graph, links: &[LinkMotion], column: &WrenchColumn) {
        let (j, link) = (column.link, &links[column.link.0]);
        // The form of each entry by the twist: z . n + d . f.
        let mut entry_of = vec![None; link.jacobian.len()];
        for (k, twist) in link.jacobian.iter().enumerate() {
            let Some(Twist { z, d }) = *twist else { continue };
            let angular = dot(g, z, column.n);
            entry_of[k] = Some(self.places.len());
            self.places.push((k, column.place));
            self.forms.push(vec![plus_dot(g, angular, d, column.f)]);
            self.start.push(0);
        }
        // The form of an entry about an axis intersection: z . (n + c x f).
        for (p, pole) in link.poles.all.iter().enumerate() {
            let about = plus_cross(g, column.n, pole.lever, column.f);
            for k in (0..entry_of.len()).filter(|&k| link.poles.of[k] == Some(p)) {
                let (Some(entry), Some(Twist { z, d })) = (entry_of[k], link.jacobian[k]) else { continue };
                if d.iter().all(|d| d.is_zero()) {
                    continue;
                }
                let way = self.forms[entry].len();
                self.forms[entry].push(dot(g, z, about));
                self.start[entry] = way;
                for group in [FormGroup::Pole(pole.first), FormGroup::AtLink(j, pole.first)] {
                    self.groups.entry(group).or_default().push((entry, way));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::derivation::Derivation;
    use expr::{Function, Output, Tape};
    use random::SplitMix;

    /// Checks at a random state that the form by the twist and the form about an axis intersection give an entry the same value.
    /// The Stanford arm has a prismatic joint between axis intersection and link.
    #[test]
    fn both_ways_give_the_same_entry() {
        for file in ["ur5.yaml", "panda.yaml", "stanford.yaml"] {
            let path = format!("{}/../../models/{file}", env!("CARGO_MANIFEST_DIR"));
            let robot = robot::format::read(std::path::Path::new(&path)).unwrap();
            let mut derivation = Derivation::new(&robot).unwrap();
            let Derivation { graph: g, links, motion, .. } = &mut derivation;
            let mut choices = Choices::default();
            for j in robot.link_ids() {
                let U = links[j.0].angular_motion.U;
                let axis = [Expr::ONE, Expr::ZERO, Expr::ZERO];
                let n = plus_cross(g, [Expr::ZERO; 3], axis, links[j.0].a);
                choices.add(g, links, &WrenchColumn { place: 0, link: j, f: U.map(|row| row[0]), n });
            }
            assert_eq!(choices.forms.iter().map(Vec::len).max(), Some(2), "{file}");
            let entries: Vec<Expr> = choices.forms.concat();
            let output = Output { name: "y".into(), rows: entries.len(), columns: 1, entries };
            let tape = Tape::new(&Function::new("ways", g, motion.inputs(), vec![output]).bound());
            let mut random = SplitMix(43);
            let state: Vec<f64> = (0..tape.n_inputs()).map(|_| 2.0 * random.unit()).collect();
            let mut values = vec![f64::NAN; tape.n_outputs()];
            tape.evaluate(&state, &mut tape.workspace(), &mut values);
            let mut values = values.into_iter();
            for ways in &choices.forms {
                let ways: Vec<f64> = values.by_ref().take(ways.len()).collect();
                assert!(ways.iter().all(|way| (way - ways[0]).abs() < 1e-12), "{file}: {ways:?}");
            }
        }
    }
}
