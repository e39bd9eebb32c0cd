//! Checkpoints of ensembles: a run that is stopped at any moment goes on bit for bit, and no file is misread.

mod damage;
mod killed;
mod levels;
mod other_run;
mod resume;
