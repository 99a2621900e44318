//! Tests that `fill_many` (many samples at once, in SIMD lanes) gives the same bits as `fill` (one sample), for every compiled
//! robot and any number of samples. Both use the same fused multiply-adds.

use random::SplitMix;

/// All compiled robots; under Miri only those with at most three coordinates, since the others take hours.
fn robots() -> impl Iterator<Item = &'static generated::Compiled> {
    generated::all().iter().filter(|robot| !cfg!(miri) || robot.coordinates.len() <= 3)
}

#[test]
fn many_samples_equal_one_at_a_time() {
    for robot in robots() {
        let (n, size) = (robot.coordinates.len(), robot.coordinates.len() * robot.parameters.len());
        // 23 samples: two vectors of eight lanes, one of four, and a remainder of three, if the processor has both vector widths.
        for samples in [0, 1, 23] {
            let mut random = SplitMix(1);
            let states: Vec<f64> = (0..3 * n * samples)
                .map(|i| {
                    // Every fifth number is large, which tests all quadrants and the range reduction of the angles.
                    let scale = if i % 5 == 0 { 1e4 } else { 4.0 };
                    scale * random.unit()
                })
                .collect();
            let mut many = vec![f64::NAN; size * samples];
            assert!(robot.fill_many(&states, &mut many));
            for (s, y) in states.chunks_exact(3 * n).zip(many.chunks_exact(size)) {
                let mut one = vec![f64::NAN; size];
                assert!(robot.fill(&s[..n], &s[n..2 * n], &s[2 * n..], &mut one));
                let bits = |y: &[f64]| y.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
                assert_eq!(bits(y), bits(&one), "{}", robot.name);
            }
        }
    }
}

/// The nonzero entries, computed for one sample or for eight samples, equal the entries of the dense matrix. All other entries of
/// this matrix are zero.
#[test]
fn the_entries_are_those_of_the_matrix() {
    for robot in robots() {
        let (n, p) = (robot.coordinates.len(), robot.parameters.len());
        assert!(robot.non_zeros.is_sorted() && robot.non_zeros.iter().all(|(i, c)| *i < n && *c < p));
        let states: Vec<f64> = (0..3 * n * 8).map(|i| 3.0 * (1.0 + i as f64 * 0.7).sin()).collect();
        let mut eight = vec![generated::Eight::default(); robot.non_zeros.len()];
        assert!(robot.fill_eight(&states, &mut eight));
        for (l, s) in states.chunks_exact(3 * n).enumerate() {
            let mut y = vec![f64::NAN; n * p];
            let mut entries = vec![f64::NAN; robot.non_zeros.len()];
            assert!(robot.fill(&s[..n], &s[n..2 * n], &s[2 * n..], &mut y));
            assert!(robot.fill_non_zeros(&s[..n], &s[n..2 * n], &s[2 * n..], &mut entries));
            for ((x, eight), (i, c)) in entries.iter().zip(&eight).zip(robot.non_zeros) {
                let dense = std::mem::take(&mut y[i * p + c]);
                assert_eq!((x.to_bits(), eight.0[l].to_bits()), (dense.to_bits(), dense.to_bits()), "{}", robot.name);
            }
            assert!(y.iter().all(|y| *y == 0.0), "{}", robot.name);
        }
        assert!(!robot.fill_eight(&states[1..], &mut eight) && !robot.fill_eight(&states, &mut eight[1..]));
    }
}

#[test]
fn wrong_lengths_are_refused_and_nothing_is_written() {
    let robot = &generated::all()[0];
    let (n, size) = (robot.coordinates.len(), robot.coordinates.len() * robot.parameters.len());
    for (states, entries) in [(3 * n, size - 1), (3 * n - 1, size), (6 * n, size), (3 * n, 2 * size), (0, size)] {
        let mut y = vec![7.0; entries];
        assert!(!robot.fill_many(&vec![0.0; states], &mut y));
        assert!(y.iter().all(|y| *y == 7.0));
    }
}
