//! Reports: the fit on curves with known slopes, the estimators against closed forms, the files and the page.

#![cfg(feature = "report")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

mod report {
    mod estimators;
    mod files;
    mod fit;
    mod page;
    mod thermostats;
}
