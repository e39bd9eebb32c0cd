//! Checkpoints: a run that is stopped at any moment goes on bit for bit, and no file is misread.

mod damage;
mod killed;
mod other_run;
mod resume;
mod serial;
mod systems;
