//! The order in which windows take the rounds of a step.
//!
//! A round starts with a kick, which reads coordinates of neighbours; its other moves act on single sites. A
//! window takes a round as soon as its neighbours have taken the previous one. A step thus passes over the
//! system once, and takes all rounds of a stretch while that is in the cache, whatever the number of rounds.

use std::ops::Range;

/// A round of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Turn {
    pub(super) round: usize,
    pub(super) window: usize,
}

/// The rounds after those `taken` that `windows` can take without other windows, each after the previous
/// round of its neighbours. A window begins when those before it have gone as far as they can.
pub(super) fn order(
    neighbours: &[Vec<usize>],
    rounds: usize,
    windows: Range<usize>,
    taken: &mut [usize],
) -> Vec<Turn> {
    let mut turns = Vec::new();
    for first in windows.clone() {
        let mut next = vec![first];
        while let Some(window) = next.pop() {
            let round = taken[window];
            let is_next = round < rounds && (round > 0 || window == first);
            let has = |&neighbour: &usize| windows.contains(&neighbour) && taken[neighbour] >= round;
            if is_next && (round == 0 || neighbours[window].iter().all(has)) {
                turns.push(Turn { round, window });
                taken[window] += 1;
                next.extend(&neighbours[window]);
            }
        }
    }
    turns
}

/// All rounds of all windows: those that each share takes alone, concurrently with the others, and then the
/// rest, of windows at the borders of shares.
pub(super) fn divided(
    neighbours: &[Vec<usize>],
    rounds: usize,
    shares: &[Range<usize>],
) -> (Vec<Vec<Turn>>, Vec<Turn>) {
    let mut taken = vec![0; neighbours.len()];
    let own = shares.iter().map(|share| order(neighbours, rounds, share.clone(), &mut taken)).collect();
    let rest = order(neighbours, rounds, 0..neighbours.len(), &mut taken);
    (own, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(windows: usize, reach: usize) -> Vec<Vec<usize>> {
        (0..windows).map(|k| (k.saturating_sub(reach)..(k + reach + 1).min(windows)).collect()).collect()
    }

    fn ring(windows: usize) -> Vec<Vec<usize>> {
        (0..windows).map(|k| vec![k, (k + 1) % windows, (k + windows - 1) % windows]).collect()
    }

    #[test]
    fn windows_follow_their_neighbours() {
        for neighbours in [chain(1, 1), chain(7, 1), chain(23, 3), ring(3), ring(11)] {
            let all = neighbours.len();
            for (rounds, parts) in (1..5).flat_map(|rounds| (1..6).map(move |parts| (rounds, parts))) {
                let shares: Vec<_> = (0..parts).map(|k| all * k / parts..all * (k + 1) / parts).collect();
                let (own, rest) = divided(&neighbours, rounds, &shares);
                let follow = |earlier: &[Turn], turn: &Turn, share: Option<&Range<usize>>| {
                    assert!(!earlier.contains(turn));
                    assert!(share.is_none_or(|share| share.contains(&turn.window)));
                    let Some(round) = turn.round.checked_sub(1) else { return };
                    for &window in &neighbours[turn.window] {
                        assert!(earlier.contains(&Turn { round, window }), "{turn:?} before {window}");
                    }
                };
                for (own, share) in own.iter().zip(&shares) {
                    own.iter().enumerate().for_each(|(at, turn)| follow(&own[..at], turn, Some(share)));
                }
                let turns: Vec<Turn> = own.into_iter().flatten().chain(rest.iter().copied()).collect();
                assert_eq!(turns.len(), rounds * all);
                for at in turns.len() - rest.len()..turns.len() {
                    follow(&turns[..at], &turns[at], None);
                }
            }
        }
    }

    #[test]
    fn a_chain_is_gone_over_once() {
        let turns = order(&chain(50, 1), 4, 0..50, &mut [0; 50]);
        assert_eq!(turns.len(), 200);
        for (at, turn) in turns.iter().enumerate() {
            let furthest = turns[..at].iter().map(|turn| turn.window).max().unwrap_or(0);
            assert!(furthest <= turn.window + 4, "{turn:?} when {furthest} was there");
        }
    }

    #[test]
    fn little_is_left_at_borders() {
        let (own, rest) = divided(&chain(100, 1), 3, &[0..50, 50..100]);
        assert_eq!((own[0].len(), own[1].len(), rest.len()), (147, 147, 6));
    }
}
