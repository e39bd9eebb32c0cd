//! In which order windows take the rounds of a step.
//!
//! A round starts with a kick, which reads coordinates of neighbours, and goes on with what reads nothing of other sites. A window
//! takes a round as soon as its neighbours have taken the round before: a step goes over the system once, with all rounds of a
//! stretch while that is in the cache, whatever the number of rounds.

/// A round of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Turn {
    pub(super) round: usize,
    pub(super) window: usize,
}

/// All rounds of all windows, so that every window comes after its `neighbours`' round before.
pub(super) fn order(neighbours: &[Vec<usize>], rounds: usize) -> Vec<Turn> {
    let count = neighbours.len();
    let all: Vec<usize> = neighbours.iter().map(Vec::len).collect();
    // By round, how many neighbours have not taken the one before.
    let mut missing: Vec<Vec<usize>> = (1..rounds).map(|_| all.clone()).collect();
    let mut turns = Vec::with_capacity(rounds * count);
    for window in 0..count {
        let mut ready = vec![Turn { round: 0, window }];
        while let Some(turn) = ready.pop() {
            turns.push(turn);
            let Some(missing) = missing.get_mut(turn.round) else { continue };
            for &neighbour in &neighbours[turn.window] {
                missing[neighbour] -= 1;
                if missing[neighbour] == 0 {
                    ready.push(Turn { round: turn.round + 1, window: neighbour });
                }
            }
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_follow_their_neighbours() {
        let chain = |n: usize| (0..n).map(|k| (k.saturating_sub(1)..(k + 2).min(n)).collect()).collect();
        let ring = |n: usize| (0..n).map(|k| vec![k, (k + 1) % n, (k + n - 1) % n]).collect();
        let cases: [Vec<Vec<usize>>; 4] = [chain(1), chain(7), ring(3), ring(11)];
        for neighbours in cases {
            for rounds in 1..5 {
                let turns = order(&neighbours, rounds);
                assert_eq!(turns.len(), rounds * neighbours.len());
                for (at, turn) in turns.iter().enumerate() {
                    let earlier = &turns[..at];
                    assert!(!earlier.contains(turn));
                    let Some(round) = turn.round.checked_sub(1) else { continue };
                    for &window in &neighbours[turn.window] {
                        assert!(earlier.contains(&Turn { round, window }), "{turn:?} before {window}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_chain_is_gone_over_once() {
        let chain: Vec<Vec<usize>> =
            (0..50_usize).map(|k| (k.saturating_sub(1)..(k + 2).min(50)).collect()).collect();
        let turns = order(&chain, 4);
        for (at, turn) in turns.iter().enumerate() {
            let furthest = turns[..at].iter().map(|turn| turn.window).max().unwrap_or(0);
            assert!(furthest <= turn.window + 4, "{turn:?} when {furthest} was there");
        }
    }
}
