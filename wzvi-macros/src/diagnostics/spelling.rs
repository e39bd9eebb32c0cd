//! Spelling: the user's tokens as text, and suggestions for misspelled names.

use quote::ToTokens;

/// The candidate nearest to `name`, if it is near enough to be what was meant.
pub(crate) fn closest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    candidates
        .into_iter()
        .map(|candidate| (distance(&name, &candidate.to_lowercase()), candidate))
        .filter(|&(distance, candidate)| distance <= allowed(candidate))
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// One mistake per three letters.
fn allowed(candidate: &str) -> usize {
    candidate.chars().count() / 3
}

/// Number of letters inserted, removed, replaced or swapped with their neighbour; long names are cut.
fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().take(64).collect();
    let b: Vec<char> = b.chars().take(64).collect();
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replaced = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replaced.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

/// The tokens as a user would write them, on one line: without the spaces that a token stream prints.
pub(crate) fn source(tokens: &impl ToTokens) -> String {
    let spaced = tokens.to_token_stream().to_string();
    let mut text = String::with_capacity(spaced.len());
    for (i, part) in spaced.split_whitespace().enumerate() {
        let tight = |part: &str, ends: &str| part.chars().next().is_some_and(|c| ends.contains(c));
        let after = text.chars().last().is_some_and(|c| "<[(&:.".contains(c));
        if i > 0 && !after && !tight(part, "<>[](),;:.") {
            text.push(' ');
        }
        text.push_str(part);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found() {
        let known = ["drift", "noise", "embedding", "invariant"];
        assert_eq!(closest("embeding", known), Some("embedding"));
        assert_eq!(closest("Drfit", known), Some("drift"));
        assert_eq!(closest("potential", known), None);
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
