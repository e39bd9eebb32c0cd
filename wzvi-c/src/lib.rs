//! Systems of wzvi as a library for C and for every language that calls C: `wzvi.h` is its header.
//!
//! A crate of the type `cdylib` or `staticlib` lists systems whose attribute has `export = []`:
//!
//! ```
//! use wzvi::prelude::*;
//!
//! #[hamiltonian(drift = |q, p| 0.5 * p * p - g * q.cos(), embedding = [Verlet, Midpoint], export = [])]
//! pub struct Pendulum {
//!     /// Acceleration of gravity.
//!     pub g: f64,
//! }
//!
//! wzvi_c::export!(Pendulum);
//! ```
//!
//! The library then has one symbol, `wzvi_table`, which is a table of functions. A run is a task: settings by
//! name go in, arrays by name come out. Every setting and every array has a name, so that new ones do not
//! change the table.
//!
//! | module | contents |
//! |---|---|
//! | [`settings`] | settings by name |
//! | [`quantities`] | starts, observables and sections by name |
//! | [`noise`] | the noise that settings name |
//! | [`path`], [`ensemble`], [`chaos`] | the kinds of runs, generic over system and scheme |
//! | [`results`] | arrays by name |
//! | [`library`] | systems and schemes by name |
//! | [`describe`] | the description of a library, as JSON |
//! | [`table`] | the functions for C, with all of the `unsafe` |

#[cfg(feature = "chaos")]
pub mod chaos;
pub mod describe;
#[cfg(feature = "ensemble")]
pub mod ensemble;
pub mod error;
pub mod library;
pub mod noise;
pub mod path;
pub mod quantities;
pub mod results;
pub mod settings;
pub mod table;

pub use wzvi;

/// Defines the symbol `wzvi_table` of a library with these systems: `wzvi_c::export!(Kubo, Pendulum);`. A
/// program that links several libraries gives each a symbol of its own: `export! { as kubo_table; Kubo }`.
#[macro_export]
macro_rules! export {
    (as $symbol:ident; $($system:ty),+ $(,)?) => {
        #[doc = "The systems of this library, for C: see `wzvi.h`."]
        #[unsafe(no_mangle)]
        pub extern "C" fn $symbol() -> &'static $crate::table::Table {
            static CONTENTS: $crate::table::Contents = $crate::table::Contents::new(|| {
                ::std::vec![$($crate::library::System::of::<$system>()),+]
            });
            static TABLE: $crate::table::Table = $crate::table::Table::of(&CONTENTS);
            &TABLE
        }
    };
    ($($system:ty),+ $(,)?) => {
        $crate::export! { as wzvi_table; $($system),+ }
    };
}
