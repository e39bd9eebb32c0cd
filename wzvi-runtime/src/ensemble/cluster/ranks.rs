//! Actions of all ranks together: agree, compare, and end.

use mpi::traits::{Communicator, CommunicatorCollectives, Root};

use crate::trajectory::Error;
use crate::trajectory::error::ClusterError;

/// The exit code of a process that panics.
const PANICKED: i32 = 101;

/// Ends the processes of all ranks if this one panics: the others would wait for it.
pub(super) struct AbortOnPanic<'w, C: Communicator>(pub(super) &'w C);

impl<C: Communicator> Drop for AbortOnPanic<'_, C> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            end_all(self.0, "it panicked");
        }
    }
}

/// Ends the processes of all ranks, for a reason.
pub(super) fn end_all<C: Communicator>(world: &C, why: &str) -> ! {
    eprintln!(
        "wzvi: rank {} of {} ends the run on all ranks: {why}. With a checkpoint, start the same program again to go on.",
        world.rank(),
        world.size()
    );
    world.abort(PANICKED)
}

/// Succeeds where all ranks do: fails on the others, too, with what the first one says that failed.
pub(super) fn agree<C: Communicator, T>(world: &C, outcome: Result<T, Error>) -> Result<T, Error> {
    let mut failed = vec![0_u8; world.size().unsigned_abs() as usize];
    world.all_gather_into(&u8::from(outcome.is_err()), &mut failed[..]);
    let Some(first) = (0..).zip(&failed).find_map(|(rank, &failed)| (failed != 0).then_some(rank)) else {
        return outcome;
    };
    let said = outcome.as_ref().err().map(ToString::to_string);
    let cause = share(world, first, said.unwrap_or_default());
    outcome.and_then(|_| Err(ClusterError::Rank { rank: first, cause }.into()))
}

/// Whether all ranks have the lines of rank 0, up to as many as there are.
pub(super) fn same<C: Communicator>(world: &C, lines: &[String]) -> Result<(), Error> {
    let theirs = share(world, 0, lines.join("\n"));
    let rank = world.rank();
    let ours = lines.iter().map(String::as_str).map(Some).chain([None]);
    let differing =
        theirs.split('\n').map(Some).chain([None]).zip(ours).find(|(theirs, ours)| theirs != ours);
    let outcome = match differing {
        None => Ok(()),
        Some((theirs, ours)) => {
            let [theirs, ours] = [theirs, ours].map(|line| line.unwrap_or("nothing"));
            Err(ClusterError::Settings { rank, difference: format!("{ours}; there {theirs}") }.into())
        }
    };
    agree(world, outcome)
}

/// The text that rank `root` has.
fn share<C: Communicator>(world: &C, root: i32, text: String) -> String {
    let root = world.process_at_rank(root);
    let mut bytes = text.into_bytes();
    let mut length = bytes.len() as u64;
    root.broadcast_into(&mut length);
    bytes.resize(usize::try_from(length).unwrap_or_default(), 0);
    root.broadcast_into(&mut bytes[..]);
    String::from_utf8_lossy(&bytes).into_owned()
}
