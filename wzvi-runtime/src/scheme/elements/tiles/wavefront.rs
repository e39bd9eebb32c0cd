//! The order in which tiles take the rounds of a step.
//!
//! A round starts with a kick, which reads coordinates of neighbours; its other parts act on single sites. A
//! tile takes a round as soon as its neighbours have taken the previous one. A step thus passes over the
//! system once, and takes all rounds of a tile while that is in the cache, whatever the number of rounds.

use std::ops::Range;

/// A round of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TileRound {
    pub(super) round: usize,
    pub(super) tile_index: usize,
}

/// The rounds after those `taken` that `tiles` can take without other tiles, each after the previous
/// round of its neighbours. A tile begins when those before it have gone as far as they can.
pub(super) fn wavefront(
    neighbours: &[Vec<usize>],
    rounds: usize,
    tiles: Range<usize>,
    taken: &mut [usize],
) -> Vec<TileRound> {
    let mut tile_rounds = Vec::new();
    for first in tiles.clone() {
        let mut next = vec![first];
        while let Some(tile_index) = next.pop() {
            let round = taken[tile_index];
            let is_next = round < rounds && (round > 0 || tile_index == first);
            let has = |&neighbour: &usize| tiles.contains(&neighbour) && taken[neighbour] >= round;
            if is_next && (round == 0 || neighbours[tile_index].iter().all(has)) {
                tile_rounds.push(TileRound { round, tile_index });
                taken[tile_index] += 1;
                next.extend(&neighbours[tile_index]);
            }
        }
    }
    tile_rounds
}

/// All rounds of all tiles: those that each share takes alone, concurrently with the others, and then the
/// rest, of tiles at the borders of shares.
pub(super) fn divided(
    neighbours: &[Vec<usize>],
    rounds: usize,
    shares: &[Range<usize>],
) -> (Vec<Vec<TileRound>>, Vec<TileRound>) {
    let mut taken = vec![0; neighbours.len()];
    let own = shares.iter().map(|share| wavefront(neighbours, rounds, share.clone(), &mut taken)).collect();
    let rest = wavefront(neighbours, rounds, 0..neighbours.len(), &mut taken);
    (own, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(tiles: usize, reach: usize) -> Vec<Vec<usize>> {
        (0..tiles).map(|k| (k.saturating_sub(reach)..(k + reach + 1).min(tiles)).collect()).collect()
    }

    fn ring(tiles: usize) -> Vec<Vec<usize>> {
        (0..tiles).map(|k| vec![k, (k + 1) % tiles, (k + tiles - 1) % tiles]).collect()
    }

    #[test]
    fn tiles_follow_their_neighbours() {
        for neighbours in [chain(1, 1), chain(7, 1), chain(23, 3), ring(3), ring(11)] {
            let all = neighbours.len();
            for (rounds, parts) in (1..5).flat_map(|rounds| (1..6).map(move |parts| (rounds, parts))) {
                let shares: Vec<_> = (0..parts).map(|k| all * k / parts..all * (k + 1) / parts).collect();
                let (own, rest) = divided(&neighbours, rounds, &shares);
                let follow = |earlier: &[TileRound], tile_round: &TileRound, share: Option<&Range<usize>>| {
                    assert!(!earlier.contains(tile_round));
                    assert!(share.is_none_or(|share| share.contains(&tile_round.tile_index)));
                    let Some(round) = tile_round.round.checked_sub(1) else { return };
                    for &tile_index in &neighbours[tile_round.tile_index] {
                        assert!(
                            earlier.contains(&TileRound { round, tile_index }),
                            "{tile_round:?} before {tile_index}"
                        );
                    }
                };
                for (own, share) in own.iter().zip(&shares) {
                    own.iter()
                        .enumerate()
                        .for_each(|(at, tile_round)| follow(&own[..at], tile_round, Some(share)));
                }
                let tile_rounds: Vec<TileRound> =
                    own.into_iter().flatten().chain(rest.iter().copied()).collect();
                assert_eq!(tile_rounds.len(), rounds * all);
                for at in tile_rounds.len() - rest.len()..tile_rounds.len() {
                    follow(&tile_rounds[..at], &tile_rounds[at], None);
                }
            }
        }
    }

    #[test]
    fn a_chain_is_gone_over_once() {
        let tile_rounds = wavefront(&chain(50, 1), 4, 0..50, &mut [0; 50]);
        assert_eq!(tile_rounds.len(), 200);
        for (at, tile_round) in tile_rounds.iter().enumerate() {
            let furthest =
                tile_rounds[..at].iter().map(|tile_round| tile_round.tile_index).max().unwrap_or(0);
            assert!(furthest <= tile_round.tile_index + 4, "{tile_round:?} when {furthest} was there");
        }
    }

    #[test]
    fn little_is_left_at_borders() {
        let (own, rest) = divided(&chain(100, 1), 3, &[0..50, 50..100]);
        assert_eq!((own[0].len(), own[1].len(), rest.len()), (147, 147, 6));
    }
}
