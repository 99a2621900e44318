//! Suggests the valid word that is nearest to a mistyped word.

/// Number of characters of the longest word for which a suggestion is searched. A longer word is hardly a typing error, and the
/// time for a distance grows with the length.
const LONGEST_WORD_CHARS: usize = 64;
/// Length of the longest candidate that is compared, bytes.
const LONGEST_CANDIDATE_BYTES: usize = 256;

/// The least number of insertions, deletions, substitutions and swaps of neighbours that turn `a` into `b`. Case is ignored.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.to_lowercase().chars().collect(), b.to_lowercase().chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = match (i, j) {
                (i, 0) => i,
                (0, j) => j,
                (i, j) => {
                    let changed = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                    let best = changed.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
                    let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                    if swapped { best.min(rows[i - 2][j - 2] + 1) } else { best }
                }
            };
        }
    }
    rows[a.len()][b.len()]
}

/// The candidate nearest to `word`. `None` if its distance is above about a third of the length of the longer of the two words.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if word.chars().count() > LONGEST_WORD_CHARS {
        return None;
    }
    let near = |c: &str| (word.chars().count().max(c.chars().count()) + 1) / 3;
    let scored = candidates.into_iter().filter(|c| c.len() <= LONGEST_CANDIDATE_BYTES).map(|c| (distance(word, c), c));
    scored.filter(|(d, c)| *d <= near(c)).min_by_key(|(d, _)| *d).map(|(_, c)| c)
}

/// The text ` (did you mean ...?)` with the nearest candidate; empty if there is none.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, candidates).map_or(String::new(), |c| format!(" (did you mean `{c}`?)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_word_that_was_meant() {
        let keys = ["antecedent", "alpha", "theta", "gamma", "d"];
        assert_eq!(nearest("antecedant", keys), Some("antecedent"));
        assert_eq!(nearest("aplha", keys), Some("alpha"));
        assert_eq!(nearest("Theta", keys), Some("theta"));
        assert_eq!(nearest("colour", keys), None);
        assert_eq!(nearest("a", keys), None);
        assert_eq!(nearest(&"x".repeat(100_000), keys), None);
    }
}
