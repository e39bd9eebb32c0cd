//! The user's declaration: the struct, the attribute and the phase space, checked as far as possible before
//! any Hamiltonian is read.

mod attribute;
mod attributes;
mod embeddings;
mod groups;
mod library;
mod nesting;
mod phase_space;
mod points;
mod rotations;
mod system;

pub(crate) use attribute::{
    Declaration, DeclaredClock, DeclaredFriction, DeclaredValue, Hamiltonian, read_attribute,
};
pub(crate) use attributes::{MacroKind, check as check_attributes};
pub(crate) use groups::peeled;
pub(crate) use library::{Library, SharedFunction};
pub(crate) use nesting::check as check_nesting;
pub(crate) use phase_space::{
    Labels, Length, PhaseSpace, Shape, is_usual_time, name_of_time, read_phase_space,
};
pub(crate) use system::{Container, Field, FieldKind, is_integer_type, read_struct};
