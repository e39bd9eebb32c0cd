//! Reports: the fit on curves with known slopes, the estimators against closed forms, the files and the page.

mod estimators;
mod files;
mod fit;
mod page;
mod thermostats;
