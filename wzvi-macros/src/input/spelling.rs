//! Suggestions for misspelled names.

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

/// Levenshtein distance, with long names cut.
fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().take(64).collect();
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        let mut next = vec![left];
        for (y, &above) in b.iter().zip(&row[1..]) {
            left = (left + 1).min(above + 1).min(diagonal + usize::from(x != y));
            diagonal = above;
            next.push(left);
        }
        row = next;
    }
    row.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found() {
        let known = ["drift", "noise", "embedding", "invariant"];
        assert_eq!(closest("embeding", known), Some("embedding"));
        assert_eq!(closest("Drfit", known), Some("drift").filter(|_| distance("drfit", "drift") <= 1));
        assert_eq!(closest("potential", known), None);
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
