//! Writes the regrouping rules of all base parameters as text, expanded or nested.
//!
//! An expanded rule has only standard parameters: `XXR1 = XX1 - YY1 + cos(A)^2*(YY2 + YY3)`. A nested rule has the regrouped
//! parameters X^R of the next link. If D_d = sum_c f_dc D_c is the rule of a dropped parameter d,
//!
//! ```text
//! X^R_c = X_c + sum_d f_dc X^R_d
//! ```
//! for every parameter c, kept or dropped, so that `XXR1 = XX1 - YYR1`, `YYR1 = YY1 + cos(A)^2*YYR2` and so on outward
//! [Khalil, Dombre 2002, chapter 9]. A chain of n links has n such rules of bounded length. The length of expanded rules
//! grows faster than n^2 for oblique axes, and faster than any power of n for prismatic joints on them.

use std::collections::{BTreeMap, BTreeSet};

use expr::Graph;
use robot::{Inertial, Robot, StandardParameter};

use crate::base::coefficient::Coefficient;
use crate::base::regrouping::{Beta, Regrouping};
use crate::base::{names, rule};

/// Rules are written expanded if they have at most this many characters in total. The rules of a humanoid of 44 joints need a
/// third of this number.
const EXPANDED_RULES_CHARACTERS: usize = 200_000;
/// Largest total number of summands of expanded rules that a user requests. This number of summands gives about 30 MB of text.
const MAX_SUMMANDS: usize = 1_000_000;

/// The regrouping rules of all base parameters as text.
#[derive(Clone, Debug)]
pub struct Rules {
    /// The rule of each base parameter, in the order of [`crate::BaseParameters::base`]: `XXR2 = XX2 - YY2 - D2^2*(M3 + M4)`, or
    /// `XY2 = XY2` if nothing is absorbed.
    pub base: Vec<String>,
    /// The rules of the regrouped parameters that `base` names and that are no base parameters. Empty if the rules are expanded.
    pub regrouped: Vec<String>,
    /// The coefficient of each term of each base parameter, in the robot's symbols; a number if no closed form was found. Empty
    /// if the rules are nested.
    pub coefficients: Vec<Vec<String>>,
}

/// The data from which the regrouping rules are written.
#[derive(Clone, Debug)]
pub(crate) struct RuleSources {
    regrouping: Regrouping,
    /// Name of each standard parameter, such as `XX2`.
    names: Vec<String>,
    /// Kind (XX .. IA) of each standard parameter.
    inertials: Vec<Inertial>,
    /// A graph with only the constants of the robot. The graph gives the values and names of constants in coefficients.
    symbols: Graph,
    /// Name of a constant -> the names of the places in the file that use the constant, if there are several places
    /// ([`crate::kinematics::constants`]).
    places: BTreeMap<String, Vec<String>>,
    /// Index of the link of each standard parameter.
    links: Vec<usize>,
    /// Label of each link, and index of its antecedent (`None`: the base).
    labels: Vec<(String, Option<usize>)>,
}

/// Relations with every rule substituted: dropped column -> its kept columns and their coefficients.
type Expanded = BTreeMap<usize, Vec<(usize, Beta)>>;

impl RuleSources {
    pub(crate) fn new(
        regrouping: Regrouping,
        robot: &Robot,
        standard: &[StandardParameter],
        graph: &Graph,
        places: BTreeMap<String, Vec<String>>,
    ) -> RuleSources {
        RuleSources {
            places,
            links: standard.iter().map(|s| s.link.0).collect(),
            labels: robot.links.iter().map(|l| (l.label.clone(), l.antecedent.map(|i| i.0))).collect(),
            regrouping,
            names: standard.iter().map(|s| s.display(robot).to_string()).collect(),
            inertials: standard.iter().map(|s| s.inertial).collect(),
            symbols: Graph::with_symbols(graph.symbols().to_vec()),
        }
    }

    /// The rules as text, expanded if the expanded rules are short, otherwise nested. `kept`: the columns of the base
    /// parameters.
    pub(crate) fn short(&self, kept: &[usize]) -> Rules {
        // A summand needs at least five characters (` + M3`), but two summands may be merged into one. So rules with more
        // summands than half the allowed characters are certainly too long.
        let expanded = self.expand(EXPANDED_RULES_CHARACTERS / 2).map(|expanded| self.written(&expanded, kept));
        expanded
            .filter(|rules| rules.base.iter().map(String::len).sum::<usize>() <= EXPANDED_RULES_CHARACTERS)
            .unwrap_or_else(|| self.nested(kept))
    }

    /// The rules as text, expanded; `None` if the rules have more than [`MAX_SUMMANDS`] summands. `kept`: the columns of the
    /// base parameters.
    pub(crate) fn expanded(&self, kept: &[usize]) -> Option<Rules> {
        self.expand(MAX_SUMMANDS).map(|expanded| self.written(&expanded, kept))
    }

    /// Substitutes every rule into the rules that contain the column of this rule; `None` if there are more than `most`
    /// summands in total.
    fn expand(&self, most: usize) -> Option<Expanded> {
        let mut all = self.regrouping.solved.clone();
        let mut n_summands = 0;
        for (&dropped, terms) in &self.regrouping.rules {
            let mut row: BTreeMap<usize, Beta> = BTreeMap::new();
            for (c, factor) in terms {
                let own = [(*c, Beta::Exact(Coefficient::one()))];
                for (kept, beta) in all.get(c).map_or(&own[..], Vec::as_slice) {
                    let term = beta.times(factor, &self.symbols);
                    let sum = match row.remove(kept) {
                        None => term,
                        Some(before) => before.plus(&term, &self.symbols),
                    };
                    row.insert(*kept, sum);
                }
            }
            row.retain(|_, beta| !matches!(beta, Beta::Exact(c) if c.is_zero()));
            n_summands += row.values().map(Beta::n_summands).sum::<usize>();
            if n_summands > most {
                return None;
            }
            all.insert(dropped, row.into_iter().collect());
        }
        Some(all)
    }

    fn written(&self, expanded: &Expanded, kept: &[usize]) -> Rules {
        let mut by_kept: BTreeMap<usize, Vec<(usize, &Beta)>> = BTreeMap::new();
        for (&dropped, row) in expanded {
            for (kept, beta) in row {
                by_kept.entry(*kept).or_default().push((dropped, beta));
            }
        }
        let mut rules = Rules { base: Vec::new(), regrouped: Vec::new(), coefficients: Vec::new() };
        let names = ConstantNames::new(self);
        for &column in kept {
            let terms = by_kept.get(&column).map_or(&[][..], Vec::as_slice);
            let left = self.regrouped_name(column, !terms.is_empty());
            rules.base.push(self.text(&names, &left, column, terms, &|c| self.names[c].clone()));
            let coefficients = terms.iter().map(|(dropped, beta)| beta.text(&names.of(column, *dropped)));
            rules.coefficients.push([String::from("1")].into_iter().chain(coefficients).collect());
        }
        rules
    }

    /// The rules as text, nested: each names regrouped parameters of the next link. `kept`: the columns of the base parameters.
    pub(crate) fn nested(&self, kept: &[usize]) -> Rules {
        let direct: Vec<(usize, usize, Beta)> = {
            let tree = self
                .regrouping
                .rules
                .iter()
                .flat_map(|(&d, row)| row.iter().map(move |(c, factor)| (*c, d, Beta::Exact(factor.clone()))));
            let solved =
                self.regrouping.solved.iter().flat_map(|(&d, row)| row.iter().map(move |(c, b)| (*c, d, b.clone())));
            tree.chain(solved).collect()
        };
        let mut absorbed: BTreeMap<usize, Vec<(usize, &Beta)>> = BTreeMap::new();
        for (c, dropped, beta) in &direct {
            absorbed.entry(*c).or_default().push((*dropped, beta));
        }
        absorbed.values_mut().for_each(|terms| terms.sort_by_key(|t| t.0));

        let names = ConstantNames::new(self);
        let name = |c: usize| self.regrouped_name(c, absorbed.contains_key(&c));
        let rule = |c: &usize| {
            let terms = absorbed.get(c).map_or(&[][..], Vec::as_slice);
            self.text(&names, &name(*c), *c, terms, &|d| if d == *c { self.names[d].clone() } else { name(d) })
        };
        // Find the regrouped parameters that the base rules name, directly or through other rules.
        let mut wanted: BTreeSet<usize> = BTreeSet::new();
        let mut open: Vec<usize> = kept.to_vec();
        while let Some(c) = open.pop() {
            for (dropped, _) in absorbed.get(&c).into_iter().flatten() {
                if absorbed.contains_key(dropped) && wanted.insert(*dropped) {
                    open.push(*dropped);
                }
            }
        }
        Rules {
            base: kept.iter().map(rule).collect(),
            regrouped: wanted.iter().map(rule).collect(),
            coefficients: Vec::new(),
        }
    }

    fn text(
        &self,
        names: &ConstantNames,
        left: &str,
        own: usize,
        terms: &[(usize, &Beta)],
        name: &impl Fn(usize) -> String,
    ) -> String {
        let factors = |(dropped, beta): &(usize, &Beta)| {
            let factors = match beta {
                Beta::Exact(c) => rule::Factor::summands(c, &names.of(own, *dropped)),
                Beta::Number(x) => vec![rule::Factor::number(*x)],
            };
            let dropped = *dropped;
            factors.into_iter().map(move |factor| (dropped, factor))
        };
        let absorbed = terms.iter().flat_map(factors);
        let formula: Vec<_> = [(own, rule::Factor::one())].into_iter().chain(absorbed).collect();
        rule::text(left, &formula, name)
    }

    fn regrouped_name(&self, column: usize, absorbs: bool) -> String {
        let plain = &self.names[column];
        if absorbs { names::regrouped(plain, self.inertials[column]) } else { plain.clone() }
    }
}

/// The names that the robot's constants get in the rules.
struct ConstantNames<'a> {
    sources: &'a RuleSources,
    /// For constants that the file uses at several places: symbol -> link -> name of the constant at this link.
    own: BTreeMap<u32, BTreeMap<usize, &'a str>>,
}

impl<'a> ConstantNames<'a> {
    fn new(sources: &'a RuleSources) -> ConstantNames<'a> {
        let RuleSources { places, labels, symbols, .. } = sources;
        let links: BTreeMap<&str, usize> = labels.iter().enumerate().map(|(j, l)| (l.0.as_str(), j)).collect();
        let link = |place: &str| {
            let place = place.trim_end_matches('_');
            PLACE_LETTERS.iter().find_map(|letters| links.get(place.strip_prefix(letters)?).copied())
        };
        let own = symbols.symbols().iter().enumerate().filter_map(|(s, (name, _))| {
            let mut own = BTreeMap::new();
            for place in places.get(name)? {
                if let Some(link) = link(place) {
                    own.entry(link).or_insert(place.as_str());
                }
            }
            Some((s as u32, own))
        });
        ConstantNames { sources, own: own.collect() }
    }

    /// Gives the names of constants in one coefficient of a rule: the coefficient with which the parameter of column `kept`
    /// absorbs the parameter of column `dropped`. If the file uses a number at several places, the number is named after the
    /// place that lies on the path between the links of the two parameters. If several places lie on this path, the outermost
    /// place is taken.
    fn of(&self, kept: usize, dropped: usize) -> impl Fn(u32) -> String {
        let RuleSources { links, labels, symbols, .. } = self.sources;
        let (from, to) = (links[dropped], links[kept]);
        move |symbol| {
            let path = std::iter::successors(Some(from), |&j| labels[j].1).take_while(|&j| j != to);
            let own = self.own.get(&symbol).and_then(|own| path.into_iter().find_map(|j| own.get(&j).copied()));
            own.unwrap_or(&symbols.symbols()[symbol as usize].0).to_owned()
        }
    }
}

/// The letters with which the name of a place starts; the label of its link follows (`alpha5`).
const PLACE_LETTERS: [&str; 6] = ["gamma", "b", "alpha", "d", "theta", "r"];

impl Beta {
    fn plus(&self, other: &Beta, graph: &Graph) -> Beta {
        match (self, other) {
            (Beta::Exact(a), Beta::Exact(b)) => Beta::Exact(a.plus(b)),
            (a, b) => Beta::Number(a.number(graph) + b.number(graph)),
        }
    }

    fn times(&self, factor: &Coefficient, graph: &Graph) -> Beta {
        match self {
            Beta::Exact(c) => Beta::Exact(factor.times(c)),
            Beta::Number(x) => Beta::Number(factor.number(graph) * x),
        }
    }

    fn number(&self, graph: &Graph) -> f64 {
        match self {
            Beta::Exact(c) => c.number(graph),
            Beta::Number(x) => *x,
        }
    }

    fn n_summands(&self) -> usize {
        match self {
            Beta::Exact(c) => c.n_terms(),
            Beta::Number(_) => 1,
        }
    }

    fn text(&self, name: &dyn Fn(u32) -> String) -> String {
        match self {
            Beta::Exact(c) => c.display(name).to_string(),
            Beta::Number(x) => rule::rounded(*x).to_string(),
        }
    }
}
