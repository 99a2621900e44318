//! Tests of the exact number of base parameters (rank) of robots whose loops are solved numerically. The rank is computed in a
//! finite field, at points at which the loops are closed.

use modeling::{BaseParameters, ExactRank, NoCertificate, UnclearRank};
use robot::format;
use tests::loops::{BY_CHANCE, LOOPS, resized, with_loops};
use tests::random::Random;
use tests::{base_parameters, derived, evaluated, try_base_parameters};

fn exact_base(name: &str) -> BaseParameters {
    base_parameters(&with_loops(name))
}

/// For each base parameter: its column of the regressor, and the standard parameters that it contains.
fn structure(base: &BaseParameters) -> Vec<(usize, Vec<usize>)> {
    base.base.iter().map(|b| (b.column, b.terms.iter().map(|t| t.parameter).collect())).collect()
}

#[test]
fn the_exact_rank_is_that_of_the_numbers_or_there_is_a_reason() {
    for (name, count, is_exact) in LOOPS {
        let base = exact_base(name);
        let rank = base.rank;
        assert_eq!(base.len(), count, "{name}: {rank:?}");
        assert_eq!(rank.exact.rank(), is_exact.then_some(count), "{name}: {rank:?}");
        if is_exact {
            // If the rank is exact, every relation between columns is proven for all robots of this structure; its coefficients
            // are symbolic or numeric.
            assert!(matches!(rank.exact, ExactRank::Closed { .. }) && rank.numeric_relations == 0, "{name}: {rank:?}");
        }
    }
    // In linkages that consist of dyads, the coefficients are products of powers of lengths. So no relation needs a numeric
    // coefficient.
    for name in ["four_bar", "crossed_four_bar", "boom", "whitworth", "stephenson", "four_bars_in_series"] {
        assert_eq!(exact_base(name).rank.general_relations, 0, "{name}");
    }
    let rules = exact_base("four_bar").rules().base;
    assert!(rules.iter().any(|rule| rule == "ZZR2 = ZZ2 + L2^2/L3*MX3"), "{rules:?}");
    let reason = |name: &str| exact_base(name).rank.exact.reason();
    assert_eq!(reason("sarrus"), Some(NoCertificate::EqualLengths));
    assert_eq!(reason("bricard"), Some(NoCertificate::Overconstrained));
}

/// An exact rank holds for almost all robots of a structure. So robots with random lengths must have the same rank and relations.
#[test]
fn columns_and_relations_are_those_of_other_lengths() {
    for (name, count, is_exact) in LOOPS {
        if !is_exact {
            continue;
        }
        let given = exact_base(name);
        let expected = structure(&given);
        for seed in 0..if count > 100 { 1 } else { 2 } {
            // The change of the lengths is small, so that the loops still close near the start configuration.
            let other = resized(&with_loops(name), 0.03, &mut Random(seed));
            let base = base_parameters(&other);
            assert_eq!(base.len(), count, "{name}");
            assert_eq!(structure(&base), expected, "{name}");
            if given.rank.general_relations == 0 {
                assert_eq!(base.rules().base, given.rules().base, "{name}");
            }
        }
    }
}

#[test]
fn the_base_parameters_lose_nothing_at_other_states() {
    for (name, ..) in LOOPS {
        let robot = with_loops(name);
        let (derivation, regressor, base) = derived(&robot);
        let base_regressor = base.regressor(&regressor);
        let mut closure = derivation.closure().unwrap();
        let (n, p) = (robot.n_coordinates(), base.standard.len());
        let random = &mut Random(7);
        let x = random.vector(p, 1.0);
        let x_base = base.values(&x);
        let (origin, _) = closure.find_origin(n).unwrap();
        let mut found = 0;
        for _ in 0..20 {
            let q: Vec<f64> = origin.iter().map(|q| q + 0.15 * random.unit()).collect();
            let Ok(passive) = closure.passive(&q) else { continue };
            let inputs = [q, passive, random.vector(n, 2.0), random.vector(n, 4.0)].concat();
            let (d, d_base) = (evaluated(&regressor, &[&inputs]), evaluated(&base_regressor, &[&inputs]));
            let product = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
            let largest = d.iter().fold(1.0, |largest: f64, y| largest.max(y.abs()));
            for (row, base_row) in d.chunks(p).zip(d_base.chunks(x_base.len())) {
                let apart = (product(row, &x) - product(base_row, &x_base)).abs();
                // Numeric coefficients have the rounding error of the rank computation. It is larger if a column is nearly
                // dependent (1e-5).
                assert!(apart < 1e-7 * largest, "{name}: {apart:e} of {largest:e}");
            }
            found += 1;
        }
        assert!(found >= 5, "{name}: the loops closed at {found} states");
    }
}

#[test]
fn lengths_that_are_equal_by_chance_are_refused() {
    let robot = format::read_yaml(BY_CHANCE, "by_chance.yaml").unwrap();
    let refused = try_base_parameters(&robot).err();
    let Some(UnclearRank::Coincident { numeric, exact, only_exact }) = refused else { panic!("{refused:?}") };
    assert_eq!((numeric, exact, only_exact.len()), (3, 8, 5));
    // If the lengths are only almost equal, the parallelogram becomes an ordinary four-bar.
    let near = BY_CHANCE.replace("L2: 0.5,", "L2: 0.52,");
    let near = base_parameters(&format::read_yaml(&near, "near.yaml").unwrap());
    assert_eq!((near.len(), near.rank.exact.rank()), (8, Some(8)));
}

/// A linkage can be assembled in different ways (crossed, uncrossed), and these can have different ranks. The exact rank belongs
/// to the assembly at the start configuration.
#[test]
fn another_assembly_may_have_another_rank() {
    let other = |name: &str| match exact_base(name).rank.exact {
        ExactRank::Closed { other_assemblies, .. } => other_assemblies,
        exact => panic!("{name}: {exact}"),
    };
    assert!(other("crossed_four_bar"));
    assert!(!other("four_bar"));
    let text = exact_base("crossed_four_bar").rank.exact.to_string();
    assert!(text.contains("other assemblies"), "{text}");
}
