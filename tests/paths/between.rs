//! Between the nodes: dense output, recorded times, ends and sections.

mod dense;
mod ensembles;
mod kept;
mod sections;
mod states;
mod systems;
mod times;
