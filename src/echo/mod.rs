//! Contacts to samples.

pub mod reference;
