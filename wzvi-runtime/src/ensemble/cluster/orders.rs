//! Messages between rank 0 and the others.
//!
//! Rank 0 must be able to go on without a rank that has stalled, and that rank to end when it wakes up. So
//! nobody sends what the other one may never receive: results that are more than a few words are announced,
//! and sent when rank 0 asks for them; it then receives them whatever happens ([`Orders::abandon`]). All
//! other messages are so short that they are sent at once.

use mpi::point_to_point::{Message, Status};
use mpi::request::StaticScope;
use mpi::traits::{Communicator, Destination, MatchedReceiveVec, Source};

use crate::trajectory::error::ClusterError;

/// To a rank: the first and the last number of a batch.
const BATCH: i32 = 1;
/// To a rank: the results that it announced are to be sent.
const SEND: i32 = 2;
/// To a rank: there is no more to do; why, if the run failed.
const END: i32 = 3;
/// To rank 0: the number of words of results.
const ANNOUNCED: i32 = 4;
/// To rank 0: the words of results.
const RESULTS: i32 = 5;

/// Words of a message that MPI sends at once, whatever the receiver is doing: below the limits of all
/// libraries.
const FEW_WORDS: usize = 128;
/// Bytes of a text, likewise.
const FEW_BYTES: usize = 1000;

/// A message of rank 0.
pub(super) enum Order {
    Batch(u64, u64),
    Send,
    End(Option<String>),
}

/// A message of another rank.
pub(super) enum Answer {
    Announced(usize),
    Results(Vec<u64>),
}

/// The end of rank 0.
pub(super) struct Orders<'w, C>(pub(super) &'w C);

impl<C: Communicator> Orders<'_, C> {
    pub(super) fn batch(&self, rank: i32, first: u64, end: u64) {
        self.0.process_at_rank(rank).send_with_tag(&[first, end][..], BATCH);
    }

    pub(super) fn send(&self, rank: i32) {
        let nothing: &[u64] = &[];
        self.0.process_at_rank(rank).send_with_tag(nothing, SEND);
    }

    /// Ends the work of all ranks, with the reason if the run failed.
    pub(super) fn end(&self, failure: Option<&str>) {
        let bytes = failure.unwrap_or_default().as_bytes();
        let bytes = &bytes[..bytes.len().min(FEW_BYTES)];
        for rank in 1..self.0.size() {
            self.0.process_at_rank(rank).send_with_tag(bytes, END);
        }
    }

    /// The next answer that is there, and whose it is.
    pub(super) fn answer(&self) -> Result<Option<(i32, Answer)>, ClusterError> {
        let Some(found) = self.0.any_process().immediate_matched_probe() else { return Ok(None) };
        let (rank, tag) = (found.1.source_rank(), found.1.tag());
        let words: Vec<u64> = found.matched_receive_vec().0;
        let answer = match (tag, &words[..]) {
            (ANNOUNCED, &[length]) => usize::try_from(length).ok().map(Answer::Announced),
            (RESULTS, _) => Some(Answer::Results(words)),
            _ => None,
        };
        answer.map(|answer| Some((rank, answer))).ok_or(ClusterError::Message { rank })
    }

    /// Lets MPI receive what a rank was asked to send and nobody waits for any more: else it would wait for
    /// us in turn. The memory is MPI's from then on.
    pub(super) fn abandon(&self, rank: i32, words: usize) {
        let buffer = Box::leak(vec![0_u64; words].into_boxed_slice());
        let request =
            self.0.process_at_rank(rank).immediate_receive_into_with_tag(StaticScope, buffer, RESULTS);
        std::mem::forget(request);
    }
}

/// The end of another rank.
pub(super) struct Answers<'w, C>(pub(super) &'w C);

impl<C: Communicator> Answers<'_, C> {
    /// The next order, if there is one.
    pub(super) fn order(&self) -> Option<Order> {
        let found: (Message, Status) = self.0.process_at_rank(0).immediate_matched_probe()?;
        match found.1.tag() {
            BATCH => match found.matched_receive_vec::<u64>().0[..] {
                [first, end] => Some(Order::Batch(first, end)),
                _ => Some(Order::End(Some("it sent a batch without two numbers".to_owned()))),
            },
            SEND => {
                let _: Vec<u64> = found.matched_receive_vec().0;
                Some(Order::Send)
            }
            _ => {
                let text = found.matched_receive_vec::<u8>().0;
                let text = String::from_utf8_lossy(&text).into_owned();
                Some(Order::End((!text.is_empty()).then_some(text)))
            }
        }
    }

    /// Sends results at once if they are short, else announces them; gives them back in that case.
    pub(super) fn offer(&self, words: Vec<u64>) -> Option<Vec<u64>> {
        if words.len() <= FEW_WORDS {
            self.results(&words);
            return None;
        }
        self.0.process_at_rank(0).send_with_tag(&[words.len() as u64][..], ANNOUNCED);
        Some(words)
    }

    pub(super) fn results(&self, words: &[u64]) {
        self.0.process_at_rank(0).send_with_tag(words, RESULTS);
    }
}
