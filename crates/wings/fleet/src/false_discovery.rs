//! Multiple tests with control of the false discovery rate.
//!
//! The false discovery rate is the expected share of false rejections among all rejections. q: the rate that is allowed. Of m
//! p-values, the k smallest are rejected; k is the largest number with p_(k) <= k q / m [Benjamini, Hochberg 1995], p_(k): the
//! k-th smallest. The adjusted value of a test is the smallest q at which it is rejected. The rule controls the rate q for
//! independent and for positively dependent tests. Estimates of one robot are approximately positively dependent, and so are
//! robots with a common reference. For any dependence, q must be divided by 1 + 1/2 + .. + 1/m [Benjamini, Yekutieli 2001], which
//! is eleven for 25 000 tests; this is not done, because it reduces the power too much. Measured rates are in docs/benchmarks.md.
//!
//! Tests are grouped in families; a family contains the parameters of one robot. The p-value of a family is the smallest adjusted
//! value in it [Simes 1986]: it tests the hypothesis that nothing in the family changed. If R of m families are rejected at q,
//! the tests within these are made at q R / m [Benjamini, Bogomolov 2014]. This controls the rate over families and the rate over
//! parameters in the rejected families. A rejected family has at least one rejected parameter.

/// The adjusted value of each test: the smallest false discovery rate at which it is rejected.
pub(crate) fn adjusted(p: &[f64]) -> Vec<f64> {
    let m = p.len();
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]).then(a.cmp(&b)));
    let mut out = vec![1.0; m];
    let mut least = 1.0_f64;
    for (k, &i) in order.iter().enumerate().rev() {
        least = least.min(p[i] * m as f64 / (k + 1) as f64);
        out[i] = least;
    }
    out
}

/// The test results of one family.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Family {
    /// p-value of the hypothesis that nothing in the family changed.
    pub p: f64,
    /// The smallest false discovery rate over families at which the family is rejected.
    pub adjusted: f64,
    /// Whether the hypothesis that nothing in the family changed is rejected.
    pub is_found: bool,
    /// Whether each test of the family is rejected.
    pub found: Vec<bool>,
}

/// Tests families of p-values such that both false discovery rates (of families, and of tests within them) are at most `rate`.
pub(crate) fn families(p: &[Vec<f64>], rate: f64) -> Vec<Family> {
    let within: Vec<Vec<f64>> = p.iter().map(|p| adjusted(p)).collect();
    let simes: Vec<f64> = within.iter().map(|q| q.iter().copied().fold(1.0, f64::min)).collect();
    let between = adjusted(&simes);
    let found = between.iter().filter(|&&q| q <= rate).count();
    let share = rate * found as f64 / p.len().max(1) as f64;
    let family = |i: usize| {
        let is_found = between[i] <= rate;
        let found = within[i].iter().map(|&q| is_found && q <= share).collect();
        Family { p: simes[i], adjusted: between[i], is_found, found }
    };
    (0..p.len()).map(family).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::behrens_fisher::two_sided_difference;
    use numerics::student::two_sided;
    use random::Random;

    /// The fifteen p-values in the example of [Benjamini, Hochberg 1995]: at 5 %, the four smallest are rejected.
    #[test]
    fn the_published_example() {
        let p = [
            0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262, 0.5719, 0.6528,
            0.7590, 1.0,
        ];
        let adjusted = adjusted(&p);
        assert_eq!(adjusted.iter().filter(|&&q| q <= 0.05).count(), 4);
        assert!((adjusted[0] - 0.0015).abs() < 1e-12 && adjusted[14] == 1.0);
    }

    /// Families of normal errors; in one of ten families, some values changed by five standard deviations. Both false discovery
    /// rates must be at most the given rate, also for dependent tests and for families with a common reference.
    #[test]
    fn the_rate_is_held() {
        let mut random = Random::new(4);
        for shared in [0.0, 0.5] {
            let (runs, mut of_families, mut of_questions, mut missed) = (60, 0.0, 0.0, 0);
            for _ in 0..runs {
                let reference: Vec<f64> = (0..20).map(|_| random.normal()).collect();
                let p: Vec<Vec<f64>> = (0..100)
                    .map(|i| {
                        let own = random.normal();
                        let error = |c: usize, random: &mut Random| {
                            let alone = f64::sqrt(0.5) * (own + random.normal());
                            f64::sqrt(shared) * reference[c] + f64::sqrt(1.0 - shared) * alone
                        };
                        let moved = |c: usize| if i < 10 && c < 4 { 5.0 } else { 0.0 };
                        (0..20).map(|c| two_sided(error(c, &mut random) + moved(c), 1e9)).collect()
                    })
                    .collect();
                let found = families(&p, 0.05);
                let yes = found.iter().filter(|f| f.is_found).count();
                let wrong = found.iter().skip(10).filter(|f| f.is_found).count();
                let questions = |f: &Family| f.found.iter().filter(|f| **f).count();
                let all: usize = found.iter().map(questions).sum();
                let right: usize = found.iter().take(10).map(|f| f.found[..4].iter().filter(|f| **f).count()).sum();
                of_families += wrong as f64 / yes.max(1) as f64 / f64::from(runs);
                of_questions += (all - right) as f64 / all.max(1) as f64 / f64::from(runs);
                missed += 10 - (yes - wrong);
                assert!(found.iter().all(|f| f.is_found == (questions(f) > 0)));
            }
            // 5 % are expected. In one run, the share has a standard deviation of 7 %; the mean of 60 runs has 1 %. The limit
            // is 5 % plus three times this 1 %.
            assert!(of_families < 0.08 && of_questions < 0.08, "{shared}: {of_families} {of_questions}");
            assert!(missed < 60, "{shared}: {missed} of 600 families missed");
        }
    }

    /// Two shares over `count` fleets: unchanged robots among the rejected robots (mean), and rejected robots among the changed
    /// robots.
    ///
    /// Fleets of 500 robots with 16 logs each are compared with a reference of 64 logs. The standard deviations have 13 and 60
    /// degrees of freedom. In 25 robots, one of 24 parameters changed by `moved`.
    fn fleets(count: usize, moved: f64) -> (f64, f64) {
        let (mut random, robots, changed, parameters) = (Random::new(9), 500, 25, 24);
        let mut deviation = |variance: f64, freedom: usize| {
            let square = (0..freedom).map(|_| random.normal().powi(2)).sum::<f64>();
            (random.normal() * variance.sqrt(), (variance * square / freedom as f64).sqrt())
        };
        let (mut wrong, mut right) = (0.0, 0);
        for _ in 0..count {
            let reference: Vec<(f64, f64)> = (0..parameters).map(|_| deviation(0.2, 60)).collect();
            let mut p = |robot: usize, c: usize| {
                let ((a, s), (b, r)) = (deviation(0.8, 13), reference[c]);
                let d = a - b + if robot < changed && c == robot % parameters { moved } else { 0.0 };
                // A normal variable exceeds 1.8 standard deviations in one of fourteen cases. A smaller difference is never
                // rejected at the rates used here, so its p need not be computed.
                if d.abs() < 1.8 * s.hypot(r) { 1.0 } else { two_sided_difference(d, (s, 13.0), (r, 60.0)) }
            };
            let p: Vec<Vec<f64>> = (0..robots).map(|i| (0..parameters).map(|c| p(i, c)).collect()).collect();
            let found = families(&p, 0.05);
            let yes = found.iter().filter(|f| f.is_found).count();
            let of_changed = found[..changed].iter().filter(|f| f.is_found).count();
            wrong += (yes - of_changed) as f64 / yes.max(1) as f64 / count as f64;
            right += of_changed;
        }
        (wrong, right as f64 / (count * changed) as f64)
    }

    #[test]
    fn the_rate_is_held_where_deviations_are_estimated() {
        // In one fleet, the share has a standard deviation of 4 %; the mean of 60 fleets has 0.5 %. The limit is 5 % plus this
        // 0.5 %. With Welch's degrees of freedom, the mean would be 7.1 %.
        let (wrong, power) = fleets(60, 8.0);
        assert!(wrong < 0.055 && power > 0.9, "{wrong} {power}");
        let (_, power) = fleets(5, 2.0);
        assert!(power < 0.05, "{power}");
    }

    #[test]
    fn nothing_is_found_in_nothing() {
        assert!(families(&[], 0.05).is_empty());
        let found = families(&[vec![], vec![0.5, 1.0]], 0.05);
        assert!(found.iter().all(|f| !f.is_found && f.found.iter().all(|f| !f)));
    }
}
