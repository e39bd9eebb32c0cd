//! Checkpoints: a run that is stopped at any moment goes on bit for bit, and no file is misread.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first error")]

mod checkpoint {
    mod damage;
    mod killed;
    mod other_run;
    mod resume;
    mod serial;
    mod systems;
}
