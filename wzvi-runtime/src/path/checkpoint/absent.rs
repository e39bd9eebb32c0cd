//! Without the feature `serde` no run keeps anything: what the loop asks for is answered at compile time.

use crate::algebra::carry::Carry;
use crate::error::FileError;
use crate::path::Error;
use crate::path::retry::Retry;
use crate::path::section::Sections;
use crate::path::simulate::Run;
use crate::path::span::Grid;
use crate::path::step::Stepper;
use crate::scheme::system::Discretized;

/// What a run was told to keep: nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Keeping(());

/// Keeps nothing.
#[derive(Debug)]
pub(crate) struct Keeper;

impl Keeping {
    pub(crate) fn is_set(&self) -> bool {
        false
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn open<H: Discretized<E>, E, C: Carry<f64>, N>(
        self,
        _stepper: &mut Stepper<'_, H, E, C>,
        _run: &mut Run<'_, '_, '_, H::Vector>,
        _noise: Option<&N>,
        _extent: (&Grid, Retry, &Sections<'_, H::Vector>),
    ) -> Result<Keeper, Error> {
        Ok(Keeper)
    }
}

impl Keeper {
    /// Every run starts at its start.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn first(&self) -> u64 {
        0
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn keeps(&self) -> bool {
        false
    }

    /// No node is looked at.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn next(&self) -> u64 {
        u64::MAX
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn is_due(&mut self, _node: u64) -> bool {
        false
    }

    pub(crate) fn unsaved(&self) -> Option<FileError> {
        None
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn save<H: Discretized<E>, E, C: Carry<f64>>(
        &mut self,
        _stepper: &mut Stepper<'_, H, E, C>,
        _run: &mut Run<'_, '_, '_, H::Vector>,
        _node: u64,
    ) -> Result<(), Error> {
        Ok(())
    }
}
