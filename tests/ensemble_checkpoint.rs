//! Checkpoints of ensembles: a run that is stopped at any moment goes on bit for bit, and no file is misread.

#![cfg(feature = "ensemble")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first error")]

mod ensemble_checkpoint {
    mod damage;
    mod killed;
    mod other_run;
    mod resume;
    mod systems;
}
